#include "math/space_curve.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "math/elementary.h"
#include "math/turn.h"

namespace mimbre {
namespace {

using Row = Eigen::RowVectorXd;
using Knots = Eigen::Matrix<double, SpaceCurve::rows, Eigen::Dynamic>;

/// Second derivatives at the knots. The equations are diagonally dominant, so that every sweep (Gauss–Seidel)
/// at least halves what is left. Open curves end without curvature, directions without slope.
Knots curvatures(const Knots& values, const std::vector<double>& spans, bool closed) {
  const auto n = static_cast<int>(values.cols());
  Knots m = Knots::Zero(SpaceCurve::rows, n);
  const auto next = [&](int k) { return k + 1 < n ? k + 1 : 0; };
  const auto slope = [&](int k) {
    return ((values.col(next(k)) - values.col(k)) / spans[static_cast<std::size_t>(k)]).eval();
  };
  for (int sweep = 0; sweep < 120; ++sweep)
    for (int k = 0; k < n; ++k) {
      const bool ends = !closed && (k == 0 || k == n - 1);
      if (ends) {
        const int piece = k == 0 ? 0 : n - 2, other = k == 0 ? 1 : n - 2;
        const double sign = k == 0 ? 1 : -1;
        m.col(k).tail<6>() = sign * 3 * slope(piece).tail<6>() / spans[static_cast<std::size_t>(piece)] -
                             0.5 * m.col(other).tail<6>();
        continue;
      }
      const int before = k > 0 ? k - 1 : n - 1;
      const double h0 = spans[static_cast<std::size_t>(before)], h1 = spans[static_cast<std::size_t>(k)];
      m.col(k) =
          (6 * (slope(k) - slope(before)) - h0 * m.col(before) - h1 * m.col(next(k))) / (2 * (h0 + h1));
    }
  return m;
}

/// Directions at the knots that turn along with the tangents as little as they can; round a closed curve the
/// turn that is left over is spread over its length.
void add_directions(Knots& values, const std::vector<double>& spans, bool closed) {
  const auto n = static_cast<int>(values.cols());
  std::vector<Eigen::Vector3d> tangents;
  for (int k = 0; k < n; ++k) {
    const int after = closed ? (k + 1) % n : std::min(k + 1, n - 1),
              before = closed ? (k + n - 1) % n : std::max(k - 1, 0);
    const Eigen::Vector3d chord = values.col(after).head<3>() - values.col(before).head<3>();
    const Eigen::Vector3d ahead = values.col(after).head<3>() - values.col(k).head<3>();
    // Of points that go there and back there is no chord.
    tangents.push_back(chord.norm() > 1e-9 * spans[0] ? chord.normalized() : ahead.normalized());
  }
  int least = 0;
  tangents[0].cwiseAbs().minCoeff(&least);
  Eigen::Vector3d first = tangents[0].cross(Eigen::Vector3d::Unit(least)).normalized();
  const Eigen::Vector3d start = first;
  std::vector<Eigen::Vector3d> firsts{first};
  double length = spans[0];
  for (int k = 1; k < n; ++k) {
    first = turn_between(tangents[static_cast<std::size_t>(k - 1)], tangents[static_cast<std::size_t>(k)]) *
            first;
    firsts.push_back(first);
    if (static_cast<std::size_t>(k) < spans.size()) length += spans[static_cast<std::size_t>(k)];
  }
  double left = 0;
  if (closed) {
    first = turn_between(tangents.back(), tangents[0]) * first;
    left = mimbre::atan2(tangents[0].dot(first.cross(start)), first.dot(start));
  }
  double at = 0;
  for (int k = 0; k < n; ++k) {
    const auto j = static_cast<std::size_t>(k);
    const Eigen::Vector3d direction = turn_about(tangents[j], left * at / length) * firsts[j];
    values.col(k).segment<3>(3) = direction;
    values.col(k).tail<3>() = tangents[j].cross(direction);
    if (j < spans.size()) at += spans[j];
  }
}

}  // namespace

std::size_t SpaceCurve::piece(double& parameter) const {
  if (closed) {
    parameter -= length * std::floor(parameter / length);
    if (!(parameter < length)) parameter = 0;  // round-off, or not a number
  }
  const auto behind = std::upper_bound(pieces.begin() + 1, pieces.end(), parameter,
                                       [](double x, const Piece& p) { return x < p.start; });
  return static_cast<std::size_t>(behind - pieces.begin() - 1);
}

SpaceCurve space_curve(const std::vector<Eigen::Vector3d>& points, bool closed) {
  SpaceCurve curve;
  curve.closed = closed;
  const auto n = static_cast<int>(points.size());
  const int count = closed ? n : n - 1;
  std::vector<double> spans;
  Knots values(SpaceCurve::rows, n);
  for (int k = 0; k < n; ++k) values.col(k).head<3>() = points[static_cast<std::size_t>(k)];
  for (int k = 0; k < count; ++k) spans.push_back((values.col((k + 1) % n) - values.col(k)).head<3>().norm());
  add_directions(values, spans, closed);
  const Knots m = curvatures(values, spans, closed);
  const auto straight = [&](double start, const auto& value, const auto& slope) {
    SpaceCurve::Piece piece;
    piece.start = start;
    for (int row = 0; row < SpaceCurve::rows; ++row) {
      piece.coefficients[static_cast<std::size_t>(4 * row)] = value[row];
      piece.coefficients[static_cast<std::size_t>(4 * row + 1)] = row < 3 ? slope[row] : 0;
    }
    return piece;
  };
  double at = 0;
  for (int k = 0; k < count; ++k) {
    const int next = (k + 1) % n;
    const double h = spans[static_cast<std::size_t>(k)];
    const auto slope = ((values.col(next) - values.col(k)) / h - h / 6 * (2 * m.col(k) + m.col(next))).eval();
    if (!closed && k == 0) {  // ends at the curve's start, whose parameter is 0
      curve.pieces.push_back(straight(0, values.col(k), slope));
    }
    SpaceCurve::Piece piece;
    piece.start = at;
    for (int row = 0; row < SpaceCurve::rows; ++row) {
      const auto c = static_cast<std::size_t>(4 * row);
      piece.coefficients[c] = values(row, k);
      piece.coefficients[c + 1] = slope[row];
      piece.coefficients[c + 2] = m(row, k) / 2;
      piece.coefficients[c + 3] = (m(row, next) - m(row, k)) / (6 * h);
    }
    curve.pieces.push_back(piece);
    at += h;
    if (!closed && k == count - 1)
      curve.pieces.push_back(
          straight(at, values.col(next), (slope + h / 2 * (m.col(k) + m.col(next))).eval()));
  }
  curve.length = at;
  return curve;
}

double nearest_on(const SpaceCurve& curve, const Eigen::Vector3d& place) {
  CurvePoint<double> point;
  const auto distance = [&](double s) {
    curve_point(curve, s, point);
    return (place - point.value[0]).squaredNorm();
  };
  const int samples = 16 * static_cast<int>(curve.pieces.size());
  double best = 0, least = distance(0);
  for (int k = 1; k <= samples; ++k)
    if (const double s = curve.length * k / samples, d = distance(s); d < least) best = s, least = d;
  return nearest_near<double>(curve, place, best, point);
}

}  // namespace mimbre
