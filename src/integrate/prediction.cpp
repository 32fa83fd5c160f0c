#include "integrate/prediction.h"

#include <algorithm>
#include <cmath>

namespace mimbre {

/// Of a step, by which another one may differ from it that is as long: round-off of times.
constexpr double round_off_of_steps = 1e-9;

Prediction::Prediction(int unknowns) {
  for (Eigen::VectorXd* x : {&own_, &last_, &before_, &error_, &rest_}) x->setZero(unknowns);
}

void Prediction::begin(double step, Eigen::VectorXd& x) {
  own_ = x;
  replaced_ = false;
  if (!as_long(step)) return;
  if (order_ == 1) x += last_;
  if (order_ == 2) x += 2 * last_ - before_;
}

bool Prediction::as_long(double step) const { return std::abs(step - step_) <= round_off_of_steps * step; }

void Prediction::replace(const Eigen::VectorXd& x) {
  own_ = x;
  replaced_ = true;
}

double Prediction::off(const Scales& scales, const Eigen::VectorXd& x) {
  rest_ = x - own_;
  return scales.of_coordinates(rest_.data());
}

void Prediction::learn(double step, const Scales& scales, const Eigen::VectorXd& x) {
  if (replaced_) return forget();
  if (!as_long(step)) forget();
  step_ = step;
  error_ = x - own_;
  double least = scales.of_coordinates(error_.data());
  order_ = 0;
  const auto try_order = [&](int order) {
    const double left = scales.of_coordinates(rest_.data());
    if (!(left < least)) return;
    least = left;
    order_ = order;
  };
  if (known_ > 0) {
    rest_ = error_ - last_;
    try_order(1);
  }
  if (known_ > 1) {
    rest_ = error_ - 2 * last_ + before_;
    try_order(2);
  }
  before_.swap(last_);
  last_.swap(error_);
  known_ = std::min(known_ + 1, 2);
}

}  // namespace mimbre
