#include <fmt/format.h>

#include <Eigen/Core>
#include <stdexcept>

#include "fe/solve/fix_signs.h"
#include "math/once/decompositions.h"
#include "mimbre/reduced_body.h"
#include "reduction/stiffening/beside_rotation.h"

namespace mimbre {
namespace {

/// Qᵀ A Q
void rotate(Eigen::MatrixXd& matrix, const Eigen::MatrixXd& Q) {
  matrix = (Q.transpose() * matrix * Q).eval();
}

template <typename Block>
void rotate_columns(Block& block, const Eigen::MatrixXd& Q) {
  block = (block * Q).eval();
}

void rotate_columns_of(Eigen::MatrixXd& matrix, Eigen::Index first, const Eigen::MatrixXd& Q) {
  auto block = matrix.middleCols(first, Q.rows());
  block = (block * Q).eval();
}

void make_symmetric(Eigen::MatrixXd& matrix) { matrix = (0.5 * (matrix + matrix.transpose())).eval(); }

}  // namespace

void make_orthogonal(ReducedBody& body) {
  if (body.user_from_modal.size() == 0) body.user_from_modal.setIdentity(body.modes, body.modes);
  if (body.modes == 0) {
    body.eigenfrequencies.resize(0);
    return;
  }
  if (!is_positive_definite(body.mass_matrix))
    throw std::invalid_argument(fmt::format(
        "reduced body '{}': the modes' mass matrix is not positive definite, the modes are dependent",
        body.name));
  const EigenPairs pairs = symmetric_eigen(body.stiffness, body.mass_matrix);
  if (!pairs.ok)
    throw std::invalid_argument(
        fmt::format("reduced body '{}': the eigenproblem of its matrices has no solution", body.name));
  Eigen::MatrixXd Q = pairs.vectors;
  fe::fix_signs(Q);

  // Exact by construction; computing them would only add round-off.
  body.mass_matrix.setIdentity();
  body.stiffness = pairs.values.asDiagonal();
  body.eigenfrequencies = pairs.values.cwiseMax(0).cwiseSqrt();

  rotate(body.damping, Q);
  make_symmetric(body.damping);
  rotate_columns(body.S, Q);
  for (auto& block : body.S_position) rotate_columns(block, Q);
  for (int i = 0; i < 3; ++i) {
    rotate(body.S_modes[i][i], Q);
    make_symmetric(body.S_modes[i][i]);
    for (int j = i + 1; j < 3; ++j) {
      rotate(body.S_modes[i][j], Q);
      body.S_modes[j][i] = body.S_modes[i][j].transpose();
    }
  }
  if (body.geometric) {
    for (Eigen::MatrixXd& stiffness : body.geometric->stiffness) {
      rotate(stiffness, Q);
      make_symmetric(stiffness);
    }
    rotate_columns(body.geometric->boundary_loads, Q);
  }
  if (body.stretching)
    for (Eigen::MatrixXd& form : body.stretching->forms) {
      rotate(form, beside_rotation(Q));
      make_symmetric(form);
    }
  if (body.sections)
    for (int block = 0; block < 4; ++block)
      rotate_columns_of(body.sections->influence, GeometricStiffness::boundary + block * body.modes, Q);
  if (body.bar_stress) rotate_columns(body.bar_stress->shapes, Q);
  for (BodyFrame& frame : body.frames) {
    rotate_columns(frame.X, Q);
    rotate_columns(frame.X_theta, Q);
  }
  rotate_columns(body.node_shapes, Q);
  for (Eigen::MatrixXd* field : {&body.stress, &body.strain})
    if (field->size() > 0) rotate_columns(*field, Q);
  if (body.mesh_inertia) rotate_columns(body.mesh_inertia->shapes, Q);
  rotate_columns(body.user_from_modal, Q);
}

}  // namespace mimbre
