#include "simulation/watch/validity_measures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "joints/joint_kind.h"
#include "math/once/decompositions.h"

namespace mimbre::validity {

bool is_piece(const Compiled& m, int body) {
  const auto flexible = [&](int b) { return b >= 0 && m.bodies[b].modes > 0; };
  for (const spec::Joint& joint : m.spec().joints) {
    if (!joint_info(joint.type).all_static_modes) continue;
    const int a = m.frames[m.frame_of_spec[joint.frame_a]].body,
              b = m.frames[m.frame_of_spec[joint.frame_b]].body;
    if ((a == body && flexible(b)) || (b == body && flexible(a))) return true;
  }
  return false;
}

Points points_of(const ReducedBody& body) {
  if (body.nodes.cols() > 0) return {body.nodes, body.node_shapes};
  const Eigen::Index count = static_cast<Eigen::Index>(body.frames.size());
  Points p{Eigen::Matrix3Xd(3, count), MatrixXd(3 * count, body.modes)};
  for (Eigen::Index k = 0; k < count; ++k) {
    p.places.col(k) = body.frames[k].position;
    p.shapes.middleRows<3>(3 * k) = body.frames[k].X;
  }
  return p;
}

namespace {

Eigen::Index farthest(const Eigen::Matrix3Xd& places, Eigen::Index from) {
  Eigen::Index at = 0;
  (places.colwise() - places.col(from)).colwise().squaredNorm().maxCoeff(&at);
  return at;
}

}  // namespace

namespace {

/// Points of a body whose displacements are watched in every step, at least.
constexpr Eigen::Index most_points = 24;

/// Each next one moves most for its elastic energy where the ones before it are held, until that leaves less
/// than a twentieth of the largest motion.
std::vector<Eigen::Index> points_that_move_most(const Points& points, const MatrixXd& stiffness) {
  // Amplitudes of unit elastic energy; those without any are left out.
  const EigenPairs pairs = symmetric_eigen(stiffness);
  Eigen::Index free = 0;
  while (free < pairs.values.size() && !(pairs.values[free] > 1e-12 * pairs.values[pairs.values.size() - 1]))
    ++free;
  const Eigen::Index count = pairs.values.size() - free;
  MatrixXd left = points.shapes * pairs.vectors.rightCols(count) *
                  pairs.values.tail(count).cwiseSqrt().cwiseInverse().asDiagonal();
  std::vector<Eigen::Index> chosen;
  double largest = 0;
  for (Eigen::Index round = 0; round < stiffness.rows(); ++round) {
    Eigen::Index at = 0;
    double most = 0;
    for (Eigen::Index k = 0; k < points.places.cols(); ++k)
      if (const double moves = left.middleRows<3>(3 * k).squaredNorm(); moves > most) {
        most = moves;
        at = k;
      }
    largest = std::max(largest, most);
    if (!(most > 0.0025 * largest)) break;
    chosen.push_back(at);
    // Hold it: leave what is at right angles to its rows.
    const MatrixXd rows = left.middleRows<3>(3 * at);
    const EigenPairs held = symmetric_eigen(MatrixXd(rows * rows.transpose()));
    for (int k = 0; k < 3; ++k) {
      if (!(held.values[k] > 1e-12 * held.values[2])) continue;
      const VectorXd direction = rows.transpose() * held.vectors.col(k) / std::sqrt(held.values[k]);
      left -= (left * direction).eval() * direction.transpose();
    }
  }
  return chosen;
}

}  // namespace

std::vector<Eigen::Index> telling_points(const Points& points, const MatrixXd& stiffness) {
  const Eigen::Index count = points.places.cols(),
                     most = std::max<Eigen::Index>(most_points, 2 * stiffness.rows());
  std::vector<Eigen::Index> chosen;
  if (count <= most) {
    for (Eigen::Index k = 0; k < count; ++k)
      if (!points.shapes.middleRows<3>(3 * k).isZero(0)) chosen.push_back(k);
    return chosen;
  }
  chosen = points_that_move_most(points, stiffness);
  // Between those, evenly: the farthest from all so far.
  VectorXd distance = VectorXd::Constant(count, std::numeric_limits<double>::infinity());
  std::size_t done = 0;
  while (true) {
    for (; done < chosen.size(); ++done)
      distance = distance.cwiseMin(
          (points.places.colwise() - points.places.col(chosen[done])).colwise().squaredNorm().transpose());
    Eigen::Index at = 0;
    if (static_cast<Eigen::Index>(chosen.size()) >= most || !(distance.maxCoeff(&at) > 0)) return chosen;
    chosen.push_back(at);
  }
}

double extent(const Eigen::Matrix3Xd& places) {
  if (places.cols() == 0) return 0;
  const Eigen::Index one = farthest(places, 0), other = farthest(places, one);
  return (places.col(other) - places.col(one)).norm();
}

std::vector<Bar> bars_of(const ReducedBody& body) {
  std::vector<Bar> bars;
  const double length = extent(body.nodes);
  std::vector<std::array<int, 2>> lines;
  for (const auto& t : body.triangles)
    for (int k = 0; k < 3; ++k)
      lines.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
  std::sort(lines.begin(), lines.end());
  lines.erase(std::unique(lines.begin(), lines.end()), lines.end());
  if (lines.empty()) lines = body.lines;
  for (const auto& [a, b] : lines) {
    const Eigen::Vector3d along = body.nodes.col(b) - body.nodes.col(a);
    if (along.norm() > 1e-9 * length) bars.push_back({a, b, along.norm(), along.normalized()});
  }
  return bars;
}

MatrixXd difference(const ReducedBody& body, const Bar& bar) {
  return body.node_shapes.middleRows<3>(3 * bar.b) - body.node_shapes.middleRows<3>(3 * bar.a);
}

MatrixXd across(const Bar& bar, const MatrixXd& u) { return u - bar.axis * (bar.axis.transpose() * u); }

VectorXd node_masses(const ReducedBody& body, const std::vector<Bar>& bars) {
  if (body.mesh_inertia && body.mesh_inertia->nodal_mass.rows() == body.nodes.cols())
    return body.mesh_inertia->nodal_mass * VectorXd::Ones(body.nodes.cols());
  VectorXd masses = VectorXd::Zero(body.nodes.cols());
  for (const Bar& bar : bars)
    for (const int node : {bar.a, bar.b}) masses[node] += bar.length;
  return masses * (body.mass / masses.sum());
}

Tree tree_of(const ReducedBody& body, const std::vector<Bar>& bars) {
  const std::size_t count = static_cast<std::size_t>(body.nodes.cols());
  Tree tree{std::vector<int>(count, -1), std::vector<int>(count, -1), {}};
  std::vector<std::vector<int>> at(count);
  for (std::size_t k = 0; k < bars.size(); ++k)
    for (const int node : {bars[k].a, bars[k].b})
      at[static_cast<std::size_t>(node)].push_back(static_cast<int>(k));
  VectorXd motion(body.nodes.cols());
  for (Eigen::Index k = 0; k < motion.size(); ++k) motion[k] = body.node_shapes.middleRows<3>(3 * k).norm();
  const double still = std::max(1e-9 * motion.maxCoeff(), motion.minCoeff());

  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> next;
  std::vector<double> distance(count, std::numeric_limits<double>::infinity());
  for (Eigen::Index k = 0; k < motion.size(); ++k)
    if (motion[k] <= still) {
      distance[static_cast<std::size_t>(k)] = 0;
      next.push({0, static_cast<int>(k)});
    }
  while (!next.empty()) {
    const auto [far, node] = next.top();
    next.pop();
    if (far > distance[static_cast<std::size_t>(node)]) continue;
    tree.order.push_back(node);
    for (const int k : at[static_cast<std::size_t>(node)]) {
      const Bar& bar = bars[static_cast<std::size_t>(k)];
      const int other = bar.a == node ? bar.b : bar.a;
      const std::size_t o = static_cast<std::size_t>(other);
      if (!(far + bar.length < distance[o])) continue;
      distance[o] = far + bar.length;
      tree.bar[o] = k;
      tree.parent[o] = node;
      next.push({distance[o], other});
    }
  }
  return tree;
}

Eigenmodes eigenmodes(const ReducedBody& body) {
  const EigenPairs pairs = symmetric_eigen(body.stiffness, body.mass_matrix);
  const VectorXd& squares = pairs.values;
  Eigen::Index free = 0;
  while (free < squares.size() && !(squares[free] > 1e-12 * squares[squares.size() - 1])) ++free;
  return {pairs.vectors.rightCols(squares.size() - free), squares.tail(squares.size() - free)};
}

namespace {

/// Modes that stand for a series, by increasing frequency: the dynamic ones by their names (static
/// modes hold what loads at the boundary need, however stiff they are), otherwise those of the reduced
/// matrices.
struct Series {
  MatrixXd rows;     ///< squares of their values are twice the modes' energies
  MatrixXd shapes;   ///< modes × count, amplitudes
  VectorXd squares;  ///< ω²
};

Series dynamic_series(const ReducedBody& body) {
  if (body.user_from_modal.rows() == body.modes) {
    const MatrixXd modal_from_user = inverse(body.user_from_modal);
    std::vector<std::pair<double, Eigen::Index>> order;
    for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(body.mode_names.size()); ++k) {
      if (body.mode_names[static_cast<std::size_t>(k)].rfind("dynamic", 0) != 0) continue;
      const VectorXd shape = modal_from_user.col(k);
      order.push_back({shape.dot(body.stiffness * shape) / shape.dot(body.mass_matrix * shape), k});
    }
    std::sort(order.begin(), order.end());
    const Eigen::Index count = static_cast<Eigen::Index>(order.size());
    Series s{MatrixXd(count, body.modes), MatrixXd(body.modes, count), VectorXd(count)};
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto [square, k] = order[static_cast<std::size_t>(i)];
      const VectorXd shape = modal_from_user.col(k);
      s.shapes.col(i) = shape;
      s.rows.row(i) = std::sqrt(shape.dot(body.stiffness * shape)) * body.user_from_modal.row(k);
      s.squares[i] = square;
    }
    if (count > 0) return s;
  }
  const Eigenmodes modes = eigenmodes(body);
  return {modes.squares.cwiseSqrt().asDiagonal() * modes.shapes.transpose() * body.mass_matrix, modes.shapes,
          modes.squares};
}

/// Where a shape moves the body's points: Σ u uᵀ, of norm 1 (or 0 when it moves none).
Eigen::Matrix3d directions(const Points& points, const VectorXd& shape) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (Eigen::Index k = 0; k < points.places.cols(); ++k) {
    const Eigen::Vector3d u = points.shapes.middleRows<3>(3 * k) * shape;
    sum += u * u.transpose();
  }
  const double size = sum.norm();
  if (size > 0) sum /= size;
  return sum;
}

}  // namespace

MatrixXd high_rows(const ReducedBody& body) {
  const Points points = points_of(body);
  const Series series = dynamic_series(body);
  const Eigen::Index count = series.squares.size();
  MatrixXd high(0, body.modes);
  for (Eigen::Index k = count - (count + 2) / 3; k < count; ++k) {
    const Eigen::Matrix3d own = directions(points, series.shapes.col(k));
    bool preceded = false;
    for (Eigen::Index i = 0; i < k && !preceded; ++i)
      preceded = 4 * series.squares[i] <= series.squares[k] &&
                 own.cwiseProduct(directions(points, series.shapes.col(i))).sum() > 0.5;
    if (!preceded) continue;
    high.conservativeResize(high.rows() + 1, body.modes);
    high.bottomRows<1>() = series.rows.row(k);
  }
  return high;
}

MatrixXd root(const MatrixXd& form) {
  const EigenPairs pairs = symmetric_eigen(form);
  const VectorXd& values = pairs.values;
  if (values.size() == 0) return form;
  Eigen::Index first = 0;
  while (first < values.size() && !(values[first] > 1e-14 * values[values.size() - 1])) ++first;
  const Eigen::Index rank = values.size() - first;
  return values.tail(rank).cwiseSqrt().asDiagonal() * pairs.vectors.rightCols(rank).transpose();
}

}  // namespace mimbre::validity
