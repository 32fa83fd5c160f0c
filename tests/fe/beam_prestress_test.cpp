#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "fe/elements/beam_element.h"
#include "fe/meshes.h"
#include "math/gauss.h"
#include "math/once/decompositions.h"
#include "math/rotation.h"
#include "support/dense.h"

/// Geometric stiffness of the beam element by all of its section forces.
namespace mimbre::test::beam_prestress_test {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using fe::Matrix12;
using fe::SectionForces;
using std::numbers::pi;
using Vector12 = Eigen::Matrix<double, 12, 1>;

constexpr double L = 1.3;
constexpr fe::ShearRatio sheared{0.7, 0.4};

Vector3d force(const SectionForces& s, double x) {
  const auto at = [&](const auto& p) { return p[0] + x * (p[1] + x * (p[2] + x * p[3])); };
  return {at(s.axial), at(s.shear_y), at(s.shear_z)};
}
Vector3d moment(const SectionForces& s, double x) {
  return force({.axial = s.torque, .shear_y = s.moment_y, .shear_z = s.moment_z}, x);
}

/// ∫ F·Γ + M·κ ds of the geometrically exact beam by its strains in full, the rotation vector and the
/// displacement interpolated as in the element; and the ½ N γ² by which Engesser differs from Haringx.
double exact_work(const SectionForces& s, const fe::ShearRatio& shear, const Vector12& dofs) {
  double work = 0;
  for (const fe::GaussPoint& g : fe::gauss6) {
    const auto slope_of = [&](const auto& functions) -> Vector3d {
      const double h = 1e-3;  // five points: exact for cubics
      const auto at = [&](double x) -> Vector3d { return functions(x, L, shear) * dofs; };
      return (8 * (at(g.xi + h) - at(g.xi - h)) - at(g.xi + 2 * h) + at(g.xi - 2 * h)) / (12 * h * L);
    };
    const Vector3d x = Vector3d::UnitX(), theta = fe::rotation_functions(g.xi, L, shear) * dofs,
                   gradient = slope_of(fe::shape_functions);
    const Eigen::Matrix3d R = rotation_exp<double>(theta);
    const Vector3d strain = R.transpose() * (x + gradient) - x,
                   curvature = left_jacobian<double>(-theta) * slope_of(fe::rotation_functions),
                   gamma = gradient - theta.cross(x);
    const Vector3d F = force(s, g.xi), M = moment(s, g.xi);
    work += g.weight * L * (F.dot(strain) + M.dot(curvature) + 0.5 * F[0] * gamma.tail<2>().squaredNorm());
  }
  return work;
}

/// Section forces in equilibrium without loads along the element: M' = −x × F.
SectionForces balanced(const Vector3d& F, const Vector3d& M) {
  return {.axial = {F[0]},
          .shear_y = {F[1]},
          .shear_z = {F[2]},
          .torque = {M[0]},
          .moment_y = {M[1], L * F[2]},
          .moment_z = {M[2], -L * F[1]}};
}

TEST(BeamPrestress, IsTheSecondVariationOfAnExactBeamsWork) {
  const SectionForces forces{.axial = {1.1, -0.7, 0.3},
                             .shear_y = {0.4, 0.9, -0.6},
                             .shear_z = {-0.8, 0.5, 1.2},
                             .torque = {0.9, -0.3, 0.1},
                             .moment_y = {-0.5, 0.6, 0.7, -0.9},
                             .moment_z = {0.3, 1.4, -0.2, 0.8}};
  for (const fe::ShearRatio& shear : {fe::ShearRatio{}, sheared}) {
    const Matrix12 k = fe::element_geometric_stiffness(forces, L, shear);
    const double h = 1e-3;
    const auto work = [&](int i, double a, int j, double b) {
      Vector12 dofs = Vector12::Zero();
      dofs[i] += a;
      dofs[j] += b;
      return exact_work(forces, shear, dofs);
    };
    for (int i = 0; i < 12; ++i)
      for (int j = 0; j <= i; ++j) {
        const double second =
            (work(i, h, j, h) - work(i, h, j, -h) - work(i, -h, j, h) + work(i, -h, j, -h)) / (4 * h * h);
        EXPECT_NEAR(k(i, j), second, 5e-6) << i << ' ' << j;
        EXPECT_EQ(k(i, j), k(j, i));
      }
  }
}

/// As the element turns, the forces at its ends turn with it, and half of the moments: the other half is in
/// the work of a moment on rotation vectors, whose rate is not the angular velocity.
TEST(BeamPrestress, ARigidTurnTurnsForces) {
  const Vector3d F(3, -2, 1.5), M(0.7, 0.4, -1.1);
  const SectionForces forces = balanced(F, M);
  for (const fe::ShearRatio& shear : {fe::ShearRatio{}, sheared})
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d turn = Vector3d::Unit(axis);
      Vector12 rigid = Vector12::Zero(), expected;
      rigid.segment<3>(3) = rigid.segment<3>(9) = turn;
      rigid.segment<3>(6) = turn.cross(L * Vector3d::UnitX());
      expected << turn.cross(-F), 0.5 * turn.cross(-M), turn.cross(F), 0.5 * turn.cross(moment(forces, 1));
      const Vector12 found = fe::element_geometric_stiffness(forces, L, shear) * rigid;
      EXPECT_LT((found - expected).norm(), 1e-12) << axis;
    }
}

/// Of a mesh that nodal forces alone displace.
MatrixXd prestress(const fe::Mesh& mesh, const VectorXd& displacement) {
  MatrixXd KG = MatrixXd::Zero(displacement.size(), displacement.size());
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const fe::BeamElement& beam = mesh.elements[e];
    const fe::ElementGeometry geometry = fe::element_geometry(mesh, e);
    const double length = geometry.length;
    const Matrix12 T = fe::element_transformation(beam, geometry.axes);
    Vector12 u;
    u << displacement.segment<6>(6 * beam.nodes[0]), displacement.segment<6>(6 * beam.nodes[1]);
    const Vector12 f = -fe::element_stiffness(beam, length) * T * u;
    const SectionForces forces{.axial = {f[0]},
                               .shear_y = {f[1]},
                               .shear_z = {f[2]},
                               .torque = {f[3]},
                               .moment_y = {f[4], length * f[2]},
                               .moment_z = {f[5], -length * f[1]}};
    const Matrix12 k =
        T.transpose() * fe::element_geometric_stiffness(forces, length, fe::shear_ratio(beam, length)) * T;
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b)
        KG.block<6, 6>(6 * beam.nodes[a], 6 * beam.nodes[b]) += k.block<6, 6>(6 * a, 6 * b);
  }
  return KG;
}

/// Factors of the load, the least of each sign, at which the mesh without the held dofs buckles.
struct Critical {
  double positive, negative;
};
Critical critical_factors(const fe::Mesh& mesh, const std::vector<int>& held, const VectorXd& load) {
  std::vector<int> kept;
  for (int k = 0; k < load.size(); ++k)
    if (std::find(held.begin(), held.end(), k) == held.end()) kept.push_back(k);
  const MatrixXd K = MatrixXd(fe::assemble(mesh).stiffness)(kept, kept);
  VectorXd displacement = VectorXd::Zero(load.size());
  displacement(kept) = mimbre::solve(K, VectorXd(load(kept)));
  const VectorXd values = symmetric_eigenvalues(-prestress(mesh, displacement)(kept, kept), K);
  return {1 / values.maxCoeff(), 1 / values.minCoeff()};
}

/// A strip along x, its width along z, so thin that it does not matter how far it bends in its plane before.
struct Strip {
  fe::Section section = [] {
    fe::Section s = rectangle(0.01, 0.1);
    s.J = 0.1 * 1e-6 / 3 * (1 - 0.63 * 0.1);
    s.shear_y = s.shear_z = s.area / 1.2;
    return s;
  }();
  double length = 2;
  fe::BeamTheory theory = fe::BeamTheory::euler_bernoulli;

  /// √(EI GJ)
  double stiffness() const {
    const fe::Material m = steel();
    return m.young * std::sqrt(section.Iz * section.J / (2 * (1 + m.poisson)));
  }
  fe::Mesh mesh(int elements) const {
    fe::Mesh mesh = straight_beam(length, elements, section);
    for (fe::BeamElement& element : mesh.elements) element.theory = theory;
    return mesh;
  }
};

/// Ends that cannot twist or move across, but bend freely (forks); x held at one.
const std::vector<int> forks{0, 1, 2, 3, 7, 8, 9};
const std::vector<int> clamp{0, 1, 2, 3, 4, 5};

VectorXd nodal(const fe::Mesh& mesh, std::initializer_list<std::pair<int, double>> loads) {
  VectorXd out = VectorXd::Zero(6 * mesh.nodes.cols());
  for (const auto& [dof, value] : loads) out[dof] = value;
  return out;
}

class LateralBuckling : public testing::TestWithParam<fe::BeamTheory> {
 protected:
  Strip strip{.theory = GetParam()};
};
INSTANTIATE_TEST_SUITE_P(Theories, LateralBuckling,
                         testing::Values(fe::BeamTheory::euler_bernoulli, fe::BeamTheory::timoshenko),
                         [](const auto& p) {
                           return p.param == fe::BeamTheory::timoshenko ? "timoshenko" : "euler_bernoulli";
                         });

// M = π √(EI GJ)/L (Timoshenko, Gere 1961, 6.2).
TEST_P(LateralBuckling, OfABeamUnderAUniformMoment) {
  const fe::Mesh mesh = strip.mesh(32);
  const Critical M = critical_factors(mesh, forks, nodal(mesh, {{4, -1}, {10, 1}}));
  const double exact = pi * strip.stiffness() / strip.length;
  EXPECT_NEAR(M.positive, exact, 1e-3 * exact);
  EXPECT_NEAR(M.negative, -exact, 1e-3 * exact);
}

// P = 4.0126 √(EI GJ)/L² (Prandtl 1899; Timoshenko, Gere 1961, 6.3).
TEST_P(LateralBuckling, OfACantileverUnderAForceAtItsTip) {
  const fe::Mesh mesh = strip.mesh(16);
  const Critical P = critical_factors(mesh, clamp, nodal(mesh, {{8, 1}}));
  const double exact = 4.0126 * strip.stiffness() / (strip.length * strip.length);
  EXPECT_NEAR(P.positive, exact, 2e-3 * exact);
  EXPECT_NEAR(P.negative, -exact, 2e-3 * exact);
}

// P = 16.94 √(EI GJ)/L² (Timoshenko, Gere 1961, 6.4).
TEST_P(LateralBuckling, OfASimplySupportedBeamUnderAForceInItsMiddle) {
  const int elements = 16;
  const fe::Mesh mesh = strip.mesh(elements);
  int middle = 0;
  (mesh.nodes.row(0).array() - strip.length / 2).abs().minCoeff(&middle);
  const Critical P = critical_factors(mesh, forks, nodal(mesh, {{6 * middle + 2, 1}}));
  const double exact = 16.94 * strip.stiffness() / (strip.length * strip.length);
  EXPECT_NEAR(P.positive, exact, 2e-3 * exact);
  EXPECT_NEAR(P.negative, -exact, 2e-3 * exact);
}

/// Two legs of 240 at a right angle in the plane x–y, 30 wide in it and 0.6 thick, E = 71240, ν = 0.31
/// (Argyris, Hilpert, Malejannakis, Scharpf, Comput. Meth. Appl. Mech. Eng. 20 (1979) 105–155).
struct RightAngle {
  fe::Mesh mesh = with_nodes({Vector3d::Zero(), Vector3d(240, 0, 0), Vector3d(240, -240, 0)});
  explicit RightAngle(int elements) {
    fe::Section s = rectangle(30, 0.6);
    s.J = 30 * 0.6 * 0.6 * 0.6 / 3;
    add_bar(mesh, 0, 1, elements, s, Vector3d::UnitY());
    add_bar(mesh, 1, 2, elements, s, Vector3d::UnitX());
    for (fe::BeamElement& element : mesh.elements) element.material = {71240, 0.31, 1};
  }
};

// Moments about z at both ends, which turn about z alone, one of them sliding along x: ± π √(EI GJ)/L. What
// moments do as the corner turns decides: with another matrix than that of rotation vectors the two legs do
// not agree on it.
TEST(RightAngleFrame, BucklesUnderMomentsAtItsHinges) {
  const RightAngle frame(20);
  // The legs lie at 45° to the line between the hinges, along which one end slides.
  const Eigen::Matrix3d R = rotation_exp<double>(pi / 4 * Vector3d::UnitZ());
  const fe::Mesh mesh = moved(frame.mesh, R, Vector3d::Zero());
  const std::vector<int> hinges{0, 1, 2, 3, 4, 13, 14, 15, 16};
  const Critical M = critical_factors(mesh, hinges, nodal(mesh, {{5, -1}, {17, 1}}));
  const double EI = 71240 * 30 * 0.216 / 12, GJ = 71240 / 2.62 * 30 * 0.216 / 3;
  const double exact = pi * std::sqrt(EI * GJ) / 240;
  EXPECT_NEAR(exact, 622.2, 0.1);
  EXPECT_NEAR(M.positive, exact, 2e-3 * exact);
  EXPECT_NEAR(M.negative, -exact, 2e-3 * exact);
}

// Clamped, a force along the first leg at the end of the second: 1.088 (Argyris et al. 1979; J. C. Simo, L.
// Vu-Quoc, Comput. Meth. Appl. Mech. Eng. 58 (1986) 79–116, find 1.09).
TEST(RightAngleFrame, BucklesUnderAForceAtItsEnd) {
  const RightAngle frame(10);
  const Critical P = critical_factors(frame.mesh, clamp, nodal(frame.mesh, {{12, 1}}));
  EXPECT_NEAR(std::max(P.positive, -P.negative), 1.088, 0.01 * 1.088) << P.positive << ' ' << P.negative;
}

}  // namespace
}  // namespace mimbre::test::beam_prestress_test
