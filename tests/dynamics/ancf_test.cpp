#include "dynamics/ancf.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <random>

#include "compile/flexible_data.h"
#include "dynamics/elasticity.h"
#include "math/once/decompositions.h"
#include "mimbre/beam_reduction.h"

namespace mimbre::test::ancf_test {
namespace {

constexpr double EA = 5e4, EI = 30;

/// A line along an oblique axis in the plane z = 0, clamped at its first node.
fe::Mesh line(int elements, double length) {
  fe::Mesh mesh;
  mesh.nodes.resize(3, elements + 1);
  fe::BeamElement element;
  element.material = {1e9, 0.3, 2000};
  element.section = {EA / 1e9, EI / 1e9, EI / 1e9, 2 * EI / 1e9};
  for (int k = 0; k <= elements; ++k)
    mesh.nodes.col(k) = length * k / elements * Eigen::Vector3d(0.6, 0.8, 0);
  for (int k = 0; k < elements; ++k) {
    element.nodes = {k, k + 1};
    mesh.elements.push_back(element);
  }
  return mesh;
}

/// One element whose eight amplitudes are all free, as the step sees it.
FlexibleData free_element(double length, double damping = 0) {
  FlexibleData f;
  f.modes = f.amplitudes = f.stride = 8;
  AncfElement e;
  for (int k = 0; k < 8; ++k) e.amplitudes[static_cast<std::size_t>(k)] = k;
  // The second element of a line of two has no amplitude that is held at zero.
  AncfElement second = flexible_data(fe::ancf_beam(line(2, 2 * length), {}, {})).ancf[1];
  second.amplitudes = e.amplitudes;
  f.ancf = {second};
  f.ancf_damping = damping;
  return f;
}

using Vector8 = Eigen::Matrix<double, 8, 1>;

/// A deformed element: rigid motion by `angle`, then random amplitudes.
Vector8 state(double length, double angle, double scale, std::mt19937& random) {
  std::uniform_real_distribution<double> u(-scale, scale);
  const double c = std::cos(angle), s = std::sin(angle);
  Vector8 y;
  y << 0.3, -0.2, c - 1, s, 0.3 + length * (c - 1), -0.2 + length * s, c - 1, s;
  for (double& x : y) x += u(random);
  return y;
}

Vector8 forces(const FlexibleData& f, const Vector8& y, const Vector8& yd = Vector8::Zero()) {
  Vector8 out = Vector8::Zero();
  add_elasticity<double>(f, y.data(), yd.data(), out.data());
  return out;
}

TEST(Ancf, RigidMotionsGiveNoForce) {
  const FlexibleData f = free_element(0.7);
  std::mt19937 random(1);
  for (const double angle : {0.0, 0.5, 2.0, 4.0, -3.0}) {
    const Vector8 y = state(0.7, angle, 0, random);
    EXPECT_LT(forces(f, y).norm(), 1e-10 * EA);
    EXPECT_LT(ancf::energy<double>(f, y.data()), 1e-20 * EA);
  }
}

TEST(Ancf, ForcesAreTheGradientOfTheEnergyAndTheTangentTheirJacobian) {
  const FlexibleData f = free_element(0.7, 0.01);
  std::mt19937 random(2);
  for (int round = 0; round < 20; ++round) {
    const Vector8 y = state(0.7, 0.4 * round, 0.2, random), yd = state(0.7, 1, 1, random);
    const Vector8 r = forces(f, y);
    Eigen::Matrix<double, 8, 8> tangent = Eigen::Matrix<double, 8, 8>::Zero(), damping = tangent;
    ancf::add_tangent<double>(f, y.data(), 1, 0, [&](int i, int j, double x) { tangent(i, j) += x; });
    ancf::add_tangent<double>(f, y.data(), 0, 1, [&](int i, int j, double x) { damping(i, j) += x; });
    const double h = 1e-6;
    for (int k = 0; k < 8; ++k) {
      const Vector8 d = h * Vector8::Unit(k);
      const Vector8 plus = y + d, minus = y - d;
      EXPECT_NEAR((ancf::energy<double>(f, plus.data()) - ancf::energy<double>(f, minus.data())) / (2 * h),
                  r[k], 1e-4 * EA * h + 1e-6 * r.norm());
      EXPECT_LT(((forces(f, plus) - forces(f, minus)) / (2 * h) - tangent.col(k)).norm(),
                1e-7 * tangent.norm());
      EXPECT_LT((forces(f, y, yd + Vector8::Unit(k)) - forces(f, y, yd) - damping.col(k)).norm(),
                1e-9 * damping.norm());
    }
    // Strains' rates dissipate.
    EXPECT_GE((forces(f, y, yd) - r).dot(yd), 0);
    EXPECT_GE(symmetric_eigenvalues(damping).minCoeff(), -1e-9 * damping.norm());
  }
}

/// Stretched by ε the ends pull with EA ε, and an arc of a circle has the moment EI / radius.
TEST(Ancf, StretchingAndBendingResistAsBeamsDo) {
  const double L = 0.7, strain = 0.02;
  const FlexibleData f = free_element(L);
  Vector8 y;
  y << 0, 0, strain, 0, L * strain, 0, strain, 0;
  const Vector8 pull = forces(f, y);
  EXPECT_NEAR(pull[4], EA * strain, 1e-9 * EA);
  EXPECT_NEAR(pull[0], -EA * strain, 1e-9 * EA);
  EXPECT_NEAR(ancf::energy<double>(f, y.data()), 0.5 * EA * strain * strain * L, 1e-9 * EA);

  const double angle = 0.05, radius = L / angle;
  y << 0, 0, 0, 0, radius * std::sin(angle) - L, radius * (1 - std::cos(angle)), std::cos(angle) - 1,
      std::sin(angle);
  EXPECT_NEAR(ancf::energy<double>(f, y.data()), 0.5 * EI * angle * angle / L,
              1e-3 * 0.5 * EI * angle * angle / L);
}

TEST(Ancf, IntegralsAreThoseOfTheLine) {
  const ReducedBody body = fe::ancf_beam(line(3, 3), {}, {{"tip", 3, Eigen::Matrix3d::Identity()}});
  EXPECT_EQ(body.modes, 13);
  EXPECT_TRUE(check(body).empty());
  const double mass = 2000 * EA / 1e9 * 3;
  EXPECT_NEAR(body.mass, mass, 1e-12 * mass);
  // All nodes moved by the same vector: the whole mass moves, the first node being held apart from it.
  Eigen::VectorXd shift = Eigen::VectorXd::Zero(13);
  for (int k = 1; k <= 3; ++k) shift[4 * k - 3] = 1;
  // Uniform stretch: displacement x along.
  Eigen::VectorXd stretch = Eigen::VectorXd::Zero(13);
  stretch[0] = 1;
  for (int k = 1; k <= 3; ++k) {
    stretch[4 * k - 3] = k;
    stretch[4 * k - 1] = 1;
  }
  EXPECT_LT((body.S * stretch - body.first_moment).norm(), 1e-12 * mass);
  EXPECT_NEAR(stretch.dot(body.mass_matrix * stretch), mass * 3, 1e-10 * mass);  // ∫ x² dm = m L²/3
  EXPECT_NEAR(stretch.dot(body.stiffness * stretch), EA * 3, 1e-9 * EA);
  EXPECT_LT((body.frames[0].X * stretch - 3 * Eigen::Vector3d(0.6, 0.8, 0)).norm(), 1e-12);
}

TEST(Ancf, RefusesWhatIsNoStraightLine) {
  fe::Mesh bent = line(2, 1);
  bent.nodes.col(2).x() += 0.1;
  EXPECT_THROW(fe::ancf_beam(bent, {}, {}), std::invalid_argument);
  fe::AncfOptions along;
  along.normal = Eigen::Vector3d(0.6, 0.8, 0);
  EXPECT_THROW(fe::ancf_beam(line(2, 1), along, {}), std::invalid_argument);
  fe::AncfOptions middle;
  middle.clamped_node = 1;
  EXPECT_THROW(fe::ancf_beam(line(2, 1), middle, {}), std::invalid_argument);
}

}  // namespace
}  // namespace mimbre::test::ancf_test
