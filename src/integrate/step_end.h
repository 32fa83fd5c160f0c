#pragma once
#include "integrate/step_motion.h"
#include "integrate/vectors.h"

namespace mimbre {

/// Violations at the end of a step, from the system's last evaluation, and whether the end can be accepted:
/// |Φ| within `drift_limit` in the mechanism's own units (Scales).
inline StepCode check_end(const System& system, const StepMotion& motion, double drift_limit,
                          StepStatus& status) {
  const int n = system.velocities(), m = system.equations();
  for (const Eigen::VectorXd* x : {&motion.x, &motion.v, &motion.a})
    if (const int bad = find_not_finite(x->data(), n); bad >= 0) {
      status.coordinate = bad;
      return StepCode::not_finite;
    }
  status.position_violation = largest(system.phi(), m);
  status.velocity_violation = largest(system.phi_dot(), m);
  for (int k = 0; k < m; ++k)
    if (!(std::abs(system.phi()[k]) <= drift_limit * system.scales().equations[k])) {
      status.equation = k;
      return StepCode::drifted;
    }
  return StepCode::ok;
}

}  // namespace mimbre
