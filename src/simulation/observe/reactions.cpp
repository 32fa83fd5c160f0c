#include "simulation/observe/reactions.h"

#include <algorithm>
#include <cmath>

namespace mimbre {
namespace {
constexpr double penalty = 1e6;  // as for the accelerations at the start
constexpr int rounds = 6;
}  // namespace

Reactions::Reactions(const System& system)
    : residual_(system.velocities()), change_(system.velocities()), jacobian_change_(system.equations()) {}

void Reactions::choose_smallest(const Compiled& model, bool always) {
  always_ = always;
  smallest_ = std::make_unique<SmallestReactions>(model);
}

void Reactions::evaluate(relative::RelativeSystem& system, const State& s) {
  system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, residual_.data());
}

void Reactions::reduce(relative::RelativeSystem& system, State& s) {
  if (smallest_ && smallest_->find(system, s, s.multipliers)) evaluate(system, s);
}

void Reactions::limit(relative::RelativeSystem& system, State& s, double step) {
  if (!smallest_) return;
  const double strain = step * system.scales().of_coordinates(s.v.data());
  const auto found = smallest_->limit(system, s, strain, s.multipliers);
  if (!found) return;
  if (!unresolved_) unresolved_ = found;
  evaluate(system, s);
}

void Reactions::begin(relative::RelativeSystem& system, State& s) {
  s.multipliers.setZero();
  evaluate(system, s);
}

bool Reactions::factor(relative::RelativeSystem& system, const State& s) {
  return system.factor(s.q.data(), {0, 0, penalty}).ok();
}

/// Augmented Lagrangian: (M + α ΦqᵀΦq) x = −(r + Φqᵀ λ), λ ← λ + α Φq x. What remains of r is what the
/// constraints cannot carry: the error of the accelerations.
void Reactions::solve(relative::RelativeSystem& system, State& s) {
  double largest = 0, correction = 0;
  for (int round = 0; round < rounds; ++round) {
    change_ = -residual_;
    system.solve(change_.data());
    system.jacobian_times(change_.data(), jacobian_change_.data());
    correction = 0;
    for (int k = 0; k < system.equations(); ++k) {
      const double d = penalty * system.penalty()[k] * jacobian_change_[k];
      s.multipliers[k] += d;
      jacobian_change_[k] = d;
      correction = std::max(correction, std::abs(d));
    }
    system.add_jacobian_transposed(jacobian_change_.data(), 1, residual_.data());
    largest = std::max(largest, correction);
    if (!(correction > 1e-6 * largest)) break;
  }
  settled_ = correction <= 1e-3 * largest;
}

bool Reactions::find(relative::RelativeSystem& system, State& s) {
  begin(system, s);
  if (system.equations() == 0) return true;
  if (!factor(system, s)) return false;
  solve(system, s);
  evaluate(system, s);
  if (!determined()) reduce(system, s);
  return true;
}

}  // namespace mimbre
