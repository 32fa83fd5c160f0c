#include "fe_files/bodies/cross_integrals.h"

#include <fmt/format.h>

#include <Eigen/Core>

#include "math/once/decompositions.h"
#include "mimbre/diagnostics.h"

namespace mimbre::fe {

namespace {

/// k, i, j: an even permutation.
int next(int k) { return (k + 1) % 3; }
int after_next(int k) { return (k + 2) % 3; }

}  // namespace

Eigen::Matrix3d second_moment_of(const Eigen::Matrix3d& inertia) {
  return 0.5 * inertia.trace() * Eigen::Matrix3d::Identity() - inertia;
}

Eigen::Matrix3d inertia_of(const Eigen::Matrix3d& second_moment) {
  return second_moment.trace() * Eigen::Matrix3d::Identity() - second_moment;
}

Eigen::Matrix3d position_integral(const ReducedBody& body, int m) {
  Eigen::Matrix3d result;
  for (int i = 0; i < 3; ++i) result.col(i) = body.S_position[static_cast<std::size_t>(i)].col(m);
  return result;
}

Eigen::Matrix3Xd angular_coupling(const ReducedBody& body) {
  Eigen::Matrix3Xd result(3, body.modes);
  for (int k = 0; k < 3; ++k) {
    const int i = next(k), j = after_next(k);
    result.row(k) = body.S_position[static_cast<std::size_t>(i)].row(j) -
                    body.S_position[static_cast<std::size_t>(j)].row(i);
  }
  return result;
}

void set_position_integrals(const std::vector<Eigen::Matrix3d>& position, const Eigen::Matrix3Xd& coupling,
                            ReducedBody& body) {
  for (int m = 0; m < body.modes; ++m) {
    const Eigen::Matrix3d& given = position[static_cast<std::size_t>(m)];
    Eigen::Matrix3d value = 0.5 * (given + given.transpose());
    for (int k = 0; k < 3; ++k) {
      const int i = next(k), j = after_next(k);
      value(j, i) += 0.5 * coupling(k, m);
      value(i, j) -= 0.5 * coupling(k, m);
    }
    for (int i = 0; i < 3; ++i) body.S_position[static_cast<std::size_t>(i)].col(m) = value.col(i);
  }
}

Eigen::Matrix3d mode_integral(const ReducedBody& body, int k, int m) {
  Eigen::Matrix3d result;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      result(i, j) = body.S_modes[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)](k, m);
  return result;
}

ReducedBody empty_body(int modes) {
  ReducedBody body;
  body.modes = modes;
  for (int m = 0; m < modes; ++m) body.mode_names.push_back(fmt::format("mode {}", m + 1));
  body.S = Eigen::Matrix3Xd::Zero(3, modes);
  for (Eigen::Matrix3Xd& block : body.S_position) block = Eigen::Matrix3Xd::Zero(3, modes);
  for (auto& row : body.S_modes)
    for (Eigen::MatrixXd& block : row) block = Eigen::MatrixXd::Zero(modes, modes);
  for (Eigen::MatrixXd* matrix : {&body.mass_matrix, &body.stiffness, &body.damping})
    *matrix = Eigen::MatrixXd::Zero(modes, modes);
  body.user_from_modal = Eigen::MatrixXd::Identity(modes, modes);
  return body;
}

std::vector<std::string> finish_body(const std::string& path, ReducedBody& body) {
  for (Eigen::MatrixXd* matrix : {&body.mass_matrix, &body.stiffness, &body.damping})
    *matrix = (0.5 * (*matrix + matrix->transpose())).eval();
  body.second_moment = (0.5 * (body.second_moment + body.second_moment.transpose())).eval();
  if (!(body.mass > 0))
    throw InputError({path, 0, 0}, fmt::format("the mass must be positive, is {}", body.mass));
  if (body.modes > 0 && !is_positive_definite(body.mass_matrix))
    throw InputError({path, 0, 0}, "the modal mass matrix is not positive definite");
  return check(body);
}

}  // namespace mimbre::fe
