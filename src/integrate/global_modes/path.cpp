#include "integrate/global_modes/path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "math/once/decompositions.h"

namespace mimbre::global_modes {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = CoordinateKinds::Kind;

namespace {

/// Of a step along the path, by the scales of the coordinates, and how often it may be halved.
constexpr double stride = 0.05;
constexpr int halvings = 4;
/// What a coordinate may make on either side: a little more than a turn.
constexpr double furthest = 2 * std::numbers::pi + 0.3;
/// Share of the largest singular direction: less is another way to go.
constexpr double other_way = 1e-4;
/// Of the fastest coordinate: a slower one does not describe the path.
constexpr double slowest = 0.1;
constexpr double closed = 1e-12, nearly_closed = 1e-9;
constexpr int rounds = 20;

MatrixXd part(const MatrixXd& J, const std::vector<int>& rows, const std::vector<int>& columns,
              const VectorXd& scale) {
  MatrixXd out = J(rows, columns);
  for (std::size_t k = 0; k < columns.size(); ++k) out.col(static_cast<Eigen::Index>(k)) *= scale[columns[k]];
  return out;
}

/// Moves `coordinates` alone until the loop is closed.
bool close(Probe& probe, const Loop& loop, const std::vector<int>& coordinates, VectorXd& q) {
  double before = 1;
  for (int round = 0; round < rounds; ++round) {
    const VectorXd violation = probe.violations(q)(loop.equations);
    const double off = violation.cwiseAbs().maxCoeff();
    if (!(off < 10)) return false;
    if (off < closed || (off < nearly_closed && off > 0.5 * before)) return true;
    before = off;
    probe.evaluate(q);
    const MatrixXd J = part(probe.jacobian(), loop.equations, coordinates, probe.scale());
    const VectorXd d = shortest_solution(J, -violation, other_way);
    VectorXd x = VectorXd::Zero(probe.scale().size());
    for (std::size_t k = 0; k < coordinates.size(); ++k)
      x[coordinates[k]] = probe.scale()[coordinates[k]] * d[static_cast<Eigen::Index>(k)];
    q = probe.moved(q, x);
  }
  return false;
}

/// Ways to go on, along the scales.
MatrixXd ways(Probe& probe, const Loop& loop, const VectorXd& q) {
  probe.evaluate(q);
  return null_space(part(probe.jacobian(), loop.equations, loop.rigid, probe.scale()), other_way);
}

VectorXd increment(const Loop& loop, const VectorXd& scale, const VectorXd& along, double by) {
  VectorXd x = VectorXd::Zero(scale.size());
  for (std::size_t k = 0; k < loop.rigid.size(); ++k)
    x[loop.rigid[k]] = by * scale[loop.rigid[k]] * along[static_cast<Eigen::Index>(k)];
  return x;
}

/// The next place, a stride further.
std::optional<Place> next_place(Probe& probe, const Loop& loop, const Place& from) {
  double length = stride;
  Place to = from;
  double done = 0;
  for (int halved = 0; done < stride * (1 - 1e-9);) {
    VectorXd q = probe.moved(to.q, increment(loop, probe.scale(), to.tangent, length));
    MatrixXd along;
    if (close(probe, loop, loop.rigid, q)) along = ways(probe, loop, q);
    if (along.cols() != 1 || std::abs(along.col(0).dot(to.tangent)) < 0.9 * to.tangent.norm()) {
      if (++halved > halvings) return {};
      length /= 2;
      continue;
    }
    const double size = along.cwiseAbs().maxCoeff();
    to.tangent = along.col(0) / (along.col(0).dot(to.tangent) < 0 ? -size : size);
    to.q = std::move(q);
    done += length;
    length = std::min(length, stride - done);
  }
  return to;
}

double position_of(const CoordinateKinds& kinds, const VectorXd& q, int coordinate) {
  return q[kinds.position[static_cast<std::size_t>(coordinate)]];
}

}  // namespace

Path follow_loop(Probe& probe, const Loop& loop, const CoordinateKinds& kinds, const VectorXd& q) {
  Place start;
  start.q = q;
  for (const int k : loop.amplitudes) start.q[kinds.position[static_cast<std::size_t>(k)]] = 0;
  const int named = loop.rigid.empty() ? -1 : loop.rigid.front();
  std::vector<int> moving;
  for (const int k : loop.rigid)
    if (k != loop.prescribed) moving.push_back(k);
  const double open = probe.violations(start.q)(loop.equations).cwiseAbs().maxCoeff();
  if (open > nearly_closed && (moving.empty() || !close(probe, loop, moving, start.q)))
    throw NoGlobalModes(
        "its loop cannot move, or does not close without deflections; only loops that can move "
        "in one way have a table",
        named >= 0 ? named : loop.amplitudes.front());
  if (loop.rigid.empty())
    throw NoGlobalModes("its loop cannot move; only loops that can move in one way have a table",
                        loop.amplitudes.front());
  const MatrixXd along = ways(probe, loop, start.q);
  if (along.cols() != 1)
    throw NoGlobalModes(along.cols() == 0
                            ? "its loop cannot move; only loops that can move in one way have a table"
                            : "its loop can move in " + std::to_string(along.cols()) +
                                  " ways, drives among them; only loops that can move in one have a table",
                        named);
  start.tangent = along.col(0) / along.cwiseAbs().maxCoeff();
  const auto follow = [&](Place from) {
    std::vector<Place> places;
    const VectorXd scale = probe.scale();
    for (;;) {
      std::optional<Place> to = next_place(probe, loop, from);
      if (!to) break;
      double moved = 0;
      for (const int k : loop.rigid)
        if (kinds.kind[static_cast<std::size_t>(k)] == Kind::plain)
          moved = std::max(
              moved, std::abs(position_of(kinds, to->q, k) - position_of(kinds, start.q, k)) / scale[k]);
      places.push_back(*to);
      from = std::move(*to);
      if (moved > furthest || places.size() > 400) break;
    }
    return places;
  };
  Place back = start;
  back.tangent = -start.tangent;
  std::vector<Place> before = follow(back);
  Path path;
  for (auto place = before.rbegin(); place != before.rend(); ++place) {
    place->tangent = -place->tangent;
    path.places.push_back(std::move(*place));
  }
  path.start = path.places.size();
  path.places.push_back(start);
  for (Place& place : follow(start)) path.places.push_back(std::move(place));
  return path;
}

Parameter choose_parameter(const Path& path, const Loop& loop, const CoordinateKinds& kinds) {
  Parameter best;
  double best_pace = 0;
  for (std::size_t k = 0; k < loop.rigid.size(); ++k) {
    const int coordinate = loop.rigid[k];
    if (kinds.kind[static_cast<std::size_t>(coordinate)] != Kind::plain) continue;
    if (loop.prescribed >= 0 && coordinate != loop.prescribed) continue;
    const auto pace = [&](std::size_t place) {
      return path.places[place].tangent[static_cast<Eigen::Index>(k)];
    };
    const double here = pace(path.start);
    const auto describes = [&](std::size_t place) {
      return pace(place) * here > 0 && std::abs(pace(place)) > slowest;
    };
    if (!describes(path.start)) continue;
    Parameter p{coordinate, path.start, path.start};
    while (p.first > 0 && describes(p.first - 1)) --p.first;
    while (p.last + 1 < path.places.size() && describes(p.last + 1)) ++p.last;
    double least = 1;
    for (std::size_t place = p.first; place <= p.last; ++place)
      least = std::min(least, std::abs(pace(place)));
    const std::size_t length = p.last - p.first, best_length = best.last - best.first;
    if (best.coordinate < 0 || length > best_length || (length == best_length && least > best_pace)) {
      best = p;
      best_pace = least;
    }
  }
  if (best.coordinate < 0 || best.last - best.first < 4)
    throw NoGlobalModes("near this position no joint coordinate describes how its loop moves",
                        loop.rigid.front());
  return best;
}

VectorXd place_at(Probe& probe, const Loop& loop, const CoordinateKinds& kinds, const Place& near,
                  int coordinate, double value) {
  std::vector<int> others;
  double pace = 1;
  for (std::size_t k = 0; k < loop.rigid.size(); ++k) {
    if (loop.rigid[k] != coordinate)
      others.push_back(loop.rigid[k]);
    else
      pace = near.tangent[static_cast<Eigen::Index>(k)] * probe.scale()[coordinate];
  }
  VectorXd q = probe.moved(near.q, increment(loop, probe.scale(), near.tangent,
                                             (value - position_of(kinds, near.q, coordinate)) / pace));
  q[kinds.position[static_cast<std::size_t>(coordinate)]] = value;
  if (!close(probe, loop, others, q))
    throw NoGlobalModes("its loop cannot be closed at a place of the table", coordinate);
  return q;
}

}  // namespace mimbre::global_modes
