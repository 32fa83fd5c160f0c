#pragma once
#include <Eigen/Core>

namespace mimbre::global_modes {

/// Cubic splines through the same equally spaced places, without a knot next to the ends: values, first and
/// second derivatives are continuous.
class Spline {
 public:
  Spline() = default;
  /// values: columns × places (at least four), from `first` on with `spacing`.
  Spline(const Eigen::MatrixXd& values, double first, double spacing);

  double first() const { return first_; }
  double last() const { return first_ + spacing_ * cells_; }
  Eigen::Index columns() const { return columns_; }
  /// Writes value, derivative and second derivative (columns × 1 each) at x, from first() to last().
  void evaluate(double x, double* value, double* rate, double* second) const;

 private:
  double first_ = 0, spacing_ = 1;
  int cells_ = 0;
  Eigen::Index columns_ = 0;
  Eigen::MatrixXd coefficients_;  ///< 4 columns × cells: of 1, u, u², u³, u from the begin of the cell on
};

}  // namespace mimbre::global_modes
