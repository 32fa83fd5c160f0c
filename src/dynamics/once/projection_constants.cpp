#include <fmt/format.h>

#include <Eigen/SparseCore>
#include <algorithm>
#include <stdexcept>

#include "compile/compiled.h"
#include "dynamics/projection.h"
#include "mimbre/diagnostics.h"
#include "mimbre/reduced_body.h"

namespace mimbre::projection {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

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

/// [four modes][translations][4].
Values by_fours(const Eigen::MatrixXd& translations, int modes) {
  Values out;
  for (int m = 0; m < modes; m += 4)
    for (Eigen::Index i = 0; i < translations.rows(); ++i)
      for (int n = m; n < m + 4; ++n) out.push_back(n < modes ? translations(i, n) : 0.0);
  return out;
}

/// [panel][mode][8].
Values by_panels(const Eigen::MatrixXd& translations, int panels) {
  Values out;
  for (int p = 0; p < panels; ++p)
    for (Eigen::Index m = 0; m < translations.cols(); ++m)
      for (Eigen::Index i = 8 * static_cast<Eigen::Index>(p); i < 8 * (p + 1); ++i)
        out.push_back(i < translations.rows() ? translations(i, m) : 0.0);
  return out;
}

/// Of a rigid motion.
void add_rigid_inertia(const Mesh& mesh, const Eigen::Matrix3Xd& nodes, Constants& c) {
  Eigen::MatrixXd rigid = Eigen::MatrixXd::Zero(mesh.mass.rows(), 6);
  for (int k = 0; k < mesh.nodes; ++k) {
    rigid.block<3, 3>(mesh.dof(k, 0), 0).setIdentity();
    rigid.block<3, 3>(mesh.dof(k, 0), 3) = -skew<double>(nodes.col(k));
    if (mesh.width == 6) rigid.block<3, 3>(mesh.dof(k, 3), 3).setIdentity();
  }
  const Eigen::Matrix<double, 6, 6> mass = rigid.transpose() * (mesh.mass * rigid);
  const Mat3d translation = mass.topLeftCorner<3, 3>(), mixed = mass.topRightCorner<3, 3>();  // m, −m̄u~
  const Mat3d rotation = 0.5 * (mass.bottomRightCorner<3, 3>() + mass.bottomRightCorner<3, 3>().transpose());
  c.total_mass = translation.trace() / 3;
  c.first_moment =
      0.5 * Vec3d(mixed(1, 2) - mixed(2, 1), mixed(2, 0) - mixed(0, 2), mixed(0, 1) - mixed(1, 0));
  c.second_moment = 0.5 * rotation.trace() * Mat3d::Identity() - rotation;
  const double off = (translation - c.total_mass * Mat3d::Identity()).cwiseAbs().maxCoeff(),
               size = nodes.cwiseAbs().maxCoeff();
  const Mat3d symmetric = mixed + mixed.transpose();
  c.plain = off <= 1e-8 * c.total_mass && symmetric.cwiseAbs().maxCoeff() <= 1e-8 * c.total_mass * size;
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
  add_rigid_inertia(mesh, body.nodes, c);

  const Eigen::MatrixXd product = mesh.mass * mesh.shapes;
  Eigen::MatrixXd shapes(3 * c.nodes, c.modes), masses = shapes;
  c.S = Rows::Zero(3, c.stride);
  c.S_theta = Rows::Zero(3, c.stride);
  for (int k = 0; k < c.nodes; ++k) {
    shapes.middleRows<3>(3 * k) = mesh.shapes.middleRows<3>(mesh.dof(k, 0));
    masses.middleRows<3>(3 * k) = product.middleRows<3>(mesh.dof(k, 0));
    c.S.matrix().leftCols(c.modes) += product.middleRows<3>(mesh.dof(k, 0));
    if (mesh.width == 6) c.S_theta.matrix().leftCols(c.modes) += product.middleRows<3>(mesh.dof(k, 3));
  }
  c.panels = pad_to(3 * c.nodes, 8) / 8;
  c.undeformed.assign(static_cast<std::size_t>(8 * c.panels), 0.0);
  std::copy(body.nodes.data(), body.nodes.data() + 3 * c.nodes, c.undeformed.begin());
  c.shapes = by_panels(shapes, c.panels);
  c.masses = by_panels(masses, c.panels);
  c.shape_rows = by_fours(shapes, c.modes);
  c.mass_rows = by_fours(masses, c.modes);
  c.mass = Rows::Zero(c.stride, c.stride);
  const Eigen::MatrixXd modal = mesh.shapes.transpose() * product;
  c.mass.matrix().topLeftCorner(c.modes, c.modes) = 0.5 * (modal + modal.transpose());
  c.zeros.assign(static_cast<std::size_t>(c.stride), 0.0);
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
    if (!body.neglected.empty())
      errors.push_back({body.mark, fmt::format("neglected_inertia of body '{}' needs inertia: integrals; by "
                                               "projection there are no single terms",
                                               body.name)});
    else if (!body.flexible->mesh_inertia)
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
