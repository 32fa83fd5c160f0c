#include "reduction/point_integrals.h"

#include <array>

#include "fe/elements/mass_points.h"
#include "fe/lumped_masses.h"
#include "math/cross_matrix.h"
#include "reduction/shape_integrals.h"

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

void add_lumped_integrals(const SolidMesh& mesh, const std::vector<Dof>& dofs, const MatrixXd& shapes,
                          ReducedBody& body) {
  std::vector<std::array<Index, 6>> rows(static_cast<std::size_t>(mesh.nodes.cols()),
                                         {-1, -1, -1, -1, -1, -1});
  for (std::size_t r = 0; r < dofs.size(); ++r)
    rows[static_cast<std::size_t>(dofs[r].node)][static_cast<std::size_t>(dofs[r].direction)] =
        static_cast<Index>(r);
  clear_shape_integrals(body, shapes.cols());
  Eigen::Matrix3Xd moves(3, shapes.cols()), turns(3, shapes.cols());
  for (const LumpedMass& lump : lumped_masses(mesh)) {
    for (int k = 0; k < 3; ++k) {
      const auto& own = rows[static_cast<std::size_t>(lump.node)];
      const Index move = own[static_cast<std::size_t>(k)], turn = own[static_cast<std::size_t>(3 + k)];
      moves.row(k).setZero();
      turns.row(k).setZero();
      if (move >= 0) moves.row(k) = shapes.row(move);
      if (turn >= 0) turns.row(k) = shapes.row(turn);
    }
    moves -= cross_matrix(lump.offset) * turns;
    add_mass_point(body, lump.mass, mesh.nodes.col(lump.node) + lump.offset, moves);
    if (!lump.second.isZero(0)) add_turning_part(body, lump.second, turns);
  }
  complete_shape_integrals(body);
}

}  // namespace mimbre::fe
