#include "reduction/bases/project_modes.h"
#include "math/once/decompositions.h"
#include "reduction/stiffening/beside_rotation.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <stdexcept>

namespace mimbre {
namespace {

using Eigen::MatrixXd;

void project(MatrixXd& matrix, const MatrixXd& T) { matrix = (T.transpose() * matrix * T).eval(); }

void project_symmetric(MatrixXd& matrix, const MatrixXd& T) {
  project(matrix, T);
  matrix = (0.5 * (matrix + matrix.transpose())).eval();
}

template <typename Block>
void project_columns(Block& block, const MatrixXd& T) {
  if (block.size() > 0) block = (block * T).eval();
}

void require(const ReducedBody& body, const MatrixXd& T) {
  if (body.second_order || body.ancf)
    throw std::invalid_argument(fmt::format(
        "reduced body '{}': its displacements are not linear in the amplitudes, so that its modes "
        "cannot be dropped or combined",
        body.name));
  if (T.rows() != body.modes || T.cols() < 1 || T.cols() > body.modes)
    throw std::invalid_argument(
        fmt::format("reduced body '{}': {} modes cannot be combined by {} × {} factors", body.name,
                    body.modes, T.rows(), T.cols()));
  if (!T.allFinite()) throw std::invalid_argument("factors of modes must be finite");
}

}  // namespace

ReducedBody project_modes(const ReducedBody& body, const MatrixXd& T) {
  require(body, T);
  ReducedBody b = body;
  b.modes = static_cast<int>(T.cols());
  b.mode_names.clear();
  for (int k = 0; k < b.modes; ++k) b.mode_names.push_back(fmt::format("combination {}", k + 1));
  b.user_from_modal.setIdentity(b.modes, b.modes);
  b.eigenfrequencies.resize(0);

  project_symmetric(b.mass_matrix, T);
  if (!is_positive_definite(b.mass_matrix))
    throw std::invalid_argument(
        fmt::format("reduced body '{}': the combinations of modes are dependent", body.name));
  project_symmetric(b.stiffness, T);
  project_symmetric(b.damping, T);
  project_columns(b.S, T);
  for (auto& block : b.S_position) project_columns(block, T);
  for (auto& row : b.S_modes)
    for (MatrixXd& block : row) project(block, T);
  for (BodyFrame& frame : b.frames) {
    project_columns(frame.X, T);
    project_columns(frame.X_theta, T);
  }
  project_columns(b.node_shapes, T);
  project_columns(b.stress, T);
  project_columns(b.strain, T);
  if (b.bar_stress) project_columns(b.bar_stress->shapes, T);
  if (b.mesh_inertia) project_columns(b.mesh_inertia->shapes, T);
  if (b.geometric) {
    for (MatrixXd& stiffness : b.geometric->stiffness) project_symmetric(stiffness, T);
    project_columns(b.geometric->boundary_loads, T);
  }
  if (b.stretching)
    for (MatrixXd& form : b.stretching->forms) project_symmetric(form, beside_rotation(T));
  return b;
}

}  // namespace mimbre
