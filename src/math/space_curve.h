#pragma once
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <vector>

#include "base/array.h"
#include "math/dual.h"
#include "math/pack.h"

/// Smooth curves in space through points.
namespace mimbre {

/// A cubic spline through points over the length of its chords, with two directions that turn along with it
/// as little as they can and stay across it: nine splines in one. Open ones go on straight beyond their ends.
struct SpaceCurve {
  static constexpr int rows = 9;  ///< point, first direction, second direction
  /// Σ_k coefficients[4 row + k] x^k, x the parameter from the piece's start.
  struct Piece {
    double start = 0;
    std::array<double, 4 * rows> coefficients{};
  };
  bool closed = false;
  double length = 0;    ///< of all chords: the period of a closed curve
  Array<Piece> pieces;  ///< an open curve has one more before its start and behind its end

  /// The piece at a parameter, which a closed curve brings into its period.
  std::size_t piece(double& parameter) const;
};

/// Through at least two points, three of a closed curve, of which no two neighbours coincide.
SpaceCurve space_curve(const std::vector<Eigen::Vector3d>& points, bool closed);

/// The parameter of a point of the curve that is nearest to a place, of all of it.
double nearest_on(const SpaceCurve& curve, const Eigen::Vector3d& place);

/// At one parameter: of each of the nine splines the value and its derivatives.
template <class T>
struct CurvePoint {
  using Vec3 = Eigen::Matrix<T, 3, 1>;
  Vec3 value[3], first[3], second[3];  ///< of the point and both directions
};

namespace curve_detail {
template <class T, class Coefficient>
void evaluate(const Coefficient& c, const T& x, CurvePoint<T>& out) {
  for (int row = 0; row < SpaceCurve::rows; ++row) {
    const T c1 = c(4 * row + 1), c2 = c(4 * row + 2), c3 = c(4 * row + 3);
    out.value[row / 3][row % 3] = c(4 * row) + x * (c1 + x * (c2 + x * c3));
    out.first[row / 3][row % 3] = c1 + x * (T(2) * c2 + x * (T(3) * c3));
    out.second[row / 3][row % 3] = T(2) * c2 + x * (T(6) * c3);
  }
}
}  // namespace curve_detail

inline void curve_point(const SpaceCurve& curve, double s, CurvePoint<double>& out) {
  const SpaceCurve::Piece& p = curve.pieces[curve.piece(s)];
  curve_detail::evaluate([&](int k) { return p.coefficients[static_cast<std::size_t>(k)]; }, s - p.start,
                         out);
}
inline void curve_point(const SpaceCurve& curve, const Dual& s, CurvePoint<Dual>& out) {
  double at = s.value;
  const SpaceCurve::Piece& p = curve.pieces[curve.piece(at)];
  curve_detail::evaluate([&](int k) { return Dual(p.coefficients[static_cast<std::size_t>(k)]); },
                         Dual(at - p.start, s.derivative), out);
}
template <int N>
void curve_point(const SpaceCurve& curve, const Pack<N>& s, CurvePoint<Pack<N>>& out) {
  const SpaceCurve::Piece* pieces[N];
  Pack<N> x;
  for (int i = 0; i < N; ++i) {
    double at = s[i];
    pieces[i] = &curve.pieces[curve.piece(at)];
    x[i] = at - pieces[i]->start;
  }
  const auto coefficient = [&](int k) {
    Pack<N> c;
    for (int i = 0; i < N; ++i) c[i] = pieces[i]->coefficients[static_cast<std::size_t>(k)];
    return c;
  };
  curve_detail::evaluate(coefficient, x, out);
}

/// The parameter of the curve's point near `start` that is nearest to `place`: where the way to it is at
/// right angles to the curve.
template <class T>
T nearest_near(const SpaceCurve& curve, const Eigen::Matrix<T, 3, 1>& place, const T& start,
               CurvePoint<T>& out) {
  // Steps are no longer than a piece, so that they go down the distance and not past the next valley.
  const T longest = T(curve.length / static_cast<double>(curve.pieces.size()));
  T s = start;
  bool last = false;
  for (int round = 0; round < 40; ++round) {
    curve_point(curve, s, out);
    const Eigen::Matrix<T, 3, 1> e = place - out.value[0];
    const T speed = out.first[0].squaredNorm();
    // Where the distance bends the other way Newton's step would climb.
    const T bend = speed - e.dot(out.second[0]);
    const T slope = select(bend > T(0.1) * speed, bend, speed);
    T step = e.dot(out.first[0]) / slope;
    step = select(step > longest, longest, step);
    step = select(step < -longest, T(-longest), step);
    s += step;
    if (last) break;
    // One more after the last that matters makes derivatives exact too.
    last = all(step * step < T(1e-16 * curve.length * curve.length));
  }
  curve_point(curve, s, out);
  return s;
}

}  // namespace mimbre
