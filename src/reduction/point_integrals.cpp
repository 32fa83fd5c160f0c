#include "reduction/point_integrals.h"

#include <array>

#include "fe/elements/mass_points.h"

namespace mimbre::fe {

using Eigen::Index;
using Eigen::MatrixXd;

void add_point_integrals(const SolidMesh& mesh, const std::vector<Dof>& dofs, const MatrixXd& shapes,
                         ReducedBody& body) {
  const Index modes = shapes.cols();
  body.mass = 0;
  body.first_moment.setZero();
  body.second_moment.setZero();
  body.S.setZero(3, modes);
  for (std::size_t i = 0; i < 3; ++i) {
    body.S_position[i].setZero(3, modes);
    for (MatrixXd& part : body.S_modes[i]) part.setZero(modes, modes);
  }
  std::array<MatrixXd, 3> moves, weighted;  // points × modes
  for_each_mass_points(mesh, dofs, shapes, [&](const MassPoints& points) {
    const Index count = points.masses.size();
    for (Index p = 0; p < count; ++p) {
      const Eigen::Vector3d place = points.places.col(p);
      body.mass += points.masses[p];
      body.first_moment += points.masses[p] * place;
      body.second_moment += points.masses[p] * place * place.transpose();
    }
    for (std::size_t i = 0; i < 3; ++i) {
      moves[i].resize(count, modes);
      for (Index p = 0; p < count; ++p) moves[i].row(p) = points.shapes.row(3 * p + static_cast<Index>(i));
      weighted[i] = points.masses.asDiagonal() * moves[i];
    }
    for (std::size_t j = 0; j < 3; ++j)
      for (Index p = 0; p < count; ++p) {
        body.S.row(static_cast<Index>(j)) += weighted[j].row(p);
        for (std::size_t i = 0; i < 3; ++i)
          body.S_position[i].row(static_cast<Index>(j)) +=
              points.places(static_cast<Index>(i), p) * weighted[j].row(p);
      }
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = i; j < 3; ++j) body.S_modes[i][j].noalias() += moves[i].transpose() * weighted[j];
  });
  for (std::size_t i = 0; i < 3; ++i) {
    body.S_modes[i][i] = (0.5 * (body.S_modes[i][i] + body.S_modes[i][i].transpose())).eval();
    for (std::size_t j = 0; j < i; ++j) body.S_modes[i][j] = body.S_modes[j][i].transpose();
  }
}

}  // namespace mimbre::fe
