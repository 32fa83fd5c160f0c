#include <fmt/format.h>

#include <Eigen/SparseCore>
#include <algorithm>
#include <set>
#include <stdexcept>

#include "compile/compiled.h"
#include "dynamics/projection.h"
#include "mimbre/diagnostics.h"
#include "mimbre/reduced_body.h"

namespace mimbre::projection {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Kind = Constants::Kind;

constexpr int pad_to(int n, int multiple) { return (n + multiple - 1) / multiple * multiple; }

/// M* and Φ of the dofs that take part, with `width` (3 or 6) dofs per node.
struct Mesh {
  int nodes = 0, width = 0;
  Sparse mass;
  Eigen::MatrixXd shapes;
  Eigen::Index dof(int node, int k) const { return static_cast<Eigen::Index>(width) * node + k; }
};

Sparse three_times(const Sparse& nodal) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int c = 0; c < nodal.outerSize(); ++c)
    for (Sparse::InnerIterator it(nodal, c); it; ++it)
      for (int k = 0; k < 3; ++k)
        entries.emplace_back(static_cast<int>(3 * it.row() + k), 3 * c + k, it.value());
  Sparse out(3 * nodal.rows(), 3 * nodal.cols());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

Mesh used_part(const ReducedBody& body, bool rotations) {
  const MeshInertia& given = *body.mesh_inertia;
  const Eigen::MatrixXd& shapes = body.second_order ? body.second_order->mesh_shapes : given.shapes;
  Mesh mesh;
  mesh.nodes = static_cast<int>(body.nodes.cols());
  if (rotations || given.dofs_per_node == 3) {
    mesh.width = given.dofs_per_node;
    mesh.mass = given.mass;
    mesh.shapes = shapes;
    return mesh;
  }
  mesh.width = 3;
  mesh.shapes.resize(3 * body.nodes.cols(), shapes.cols());
  for (int k = 0; k < mesh.nodes; ++k)
    mesh.shapes.middleRows<3>(3 * k) = shapes.middleRows<3>(6 * static_cast<Eigen::Index>(k));
  if (given.nodal_mass.size() > 0) {
    mesh.mass = three_times(given.nodal_mass);
    return mesh;
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (int c = 0; c < given.mass.outerSize(); ++c)
    for (Sparse::InnerIterator it(given.mass, c); it; ++it)
      if (c % 6 < 3 && it.row() % 6 < 3)
        entries.emplace_back(static_cast<int>(it.row() / 6 * 3 + it.row() % 6), c / 6 * 3 + c % 6,
                             it.value());
  mesh.mass.resize(3 * body.nodes.cols(), 3 * body.nodes.cols());
  mesh.mass.setFromTriplets(entries.begin(), entries.end());
  return mesh;
}

/// Blocks of node k with its neighbours, as they stand in M*.
using Block = Eigen::Matrix<double, 6, 6>;
std::vector<std::pair<int, Block>> row_of_blocks(const Mesh& mesh, int k) {
  std::set<int> neighbours{k};
  for (int a = 0; a < mesh.width; ++a)
    for (Sparse::InnerIterator it(mesh.mass, mesh.dof(k, a)); it; ++it)
      neighbours.insert(static_cast<int>(it.row()) / mesh.width);
  std::vector<std::pair<int, Block>> row;
  for (int l : neighbours) row.emplace_back(l, Block::Zero());
  for (int a = 0; a < mesh.width; ++a)
    for (Sparse::InnerIterator it(mesh.mass, mesh.dof(k, a)); it; ++it) {
      const int l = static_cast<int>(it.row()) / mesh.width, b = static_cast<int>(it.row()) % mesh.width;
      const auto at = std::lower_bound(row.begin(), row.end(), l,
                                       [](const auto& entry, int node) { return entry.first < node; });
      at->second(a, b) = it.value();  // symmetric: the column of k is its row
    }
  return row;
}

void append_columns(Values& values, const Eigen::Ref<const Eigen::MatrixXd>& block) {
  for (Eigen::Index c = 0; c < block.cols(); ++c) {
    for (Eigen::Index r = 0; r < 3; ++r) values.push_back(block(r, c));
    values.push_back(0);
  }
}

/// All blocks are multiples of the identity.
bool isotropic(const Mesh& mesh) {
  if (mesh.width != 3) return false;
  double largest = 0, other = 0;
  for (int k = 0; k < mesh.nodes; ++k)
    for (const auto& [l, block] : row_of_blocks(mesh, k)) {
      const Mat3d b = block.topLeftCorner<3, 3>();
      largest = std::max(largest, b.cwiseAbs().maxCoeff());
      other = std::max(other, (b - b(0, 0) * Mat3d::Identity()).cwiseAbs().maxCoeff());
    }
  return other <= 1e-14 * largest;
}

void add_blocks(const Mesh& mesh, Constants& c) {
  c.kind = mesh.width == 6 ? Kind::full : isotropic(mesh) ? Kind::scalar : Kind::translations;
  double off = 0, largest = 0, largest_mixed = 0;
  for (int k = 0; k < mesh.nodes; ++k) {
    c.row_start.push_back(static_cast<int>(c.column.size()));
    Block sum = Block::Zero();
    for (const auto& [l, block] : row_of_blocks(mesh, k)) {
      if (l == k) c.diagonal.push_back(static_cast<int>(c.column.size()));
      c.column.push_back(l);
      if (c.kind == Kind::scalar)
        c.blocks.push_back(block(0, 0));
      else
        append_columns(c.blocks, block.topLeftCorner(3, mesh.width));
      sum += block;
    }
    append_columns(c.sums, sum.topLeftCorner<3, 3>().transpose());
    append_columns(c.sums, sum.topRightCorner<3, 3>().transpose());
    append_columns(c.sums, sum.bottomRightCorner<3, 3>().transpose());
    c.translation += sum.topLeftCorner<3, 3>();
    c.mixed += sum.topRightCorner<3, 3>();
    c.rotation += sum.bottomRightCorner<3, 3>();
    const Mat3d node = sum.topLeftCorner<3, 3>();
    off = std::max(off, (node - node(0, 0) * Mat3d::Identity()).cwiseAbs().maxCoeff());
    largest = std::max(largest, node.cwiseAbs().maxCoeff());
    largest_mixed = std::max(largest_mixed, sum.topRightCorner<3, 3>().cwiseAbs().maxCoeff());
  }
  c.row_start.push_back(static_cast<int>(c.column.size()));
  c.total_mass = c.translation.trace() / 3;
  const Mat3d symmetric = c.mixed + c.mixed.transpose();
  c.plain = off <= 1e-8 * largest && symmetric.cwiseAbs().maxCoeff() <= 1e-8 * largest_mixed;
}

}  // namespace

Constants constants(const ReducedBody& body, bool rotations) {
  if (!body.mesh_inertia)
    throw std::invalid_argument(fmt::format("reduced body '{}' has no mesh inertia", body.name));
  const Mesh mesh = used_part(body, rotations);
  Constants c;
  c.nodes = mesh.nodes;
  c.modes = static_cast<int>(mesh.shapes.cols());
  c.stride = pad_to(c.modes, 8);
  c.rotations = mesh.width == 6;
  add_blocks(mesh, c);

  const auto translation = [&](int i) { return mesh.dof(i / 3, i % 3); };
  const auto rotation = [&](int i) { return mesh.dof(i / 3, 3 + i % 3); };
  c.panels = pad_to(3 * c.nodes, 8) / 8;
  c.rotation_panels = c.rotations ? c.panels : 0;
  c.undeformed.assign(static_cast<std::size_t>(8 * c.panels), 0.0);
  std::copy(body.nodes.data(), body.nodes.data() + 3 * c.nodes, c.undeformed.begin());
  for (int p = 0; p < c.panels + c.rotation_panels; ++p)
    for (int m = 0; m < c.modes; ++m)
      for (int i = 8 * (p % c.panels); i < 8 * (p % c.panels) + 8; ++i)
        c.shapes.push_back(i >= 3 * c.nodes ? 0.0
                           : p < c.panels   ? mesh.shapes(translation(i), m)
                                            : mesh.shapes(rotation(i), m));

  const Eigen::MatrixXd product = mesh.mass * mesh.shapes;
  for (int m = 0; m < c.modes; m += 4)
    for (int i = 0; i < (c.rotations ? 6 : 3) * c.nodes; ++i)
      for (int n = m; n < m + 4; ++n)
        c.mass_shapes.push_back(n >= c.modes      ? 0.0
                                : i < 3 * c.nodes ? product(translation(i), n)
                                                  : product(rotation(i - 3 * c.nodes), n));
  c.S = Rows::Zero(3, c.stride);
  c.S_theta = Rows::Zero(3, c.stride);
  for (int i = 0; i < 3 * c.nodes; ++i) {
    c.S.matrix().row(i % 3).head(c.modes) += product.row(translation(i));
    if (c.rotations) c.S_theta.matrix().row(i % 3).head(c.modes) += product.row(rotation(i));
  }
  c.mass = Rows::Zero(c.stride, c.stride);
  const Eigen::MatrixXd modal = mesh.shapes.transpose() * product;
  c.mass.matrix().topLeftCorner(c.modes, c.modes) = 0.5 * (modal + modal.transpose());
  c.zeros.assign(static_cast<std::size_t>(c.stride), 0.0);
  for (int k = 0; k < c.nodes; ++k)
    c.first_moment += c.sums[static_cast<std::size_t>(36) * k] * body.nodes.col(k);
  c.first_moment += Vec3d(c.mixed(1, 2), c.mixed(2, 0), c.mixed(0, 1));
  return c;
}

std::vector<Constants> constants(const Compiled& model, spec::Simulation::Inertia inertia) {
  std::vector<Constants> all;
  if (inertia == spec::Simulation::Inertia::integrals) return all;
  all.resize(model.flexible.size());
  std::vector<Diagnostic> errors;
  for (const BodyData& b : model.bodies) {
    if (b.flexible < 0) continue;
    const spec::Body& body = model.spec().bodies[static_cast<std::size_t>(b.spec)];
    Constants& c = all[static_cast<std::size_t>(b.flexible)];
    if (!body.flexible->mesh_inertia)
      errors.push_back({body.mark, fmt::format("inertia by projection needs the mesh of flexible body '{}', "
                                               "which its reduced body does not hold; use inertia: integrals",
                                               body.name)});
    else if (c.nodes == 0)
      c = constants(*body.flexible, inertia == spec::Simulation::Inertia::projection);
  }
  if (!errors.empty()) throw InputError(std::move(errors));
  return all;
}

}  // namespace mimbre::projection
