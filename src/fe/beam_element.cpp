#include "fe/beam_element.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

#include "math/gauss.h"

namespace mimbre::fe {
namespace {

[[noreturn]] void fail(int element, const std::string& what) {
  throw std::invalid_argument(fmt::format("beam element {}: {}", element, what));
}

void require_positive(int element, const char* name, double value) {
  if (!(std::isfinite(value) && value > 0))
    fail(element, fmt::format("{} must be positive, is {}", name, value));
}

void check_properties(const BeamElement& beam, int element) {
  require_positive(element, "Young's modulus", beam.material.young);
  require_positive(element, "density", beam.material.density);
  if (!(beam.material.poisson > -1 && beam.material.poisson <= 0.5))
    fail(element, fmt::format("Poisson's ratio must lie in (-1, 0.5], is {}", beam.material.poisson));
  require_positive(element, "section area", beam.section.area);
  require_positive(element, "section Iy", beam.section.Iy);
  require_positive(element, "section Iz", beam.section.Iz);
  require_positive(element, "section J", beam.section.J);
}

/// The body axis that is farthest from `x`, for elements whose y direction does not matter.
Eigen::Vector3d any_direction_across(const Eigen::Vector3d& x) {
  Eigen::Index least = 0;
  x.cwiseAbs().minCoeff(&least);
  return Eigen::Vector3d::Unit(least);
}

/// Adds a cubic bending field's 4 × 4 matrix (dofs: deflection, slope at both ends) where it acts on the
/// element. `slope_sign` is −1 where the rotation dof is minus the slope.
void add_bending(Matrix12& matrix, const Eigen::Matrix4d& bending, const std::array<int, 4>& dofs,
                 double slope_sign) {
  const std::array<double, 4> sign{1, slope_sign, 1, slope_sign};
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) matrix(dofs[i], dofs[j]) += sign[i] * sign[j] * bending(i, j);
}

constexpr std::array<int, 4> kBendingXY{1, 5, 7, 11};  // v, θz
constexpr std::array<int, 4> kBendingXZ{2, 4, 8, 10};  // w, θy

void add_linear(Matrix12& matrix, int dof, double diagonal, double off_diagonal) {
  matrix(dof, dof) += diagonal;
  matrix(dof + 6, dof + 6) += diagonal;
  matrix(dof, dof + 6) += off_diagonal;
  matrix(dof + 6, dof) += off_diagonal;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

}  // namespace

ElementGeometry element_geometry(const Mesh& mesh, int element) {
  const BeamElement& beam = mesh.elements[element];
  for (int node : beam.nodes)
    if (node < 0 || node >= mesh.nodes.cols())
      fail(element, fmt::format("node {} does not exist, the mesh has {} nodes", node, mesh.nodes.cols()));
  if (beam.nodes[0] == beam.nodes[1]) fail(element, fmt::format("both ends are node {}", beam.nodes[0]));
  check_properties(beam, element);

  ElementGeometry geometry;
  geometry.start = mesh.nodes.col(beam.nodes[0]) + beam.offsets[0];
  const Eigen::Vector3d axis = mesh.nodes.col(beam.nodes[1]) + beam.offsets[1] - geometry.start;
  geometry.length = axis.norm();
  if (!std::isfinite(geometry.length) || !geometry.start.allFinite())
    fail(element, "positions must be finite");
  if (geometry.length == 0) fail(element, "has no length");

  const Eigen::Vector3d x = axis / geometry.length;
  const bool any = beam.y_direction.isZero(0);
  const Eigen::Vector3d y_direction = any ? any_direction_across(x) : beam.y_direction.normalized();
  const Eigen::Vector3d z = x.cross(y_direction);
  if (!(z.norm() > 1e-8)) fail(element, "its y direction is parallel to its axis");
  geometry.axes.col(0) = x;
  geometry.axes.col(2) = z.normalized();
  geometry.axes.col(1) = geometry.axes.col(2).cross(x);
  return geometry;
}

Matrix12 element_stiffness(const BeamElement& element, double length) {
  const double L = length;
  const double E = element.material.young;
  const double G = E / (2 * (1 + element.material.poisson));
  Eigen::Matrix4d bending;                  // of unit EI
  bending << 12, 6 * L, -12, 6 * L,         //
      6 * L, 4 * L * L, -6 * L, 2 * L * L,  //
      -12, -6 * L, 12, -6 * L,              //
      6 * L, 2 * L * L, -6 * L, 4 * L * L;
  bending /= L * L * L;

  Matrix12 k = Matrix12::Zero();
  const double axial = E * element.section.area / L;
  const double torsion = G * element.section.J / L;
  add_linear(k, 0, axial, -axial);
  add_linear(k, 3, torsion, -torsion);
  add_bending(k, E * element.section.Iz * bending, kBendingXY, 1);
  add_bending(k, E * element.section.Iy * bending, kBendingXZ, -1);
  return k;
}

Matrix12 element_mass(const BeamElement& element, double length) {
  const double L = length;
  const double mass = element.material.density * element.section.area * L;
  Eigen::Matrix4d bending;
  bending << 156, 22 * L, 54, -13 * L,        //
      22 * L, 4 * L * L, 13 * L, -3 * L * L,  //
      54, 13 * L, 156, -22 * L,               //
      -13 * L, -3 * L * L, -22 * L, 4 * L * L;
  bending *= mass / 420;

  Matrix12 m = Matrix12::Zero();
  const double polar = polar_inertia(element) * L;
  add_linear(m, 0, mass / 3, mass / 6);
  add_linear(m, 3, polar / 3, polar / 6);
  add_bending(m, bending, kBendingXY, 1);
  add_bending(m, bending, kBendingXZ, -1);
  return m;
}

double polar_inertia(const BeamElement& element) {
  return element.material.density * (element.section.Iy + element.section.Iz);
}

Matrix12 element_geometric_stiffness(const AxialForce& force, double length) {
  Eigen::Matrix4d bending = Eigen::Matrix4d::Zero();
  for (const GaussPoint& g : gauss4) {
    const double x = g.xi;
    const Eigen::Vector4d slope{6 * (x * x - x) / length, 1 - 4 * x + 3 * x * x, 6 * (x - x * x) / length,
                                3 * x * x - 2 * x};
    const double tension = force[0] + x * (force[1] + x * force[2]);
    bending += (g.weight * length * tension) * slope * slope.transpose();
  }
  Matrix12 k = Matrix12::Zero();
  add_bending(k, bending, kBendingXY, 1);
  add_bending(k, bending, kBendingXZ, -1);
  return k;
}

Matrix12 element_transformation(const BeamElement& element, const Eigen::Matrix3d& axes) {
  Matrix12 transformation = Matrix12::Zero();
  for (int end = 0; end < 2; ++end) {
    const int at = 6 * end;
    transformation.block<3, 3>(at, at) = axes.transpose();
    // u at the end of the offset o is u + θ × o
    transformation.block<3, 3>(at, at + 3) = -axes.transpose() * cross_matrix(element.offsets[end]);
    transformation.block<3, 3>(at + 3, at + 3) = axes.transpose();
  }
  return transformation;
}

Eigen::Matrix<double, 3, 12> shape_functions(double xi, double length) {
  const double xi2 = xi * xi;
  const double xi3 = xi2 * xi;
  const std::array<double, 4> hermite{1 - 3 * xi2 + 2 * xi3, length * (xi - 2 * xi2 + xi3), 3 * xi2 - 2 * xi3,
                                      length * (xi3 - xi2)};
  Eigen::Matrix<double, 3, 12> n = Eigen::Matrix<double, 3, 12>::Zero();
  n(0, 0) = 1 - xi;
  n(0, 6) = xi;
  for (int i = 0; i < 4; ++i) {
    const double slope_sign = i % 2 == 0 ? 1 : -1;
    n(1, kBendingXY[i]) = hermite[i];
    n(2, kBendingXZ[i]) = slope_sign * hermite[i];
  }
  return n;
}

}  // namespace mimbre::fe
