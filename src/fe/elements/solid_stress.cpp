#include "fe/elements/solid_stress.h"
#include "math/once/decompositions.h"

#include <Eigen/Core>

namespace mimbre::fe {
namespace {

using StrainOperator = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxSolidDofs>;

/// Strain = operator · displacements of the functions whose gradients are given.
StrainOperator strain_operator(const ShapeGradients& gradients) {
  StrainOperator strain = StrainOperator::Zero(6, 3 * gradients.cols());
  for (Eigen::Index a = 0; a < gradients.cols(); ++a) {
    const double x = gradients(0, a), y = gradients(1, a), z = gradients(2, a);
    strain.block<6, 3>(0, 3 * a) << x, 0, 0,  //
        0, y, 0,                              //
        0, 0, z,                              //
        y, x, 0,                              //
        0, z, y,                              //
        z, 0, x;
  }
  return strain;
}

/// Displacements of all functions = matrix · nodal displacements.
SolidMatrix function_displacements(const SolidGeometry& geometry, const ElementMaterial& material) {
  const int dofs = 3 * node_count(geometry.type);
  if (incompatible_modes(geometry.type) == 0) return SolidMatrix::Identity(dofs, dofs);
  SolidMatrix stiffness, condensation;
  solid_stiffness(geometry, material, stiffness, &condensation);
  return condensation;
}

Eigen::Matrix3d tensor(const Vector6& s) {
  return (Eigen::Matrix3d() << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2]).finished();
}

/// As many polynomials as the type has stress points.
Eigen::RowVectorXd extrapolation_basis(ElementType type, const Eigen::Vector3d& at) {
  const double x = at.x(), y = at.y(), z = at.z();
  switch (type) {
    case ElementType::tet4:
      return Eigen::RowVectorXd::Ones(1);
    case ElementType::tet10:
      return Eigen::RowVector4d(1, x, y, z);
    case ElementType::wedge6:
      return Eigen::RowVector2d(1, z);
    case ElementType::wedge15:
      return (Eigen::RowVectorXd(6) << 1, x, y, z, x * z, y * z).finished();
    case ElementType::pyramid5:
      return Eigen::RowVectorXd::Ones(1);
    case ElementType::pyramid13:
      return (Eigen::RowVectorXd(5) << 1, x, y, z, x * y).finished();
    default:
      return (Eigen::RowVectorXd(8) << 1, x, y, z, x * y, y * z, z * x, x * y * z).finished();
  }
}

/// Nodes × stress points.
Eigen::MatrixXd extrapolation(ElementType type) {
  const Quadrature& rule = stress_points(type);
  const NodePositions nodes = reference_nodes(type);
  const auto points = static_cast<Eigen::Index>(rule.size());
  Eigen::MatrixXd at_points(points, points);
  for (Eigen::Index p = 0; p < points; ++p) at_points.row(p) = extrapolation_basis(type, rule[p].at);
  Eigen::MatrixXd at_nodes(nodes.cols(), points);
  for (Eigen::Index n = 0; n < nodes.cols(); ++n) at_nodes.row(n) = extrapolation_basis(type, nodes.col(n));
  return at_nodes * inverse(at_points);
}

}  // namespace

Eigen::MatrixXd nodal_strain_operator(const SolidGeometry& geometry, const ElementMaterial& material) {
  const SolidMatrix condensation = function_displacements(geometry, material);
  const ShapeSamples& samples = stress_samples(geometry.type);
  const Eigen::MatrixXd weights = extrapolation(geometry.type);
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(6 * weights.rows(), condensation.cols());
  ShapeGradients gradients;
  for (std::size_t p = 0; p < samples.size(); ++p) {
    body_gradients(geometry, samples[p], gradients);
    const Eigen::MatrixXd strain = strain_operator(gradients) * condensation;
    for (Eigen::Index n = 0; n < weights.rows(); ++n)
      result.middleRows<6>(6 * n) += weights(n, static_cast<Eigen::Index>(p)) * strain;
  }
  return result;
}

void solid_geometric_stiffness(const SolidGeometry& geometry, const ElementMaterial& material,
                               const NodePositions& displacements, NodalMatrix& stiffness) {
  const int nodes = node_count(geometry.type);
  using Displacements = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxSolidDofs, 1>;
  Displacements all = Displacements::Map(displacements.data(), 3 * nodes);
  if (incompatible_modes(geometry.type) > 0)
    all = function_displacements(geometry, material).lazyProduct(Displacements(all)).eval();
  stiffness.setZero(nodes, nodes);
  ShapeGradients gradients;
  for (const ShapeSample& sample : stiffness_samples(geometry)) {
    const double dV = sample.weight * body_gradients(geometry, sample, gradients);
    const Vector6 strain = strain_operator(gradients).lazyProduct(all);
    const Matrix6 elastic = material.at(geometry.nodes.lazyProduct(sample.values));
    const Eigen::Matrix3d stress = tensor(dV * (elastic * strain));
    const auto g = gradients.leftCols(nodes);
    stiffness += g.transpose().lazyProduct((stress * g).eval());
  }
  stiffness.triangularView<Eigen::StrictlyUpper>() = stiffness.transpose();
}

}  // namespace mimbre::fe
