#include "reduction/shape_integrals.h"

#include <span>

#include "fe/elements/beam_element.h"
#include "math/gauss.h"

namespace mimbre::fe {

void clear_shape_integrals(ReducedBody& body, Eigen::Index modes) {
  body.mass = 0;
  body.first_moment.setZero();
  body.second_moment.setZero();
  body.S.setZero(3, modes);
  for (auto& block : body.S_position) block.setZero(3, modes);
  for (auto& row : body.S_modes)
    for (auto& block : row) block.setZero(modes, modes);
}

void add_mass_point(ReducedBody& body, double dm, const Eigen::Vector3d& position,
                    const Eigen::Matrix3Xd& X) {
  body.mass += dm;
  body.first_moment += dm * position;
  body.second_moment += dm * position * position.transpose();
  body.S += dm * X;
  for (int i = 0; i < 3; ++i) {
    body.S_position[i] += dm * position[i] * X;
    for (int j = i; j < 3; ++j) body.S_modes[i][j].noalias() += dm * X.row(i).transpose() * X.row(j);
  }
}

void complete_shape_integrals(ReducedBody& body) {
  for (int i = 0; i < 3; ++i) {
    body.S_modes[i][i] = (0.5 * (body.S_modes[i][i] + body.S_modes[i][i].transpose())).eval();
    for (int j = 0; j < i; ++j) body.S_modes[i][j] = body.S_modes[j][i].transpose();
  }
}

// The second moment of exp(θ~) d to second order, (I + θ~ + ½θ~²) D (I + θ~ + ½θ~²)ᵀ, and the
// moment of momentum that goes with it.
void add_turning_part(ReducedBody& body, const Eigen::Matrix3d& D, const Eigen::Matrix3Xd& turn) {
  body.second_moment += D;
  const Eigen::Matrix3Xd D_turn = D * turn;
  std::array<Eigen::Matrix3Xd, 3> across;  // row i of θ~ by mode: coordinate i of θ × d is its product with d
  for (int i = 0; i < 3; ++i) {
    across[i].setZero(3, turn.cols());
    across[i].row((i + 1) % 3) = -turn.row((i + 2) % 3);
    across[i].row((i + 2) % 3) = turn.row((i + 1) % 3);
  }
  const auto outer = [](const auto& a, const auto& b) { return a.transpose() * b; };
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      body.S_position[i].row(j) += D.row(i) * across[j];
      if (j < i) continue;
      Eigen::MatrixXd& block = body.S_modes[i][j];
      block.noalias() += across[i].transpose() * (D * across[j]);
      block.noalias() += 0.25 * (outer(D_turn.row(j), turn.row(i)) + outer(turn.row(i), D_turn.row(j)) +
                                 outer(turn.row(j), D_turn.row(i)) + outer(D_turn.row(i), turn.row(j)));
      block.noalias() -= D(i, j) * (turn.transpose() * turn);
    }
}

namespace {

void add_polar_inertia(ReducedBody& body, double inertia, const Eigen::Vector3d& axis,
                       const Eigen::RowVectorXd& mean_twist) {
  body.second_moment += inertia * (0.5 * Eigen::Matrix3d::Identity() - axis * axis.transpose());
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3;
    const int j = (k + 2) % 3;
    const Eigen::RowVectorXd half = 0.5 * inertia * axis[k] * mean_twist;
    body.S_position[i].row(j) += half;
    body.S_position[j].row(i) -= half;
  }
}

}  // namespace

void add_shape_integrals(const Mesh& mesh, const Eigen::MatrixXd& shapes, MassMatrix mass_matrix,
                         ReducedBody& body) {
  const bool lumped = mass_matrix == MassMatrix::lumped;
  const std::span<const GaussPoint> points = lumped ? std::span<const GaussPoint>(trapezoid2) : gauss4;
  clear_shape_integrals(body, shapes.cols());
  Eigen::MatrixXd dofs(12, shapes.cols());  // of the element, in its axes, per mode
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const BeamElement& beam = mesh.elements[e];
    const ElementGeometry geometry = element_geometry(mesh, e);
    for (int end = 0; end < 2; ++end) dofs.middleRows<6>(6 * end) = shapes.middleRows<6>(6 * beam.nodes[end]);
    dofs = (element_transformation(beam, geometry.axes) * dofs).eval();

    const double mass = beam.material.density * beam.section.area * geometry.length;
    const Eigen::Vector3d axis = geometry.axes.col(0);
    const ShearRatio shear = shear_ratio(beam, geometry.length);
    const Eigen::Matrix3d section =
        beam.material.density *
        (geometry.axes * Eigen::Vector3d(0, beam.section.Iz, beam.section.Iy).asDiagonal() *
         geometry.axes.transpose());
    for (const GaussPoint& point : points) {
      const Eigen::Matrix3Xd X = geometry.axes * shape_functions(point.xi, geometry.length, shear) * dofs;
      add_mass_point(body, point.weight * mass, geometry.start + point.xi * geometry.length * axis, X);
      const Eigen::Matrix3Xd turn =
          geometry.axes * rotation_functions(point.xi, geometry.length, shear) * dofs;
      if (has_rotary_inertia(beam)) add_turning_part(body, point.weight * geometry.length * section, turn);
      if (lumped)
        add_turning_part(body, lumped_turning(beam, geometry.length) * axis * axis.transpose(), turn);
    }
    if (!has_rotary_inertia(beam))
      add_polar_inertia(body, polar_inertia(beam) * geometry.length, axis, 0.5 * (dofs.row(3) + dofs.row(9)));
  }
  complete_shape_integrals(body);
}

}  // namespace mimbre::fe
