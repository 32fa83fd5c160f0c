#include "integrate/driven.h"

#include <algorithm>

namespace mimbre {

DrivenCoordinates::DrivenCoordinates(System& system) : system_(system) {
  if (!any()) return;
  const int n = system.velocities();
  none_.setZero(std::max(n, system.equations()));
  for (Eigen::VectorXd* x : {&change_, &without_, &r_, &x_}) x->setZero(n);
}

void DrivenCoordinates::solve(const Eigen::VectorXd& r) {
  x_.setZero();
  for (const int k : system_.driven_coordinates()) x_[k] = -r[k];
  system_.solve(x_.data());
}

void DrivenCoordinates::accelerate(double time, const double* q, const double* v, const double* multipliers,
                                   double* a) {
  if (!any()) return;
  for (const int k : system_.driven_coordinates()) a[k] = 0;
  system_.residual(time, q, v, a, multipliers, 0, r_.data());
  solve(r_);
  for (const int k : system_.driven_coordinates()) a[k] = x_[k];
}

void DrivenCoordinates::follow(double time, const double* q, const Eigen::VectorXd& change,
                               const double* impulse, Eigen::VectorXd& target, bool again) {
  if (!any()) return;
  // Residuals are linear in accelerations and multipliers.
  change_ = change;
  for (const int k : system_.driven_coordinates()) change_[k] = 0;
  if (!again) system_.residual(time, q, none_.data(), none_.data(), none_.data(), 0, without_.data());
  system_.residual(time, q, none_.data(), change_.data(), impulse, 0, r_.data());
  r_ -= without_;
  solve(r_);
  for (const int k : system_.driven_coordinates()) target[k] += x_[k];
}

}  // namespace mimbre
