#pragma once
#include "integrate/step_motion.h"

/// σ = Φ̈ + 2ζω Φ̇ + ω² Φ (Baumgarte 1972), what several formalisms impose instead of Φ = 0.
namespace mimbre {

/// σ of the system's last evaluation.
inline void stabilised(const System& system, double damping, double frequency, double* sigma) {
  const double *phi = system.phi(), *phi_dot = system.phi_dot(), *phi_ddot = system.phi_ddot();
  for (int k = 0; k < system.equations(); ++k)
    sigma[k] = phi_ddot[k] + 2 * damping * frequency * phi_dot[k] + frequency * frequency * phi[k];
}

/// w in ∂σ/∂x = w Φz (the changes of Φz itself left out).
inline double stabilised_rate(const StepMotion& motion, double damping, double frequency) {
  return 1 / motion.scale + 2 * damping * frequency * motion.rate + frequency * frequency;
}

}  // namespace mimbre
