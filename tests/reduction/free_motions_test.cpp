#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "fe/bar_ends.h"
#include "fe/solid_meshes.h"
#include "math/once/decompositions.h"
#include "mimbre/fe_reduce.h"
#include "reduction/bases/shapes.h"
#include "reduction/tied_model.h"

/// Motions of interfaces that are left free or held.
namespace mimbre::test::free_motions_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using fe::Interface;
using Motion = fe::Interface::Motion;

constexpr double length = 1, width = 0.1, height = 0.05;
const fe::Material steel_bar{2.1e11, 0.3, 7850};

fe::SolidMesh bar() { return block(fe::ElementType::hex20, {length, width, height}, {8, 1, 1}, steel_bar); }

/// Root held by the frame, the tip as told.
fe::ModelReduction options(const fe::SolidMesh& mesh, const std::array<Motion, 6>& tip, int modes,
                           Interface::Tie tie = Interface::Tie::rigid) {
  fe::ModelReduction o;
  o.interfaces = {end(mesh, "root", 0, tie), end(mesh, "tip", length, tie)};
  o.interfaces[1].motions = tip;
  o.dynamic_modes = modes;
  o.free_modes = 0;
  return o;
}

constexpr auto R = Motion::retained, F = Motion::free, H = Motion::held;

/// The tied model with free motions does what dense elimination of them does.
TEST(FreeMotions, AreEliminatedAsInADenseModel) {
  const fe::SolidMesh mesh = block(fe::ElementType::hex8, {length, width, height}, {4, 1, 1}, steel_bar);
  const fe::FeMatrices m = fe::assemble(mesh);
  const MatrixXd K = full(m.stiffness), M = full(m.mass);
  for (const auto tie : {Interface::Tie::rigid, Interface::Tie::mean}) {
    fe::ModelReduction o = options(mesh, {R, F, R, F, H, F}, 3, tie);
    const fe::TiedModel freed(mesh, m, o.interfaces);
    std::vector<Interface> all = o.interfaces;
    all[1].motions = {};
    const fe::TiedModel tied(mesh, m, all);
    const Index n = tied.internals();
    // u = T [x; z] with all motions; free ones behind the x.
    MatrixXd x = MatrixXd::Zero(n, n + 12), z = MatrixXd::Zero(12, n + 12);
    x.leftCols(n).setIdentity();
    z.rightCols(12).setIdentity();
    const MatrixXd T = tied.expand(x, z);
    std::vector<Index> inner(static_cast<std::size_t>(n));
    for (Index k = 0; k < n; ++k) inner[static_cast<std::size_t>(k)] = k;
    for (const Index motion : {7, 9, 11}) inner.push_back(n + motion);
    const MatrixXd Kt = T.transpose() * K * T, Mt = T.transpose() * M * T;
    const MatrixXd Kii = Kt(inner, inner);

    ASSERT_EQ(freed.internals(), n + 3);
    const fe::Modes modes = fe::block_lanczos(freed.held(), 3);
    const VectorXd exact = symmetric_eigenvalues(Kii, Mt(inner, inner));
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(modes.eigenvalues[k] / exact[k], 1, 1e-8);

    const fe::Shapes statics = fe::static_shapes(freed, m, o.interfaces, 1);
    ASSERT_EQ(statics.names, (std::vector<std::string>{"static tip.x", "static tip.z"}));
    for (int column = 0; column < 2; ++column) {
      const Index motion = n + (column == 0 ? 6 : 8);
      VectorXd coordinates = VectorXd::Zero(n + 12);
      coordinates[motion] = 1;
      coordinates(inner) = -PivotedCholesky(Kii).solve(Kt.col(motion)(inner));
      const VectorXd u = T * coordinates;
      EXPECT_LT((statics.dofs.col(column) - u).norm(), 1e-8 * u.norm());
      EXPECT_LT((statics.points.col(column) - fe::point_rows(o.interfaces, coordinates.tail(12))).norm(),
                1e-8);
    }
  }
}

TEST(FreeMotions, HingedTipBendsAsABarWithoutMomentThere) {
  // Without Poisson's ratio the clamped ends of a wide bar are Timoshenko's.
  const fe::Material plain{2.1e11, 0, 7850};
  const fe::SolidMesh mesh = block(fe::ElementType::hex20, {length, width, height}, {20, 1, 1}, plain);
  const fe::FeMatrices m = fe::assemble(mesh);
  const double I = width * std::pow(height, 3) / 12, bending = std::pow(length, 3) / (plain.young * I),
               shear = length / (5.0 / 6 * plain.young / 2 * width * height);
  // All but the displacement across.
  const ReducedBody body = fe::reduce(mesh, m, options(mesh, {F, F, R, F, F, F}, 0)).body;
  ASSERT_EQ(body.modes, 1);
  const double x = body.frames[1].X(2, 0);
  EXPECT_NEAR(body.stiffness(0, 0) / (x * x) * (bending / 3 + shear), 1, 0.002);
  EXPECT_NEAR(body.frames[1].X_theta(1, 0) / x, -0.5 * bending / (bending / 3 + shear) / length, 0.005);
  const ReducedBody held = fe::reduce(mesh, m, options(mesh, {H, H, R, H, H, H}, 0)).body;
  const double y = held.frames[1].X(2, 0);
  EXPECT_NEAR(held.stiffness(0, 0) / (y * y) * (bending / 12 + shear), 1, 0.005);
  EXPECT_LT(held.frames[1].X_theta.cwiseAbs().maxCoeff(), 1e-9 * std::abs(y));
}

TEST(FreeMotions, GiveTheModesOfTheClampedBar) {
  const fe::SolidMesh mesh = bar();
  const fe::FeMatrices m = fe::assemble(mesh);
  fe::ModelReduction clamped = options(mesh, {F, F, F, F, F, F}, 4);
  const fe::ReductionResult freed = fe::reduce(mesh, m, clamped);
  EXPECT_EQ(freed.body.modes, 4);
  // A cantilever's first bending, Euler and Bernoulli: 1.8751² √(EI/ρA) / L².
  const double f = std::pow(1.8751, 2) *
                   std::sqrt(steel_bar.young * height * height / 12 / steel_bar.density) /
                   (2 * std::numbers::pi);
  EXPECT_NEAR(freed.fixed_frequencies[0], f, 0.02 * f);
  // The eigenmodes of the body are those: no static mode adds to them.
  EXPECT_NEAR(freed.body.eigenfrequencies[0] / (2 * std::numbers::pi), freed.fixed_frequencies[0], 1e-6 * f);
  bool said = false;
  for (const Check& c : freed.body.checks)
    if (c.name == "number of modes") {
      said = true;
      EXPECT_THAT(c.detail,
                  testing::HasSubstr("4 = 12 motions of 2 interfaces − 6 of the body − 6 free + 4"));
    }
  EXPECT_TRUE(said);
}

TEST(FreeMotions, OfTheMeanFrameKeepTheRigidOnes) {
  const fe::SolidMesh mesh = bar();
  const fe::FeMatrices m = fe::assemble(mesh);
  fe::ModelReduction o = options(mesh, {R, R, R, F, F, F}, 4);
  o.frame = fe::ModelReduction::Frame::mean_axis;
  o.free_modes = 3;
  const fe::ReductionResult r = fe::reduce(mesh, m, o);
  EXPECT_EQ(r.body.modes, 6 + 3 + 4 - 6);
  EXPECT_LT(r.body.S.norm(), 1e-9);  // no momentum
  EXPECT_NEAR(r.reduced_free_frequencies[0] / r.free_frequencies[0], 1, 0.02);
}

TEST(FreeMotions, WhereTheyMakeNoSenseAreRefused) {
  const fe::SolidMesh mesh = bar();
  const fe::FeMatrices m = fe::assemble(mesh);
  const auto complaint = [&](fe::ModelReduction o) -> std::string {
    try {
      fe::reduce(mesh, m, o);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "no error";
  };
  fe::ModelReduction o = options(mesh, {R, R, R, F, F, F}, 2);
  o.interfaces[0].motions[5] = Motion::free;
  EXPECT_THAT(complaint(o), testing::HasSubstr("'root': the body frame moves with it"));
  o.interfaces[0].motions = {};
  o.basis = fe::ModelReduction::Basis::krylov;
  EXPECT_THAT(complaint(o), testing::HasSubstr("Craig-Bampton"));
  o = options(mesh, {H, R, R, R, R, R}, 2);
  o.frame = fe::ModelReduction::Frame::mean_axis;
  EXPECT_THAT(complaint(o), testing::HasSubstr("nothing can be held"));
  o = options(mesh, {F, F, F, F, F, F}, 2);
  o.frame = fe::ModelReduction::Frame::mean_axis;
  o.interfaces[0].motions[0] = Motion::free;
  EXPECT_THAT(complaint(o), testing::HasSubstr("nothing holds the body"));
}

}  // namespace
}  // namespace mimbre::test::free_motions_test
