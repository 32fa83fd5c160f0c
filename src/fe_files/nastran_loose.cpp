#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <queue>

#include "fe_files/nastran_build.h"
#include "math/decompositions.h"

// Nastran holds what nothing resists to the ground (AUTOSPC). A body has no ground: what rods hold along
// their length alone goes with the body as if it were stiff.

namespace mimbre::fe {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// What holds each node.
struct Holds {
  explicit Holds(const SolidMesh& mesh) {
    const auto count = static_cast<std::size_t>(mesh.nodes.cols());
    firm.assign(count, 0);
    stiffness.assign(count, Matrix3d::Zero());
    neighbours.resize(count);
    const auto hold = [&](int node) { firm[static_cast<std::size_t>(node)] = 1; };
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
    for (const Equation& equation : mesh.equations)
      for (const LinearTerm& term : equation.terms) hold(term.node);
    for (const Spring& spring : mesh.springs) {
      std::map<int, Vector3d> parts;
      for (const LinearTerm& term : spring.stretch) {
        const auto [part, is_new] = parts.try_emplace(term.node, Vector3d::Zero());
        if (term.direction < 3) part->second[term.direction] += term.factor;
      }
      for (const auto& [node, part] : parts) {
        stiffness[static_cast<std::size_t>(node)] += spring.stiffness * part * part.transpose();
        for (const auto& [other, unused] : parts)
          if (other != node) neighbours[static_cast<std::size_t>(node)].push_back(other);
      }
    }
  }

  std::vector<char> firm;           ///< by more than springs
  std::vector<Matrix3d> stiffness;  ///< against displacement, by springs
  std::vector<std::vector<int>> neighbours;
};

/// The nearest node along springs that elements hold and turn, −1: none.
int nearest_turning(const NastranBuild& build, const Holds& holds, int from) {
  std::vector<char> seen(holds.firm.size(), 0);
  std::queue<int> next({from});
  seen[static_cast<std::size_t>(from)] = 1;
  while (!next.empty()) {
    const int node = next.front();
    next.pop();
    if (holds.firm[static_cast<std::size_t>(node)] && build.rotates[static_cast<std::size_t>(node)])
      return node;
    for (const int other : holds.neighbours[static_cast<std::size_t>(node)])
      if (!seen[static_cast<std::size_t>(other)]) {
        seen[static_cast<std::size_t>(other)] = 1;
        next.push(other);
      }
  }
  return -1;
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
    build.mesh.equations.push_back({"what rods hold along their length alone", std::move(terms)});
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
    return !holds.firm[k] && holds.neighbours[k].empty();
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
  constexpr double nothing = 1e-9;
  std::size_t settled = 0;
  for (int node = 0; node < static_cast<int>(holds.firm.size()); ++node) {
    const auto k = static_cast<std::size_t>(node);
    if (holds.firm[k] || holds.neighbours[k].empty()) continue;
    const EigenPairs pairs = symmetric_eigen(holds.stiffness[k]);
    std::vector<Vector3d> loose;
    for (int i = 0; i < 3; ++i)
      if (!(pairs.values[i] > nothing * pairs.values[2])) loose.push_back(pairs.vectors.col(i));
    const int root = loose.empty() ? -1 : nearest_turning(build, holds, node);
    if (root < 0) continue;
    follow(build, node, root, loose);
    if (settled++ == 0)
      model.warn("loose", mark,
                 fmt::format("rods and springs alone do not hold node {} in all directions; in the others it "
                             "goes with node {} as if rigid",
                             mesh.labels[k], mesh.labels[static_cast<std::size_t>(root)]));
  }
}

}  // namespace mimbre::fe
