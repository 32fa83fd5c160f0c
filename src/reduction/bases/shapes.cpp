#include "reduction/bases/shapes.h"
#include "math/once/decompositions.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace mimbre::fe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

MatrixXd point_rows(const std::vector<Interface>& interfaces, const MatrixXd& z) {
  MatrixXd rows(z.rows(), z.cols());
  for (std::size_t i = 0; i < interfaces.size(); ++i)
    for (Index row = static_cast<Index>(6 * i), half = 0; half < 2; ++half, row += 3)
      rows.middleRows<3>(row) = interfaces[i].axes * z.middleRows<3>(row);
  return rows;
}

MatrixXd rigid_points(const std::vector<Interface>& interfaces) {
  MatrixXd motion(6 * interfaces.size(), 6);
  for (std::size_t i = 0; i < interfaces.size(); ++i) {
    auto own = motion.middleRows<6>(static_cast<Index>(6 * i));
    own.setIdentity();
    for (int k = 0; k < 3; ++k)
      own.block<3, 1>(0, 3 + k) = Vector3d(Vector3d::Unit(k)).cross(interfaces[i].point);
  }
  return motion;
}

std::vector<std::string> motion_names(const std::string& kind, const std::vector<Interface>& interfaces,
                                      Index first) {
  std::vector<std::string> names;
  for (auto i = static_cast<std::size_t>(first); i < interfaces.size(); ++i)
    for (const char* motion : {"x", "y", "z", "rx", "ry", "rz"})
      names.push_back(fmt::format("{} {}.{}", kind, interfaces[i].name, motion));
  return names;
}

std::vector<Index> retained_motions(const std::vector<Interface>& interfaces, Index first) {
  std::vector<Index> retained;
  for (auto i = static_cast<std::size_t>(first); i < interfaces.size(); ++i)
    for (std::size_t k = 0; k < 6; ++k)
      if (interfaces[i].motions[k] == Interface::Motion::retained)
        retained.push_back(static_cast<Index>(6 * i + k));
  return retained;
}

Shapes static_shapes(const TiedModel& tied, const FeMatrices& matrices,
                     const std::vector<Interface>& interfaces, Index first) {
  const std::vector<Index> retained = retained_motions(interfaces, first);
  const std::vector<std::string> names = motion_names("static", interfaces, 0);
  const auto count = static_cast<Index>(retained.size());
  MatrixXd z = MatrixXd::Zero(tied.boundaries(), count);
  Shapes shapes{MatrixXd(matrices.stiffness.rows(), count), z, {}};
  for (Index k = 0; k < count; ++k) {
    const Index motion = retained[static_cast<std::size_t>(k)];
    z(motion, k) = 1;
    shapes.names.push_back(names[static_cast<std::size_t>(motion)]);
  }
  if (count == 0) return shapes;
  const MatrixXd moved = tied.expand(MatrixXd::Zero(tied.internals(), count), z);
  const MatrixXd x = -tied.solve(tied.restrict(symmetric_times(matrices.stiffness, moved)));
  shapes.dofs = tied.expand(x, z);
  shapes.points = point_rows(interfaces, tied.motions(x, z));
  return shapes;
}

Shapes held_shapes(const TiedModel& tied, const std::vector<Interface>& interfaces, const MatrixXd& x,
                   const std::string& kind) {
  const MatrixXd z = MatrixXd::Zero(tied.boundaries(), x.cols());
  Shapes shapes{tied.expand(x, z), point_rows(interfaces, tied.motions(x, z)), {}};
  for (Index k = 0; k < x.cols(); ++k) shapes.names.push_back(fmt::format("{} {}", kind, k + 1));
  return shapes;
}

Shapes join(const Shapes& a, const Shapes& b) {
  Shapes both{MatrixXd(a.dofs.rows(), a.dofs.cols() + b.dofs.cols()),
              MatrixXd(a.points.rows(), a.points.cols() + b.points.cols()), a.names};
  both.dofs << a.dofs, b.dofs;
  both.points << a.points, b.points;
  both.names.insert(both.names.end(), b.names.begin(), b.names.end());
  return both;
}

void to_tangent(const std::vector<Interface>& interfaces, const MatrixXd& R, Shapes& shapes) {
  const MatrixXd motion = rigid_points(interfaces);
  const MatrixXd part = solve(motion.topRows<6>(), shapes.points.topRows<6>());
  shapes.dofs -= R * part;
  shapes.points -= motion * part;
  shapes.points.topRows<6>().setZero();
}

void to_centre_of_mass(const FeMatrices& matrices, const std::vector<Interface>& interfaces,
                       const MatrixXd& R, Shapes& shapes) {
  const MatrixXd moved = R.leftCols(3), momenta = symmetric_times(matrices.mass, moved);
  const MatrixXd part = PivotedCholesky(moved.transpose() * momenta).solve(momenta.transpose() * shapes.dofs);
  shapes.dofs -= moved * part;
  shapes.points -= rigid_points(interfaces).leftCols(3) * part;
}

void to_mean_axes(const FeMatrices& matrices, const std::vector<Interface>& interfaces, const MatrixXd& R,
                  Shapes& shapes) {
  // Each shape's size before: what is rigid alone leaves round-off, which must not count as a shape.
  const VectorXd scale = shapes.dofs.cwiseProduct(symmetric_times(matrices.mass, shapes.dofs))
                             .colwise()
                             .sum()
                             .transpose()
                             .cwiseMax(1e-300)
                             .cwiseSqrt()
                             .cwiseInverse();
  const MatrixXd momenta = symmetric_times(matrices.mass, R);
  const MatrixXd part = PivotedCholesky(R.transpose() * momenta).solve(momenta.transpose() * shapes.dofs);
  shapes.dofs -= R * part;
  shapes.points -= rigid_points(interfaces) * part;
  const MatrixXd gram = shapes.dofs.transpose() * symmetric_times(matrices.mass, shapes.dofs);
  const EigenPairs pairs = symmetric_eigen(scale.asDiagonal() * gram * scale.asDiagonal());
  const Index kept = gram.cols() - 6;
  const MatrixXd turn = scale.asDiagonal() * pairs.vectors.rightCols(kept) *
                        pairs.values.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  shapes.dofs = (shapes.dofs * turn).eval();
  shapes.points = (shapes.points * turn).eval();
  shapes.names.clear();
  for (Index k = 0; k < kept; ++k) shapes.names.push_back(fmt::format("mean-axis {}", k + 1));
}

}  // namespace mimbre::fe
