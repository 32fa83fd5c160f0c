#include "math/function_pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/elementary.h"
#include "mimbre/diagnostics.h"

namespace mimbre {

namespace {

[[noreturn]] void refuse_pieces(std::string message) { throw InputError(Mark{}, std::move(message)); }

template <class Values>
bool all_finite(const Values& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

}  // namespace

Pieces::Pieces(const std::vector<double>& breaks, const std::vector<Piece>& pieces) : breaks_(breaks) {
  if (pieces.size() != breaks_.size() + 1)
    refuse_pieces(fmt::format("a function of {} pieces needs {} breaks, not {}", pieces.size(),
                              pieces.empty() ? 0 : pieces.size() - 1, breaks_.size()));
  if (!all_finite(breaks_)) refuse_pieces("the breaks of a piecewise function must be finite");
  for (std::size_t k = 1; k < breaks_.size(); ++k)
    if (!(breaks_[k - 1] < breaks_[k]))
      refuse_pieces(fmt::format("the breaks of a piecewise function must ascend: {} is followed by {}",
                                breaks_[k - 1], breaks_[k]));

  for (const Piece& piece : pieces) {
    if (!std::isfinite(piece.origin) || !all_finite(piece.coefficients))
      refuse_pieces("the coefficients of a piecewise function must be finite");
    origins_.push_back(piece.origin);
    first_.push_back(coefficients_.size());
    coefficients_.append(piece.coefficients.begin(), piece.coefficients.end());
    if (piece.coefficients.empty()) coefficients_.push_back(0);
    for (std::size_t i = first_.back(); i < coefficients_.size(); ++i)
      integrals_.push_back(coefficients_[i] / static_cast<double>(i - first_.back() + 1));
  }
  first_.push_back(coefficients_.size());

  // Integration constants that make the antiderivative continuous.
  integral_at_origin_.assign(pieces.size(), 0);
  for (std::size_t k = 1; k < pieces.size(); ++k)
    integral_at_origin_[k] = integral_at_origin_[k - 1] + integral_from_origin(k - 1, breaks_[k - 1]) -
                             integral_from_origin(k, breaks_[k - 1]);
  integral_at_zero_ = integrated(0);
}

Pieces Pieces::repeated(double start, double period) const {
  if (!std::isfinite(start) || !std::isfinite(period) || period <= 0)
    refuse_pieces(fmt::format("a function can be repeated with a positive period only, not {}", period));
  if (wrap_.period > 0) refuse_pieces("a repeated function cannot be repeated again");
  Pieces result = *this;
  const double integral = integrated(start + period) - integrated(start);
  result.wrap_ = Wrap{start, period, integral};
  result.integral_at_zero_ = 0;
  result.integral_at_zero_ = result.antiderivative(0);
  return result;
}

Pieces::Wrapped Pieces::wrapped(double x) const {
  if (!(wrap_.period > 0)) return {x, 0};
  const double turns = std::floor((x - wrap_.start) / wrap_.period);
  const double within = x - turns * wrap_.period;
  // Rounding may leave it just outside; it stays within the period, at the end it is nearest to.
  const double end = wrap_.start + wrap_.period;
  if (within < wrap_.start) return {wrap_.start, turns};
  if (within >= end) return {wrap_.start, turns + 1};
  return {within, turns};
}

std::size_t Pieces::piece_at(double x) const {
  // The laws in use have a handful of pieces, for which counting is faster than halving.
  if (breaks_.size() <= 8) {
    std::size_t k = 0;
    while (k < breaks_.size() && x >= breaks_[k]) ++k;
    return k;
  }
  return static_cast<std::size_t>(std::upper_bound(breaks_.begin(), breaks_.end(), x) - breaks_.begin());
}

double Pieces::value(double x) const {
  x = wrapped(x).x;
  const std::size_t k = piece_at(x);
  const double s = x - origins_[k];
  double f = 0;
  for (std::size_t i = first_[k + 1]; i-- > first_[k];) f = f * s + coefficients_[i];
  return f;
}

double Pieces::derivative(double x) const {
  x = wrapped(x).x;
  const std::size_t k = piece_at(x);
  const double s = x - origins_[k];
  double f = 0, df = 0;
  for (std::size_t i = first_[k + 1]; i-- > first_[k];) {
    df = df * s + f;
    f = f * s + coefficients_[i];
  }
  return df;
}

double Pieces::second_derivative(double x) const {
  x = wrapped(x).x;
  const std::size_t k = piece_at(x);
  const double s = x - origins_[k];
  double f = 0, df = 0, half_ddf = 0;
  for (std::size_t i = first_[k + 1]; i-- > first_[k];) {
    half_ddf = half_ddf * s + df;
    df = df * s + f;
    f = f * s + coefficients_[i];
  }
  return 2 * half_ddf;
}

double Pieces::integral_from_origin(std::size_t k, double x) const {
  const double s = x - origins_[k];
  double f = 0;
  for (std::size_t i = first_[k + 1]; i-- > first_[k];) f = f * s + integrals_[i];
  return f * s;
}

double Pieces::integrated(double x) const {
  const std::size_t k = piece_at(x);
  return integral_at_origin_[k] + integral_from_origin(k, x);
}

double Pieces::antiderivative(double x) const {
  const Wrapped place = wrapped(x);
  const double whole_periods = wrap_.period > 0 ? place.turns * wrap_.integral : 0;
  return whole_periods + integrated(place.x) - integral_at_zero_;
}

namespace {

void check_points(const std::vector<double>& x, const std::vector<double>& y, bool may_jump) {
  if (x.size() != y.size())
    refuse_pieces(fmt::format("a table needs as many x as y, not {} and {}", x.size(), y.size()));
  if (x.size() < 2) refuse_pieces("a table needs at least two points");
  if (!all_finite(x) || !all_finite(y)) refuse_pieces("the points of a table must be finite");
  for (std::size_t i = 1; i < x.size(); ++i) {
    if (x[i] < x[i - 1])
      refuse_pieces(fmt::format("the x of a table must ascend: {} is followed by {}", x[i - 1], x[i]));
    if (x[i] > x[i - 1]) continue;
    if (!may_jump)
      refuse_pieces(fmt::format("a cubic table cannot jump: x = {} stands twice (linear tables can)", x[i]));
    if (i > 1 && x[i - 2] == x[i])
      refuse_pieces(fmt::format("x = {} stands more than twice in a table", x[i]));
  }
}

/// Of the parabola through three points, at the one where the two intervals h0 (slope d0) and h1 (slope d1)
/// meet.
double parabola_slope(double h0, double d0, double h1, double d1) { return (h1 * d0 + h0 * d1) / (h0 + h1); }

/// At the far end of the interval with slope d0, whose other neighbour has slope d1; not against the
/// interval.
double end_slope(double h0, double d0, double h1, double d1) {
  const double slope = ((2 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
  return slope * d0 <= 0 ? 0 : slope;
}

std::vector<double> monotone_slopes(const std::vector<double>& h, const std::vector<double>& d) {
  const std::size_t n = h.size();
  std::vector<double> slope(n + 1);
  if (n == 1) return {d[0], d[0]};
  slope[0] = end_slope(h[0], d[0], h[1], d[1]);
  slope[n] = end_slope(h[n - 1], d[n - 1], h[n - 2], d[n - 2]);
  for (std::size_t i = 1; i < n; ++i)
    slope[i] = d[i - 1] * d[i] <= 0 ? 0 : parabola_slope(h[i - 1], d[i - 1], h[i], d[i]);
  // Fritsch and Carlson: within a circle of radius 3 secants a cubic is monotone.
  for (std::size_t i = 0; i < n; ++i) {
    if (d[i] == 0) continue;  // both slopes are zero already
    const double a = slope[i] / d[i], b = slope[i + 1] / d[i];
    const double length = mimbre::hypot(a, b);
    if (length <= 3) continue;
    slope[i] = 3 / length * a * d[i];
    slope[i + 1] = 3 / length * b * d[i];
  }
  return slope;
}

}  // namespace

Pieces linear_table(const std::vector<double>& x, const std::vector<double>& y) {
  check_points(x, y, true);
  std::vector<double> breaks;
  std::vector<Pieces::Piece> pieces;
  if (x[0] == x[1]) pieces.push_back({x[0], {y[0]}});
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    if (x[i] == x[i + 1]) continue;
    if (!pieces.empty()) breaks.push_back(x[i]);
    pieces.push_back({x[i], {y[i], (y[i + 1] - y[i]) / (x[i + 1] - x[i])}});
  }
  if (x[x.size() - 2] == x.back()) {
    breaks.push_back(x.back());
    pieces.push_back({x.back(), {y.back()}});
  }
  return Pieces(breaks, pieces);
}

Pieces cubic_table(const std::vector<double>& x, const std::vector<double>& y) {
  check_points(x, y, false);
  std::vector<double> h, d;
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    h.push_back(x[i + 1] - x[i]);
    d.push_back((y[i + 1] - y[i]) / h[i]);
  }
  const std::vector<double> slope = monotone_slopes(h, d);
  std::vector<Pieces::Piece> pieces{{x[0], {y[0], slope[0]}}};
  for (std::size_t i = 0; i < h.size(); ++i)
    pieces.push_back({x[i],
                      {y[i], slope[i], (3 * d[i] - 2 * slope[i] - slope[i + 1]) / h[i],
                       (slope[i] + slope[i + 1] - 2 * d[i]) / (h[i] * h[i])}});
  pieces.push_back({x.back(), {y.back(), slope.back()}});
  return Pieces(x, pieces);
}

}  // namespace mimbre
