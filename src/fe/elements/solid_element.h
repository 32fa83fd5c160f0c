#pragma once
#include <Eigen/Core>

#include "fe/elements/elastic_matrix.h"
#include "fe/elements/solid_sample.h"
#include "mimbre/fe_mesh.h"

/// Isoparametric solid elements, linear elasticity. Element dofs: x, y, z of the first node, then
/// of the next ones (body axes). Nothing here allocates on the heap. Functions throw std::invalid_argument
/// where an element is turned inside out or has no volume.
///
/// The 8-node brick has three incompatible displacement modes 1 − ξ², 1 − η², 1 − ζ² besides its nodes'
/// (Wilson et al. 1973; made to pass the patch test with the Jacobian of the centre: Taylor, Beresford,
/// Wilson 1976), which are condensed: it bends without locking. CalculiX's C3D8 is the element without these
/// modes, its C3D8I has them as first published, which is the same where opposite faces are parallel.
///
/// The 20-node brick with reduced integration (2 × 2 × 2 points of stiffness and mass, as CalculiX's C3D20R)
/// has six motions that none of the points sees, such as u = ξ(3η² − 1), v = −η(3ξ² − 1) and its product with
/// ζ. They get a share of the energy that they have by full integration, which rigid motions, constant
/// strains and, in parallelepipeds, all quadratic displacements do not feel.
namespace mimbre::fe {

constexpr int kMaxSolidDofs = 3 * kMaxSolidNodes;
using SolidMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxSolidDofs, kMaxSolidDofs>;
using NodalMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxSolidNodes, kMaxSolidNodes>;

/// Where the element lies.
struct SolidGeometry {
  ElementType type;
  NodePositions nodes;                                             ///< 3 × nodes, body axes, m
  bool reduced = false;                                            ///< integration, of hex20
  double least_determinant = 0;                                    ///< below it there is no volume
  Eigen::Matrix3d incompatible_map = Eigen::Matrix3d::Identity();  ///< det J₀ J₀⁻ᵀ at the centre
};
SolidGeometry solid_geometry(ElementType type, const NodePositions& nodes, bool reduced = false);

/// The points of its stiffness.
const ShapeSamples& stiffness_samples(const SolidGeometry& geometry);

/// Determinant of the derivative of the position by the reference coordinates.
double volume_ratio(const SolidGeometry& geometry, const ShapeSample& sample);

/// Gradients by body coordinates of the functions of the nodes and, after them, the incompatible modes;
/// returns volume_ratio.
double body_gradients(const SolidGeometry& geometry, const ShapeSample& sample, ShapeGradients& gradients);

/// Of all functions, incompatible modes last, not condensed; symmetric, full storage.
void function_stiffness(const SolidGeometry& geometry, const ElementMaterial& material,
                        SolidMatrix& stiffness);

/// Symmetric, full storage. `condensation` (where wanted): displacements of all functions, incompatible modes
/// last, = condensation · nodal displacements; the identity for all types but hex8.
void solid_stiffness(const SolidGeometry& geometry, const ElementMaterial& material, SolidMatrix& stiffness,
                     SolidMatrix* condensation = nullptr);

/// Nodes × nodes, symmetric, full storage: the consistent mass matrix is each entry times the 3 × 3 identity.
void solid_mass(const SolidGeometry& geometry, double density, const ShapeSamples& samples,
                NodalMatrix& mass);
/// By the rule of the element.
void solid_mass(const SolidGeometry& geometry, double density, NodalMatrix& mass);

/// With reduced integration the mass is this share of the exact one's and else that of the few points, which
/// alone would leave motions without mass.
constexpr double kExactShare = 1e-3;

}  // namespace mimbre::fe
