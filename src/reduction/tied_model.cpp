#include "reduction/tied_model.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <stdexcept>

#include "fe/node_label.h"
#include "math/once/decompositions.h"

namespace mimbre::fe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::SparseMatrix;
using Eigen::Vector3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Row6 = Eigen::Matrix<double, 1, 6>;

namespace {

/// Displacement in `direction` (0–5) of a node at `arm` from the reference point, per coordinate of the
/// interface: displacements along its axes, turns about them.
Row6 rigid_motion(const Interface& interface, const Vector3d& arm, int direction) {
  Row6 row = Row6::Zero();
  for (int k = 0; k < 3; ++k) {
    const Vector3d axis = interface.axes.col(k);
    if (direction < 3) {
      row[k] = axis[direction];
      row[3 + k] = axis.cross(arm)[direction];
    } else {
      row[3 + k] = axis[direction - 3];
    }
  }
  return row;
}

/// The stiffness rows of each node.
std::vector<std::vector<Index>> rows_of_nodes(const SolidMesh& mesh, const FeMatrices& matrices) {
  std::vector<std::vector<Index>> rows(static_cast<std::size_t>(mesh.nodes.cols()));
  for (Index r = 0; r < matrices.stiffness.rows(); ++r)
    rows[static_cast<std::size_t>(matrices.dofs[static_cast<std::size_t>(r)].node)].push_back(r);
  return rows;
}

/// For each interface its nodes, each once; a node belongs to one interface at most.
std::vector<std::vector<int>> distinct_nodes(const SolidMesh& mesh,
                                             const std::vector<Interface>& interfaces) {
  std::vector<std::vector<int>> result(interfaces.size());
  std::vector<int> owner(static_cast<std::size_t>(mesh.nodes.cols()), -1);
  for (std::size_t i = 0; i < interfaces.size(); ++i) {
    const Interface& interface = interfaces[i];
    if (interface.nodes.empty())
      throw std::invalid_argument(fmt::format("interface '{}' has no nodes", interface.name));
    for (const int node : interface.nodes) {
      if (node < 0 || node >= mesh.nodes.cols())
        throw std::invalid_argument(
            fmt::format("interface '{}': node {} does not exist", interface.name, node));
      int& taken = owner[static_cast<std::size_t>(node)];
      if (taken >= 0 && taken != static_cast<int>(i))
        throw std::invalid_argument(fmt::format(
            "node {} is in the interfaces '{}' and '{}'; a node belongs to one at most", label_of(mesh, node),
            interfaces[static_cast<std::size_t>(taken)].name, interface.name));
      if (taken >= 0) continue;
      taken = static_cast<int>(i);
      result[i].push_back(node);
    }
  }
  return result;
}

/// The largest arm of rotations in the rigid motions of an interface.
double arm_of(const MatrixXd& motions) {
  return motions.rows() == 0 ? 0 : motions.rightCols(3).cwiseAbs().maxCoeff();
}

void require_six_directions(const Interface& interface, const MatrixXd& motions) {
  MatrixXd scaled = motions;
  if (const double length = arm_of(motions); length > 0) scaled.rightCols(3) /= length;
  if (motions.rows() > 0 && order_columns(scaled, 1e-6).rank == 6) return;
  throw std::invalid_argument(
      fmt::format("interface '{}' has no hold in all six directions: its {} node{} must not lie on one "
                  "line{} and must belong to the model",
                  interface.name, interface.nodes.size(), interface.nodes.size() == 1 ? "" : "s",
                  interface.tie == Interface::Tie::rigid ? " (or must have rotations)" : ""));
}

}  // namespace

TiedModel::TiedModel(const SolidMesh& mesh, const FeMatrices& matrices,
                     const std::vector<Interface>& interfaces, Definiteness stiffness)
    : matrices_(matrices), interfaces_(interfaces.size()) {
  const auto rows_of = rows_of_nodes(mesh, matrices);
  const auto nodes = distinct_nodes(mesh, interfaces);
  Places places(static_cast<std::size_t>(matrices.stiffness.rows()), 0);
  for (std::size_t i = 0; i < interfaces.size(); ++i) {
    const Interface& interface = interfaces[i];
    const bool rigid = interface.tie == Interface::Tie::rigid;
    std::vector<Index> own;  // rows of the interface
    for (const int node : nodes[i])
      for (const Index r : rows_of[static_cast<std::size_t>(node)])
        if (rigid || matrices.dofs[static_cast<std::size_t>(r)].direction < 3)  // a mean is of translations
          own.push_back(r);
    MatrixXd motions(own.size(), 6);
    for (std::size_t k = 0; k < own.size(); ++k) {
      const Dof& dof = matrices.dofs[static_cast<std::size_t>(own[k])];
      motions.row(static_cast<Index>(k)) =
          rigid_motion(interface, mesh.nodes.col(dof.node) - interface.point, dof.direction);
    }
    require_six_directions(interface, motions);
    if (rigid)
      tie_rigidly(static_cast<int>(i), own, motions, places);
    else
      tie_mean(static_cast<int>(i), own, motions, places);
  }
  number_internals(places);
  factor(places, stiffness);
  if (!internal_.empty() && !means_.empty()) prepare_means();
  free_motions(interfaces);
}

void TiedModel::tie_rigidly(int interface, const std::vector<Index>& own, const MatrixXd& motions,
                            Places& places) {
  for (std::size_t k = 0; k < own.size(); ++k) {
    tied_.push_back({own[k], interface, motions.row(static_cast<Index>(k))});
    places[static_cast<std::size_t>(own[k])] = -1;
  }
}

/// z is the rigid motion nearest to the translations u of the nodes: z = W u, W = (RᵀR)⁻¹ Rᵀ, R the rigid
/// motions. Pins are the six translations that determine z best.
void TiedModel::tie_mean(int interface, const std::vector<Index>& translations, const MatrixXd& R,
                         Places& places) {
  const MatrixXd W = PivotedCholesky(R.transpose() * R).solve(R.transpose());
  MatrixXd weighted = W;
  if (const double length = arm_of(R); length > 0) weighted.bottomRows(3) *= length;
  const std::vector<int> best = order_columns(weighted).order;
  Mean mean;
  mean.interface = interface;
  Matrix6 at_pins;
  std::vector<char> pinned(translations.size(), 0);
  for (int p = 0; p < 6; ++p) {
    const auto column = static_cast<std::size_t>(best[static_cast<std::size_t>(p)]);
    mean.pins[static_cast<std::size_t>(p)] = translations[column];
    at_pins.col(p) = W.col(static_cast<Index>(column));
    pinned[column] = 1;
    places[static_cast<std::size_t>(translations[column])] = -1;
  }
  mean.from_z = inverse(at_pins);
  mean.from_x.resize(6, static_cast<Index>(translations.size()) - 6);
  Index next = 0;
  for (std::size_t k = 0; k < translations.size(); ++k)
    if (!pinned[k]) {
      mean.others.push_back(translations[k]);
      mean.from_x.col(next++) = -mean.from_z * W.col(static_cast<Index>(k));
    }
  means_.push_back(std::move(mean));
}

void TiedModel::number_internals(Places& places) {
  for (std::size_t r = 0; r < places.size(); ++r)
    if (places[r] >= 0) {
      places[r] = static_cast<Index>(internal_.size());
      internal_.push_back(static_cast<Index>(r));
    }
  for (Mean& mean : means_)
    for (Index& r : mean.others) r = places[static_cast<std::size_t>(r)];
}

/// Factorises the stiffness of the internal dofs with the interfaces held.
void TiedModel::factor(const Places& places, Definiteness stiffness) {
  const Index n = internals();
  if (n == 0) return;
  SparseMatrix<double> Koo(n, n);
  const auto visit = [&](Index column, const auto& see) {
    for (SparseMatrix<double>::InnerIterator it(matrices_.stiffness,
                                                internal_[static_cast<std::size_t>(column)]);
         it; ++it)
      if (const Index r = places[static_cast<std::size_t>(it.row())]; r >= 0) see(r, it.value());
  };
  Index entries = 0;
  for (Index c = 0; c < n; ++c) visit(c, [&](Index, double) { ++entries; });
  Koo.reserve(entries);
  for (Index c = 0; c < n; ++c) {
    Koo.startVec(c);
    visit(c, [&](Index r, double value) { Koo.insertBack(r, c) = value; });
  }
  Koo.finalize();
  factor_ = std::make_unique<LargeFactor>(
      Koo,
      "the stiffness is not positive definite where the interfaces hold the body: a part of the model is "
      "not connected to the rest, or the matrices are not those of an elastic body",
      stiffness);
}

void TiedModel::prepare_means() {
  const Index n = internals(), rows = matrices_.stiffness.rows();
  // U = [Kop/√k, √k Cᵀ], S = [0 I; I Kpp/k], pins p, C the others' part in them, k so that both parts weigh
  // alike.
  const Index pins = 6 * static_cast<Index>(means_.size());
  MatrixXd unit = MatrixXd::Zero(rows, pins);
  for (std::size_t m = 0; m < means_.size(); ++m)
    for (int p = 0; p < 6; ++p)
      unit(means_[m].pins[static_cast<std::size_t>(p)], static_cast<Index>(6 * m) + p) = 1;
  const MatrixXd Kp = symmetric_times(matrices_.stiffness, unit);
  const MatrixXd Kpp = unit.transpose() * Kp;
  const double k = Kpp.diagonal().maxCoeff(), root = std::sqrt(k);
  U_.setZero(n, 2 * pins);
  for (Index r = 0; r < n; ++r) U_.row(r).head(pins) = Kp.row(internal_[static_cast<std::size_t>(r)]) / root;
  for (std::size_t m = 0; m < means_.size(); ++m)
    for (std::size_t j = 0; j < means_[m].others.size(); ++j)
      U_.block(means_[m].others[j], pins + static_cast<Index>(6 * m), 1, 6) =
          root * means_[m].from_x.col(static_cast<Index>(j)).transpose();
  MatrixXd inverse_of_S = MatrixXd::Zero(2 * pins, 2 * pins);
  inverse_of_S.topLeftCorner(pins, pins) = -Kpp / k;
  inverse_of_S.topRightCorner(pins, pins).setIdentity();
  inverse_of_S.bottomLeftCorner(pins, pins).setIdentity();
  solved_ = factor_->solve(U_);
  small_ = inverse(inverse_of_S + U_.transpose() * solved_);
}

void TiedModel::free_motions(const std::vector<Interface>& interfaces) {
  std::vector<Index> freed;
  for (std::size_t i = 0; i < interfaces.size(); ++i)
    for (std::size_t k = 0; k < 6; ++k)
      if (interfaces[i].motions[k] == Interface::Motion::free) freed.push_back(static_cast<Index>(6 * i + k));
  if (freed.empty()) return;
  const auto count = static_cast<Index>(freed.size());
  MatrixXd z = MatrixXd::Zero(boundaries(), count);
  for (Index k = 0; k < count; ++k) z(freed[static_cast<std::size_t>(k)], k) = 1;
  const MatrixXd moved = expand(MatrixXd::Zero(internals(), count), z);
  const MatrixXd shapes = expand(-solve(restrict(symmetric_times(matrices_.stiffness, moved))), z);
  MatrixXd stiffness = shapes.transpose() * symmetric_times(matrices_.stiffness, shapes);
  stiffness = (0.5 * (stiffness + stiffness.transpose())).eval();
  const Eigen::VectorXd unit = stiffness.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const PivotedCholesky factor(unit.asDiagonal() * stiffness * unit.asDiagonal());
  if (!(factor.least_pivot() > 1e-10))
    throw std::invalid_argument("so many motions are free that nothing holds the body: retain six at least");
  freed_inverse_ = unit.asDiagonal() * factor.solve(MatrixXd(unit.asDiagonal()));
  freed_shapes_ = shapes;
  freed_ = std::move(freed);
}

MatrixXd TiedModel::motions(const MatrixXd& x, const MatrixXd& z) const {
  MatrixXd all = z;
  const auto first = static_cast<Index>(internal_.size());
  for (std::size_t k = 0; k < freed_.size(); ++k) all.row(freed_[k]) += x.row(first + static_cast<Index>(k));
  return all;
}

MatrixXd TiedModel::expand(const MatrixXd& x, const MatrixXd& z) const {
  MatrixXd u = MatrixXd::Zero(matrices_.stiffness.rows(), x.cols());
  for (std::size_t k = 0; k < internal_.size(); ++k) u.row(internal_[k]) = x.row(static_cast<Index>(k));
  for (const Tied& t : tied_) u.row(t.row) = t.motion * z.middleRows<6>(6 * t.interface);
  for (const Mean& m : means_) {
    MatrixXd at = m.from_z * z.middleRows<6>(6 * m.interface);
    for (std::size_t k = 0; k < m.others.size(); ++k)
      at += m.from_x.col(static_cast<Index>(k)) * x.row(m.others[k]);
    for (int p = 0; p < 6; ++p) u.row(m.pins[static_cast<std::size_t>(p)]) = at.row(p);
  }
  if (!freed_.empty()) u += freed_shapes_ * x.bottomRows(static_cast<Index>(freed_.size()));
  return u;
}

MatrixXd TiedModel::restrict(const MatrixXd& f) const {
  MatrixXd x(internals(), f.cols());
  for (std::size_t k = 0; k < internal_.size(); ++k) x.row(static_cast<Index>(k)) = f.row(internal_[k]);
  if (!freed_.empty()) x.bottomRows(static_cast<Index>(freed_.size())) = freed_shapes_.transpose() * f;
  for (const Mean& m : means_) {
    MatrixXd at(6, f.cols());
    for (int p = 0; p < 6; ++p) at.row(p) = f.row(m.pins[static_cast<std::size_t>(p)]);
    for (std::size_t k = 0; k < m.others.size(); ++k)
      x.row(m.others[k]) += m.from_x.col(static_cast<Index>(k)).transpose() * at;
  }
  return x;
}

MatrixXd TiedModel::solve(const MatrixXd& f) const {
  const auto inner = static_cast<Index>(internal_.size());
  MatrixXd x(internals(), f.cols());
  if (inner > 0) {
    x.topRows(inner) = factor_->solve(f.topRows(inner));
    if (!means_.empty())
      x.topRows(inner) -= (solved_ * (small_ * (U_.transpose() * x.topRows(inner)))).eval();
  }
  if (!freed_.empty()) x.bottomRows(x.rows() - inner) = freed_inverse_ * f.bottomRows(x.rows() - inner);
  return x;
}

Pencil TiedModel::held() const {
  const auto mass = [this](const MatrixXd& x) {
    return restrict(symmetric_times(matrices_.mass, expand(x, MatrixXd::Zero(boundaries(), x.cols()))));
  };
  return {internals(), [this](const MatrixXd& f) { return solve(f); }, mass, 0};
}

}  // namespace mimbre::fe
