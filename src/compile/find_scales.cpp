#include "compile/find_scales.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "compile/struck_mass.h"

namespace mimbre {
namespace {

/// A lever that is this many times as long as the body is wide has no meaning for the size of the mechanism;
/// nor does a body that is this many times as large as half of the others.
constexpr double longest_lever = 1e3, largest_body = 1e2;

/// Of its radius of gyration: a body that is held nearer to its centre of mass than this is held there.
constexpr double at_centre = 0.1;

/// Distances below this share of the coordinates that they are the differences of are round-off.
constexpr double round_off = 1e3 * std::numeric_limits<double>::epsilon();

/// Of the length scale: a body without inertia that is held within this is a point.
constexpr double point = 1e-9;

Vec3d centre_of(const BodyData& b) {
  return b.mass > 0 ? Vec3d(b.first_moment / b.mass) : Vec3d(Vec3d::Zero());
}

/// ∫ |r − r_c|² dm, kg m²; 0 where it is round-off of where the body's frame lies.
double second_moment_about_centre(const BodyData& b) {
  if (!(b.mass > 0)) return 0;
  const double about_origin = b.second_moment.trace(), of_centre = b.mass * centre_of(b).squaredNorm();
  const double about_centre = about_origin - of_centre;
  return about_centre > round_off * about_origin ? about_centre : 0;
}

/// Rigid bodies that are one: they hold each other all over, wherever that is said to be.
bool is_part_of_parent(const Compiled& m, const BodyData& b) {
  return b.joint == spec::JointType::fixed && b.modes == 0 && (b.parent < 0 || m.bodies[b.parent].modes == 0);
}

/// Frames at which something holds or pushes a body by where it is: not those of loads, sensors, joints that
/// leave everything free or nothing, which may be anywhere.
std::vector<char> holding_frames(const Compiled& m) {
  std::vector<char> holds(m.frames.size(), 0);
  const auto mark = [&](int frame) {
    if (frame >= 0) holds[static_cast<std::size_t>(frame)] = 1;
  };
  for (const BodyData& b : m.bodies)
    if (joint_info(b.joint).equations > 0 && !is_part_of_parent(m, b))
      mark(b.inboard_frame), mark(b.outboard_frame);
  for (const LoopData& l : m.loops) mark(l.frame_a), mark(l.frame_b);
  for (const ConstraintData& c : m.constraints)
    for (const ConstraintTerm& t : c.terms)
      if (!c.of_coordinates) mark(t.frame_a), mark(t.frame_b);
  for (const ElementData& e : m.elements) {
    if (e.measure == Measure::none || e.measure == Measure::coordinate) continue;
    mark(e.frame_a), mark(e.frame_b);
  }
  for (const SwarmData& swarm : m.swarms)
    for (const SwarmSphere& sphere : swarm.spheres) mark(sphere.frame);
  return holds;
}

/// Of the arm from a body's centre of mass to the joint that carries it what counts: where a guide or a plane
/// is given along the directions in which the body slides is arbitrary. The place of a pin in its slot is
/// not.
Vec3d arm_of_own_joint(const FrameData& frame, spec::JointType type, Vec3d arm) {
  const JointInfo& joint = joint_info(type);
  if (type == spec::JointType::pin_slot) return arm;
  for (std::size_t k = 0; k < joint.moves.size(); ++k) {
    if (is_angle(type, static_cast<int>(k))) continue;
    const Vec3d along = frame.rotation.col(joint.moves[k] - 'x');
    arm -= along.dot(arm) * along;
  }
  return arm;
}

/// How far from its centre of mass a body is held, m, or where that is at its centre its radius of gyration;
/// 0: it is a point. Distances up to `same` are none.
double size_of(const Compiled& m, const BodyData& b, const std::vector<char>& holds, double same) {
  const Vec3d centre = centre_of(b);
  const double radius = b.mass > 0 ? std::sqrt(second_moment_about_centre(b) / b.mass) : 0;
  double size = 0;
  const auto look = [&](int f) {
    if (!holds[static_cast<std::size_t>(f)]) return;
    const Vec3d& place = m.frames[f].position;
    const Vec3d arm = place - centre;
    const double distance =
        (f == b.outboard_frame ? arm_of_own_joint(m.frames[f], b.joint, arm) : arm).norm();
    if (!(distance > same + round_off * (place.norm() + centre.norm()))) return;
    size = std::max(size, radius > 0 ? std::min(distance, longest_lever * radius) : distance);
  };
  for (int f = b.first_frame; f < b.last_frame; ++f) look(f);
  if (!is_part_of_parent(m, b)) look(b.outboard_frame);
  return size > at_centre * radius ? size : radius;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// The mean, of what is much larger than half of them no more than that.
double robust_mean(std::vector<double> values) {
  std::vector<double> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  const double most = largest_body * sorted[(sorted.size() - 1) / 2];
  for (double& value : values) value = std::min(value, most);
  return mean(values);
}

/// Of points: the lengths of what joins them, the sizes of what they touch, or how far they are from where
/// they are held.
double length_between_points(const Compiled& m) {
  std::vector<double> lengths;
  for (const ElementData& e : m.elements) {
    if ((e.measure == Measure::distance || e.measure == Measure::axis) && !e.about && e.reference > 0)
      lengths.push_back(e.reference);
    if (e.radius > 0) lengths.push_back(e.radius);
  }
  for (const SwarmData& swarm : m.swarms)
    for (const SwarmSphere& sphere : swarm.spheres) lengths.push_back(sphere.radius);
  if (!lengths.empty()) return robust_mean(lengths);
  for (const BodyData& b : m.bodies) {
    const Vec3d& place = m.spec().bodies[static_cast<std::size_t>(b.spec)].pose.position;
    for (int f = m.first_ground_frame; f < m.last_ground_frame; ++f)
      if (const double distance = (place - m.frames[f].position).norm(); distance > round_off * place.norm())
        lengths.push_back(distance);
  }
  return lengths.empty() ? 1 : robust_mean(lengths);
}

/// The body that a body is fixed to by joints without freedom, itself where there is none; -1: the ground.
std::vector<int> carriers(const Compiled& m) {
  std::vector<int> carrier;
  for (std::size_t k = 0; k < m.bodies.size(); ++k) {  // parents come before children
    const BodyData& b = m.bodies[k];
    carrier.push_back(b.joint_velocities > 0 ? static_cast<int>(k)
                      : b.parent < 0         ? -1
                                             : carrier[static_cast<std::size_t>(b.parent)]);
  }
  return carrier;
}

}  // namespace

BodyResistances::BodyResistances(const Compiled& m) : all_(m.bodies.size() + 1) {
  const std::vector<int> carrier = carriers(m);
  const std::vector<char> holds = holding_frames(m);
  std::vector<BodyResistance> sums(m.bodies.size(), {0, 0});
  for (std::size_t k = 0; k < m.bodies.size(); ++k) {
    if (carrier[k] < 0) continue;
    const BodyData& b = m.bodies[k];
    BodyResistance& sum = sums[static_cast<std::size_t>(carrier[k])];
    sum.mass += b.mass;
    const double inertia = second_moment_about_centre(b), size = size_of(m, b, holds, point * m.length_scale);
    sum.inertia += inertia > 0 ? inertia : b.mass * size * size;
  }
  const auto resistance = [&](int body) -> BodyResistance* {
    const int of = body < 0 ? -1 : carrier[static_cast<std::size_t>(body)];
    return of < 0 ? nullptr : &sums[static_cast<std::size_t>(of)];
  };
  // Bodies without mass, from those with mass outwards.
  const auto spread = [&](double BodyResistance::*what) {
    for (bool changed = true; changed;) {
      changed = false;
      std::vector<std::pair<BodyResistance*, double>> found;
      const auto look = [&](int body_a, int body_b) {
        BodyResistance *const a = resistance(body_a), *const b = resistance(body_b);
        if (!a || !b || (a->*what > 0) == (b->*what > 0)) return;
        found.push_back(a->*what > 0 ? std::pair(b, a->*what) : std::pair(a, b->*what));
      };
      for (std::size_t k = 0; k < m.bodies.size(); ++k) look(m.bodies[k].parent, static_cast<int>(k));
      for (const LoopData& l : m.loops) look(m.frames[l.frame_a].body, m.frames[l.frame_b].body);
      for (const auto& [of, value] : found) {
        double& kept = of->*what;
        kept = kept > 0 ? std::min(kept, value) : value;
        changed = true;
      }
    }
  };
  spread(&BodyResistance::mass);
  spread(&BodyResistance::inertia);
  for (std::size_t k = 0; k < m.bodies.size(); ++k)
    if (const BodyResistance* sum = resistance(static_cast<int>(k))) {
      if (sum->mass > 0) all_[k].mass = sum->mass;
      if (sum->inertia > 0) all_[k].inertia = sum->inertia;
    }
}

void find_scales(Compiled& m) {
  const std::vector<char> holds = holding_frames(m);
  std::vector<double> masses, lengths;
  for (const BodyData& b : m.bodies) {
    if (b.mass > 0) masses.push_back(b.mass);
    // Frames are differences of places in the assembled position.
    const Vec3d& place = m.spec().bodies[static_cast<std::size_t>(b.spec)].pose.position;
    if (const double size = size_of(m, b, holds, round_off * place.norm()); size > 0) lengths.push_back(size);
  }
  if (!masses.empty()) m.mass_scale = mean(masses);
  m.length_scale = lengths.empty() ? length_between_points(m) : robust_mean(lengths);
  for (ElementData& e : m.elements)
    if (e.measure == Measure::contact && !e.pooled) e.struck_mass = struck_mass(m, e);
  for (const SwarmData& swarm : m.swarms) {
    const double mass = struck_mass(m, swarm);
    for (int k = swarm.first; k < swarm.last; ++k) m.elements[k].struck_mass = mass;
  }

  const BodyResistances resistances(m);
  const double mass = m.mass_scale, angle = m.length_scale * m.length_scale;
  const auto scale = [&](bool is_length, const BodyResistance& least) {
    return (is_length ? penalty_scale(mass, least.mass) : penalty_scale(mass * angle, least.inertia)) / mass;
  };
  for (LoopData& l : m.loops) {
    const BodyResistance least = resistances.least(m.frames[l.frame_a].body, m.frames[l.frame_b].body);
    for (int r = 0; r < l.count; ++r)
      l.scale[r] = scale(l.closure[r].kind == LoopClosure::Kind::distance, least);
  }
  for (ConstraintData& c : m.constraints) {
    BodyResistance least;
    for (const ConstraintTerm& t : c.terms) {
      const BodyResistance of = resistances.least(m.frames[t.frame_a].body, m.frames[t.frame_b].body);
      least = {std::min(least.mass, of.mass), std::min(least.inertia, of.inertia)};
    }
    for (int r = 0; r < c.count; ++r) c.scale[r] = scale(c.is_length(r), least);
  }
  for (DriveData& d : m.drives)
    d.scale =
        scale(!is_angle(m.bodies[d.body].joint, d.local), resistances.least(d.body, m.bodies[d.body].parent));
}

}  // namespace mimbre
