#include "integrate/global_modes/spline.h"

#include <algorithm>

#include "math/once/decompositions.h"

namespace mimbre::global_modes {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// Second derivatives at the places (de Boor 1978, chapter IV).
MatrixXd second_derivatives(const MatrixXd& y, double h) {
  const Index n = y.cols();
  // Rows m(i−1) + 4 m(i) + m(i+1) = 6 (y(i−1) − 2 y(i) + y(i+1))/h²; at the ends third derivatives go on, so
  // that m(0) = 2 m(1) − m(2).
  MatrixXd rest(y.rows(), n - 2);
  for (Index i = 1; i < n - 1; ++i)
    rest.col(i - 1) = 6 / (h * h) * (y.col(i - 1) - 2 * y.col(i) + y.col(i + 1));
  Eigen::VectorXd diagonal = Eigen::VectorXd::Constant(n - 2, 4), next = Eigen::VectorXd::Ones(n - 2),
                  before = next;
  diagonal[0] = diagonal[n - 3] = 6;
  next[0] = before[n - 3] = 0;
  for (Index i = 1; i < n - 2; ++i) {
    const double factor = before[i] / diagonal[i - 1];
    diagonal[i] -= factor * next[i - 1];
    rest.col(i) -= factor * rest.col(i - 1);
  }
  MatrixXd m(y.rows(), n);
  for (Index i = n - 3; i >= 0; --i) {
    m.col(i + 1) = rest.col(i);
    if (i < n - 3) m.col(i + 1) -= next[i] * m.col(i + 2);
    m.col(i + 1) /= diagonal[i];
  }
  m.col(0) = 2 * m.col(1) - m.col(2);
  m.col(n - 1) = 2 * m.col(n - 2) - m.col(n - 3);
  return m;
}

}  // namespace

Spline::Spline(const MatrixXd& values, double first, double spacing)
    : first_(first),
      spacing_(spacing),
      cells_(static_cast<int>(values.cols()) - 1),
      columns_(values.rows()),
      coefficients_(4 * values.rows(), cells_) {
  const MatrixXd m = second_derivatives(values, spacing);
  for (Index i = 0; i < cells_; ++i)
    coefficients_.col(i) << values.col(i),
        (values.col(i + 1) - values.col(i)) / spacing - spacing / 6 * (2 * m.col(i) + m.col(i + 1)),
        0.5 * m.col(i), (m.col(i + 1) - m.col(i)) / (6 * spacing);
}

void Spline::evaluate(double x, double* value, double* rate, double* second) const {
  const int cell = std::clamp(static_cast<int>((x - first_) / spacing_), 0, cells_ - 1);
  const double u = x - first_ - spacing_ * cell;
  const double *a = coefficients_.col(cell).data(), *b = a + columns_, *c = b + columns_, *d = c + columns_;
  for (Index k = 0; k < columns_; ++k) {
    value[k] = a[k] + u * (b[k] + u * (c[k] + u * d[k]));
    rate[k] = b[k] + u * (2 * c[k] + 3 * u * d[k]);
    second[k] = 2 * c[k] + 6 * u * d[k];
  }
}

}  // namespace mimbre::global_modes
