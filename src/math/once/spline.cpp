#include "math/once/spline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "math/once/decompositions.h"

namespace mimbre {
namespace {

/// A banded matrix, solved by elimination with pivots of its columns.
class SplineBand {
 public:
  SplineBand(std::size_t size, std::size_t width)
      : size_(size), width_(width), stride_(3 * width + 1), values_(size * stride_, 0.0) {}
  /// Of row and column at most `width` apart.
  double& at(std::size_t row, std::size_t column) { return values_[row * stride_ + column + width_ - row]; }

  void solve(std::vector<double>& b) {
    for (std::size_t k = 0; k < size_; ++k) {
      const std::size_t last = std::min(size_ - 1, k + width_), end = std::min(size_ - 1, k + 2 * width_);
      std::size_t pivot = k;
      for (std::size_t row = k + 1; row <= last; ++row)
        if (std::abs(at(row, k)) > std::abs(at(pivot, k))) pivot = row;
      if (pivot != k) {
        for (std::size_t column = k; column <= end; ++column) std::swap(at(k, column), at(pivot, column));
        std::swap(b[k], b[pivot]);
      }
      for (std::size_t row = k + 1; row <= last; ++row) {
        const double factor = at(row, k) / at(k, k);
        if (factor == 0) continue;
        for (std::size_t column = k; column <= end; ++column) at(row, column) -= factor * at(k, column);
        b[row] -= factor * b[k];
      }
    }
    for (std::size_t k = size_; k-- > 0;) {
      const std::size_t end = std::min(size_ - 1, k + 2 * width_);
      for (std::size_t column = k + 1; column <= end; ++column) b[k] -= at(k, column) * b[column];
      b[k] /= at(k, k);
    }
  }

 private:
  std::size_t size_, width_, stride_;
  std::vector<double> values_;
};

/// By value, slope and second derivative at both ends of an interval.
using EndRow = std::array<double, 6>;

EndRow operator*(double factor, EndRow row) {
  for (double& x : row) x *= factor;
  return row;
}
EndRow operator+(EndRow a, const EndRow& b) {
  for (std::size_t k = 0; k < a.size(); ++k) a[k] += b[k];
  return a;
}

/// Coefficients of (x − start)³, ⁴, ⁵ on an interval of length h.
struct HighPowers {
  EndRow third, fourth, fifth;
};

HighPowers upper(double h) {
  const double h2 = h * h;
  const EndRow value{-1, -h, -h2 / 2, 1, 0, 0}, slope{0, -h, -h2, 0, h, 0}, second{0, 0, -h2, 0, 0, h2};
  const double h3 = h * h * h;
  return {(1 / h3) * (10 * value + -4 * slope + 0.5 * second),
          (1 / (h3 * h)) * (-15 * value + 7 * slope + -1 * second),
          (1 / (h3 * h * h)) * (6 * value + -3 * slope + 0.5 * second)};
}

double product(const EndRow& row, const SplinePoints& p, std::size_t k) {
  return row[0] * p.value[k] + row[1] * p.slope[k] + row[2] * p.second[k] + row[3] * p.value[k + 1] +
         row[4] * p.slope[k + 1] + row[5] * p.second[k + 1];
}

/// The equations of a spline for slopes and second derivatives, two by point.
class SplineEquations {
 public:
  explicit SplineEquations(const std::vector<double>& values)
      : values_(values), matrix_(2 * values.size(), 6), right_(2 * values.size(), 0.0) {}
  /// Adds to an equation the product of `row` with what interval k has at its ends.
  void add(std::size_t equation, std::size_t k, const EndRow& row) {
    for (std::size_t end = 0; end < 2; ++end) {
      right_[equation] -= row[3 * end] * values_[k + end];
      for (std::size_t d = 0; d < 2; ++d) matrix_.at(equation, 2 * (k + end) + d) += row[3 * end + 1 + d];
    }
  }
  std::vector<double> solution() {
    matrix_.solve(right_);
    return std::move(right_);
  }

 private:
  const std::vector<double>& values_;
  SplineBand matrix_;
  std::vector<double> right_;
};

/// The polynomial through few points.
SplinePoints polynomial_through(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<Eigen::Index>(x.size());
  SplinePoints out{x, y, std::vector<double>(x.size(), 0.0), std::vector<double>(x.size(), 0.0)};
  if (n == 1) return out;
  const double length = x.back() - x.front();
  Eigen::MatrixXd powers(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      powers(i, j) = j == 0 ? 1 : powers(i, j - 1) * (x[static_cast<std::size_t>(i)] - x.front()) / length;
  const Eigen::VectorXd c = solve(powers, Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(y.data(), n)));
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 1; j < n; ++j) {
      const double factor = static_cast<double>(j);
      out.slope[static_cast<std::size_t>(i)] += factor * c[j] * powers(i, j - 1) / length;
      if (j > 1)
        out.second[static_cast<std::size_t>(i)] +=
            factor * (factor - 1) * c[j] * powers(i, j - 2) / (length * length);
    }
  return out;
}

}  // namespace

SplinePoints quintic_spline(const std::vector<double>& x, const std::vector<double>& y, SplineEnds ends) {
  const std::size_t n = x.size();
  if (n < 6) return polynomial_through(x, y);
  // In units in which intervals are near 1.
  const double unit = (x.back() - x.front()) / static_cast<double>(n - 1);
  std::vector<HighPowers> of;
  std::vector<double> h;
  for (std::size_t k = 0; k + 1 < n; ++k) {
    h.push_back((x[k + 1] - x[k]) / unit);
    of.push_back(upper(h.back()));
  }
  const auto third_at_end = [&](std::size_t k) {
    return of[k].third + 4 * h[k] * of[k].fourth + 10 * h[k] * h[k] * of[k].fifth;
  };
  const auto fourth_at_end = [&](std::size_t k) { return of[k].fourth + 5 * h[k] * of[k].fifth; };
  SplineEquations equations(y);
  for (std::size_t k = 1; k + 1 < n; ++k) {
    const double least = std::min(h[k - 1], h[k]), cube = least * least * least;
    equations.add(2 * k, k - 1, cube * third_at_end(k - 1));
    equations.add(2 * k, k, -cube * of[k].third);
    equations.add(2 * k + 1, k - 1, cube * least * fourth_at_end(k - 1));
    equations.add(2 * k + 1, k, -cube * least * of[k].fourth);
  }
  const auto same_fifth = [&](std::size_t equation, std::size_t k) {
    const double least = std::min(h[k], h[k + 1]), fifth = least * least * least * least * least;
    equations.add(equation, k, fifth * of[k].fifth);
    equations.add(equation, k + 1, -fifth * of[k + 1].fifth);
  };
  if (ends == SplineEnds::natural) {
    equations.add(0, 0, of[0].third);
    equations.add(1, 0, of[0].fourth);
    equations.add(2 * n - 2, n - 2, third_at_end(n - 2));
    equations.add(2 * n - 1, n - 2, fourth_at_end(n - 2));
  } else {
    same_fifth(0, 0);
    same_fifth(1, 1);
    same_fifth(2 * n - 2, n - 4);
    same_fifth(2 * n - 1, n - 3);
  }
  const std::vector<double> found = equations.solution();
  SplinePoints out{x, y, {}, {}};
  for (std::size_t k = 0; k < n; ++k) {
    out.slope.push_back(found[2 * k] / unit);
    out.second.push_back(found[2 * k + 1] / (unit * unit));
  }
  return out;
}

std::vector<double> smoothed(const std::vector<double>& x, const std::vector<double>& y, double period) {
  const std::size_t n = x.size();
  if (n < 4) return y;
  const double unit = (x.back() - x.front()) / static_cast<double>(n - 1);
  const double ratio = period / (2 * std::numbers::pi * unit), cube = ratio * ratio * ratio,
               strength = cube * cube;
  std::vector<double> t(n), weight(n, 0.0);
  for (std::size_t k = 0; k < n; ++k) t[k] = (x[k] - x[0]) / unit;
  for (std::size_t k = 0; k + 1 < n; ++k) {
    weight[k] += (t[k + 1] - t[k]) / 2;
    weight[k + 1] += (t[k + 1] - t[k]) / 2;
  }
  // Third divided differences, of the points j to j + 3.
  const std::size_t m = n - 3;
  std::vector<std::array<double, 4>> difference(m);
  for (std::size_t j = 0; j < m; ++j)
    for (std::size_t i = 0; i < 4; ++i) {
      double denominator = 1;
      for (std::size_t k = 0; k < 4; ++k)
        if (k != i) denominator *= t[j + i] - t[j + k];
      difference[j][i] = 1 / denominator;
    }
  // f''' is a sum of their kernels K_j, Σ_i d_ij (t_i − t)²/2 over the points behind t. The matrix: products
  // of the kernels, and of the differences.
  const auto kernel = [&](std::size_t j, double at) {
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i)
      if (const double behind = t[j + i] - at; behind > 0) sum += difference[j][i] * behind * behind / 2;
    return sum;
  };
  SplineBand matrix(m, 3);
  std::vector<double> right(m, 0.0);
  const double root = std::sqrt(0.6);
  for (std::size_t k = 0; k + 1 < n; ++k) {
    const std::size_t first = k < 2 ? 0 : k - 2, last = std::min(k, m - 1);
    const double h = t[k + 1] - t[k];
    for (const auto& [place, share] :
         {std::pair(-root, 5.0 / 18), std::pair(0.0, 8.0 / 18), std::pair(root, 5.0 / 18)}) {
      const double at = t[k] + h * (1 + place) / 2;
      for (std::size_t a = first; a <= last; ++a)
        for (std::size_t b = first; b <= last; ++b)
          matrix.at(a, b) += h * share * kernel(a, at) * kernel(b, at);
    }
  }
  for (std::size_t a = 0; a < m; ++a) {
    for (std::size_t i = 0; i < 4; ++i) right[a] += difference[a][i] * y[a + i];
    for (std::size_t b = a < 3 ? 0 : a - 3; b <= std::min(m - 1, a + 3); ++b)
      for (std::size_t i = 0; i < 4; ++i)
        if (a + i >= b && a + i < b + 4)
          matrix.at(a, b) += strength * difference[a][i] * difference[b][a + i - b] / weight[a + i];
  }
  matrix.solve(right);
  std::vector<double> out = y;
  for (std::size_t a = 0; a < m; ++a)
    for (std::size_t i = 0; i < 4; ++i) out[a + i] -= strength * difference[a][i] * right[a] / weight[a + i];
  return out;
}

Function quintic_function(const SplinePoints& points) {
  const std::size_t n = points.x.size();
  std::vector<double> breaks, origins;
  std::vector<std::vector<double>> pieces;
  if (points.x[0] > 0 || n == 1) {
    origins.push_back(points.x[0]);
    pieces.push_back({points.value[0]});
    if (n > 1) breaks.push_back(points.x[0]);
  }
  for (std::size_t k = 0; k + 1 < n; ++k) {
    const HighPowers c = upper(points.x[k + 1] - points.x[k]);
    origins.push_back(points.x[k]);
    pieces.push_back({points.value[k], points.slope[k], points.second[k] / 2, product(c.third, points, k),
                      product(c.fourth, points, k), product(c.fifth, points, k)});
    if (k > 0) breaks.push_back(points.x[k]);
  }
  return Function::piecewise(breaks, origins, std::move(pieces));
}

}  // namespace mimbre
