#include "fe/elements/shell_bending.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "fe/elements/congruence.h"
#include "fe/elements/quadrature.h"

namespace mimbre::fe {
namespace {

using Row = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, 12>;
template <int Rows>
using Operator = Eigen::Matrix<double, Rows, Eigen::Dynamic, Eigen::ColMajor, Rows, 12>;

using Gradients = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::ColMajor, 2, 4>;

/// A side from its node to the next one. Along it the rotation towards the side β = (θy, −θx)·t is linear
/// plus a parabola of height Δβ, which follows from the nodes such that the mean shear strain is that of the
/// side's equilibrium.
struct Side {
  Eigen::Vector2d tangent;
  double length = 0;
  Row height;  ///< Δβ = height · dofs
  Row shear;   ///< mean shear strain along the side = shear · dofs
};

Side side(const PlaneNodes& nodes, int i, const SheetElasticity& elastic, double thickness) {
  const int count = static_cast<int>(nodes.cols());
  const int j = (i + 1) % count;
  Side side;
  side.tangent = nodes.col(j) - nodes.col(i);
  side.length = side.tangent.norm();
  side.tangent /= side.length;
  const double ratio = thickness / side.length;
  const Eigen::Vector2d& t = side.tangent;
  const Eigen::Vector3d stretch(t.x() * t.x(), t.y() * t.y(), 2 * t.x() * t.y());
  const double phi =
      ratio * ratio * stretch.dot(elastic.plane * stretch) / (kShearFactor * t.dot(elastic.shear * t));
  side.height.setZero(3 * count);
  side.height[3 * i] = -1;
  side.height[3 * j] = 1;
  for (int node : {i, j}) {
    side.height[3 * node + 1] = -side.length / 2 * side.tangent.y();
    side.height[3 * node + 2] = side.length / 2 * side.tangent.x();
  }
  side.height *= -1.5 / (side.length * (1 + phi));
  side.shear = -2.0 / 3 * phi * side.height;
  return side;
}

/// Functions and derivatives by the reference coordinates at a point.
struct PlateShapes {
  Gradients nodes;      ///< of the linear functions
  Gradients parabolas;  ///< of the sides' parabolas of unit height
  Gradients sides;      ///< shear strains (reference) of unit ones along the sides times their lengths
};

PlateShapes triangle_plate_shapes(double r, double s) {
  const std::array<double, 3> l{1 - r - s, r, s};
  PlateShapes shapes;
  shapes.nodes.resize(2, 3);
  shapes.nodes << -1, 1, 0, -1, 0, 1;
  shapes.parabolas.resize(2, 3);
  shapes.sides.resize(2, 3);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    shapes.parabolas.col(i) = 4 * (l[i] * shapes.nodes.col(j) + l[j] * shapes.nodes.col(i));
    shapes.sides.col(i) = l[i] * shapes.nodes.col(j) - l[j] * shapes.nodes.col(i);
  }
  return shapes;
}

PlateShapes square_plate_shapes(double x, double y) {
  PlateShapes shapes;
  shapes.nodes.resize(2, 4);
  shapes.nodes << -(1 - y), 1 - y, 1 + y, -(1 + y), -(1 - x), -(1 + x), 1 + x, 1 - x;
  shapes.nodes /= 4;
  shapes.parabolas.resize(2, 4);
  shapes.parabolas << -2 * x * (1 - y), 1 - y * y, -2 * x * (1 + y), -(1 - y * y),  //
      -(1 - x * x), -2 * y * (1 + x), 1 - x * x, -2 * y * (1 - x);
  shapes.parabolas /= 2;
  shapes.sides.resize(2, 4);
  shapes.sides << 1 - y, 0, -(1 + y), 0,  //
      0, 1 + x, 0, -(1 - x);
  shapes.sides /= 4;
  return shapes;
}

std::array<Side, 4> all_sides(const PlaneNodes& nodes, const SheetElasticity& elastic, double thickness) {
  std::array<Side, 4> sides;
  for (int k = 0; k < static_cast<int>(nodes.cols()); ++k) sides[k] = side(nodes, k, elastic, thickness);
  return sides;
}

PlateShapes plate_shapes(Eigen::Index count, const Eigen::Vector3d& at) {
  return count == 3 ? triangle_plate_shapes(at.x(), at.y()) : square_plate_shapes(at.x(), at.y());
}

Operator<3> curvature_operator(const std::array<Side, 4>& sides, const Gradients& nodes,
                               const Gradients& parabolas) {
  const int count = static_cast<int>(nodes.cols());
  Operator<3> curvature = Operator<3>::Zero(3, 3 * count);
  for (int k = 0; k < count; ++k) {
    curvature.col(3 * k + 1) << 0, -nodes(1, k), -nodes(0, k);  // β = (θy, −θx)
    curvature.col(3 * k + 2) << nodes(0, k), 0, nodes(1, k);
  }
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector2d& t = sides[k].tangent;
    const double x = parabolas(0, k), y = parabolas(1, k);
    curvature += Eigen::Vector3d(x * t.x(), y * t.y(), y * t.x() + x * t.y()) * sides[k].height;
  }
  return curvature;
}

}  // namespace

MembraneMatrix plate_stiffness(const PlaneNodes& nodes, const SheetElasticity& elastic, double thickness) {
  const int count = static_cast<int>(nodes.cols());
  const std::array<Side, 4> sides = all_sides(nodes, elastic, thickness);

  const double t3 = thickness * thickness * thickness;
  const Eigen::Matrix3d bending = t3 / 12 * elastic.plane;
  const Eigen::Matrix2d shear = kShearFactor * thickness * elastic.shear;

  static const Quadrature triangle = triangle_rule(3), square = square_rule(2);
  MembraneMatrix stiffness = MembraneMatrix::Zero(3 * count, 3 * count);
  for (const IntegrationPoint& point : count == 3 ? triangle : square) {
    const PlateShapes shapes = plate_shapes(count, point.at);
    const Eigen::Matrix2d J = nodes * shapes.nodes.transpose();
    const double dA = point.weight * J.determinant();
    const Eigen::Matrix2d to_plane = J.inverse().transpose();
    const Gradients s = to_plane * shapes.sides;
    const Operator<3> curvature =
        curvature_operator(sides, to_plane * shapes.nodes, to_plane * shapes.parabolas);
    Operator<2> strain = Operator<2>::Zero(2, 3 * count);
    for (int k = 0; k < count; ++k) strain += sides[k].length * s.col(k) * sides[k].shear;
    add_congruent(stiffness, dA, curvature, bending);
    add_congruent(stiffness, dA, strain, shear);
  }
  return 0.5 * (stiffness + stiffness.transpose());
}

Eigen::MatrixXd nodal_curvatures(const PlaneNodes& nodes, const SheetElasticity& elastic, double thickness) {
  const Eigen::Index count = nodes.cols();
  const std::array<Side, 4> sides = all_sides(nodes, elastic, thickness);
  const double low = count == 3 ? 0 : -1;
  const std::array<Eigen::Vector3d, 4> corners{
      Eigen::Vector3d(low, low, 0), Eigen::Vector3d(1, low, 0),
      count == 3 ? Eigen::Vector3d(0, 1, 0) : Eigen::Vector3d(1, 1, 0), Eigen::Vector3d(-1, 1, 0)};
  Eigen::MatrixXd curvatures(3 * count, 3 * count);
  for (Eigen::Index n = 0; n < count; ++n) {
    const PlateShapes shapes = plate_shapes(count, corners[n]);
    const Eigen::Matrix2d to_plane = Eigen::Matrix2d(nodes * shapes.nodes.transpose()).inverse().transpose();
    curvatures.middleRows<3>(3 * n) =
        curvature_operator(sides, to_plane * shapes.nodes, to_plane * shapes.parabolas);
  }
  return curvatures;
}

}  // namespace mimbre::fe
