#include "integrate/dense.h"
#include "math/once/decompositions.h"

#include <algorithm>
#include <cmath>

namespace mimbre {

DenseSystem::DenseSystem(System& system)
    : system_(system),
      partition_(system.velocities(), system.equations()),
      ldlt_(Eigen::MatrixXd::Identity(system.velocities(), system.velocities())) {
  const int n = system.velocities(), m = system.equations();
  f_.setZero(n, n);
  jacobian_.setZero(m, n);
  R_.setZero(n, n);
  fR_.setZero(n, n);
  reduced_.setZero(n, n);
  row_weight_.resize(m);
  unit_.setZero(m);
  for (int k = 0; k < m; ++k) row_weight_[k] = std::sqrt(system.penalty()[k]);
  for (Eigen::VectorXd* x : {&row_, &column_weight_, &order_, &balance_, &right_}) x->setZero(n);
}

void DenseSystem::assemble(const double* q, const MatrixWeights& weights) {
  system_.dense_matrix(q, weights, f_.data());
  for (int k = 0; k < system_.equations(); ++k) {
    unit_[k] = 1;
    row_.setZero();
    system_.add_jacobian_transposed(unit_.data(), 1, row_.data());
    jacobian_.row(k) = row_.transpose();
    unit_[k] = 0;
  }
}

bool DenseSystem::choose(StepStatus& status) {
  const int n = system_.velocities();
  // By what moves a coordinate through its scale, so that lengths and angles compare.
  const std::vector<double>& scale = system_.scales().coordinates;
  double largest = 0;
  for (int k = 0; k < n; ++k) largest = std::max(largest, f_(k, k) * scale[k] * scale[k]);
  for (int k = 0; k < n; ++k)
    column_weight_[k] = scale[k] / std::sqrt(std::max(f_(k, k) * scale[k] * scale[k], 1e-12 * largest));
  const bool sound = partition_.choose(jacobian_, row_weight_, column_weight_);
  if (!sound) status.equation = partition_.weakest();
  return sound;
}

bool DenseSystem::factor(StepStatus& status) {
  ++status.factorisations;
  if (!partition_.factor(jacobian_)) {
    status.equation = partition_.weakest();
    return false;
  }
  partition_.null_space(R_);
  fR_.noalias() = f_ * R_;
  reduced_.noalias() = R_.transpose() * fR_;
  ldlt_.compute(reduced_);
  if (const int place = ldlt_.singular_at(reduced_, 1e-14, order_); place >= 0) {
    status.coordinate = partition_.independent(place);
    return false;
  }
  return true;
}

void DenseSystem::solve(const double* g, const double* b, double* delta, double* y) {
  const int n = system_.velocities();
  const Eigen::Map<const Eigen::VectorXd> force(g, n);
  Eigen::Map<Eigen::VectorXd> out(delta, n);
  partition_.particular(b, delta);
  balance_ = force;
  balance_.noalias() -= f_ * out;
  right_.noalias() = R_.transpose() * balance_;
  ldlt_.solve_in_place(right_);
  out.noalias() += R_ * right_;
  balance_ = force;
  balance_.noalias() -= f_ * out;
  partition_.multipliers(balance_.data(), y);
}

}  // namespace mimbre
