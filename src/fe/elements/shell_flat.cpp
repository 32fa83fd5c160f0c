#include "fe/elements/shell_flat.h"

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

#include "fe/elements/congruence.h"
#include "fe/elements/quadrature.h"
#include "fe/elements/shell_bending.h"
#include "fe/elements/shell_membrane.h"
#include "math/cross_matrix.h"
#include "math/elementary.h"

namespace mimbre::fe {
namespace {

/// Columns: x, y in the plane of the element (of a warped one: parallel to both diagonals), z its normal.
Eigen::Matrix3d shell_axes(const ShellNodes& nodes) {
  const bool triangle = nodes.cols() == 3;
  const Eigen::Vector3d a = triangle ? nodes.col(1) - nodes.col(0) : nodes.col(2) - nodes.col(0);
  const Eigen::Vector3d b = triangle ? nodes.col(2) - nodes.col(0) : nodes.col(3) - nodes.col(1);
  const Eigen::Vector3d normal = a.cross(b);
  const double extent = (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm();
  if (!(normal.norm() > kNoArea * extent * extent)) throw std::invalid_argument("has no area");
  Eigen::Matrix3d axes;
  axes.col(0) = a.normalized();
  axes.col(2) = normal.normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

void check_convex(const PlaneNodes& plane) {
  const auto count = plane.cols();
  const double extent = (plane.rowwise().maxCoeff() - plane.rowwise().minCoeff()).norm();
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector2d before = plane.col(i) - plane.col((i + count - 1) % count);
    const Eigen::Vector2d after = plane.col((i + 1) % count) - plane.col(i);
    if (!(before.x() * after.y() - before.y() * after.x() > kNoArea * extent * extent))
      throw std::invalid_argument(
          "is not convex: its nodes do not run round it or two of its sides are in line");
  }
}

/// Element dofs = transformation · nodal dofs. Node k is `height[k]` above the plane.
ShellMatrix transformation(const Eigen::Matrix3d& axes, const Eigen::VectorXd& heights) {
  ShellMatrix t = ShellMatrix::Zero(6 * heights.size(), 6 * heights.size());
  for (Eigen::Index k = 0; k < heights.size(); ++k) {
    t.block<3, 3>(6 * k, 6 * k) = axes.transpose();
    t.block<3, 3>(6 * k + 3, 6 * k + 3) = axes.transpose();
    // The plane's point lies at −height·z from the node: u − height·θ × z
    t.block<1, 3>(6 * k, 6 * k + 3) = -heights[k] * axes.col(1).transpose();
    t.block<1, 3>(6 * k + 1, 6 * k + 3) = heights[k] * axes.col(0).transpose();
  }
  return t;
}

/// Functions of the nodes and of the sides (parabolas of unit height), derivatives of the former by the
/// reference coordinates.
struct FlatShapes {
  Eigen::Vector4d nodes, sides;
  Eigen::Matrix<double, 4, 2> derivatives;
};

FlatShapes flat_shapes(Eigen::Index count, double x, double y) {
  FlatShapes shapes;
  if (count == 3) {
    const double l = 1 - x - y;
    shapes.nodes << l, x, y, 0;
    shapes.sides << 4 * l * x, 4 * x * y, 4 * y * l, 0;
    shapes.derivatives << -1, -1, 1, 0, 0, 1, 0, 0;
  } else {
    shapes.nodes << (1 - x) * (1 - y), (1 + x) * (1 - y), (1 + x) * (1 + y), (1 - x) * (1 + y);
    shapes.nodes /= 4;
    shapes.sides << (1 - x * x) * (1 - y), (1 - y * y) * (1 + x), (1 - x * x) * (1 + y),
        (1 - y * y) * (1 - x);
    shapes.sides /= 2;
    shapes.derivatives << -(1 - y), -(1 - x), 1 - y, -(1 + x), 1 + y, 1 + x, -(1 + y), 1 - x;
    shapes.derivatives /= 4;
  }
  return shapes;
}

constexpr int kMembraneDofs[] = {0, 1, 5};
constexpr int kPlateDofs[] = {2, 3, 4};

/// The flat element behind the nodes.
struct FlatShell {
  Eigen::Matrix3d axes;
  PlaneNodes plane;
  ShellMatrix from_nodes;  ///< element dofs = from_nodes · nodal dofs
};

FlatShell flat_shell(const ShellGeometry& geometry) {
  const ShellNodes& nodes = geometry.nodes;
  if (nodes.cols() > 4 || nodes.cols() != node_count(geometry.type))
    throw std::logic_error("not the nodes of a flat shell");
  const Eigen::Matrix3d axes = shell_axes(nodes);
  const ShellNodes local = axes.transpose() * (nodes.colwise() - Eigen::Vector3d(nodes.rowwise().mean()));
  const PlaneNodes plane = local.topRows<2>();
  check_convex(plane);
  return {axes, plane, transformation(axes, local.row(2).transpose().array() - geometry.offset)};
}

SheetElasticity sheet_of(const ShellGeometry& geometry, const FlatShell& shell,
                         const ElementMaterial& material) {
  return material.sheet_at(geometry.nodes.rowwise().mean(), shell.axes);
}

}  // namespace

ShellMatrix flat_stiffness(const ShellGeometry& geometry, const ElementMaterial& material) {
  const FlatShell shell = flat_shell(geometry);
  const SheetElasticity sheet = sheet_of(geometry, shell, material);
  const Eigen::Index count = geometry.nodes.cols();
  const MembraneMatrix membrane = membrane_stiffness(shell.plane, sheet.plane, geometry.thickness);
  const MembraneMatrix plate = plate_stiffness(shell.plane, sheet, geometry.thickness);
  ShellMatrix stiffness = ShellMatrix::Zero(6 * count, 6 * count);
  for (Eigen::Index i = 0; i < 3 * count; ++i)
    for (Eigen::Index j = 0; j < 3 * count; ++j) {
      stiffness(6 * (i / 3) + kMembraneDofs[i % 3], 6 * (j / 3) + kMembraneDofs[j % 3]) = membrane(i, j);
      stiffness(6 * (i / 3) + kPlateDofs[i % 3], 6 * (j / 3) + kPlateDofs[j % 3]) = plate(i, j);
    }
  ShellMatrix of_nodes = ShellMatrix::Zero(6 * count, 6 * count);
  add_congruent(of_nodes, 1, shell.from_nodes, stiffness);
  return of_nodes;
}

ShellMatrix flat_drilling_mass(const ShellGeometry& geometry, double density) {
  const Eigen::Index count = geometry.nodes.cols();
  const Eigen::Matrix3d axes = shell_axes(geometry.nodes);
  const double middle = count == 3 ? 1.0 / 3 : 0.0;
  const Eigen::Matrix<double, 4, 2> derivatives = flat_shapes(count, middle, middle).derivatives;
  const Eigen::Matrix<double, 2, 2> J =
      axes.leftCols<2>().transpose() * geometry.nodes * derivatives.topRows(count);
  const double area = (count == 3 ? 0.5 : 4.0) * J.determinant();
  const Eigen::Matrix2d inverse = J.inverse();
  // θ·n less the rotation of the membrane at the centre, ½ n·Σ ∇Na × ua.
  Eigen::RowVectorXd rotation = Eigen::RowVectorXd::Zero(6 * count);
  for (Eigen::Index a = 0; a < count; ++a) {
    const Eigen::Vector3d gradient = axes.leftCols<2>() * (derivatives.row(a) * inverse).transpose();
    rotation.segment<3>(6 * a) = 0.5 * axes.col(2).cross(gradient).transpose();
  }
  ShellMatrix mass = ShellMatrix::Zero(6 * count, 6 * count);
  const double inertia =
      density * mimbre::pow(geometry.thickness, 3) / 12 * area / static_cast<double>(count);
  for (Eigen::Index a = 0; a < count; ++a) {
    Eigen::RowVectorXd drilling = -rotation;
    drilling.segment<3>(6 * a + 3) += axes.col(2).transpose();
    add_square(mass, inertia, drilling);
  }
  return mass;
}

void for_each_flat_mass_point(const ShellGeometry& geometry, double density, const VisitMass& visit) {
  static const Quadrature triangle = triangle_rule(6), square = square_rule(3);
  const ShellNodes& nodes = geometry.nodes;
  const auto count = nodes.cols();
  const Eigen::Vector3d normal = shell_axes(nodes).col(2);
  for (const IntegrationPoint& point : count == 3 ? triangle : square) {
    const FlatShapes shapes = flat_shapes(count, point.at.x(), point.at.y());
    const Eigen::Matrix<double, 3, 2> tangents = nodes * shapes.derivatives.topRows(count);
    const double dm =
        density * geometry.thickness * point.weight * tangents.col(0).cross(tangents.col(1)).norm();
    const Eigen::Vector3d place = nodes * shapes.nodes.head(count);

    ShellField middle = ShellField::Zero(3, 6 * count);
    for (Eigen::Index a = 0; a < count; ++a) {
      middle.block<3, 3>(0, 6 * a).diagonal().setConstant(shapes.nodes[a]);
      // Middle of the side: mean of its ends + ⅛ (θa − θb) × (xb − xa)
      const Eigen::Index b = (a + 1) % count;
      const Eigen::Matrix3d arm = -shapes.sides[a] / 8 * cross_matrix(nodes.col(b) - nodes.col(a));
      middle.block<3, 3>(0, 6 * a + 3) += arm;
      middle.block<3, 3>(0, 6 * b + 3) -= arm;
    }
    for (const double side : {-1.0, 1.0}) {
      const double height = geometry.offset + side * geometry.thickness / std::sqrt(12.0);
      ShellField motion = middle;
      for (Eigen::Index a = 0; a < count; ++a)
        motion.block<3, 3>(0, 6 * a + 3) -= height * shapes.nodes[a] * cross_matrix(normal);
      visit(place + height * normal, 0.5 * dm, motion);
    }
  }
}

ShellStrains flat_strains(const ShellGeometry& geometry, const ElementMaterial& material) {
  const FlatShell shell = flat_shell(geometry);
  const Eigen::Index count = geometry.nodes.cols();
  const Eigen::MatrixXd membrane = membrane_strain(shell.plane);
  const Eigen::MatrixXd curvature =
      nodal_curvatures(shell.plane, sheet_of(geometry, shell, material), geometry.thickness);
  Eigen::MatrixXd in_plane = Eigen::MatrixXd::Zero(3, 6 * count);
  Eigen::MatrixXd bent = Eigen::MatrixXd::Zero(3 * count, 6 * count);
  for (Eigen::Index j = 0; j < 3 * count; ++j) {
    in_plane.col(6 * (j / 3) + kMembraneDofs[j % 3]) = membrane.col(j);
    bent.col(6 * (j / 3) + kPlateDofs[j % 3]) = curvature.col(j);
  }
  return {std::vector<Eigen::Matrix3d>(static_cast<std::size_t>(count), shell.axes),
          (in_plane * shell.from_nodes).replicate(count, 1), bent * shell.from_nodes};
}

}  // namespace mimbre::fe
