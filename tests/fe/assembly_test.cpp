#include <gtest/gtest.h>

#include <Eigen/Core>

#include "fe/meshes.h"
#include "math/once/decompositions.h"
#include "mimbre/beam_reduction.h"

namespace mimbre::test::assembly_test {
namespace {

/// Static solution with node 0 clamped under a force and a moment on one node.
Eigen::VectorXd static_solution(const fe::Mesh& mesh, int node, const Eigen::Matrix<double, 6, 1>& load) {
  const Eigen::MatrixXd K(fe::assemble(mesh).stiffness);
  const Eigen::Index free = K.rows() - 6;
  Eigen::VectorXd f = Eigen::VectorXd::Zero(K.rows());
  f.segment<6>(6 * node) = load;
  Eigen::VectorXd u = Eigen::VectorXd::Zero(K.rows());
  u.tail(free) = Cholesky(K.bottomRightCorner(free, free)).solve(f.tail(free));
  return u;
}

TEST(Assembly, CantileverDeflectsUnderTipLoadsAsTheClosedFormSays) {
  const fe::Section s = rectangle(0.02, 0.03);
  const fe::Material m = steel();
  const double L = 1.2;
  const double G = m.young / (2 * (1 + m.poisson));
  Eigen::Matrix<double, 6, 1> load;
  load << 100, 200, 300, 40, 50, 60;
  for (int elements : {1, 5}) {
    const Eigen::VectorXd u = static_solution(straight_beam(L, elements, s), 1, load);
    Eigen::Matrix<double, 6, 1> exact;
    const double EIz = m.young * s.Iz;
    const double EIy = m.young * s.Iy;
    exact << 100 * L / (m.young * s.area),                     //
        200 * L * L * L / (3 * EIz) + 60 * L * L / (2 * EIz),  //
        300 * L * L * L / (3 * EIy) - 50 * L * L / (2 * EIy),  //
        40 * L / (G * s.J),                                    //
        50 * L / EIy - 300 * L * L / (2 * EIy),                //
        60 * L / EIz + 200 * L * L / (2 * EIz);
    EXPECT_LT((u.segment<6>(6) - exact).norm(), 1e-9 * exact.norm());
  }
}

TEST(Assembly, SectionAxesFollowTheYDirection) {
  const fe::Section s = rectangle(0.02, 0.03);
  fe::Mesh mesh = straight_beam(1, 1, s);
  mesh.elements[0].y_direction = {5, 0, -2};  // in the plane of axis and −z: element y = −z, element z = y
  Eigen::Matrix<double, 6, 1> load = Eigen::Matrix<double, 6, 1>::Zero();
  load[1] = 1;
  EXPECT_NEAR(static_solution(mesh, 1, load)[7] * 3 * steel().young * s.Iy, 1, 1e-9);
}

TEST(Assembly, MatricesAreSymmetricAndRigidMotionsHaveNoEnergyWithOffsetsToo) {
  const fe::Mesh mesh = bent_frame();
  const fe::Matrices matrices = fe::assemble(mesh);
  EXPECT_EQ((Eigen::MatrixXd(matrices.stiffness) - Eigen::MatrixXd(matrices.stiffness.transpose())).norm(),
            0);
  EXPECT_EQ((Eigen::MatrixXd(matrices.mass) - Eigen::MatrixXd(matrices.mass.transpose())).norm(), 0);
  const Eigen::MatrixXd motions = rigid_motions(mesh);
  const double scale = matrices.stiffness.coeffs().cwiseAbs().maxCoeff();
  EXPECT_LT((matrices.stiffness * motions).cwiseAbs().maxCoeff(), 1e-13 * scale);
}

TEST(Assembly, RigidMotionsHaveTheMassAndInertiaOfTheBars) {
  const fe::Mesh mesh = bent_frame();
  const Eigen::MatrixXd motions = rigid_motions(mesh);
  const Eigen::MatrixXd M = motions.transpose() * (fe::assemble(mesh).mass * motions);

  // Thin rods between the offset ends, plus the polar inertia of their sections.
  double mass = 0;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (const fe::BeamElement& e : mesh.elements) {
    const Eigen::Vector3d a = mesh.nodes.col(e.nodes[0]) + e.offsets[0];
    const Eigen::Vector3d b = mesh.nodes.col(e.nodes[1]) + e.offsets[1];
    const double length = (b - a).norm();
    const double m = e.material.density * e.section.area * length;
    const Eigen::Matrix3d P =
        m / 6 * (2 * a * a.transpose() + a * b.transpose() + b * a.transpose() + 2 * b * b.transpose());
    const Eigen::Vector3d axis = (b - a) / length;
    mass += m;
    inertia += P.trace() * Eigen::Matrix3d::Identity() - P +
               e.material.density * (e.section.Iy + e.section.Iz) * length * axis * axis.transpose();
  }
  EXPECT_LT((M.topLeftCorner<3, 3>() - mass * Eigen::Matrix3d::Identity()).norm(), 1e-12 * mass);
  EXPECT_LT((M.bottomRightCorner<3, 3>() - inertia).norm(), 1e-12 * inertia.norm());
}

TEST(Assembly, OffsetActsLikeANearlyRigidMasslessElement) {
  fe::Mesh offset = with_nodes({{0, 0, 0}, {1, 0, 0}});
  add_bar(offset, 0, 1, 1, rectangle(0.02, 0.03), Eigen::Vector3d::UnitY());
  offset.nodes.col(1) += Eigen::Vector3d(0.05, 0.2, -0.1);
  offset.elements[0].offsets[1] = -Eigen::Vector3d(0.05, 0.2, -0.1);

  fe::Mesh stiff = with_nodes({{0, 0, 0}, {1, 0, 0}, offset.nodes.col(1)});
  add_bar(stiff, 0, 1, 1, rectangle(0.02, 0.03), Eigen::Vector3d::UnitY());
  add_bar(stiff, 1, 2, 1, rectangle(0.02, 0.03));
  stiff.elements[1].material.young *= 1e6;

  Eigen::Matrix<double, 6, 1> load;
  load << 100, 200, 300, 40, 50, 60;
  const Eigen::VectorXd a = static_solution(offset, 1, load).segment<6>(6);
  const Eigen::VectorXd b = static_solution(stiff, 2, load).segment<6>(12);
  EXPECT_LT((a - b).norm(), 1e-5 * a.norm());
}

TEST(Assembly, HeavyRigidTipOnAnOffsetLowersTheFrequencyAsTheClosedFormSays) {
  // A stub of large density at distance d from the tip of a nearly massless cantilever, swinging in the x–y
  // plane: the beam's flexibility at the tip and the stub's mass and inertia give a two-dof oscillator.
  const fe::Section s = rectangle(0.02, 0.03);
  const double L = 1;
  const double d = 0.3;
  const double stub = 1e-3;
  fe::Mesh mesh = with_nodes({{0, 0, 0}, {L, 0, 0}, {L + stub, 0, 0}});
  add_bar(mesh, 0, 1, 1, s, Eigen::Vector3d::UnitY());
  add_bar(mesh, 1, 2, 1, s, Eigen::Vector3d::UnitY());
  mesh.elements[0].material.density = 1e-3;
  mesh.elements[1].offsets = {Eigen::Vector3d(d, 0, 0), Eigen::Vector3d(d, 0, 0)};
  mesh.elements[1].material.density = 1e7;
  const double m = 1e7 * s.area * stub;
  const double arm = d + stub / 2;

  const double EI = steel().young * s.Iz;
  Eigen::Matrix2d flexibility;  // of v and θz at the tip
  flexibility << L * L * L / 3, L * L / 2, L * L / 2, L;
  flexibility /= EI;
  Eigen::Matrix2d mass;
  mass << m, m * arm, m * arm, m * arm * arm + m * stub * stub / 12;
  const double lowest = 1 / std::sqrt((flexibility * mass).eval().eigenvalues().real().maxCoeff());
  const Eigen::VectorXd omega = fe::eigenfrequencies(mesh, {0}, 2);
  EXPECT_NEAR(omega[0] / lowest, 1, 1e-4);
}

}  // namespace
}  // namespace mimbre::test::assembly_test
