#pragma once
#include <Eigen/Core>

#include "fe/elements/elastic_matrix.h"
#include "fe/elements/shell_membrane.h"

namespace mimbre::fe {

/// Plate that bends and shears (Reissner–Mindlin, shear factor 5/6): dofs w, θx, θy of each node (w along z,
/// rotations about x and y). The discrete Kirchhoff–Mindlin triangle and quadrilateral (Katili 1993, parts I
/// and II): of thin plates those of Batoz (DKT, DKQ), without locking. `nodes` (2 × 3 or 2 × 4)
/// anticlockwise, convex. Symmetric, full storage.
MembraneMatrix plate_stiffness(const PlaneNodes& nodes, const SheetElasticity& elastic, double thickness);

/// Curvatures at the nodes = matrix (3·nodes × dofs) · dofs: strains (xx, yy, engineering xy) per height z.
Eigen::MatrixXd nodal_curvatures(const PlaneNodes& nodes, const SheetElasticity& elastic, double thickness);

}  // namespace mimbre::fe
