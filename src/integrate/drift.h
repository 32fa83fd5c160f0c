#pragma once
#include "integrate/step_motion.h"
#include "integrate/vectors.h"

namespace mimbre {

/// Violations of the system's last evaluation.
inline void find_violations(const System& system, Violations& out) {
  const Scales& scales = system.scales();
  scales.of_kinds(system.phi(), out.position_violation, out.angle_violation);
  scales.of_kinds(system.phi_dot(), out.velocity_violation, out.angular_velocity_violation);
}

/// Violations of the system's last evaluation, and whether they can be accepted: |Φ| within `drift_limit` in
/// the mechanism's own units (Scales). Where not, the worst equation is named.
inline StepCode find_drift(const System& system, double drift_limit, StepStatus& status) {
  find_violations(system, status);
  const std::vector<double>& scale = system.scales().equations;
  double worst = drift_limit;
  int equation = -1;
  for (int k = 0; k < system.equations(); ++k) {
    const double violation = std::abs(system.phi()[k]);
    if (violation <= worst * scale[static_cast<std::size_t>(k)]) continue;
    equation = k;
    if (std::isnan(violation)) break;
    worst = violation / scale[static_cast<std::size_t>(k)];
  }
  if (equation < 0) return StepCode::ok;
  status.equation = equation;
  status.equation_violation = std::abs(system.phi()[equation]);
  return StepCode::drifted;
}

/// The same at the end of a step, whose motion has to be finite.
inline StepCode check_end(const System& system, const StepMotion& motion, double drift_limit,
                          StepStatus& status) {
  const int n = system.velocities();
  for (const Eigen::VectorXd* x : {&motion.x, &motion.v, &motion.a})
    if (const int bad = find_not_finite(x->data(), n); bad >= 0) {
      status.coordinate = bad;
      return StepCode::not_finite;
    }
  return find_drift(system, drift_limit, status);
}

}  // namespace mimbre
