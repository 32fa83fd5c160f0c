#pragma once
#include <array>
#include <cstddef>

#include "mimbre/method.h"

/// What the choices of spec::Simulation are called in model files and on the command line, in the order of
/// its enumerations.
namespace mimbre::method_names {

inline constexpr std::array formulations{"relative", "natural"};
inline constexpr std::array inertias{"integrals", "projection", "projection_translations"};
inline constexpr std::array formalisms{"index3",       "index1",           "baumgarte",
                                       "penalty",      "index1_augmented", "independent",
                                       "global_modes", "transfer_matrices"};
inline constexpr std::array integrators{"generalized_alpha", "newmark", "hht", "conserve", "rk4",
                                        "dopri853",          "radau",   "auto"};

}  // namespace mimbre::method_names

namespace mimbre {

/// The least spectral radius of HHT (α = −1/3): αf beyond 1/3 costs stability.
inline constexpr double least_hht_rho = 0.5;

/// Whether an integrator needs accelerations only, no tangents.
inline bool is_explicit(spec::Simulation::Integrator i) {
  return i == spec::Simulation::Integrator::rk4 || i == spec::Simulation::Integrator::dopri853;
}

/// Whether an integrator is of Runge–Kutta: of an order above 2, with constraints by accelerations and
/// projections instead of a formalism.
inline bool is_runge_kutta(spec::Simulation::Integrator i) {
  return is_explicit(i) || i == spec::Simulation::Integrator::radau ||
         i == spec::Simulation::Integrator::automatic;
}

/// Whether an integrator estimates its error, and can keep an accuracy.
inline bool estimates_error(spec::Simulation::Integrator i) {
  return is_runge_kutta(i) && i != spec::Simulation::Integrator::rk4;
}

inline const char* name_of(spec::Simulation::Formulation f) {
  return method_names::formulations[static_cast<std::size_t>(f)];
}
inline const char* name_of(spec::Simulation::Inertia i) {
  return method_names::inertias[static_cast<std::size_t>(i)];
}
inline const char* name_of(spec::Simulation::Formalism f) {
  return method_names::formalisms[static_cast<std::size_t>(f)];
}
inline const char* name_of(spec::Simulation::Integrator i) {
  return method_names::integrators[static_cast<std::size_t>(i)];
}

}  // namespace mimbre
