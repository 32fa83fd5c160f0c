#include "reduction/nodal_shape_integrals.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace mimbre::fe {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

/// Every third row, from `component` on.
Eigen::MatrixXd component_rows(const Eigen::MatrixXd& rows, int component) {
  Eigen::MatrixXd out(rows.rows() / 3, rows.cols());
  for (Eigen::Index k = 0; k < out.rows(); ++k) out.row(k) = rows.row(3 * k + component);
  return out;
}

}  // namespace

Sparse nodal_mass(const Sparse& translational_mass) {
  const Sparse& M = translational_mass;
  if (M.rows() != M.cols() || M.rows() % 3 != 0)
    throw std::invalid_argument(fmt::format(
        "a translational mass matrix must have three dofs per node, is {} x {}", M.rows(), M.cols()));
  std::vector<Eigen::Triplet<double>> entries, off;
  double largest = 0;
  for (int c = 0; c < M.outerSize(); ++c)
    for (Sparse::InnerIterator it(M, c); it; ++it) {
      const int row = static_cast<int>(it.row());
      largest = std::max(largest, std::abs(it.value()));
      if (row % 3 == c % 3) entries.emplace_back(row / 3, c / 3, it.value() / 3);
      // What must vanish: couplings of components, and differences of the diagonal.
      off.emplace_back(row, c, it.value());
    }
  Sparse nodal(M.rows() / 3, M.cols() / 3);
  nodal.setFromTriplets(entries.begin(), entries.end());
  for (int c = 0; c < nodal.outerSize(); ++c)
    for (Sparse::InnerIterator it(nodal, c); it; ++it)
      for (int k = 0; k < 3; ++k)
        off.emplace_back(static_cast<int>(3 * it.row() + k), 3 * c + k, -it.value());
  Sparse rest(M.rows(), M.cols());
  rest.setFromTriplets(off.begin(), off.end());
  for (int c = 0; c < rest.outerSize(); ++c)
    for (Sparse::InnerIterator it(rest, c); it; ++it)
      if (!(std::abs(it.value()) <= 1e-6 * largest))
        throw std::invalid_argument(
            fmt::format("the mass of nodes {} and {} is not the same in all directions: shape integrals need "
                        "isoparametric elements",
                        it.row() / 3, c / 3));
  return nodal;
}

void add_shape_integrals(const Eigen::Matrix3Xd& nodes, const Sparse& nodal_mass,
                         const Eigen::MatrixXd& node_shapes, ReducedBody& body) {
  if (nodal_mass.rows() != nodes.cols() || nodal_mass.cols() != nodes.cols() ||
      node_shapes.rows() != 3 * nodes.cols())
    throw std::invalid_argument(fmt::format(
        "{} nodes need a mass matrix of that size, not {} x {}, and {} rows of shapes, not {}", nodes.cols(),
        nodal_mass.rows(), nodal_mass.cols(), 3 * nodes.cols(), node_shapes.rows()));
  std::array<Eigen::MatrixXd, 3> X, weighted;  // nodes × modes
  for (std::size_t i = 0; i < 3; ++i) {
    X[i] = component_rows(node_shapes, static_cast<int>(i));
    weighted[i] = nodal_mass * X[i];
  }
  const Eigen::MatrixXd positions = nodal_mass * nodes.transpose();  // nodes × 3
  // Entry by entry: Eigen sums a sparse matrix in an order that depends on where its memory begins.
  body.mass = 0;
  for (int c = 0; c < nodal_mass.outerSize(); ++c)
    for (Sparse::InnerIterator it(nodal_mass, c); it; ++it) body.mass += it.value();
  body.first_moment = positions.colwise().sum();
  const Eigen::Matrix3d second = nodes * positions;
  body.second_moment = 0.5 * (second + second.transpose());
  body.S.resize(3, node_shapes.cols());
  for (int j = 0; j < 3; ++j) body.S.row(j) = weighted[static_cast<std::size_t>(j)].colwise().sum();
  for (std::size_t i = 0; i < 3; ++i) {
    body.S_position[i].resize(3, node_shapes.cols());
    for (std::size_t j = 0; j < 3; ++j) {
      body.S_position[i].row(static_cast<int>(j)) = nodes.row(static_cast<int>(i)) * weighted[j];
      if (j < i)
        body.S_modes[i][j] = body.S_modes[j][i].transpose();
      else
        body.S_modes[i][j] = X[i].transpose() * weighted[j];
    }
    body.S_modes[i][i] = (0.5 * (body.S_modes[i][i] + body.S_modes[i][i].transpose())).eval();
  }
}

}  // namespace mimbre::fe
