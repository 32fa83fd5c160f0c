#include "fe/shell_element.h"

#include <Eigen/Geometry>
#include <stdexcept>

#include "fe/quadrature.h"
#include "fe/shell_bending.h"
#include "fe/shell_membrane.h"

namespace mimbre::fe {
namespace {

constexpr double kNoArea = 1e-10;  ///< relative to the square of the element's extent

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
struct SurfaceShapes {
  Eigen::Vector4d nodes, sides;
  Eigen::Matrix<double, 4, 2> derivatives;
};

SurfaceShapes surface_shapes(Eigen::Index count, double x, double y) {
  SurfaceShapes shapes;
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

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
  return (Eigen::Matrix3d() << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0).finished();
}

ShellMatrix mass_matrix(const ShellNodes& nodes, const Eigen::Vector3d& normal, double density,
                        double thickness) {
  static const Quadrature triangle = triangle_rule(6), square = square_rule(3);
  const auto count = nodes.cols();
  const Eigen::Matrix3d in_plane = Eigen::Matrix3d::Identity() - normal * normal.transpose();
  ShellMatrix mass = ShellMatrix::Zero(6 * count, 6 * count);
  for (const IntegrationPoint& point : count == 3 ? triangle : square) {
    const SurfaceShapes shapes = surface_shapes(count, point.at.x(), point.at.y());
    const Eigen::Matrix<double, 3, 2> tangents = nodes * shapes.derivatives.topRows(count);
    const double dm = density * thickness * point.weight * tangents.col(0).cross(tangents.col(1)).norm();

    using Field = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMaxShellDofs>;
    Field displacement = Field::Zero(3, 6 * count);
    for (Eigen::Index a = 0; a < count; ++a) {
      displacement.block<3, 3>(0, 6 * a).diagonal().setConstant(shapes.nodes[a]);
      // Middle of the side: mean of its ends + ⅛ (θa − θb) × (xb − xa)
      const Eigen::Index b = (a + 1) % count;
      const Eigen::Matrix3d arm = -shapes.sides[a] / 8 * cross_matrix(nodes.col(b) - nodes.col(a));
      displacement.block<3, 3>(0, 6 * a + 3) += arm;
      displacement.block<3, 3>(0, 6 * b + 3) -= arm;
    }
    mass += dm * displacement.transpose() * displacement;
    for (Eigen::Index a = 0; a < count; ++a)
      for (Eigen::Index b = 0; b < count; ++b)
        mass.block<3, 3>(6 * a + 3, 6 * b + 3) +=
            dm * thickness * thickness / 12 * shapes.nodes[a] * shapes.nodes[b] * in_plane;
  }
  return 0.5 * (mass + mass.transpose());
}

constexpr int kMembraneDofs[] = {0, 1, 5};
constexpr int kPlateDofs[] = {2, 3, 4};

/// The flat element behind the nodes.
struct FlatShell {
  Eigen::Matrix3d axes;
  PlaneNodes plane;
  ShellMatrix from_nodes;  ///< element dofs = from_nodes · nodal dofs
};

FlatShell flat_shell(ElementType type, const ShellNodes& nodes) {
  if (!is_shell(type) || nodes.cols() != node_count(type)) throw std::logic_error("not the nodes of a shell");
  const Eigen::Matrix3d axes = shell_axes(nodes);
  const ShellNodes local = axes.transpose() * (nodes.colwise() - Eigen::Vector3d(nodes.rowwise().mean()));
  const PlaneNodes plane = local.topRows<2>();
  check_convex(plane);
  return {axes, plane, transformation(axes, local.row(2).transpose())};
}

}  // namespace

ShellMatrices shell_matrices(ElementType type, const ShellNodes& nodes, const Material& material,
                             double thickness) {
  const FlatShell shell = flat_shell(type, nodes);
  const Eigen::Index count = nodes.cols();
  const MembraneMatrix membrane =
      membrane_stiffness(shell.plane, material.young, material.poisson, thickness);
  const MembraneMatrix plate = plate_stiffness(shell.plane, material.young, material.poisson, thickness);
  ShellMatrix stiffness = ShellMatrix::Zero(6 * count, 6 * count);
  for (Eigen::Index i = 0; i < 3 * count; ++i)
    for (Eigen::Index j = 0; j < 3 * count; ++j) {
      stiffness(6 * (i / 3) + kMembraneDofs[i % 3], 6 * (j / 3) + kMembraneDofs[j % 3]) = membrane(i, j);
      stiffness(6 * (i / 3) + kPlateDofs[i % 3], 6 * (j / 3) + kPlateDofs[j % 3]) = plate(i, j);
    }
  const ShellMatrix turned = shell.from_nodes.transpose() * stiffness * shell.from_nodes;
  return {0.5 * (turned + turned.transpose()),
          mass_matrix(nodes, shell.axes.col(2), material.density, thickness)};
}

ShellStrains shell_strains(ElementType type, const ShellNodes& nodes, const Material& material,
                           double thickness) {
  const FlatShell shell = flat_shell(type, nodes);
  const Eigen::Index count = nodes.cols();
  const Eigen::MatrixXd membrane = membrane_strain(shell.plane);
  const Eigen::MatrixXd curvature = nodal_curvatures(shell.plane, material.poisson, thickness);
  Eigen::MatrixXd in_plane = Eigen::MatrixXd::Zero(3, 6 * count);
  Eigen::MatrixXd bent = Eigen::MatrixXd::Zero(3 * count, 6 * count);
  for (Eigen::Index j = 0; j < 3 * count; ++j) {
    in_plane.col(6 * (j / 3) + kMembraneDofs[j % 3]) = membrane.col(j);
    bent.col(6 * (j / 3) + kPlateDofs[j % 3]) = curvature.col(j);
  }
  return {shell.axes, in_plane * shell.from_nodes, bent * shell.from_nodes};
}

}  // namespace mimbre::fe
