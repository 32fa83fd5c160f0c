#include "fe/elements/beam_element.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

#include "math/cross_matrix.h"
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
  if (beam.theory != BeamTheory::timoshenko) return;
  require_positive(element, "section shear area along y", beam.section.shear_y);
  require_positive(element, "section shear area along z", beam.section.shear_z);
}

double shear_modulus(const Material& material) { return material.young / (2 * (1 + material.poisson)); }

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

/// Of a bending field by its dofs: deflection and slope at both ends.
using Bending = Eigen::Vector4d;

Bending deflection(double x, double length, double shear) {
  const double x2 = x * x, x3 = x2 * x, half = 0.5 * shear * (x - x2);
  return Bending{1 - 3 * x2 + 2 * x3 + shear * (1 - x), length * (x - 2 * x2 + x3 + half),
                 3 * x2 - 2 * x3 + shear * x, length * (x3 - x2 - half)} /
         (1 + shear);
}

/// The derivative of the deflection.
Bending slope(double x, double length, double shear) {
  const double half = 0.5 * shear * (1 - 2 * x);
  return Bending{(6 * (x * x - x) - shear) / length, 1 - 4 * x + 3 * x * x + half,
                 (6 * (x - x * x) + shear) / length, 3 * x * x - 2 * x - half} /
         (1 + shear);
}

/// Of the section: the slope less the shear strain.
Bending rotation(double x, double length, double shear) {
  return Bending{6 * (x * x - x) / length, 1 - 4 * x + 3 * x * x + shear * (1 - x), 6 * (x - x * x) / length,
                 3 * x * x - 2 * x + shear * x} /
         (1 + shear);
}

/// The derivative of the rotation.
Bending curvature(double x, double length, double shear) {
  return Bending{6 * (2 * x - 1) / length, 6 * x - 4 - shear, 6 * (1 - 2 * x) / length, 6 * x - 2 + shear} /
         (length * (1 + shear));
}

Eigen::Matrix4d bending_stiffness(double EI, double length, double shear) {
  const double L = length, same = (4 + shear) * L * L, other = (2 - shear) * L * L;
  Eigen::Matrix4d k;
  k << 12, 6 * L, -12, 6 * L,      //
      6 * L, same, -6 * L, other,  //
      -12, -6 * L, 12, -6 * L,     //
      6 * L, other, -6 * L, same;
  return EI * (k / (L * L * L)) / (1 + shear);
}

/// ∫ μ v² + j θ² ds: of the mass and of the rotary inertia per length.
Eigen::Matrix4d bending_mass(double mass, double rotary, double length, double shear) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  for (const GaussPoint& g : gauss4) {
    const Bending v = deflection(g.xi, length, shear), turn = rotation(g.xi, length, shear);
    m += g.weight * length * (mass * v * v.transpose() + rotary * turn * turn.transpose());
  }
  return m;
}

using Rows12 = Eigen::Matrix<double, 3, 12>;

/// Rows of a displacement that are linear along the element by `first` and `second` per end's dof, bent by v
/// and w.
Rows12 displacement_rows(double first, double second, const Bending& v, const Bending& w) {
  Rows12 n = Rows12::Zero();
  n(0, 0) = first;
  n(0, 6) = second;
  for (std::size_t i = 0; i < 4; ++i) {
    const double slope_sign = i % 2 == 0 ? 1 : -1;
    n(1, kBendingXY[i]) = v[static_cast<Eigen::Index>(i)];
    n(2, kBendingXZ[i]) = slope_sign * w[static_cast<Eigen::Index>(i)];
  }
  return n;
}

/// The same of a rotation: θy = −w'.
Rows12 rotation_rows(double first, double second, const Bending& v, const Bending& w) {
  Rows12 n = Rows12::Zero();
  n(0, 3) = first;
  n(0, 9) = second;
  for (std::size_t i = 0; i < 4; ++i) {
    const double slope_sign = i % 2 == 0 ? 1 : -1;
    n(2, kBendingXY[i]) = v[static_cast<Eigen::Index>(i)];
    n(1, kBendingXZ[i]) = -slope_sign * w[static_cast<Eigen::Index>(i)];
  }
  return n;
}

double value(const SectionForces::Polynomial& p, double x) {
  return p[0] + x * (p[1] + x * (p[2] + x * p[3]));
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
  const double E = element.material.young;
  const ShearRatio shear = shear_ratio(element, length);
  Matrix12 k = Matrix12::Zero();
  const double axial = E * element.section.area / length;
  const double torsion = shear_modulus(element.material) * element.section.J / length;
  add_linear(k, 0, axial, -axial);
  add_linear(k, 3, torsion, -torsion);
  add_bending(k, bending_stiffness(E * element.section.Iz, length, shear.xy), kBendingXY, 1);
  add_bending(k, bending_stiffness(E * element.section.Iy, length, shear.xz), kBendingXZ, -1);
  return k;
}

ShearRatio shear_ratio(const BeamElement& element, double length) {
  if (element.theory != BeamTheory::timoshenko) return {};
  const Section& s = element.section;
  const double ratio = 12 * element.material.young / (shear_modulus(element.material) * length * length);
  return {ratio * s.Iz / s.shear_y, ratio * s.Iy / s.shear_z};
}

bool has_rotary_inertia(const BeamElement& element) { return element.theory != BeamTheory::euler_bernoulli; }

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
  if (has_rotary_inertia(element)) {
    const double density = element.material.density;
    const ShearRatio shear = shear_ratio(element, L);
    const auto plane = [&](double I, double ratio) { return bending_mass(mass / L, density * I, L, ratio); };
    add_bending(m, plane(element.section.Iz, shear.xy), kBendingXY, 1);
    add_bending(m, plane(element.section.Iy, shear.xz), kBendingXZ, -1);
    return m;
  }
  add_bending(m, bending, kBendingXY, 1);
  add_bending(m, bending, kBendingXZ, -1);
  return m;
}

double lumped_turning(const BeamElement& element, double length) {
  return element.material.density * element.section.area * length * length * length / 78;
}

Matrix12 element_mass(const BeamElement& element, double length, MassMatrix mass_matrix) {
  if (mass_matrix == MassMatrix::consistent) return element_mass(element, length);
  const double half = 0.5 * element.material.density * length;
  const double turning = lumped_turning(element, length);
  const double rotary = has_rotary_inertia(element) ? half : 0;
  Matrix12 m = Matrix12::Zero();
  for (int first : {0, 6})
    m.diagonal().segment<6>(first) << half * element.section.area, half * element.section.area,
        half * element.section.area, 0.5 * polar_inertia(element) * length,
        turning + rotary * element.section.Iy, turning + rotary * element.section.Iz;
  return m;
}

double polar_inertia(const BeamElement& element) {
  return element.material.density * (element.section.Iy + element.section.Iz);
}

// With the rotation matrix R(θ) of the section and the axis x + u, the strains Γ = Rᵀ (x + u)' − x and
// κ~ = Rᵀ R' have the second-order parts
//   Γ₂ = −θ × u' + ½ θ × (θ × x),   κ₂ = −½ θ × θ'
// where θ is the rotation vector. That settles how moments turn with the nodes: to this order components of
// the rotation vector are Argyris' semitangential rotations (Argyris, Dunne, Scharpf, Comput. Meth. Appl.
// Mech. Eng. 14 (1978) 401–451): −½ M·(θ × θ') is what makes the matrix symmetric, and bars that meet at an
// angle, or hang on frames that turn by exp(θ~), share their θ. With slopes as rotations the moments at an
// element's ends would be quasitangential, and right in straight beams alone.
// As shear strains γ are by Γ₂ in the work of the tension with −½ N γ² (Haringx), ½ N γ² is put back: the
// tension works on ½ v'² + ½ w'² (Engesser).
Matrix12 element_geometric_stiffness(const SectionForces& forces, double length, const ShearRatio& shear) {
  const Eigen::Matrix3d along = cross_matrix(Eigen::Vector3d::UnitX());
  Matrix12 half = Matrix12::Zero();  // the matrix is this and its transpose
  for (const GaussPoint& g : gauss4) {
    const double x = g.xi;
    const Eigen::Vector3d F(value(forces.axial, x), value(forces.shear_y, x), value(forces.shear_z, x)),
        M(value(forces.torque, x), value(forces.moment_y, x), value(forces.moment_z, x));
    const Rows12 gradient = displacement_rows(-1 / length, 1 / length, slope(x, length, shear.xy),
                                              slope(x, length, shear.xz)),
                 turn = rotation_functions(x, length, shear),
                 bend = rotation_rows(-1 / length, 1 / length, curvature(x, length, shear.xy),
                                      curvature(x, length, shear.xz)),
                 strain = gradient + along * turn;
    const Rows12 by_force = 0.5 * (F * turn.row(0) - F[0] * turn);
    Matrix12 work = turn.transpose() * by_force - gradient.transpose() * (cross_matrix(F) * turn) -
                    0.5 * bend.transpose() * (cross_matrix(M) * turn);
    work += 0.5 * F[0] * strain.bottomRows<2>().transpose() * strain.bottomRows<2>();
    half += g.weight * length * work;
  }
  return half + half.transpose();
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

Eigen::Matrix<double, 3, 12> shape_functions(double xi, double length, const ShearRatio& shear) {
  return displacement_rows(1 - xi, xi, deflection(xi, length, shear.xy), deflection(xi, length, shear.xz));
}

Eigen::Matrix<double, 3, 12> rotation_functions(double xi, double length, const ShearRatio& shear) {
  return rotation_rows(1 - xi, xi, rotation(xi, length, shear.xy), rotation(xi, length, shear.xz));
}

}  // namespace mimbre::fe
