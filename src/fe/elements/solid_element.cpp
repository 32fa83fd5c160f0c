#include "fe/elements/solid_element.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

#include "fe/elements/hourglass.h"

namespace mimbre::fe {
namespace {

/// Relative to the cube of the element's extent; real slivers have far more.
constexpr double kNoVolume = 1e-12;

double checked(double determinant, const SolidGeometry& geometry) {
  if (!(determinant > geometry.least_determinant))
    throw std::invalid_argument(
        determinant < -geometry.least_determinant
            ? fmt::format("is turned inside out (Jacobian {:.3g}): its nodes are in the wrong order or moved "
                          "through the opposite side",
                          determinant)
            : fmt::format("has no volume (Jacobian {:.3g})", determinant));
  return determinant;
}

Eigen::Matrix3d jacobian(const SolidGeometry& geometry, const ShapeGradients& reference) {
  return geometry.nodes * reference.leftCols(geometry.nodes.cols()).transpose();
}

/// Displacements of the incompatible modes leave the energy stationary.
void condense(SolidMatrix& all, int dofs, SolidMatrix* condensation) {
  constexpr int kModeDofs = 9;
  using Modes = Eigen::Matrix<double, kModeDofs, kModeDofs>;
  using Coupling =
      Eigen::Matrix<double, kModeDofs, Eigen::Dynamic, Eigen::ColMajor, kModeDofs, kMaxSolidDofs>;
  const Coupling coupling = all.bottomLeftCorner(kModeDofs, dofs);
  const Modes modes = all.bottomRightCorner<kModeDofs, kModeDofs>();
  const Coupling follow = -modes.llt().solve(coupling);
  if (condensation != nullptr) condensation->bottomRows(kModeDofs) = follow;
  const SolidMatrix condensed = all.topLeftCorner(dofs, dofs) + coupling.transpose().lazyProduct(follow);
  all = condensed;
}

}  // namespace

SolidGeometry solid_geometry(ElementType type, const NodePositions& nodes, bool reduced) {
  SolidGeometry geometry{type, nodes, reduced && type == ElementType::hex20};
  const double extent = (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm();
  geometry.least_determinant = kNoVolume * extent * extent * extent;
  if (incompatible_modes(type) > 0) {
    static const ShapeGradients centre = shape_gradients(ElementType::hex8, Eigen::Vector3d::Zero());
    const Eigen::Matrix3d J0 = jacobian(geometry, centre);
    geometry.incompatible_map = checked(J0.determinant(), geometry) * J0.inverse().transpose();
  }
  return geometry;
}

double volume_ratio(const SolidGeometry& geometry, const ShapeSample& sample) {
  return checked(jacobian(geometry, sample.gradients).determinant(), geometry);
}

double body_gradients(const SolidGeometry& geometry, const ShapeSample& sample, ShapeGradients& gradients) {
  const Eigen::Matrix3d J = jacobian(geometry, sample.gradients);
  const double determinant = checked(J.determinant(), geometry);
  const Eigen::Matrix3d to_body = J.inverse().transpose();
  gradients = to_body.lazyProduct(sample.gradients);
  const int extra = incompatible_modes(geometry.type);
  if (extra > 0)
    gradients.rightCols(extra) =
        (geometry.incompatible_map / determinant).lazyProduct(sample.gradients.rightCols(extra));
  return determinant;
}

const ShapeSamples& stiffness_samples(const SolidGeometry& geometry) {
  return geometry.reduced ? stress_samples(geometry.type) : stiffness_samples(geometry.type);
}

namespace {

/// ∫ λ div(u) div(v) + 2μ ε(u):ε(v) of two functions with the gradients g and, times dV, scaled.
Eigen::Matrix3d isotropic_block(const ElementMaterial& material, const Eigen::Vector3d& g,
                                const Eigen::Vector3d& scaled) {
  Eigen::Matrix3d block =
      material.lame() * g * scaled.transpose() + material.shear() * scaled * g.transpose();
  block.diagonal().array() += material.shear() * g.dot(scaled);
  return block;
}

using StrainBlock = Eigen::Matrix<double, 6, 3>;
StrainBlock strain_block(const Eigen::Vector3d& g) {
  StrainBlock strain;
  strain << g.x(), 0, 0,  //
      0, g.y(), 0,        //
      0, 0, g.z(),        //
      g.y(), g.x(), 0,    //
      0, g.z(), g.y(),    //
      g.z(), 0, g.x();
  return strain;
}

}  // namespace

void function_stiffness(const SolidGeometry& geometry, const ElementMaterial& material,
                        SolidMatrix& stiffness) {
  const int functions = node_count(geometry.type) + incompatible_modes(geometry.type);
  stiffness.setZero(3 * functions, 3 * functions);
  ShapeGradients gradients;
  for (const ShapeSample& sample : stiffness_samples(geometry)) {
    const double dV = sample.weight * body_gradients(geometry, sample, gradients);
    if (material.isotropic()) {
      for (int b = 0; b < functions; ++b) {
        const Eigen::Vector3d scaled = dV * gradients.col(b);
        for (int a = b; a < functions; ++a)
          stiffness.block<3, 3>(3 * a, 3 * b) += isotropic_block(material, gradients.col(a), scaled);
      }
      continue;
    }
    const Matrix6 elastic = dV * material.at(geometry.nodes.lazyProduct(sample.values));
    for (int b = 0; b < functions; ++b) {
      const StrainBlock stress = elastic * strain_block(gradients.col(b));
      for (int a = b; a < functions; ++a)
        stiffness.block<3, 3>(3 * a, 3 * b) += strain_block(gradients.col(a)).transpose() * stress;
    }
  }
  if (geometry.reduced) add_hourglass_stiffness(geometry, material, stiffness);
  stiffness.triangularView<Eigen::StrictlyUpper>() = stiffness.transpose();
}

void solid_stiffness(const SolidGeometry& geometry, const ElementMaterial& material, SolidMatrix& stiffness,
                     SolidMatrix* condensation) {
  function_stiffness(geometry, material, stiffness);
  const int dofs = 3 * node_count(geometry.type);
  if (condensation != nullptr) condensation->setIdentity(stiffness.rows(), dofs);
  if (incompatible_modes(geometry.type) == 0) return;
  condense(stiffness, dofs, condensation);
  stiffness.triangularView<Eigen::StrictlyUpper>() = stiffness.transpose();
}

void solid_mass(const SolidGeometry& geometry, double density, const ShapeSamples& samples,
                NodalMatrix& mass) {
  const int nodes = node_count(geometry.type);
  mass.setZero(nodes, nodes);
  for (const ShapeSample& sample : samples) {
    const double dm = density * sample.weight * volume_ratio(geometry, sample);
    for (int b = 0; b < nodes; ++b)
      mass.col(b).tail(nodes - b) += dm * sample.values[b] * sample.values.tail(nodes - b);
  }
  mass.triangularView<Eigen::StrictlyUpper>() = mass.transpose();
}

void solid_mass(const SolidGeometry& geometry, double density, NodalMatrix& mass) {
  solid_mass(geometry, density, mass_samples(geometry.type), mass);
  if (!geometry.reduced) return;
  NodalMatrix few;
  solid_mass(geometry, density, stiffness_samples(geometry), few);
  mass = kExactShare * mass + (1 - kExactShare) * few;
}

}  // namespace mimbre::fe
