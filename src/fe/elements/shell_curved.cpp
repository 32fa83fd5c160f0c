#include "fe/elements/shell_curved.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <stdexcept>

#include "fe/elements/congruence.h"
#include "fe/elements/orthonormal.h"
#include "fe/elements/quadrature.h"
#include "fe/elements/solid_element.h"
#include "math/elementary.h"
#include "math/once/decompositions.h"

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Share of the shear modulus that resists drilling rotations other than the membrane's.
constexpr double kDrillingShare = 0.05;
/// Share of the full integration's energy that motions get which reduced integration does not see.
constexpr double kUnseenShare = 0.02;

struct SurfaceShapes {
  Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxShellNodes, 1> values;
  Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::ColMajor, kMaxShellNodes, 2> derivatives;
};

SurfaceShapes triangle_shapes(double x, double y) {
  const std::array<double, 3> l{1 - x - y, x, y};
  constexpr double by_x[] = {-1, 1, 0}, by_y[] = {-1, 0, 1};
  SurfaceShapes s;
  s.values.resize(6);
  s.derivatives.resize(6, 2);
  for (int i = 0; i < 3; ++i) {
    s.values[i] = l[i] * (2 * l[i] - 1);
    s.derivatives.row(i) << (4 * l[i] - 1) * by_x[i], (4 * l[i] - 1) * by_y[i];
    const int j = (i + 1) % 3;
    s.values[3 + i] = 4 * l[i] * l[j];
    s.derivatives.row(3 + i) << 4 * (l[i] * by_x[j] + l[j] * by_x[i]), 4 * (l[i] * by_y[j] + l[j] * by_y[i]);
  }
  return s;
}

constexpr std::array<std::array<double, 2>, 8> kSquare{
    {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {0, -1}, {1, 0}, {0, 1}, {-1, 0}}};
constexpr std::array<std::array<double, 2>, 6> kTriangle{
    {{0, 0}, {1, 0}, {0, 1}, {0.5, 0}, {0.5, 0.5}, {0, 0.5}}};

SurfaceShapes square_shapes(double x, double y) {
  SurfaceShapes s;
  s.values.resize(8);
  s.derivatives.resize(8, 2);
  for (int i = 0; i < 8; ++i) {
    const auto [a, b] = kSquare[static_cast<std::size_t>(i)];
    if (i < 4) {
      s.values[i] = 0.25 * (1 + a * x) * (1 + b * y) * (a * x + b * y - 1);
      s.derivatives.row(i) << 0.25 * a * (1 + b * y) * (2 * a * x + b * y),
          0.25 * b * (1 + a * x) * (a * x + 2 * b * y);
    } else if (a == 0) {
      s.values[i] = 0.5 * (1 - x * x) * (1 + b * y);
      s.derivatives.row(i) << -x * (1 + b * y), 0.5 * b * (1 - x * x);
    } else {
      s.values[i] = 0.5 * (1 + a * x) * (1 - y * y);
      s.derivatives.row(i) << 0.5 * a * (1 - y * y), -y * (1 + a * x);
    }
  }
  return s;
}

SurfaceShapes surface_shapes(Index count, double x, double y) {
  return count == 6 ? triangle_shapes(x, y) : square_shapes(x, y);
}

/// Σ weights · columns, in a loop, which compiles faster than Eigen's product.
Vector3d combined(const ShellNodes& columns, const double* weights) {
  Vector3d sum = Vector3d::Zero();
  for (Index a = 0; a < columns.cols(); ++a)
    for (Index k = 0; k < 3; ++k) sum[k] += columns(k, a) * weights[a];
  return sum;
}
/// The derivatives of what the columns are at the nodes.
std::array<Vector3d, 2> tangents_of(const ShellNodes& columns, const SurfaceShapes& shapes) {
  const double* const weights = shapes.derivatives.data();
  return {combined(columns, weights), combined(columns, weights + shapes.derivatives.rows())};
}

Vector3d area_vector(const ShellNodes& nodes, const SurfaceShapes& shapes) {
  const auto [x, y] = tangents_of(nodes, shapes);
  return x.cross(y);
}

/// Normals at the nodes. Throws where the element has no area, is folded or turned over in itself.
ShellNodes node_normals(const ShellGeometry& shell) {
  const ShellNodes& nodes = shell.nodes;
  const Index count = nodes.cols();
  if (count != node_count(shell.type) || (count != 6 && count != 8))
    throw std::logic_error("not the nodes of a curved shell");
  const double extent = (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm();
  const double middle = count == 6 ? 1.0 / 3 : 0;
  const Vector3d centre = area_vector(nodes, surface_shapes(count, middle, middle));
  if (!(centre.norm() > kNoArea * extent * extent)) throw std::invalid_argument("has no area");
  ShellNodes normals(3, count);
  for (Index k = 0; k < count; ++k) {
    const auto [x, y] =
        count == 6 ? kTriangle[static_cast<std::size_t>(k)] : kSquare[static_cast<std::size_t>(k)];
    const Vector3d area = area_vector(nodes, surface_shapes(count, x, y));
    if (!(area.norm() > kNoArea * extent * extent) || !(area.dot(centre) > 0))
      throw std::invalid_argument(
          "is folded: its nodes do not run round it, or a node amid a side lies too near to a corner");
    normals.col(k) = area.normalized();
  }
  return normals;
}

/// What the element's functions are at a point.
struct ShellPoint {
  Vector3d place;
  Matrix3d axes;  ///< columns; the last is the normal
  double volume;  ///< per unit of the reference coordinates and of the height
  double area;    ///< of the surface at this height, per unit of the reference coordinates
  SurfaceShapes shapes;
  ShellNodes by_translation, by_tilt;  ///< gradient of u = Σ ua gaᵀ + (θa × na) haᵀ
};

/// `height` above the nodes.
ShellPoint point_at(const ShellGeometry& shell, const ShellNodes& normals, double x, double y,
                    double height) {
  const Index count = shell.nodes.cols();
  ShellPoint p;
  p.shapes = surface_shapes(count, x, y);
  const ShellNodes lifted = shell.nodes + height * normals;
  p.place = combined(lifted, p.shapes.values.data());
  Matrix3d J;
  const auto [along_x, along_y] = tangents_of(lifted, p.shapes);
  J.col(0) = along_x;
  J.col(1) = along_y;
  J.col(2) = combined(normals, p.shapes.values.data());
  const Vector3d area = J.col(0).cross(J.col(1));
  p.area = area.norm();
  p.volume = area.dot(J.col(2));
  p.axes.col(2) = area / p.area;
  p.axes.col(0) = J.col(0).normalized();
  p.axes.col(1) = p.axes.col(2).cross(p.axes.col(0));
  const Matrix3d to_body = J.inverse().transpose();
  p.by_translation.resize(3, count);
  p.by_tilt.resize(3, count);
  for (Index a = 0; a < count; ++a) {
    const Vector3d g = to_body.leftCols<2>() * p.shapes.derivatives.row(a).transpose();
    p.by_translation.col(a) = g;
    p.by_tilt.col(a) = height * g + p.shapes.values[a] * to_body.col(2);
  }
  return p;
}

/// Strains in the point's axes: xx, yy, xy, then zx, yz (engineering); the last row is the rotation of the
/// membrane about the normal.
using Strains = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxShellDofs>;

Strains strain_operator(const ShellPoint& p, const ShellNodes& normals) {
  const Index count = normals.cols();
  Strains strain(6, 6 * count);
  const Vector3d e1 = p.axes.col(0), e2 = p.axes.col(1), n = p.axes.col(2);
  // A unit motion along a, b, c of the axes with the gradient g.
  const auto fill = [&](Index column, const Matrix3d& motion, const Vector3d& g) {
    const double g1 = e1.dot(g), g2 = e2.dot(g), g3 = n.dot(g);
    const Eigen::RowVector3d a = e1.transpose() * motion, b = e2.transpose() * motion,
                             c = n.transpose() * motion;
    strain.block<1, 3>(0, column) = g1 * a;
    strain.block<1, 3>(1, column) = g2 * b;
    strain.block<1, 3>(2, column) = g2 * a + g1 * b;
    strain.block<1, 3>(3, column) = g3 * a + g1 * c;
    strain.block<1, 3>(4, column) = g3 * b + g2 * c;
    strain.block<1, 3>(5, column) = 0.5 * (g1 * b - g2 * a);
  };
  for (Index a = 0; a < count; ++a) {
    fill(6 * a, Matrix3d::Identity(), p.by_translation.col(a));
    Matrix3d tilt;  // θ × n
    const Vector3d m = normals.col(a);
    tilt << 0, m.z(), -m.y(), -m.z(), 0, m.x(), m.y(), -m.x(), 0;
    fill(6 * a + 3, tilt, p.by_tilt.col(a));
  }
  return strain;
}

/// The nodes' rotation about the normal less that of the membrane.
using DrillingRow = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMaxShellDofs>;
DrillingRow drilling_row(const ShellPoint& p, const ShellNodes& normals) {
  DrillingRow row = -strain_operator(p, normals).row(5);
  for (Index a = 0; a < normals.cols(); ++a)
    row.segment<3>(6 * a + 3) += p.shapes.values[a] * p.axes.col(2).transpose();
  return row;
}

Eigen::Matrix<double, 5, 5> elastic_at(const ElementMaterial& material, const ShellPoint& p) {
  const SheetElasticity sheet = material.sheet_at(p.place, p.axes);
  Eigen::Matrix<double, 5, 5> elastic = Eigen::Matrix<double, 5, 5>::Zero();
  elastic.topLeftCorner<3, 3>() = sheet.plane;
  elastic.bottomRightCorner<2, 2>() = kShearFactor * sheet.shear;
  return elastic;
}

const Quadrature& surface_rule(const ShellGeometry& shell) {
  static const Quadrature triangle = triangle_rule(3), full = square_rule(3), reduced = square_rule(2);
  if (shell.type == ElementType::tri6) return triangle;
  return shell.reduced ? reduced : full;
}

/// Exact for the mass of elements with straight sides.
const Quadrature& full_rule(const ShellGeometry& shell) {
  static const Quadrature triangle = triangle_rule(6), square = square_rule(3);
  return shell.type == ElementType::tri6 ? triangle : square;
}

double height_of(const ShellGeometry& shell, double side) {
  return shell.offset + side * shell.thickness / std::sqrt(12.0);
}

/// The motions u = ξ(3η² − 1), v = −η(3ξ² − 1) of the quadrilateral's translations and of what its normals
/// tilt: they have no strain at the 2 × 2 points.
using Unseen = Eigen::Matrix<double, 6 * 8, 2>;

/// Of a field of translations or of tilts.
Unseen unseen_motions(const Eigen::Matrix<double, 8, 3>& field, const ShellNodes& normals) {
  Unseen motions = Unseen::Zero();
  for (Index n = 0; n < 8; ++n) {
    motions.block<3, 1>(6 * n, 0) = field.row(n).transpose();
    // θ × normal = field
    motions.block<3, 1>(6 * n + 3, 1) = Vector3d(normals.col(n)).cross(Vector3d(field.row(n).transpose()));
  }
  return motions;
}

void add_unseen_stiffness(const ShellGeometry& shell, const ShellNodes& normals,
                          const ElementMaterial& material, ShellMatrix& stiffness) {
  const ShellPoint centre = point_at(shell, normals, 0, 0, shell.offset);
  // Columns: reciprocal to the tangents.
  const auto [along_x, along_y] = tangents_of(shell.nodes, centre.shapes);
  Eigen::Matrix<double, 3, 2> tangents;
  tangents.col(0) = along_x;
  tangents.col(1) = along_y;
  const Eigen::Matrix<double, 3, 2> reciprocal =
      tangents * Eigen::Matrix2d(tangents.transpose() * tangents).inverse();
  // Test vectors feel neither linear displacements in body coordinates nor quadratic ones in reference
  // coordinates.
  using Smooth = Eigen::Matrix<double, 8, 7>;
  Smooth smooth;
  const Vector3d middle = shell.nodes.rowwise().mean();
  const double size = (shell.nodes.rowwise().maxCoeff() - shell.nodes.rowwise().minCoeff()).norm();
  for (Index n = 0; n < 8; ++n) {
    const Vector3d x = centre.axes.transpose() * (shell.nodes.col(n) - middle) / size;
    const auto [r, s] = kSquare[static_cast<std::size_t>(n)];
    smooth.row(n) << 1, x.x(), x.y(), r * r, s * s, r * s, x.z();
  }
  // Of a flat element the last column vanishes.
  const Smooth basis = orthonormal(smooth);
  Eigen::Matrix<double, 8, 3> field;
  for (Index n = 0; n < 8; ++n) {
    const auto [r, s] = kSquare[static_cast<std::size_t>(n)];
    field.row(n) = (reciprocal * Eigen::Vector2d(r * (3 * s * s - 1), -s * (3 * r * r - 1))).transpose();
  }
  const Eigen::Matrix<double, 8, 3> seen = projected(basis, field);
  const Unseen motions = unseen_motions(field, normals),
               tests = unseen_motions((field - seen) / field.squaredNorm(), normals);
  static const Quadrature full = square_rule(3);
  Eigen::Matrix2d energy = Eigen::Matrix2d::Zero();
  for (const IntegrationPoint& q : full)
    for (const double side : {-1.0, 1.0}) {
      const ShellPoint p = point_at(shell, normals, q.at.x(), q.at.y(), height_of(shell, side));
      const Strains strain = strain_operator(p, normals);
      Eigen::Matrix<double, 5, 2> of_motions = Eigen::Matrix<double, 5, 2>::Zero();
      for (Index m = 0; m < 2; ++m)
        for (Index d = 0; d < motions.rows(); ++d)
          // Tilts feel no transverse shear: a share of it would lock thin elements.
          for (Index k = 0; k < (m == 0 ? 5 : 3); ++k) of_motions(k, m) += strain(k, d) * motions(d, m);
      add_congruent(energy, 0.5 * shell.thickness * q.weight * p.volume, of_motions, elastic_at(material, p));
    }
  energy(0, 1) = energy(1, 0) = 0;
  add_congruent(stiffness, kUnseenShare, tests.transpose(), energy);
}

}  // namespace

ShellMatrix curved_stiffness(const ShellGeometry& shell, const ElementMaterial& material) {
  const ShellNodes normals = node_normals(shell);
  const Index dofs = 6 * shell.nodes.cols();
  ShellMatrix stiffness = ShellMatrix::Zero(dofs, dofs);
  for (const IntegrationPoint& q : surface_rule(shell)) {
    for (const double side : {-1.0, 1.0}) {
      const ShellPoint p = point_at(shell, normals, q.at.x(), q.at.y(), height_of(shell, side));
      if (!(p.volume > 0)) throw std::invalid_argument("is thicker than its curvature allows");
      add_congruent(stiffness, 0.5 * shell.thickness * q.weight * p.volume, strain_operator(p, normals),
                    elastic_at(material, p));
    }
  }
  // By a full rule: fewer points leave rotations without energy.
  for (const IntegrationPoint& q : full_rule(shell)) {
    const ShellPoint p = point_at(shell, normals, q.at.x(), q.at.y(), shell.offset);
    const DrillingRow drilling = drilling_row(p, normals);
    const double shear = material.sheet_at(p.place, p.axes).plane(2, 2);
    add_square(stiffness, kDrillingShare * shear * shell.thickness * q.weight * p.area, drilling);
  }
  if (shell.reduced && shell.type == ElementType::quad8)
    add_unseen_stiffness(shell, normals, material, stiffness);
  return stiffness;
}

ShellMatrix curved_drilling_mass(const ShellGeometry& shell, double density) {
  const ShellNodes normals = node_normals(shell);
  const Index dofs = 6 * shell.nodes.cols();
  ShellMatrix mass = ShellMatrix::Zero(dofs, dofs);
  const double inertia = density * mimbre::pow(shell.thickness, 3) / 12;
  for (const IntegrationPoint& q : full_rule(shell)) {
    const ShellPoint p = point_at(shell, normals, q.at.x(), q.at.y(), shell.offset);
    const DrillingRow drilling = drilling_row(p, normals);
    add_square(mass, inertia * q.weight * p.area, drilling);
  }
  return mass;
}

void for_each_curved_mass_point(const ShellGeometry& shell, double density, const VisitMass& visit) {
  static const Quadrature few = square_rule(2);
  const ShellNodes normals = node_normals(shell);
  const Index count = shell.nodes.cols();
  const auto add = [&](const Quadrature& rule, double share) {
    for (const IntegrationPoint& q : rule)
      for (const double side : {-1.0, 1.0}) {
        const double height = height_of(shell, side);
        const ShellPoint p = point_at(shell, normals, q.at.x(), q.at.y(), height);
        ShellField motion(3, 6 * count);
        for (Index a = 0; a < count; ++a) {
          const Vector3d m = height * p.shapes.values[a] * normals.col(a);
          motion.block<3, 3>(0, 6 * a) = p.shapes.values[a] * Matrix3d::Identity();
          motion.block<3, 3>(0, 6 * a + 3) << 0, m.z(), -m.y(), -m.z(), 0, m.x(), m.y(), -m.x(), 0;
        }
        visit(p.place, share * density * 0.5 * shell.thickness * q.weight * p.volume, motion);
      }
  };
  const bool reduced = shell.reduced && shell.type == ElementType::quad8;
  add(full_rule(shell), reduced ? kExactShare : 1);
  if (reduced) add(few, 1 - kExactShare);
}

ShellStrains curved_strains(const ShellGeometry& shell) {
  const ShellNodes normals = node_normals(shell);
  const Index count = shell.nodes.cols();
  static const Quadrature triangle = triangle_rule(3), square = square_rule(2);
  const Quadrature& rule = count == 6 ? triangle : square;
  const auto points = static_cast<Index>(rule.size());
  // From the points, where strains are most accurate, to the nodes: linear, of the square bilinear.
  const auto basis = [&](double x, double y) {
    Eigen::RowVectorXd row(points);
    if (count == 6)
      row << 1, x, y;
    else
      row << 1, x, y, x * y;
    return row;
  };
  Eigen::MatrixXd at_points(points, points);
  for (Index q = 0; q < points; ++q)
    at_points.row(q) =
        basis(rule[static_cast<std::size_t>(q)].at.x(), rule[static_cast<std::size_t>(q)].at.y());
  const Eigen::MatrixXd from_points = inverse(at_points);

  ShellStrains strains;
  strains.membrane.setZero(3 * count, 6 * count);
  strains.curvature.setZero(3 * count, 6 * count);
  std::vector<Matrix3d> node_axes;
  for (Index n = 0; n < count; ++n) {
    const auto [x, y] =
        count == 6 ? kTriangle[static_cast<std::size_t>(n)] : kSquare[static_cast<std::size_t>(n)];
    strains.axes.push_back(point_at(shell, normals, x, y, shell.offset).axes);
    const Eigen::RowVectorXd weights = basis(x, y) * from_points;
    for (Index q = 0; q < points; ++q) {
      const Vector3d& at = rule[static_cast<std::size_t>(q)].at;
      const double half = shell.thickness / 2;
      const auto strain = [&](double height) -> Eigen::MatrixXd {
        return strain_operator(point_at(shell, normals, at.x(), at.y(), shell.offset + height), normals)
            .topRows<3>();
      };
      const Eigen::MatrixXd top = strain(half), bottom = strain(-half);
      strains.membrane.middleRows<3>(3 * n) += 0.5 * weights[q] * (top + bottom);
      strains.curvature.middleRows<3>(3 * n) += weights[q] / shell.thickness * (top - bottom);
    }
  }
  return strains;
}

}  // namespace mimbre::fe
