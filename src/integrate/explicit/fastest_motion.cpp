#include "integrate/explicit/fastest_motion.h"

#include <algorithm>
#include <cmath>

#include "integrate/explicit/accelerations.h"
#include "integrate/explicit/runge_kutta.h"
#include "mimbre/method_names.h"

namespace mimbre {

/// Power iterations with M⁻¹K and M⁻¹C, which are differences of accelerations.
double fastest_motion(System& system, const State& state) {
  constexpr double difference = 1e-6;
  constexpr int rounds = 30;
  const int n = system.velocities();
  const Eigen::Map<const Eigen::VectorXd> scale(system.scales().coordinates.data(), n);
  Accelerations accelerations(system, 1e-8);
  Eigen::VectorXd at_rest(n), a(n), x(n), q(state.q.size()), v(n), multipliers = state.multipliers;
  StepStatus status;
  system.begin_step(state.q.data());
  if (!accelerations.find(state.time, state.q, state.v, at_rest, multipliers, status)) return 0;
  const auto largest_factor = [&](const auto& move) {
    double factor = 0;
    for (int k = 0; k < n; ++k) x[k] = (k % 2 == 0 ? 1 : -1) * scale[k] / (1 + k % 7);
    for (int round = 0; round < rounds; ++round) {
      const double length = x.cwiseQuotient(scale).norm();
      if (!(length > 0) || !std::isfinite(length)) return 0.0;
      x *= difference / length;
      q = state.q;
      v = state.v;
      move();
      multipliers = state.multipliers;
      if (!accelerations.find(state.time, q, v, a, multipliers, status)) return 0.0;
      x = at_rest - a;
      factor = x.cwiseQuotient(scale).norm() / difference;
    }
    return factor;
  };
  const double square = largest_factor([&] { system.retract(state.q.data(), x.data(), q.data()); });
  const double damping = largest_factor([&] { v += x; });
  return std::max(std::sqrt(square), damping);
}

double stable_reach(spec::Simulation::Integrator rule) {
  return rule == spec::Simulation::Integrator::dopri853 ? dopri853.stable : rk4.stable;
}

}  // namespace mimbre
