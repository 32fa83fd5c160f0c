#include "reduction/bases/craig_bampton.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <stdexcept>

#include "fe/elements/beam_element.h"
#include "fe/rigid_motion.h"
#include "fe/solve/lowest_modes.h"

namespace mimbre::fe {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

constexpr double kOrthogonality = 1e-6;  // directions given as rounded numbers pass

/// Where one node's three translations or rotations go: orthonormal axes, the boundary directions first, then
/// the fixed ones.
struct NodeAxes {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  std::vector<int> boundary;    ///< index of the boundary dof along the first axes
  std::array<bool, 3> fixed{};  ///< body axes along which nothing moves
  int retained_or_fixed = 0;    ///< how many of the axes are boundary or fixed ones
};

std::string describe(const BoundaryDof& dof) {
  if (!dof.name.empty()) return dof.name;
  return fmt::format("node {} {} ({:g} {:g} {:g})", dof.node, dof.rotation ? "about" : "along",
                     dof.direction.x(), dof.direction.y(), dof.direction.z());
}

void add_boundary(NodeAxes& node, const std::vector<BoundaryDof>& boundary, int index) {
  const BoundaryDof& dof = boundary[index];
  const double length = dof.direction.norm();
  if (!(std::isfinite(length) && length > 0))
    throw std::invalid_argument(fmt::format("boundary dof '{}': its direction has no length", describe(dof)));
  Eigen::Vector3d direction = dof.direction / length;
  for (int k = 0; k < static_cast<int>(node.boundary.size()); ++k) {
    const double along = direction.dot(node.axes.col(k));
    if (std::abs(along) > kOrthogonality)
      throw std::invalid_argument(fmt::format(
          "boundary dofs '{}' and '{}' of node {} are dependent: their directions must be orthogonal",
          describe(boundary[node.boundary[k]]), describe(dof), dof.node));
    direction -= along * node.axes.col(k);
  }
  node.axes.col(static_cast<Eigen::Index>(node.boundary.size())) = direction.normalized();
  node.boundary.push_back(index);
}

/// Fills the axes that no boundary dof takes: the fixed ones, then any so that all three are orthonormal.
void complete(NodeAxes& node, const std::vector<BoundaryDof>& boundary) {
  int taken = static_cast<int>(node.boundary.size());
  for (int k = 0; k < 3; ++k) {
    if (!node.fixed[k]) continue;
    for (std::size_t b = 0; b < node.boundary.size(); ++b)
      if (std::abs(node.axes(k, static_cast<Eigen::Index>(b))) > kOrthogonality)
        throw std::invalid_argument(fmt::format("boundary dof '{}': node {} is fixed in that direction",
                                                describe(boundary[node.boundary[b]]),
                                                boundary[node.boundary[b]].node));
    node.axes.col(taken++) = Eigen::Vector3d::Unit(k);
  }
  node.retained_or_fixed = taken;
  if (taken == 0) node.axes.setIdentity();
  if (taken == 1) node.axes.col(1) = node.axes.col(0).unitOrthogonal();
  if (taken == 1 || taken == 2) node.axes.col(2) = node.axes.col(0).cross(node.axes.col(1));
}

/// Orthonormal columns that split the mesh's dofs.
struct Partition {
  Eigen::SparseMatrix<double> boundary;
  Eigen::SparseMatrix<double> internal;
  Eigen::SparseMatrix<double> held;  ///< clamped, fixed and boundary together: what Kii has fixed
};

Eigen::SparseMatrix<double> sparse(Eigen::Index rows, Eigen::Index columns, const Triplets& triplets) {
  Eigen::SparseMatrix<double> matrix(rows, columns);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

void add_column(Triplets& triplets, int first_row, int column, const Eigen::Vector3d& direction) {
  for (int k = 0; k < 3; ++k)
    if (direction[k] != 0) triplets.emplace_back(first_row + k, column, direction[k]);
}

std::vector<bool> clamped_flags(int nodes, const std::vector<int>& clamped) {
  if (clamped.empty())
    throw std::invalid_argument(
        "no node is clamped: the tangent frame needs at least one that moves with the body frame");
  std::vector<bool> flags(nodes, false);
  for (int node : clamped) {
    if (node < 0 || node >= nodes)
      throw std::invalid_argument(
          fmt::format("clamped node {} does not exist, the mesh has {} nodes", node, nodes));
    flags[node] = true;
  }
  return flags;
}

Partition partition(const Mesh& mesh, const ReductionOptions& options) {
  const int nodes = static_cast<int>(mesh.nodes.cols());
  const std::vector<bool> clamped = clamped_flags(nodes, options.clamped_nodes);

  std::vector<std::array<NodeAxes, 2>> axes(nodes);  // of translations and rotations
  for (int b = 0; b < static_cast<int>(options.boundary.size()); ++b) {
    const BoundaryDof& dof = options.boundary[b];
    if (dof.node < 0 || dof.node >= nodes)
      throw std::invalid_argument(
          fmt::format("boundary dof '{}': node {} does not exist, the mesh has {} nodes", describe(dof),
                      dof.node, nodes));
    if (clamped[dof.node])
      throw std::invalid_argument(
          fmt::format("boundary dof '{}': node {} is clamped and cannot move", describe(dof), dof.node));
    add_boundary(axes[dof.node][dof.rotation ? 1 : 0], options.boundary, b);
  }

  for (const int dof : options.fixed_dofs) {
    if (dof < 0 || dof >= 6 * nodes)
      throw std::invalid_argument(
          fmt::format("fixed dof {} does not exist, the mesh has {} nodes", dof, nodes));
    axes[dof / 6][dof % 6 / 3].fixed[dof % 3] = true;
  }

  Triplets boundary;
  Triplets internal;
  Triplets held;
  int internals = 0;
  int helds = 0;
  for (int node = 0; node < nodes; ++node) {
    for (int kind = 0; kind < 2; ++kind) {
      NodeAxes& at = axes[node][kind];
      complete(at, options.boundary);
      const int row = 6 * node + 3 * kind;
      const int retained = static_cast<int>(at.boundary.size());
      for (int k = 0; k < 3; ++k) {
        if (k < retained) add_column(boundary, row, at.boundary[k], at.axes.col(k));
        if (k < at.retained_or_fixed || clamped[node])
          add_column(held, row, helds++, at.axes.col(k));
        else
          add_column(internal, row, internals++, at.axes.col(k));
      }
    }
  }
  const Eigen::Index dofs = 6 * nodes;
  return {sparse(dofs, static_cast<Eigen::Index>(options.boundary.size()), boundary),
          sparse(dofs, internals, internal), sparse(dofs, helds, held)};
}

Eigen::MatrixXd symmetric(const Eigen::MatrixXd& matrix) { return 0.5 * (matrix + matrix.transpose()); }

/// Directions along the bars at every node that is neither clamped nor a boundary along them.
Eigen::SparseMatrix<double> axial_dofs(const Mesh& mesh, const ReductionOptions& options) {
  const Eigen::Vector3d axis = element_geometry(mesh, 0).axes.col(0);
  for (int e = 1; e < static_cast<int>(mesh.elements.size()); ++e)
    if (element_geometry(mesh, e).axes.col(0).cross(axis).norm() > kOrthogonality)
      throw std::invalid_argument("axial dynamic modes need bars that are all along one line");
  std::vector<bool> held = clamped_flags(static_cast<int>(mesh.nodes.cols()), options.clamped_nodes);
  for (const BoundaryDof& dof : options.boundary)
    if (!dof.rotation && std::abs(dof.direction.normalized().dot(axis)) > kOrthogonality)
      held[dof.node] = true;
  Triplets triplets;
  int columns = 0;
  for (int node = 0; node < mesh.nodes.cols(); ++node)
    if (!held[node]) add_column(triplets, 6 * node, columns++, axis);
  return sparse(6 * mesh.nodes.cols(), columns, triplets);
}

/// Adds the lowest fixed-interface modes that only stretch.
void add_axial_modes(const Mesh& mesh, const Matrices& matrices, const ReductionOptions& options,
                     Basis& basis) {
  const Eigen::SparseMatrix<double> along = axial_dofs(mesh, options);
  const int count = options.axial_dynamic_modes;
  if (count > along.cols())
    throw std::invalid_argument(
        fmt::format("{} axial modes asked of a mesh with {} free nodes", count, along.cols()));
  const Eigen::SparseMatrix<double> K = along.transpose() * matrices.stiffness * along;
  const Eigen::SparseMatrix<double> M = along.transpose() * matrices.mass * along;
  const Modes modes = lowest_modes(M, count, 0, SymmetricSolver(K));
  const Eigen::Index before = basis.shapes.cols();
  basis.shapes.conservativeResize(Eigen::NoChange, before + count);
  basis.shapes.rightCols(count) = along * modes.vectors;
  const Eigen::MatrixXd stiffness = basis.shapes.transpose() * (matrices.stiffness * basis.shapes);
  const Eigen::MatrixXd linear = basis.stiffness;
  basis.stiffness = symmetric(stiffness);
  basis.stiffness.topLeftCorner(before, before) = linear;
  for (int k = 0; k < count; ++k) basis.names.push_back(fmt::format("axial {}", k + 1));
}

}  // namespace

Basis craig_bampton(const Mesh& mesh, const Matrices& matrices, const ReductionOptions& options,
                    const Eigen::MatrixXd& loads) {
  const Partition dofs = partition(mesh, options);
  const Eigen::Index internals = dofs.internal.cols();
  if (options.dynamic_modes < 0 || options.dynamic_modes > internals)
    throw std::invalid_argument(fmt::format("{} dynamic modes asked of a mesh with {} internal dofs",
                                            options.dynamic_modes, internals));
  if (const RigidMotions free = free_rigid_motions(mesh, dofs.held); free.count > 0)
    throw std::invalid_argument(
        fmt::format("the internal stiffness is singular: the part of the mesh with node {} is not held by "
                    "clamped nodes and "
                    "boundary dofs",
                    free.node));

  Basis basis;
  for (const BoundaryDof& dof : options.boundary) basis.names.push_back("static " + describe(dof));
  for (int k = 0; k < options.dynamic_modes; ++k) basis.names.push_back(fmt::format("dynamic {}", k + 1));

  // (2.7): static modes [I; −Kii⁻¹ Kib]
  const Eigen::Index statics = dofs.boundary.cols();
  basis.shapes.resize(matrices.stiffness.rows(), statics + options.dynamic_modes);
  basis.shapes.leftCols(statics) = dofs.boundary;
  basis.stiffness.setZero(basis.shapes.cols(), basis.shapes.cols());
  basis.responses.setZero(matrices.stiffness.rows(), loads.cols());
  if (internals > 0) {
    const Eigen::SparseMatrix<double> Kii = dofs.internal.transpose() * matrices.stiffness * dofs.internal;
    const Eigen::SparseMatrix<double> Mii = dofs.internal.transpose() * matrices.mass * dofs.internal;
    const SymmetricSolver factor(Kii);
    if (!factor.ok()) throw std::invalid_argument("the internal stiffness is singular to working precision");
    if (statics > 0) {
      const Eigen::MatrixXd Kib = (dofs.internal.transpose() * matrices.stiffness * dofs.boundary).toDense();
      basis.shapes.leftCols(statics) -= dofs.internal * factor.solve(Kib).eval();
    }
    if (loads.cols() > 0)
      basis.responses = dofs.internal * factor.solve((dofs.internal.transpose() * loads).eval()).eval();
    // (2.8): dynamic modes, the boundary fixed
    const Modes modes = lowest_modes(Mii, options.dynamic_modes, 0, factor);
    basis.shapes.rightCols(options.dynamic_modes) = dofs.internal * modes.vectors;
    basis.stiffness.diagonal().tail(options.dynamic_modes) = modes.eigenvalues;
  }
  // (2.95): the coupling of static and dynamic modes vanishes. Energy form: errors of the shapes enter
  // squared.
  const auto static_shapes = basis.shapes.leftCols(statics);
  basis.stiffness.topLeftCorner(statics, statics) =
      symmetric(static_shapes.transpose() * (matrices.stiffness * static_shapes));
  if (options.axial_dynamic_modes > 0) add_axial_modes(mesh, matrices, options, basis);
  return basis;
}

}  // namespace mimbre::fe
