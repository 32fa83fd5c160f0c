#pragma once
#include <Eigen/Core>
#include <vector>

#include "mimbre/fe_mesh.h"

/// Points and weights on the reference elements (reference_nodes in solid_shape.h): tetrahedron and triangle
/// over [0, 1], brick over [-1, 1]³, wedge the triangle over ζ in [-1, 1], pyramid over [-1, 1]² with its
/// apex at ζ = 1. Weights sum to their volumes.
namespace mimbre::fe {

struct IntegrationPoint {
  Eigen::Vector3d at;
  double weight;
};
using Quadrature = std::vector<IntegrationPoint>;

/// 1 point for tet4, 4 for tet10, 2×2×2 for hex8, 3×3×3 for hex20, 2 for wedge6, 9 for wedge15, as CalculiX
/// has them; 2×2×2 for pyramid5, 3×3×3 for pyramid13. All leave only rigid motions without energy, but a
/// single wedge6: it has one more, two together not.
const Quadrature& stiffness_quadrature(ElementType type);

/// Exact for the mass of elements with straight edges (hex20 and wedge15: and parallel ones).
const Quadrature& mass_quadrature(ElementType type);

/// Where stresses are most accurate (Barlow 1976): the points from which they are extrapolated.
const Quadrature& stress_points(ElementType type);

/// Products of the Gauss–Legendre rule of 1 to 3 points; ζ = 0 in the plane ones.
Quadrature brick_rule(int points_each_way);
Quadrature square_rule(int points_each_way);
/// 1, 3 or 6 points, exact up to degree 1, 2, 4; ζ = 0.
Quadrature triangle_rule(int points);

}  // namespace mimbre::fe
