#include "simulation/watch/lag.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/multiply_add.h"

namespace mimbre {
namespace {

/// Errors over the range of what they are the errors of: beyond it their size has no meaning.
constexpr double hopeless = 10;

using Matrix = Lag::Matrix;

/// Of a positive definite matrix; whether it is one.
bool invert(Matrix& a) {
  for (int k = 0; k < Lag::most_modes; ++k) {
    const double pivot = a(k, k);
    if (!(pivot > 0)) return false;
    a(k, k) = 1;
    a.row(k) /= pivot;
    for (int i = 0; i < Lag::most_modes; ++i) {
      if (i == k) continue;
      const double factor = std::exchange(a(i, k), 0.0);
      a.row(i) -= factor * a.row(k);
    }
  }
  return true;
}

}  // namespace

Lag::Vector Lag::read(const double* amplitudes) const {
  std::array<double, most_modes> z{};
  for (Eigen::Index k = 0; k < rows_.cols(); ++k) {
    const double* const column = rows_.col(k).data();
    for (std::size_t r = 0; r < z.size(); ++r) z[r] = multiply_add(column[r], amplitudes[k], z[r]);
  }
  return Eigen::Map<const Vector>(z.data());
}

void Lag::start(const double* amplitudes, double time) {
  stiffness_.setZero();
  step_ = largest_ = 0;
  lost_ = false;
  time_ = time;
  error_.setZero();
  rate_.setZero();
  second_.setZero();
  const Vector z = read(amplitudes);
  least_ = z.cwiseMin(0);
  most_ = z.cwiseMax(0);
}

void Lag::stiffen(const Matrix& stiffness) {
  stiffness_ = own_.transpose() * stiffness * own_;
  step_ = 0;
}

bool Lag::factor(double h) {
  if (h == step_) return true;
  inverse_ = 0.25 * h * h * stiffness_ + 0.5 * h * damping_;
  inverse_.diagonal() += squares_ + Vector::Constant(0.25 * h * h);
  step_ = h;
  return invert(inverse_);
}

void Lag::watch(const double* amplitudes, double time) {
  const Vector z = read(amplitudes);
  least_ = least_.cwiseMin(z);
  most_ = most_.cwiseMax(z);
  const double h = time - time_;
  time_ = time;
  if (!(h > 0) || lost_) return;
  const Vector rate = rate_ + 0.5 * h * second_, error = error_ + h * (rate_ + 0.25 * h * second_);
  lost_ = !factor(h);
  if (lost_) return;
  second_ = -inverse_ * (error + damping_ * rate + stiffness_ * (error + z));
  rate_ = rate + 0.5 * h * second_;
  error_ = error + 0.25 * h * h * second_;
  largest_ = std::max(largest_, error_.norm());
  lost_ = !(largest_ <= hopeless * (most_ - least_).norm());
}

double Lag::value() const {
  const double range = (most_ - least_).norm();
  return range > 0 ? std::min(largest_ / range, hopeless) : 0;
}

void Lag::transfer(StateTransfer& transfer) {
  for (Eigen::Index k = 0; k < rows_.size(); ++k) transfer(rows_.data()[k]);
  transfer(count_, own_, squares_, damping_, stiffness_, time_, largest_, lost_, error_, rate_, second_,
           least_, most_);
  if (transfer.restoring()) step_ = 0;
}

}  // namespace mimbre
