#include "analysis/modes/mode_shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace mimbre::linear {

using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

MatrixXd echelon(MatrixXd v) {
  std::vector<char> used(static_cast<std::size_t>(v.rows()), 0);
  for (Eigen::Index c = 0; c < v.cols(); ++c) {
    Eigen::Index pivot = -1, column = c;
    double most = 0;
    for (Eigen::Index r = 0; r < v.rows(); ++r)
      for (Eigen::Index k = c; k < v.cols(); ++k)
        if (!used[static_cast<std::size_t>(r)] && std::abs(v(r, k)) > most * (1 + 1e-9)) {
          most = std::abs(v(r, k));
          pivot = r;
          column = k;
        }
    if (pivot < 0) break;
    used[static_cast<std::size_t>(pivot)] = 1;
    v.col(c).swap(v.col(column));
    v.col(c) /= v(pivot, c);
    for (Eigen::Index k = 0; k < v.cols(); ++k)
      if (k != c) v.col(k) -= v(pivot, k) * v.col(c);
  }
  for (Eigen::Index k = 0; k < v.size(); ++k)
    if (std::abs(v.data()[k]) < 1e-9) v.data()[k] = 0;
  return v;
}

std::complex<double> normalise(VectorXcd& x, Eigen::Index entries, const VectorXd& scale) {
  std::complex<double> largest = 0;
  double most = 0;
  for (Eigen::Index k = 0; k < entries; ++k)
    if (std::abs(x[k]) / scale[k] > most * (1 + 1e-9)) {
      most = std::abs(x[k]) / scale[k];
      largest = x[k] / scale[k];
    }
  if (!(most > 0)) return 1;
  x /= largest;
  return 1. / largest;
}

Mode mode_of(std::complex<double> value, double decay_round_off) {
  Mode mode;
  mode.kind = value.imag() > 0 ? Mode::Kind::oscillating : Mode::Kind::real;
  mode.value = value;
  mode.frequency = std::abs(value) / (2 * std::numbers::pi);
  mode.damped = value.imag() / (2 * std::numbers::pi);
  mode.damping = std::abs(value) > 0 ? -value.real() / std::abs(value) : 0;
  mode.grows = value.real() > std::max(decay_round_off, 1e-9 * std::abs(value));
  return mode;
}

}  // namespace mimbre::linear
