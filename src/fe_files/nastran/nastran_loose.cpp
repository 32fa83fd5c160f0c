#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <queue>

#include "fe_files/nastran/nastran_build.h"
#include "math/once/decompositions.h"

// Nastran holds what nothing resists to the ground (AUTOSPC). A body has no ground: a node that rods, springs
// or equations hold in some directions only goes with the body in the others, as if rigid.

namespace mimbre::fe {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// What holds each node.
struct Holds {
  explicit Holds(const SolidMesh& mesh) {
    const auto count = static_cast<std::size_t>(mesh.nodes.cols());
    supported.assign(count, 0);
    stiffness.assign(count, Matrix3d::Zero());
    tied.assign(count, Matrix3d::Zero());
    neighbours.resize(count);
    const auto hold = [&](int node) { supported[static_cast<std::size_t>(node)] = 1; };
    for (const ElementGroup& group : mesh.groups)
      for (const int node : group.nodes) hold(node);
    for (const BeamElement& beam : mesh.beams)
      for (const int node : beam.nodes) hold(node);
    for (const RigidElement& rigid : mesh.rigid_elements) {
      hold(rigid.reference);
      for (const int node : rigid.nodes) hold(node);
    }
    for (const MeanElement& mean : mesh.mean_elements) {
      hold(mean.reference);
      for (const int node : mean.nodes) hold(node);
    }
    for (const Equation& equation : mesh.equations) {
      double largest = 0;
      for (const LinearTerm& term : equation.terms)
        if (term.direction < 3) largest = std::max(largest, std::abs(term.factor));
      join(equation.terms, largest > 0 ? 1 / (largest * largest) : 0, tied);
    }
    for (const Spring& spring : mesh.springs) join(spring.stretch, spring.stiffness, stiffness);
  }

  /// Directions in which nothing holds the node.
  std::vector<Vector3d> loose(int node) const {
    constexpr double nothing = 1e-9;
    const auto k = static_cast<std::size_t>(node);
    // Springs and equations have no scale in common.
    const auto scaled = [](const Matrix3d& m) { return Matrix3d(m.trace() > 0 ? m / m.trace() : m); };
    const EigenPairs pairs = symmetric_eigen(scaled(stiffness[k]) + scaled(tied[k]));
    std::vector<Vector3d> directions;
    for (int i = 0; i < 3; ++i)
      if (!(pairs.values[i] > nothing * pairs.values[2])) directions.push_back(pairs.vectors.col(i));
    return directions;
  }

  std::vector<char> supported;      ///< by elements
  std::vector<Matrix3d> stiffness;  ///< against displacement, by springs
  std::vector<Matrix3d> tied;       ///< squares of the factors of displacements in equations
  std::vector<std::vector<int>> neighbours;

 private:
  void join(const std::vector<LinearTerm>& terms, double weight, std::vector<Matrix3d>& sums) {
    std::map<int, Vector3d> parts;
    for (const LinearTerm& term : terms) {
      const auto [part, is_new] = parts.try_emplace(term.node, Vector3d::Zero());
      if (term.direction < 3) part->second[term.direction] += term.factor;
    }
    for (const auto& [node, part] : parts) {
      sums[static_cast<std::size_t>(node)] += weight * part * part.transpose();
      for (const auto& [other, unused] : parts)
        if (other != node) neighbours[static_cast<std::size_t>(node)].push_back(other);
    }
  }
};

/// For each node the nearest one along springs that elements hold and turn, −1: none. One search from all
/// of these at once.
std::vector<int> nearest_turning(const NastranBuild& build, const Holds& holds) {
  std::vector<int> root(holds.supported.size(), -1);
  std::queue<int> next;
  for (std::size_t k = 0; k < root.size(); ++k)
    if (holds.supported[k] && build.rotates[k]) {
      root[k] = static_cast<int>(k);
      next.push(root[k]);
    }
  while (!next.empty()) {
    const auto node = static_cast<std::size_t>(next.front());
    next.pop();
    for (const int other : holds.neighbours[node])
      if (int& its = root[static_cast<std::size_t>(other)]; its < 0) {
        its = root[node];
        next.push(other);
      }
  }
  return root;
}

/// A row of equations: the node's displacement along each direction is that of a rigid part of `root`.
void follow(NastranBuild& build, int node, int root, const std::vector<Vector3d>& directions) {
  for (const Vector3d& direction : directions) {
    std::vector<LinearTerm> terms;
    NastranBuild::add_translation(node, direction, Vector3d::Zero(), 1, terms);
    NastranBuild::add_translation(root, direction, build.at(node) - build.at(root), -1, terms);
    build.tidy(terms, true);
    std::erase_if(terms, [&](const LinearTerm& term) { return term.node == node && term.direction >= 3; });
    // The first term is the one that is eliminated: of the node, the largest.
    auto largest = terms.begin();
    for (auto term = terms.begin(); term != terms.end(); ++term)
      if (term->node == node && std::abs(term->factor) > std::abs(largest->factor)) largest = term;
    std::iter_swap(terms.begin(), largest);
    const auto label = [&](int k) { return build.mesh.labels[static_cast<std::size_t>(k)]; };
    build.mesh.equations.push_back(
        {fmt::format("node {}, which follows node {},", label(node), label(root)), std::move(terms), true});
  }
}

}  // namespace

void settle_nastran_loose_nodes(NastranBuild& build) {
  SolidMesh& mesh = build.mesh;
  NastranModel& model = build.model;
  const Mark mark{model.files.empty() ? std::string() : model.files.front(), 0, 0};
  const Holds holds(mesh);
  const auto alone = [&](int node) {
    const auto k = static_cast<std::size_t>(node);
    return !holds.supported[k] && holds.neighbours[k].empty();
  };
  double lost = 0;
  std::int64_t first = 0;
  for (const PointMass& point : mesh.point_masses)
    if (alone(point.node)) {
      if (lost == 0) first = mesh.labels[static_cast<std::size_t>(point.node)];
      lost += point.mass;
    }
  if (lost > 0 && mesh.point_masses.size() > 1) {
    model.warn("mass alone", mark,
               fmt::format("masses of {:.6g} hang on nodes without elements and are left out, the first at "
                           "node {}",
                           lost, first));
    std::erase_if(mesh.point_masses, [&](const PointMass& point) { return alone(point.node); });
  }
  const std::vector<int> nearest = nearest_turning(build, holds);
  std::size_t settled = 0;
  for (int node = 0; node < static_cast<int>(holds.supported.size()); ++node) {
    const auto k = static_cast<std::size_t>(node);
    if (holds.supported[k] || holds.neighbours[k].empty()) continue;
    const std::vector<Vector3d> loose = holds.loose(node);
    const int root = loose.empty() ? -1 : nearest[k];
    if (root < 0) continue;
    follow(build, node, root, loose);
    if (settled++ == 0)
      model.warn(
          "loose", mark,
          fmt::format(
              "rods, springs and equations alone do not hold node {} in all directions; in the others it "
              "goes with node {} as if rigid",
              mesh.labels[k], mesh.labels[static_cast<std::size_t>(root)]));
  }
}

}  // namespace mimbre::fe
