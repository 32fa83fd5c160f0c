#include "simulation/start/start_branches.h"

#include <fmt/format.h>

#include <cmath>

#include "simulation/describe/names.h"

namespace mimbre {
namespace {

constexpr double unsolved = 1e-3;   ///< of Φ̇q v, that the accelerations may leave
constexpr double round_off = 1e-9;  ///< of the squared velocities, which Φ̇q v consists of

struct Largest {
  double value = 0;
  int equation = -1;
};

/// Of Φ̈ over cut joints and constraints, by the mechanism's own units.
Largest largest(const Compiled& m, const Scales& scales, const double* phi_ddot) {
  Largest found;
  for_rows(m, [&](const EquationRows& rows) {
    for (int k = rows.first_equation; k < rows.first_equation + rows.count; ++k)
      if (const double value = std::abs(phi_ddot[k]) / scales.equations[static_cast<std::size_t>(k)];
          value > found.value)
        found = {value, k};
  });
  return found;
}

}  // namespace

std::string explain_branches(relative::RelativeSystem& system, const State& s) {
  const Compiled& m = system.model();
  if (m.loops.empty() && m.constraints.empty()) return {};
  const Scales& scales = system.scales();
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(s.a.size());
  system.kinematics(s.time, s.q.data(), s.v.data(), rest.data());
  const double asked = largest(m, scales, system.phi_ddot()).value;
  system.kinematics(s.time, s.q.data(), s.v.data(), s.a.data());
  const Largest left = largest(m, scales, system.phi_ddot());
  const double rate = scales.of_coordinates(s.v.data());
  if (left.equation < 0 || !(left.value > unsolved * asked) || !(asked > round_off * rate * rate)) return {};
  return fmt::format(
      "at the start the mechanism can go several ways (a singular position), and its initial velocities are "
      "those of none: the first step is an impact at {}; give the velocity of one joint more, as the "
      "motion has it, or start beside this position",
      equation_name(m, nullptr, left.equation));
}

}  // namespace mimbre
