#include "fe/elements/elastic_matrix.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <stdexcept>

#include "math/once/decompositions.h"

namespace mimbre::fe {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Directions of the six components.
constexpr std::array<std::array<int, 2>, 6> kComponents{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}}};

}  // namespace

Matrix6 elasticity(const Material& material) {
  const double shear = material.young / (2 * (1 + material.poisson));
  const double lame = 2 * shear * material.poisson / (1 - 2 * material.poisson);
  Matrix6 matrix = Matrix6::Zero();
  matrix.topLeftCorner<3, 3>().setConstant(lame);
  matrix.diagonal() << Vector3d::Constant(lame + 2 * shear), Vector3d::Constant(shear);
  return matrix;
}

Matrix6 elastic_matrix(const NamedMaterial& material) {
  return material.elastic ? *material.elastic : elasticity(material.material);
}

ElasticMatrix elastic_matrix(const EngineeringConstants& c) {
  const std::array<std::pair<const char*, double>, 6> moduli{
      {{"E1", c.E1}, {"E2", c.E2}, {"E3", c.E3}, {"G12", c.G12}, {"G13", c.G13}, {"G23", c.G23}}};
  for (const auto& [name, value] : moduli)
    if (!(std::isfinite(value) && value > 0))
      throw std::invalid_argument(fmt::format("{} must be positive, is {}", name, value));
  Matrix3d compliance;
  compliance << 1 / c.E1, -c.nu12 / c.E1, -c.nu13 / c.E1,  //
      -c.nu12 / c.E1, 1 / c.E2, -c.nu23 / c.E2,            //
      -c.nu13 / c.E1, -c.nu23 / c.E2, 1 / c.E3;
  const Vector3d unit = compliance.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix3d scaled = unit.asDiagonal() * compliance * unit.asDiagonal();
  if (!scaled.allFinite() || !(eigenvalues3(scaled)[0] > 1e-9))
    throw std::invalid_argument(
        fmt::format("Poisson's ratios {}, {}, {} (12, 13, 23) do not go with these Young's moduli: some "
                    "strain would have no energy",
                    c.nu12, c.nu13, c.nu23));
  Matrix6 elastic = Matrix6::Zero();
  elastic.topLeftCorner<3, 3>() = unit.asDiagonal() * scaled.inverse() * unit.asDiagonal();
  elastic.diagonal().tail<3>() << c.G12, c.G23, c.G13;
  return 0.5 * (elastic + elastic.transpose());
}

Matrix6 turned(const Matrix6& elastic, const Matrix3d& axes) {
  // Strain in the material's directions of strain in body axes: e' = Rᵀ e R.
  Matrix6 strain;
  for (int k = 0; k < 6; ++k) {
    const auto [i, j] = kComponents[static_cast<std::size_t>(k)];
    Matrix3d unit = Matrix3d::Zero();
    unit(i, j) = unit(j, i) = i == j ? 1 : 0.5;
    const Matrix3d own = axes.transpose() * unit * axes;
    for (int l = 0; l < 6; ++l) {
      const auto [a, b] = kComponents[static_cast<std::size_t>(l)];
      strain(l, k) = (a == b ? 1 : 2) * own(a, b);
    }
  }
  const Matrix6 out = strain.transpose() * elastic * strain;
  return 0.5 * (out + out.transpose());
}

SheetElasticity sheet_elasticity(const Matrix6& elastic) {
  // Components that the sheet has, and the one whose stress vanishes (zz).
  constexpr std::array<int, 5> kept{0, 1, 3, 5, 4};
  Eigen::Matrix<double, 5, 5> sheet;
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j)
      sheet(i, j) = elastic(kept[static_cast<std::size_t>(i)], kept[static_cast<std::size_t>(j)]) -
                    elastic(kept[static_cast<std::size_t>(i)], 2) *
                        elastic(2, kept[static_cast<std::size_t>(j)]) / elastic(2, 2);
  return {sheet.topLeftCorner<3, 3>(), sheet.bottomRightCorner<2, 2>()};
}

Matrix3d material_axes(const Orientation& orientation, const Vector3d& at) {
  if (orientation.kind == Orientation::Kind::rectangular) return orientation.axes;
  const Vector3d axis = orientation.axes.col(2).normalized();
  const Vector3d arm = at - orientation.origin;
  const Vector3d radial = arm - axis.dot(arm) * axis;
  if (!(radial.norm() > 1e-9 * arm.norm()))
    throw std::invalid_argument("lies on the axis of the cylindrical orientation of its material");
  Matrix3d axes;
  axes.col(0) = radial.normalized();
  axes.col(2) = axis;
  axes.col(1) = axis.cross(axes.col(0));
  return axes;
}

Matrix3d material_axes_on(const Orientation& orientation, const Vector3d& at, const Vector3d& normal) {
  constexpr double nearly_normal = 0.99996;  // cosine of half a degree
  const Matrix3d axes = material_axes(orientation, at);
  Vector3d first = axes.col(0);
  if (std::abs(first.dot(normal)) > nearly_normal) first = axes.col(2);
  Matrix3d on;
  on.col(0) = (first - normal.dot(first) * normal).normalized();
  on.col(2) = normal;
  on.col(1) = normal.cross(on.col(0));
  return on;
}

ElementMaterial::ElementMaterial(const Material& material)
    : density_(material.density), elastic_(elasticity(material)) {
  const double nu = material.poisson;
  shear_ = material.young / (2 * (1 + nu));
  lame_ = 2 * shear_ * nu / (1 - 2 * nu);
  sheet_.plane << 1, nu, 0, nu, 1, 0, 0, 0, (1 - nu) / 2;
  sheet_.plane *= material.young / (1 - nu * nu);
  sheet_.shear = shear_ * Eigen::Matrix2d::Identity();
}

ElementMaterial::ElementMaterial(const NamedMaterial& material, const Orientation* orientation)
    : ElementMaterial(material.material) {
  if (!material.elastic) return;
  isotropic_ = false;
  elastic_ = *material.elastic;
  if (orientation != nullptr) orientation_ = *orientation;
}

Matrix6 ElementMaterial::at(const Vector3d& place) const {
  return isotropic_ ? elastic_ : turned(elastic_, material_axes(orientation_, place));
}

SheetElasticity ElementMaterial::sheet_at(const Vector3d& place, const Matrix3d& axes) const {
  if (isotropic_) return sheet_;
  return sheet_elasticity(
      turned(elastic_, axes.transpose() * material_axes_on(orientation_, place, axes.col(2))));
}

void check_elastic(const Material& material) {
  const auto positive = [](const char* name, double value) {
    if (!(std::isfinite(value) && value > 0))
      throw std::invalid_argument(fmt::format("{} must be positive, is {}", name, value));
  };
  positive("Young's modulus", material.young);
  positive("density", material.density);
  if (!(material.poisson > -1 && material.poisson < 0.5))
    throw std::invalid_argument(
        fmt::format("Poisson's ratio must lie in (-1, 0.5), is {}", material.poisson));
}

void check_elastic_matrix(const ElasticMatrix& elastic) {
  if (!elastic.allFinite() || !(elastic.diagonal().array() > 0).all())
    throw std::invalid_argument("its elastic constants must be finite, those of the diagonal positive");
  const double largest = elastic.cwiseAbs().maxCoeff();
  if (!((elastic - elastic.transpose()).cwiseAbs().maxCoeff() <= 1e-9 * largest))
    throw std::invalid_argument("its elastic constants must be symmetric");
  const Eigen::Matrix<double, 6, 1> unit = elastic.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix6 scaled = unit.asDiagonal() * elastic * unit.asDiagonal();
  if (!(eigenvalues6(scaled)[0] > 1e-9))
    throw std::invalid_argument("its elastic constants are not positive definite: some strain has no energy");
}

}  // namespace mimbre::fe
