#include "dynamics/tangent_marks.h"

#include <algorithm>

#include "compile/find_scales.h"
#include "forces/sticks.h"

namespace mimbre {
namespace {

/// Changes that ask for a new matrix, of the mean mass and of what the lighter body resists motion with.
constexpr double share_of_mean = 0.02, share_of_body = 0.5;

bool measures_angle(const ElementData& e) {
  switch (e.measure) {
    case Measure::coordinate:
      return is_angle(e.joint, e.local);
    case Measure::axis:
    case Measure::sum:
      return e.about;
    default:
      return false;
  }
}

}  // namespace

TangentMarks::TangentMarks(const Compiled& m)
    : ancf_(m.elements.size()),
      sticks_(mimbre::sticks(m)),
      values_(ancf_ + ancf::all_marks(m)),
      small_(ancf_ + m.bodies.size()) {
  const BodyResistances resistances(m);
  const double mass = m.mass_scale, inertia = mass * m.length_scale * m.length_scale;
  const auto small = [&](const BodyResistance& least, bool angle) {
    return angle ? std::min(share_of_mean * inertia, share_of_body * least.inertia)
                 : std::min(share_of_mean * mass, share_of_body * least.mass);
  };
  const auto body_of = [&](int frame) { return frame < 0 ? -1 : m.frames[frame].body; };
  for (std::size_t k = 0; k < m.elements.size(); ++k) {
    const ElementData& e = m.elements[k];
    small_[k] = small(resistances.least(body_of(e.frame_a), body_of(e.frame_b)), measures_angle(e));
  }
  for (const ElementData& e : m.elements)
    if (e.measure == Measure::sum)
      for (const Leg& leg : e.legs)
        small_[static_cast<std::size_t>(&e - m.elements.begin())] =
            std::min(small_[static_cast<std::size_t>(&e - m.elements.begin())],
                     small_[static_cast<std::size_t>(leg.element)]);
  for (const SwarmData& swarm : m.swarms) {
    BodyResistance least;
    for (const SwarmSphere& sphere : swarm.spheres) {
      const BodyResistance& of = resistances.of(body_of(sphere.frame));
      least = {std::min(least.mass, of.mass), std::min(least.inertia, of.inertia)};
    }
    for (int k = swarm.first; k < swarm.last; ++k) small_[static_cast<std::size_t>(k)] = small(least, false);
  }
  for (std::size_t k = 0; k < m.bodies.size(); ++k)
    small_[ancf_ + k] = small(resistances.of(static_cast<int>(k)), false);
}

}  // namespace mimbre
