#include "simulation/contact_watch.h"

#include <algorithm>
#include <cmath>

#include "forces/contact.h"
#include "forces/surfaces/table.h"

namespace mimbre {
namespace {

namespace states = contact_states;

/// A blow moves its body, in a step, by at most this share of the depth that it reaches; where it begins or
/// ends, whose instants are not known better than to a step, by the smaller one.
constexpr double share_of_depth = 0.1, share_at_ends = 0.02;

/// How deep a blow of that speed goes: ∫ k e/n (d/e)ⁿ dd = ½ m v².
double reach(const double* p, double mass, double speed) {
  namespace law = forces::contact;
  const double k = p[law::stiffness], n = p[law::exponent], e = p[law::depth];
  return e * std::pow(0.5 * n * (n + 1) * mass * speed * speed / (k * e * e), 1 / (n + 1));
}

/// Whether a sphere went through the solid in between, or ends in it and would be pushed out on another side
/// than that on which it came. Along the straight path it is free as far as the distance reaches.
bool went_through(const SurfaceData& surface, double radius, const Vec3d& from, const Vec3d& to, double gap,
                  bool touches) {
  const Vec3d path = to - from;
  const double length = path.norm();
  if (length <= gap) return false;
  constexpr int most = 64;
  const double least = length / most;
  for (double at = gap; at < length;) {
    const Touch<double> here = surfaces::touch(surface, Vec3d(from + at / length * path));
    const double free = here.distance - radius;
    if (free < -1e-3 * radius) return !touches || here.normal.dot(surfaces::touch(surface, to).normal) < 0.5;
    at += std::max(free, least);
  }
  return false;
}

}  // namespace

double quiet_speed(const Compiled& m, double whole) {
  return std::max(forces::blow::slowest, 0.5 * whole * m.gravity.norm());
}

bool contact_followed(const Compiled& m, const relative::Workspace<double>& w, const double* before, double h,
                      double quiet) {
  for (int k = m.first_of_contact.front(); k < m.first_of_contact.back(); ++k) {
    const ElementData& e = m.elements[k];
    if (!m.swarms[e.spec].spheres.empty()) continue;
    const ElementState<const double> s = element_state(e, w.elements.data());
    const double *start = before + e.states, *p = m.numbers.data() + e.numbers;
    const bool touched = start[states::gap] < 0, touches = s.x[0] < 0;
    if (!touched &&
        went_through(m.surfaces[e.surface], e.radius,
                     Vec3d(start[states::place], start[states::place + 1], start[states::place + 2]),
                     Vec3d(s.states[states::place], s.states[states::place + 1], s.states[states::place + 2]),
                     start[states::gap], touches))
      return false;
    if (!touched && !touches) continue;
    const double fastest = std::max(std::abs(start[states::speed]), std::abs(s.v[0]));
    if (fastest <= quiet) continue;
    const double speed = touched ? std::max(fastest, start[states::blow]) : std::abs(start[states::speed]);
    const double share = touched == touches ? share_of_depth : share_at_ends;
    if (speed * h > share * reach(p, e.struck_mass, speed)) return false;
  }
  return true;
}

}  // namespace mimbre
