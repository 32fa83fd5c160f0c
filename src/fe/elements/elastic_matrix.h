#pragma once
#include "mimbre/fe_mesh.h"

namespace mimbre::fe {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Stress = matrix · strain of an isotropic material, order as ElasticMatrix.
Matrix6 elasticity(const Material& material);

/// The material's, in its own directions.
Matrix6 elastic_matrix(const NamedMaterial& material);

/// The same in body axes; columns of `axes`: the directions of the material in body axes.
Matrix6 turned(const Matrix6& elastic, const Eigen::Matrix3d& axes);

/// Of a sheet without stress across it: in-plane stress by in-plane strain (xx yy, engineering xy) and
/// transverse shear stress by shear strain (yz, zx).
struct SheetElasticity {
  Eigen::Matrix3d plane;
  Eigen::Matrix2d shear;  ///< order zx, yz
};
/// Share of the transverse shear stiffness, whose stress is not the same through the thickness.
constexpr double kShearFactor = 5.0 / 6;
SheetElasticity sheet_elasticity(const Matrix6& elastic);

/// Directions of a material at a place, columns.
Eigen::Matrix3d material_axes(const Orientation& orientation, const Eigen::Vector3d& at);

/// On a shell with this normal: the third is the normal, the first the projection of the orientation's first
/// onto the shell (of its second, where the first is nearly the normal, as in CalculiX and Abaqus).
Eigen::Matrix3d material_axes_on(const Orientation& orientation, const Eigen::Vector3d& at,
                                 const Eigen::Vector3d& normal);

/// The elasticity of an element, wherever one asks in it.
class ElementMaterial {
 public:
  /// Isotropic.
  ElementMaterial(const Material& material);  // NOLINT: a material is one of an element
  /// Without an orientation, in body axes.
  ElementMaterial(const NamedMaterial& material, const Orientation* orientation);

  bool isotropic() const { return isotropic_; }
  double density() const { return density_; }
  /// Lamé's constants of an isotropic material.
  double lame() const { return lame_; }
  double shear() const { return shear_; }
  /// Stress by strain in body axes.
  Matrix6 at(const Eigen::Vector3d& place) const;
  /// Of a shell, in its axes (columns; the last is the normal).
  SheetElasticity sheet_at(const Eigen::Vector3d& place, const Eigen::Matrix3d& axes) const;

 private:
  bool isotropic_ = true;
  double density_ = 0, lame_ = 0, shear_ = 0;
  Matrix6 elastic_;        ///< in the material's directions
  SheetElasticity sheet_;  ///< of an isotropic one
  Orientation orientation_;
};

/// Throws std::invalid_argument unless Young's modulus and density are positive and finite and Poisson's
/// ratio lies in (-1, 0.5).
void check_elastic(const Material& material);

/// Throws std::invalid_argument unless it is finite, symmetric and positive definite.
void check_elastic_matrix(const ElasticMatrix& elastic);

}  // namespace mimbre::fe
