#include "reduction/stiffening/solid_stiffening.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "math/once/decompositions.h"
#include "reduction/tied_model.h"

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

/// Of the largest of its kind: what is below is round-off.
constexpr double negligible_stiffening = 1e-6;

}  // namespace

MatrixXd unit_inertia_forces(const SolidMesh& mesh, const FeMatrices& matrices) {
  MatrixXd accelerations = MatrixXd::Zero(matrices.mass.rows(), GeometricStiffness::boundary);
  for (std::size_t r = 0; r < matrices.dofs.size(); ++r) {
    const Dof& dof = matrices.dofs[r];
    if (dof.direction > 2) continue;
    const Vector3d position = mesh.nodes.col(dof.node);
    const auto row = static_cast<Index>(r);
    for (int k = 0; k < 3; ++k) {
      // ω × (ω × r) for ω_k² and for ω_k ω_next, both orders together.
      const int next = (k + 1) % 3;
      const Vector3d square = position[k] * Vector3d::Unit(k) - position,
                     mixed = position[next] * Vector3d::Unit(k) + position[k] * Vector3d::Unit(next);
      accelerations(row, GeometricStiffness::angular_velocity + k) = square[dof.direction];
      accelerations(row, GeometricStiffness::angular_velocity + 3 + k) = mixed[dof.direction];
      accelerations(row, GeometricStiffness::acceleration + k) = dof.direction == k;
      accelerations(row, GeometricStiffness::angular_acceleration + k) =
          Vector3d(Vector3d::Unit(k)).cross(position)[dof.direction];
    }
  }
  return -symmetric_times(matrices.mass, accelerations);
}

GeometricStiffness solid_stiffening(const SolidMesh& mesh, const MatrixXd& responses, const MatrixXd& shapes,
                                    const MatrixXd& stiffness, Index statics) {
  MatrixXd displacements(shapes.rows(), responses.cols() + statics);
  displacements.leftCols(responses.cols()) = responses;
  if (statics > 0)
    displacements.rightCols(statics) =
        shapes.leftCols(statics) * PivotedCholesky(stiffness.topLeftCorner(statics, statics))
                                       .solve(MatrixXd::Identity(statics, statics));
  std::vector<MatrixXd> projected;
  for (Index l = 0; l < displacements.cols(); ++l) {
    const Eigen::SparseMatrix<double> KG = geometric_stiffness(mesh, displacements.col(l));
    const MatrixXd k = shapes.transpose() * symmetric_times(KG, shapes);
    projected.push_back(0.5 * (k + k.transpose()));
  }
  const auto largest = [&](Index first, Index count) {
    double most = 0;
    for (Index l = first; l < first + count; ++l)
      most = std::max(most, projected[static_cast<std::size_t>(l)].cwiseAbs().maxCoeff());
    return most;
  };
  const Index boundary = GeometricStiffness::boundary;
  GeometricStiffness out;
  out.boundary_loads.resize(0, shapes.cols());
  for (Index l = 0; l < displacements.cols(); ++l) {
    const Index first = l < 6 ? 0 : l < boundary ? 3 * (l / 3) : boundary + 3 * ((l - boundary) / 3);
    const Index count = l < 6 ? 6 : std::min<Index>(3, displacements.cols() - first);
    const MatrixXd& k = projected[static_cast<std::size_t>(l)];
    if (!(k.cwiseAbs().maxCoeff() > negligible_stiffening * largest(first, count))) continue;
    int load = static_cast<int>(l);
    if (l >= boundary) {
      const Index row = out.boundary_loads.rows();
      out.boundary_loads.conservativeResize(row + 1, shapes.cols());
      out.boundary_loads.row(row) = stiffness.row(l - boundary);
      load = static_cast<int>(boundary + row);
    }
    out.loads.push_back(load);
    out.stiffness.push_back(k);
  }
  return out;
}

}  // namespace mimbre::fe
