#pragma once
#include <algorithm>

#include "integrate/stepper.h"
#include "mimbre/method_names.h"

namespace mimbre {

/// The spectral radius of `conserve`: enough that vibrations faster than the step do not take up energy,
/// while of those with twenty steps a period next to nothing is damped.
constexpr double conserving_rho = 0.6;

/// Coefficients of the rules  x = h ż₀ + h² ((½ − β) w₀ + β w₁),  ż₁ = ż₀ + h ((1 − γ) w₀ + γ w₁),
/// (1 − αm) w₁ + αm w₀ = (1 − αf) z̈₁ + αf z̈₀.
struct RuleCoefficients {
  double alpha_m = 0, alpha_f = 0, beta = 0.25, gamma = 0.5;
};

inline RuleCoefficients rule_coefficients(const IntegratorOptions& options) {
  RuleCoefficients c;
  switch (options.rule) {
    case IntegratorOptions::Rule::rk4:
    case IntegratorOptions::Rule::dopri853:  // of ExplicitStepper
    case IntegratorOptions::Rule::radau:     // of RadauStepper
    case IntegratorOptions::Rule::automatic:
      return c;
    case IntegratorOptions::Rule::newmark:
      c.beta = (1 - options.xi) * (1 - options.xi) / 4;
      c.gamma = (1 - 2 * options.xi) / 2;
      return c;
    case IntegratorOptions::Rule::generalized_alpha:
    case IntegratorOptions::Rule::conserve: {
      const double rho = options.rule == IntegratorOptions::Rule::conserve ? conserving_rho : options.rho;
      c.alpha_m = (2 * rho - 1) / (rho + 1);
      c.alpha_f = rho / (rho + 1);
      break;
    }
    case IntegratorOptions::Rule::hht: {
      const double rho = std::clamp(options.rho, least_hht_rho, 1.0);
      c.alpha_f = (1 - rho) / (1 + rho);
      break;
    }
  }
  c.gamma = 0.5 + c.alpha_f - c.alpha_m;
  c.beta = 0.25 * (c.gamma + 0.5) * (c.gamma + 0.5);
  return c;
}

}  // namespace mimbre
