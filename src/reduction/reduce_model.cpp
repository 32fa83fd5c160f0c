#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "fe/block_lanczos.h"
#include "fe/skin.h"
#include "mimbre/fe_reduce.h"
#include "reduction/nodal_shape_integrals.h"
#include "reduction/rigid_shapes.h"
#include "reduction/tied_model.h"

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::SparseMatrix;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kDrawnNodes = 1500;
constexpr double kHertz = 1 / (2 * std::numbers::pi);

/// Mode shapes over the dofs, and the motion of the interfaces' points in them: six rows per interface,
/// displacement and turn in body axes.
struct Shapes {
  MatrixXd dofs, points;
  std::vector<std::string> names;
};

MatrixXd point_rows(const Interface& interface, const MatrixXd& z) {
  MatrixXd rows(6, z.cols());
  rows.topRows(3) = interface.axes * z.topRows(3);
  rows.bottomRows(3) = interface.axes * z.bottomRows(3);
  return rows;
}

/// Static modes of the interfaces' motions, all but the first's in a tangent frame, then the modes of the
/// held model.
Shapes craig_bampton(const TiedModel& tied, const FeMatrices& matrices, const ModelReduction& options,
                     const MatrixXd& dynamic) {
  const auto interfaces = static_cast<Index>(options.interfaces.size());
  const Index first = options.frame == ModelReduction::Frame::tangent ? 1 : 0;
  const Index statics = 6 * (interfaces - first);
  Shapes shapes;
  MatrixXd z = MatrixXd::Zero(6 * interfaces, statics + dynamic.cols());
  z.block(6 * first, 0, statics, statics).setIdentity();
  shapes.dofs.resize(matrices.stiffness.rows(), z.cols());
  if (statics > 0) {
    const MatrixXd zs = z.leftCols(statics);
    const MatrixXd moved = tied.expand(MatrixXd::Zero(tied.internals(), statics), zs);
    const MatrixXd x = -tied.solve(tied.restrict(symmetric_times(matrices.stiffness, moved)));
    shapes.dofs.leftCols(statics) = tied.expand(x, zs);
  }
  shapes.dofs.rightCols(dynamic.cols()) =
      tied.expand(dynamic, MatrixXd::Zero(6 * interfaces, dynamic.cols()));
  shapes.points.resize(6 * interfaces, z.cols());
  for (Index i = 0; i < interfaces; ++i) {
    const Interface& interface = options.interfaces[static_cast<std::size_t>(i)];
    shapes.points.middleRows(6 * i, 6) = point_rows(interface, z.middleRows(6 * i, 6));
    if (i < first) continue;
    for (const char* motion : {"x", "y", "z", "rx", "ry", "rz"})
      shapes.names.push_back(fmt::format("static {}.{}", interface.name, motion));
  }
  for (Index k = 0; k < dynamic.cols(); ++k) shapes.names.push_back(fmt::format("dynamic {}", k + 1));
  return shapes;
}

/// Takes linear and angular momentum out of the shapes, and the six that then depend on the others.
void to_mean_axes(const FeMatrices& matrices, const std::vector<Interface>& interfaces, const MatrixXd& R,
                  Shapes& shapes) {
  const MatrixXd momenta = symmetric_times(matrices.mass, R);
  const MatrixXd part = (R.transpose() * momenta).ldlt().solve(momenta.transpose() * shapes.dofs);
  shapes.dofs -= R * part;
  for (std::size_t i = 0; i < interfaces.size(); ++i) {
    Eigen::Matrix<double, 6, 6> motion = Eigen::Matrix<double, 6, 6>::Identity();
    for (int k = 0; k < 3; ++k)
      motion.block<3, 1>(0, 3 + k) = Vector3d(Vector3d::Unit(k)).cross(interfaces[i].point);
    shapes.points.middleRows<6>(static_cast<Index>(6 * i)) -= motion * part;
  }
  const MatrixXd gram = shapes.dofs.transpose() * symmetric_times(matrices.mass, shapes.dofs);
  const VectorXd scale = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(scale.asDiagonal() * gram * scale.asDiagonal());
  const Index kept = gram.cols() - 6;
  const MatrixXd turn = scale.asDiagonal() * solver.eigenvectors().rightCols(kept) *
                        solver.eigenvalues().tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  shapes.dofs = (shapes.dofs * turn).eval();
  shapes.points = (shapes.points * turn).eval();
  shapes.names.clear();
  for (Index k = 0; k < kept; ++k) shapes.names.push_back(fmt::format("mean-axis {}", k + 1));
}

/// m_kl of the translations: a third of the trace of each pair's block; full storage.
SparseMatrix<double> nodal_mass_of(const SolidMesh& mesh, const FeMatrices& matrices) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(2 * matrices.mass.nonZeros() / 3));
  for (Index c = 0; c < matrices.mass.cols(); ++c) {
    const Dof& b = matrices.dofs[static_cast<std::size_t>(c)];
    for (SparseMatrix<double>::InnerIterator it(matrices.mass, c); it; ++it) {
      const Dof& a = matrices.dofs[static_cast<std::size_t>(it.row())];
      if (a.direction != b.direction || a.direction > 2) continue;
      entries.emplace_back(a.node, b.node, it.value() / 3);
      if (it.row() != c) entries.emplace_back(b.node, a.node, it.value() / 3);
    }
  }
  SparseMatrix<double> mass(mesh.nodes.cols(), mesh.nodes.cols());
  mass.setFromTriplets(entries.begin(), entries.end());
  return mass;
}

MatrixXd node_shapes(const SolidMesh& mesh, const FeMatrices& matrices, const MatrixXd& shapes) {
  MatrixXd out = MatrixXd::Zero(3 * mesh.nodes.cols(), shapes.cols());
  for (std::size_t r = 0; r < matrices.dofs.size(); ++r)
    if (const Dof& dof = matrices.dofs[r]; dof.direction < 3)
      out.row(3 * dof.node + dof.direction) = shapes.row(static_cast<Index>(r));
  return out;
}

void add_drawing(const SolidMesh& mesh, const MatrixXd& displacements, ReducedBody& body) {
  const Wire drawn = wire(mesh, skin(mesh), kDrawnNodes);
  std::vector<int> nodes = drawn.nodes;
  if (nodes.empty())  // matrices without elements: a cloud of points
    for (Index k = 0; k < mesh.nodes.cols(); k += 1 + mesh.nodes.cols() / kDrawnNodes)
      nodes.push_back(static_cast<int>(k));
  body.nodes.resize(3, static_cast<Index>(nodes.size()));
  body.node_shapes.resize(static_cast<Index>(3 * nodes.size()), displacements.cols());
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    body.nodes.col(static_cast<Index>(k)) = mesh.nodes.col(nodes[k]);
    body.node_shapes.middleRows<3>(static_cast<Index>(3 * k)) = displacements.middleRows<3>(3 * nodes[k]);
  }
  body.lines = drawn.lines;
  const Vector3d size = body.nodes.rowwise().maxCoeff() - body.nodes.rowwise().minCoeff();
  body.line_radius = std::max(1e-6, 1e-3 * size.maxCoeff());
}

/// Elastic modes of the free model, and how well the reduced body has them.
void add_free_modes(const FeMatrices& matrices, const ModelReduction& options, const MatrixXd& R,
                    const MatrixXd& shapes, double scale, ReductionResult& result) {
  const int count = static_cast<int>(std::min<Index>(options.free_modes, matrices.stiffness.rows() - 6));
  if (count <= 0) return;
  const double shift = 0.3 * scale;
  Pencil pencil;
  pencil.size = matrices.stiffness.rows();
  pencil.shift = -shift;
  const LargeFactor factor(
      SparseMatrix<double>(matrices.stiffness + shift * matrices.mass),
      "stiffness plus mass is not positive definite: the matrices are not those of an elastic body");
  pencil.solve = [&](const MatrixXd& b) { return factor.solve(b); };
  pencil.mass = [&](const MatrixXd& x) { return symmetric_times(matrices.mass, x); };
  const Modes full = block_lanczos(pencil, count + 6, [&](double done) {
    if (options.progress) options.progress("free modes", done);
  });
  result.free_frequencies = full.eigenvalues.tail(count).cwiseMax(0).cwiseSqrt() * kHertz;

  MatrixXd all(shapes.rows(), 6 + shapes.cols());
  all << R, shapes;
  const MatrixXd momenta = symmetric_times(matrices.mass, all);
  MatrixXd mass = all.transpose() * momenta,
           stiffness = all.transpose() * symmetric_times(matrices.stiffness, all);
  mass = (0.5 * (mass + mass.transpose())).eval();
  stiffness = (0.5 * (stiffness + stiffness.transpose())).eval();
  // Scaled, so that metres and radians do not meet.
  const VectorXd unit = mass.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> reduced(
      unit.asDiagonal() * stiffness * unit.asDiagonal(), unit.asDiagonal() * mass * unit.asDiagonal());
  const Index elastic = std::min<Index>(count, shapes.cols());
  result.reduced_free_frequencies =
      reduced.eigenvalues().segment(6, elastic).cwiseMax(0).cwiseSqrt() * kHertz;
  const MatrixXd likeness =
      full.vectors.transpose() * (momenta * (unit.asDiagonal() * reduced.eigenvectors()));
  double worst_frequency = 0, worst_mac = 1;
  Index compared = 0;
  std::string rows;
  for (Index k = 0; k < elastic; ++k) {
    // Of frequencies that coincide the shapes may be any of their plane: the best of the neighbours together.
    double mac = 0;
    for (Index j = 6; j < reduced.eigenvectors().cols(); ++j) {
      const double f = std::sqrt(std::max(0.0, reduced.eigenvalues()[j])) * kHertz;
      if (std::abs(f / result.reduced_free_frequencies[k] - 1) < 0.02) mac += std::pow(likeness(6 + k, j), 2);
    }
    const double error = result.reduced_free_frequencies[k] / result.free_frequencies[k] - 1;
    rows += fmt::format("{}{:.5g} Hz: {:+.2g} %, MAC {:.4f}", k ? "; " : "", result.free_frequencies[k],
                        100 * error, std::min(mac, 1.0));
    // The lower half is what the basis is for.
    if (2 * k < elastic) {
      worst_frequency = std::max(worst_frequency, std::abs(error));
      worst_mac = std::min(worst_mac, mac);
      ++compared;
    }
  }
  result.body.checks.push_back({"free frequencies",
                                compared == 0 || (worst_frequency < 0.1 && worst_mac > 0.9),
                                fmt::format("full model against reduced, the lower half must agree within 10 "
                                            "% and MAC 0.9 (rigid interfaces stiffen): {}",
                                            rows)});
}

}  // namespace

Vector3d centre_of(const SolidMesh& mesh, const std::vector<int>& nodes) {
  Vector3d sum = Vector3d::Zero();
  for (const int node : nodes) sum += mesh.nodes.col(node);
  return nodes.empty() ? sum : Vector3d(sum / static_cast<double>(nodes.size()));
}

ReductionResult reduce(const SolidMesh& mesh, const FeMatrices& matrices, const ModelReduction& options) {
  const auto tell = [&](const char* stage, double done) {
    if (options.progress) options.progress(stage, done);
  };
  if (options.interfaces.empty())
    throw std::invalid_argument("a body needs at least one interface, where something can hold it");
  if (options.dynamic_modes < 0 || options.free_modes < 0)
    throw std::invalid_argument("numbers of modes must not be negative");
  if (!(std::isfinite(options.stiffness_damping) && options.stiffness_damping >= 0))
    throw std::invalid_argument("stiffness damping must not be negative");
  if (options.frame == ModelReduction::Frame::tangent && options.interfaces.size() == 1 &&
      options.dynamic_modes == 0)
    throw std::invalid_argument("one interface and no dynamic modes leave nothing that could deform");
  for (std::size_t i = 0; i < options.interfaces.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (options.interfaces[i].name == options.interfaces[j].name)
        throw std::invalid_argument(
            fmt::format("two interfaces are called '{}'", options.interfaces[i].name));

  tell("checks", 0);
  ReductionResult result;
  result.body.checks = check_matrices(mesh, matrices);
  for (const Check& check : result.body.checks)
    if (!check.passed && (check.name == "sizes" || check.name == "finite numbers" ||
                          check.name == "positive diagonals" || check.name == "rigid motions"))
      throw std::invalid_argument(fmt::format("{}: {}", check.name, check.detail));

  const MatrixXd R = rigid_shapes(mesh, matrices);
  Shapes shapes;
  double scale = 0;  // a typical ω²
  {
    tell("factorisation", 0);
    const TiedModel tied(mesh, matrices, options.interfaces);
    tell("dynamic modes", 0);
    const Modes held =
        block_lanczos(tied.held(), options.dynamic_modes, [&](double done) { tell("dynamic modes", done); });
    result.fixed_frequencies = held.eigenvalues.cwiseMax(0).cwiseSqrt() * kHertz;
    tell("static modes", 0);
    shapes = craig_bampton(tied, matrices, options, held.vectors);
    if (options.dynamic_modes > 0) scale = held.eigenvalues[0];
  }
  if (scale == 0)
    scale = shapes.dofs.cwiseProduct(symmetric_times(matrices.stiffness, shapes.dofs)).sum() /
            shapes.dofs.cwiseProduct(symmetric_times(matrices.mass, shapes.dofs)).sum();
  if (options.frame == ModelReduction::Frame::mean_axis)
    to_mean_axes(matrices, options.interfaces, R, shapes);

  tell("integrals", 0);
  ReducedBody& body = result.body;
  body.modes = static_cast<int>(shapes.dofs.cols());
  body.mode_names = shapes.names;
  const MatrixXd mass = shapes.dofs.transpose() * symmetric_times(matrices.mass, shapes.dofs),
                 stiffness = shapes.dofs.transpose() * symmetric_times(matrices.stiffness, shapes.dofs);
  const MatrixXd displacements = node_shapes(mesh, matrices, shapes.dofs);
  add_shape_integrals(mesh.nodes, nodal_mass_of(mesh, matrices), displacements, body);
  body.mass_matrix = 0.5 * (mass + mass.transpose());
  body.stiffness = 0.5 * (stiffness + stiffness.transpose());
  body.damping = options.stiffness_damping * body.stiffness;
  for (std::size_t i = 0; i < options.interfaces.size(); ++i) {
    const Interface& interface = options.interfaces[i];
    const auto rows = shapes.points.middleRows<6>(static_cast<Index>(6 * i));
    body.frames.push_back(
        {interface.name, interface.point, interface.axes, rows.topRows<3>(), rows.bottomRows<3>()});
  }
  add_drawing(mesh, displacements, body);
  make_orthogonal(body);

  const double overlap = (body.user_from_modal.transpose() * mass * body.user_from_modal -
                          MatrixXd::Identity(body.modes, body.modes))
                             .cwiseAbs()
                             .maxCoeff();
  const auto statics = static_cast<int>(6 * options.interfaces.size());
  body.checks.push_back({"orthogonal modes", overlap < 1e-8, fmt::format("to {:.1g}", overlap)});
  body.checks.push_back({"number of modes", true,
                         fmt::format("{} = {} motions of {} interface{} − 6 of the body + {} dynamic",
                                     body.modes, statics, options.interfaces.size(),
                                     options.interfaces.size() == 1 ? "" : "s", options.dynamic_modes)});
  std::string unsound;
  for (const std::string& message : check(body)) unsound += (unsound.empty() ? "" : "; ") + message;
  body.checks.push_back({"reduced body", unsound.empty(), unsound.empty() ? "sound" : unsound});
  add_free_modes(matrices, options, R, shapes.dofs, scale, result);
  tell("done", 1);
  return result;
}

}  // namespace mimbre::fe
