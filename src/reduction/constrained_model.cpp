#include "reduction/constrained_model.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

#include "math/once/decompositions.h"
#include "reduction/bases/rigid_shapes.h"

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::SparseMatrix;
using Eigen::Vector3d;

/// Row of each node's six dofs, −1: none.
std::vector<std::array<int, 6>> rows_of(const SolidMesh& mesh, const std::vector<Dof>& dofs) {
  std::vector<std::array<int, 6>> rows(static_cast<std::size_t>(mesh.nodes.cols()), {-1, -1, -1, -1, -1, -1});
  for (std::size_t r = 0; r < dofs.size(); ++r)
    rows[static_cast<std::size_t>(dofs[r].node)][static_cast<std::size_t>(dofs[r].direction)] =
        static_cast<int>(r);
  return rows;
}

/// Displacement in `direction` of a place at `arm` from a node that moves with it, by the node's six dofs.
std::array<double, 6> carried(const Vector3d& arm, int direction) {
  std::array<double, 6> factors{};
  factors[static_cast<std::size_t>(direction)] = 1;
  if (direction < 3)
    for (int k = 0; k < 3; ++k)
      factors[static_cast<std::size_t>(3 + k)] = Vector3d(Vector3d::Unit(k)).cross(arm)[direction];
  return factors;
}

void add_rigid(const SolidMesh& mesh, const RigidElement& rigid, const std::vector<std::array<int, 6>>& rows,
               std::vector<Equation>& equations) {
  for (const int node : rigid.nodes) {
    if (node == rigid.reference) continue;
    const Vector3d arm = mesh.nodes.col(node) - mesh.nodes.col(rigid.reference);
    for (int d = 0; d < 6; ++d) {
      if (!rigid.follows[static_cast<std::size_t>(d)] ||
          rows[static_cast<std::size_t>(node)][static_cast<std::size_t>(d)] < 0)
        continue;
      Equation equation{rigid.name, {{node, d, 1}}};
      const auto factors = carried(arm, d);
      for (int k = 0; k < 6; ++k)
        if (factors[static_cast<std::size_t>(k)] != 0)
          equation.terms.push_back({rigid.reference, k, -factors[static_cast<std::size_t>(k)]});
      equations.push_back(std::move(equation));
    }
  }
}

/// The reference's motion z is the rigid one nearest to that of the nodes: z = (Rᵀ w R)⁻¹ Rᵀ w u.
void add_mean(const SolidMesh& mesh, const MeanElement& mean, std::vector<Equation>& equations) {
  const auto count = static_cast<Index>(mean.nodes.size());
  if (count == 0) throw std::invalid_argument(fmt::format("mean element '{}' has no nodes", mean.name));
  MatrixXd R(3 * count, 6), weighted(3 * count, 6);
  double size = 0;
  for (const int node : mean.nodes)
    size = std::max(size, (mesh.nodes.col(node) - mesh.nodes.col(mean.reference)).norm());
  if (size == 0) size = 1;
  for (Index k = 0; k < count; ++k) {
    const int node = mean.nodes[static_cast<std::size_t>(k)];
    const double weight = mean.weights.empty() ? 1 : mean.weights[static_cast<std::size_t>(k)];
    const Vector3d arm = (mesh.nodes.col(node) - mesh.nodes.col(mean.reference)) / size;
    for (int d = 0; d < 3; ++d) {
      const auto factors = carried(arm, d);
      R.row(3 * k + d) = Eigen::Map<const Eigen::RowVectorXd>(factors.data(), 6);
      weighted.row(3 * k + d) = weight * R.row(3 * k + d);
    }
  }
  const MatrixXd normal = weighted.transpose() * R;
  const MatrixXd W = pseudo_inverse(0.5 * (normal + normal.transpose()), 1e-9) * weighted.transpose();
  for (int d = 0; d < 6; ++d) {
    if (!mean.follows[static_cast<std::size_t>(d)]) continue;
    Equation equation{mean.name, {{mean.reference, d, 1}}};
    for (Index k = 0; k < count; ++k)
      for (int j = 0; j < 3; ++j)
        if (const double factor = W(d, 3 * k + j) / (d < 3 ? 1 : size); factor != 0)
          equation.terms.push_back({mean.nodes[static_cast<std::size_t>(k)], j, -factor});
    equations.push_back(std::move(equation));
  }
}

/// Tᵀ M T, lower triangle as M.
SparseMatrix<double> projected(const SparseMatrix<double>& lower, const SparseMatrix<double>& T) {
  SparseMatrix<double> whole = lower.selfadjointView<Eigen::Lower>();
  const SparseMatrix<double> product = T.transpose() * SparseMatrix<double>(whole * T);
  return product.triangularView<Eigen::Lower>();
}

/// Rows of rotations without stiffness, but for round-off.
std::vector<int> loose_rotations(const FeMatrices& matrices) {
  constexpr double nothing = 1e-15;
  const Eigen::VectorXd diagonal = matrices.stiffness.diagonal();
  if (diagonal.size() != static_cast<Index>(matrices.dofs.size())) return {};  // refused later
  double largest = 0;
  for (std::size_t r = 0; r < matrices.dofs.size(); ++r)
    if (matrices.dofs[r].direction >= 3) largest = std::max(largest, diagonal[static_cast<Index>(r)]);
  std::vector<int> rows;
  for (std::size_t r = 0; r < matrices.dofs.size(); ++r)
    if (matrices.dofs[r].direction >= 3 && std::abs(diagonal[static_cast<Index>(r)]) <= nothing * largest)
      rows.push_back(static_cast<int>(r));
  return rows;
}

/// Rows of rotations without mass.
std::vector<Index> massless_rotations(const FeMatrices& matrices) {
  std::vector<Index> rows;
  const Eigen::VectorXd mass = matrices.mass.diagonal();
  // Matrices of other programs stay as they are, and sizes that do not fit are refused later.
  if (!matrices.of_mesh || mass.size() != static_cast<Index>(matrices.dofs.size())) return rows;
  for (Index r = 0; r < mass.size(); ++r)
    if (matrices.dofs[static_cast<std::size_t>(r)].direction >= 3 && mass[r] == 0) rows.push_back(r);
  return rows;
}

/// Bars without mass between nodes of solids turn about themselves: no stiffness and no mass. A trace of the
/// stiffness that their rotations have, by which no frequency changes, keeps the matrices positive.
void keep_positive(FeMatrices& matrices) {
  constexpr double trace = 1e-11;
  for (const Index r : massless_rotations(matrices))
    if (const double own = matrices.stiffness.coeff(r, r); own > 0)
      matrices.stiffness.coeffRef(r, r) += trace * own;
}

/// A loose node of a rigid interface goes with a node of the interface that turns; false: there is none.
bool go_with_interface(const SolidMesh& mesh, const std::vector<std::array<int, 6>>& rows,
                       const Interface& interface, Equation& equation) {
  const int node = equation.terms.front().node;
  const auto turns = [&](int other) {
    const auto& own = rows[static_cast<std::size_t>(other)];
    return other != node && std::all_of(own.begin(), own.end(), [](int row) { return row >= 0; });
  };
  const auto root = std::find_if(interface.nodes.begin(), interface.nodes.end(), turns);
  if (root == interface.nodes.end()) return false;
  std::erase_if(equation.terms, [&](const LinearTerm& term) { return term.node != node; });
  const Vector3d arm = mesh.nodes.col(node) - mesh.nodes.col(*root);
  std::array<double, 6> motion{};
  for (const LinearTerm& term : equation.terms) {
    const auto factors = carried(arm, term.direction);
    for (std::size_t k = 0; k < 6; ++k) motion[k] -= term.factor * factors[k];
  }
  for (int k = 0; k < 6; ++k) equation.terms.push_back({*root, k, motion[static_cast<std::size_t>(k)]});
  return true;
}

/// A sum of displacements by rows.
using Sum = std::map<int, double>;

/// Equations solved one by one for a dof each.
class Elimination {
 public:
  Elimination(const SolidMesh& mesh, const FeMatrices& matrices, const std::vector<Interface>& interfaces)
      : matrices_(matrices),
        rows_(rows_of(mesh, matrices.dofs)),
        interface_of_(matrices.dofs.size(), -1),
        step_(matrices.dofs.size(), -1),
        rigid_(rigid_shapes(mesh, matrices)),
        interfaces_(interfaces) {
    for (std::size_t i = 0; i < interfaces.size(); ++i)
      for (const int node : interfaces[i].nodes)
        if (node >= 0 && node < mesh.nodes.cols())
          for (const int row : rows_[static_cast<std::size_t>(node)])
            if (row >= 0) interface_of_[static_cast<std::size_t>(row)] = static_cast<int>(i);
    size_ = (mesh.nodes.rowwise().maxCoeff() - mesh.nodes.rowwise().minCoeff()).norm();
    if (!(size_ > 0)) size_ = 1;
  }

  void add(const Equation& equation) {
    Sum sum;
    for (const LinearTerm& term : equation.terms) {
      const int row = rows_[static_cast<std::size_t>(term.node)][static_cast<std::size_t>(term.direction)];
      if (row >= 0) sum[row] += term.factor;
    }
    require_free(equation, sum);
    const double scale = largest(sum);
    const int first = equation.terms.empty() ? -1
                                             : rows_[static_cast<std::size_t>(equation.terms[0].node)]
                                                    [static_cast<std::size_t>(equation.terms[0].direction)];
    substitute(sum);
    // What was solved for before is gone; a dependent equation vanishes.
    int pivot = -1;
    double best = 0;
    for (const auto& [row, factor] : sum) {
      const bool own =
          equation.loose && matrices_.dofs[static_cast<std::size_t>(row)].node == equation.terms[0].node;
      if (interface_of_[static_cast<std::size_t>(row)] >= 0 && !own) continue;
      double weight = weight_of(row, factor);
      if (row == first) weight *= 1e6;  // the dependent one of the equation, wherever it can be
      if (weight > best) best = weight, pivot = row;
    }
    constexpr double nothing = 1e-9;
    if (pivot < 0 || !(weight_of(pivot, sum.at(pivot)) > nothing * scale)) {
      if (largest(sum) > nothing * scale) require_within_an_interface(equation, sum, scale);
      return;
    }
    const double factor = sum.at(pivot);
    sum.erase(pivot);
    for (auto& [row, value] : sum) value /= -factor;
    step_[static_cast<std::size_t>(pivot)] = static_cast<int>(solved_.size());
    solved_.push_back({pivot, std::move(sum)});
  }

  FeMatrices result() {
    // Backwards: each depends on what is left and on those solved for after it.
    for (std::size_t k = solved_.size(); k-- > 0;) substitute(solved_[k].second);
    const auto rows = static_cast<Index>(matrices_.dofs.size());
    std::vector<char> needed(matrices_.dofs.size(), 0);
    const auto see = [&](const SparseMatrix<double>& m) {
      for (Index c = 0; c < rows; ++c)
        for (SparseMatrix<double>::InnerIterator it(m, c); it; ++it)
          if (it.value() != 0)
            needed[static_cast<std::size_t>(it.row())] = needed[static_cast<std::size_t>(c)] = 1;
    };
    see(matrices_.stiffness);
    see(matrices_.mass);
    // What a dof depends on is needed where the dof is; backwards again.
    std::vector<char> of_use = needed;
    for (const auto& [row, sum] : solved_)
      if (needed[static_cast<std::size_t>(row)])
        for (const auto& [other, factor] : sum) of_use[static_cast<std::size_t>(other)] = 1;
    std::vector<int> place(matrices_.dofs.size(), -1);
    FeMatrices out;
    for (std::size_t r = 0; r < matrices_.dofs.size(); ++r) {
      if (step_[r] >= 0 || !(of_use[r] || interface_of_[r] >= 0)) continue;
      place[r] = static_cast<int>(out.dofs.size());
      out.dofs.push_back(matrices_.dofs[r]);
    }
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t r = 0; r < place.size(); ++r)
      if (place[r] >= 0) entries.emplace_back(static_cast<int>(r), place[r], 1.0);
    for (const auto& [row, sum] : solved_)
      for (const auto& [other, factor] : sum)
        if (place[static_cast<std::size_t>(other)] >= 0)
          entries.emplace_back(row, place[static_cast<std::size_t>(other)], factor);
    out.expansion.resize(rows, static_cast<Index>(out.dofs.size()));
    out.expansion.setFromTriplets(entries.begin(), entries.end());
    out.all_dofs = matrices_.dofs;
    out.of_mesh = matrices_.of_mesh;
    out.mass = projected(matrices_.mass, out.expansion);
    out.stiffness = projected(matrices_.stiffness, out.expansion);
    return out;
  }

 private:
  /// Rotations count times the size of the body.
  double weight_of(int row, double factor) const {
    return matrices_.dofs[static_cast<std::size_t>(row)].direction < 3 ? std::abs(factor)
                                                                       : std::abs(factor) / size_;
  }
  double largest(const Sum& sum) const {
    double most = 0;
    for (const auto& [row, factor] : sum) most = std::max(most, weight_of(row, factor));
    return most;
  }

  void substitute(Sum& sum) const {
    // Those solved for first come first: what replaces them was not solved for before them.
    while (true) {
      int next = -1;
      for (const auto& [row, factor] : sum)
        if (const int step = step_[static_cast<std::size_t>(row)]; step >= 0 && (next < 0 || step < next))
          next = step;
      if (next < 0) return;
      const auto& [row, replacement] = solved_[static_cast<std::size_t>(next)];
      const double factor = sum.at(row);
      sum.erase(row);
      for (const auto& [other, value] : replacement) sum[other] += factor * value;
    }
  }

  void require_free(const Equation& equation, const Sum& sum) const {
    constexpr double close = 1e-6;
    for (int motion = 0; motion < 6; ++motion) {
      double value = 0, scale = 0;
      for (const auto& [row, factor] : sum) {
        value += factor * rigid_(row, motion);
        scale += weight_of(row, factor) * (motion < 3 ? 1 : size_);
      }
      if (!(std::abs(value) <= close * scale))
        throw std::invalid_argument(
            fmt::format("{} holds the body: a {} of the whole along {} does not satisfy it; a flexible body "
                        "must be free, joints of the mechanism hold it",
                        equation.name, motion < 3 ? "displacement" : "rotation", "xyz"[motion % 3]));
    }
  }

  /// All that is left are dofs of interfaces: nothing new where those of one rigid interface satisfy it.
  void require_within_an_interface(const Equation& equation, const Sum& sum, double scale) const {
    int only = -1;
    for (const auto& [row, factor] : sum) {
      if (!(weight_of(row, factor) > 1e-9 * scale)) continue;
      const int interface = interface_of_[static_cast<std::size_t>(row)];
      if (interface < 0) continue;
      if (only >= 0 && only != interface)
        throw std::invalid_argument(
            fmt::format("{} joins the interfaces '{}' and '{}' rigidly: make one of them", equation.name,
                        interfaces_[static_cast<std::size_t>(only)].name,
                        interfaces_[static_cast<std::size_t>(interface)].name));
      only = interface;
    }
    if (only >= 0 && interfaces_[static_cast<std::size_t>(only)].tie != Interface::Tie::rigid)
      throw std::invalid_argument(fmt::format(
          "{} is an equation among nodes of the mean interface '{}': make the interface rigid, or "
          "select other nodes",
          equation.name, interfaces_[static_cast<std::size_t>(only)].name));
  }

  const FeMatrices& matrices_;
  std::vector<std::array<int, 6>> rows_;
  std::vector<int> interface_of_;
  std::vector<int> step_;  ///< of each row, in which it was solved for; −1: never
  std::vector<std::pair<int, Sum>> solved_;
  MatrixXd rigid_;
  const std::vector<Interface>& interfaces_;
  double size_ = 1;
};

}  // namespace

bool has_constraints(const SolidMesh& mesh) {
  return !mesh.equations.empty() || !mesh.rigid_elements.empty() || !mesh.mean_elements.empty();
}

bool has_loose_rotations(const FeMatrices& matrices) {
  return !loose_rotations(matrices).empty() || !massless_rotations(matrices).empty();
}

std::vector<Equation> all_equations(const SolidMesh& mesh, const std::vector<Dof>& dofs) {
  std::vector<Equation> equations = mesh.equations;
  const auto rows = rows_of(mesh, dofs);
  for (const RigidElement& rigid : mesh.rigid_elements) add_rigid(mesh, rigid, rows, equations);
  for (const MeanElement& mean : mesh.mean_elements) add_mean(mesh, mean, equations);
  return equations;
}

std::vector<Interface> at_references(const SolidMesh& mesh, const std::vector<Interface>& interfaces) {
  std::map<int, int> reference_of;
  for (const RigidElement& rigid : mesh.rigid_elements)
    if (rigid.follows[0] && rigid.follows[1] && rigid.follows[2])
      for (const int node : rigid.nodes)
        if (node != rigid.reference) reference_of.emplace(node, rigid.reference);
  std::vector<Interface> out = interfaces;
  for (Interface& interface : out) {
    for (int& node : interface.nodes)
      // A chain of rigid elements; a circle ends somewhere.
      for (std::size_t step = 0; step < mesh.rigid_elements.size(); ++step)
        if (const auto found = reference_of.find(node); found != reference_of.end()) node = found->second;
    std::vector<int> once;
    for (const int node : interface.nodes)
      if (std::find(once.begin(), once.end(), node) == once.end()) once.push_back(node);
    if (once.size() == interface.nodes.size()) continue;
    interface.nodes = std::move(once);
    if (interface.nodes.size() == 1) interface.tie = Interface::Tie::rigid;
  }
  return out;
}

FeMatrices constrain(const SolidMesh& mesh, const FeMatrices& matrices,
                     const std::vector<Interface>& interfaces, std::vector<Dof>* loose) {
  Elimination elimination(mesh, matrices, interfaces);
  std::vector<const Interface*> rigid_of(static_cast<std::size_t>(mesh.nodes.cols()), nullptr);
  for (const Interface& interface : interfaces)
    for (const int node : interface.nodes)
      if (interface.tie == Interface::Tie::rigid && node >= 0 && node < mesh.nodes.cols())
        rigid_of[static_cast<std::size_t>(node)] = &interface;
  const auto rows_of_nodes = rows_of(mesh, matrices.dofs);
  for (Equation& equation : all_equations(mesh, matrices.dofs)) {
    const Interface* const rigid =
        equation.loose ? rigid_of[static_cast<std::size_t>(equation.terms.front().node)] : nullptr;
    if (!rigid || go_with_interface(mesh, rows_of_nodes, *rigid, equation)) elimination.add(equation);
  }
  FeMatrices result = elimination.result();
  std::vector<char> of_interface(static_cast<std::size_t>(mesh.nodes.cols()), 0);
  for (const Interface& interface : interfaces)
    for (const int node : interface.nodes) of_interface[static_cast<std::size_t>(node)] = 1;
  const std::vector<int> rows = loose_rotations(result);
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<Dof> kept;
  std::size_t next = 0;
  for (std::size_t r = 0; r < result.dofs.size(); ++r) {
    const Dof& dof = result.dofs[r];
    const bool is_loose = next < rows.size() && static_cast<std::size_t>(rows[next]) == r;
    next += is_loose ? 1 : 0;
    if (is_loose && !of_interface[static_cast<std::size_t>(dof.node)]) {
      if (loose) loose->push_back(dof);
      continue;
    }
    entries.emplace_back(static_cast<int>(r), static_cast<int>(kept.size()), 1.0);
    kept.push_back(dof);
  }
  if (kept.size() == result.dofs.size()) {
    keep_positive(result);
    return result;
  }
  SparseMatrix<double> choice(static_cast<Index>(result.dofs.size()), static_cast<Index>(kept.size()));
  choice.setFromTriplets(entries.begin(), entries.end());
  result.expansion = SparseMatrix<double>(result.expansion * choice);
  result.mass = projected(result.mass, choice);
  result.stiffness = projected(result.stiffness, choice);
  result.dofs = std::move(kept);
  keep_positive(result);
  return result;
}

}  // namespace mimbre::fe
