#pragma once
#include "fe/elements/solid_element.h"

/// Stresses of solid elements and the stiffness that they give. Order of components: xx yy zz xy yz zx (body
/// axes), Pa; strains likewise, with engineering shears.
namespace mimbre::fe {

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// 6·nodes × 3·nodes: strains at the element's nodes, extrapolated from the points where they are most
/// accurate, of nodal displacements.
Eigen::MatrixXd nodal_strain_operator(const SolidGeometry& geometry, const ElementMaterial& material);

/// Nodes × nodes, symmetric, full storage: ∫ ∇Na·σ ∇Nb dV, σ of the nodal displacements (3 × nodes). The
/// geometric stiffness matrix is each entry times the 3 × 3 identity; its rule is that of the stiffness.
void solid_geometric_stiffness(const SolidGeometry& geometry, const ElementMaterial& material,
                               const NodePositions& displacements, NodalMatrix& stiffness);

}  // namespace mimbre::fe
