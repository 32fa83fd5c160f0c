#include "fe/elements/hourglass.h"

#include <Eigen/LU>

#include "fe/elements/congruence.h"
#include "fe/elements/orthonormal.h"

namespace mimbre::fe {
namespace {

constexpr int kNodes = 20, kModes = 6;
using HourglassModes = Eigen::Matrix<double, 3 * kNodes, kModes>;
using Nodal = Eigen::Matrix<double, 3, kNodes>;

/// In reference coordinates: covariant components at the nodes, so that the strains are those of the brick
/// [-1, 1]³ whatever affine image the element is.
HourglassModes reference_modes(const NodePositions& reference) {
  HourglassModes modes = HourglassModes::Zero();
  for (int n = 0; n < kNodes; ++n)
    for (int pair = 0; pair < 3; ++pair) {
      const int i = pair, j = (pair + 1) % 3, k = (pair + 2) % 3;
      const double x = reference(i, n), y = reference(j, n);
      for (int order = 0; order < 2; ++order) {
        const double along = order == 0 ? 1 : reference(k, n);
        modes(3 * n + i, 2 * pair + order) = x * (3 * y * y - 1) * along;
        modes(3 * n + j, 2 * pair + order) = -y * (3 * x * x - 1) * along;
      }
    }
  return modes;
}

}  // namespace

void add_hourglass_stiffness(const SolidGeometry& geometry, const ElementMaterial& material,
                             SolidMatrix& stiffness) {
  static const NodePositions reference = reference_nodes(ElementType::hex20);
  static const HourglassModes covariant = reference_modes(reference);
  static const ShapeGradients centre = shape_gradients(ElementType::hex20, Eigen::Vector3d::Zero());
  const Eigen::Matrix3d J = geometry.nodes.lazyProduct(centre.transpose());
  const Eigen::Matrix3d to_body = J.inverse().transpose();
  HourglassModes modes;
  for (int n = 0; n < kNodes; ++n) modes.middleRows<3>(3 * n) = to_body * covariant.middleRows<3>(3 * n);

  // The test vectors are the modes without what linear displacements in body coordinates and quadratic ones
  // in reference coordinates have of them.
  Eigen::Matrix<double, kNodes, 10> smooth;
  const Eigen::Vector3d middle = geometry.nodes.rowwise().mean();
  const double size = (geometry.nodes.rowwise().maxCoeff() - geometry.nodes.rowwise().minCoeff()).norm();
  for (int n = 0; n < kNodes; ++n) {
    const Eigen::Vector3d x = (geometry.nodes.col(n) - middle) / size, r = reference.col(n);
    smooth.row(n) << 1, x.x(), x.y(), x.z(), r.x() * r.x(), r.y() * r.y(), r.z() * r.z(), r.x() * r.y(),
        r.y() * r.z(), r.z() * r.x();
  }
  const Eigen::Matrix<double, kNodes, 10> basis = orthonormal(smooth);
  HourglassModes tests = modes;
  for (int m = 0; m < kModes; ++m)
    for (int k = 0; k < 3; ++k) {
      Eigen::Matrix<double, kNodes, 1> component;
      for (int n = 0; n < kNodes; ++n) component[n] = modes(3 * n + k, m);
      component -= projected(basis, component);
      for (int n = 0; n < kNodes; ++n) tests(3 * n + k, m) = component[n];
    }
  for (int m = 0; m < kModes; ++m) tests.col(m) /= modes.col(m).squaredNorm();

  // Energy of the modes by full integration.
  Eigen::Matrix<double, kModes, kModes> energy = Eigen::Matrix<double, kModes, kModes>::Zero();
  ShapeGradients gradients;
  for (const ShapeSample& sample : stiffness_samples(ElementType::hex20)) {
    const double dV = sample.weight * body_gradients(geometry, sample, gradients);
    Eigen::Matrix<double, 6, kModes> strain;
    for (int m = 0; m < kModes; ++m) {
      const Eigen::Matrix3d g = Nodal::Map(modes.col(m).data()) * gradients.transpose();
      strain.col(m) << g(0, 0), g(1, 1), g(2, 2), g(0, 1) + g(1, 0), g(1, 2) + g(2, 1), g(2, 0) + g(0, 2);
    }
    add_congruent(energy, dV, strain, material.at(geometry.nodes.lazyProduct(sample.values)));
  }
  add_congruent(stiffness, kHourglassShare, tests.transpose(), energy);
}

}  // namespace mimbre::fe
