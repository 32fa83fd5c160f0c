#include "compile/struck_mass.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "math/elementary.h"

namespace mimbre {
namespace {

/// Mean over the directions of the speed that an impulse there causes along itself, 1/kg. A mode that is
/// stiffer there than the contact, `stiffness`, hardly moves in an impact.
double lightness(const Compiled& m, const FrameData& frame, double stiffness) {
  if (frame.body < 0) return 0;
  const BodyData& b = m.bodies[frame.body];
  if (!(b.mass > 0)) return 1 / m.mass_scale;
  double sum = 1 / b.mass;
  const Vec3d centre = b.first_moment / b.mass, arm = frame.position - centre;
  const Mat3d about_centre =
      b.inertia - b.mass * (centre.squaredNorm() * Mat3d::Identity() - centre * centre.transpose());
  Mat3d turning = Mat3d::Zero();
  bool invertible = false;
  about_centre.computeInverseWithCheck(turning, invertible, 1e-9 * mimbre::pow(about_centre.trace(), 3));
  if (invertible) {
    Mat3d cross;
    cross << 0, -arm[2], arm[1], arm[2], 0, -arm[0], -arm[1], arm[0], 0;
    sum += (cross.transpose() * turning * cross).trace() / 3;
  }
  if (frame.flexible < 0) return sum;
  const FlexibleData& f = m.flexible[frame.flexible];
  for (int k = 0; k < b.modes; ++k) {
    const double square = frame.X.matrix().col(k).squaredNorm() / 3, soft = stiffness * square;
    if (square > 0 && f.mass(k, k) > 0) sum += square / f.mass(k, k) * soft / (soft + f.stiffness(k, k));
  }
  return sum;
}

}  // namespace

double struck_mass(const Compiled& m, const ElementData& e) {
  const double stiffness = m.numbers[e.numbers];
  return 1 / (lightness(m, m.frames[e.frame_a], stiffness) + lightness(m, m.frames[e.frame_b], stiffness));
}

double struck_mass(const Compiled& m, const SwarmData& swarm) {
  if (swarm.first == swarm.last) return std::numeric_limits<double>::infinity();
  const double stiffness = m.numbers[m.elements[swarm.first].numbers];
  // Spheres of one body are no pair: the lightest of all, and the lightest of the other bodies.
  double first = -1, second = -1;
  int body = -1;
  for (const SwarmSphere& sphere : swarm.spheres) {
    const FrameData& frame = m.frames[sphere.frame];
    const double light = lightness(m, frame, stiffness);
    if (first < 0 || frame.body == body) {
      first = std::max(first, light);
      body = frame.body;
    } else if (light > first) {
      second = first;
      first = light;
      body = frame.body;
    } else {
      second = std::max(second, light);
    }
  }
  return second < 0 ? std::numeric_limits<double>::infinity() : 1 / (first + second);
}

}  // namespace mimbre
