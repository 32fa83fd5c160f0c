#include "simulation/start_branches.h"

#include <fmt/format.h>

#include <cmath>

namespace mimbre {
namespace {

constexpr double unsolved = 1e-3;   ///< of Φ̇q v, that the accelerations may leave
constexpr double round_off = 1e-9;  ///< of the squared velocities, which Φ̇q v consists of

struct Largest {
  double value = 0;
  const LoopData* loop = nullptr;
};

/// Of Φ̈ over the cut joints, by the mechanism's own units.
Largest largest(const Compiled& m, const Scales& scales, const double* phi_ddot) {
  Largest found;
  for (const LoopData& l : m.loops)
    for (int k = l.first_equation; k < l.first_equation + l.count; ++k)
      if (const double value = std::abs(phi_ddot[k]) / scales.equations[static_cast<std::size_t>(k)];
          value > found.value)
        found = {value, &l};
  return found;
}

}  // namespace

std::string explain_branches(relative::RelativeSystem& system, const State& s) {
  const Compiled& m = system.model();
  if (m.loops.empty()) return {};
  const Scales& scales = system.scales();
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(s.a.size());
  system.kinematics(s.time, s.q.data(), s.v.data(), rest.data());
  const double asked = largest(m, scales, system.phi_ddot()).value;
  system.kinematics(s.time, s.q.data(), s.v.data(), s.a.data());
  const Largest left = largest(m, scales, system.phi_ddot());
  const double rate = scales.of_coordinates(s.v.data());
  if (!left.loop || !(left.value > unsolved * asked) || !(asked > round_off * rate * rate)) return {};
  return fmt::format(
      "at the start the mechanism can go several ways (a singular position), and its initial velocities are "
      "those of none: the first step is a blow at joint '{}'; give the velocity of one joint more, as the "
      "motion has it, or start beside this position",
      m.spec().joints[static_cast<std::size_t>(left.loop->joint_spec)].name);
}

}  // namespace mimbre
