#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "compile/flexible_data.h"
#include "dynamics/ancf.h"
#include "dynamics/elasticity.h"
#include "math/once/decompositions.h"
#include "mimbre/beam_reduction.h"
#include "mimbre/fe.h"

/// Beams in space by absolute nodal coordinates.
namespace mimbre::test::ancf_spatial_test {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double length = 0.7;

const Mat3d& line_axes() {
  static const Mat3d axes = rotation_exp<double>(Vec3d(0.7, -0.4, 0.2));
  return axes;
}

/// A line along an oblique axis from (0.1, 0.2, 0.3), `height` times as high as it is wide.
fe::Mesh line(AncfKind kind, int elements, double height) {
  fe::Mesh mesh;
  mesh.nodes.resize(3, elements + 1);
  fe::BeamElement element;
  element.material = {1e9, 0.25, 2000};
  const double b = 0.02, h = height * b;
  element.section = {b * h,       b * b * b * h / 12, b * h * h * h / 12, 0.2 * b * b * b * h,
                     b * h / 1.2, b * h / 1.3};
  element.y_direction = line_axes().col(1);
  if (kind == AncfKind::thick) element.theory = fe::BeamTheory::timoshenko;
  for (int k = 0; k <= elements; ++k)
    mesh.nodes.col(k) = Vector3d(0.1, 0.2, 0.3) + length * k / elements * line_axes().col(0);
  for (int k = 0; k < elements; ++k) {
    element.nodes = {k, k + 1};
    mesh.elements.push_back(element);
  }
  return mesh;
}

ReducedBody beam(AncfKind kind, int elements, double height = 1) {
  return fe::ancf_beam(line(kind, elements, height), {kind, 0, Vector3d::UnitZ(), 0.01},
                       {{"tip", elements, Mat3d::Identity()}});
}

struct Case {
  const char* name;
  AncfKind kind;
};

class AncfInSpace : public testing::TestWithParam<Case> {
 protected:
  const AncfKind kind = GetParam().kind;
  const double height = kind == AncfKind::thick ? 2.5 : 1;
  std::mt19937 random{5};

  /// The last of two elements as the step sees it, all of its amplitudes free.
  FlexibleData free_element() const {
    FlexibleData f = flexible_data(beam(kind, 2, height));
    AncfSpatialElement e = f.ancf_spatial[1];
    const int n = kind == AncfKind::thick ? 27 : 12;
    for (int k = 0; k < n; ++k) e.amplitudes[static_cast<std::size_t>(k)] = k;
    f.ancf_spatial = {e};
    f.modes = f.amplitudes = n;
    f.stride = pad(n);
    return f;
  }

  /// Its amplitudes where it moves as a rigid body, and `scale` times random ones.
  VectorXd state(const FlexibleData& f, const Mat3d& turn, double scale) {
    std::uniform_real_distribution<double> u(-scale, scale);
    VectorXd y(f.stride);
    y.setZero();
    const int vectors = kind == AncfKind::thick ? 3 : 2, nodes = f.modes / (3 * vectors);
    const double L = f.ancf_spatial[0].length;
    for (int k = 0; k < nodes; ++k)
      for (int v = 0; v < vectors; ++v) {
        const Vector3d undeformed = v == 0                    ? Vector3d(L * k / (nodes - 1), 0, 0)
                                    : kind == AncfKind::thick ? Vector3d::Unit(v)
                                                              : Vector3d(Vector3d::UnitX());
        Vector3d at = turn * undeformed - undeformed;
        if (v == 0) at += Vector3d(0.3, -0.2, 0.5);
        y.segment<3>(3 * (vectors * k + v)) = at;
      }
    for (int k = 0; k < f.modes; ++k) y[k] += u(random);
    return y;
  }

  static VectorXd forces(const FlexibleData& f, const VectorXd& y, const VectorXd& yd) {
    VectorXd out = VectorXd::Zero(y.size());
    add_elasticity<double>(f, y.data(), yd.data(), out.data());
    return out;
  }
  static MatrixXd tangent(const FlexibleData& f, const VectorXd& y, double stiffness, double damping) {
    MatrixXd out = MatrixXd::Zero(y.size(), y.size());
    ancf::add_tangent<double>(f, y.data(), stiffness, damping,
                              [&](int r, int c, double x) { out(r, c) += x; });
    return out;
  }
};

TEST_P(AncfInSpace, RigidMotionsGiveNoForce) {
  const FlexibleData f = free_element();
  for (const Vec3d& turn : {Vec3d(0, 0, 0), Vec3d(0.5, -1, 0.3), Vec3d(2, 1, -2), Vec3d(0, 0, 3)}) {
    const VectorXd y = state(f, rotation_exp<double>(turn), 0), none = VectorXd::Zero(y.size());
    const double stiff = tangent(f, y, 1, 0).norm();
    EXPECT_LT(forces(f, y, none).norm(), 1e-14 * stiff);
    EXPECT_LT(ancf::energy<double>(f, y.data()), 1e-28 * stiff);
  }
}

TEST_P(AncfInSpace, ForcesAreTheGradientOfTheEnergyAndTheTangentTheirJacobian) {
  const FlexibleData f = free_element();
  for (int round = 0; round < 10; ++round) {
    const Mat3d turn = rotation_exp<double>(Vec3d(0.4 * round, 0.3, -0.2 * round));
    const VectorXd y = state(f, turn, 0.15), yd = state(f, turn, 1), none = VectorXd::Zero(y.size());
    const VectorXd r = forces(f, y, none);
    const MatrixXd K = tangent(f, y, 1, 0), D = tangent(f, y, 0, 1);
    const double h = 1e-6;
    for (int k = 0; k < f.modes; ++k) {
      const VectorXd d = h * VectorXd::Unit(y.size(), k), plus = y + d, minus = y - d;
      EXPECT_NEAR((ancf::energy<double>(f, plus.data()) - ancf::energy<double>(f, minus.data())) / (2 * h),
                  r[k], 1e-7 * r.norm() + 1e-7 * K.norm() * h);
      EXPECT_LT(((forces(f, plus, none) - forces(f, minus, none)) / (2 * h) - K.col(k)).norm(),
                1e-6 * K.norm());
      EXPECT_LT((forces(f, y, yd + VectorXd::Unit(y.size(), k)) - forces(f, y, yd) - D.col(k)).norm(),
                1e-9 * D.norm());
    }
    EXPECT_LT((K - K.transpose()).norm(), 1e-12 * K.norm());
    EXPECT_GE((forces(f, y, yd) - r).dot(yd), 0);  // rates of strain dissipate
    EXPECT_GE(symmetric_eigenvalues(D).minCoeff(), -1e-9 * D.norm());
  }
}

/// As many strains as ways to deform: six motions cost nothing, no other does.
TEST_P(AncfInSpace, OnlyRigidMotionsCostNothing) {
  const FlexibleData f = free_element();
  const VectorXd y = state(f, Mat3d::Identity(), 0);
  const VectorXd values = symmetric_eigenvalues(tangent(f, y, 1, 0).topLeftCorner(f.modes, f.modes));
  int zeros = 0;
  for (const double v : values) zeros += v < 1e-9 * values.maxCoeff() ? 1 : 0;
  EXPECT_EQ(zeros, kind == AncfKind::thick ? 6 : 5) << values.transpose();  // nor the twist of a cable
}

/// The stiffness that is written down for small deflections is the tangent of the large ones.
TEST_P(AncfInSpace, TheStiffnessIsTheTangentAtRest) {
  const ReducedBody body = beam(kind, 3, height);
  EXPECT_TRUE(check(body).empty());
  const FlexibleData f = flexible_data(body);
  const MatrixXd K = tangent(f, VectorXd::Zero(f.stride), 1, 0).topLeftCorner(f.modes, f.modes);
  EXPECT_LT((K - body.stiffness).norm(), 1e-12 * K.norm());
}

/// Mass, and kinetic energy of a rigid motion of all nodes, against those of a rod.
TEST_P(AncfInSpace, IntegralsAreThoseOfTheRod) {
  const int n = 3;
  const ReducedBody body = beam(kind, n, height);
  const fe::BeamElement e = line(kind, n, height).elements[0];
  const double per_length = e.material.density * e.section.area, mass = per_length * length;
  EXPECT_NEAR(body.mass, mass, 1e-12 * mass);
  const Vector3d centre = Vector3d(0.1, 0.2, 0.3) + 0.5 * length * line_axes().col(0);
  EXPECT_LT((body.first_moment - mass * centre).norm(), 1e-12 * mass);
  // About the first node.
  const Mat3d P = line_axes().transpose() *
                  (body.second_moment - body.first_moment * body.nodes.col(0).transpose() -
                   body.nodes.col(0) * body.first_moment.transpose() +
                   mass * body.nodes.col(0) * body.nodes.col(0).transpose()) *
                  line_axes();
  const double along = mass * length * length / 3, J = e.material.density * length;
  const bool thick = kind == AncfKind::thick;
  const double polar = J * (e.section.Iy + e.section.Iz);
  EXPECT_NEAR(P(0, 0), along - (thick ? 0 : 0.5 * polar), 1e-12 * along);
  EXPECT_NEAR(P(1, 1), thick ? J * e.section.Iz : 0.5 * polar, 1e-12 * along);
  EXPECT_NEAR(P(2, 2), thick ? J * e.section.Iy : 0.5 * polar, 1e-12 * along);
  EXPECT_NEAR(P(0, 1), 0, 1e-12 * along);
  EXPECT_NEAR(P(1, 2), 0, 1e-12 * along);
}

/// Frequencies of a cantilever against those of many beam elements of the same theory.
TEST_P(AncfInSpace, FrequenciesAreThoseOfBeamElements) {
  const VectorXd exact = fe::eigenfrequencies(line(kind, 100, height), {0}, 4);
  const auto frequencies = [&](int elements) {
    const ReducedBody body = beam(kind, elements, height);
    return VectorXd(symmetric_eigenvalues(body.stiffness, body.mass_matrix).cwiseMax(0).cwiseSqrt());
  };
  double before = 0;
  for (const int elements : {4, 8}) {
    const VectorXd found = frequencies(elements);
    double most = 0;
    for (int k = 0; k < 4; ++k) most = std::max(most, std::abs(found[k] / exact[k] - 1));
    std::cout << "  " << GetParam().name << ", " << elements << " elements: " << most << '\n';
    if (before > 0) {
      EXPECT_LT(most, kind == AncfKind::thick ? 2e-3 : 2e-4);
      EXPECT_GT(before / most, 8) << "of more than the third order";
    }
    before = most;
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, AncfInSpace,
                         testing::Values(Case{"cable", AncfKind::cable}, Case{"thick", AncfKind::thick}),
                         [](const auto& of) { return of.param.name; });

TEST(AncfThick, TwistShearAndStretchResistAsBeamsDo) {
  const ReducedBody body = beam(AncfKind::thick, 2, 2.5);
  const fe::BeamElement e = line(AncfKind::thick, 2, 2.5).elements[0];
  const double G = e.material.young / (2 * (1 + e.material.poisson));
  const FlexibleData f = flexible_data(body);
  // Nodes at 0, L/4, … L, the first without amplitudes.
  const auto strained = [&](auto at) {
    VectorXd y = VectorXd::Zero(f.stride);
    for (int k = 1; k <= 4; ++k) {
      const double x = length * k / 4;
      const Eigen::Matrix3d d = at(x);  // columns: displacement, changes of y and z
      for (int v = 0; v < 3; ++v) y.segment<3>(9 * (k - 1) + 3 * v) = d.col(v);
    }
    return ancf::energy<double>(f, y.data());
  };
  const double strain = 0.02, rate = 2.0;  // rad/m
  EXPECT_NEAR(strained([&](double x) {
                Eigen::Matrix3d d = Eigen::Matrix3d::Zero();
                d(0, 0) = strain * x;
                return d;
              }),
              0.5 * e.material.young * e.section.area * strain * strain * length, 1e-9);
  // Of the second order in the angle of an element, since sections between nodes are means.
  const double twist = strained([&](double x) {
    Eigen::Matrix3d d = rotation_exp<double>(Vec3d(rate * x, 0, 0)) - Mat3d::Identity();
    d.col(0).setZero();
    return d;
  });
  EXPECT_NEAR(twist / (0.5 * G * e.section.J * rate * rate * length), 1, 0.01);
  const double small = 1e-3;
  const double shear = strained([&](double x) {
    Eigen::Matrix3d d = Eigen::Matrix3d::Zero();
    d(1, 0) = small * x;
    return d;
  });
  EXPECT_NEAR(shear / (0.5 * G * e.section.shear_y * small * small * length), 1, 1e-5);
  const double shear_z = strained([&](double x) {
    Eigen::Matrix3d d = Eigen::Matrix3d::Zero();
    d(2, 0) = small * x;
    return d;
  });
  EXPECT_NEAR(shear_z / (0.5 * G * e.section.shear_z * small * small * length), 1, 1e-5);
  // Bent to parabolas v = ½ c x², their sections at right angles to the line.
  const double c = 1e-3;
  const auto bent = [&](int across) {
    return strained([&](double x) {
      Eigen::Matrix3d d = Eigen::Matrix3d::Zero();
      d(across, 0) = 0.5 * c * x * x;
      d(0, across) = -c * x;
      return d;
    });
  };
  EXPECT_NEAR(bent(1) / (0.5 * e.material.young * e.section.Iz * c * c * length), 1, 1e-3);
  EXPECT_NEAR(bent(2) / (0.5 * e.material.young * e.section.Iy * c * c * length), 1, 1e-3);
}

TEST(AncfInSpaceRefuses, LinesThatDoubleBack) {
  fe::Mesh back = line(AncfKind::cable, 2, 1);
  back.nodes.col(1) = back.nodes.col(0) + 1.5 * (back.nodes.col(2) - back.nodes.col(0));
  EXPECT_THROW(fe::ancf_beam(back, {AncfKind::cable, 0, Vector3d::UnitZ(), 0}, {}), std::invalid_argument);
}

TEST(AncfInSpaceRefuses, WhatItDoesNotKnow) {
  EXPECT_THROW(beam(AncfKind::cable, 2, 2), std::invalid_argument);  // Iy ≠ Iz
  fe::Mesh thin = line(AncfKind::thick, 2, 2);
  for (fe::BeamElement& e : thin.elements) e.theory = fe::BeamTheory::euler_bernoulli;
  EXPECT_THROW(fe::ancf_beam(thin, {AncfKind::thick, 0, Vector3d::UnitZ(), 0}, {}), std::invalid_argument);
  fe::Mesh turned = line(AncfKind::thick, 2, 2);
  turned.elements[1].y_direction = line_axes().col(2);
  EXPECT_THROW(fe::ancf_beam(turned, {AncfKind::thick, 0, Vector3d::UnitZ(), 0}, {}), std::invalid_argument);
  fe::Mesh sheared = line(AncfKind::cable, 2, 1);
  sheared.elements[0].theory = fe::BeamTheory::rayleigh;
  EXPECT_THROW(fe::ancf_beam(sheared, {AncfKind::cable, 0, Vector3d::UnitZ(), 0}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace mimbre::test::ancf_spatial_test
