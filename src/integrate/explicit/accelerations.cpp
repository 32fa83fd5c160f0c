#include "integrate/explicit/accelerations.h"

#include <algorithm>

#include "integrate/vectors.h"

namespace mimbre {
namespace {

/// κ. A correction makes what is left of the accelerations smaller by about that factor, so that corrections
/// of this share of the accelerations at play are the last ones; what does not settle to `no_solution` has
/// none. Singular positions take most rounds.
constexpr double inertia_penalty = 1e6, last_correction = 1e-8, no_solution = 1e-6;
constexpr int most_rounds = 60;

}  // namespace

Accelerations::Accelerations(System& system, double tolerance)
    : system_(system),
      tolerance_(std::min(tolerance, last_correction)),
      iterates_(system.equations() > 0 || system.has_loads_of_inertia()),
      r_(system.velocities()),
      g_(system.equations()) {}

bool Accelerations::find(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& v, Eigen::VectorXd& a,
                         Eigen::VectorXd& multipliers, StepStatus& status) {
  const int n = system_.velocities(), m = system_.equations();
  const Scales& scales = system_.scales();
  const auto fail = [&](StepCode code, int coordinate) {
    status.code = code;
    status.coordinate = coordinate;
    return false;
  };
  a.setZero();
  double change = 1;
  for (int round = 0; round < most_rounds; ++round) {
    system_.residual(t, q.data(), v.data(), a.data(), multipliers.data(), 0, r_.data());
    if (const int bad = find_not_finite(r_.data(), n); bad >= 0) return fail(StepCode::not_finite, bad);
    ++status.iterations;
    if (round == 0) {
      ++status.factorisations;
      const linalg::FactorStatus factor = system_.factor_inertia(q.data(), inertia_penalty);
      if (!factor.ok()) return fail(StepCode::singular, factor.unknown);
    }
    for (int k = 0; k < m; ++k) g_[k] = inertia_penalty * system_.penalty()[k] * system_.phi_ddot()[k];
    multipliers += g_;
    if (m > 0) system_.add_jacobian_transposed(g_.data(), 1, r_.data());
    r_ = -r_;
    system_.solve(r_.data());
    a += r_;
    if (const int bad = find_not_finite(a.data(), n); bad >= 0) return fail(StepCode::not_finite, bad);
    if (!iterates_) return true;
    if (m > 0) system_.jacobian_times(r_.data(), g_.data());
    for (int k = 0; k < m; ++k) multipliers[k] += inertia_penalty * system_.penalty()[k] * g_[k];
    const double play = scales.accelerations(a.data());
    status.correction = scales.of_coordinates(r_.data(), &status.coordinate);
    change = play > 0 ? status.correction / play : 0;
    if (change <= tolerance_) return true;
  }
  return change <= no_solution || fail(StepCode::not_converged, status.coordinate);
}

void Accelerations::take_back(const double* violation, Eigen::VectorXd& d) {
  for (Eigen::Index k = 0; k < g_.size(); ++k) g_[k] = -inertia_penalty * system_.penalty()[k] * violation[k];
  d.setZero();
  system_.add_jacobian_transposed(g_.data(), 1, d.data());
  system_.solve(d.data());
}

}  // namespace mimbre
