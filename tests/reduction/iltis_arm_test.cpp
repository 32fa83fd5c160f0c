#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "fe/meshes.h"
#include "mimbre/beam_reduction.h"

// The A-arm of the Bombardier Iltis benchmark (Frik, Leister, Schwartz 1993; sections as in the example
// model).
namespace mimbre::test::iltis_arm_test {
namespace {

/// Body axes at the axis centre: x as the chassis, y along the arm, z normal to it.
struct Arm {
  fe::Mesh mesh;
  fe::ReductionOptions options;
  std::vector<fe::NodeFrame> frames;
  Eigen::Vector3d ball;
  double bar_length = 0;
};

constexpr int kFrontPivot = 0, kRearPivot = 1, kBall = 2;

Arm iltis_arm(int elements) {
  const Eigen::Vector3d centre(0.970, 0.259, -0.268);
  const Eigen::Vector3d ball(0.970, 0.572066, -0.340982);
  const Eigen::Vector3d shock(1.045, 0.500065, -0.328989);
  Eigen::Matrix3d axes;  // rows: body axes in chassis axes
  axes.row(0) = Eigen::RowVector3d::UnitX();
  axes.row(1) = (ball - centre).normalized().transpose();
  axes.row(2) = axes.row(0).cross(axes.row(1));

  Arm arm;
  arm.ball = axes * (ball - centre);
  arm.mesh = with_nodes({{0.108, 0, 0}, {-0.108, 0, 0}, arm.ball});
  add_bar(arm.mesh, kFrontPivot, kBall, elements, round_bar(0.0379));
  add_bar(arm.mesh, kRearPivot, kBall, elements, round_bar(0.0379));
  arm.bar_length = (arm.mesh.nodes.col(kFrontPivot) - arm.ball).norm();

  // The node at 0.8 of the front bar moves to the shock absorber's end; its elements stay where they are.
  const int joined = 4 * elements / 5 - 1;  // the element that ends there
  const int node = arm.mesh.elements[joined].nodes[1];
  const Eigen::Vector3d end = axes * (shock - centre);
  const Eigen::Vector3d offset = arm.mesh.nodes.col(node) - end;
  arm.mesh.nodes.col(node) = end;
  arm.mesh.elements[joined].offsets[1] = offset;
  arm.mesh.elements[joined + 1].offsets[0] = offset;

  arm.options.clamped_nodes = {kFrontPivot, kRearPivot};
  arm.options.boundary = {{kBall, false, Eigen::Vector3d::UnitZ(), "ball.n"},
                          {node, false, Eigen::Vector3d::UnitZ(), "shock.n"}};
  arm.options.dynamic_modes = 2;
  arm.options.stiffness_damping = 0.01;
  arm.frames = {{"ball", kBall, Eigen::Matrix3d::Identity()}, {"shock", node, Eigen::Matrix3d::Identity()}};
  return arm;
}

Eigen::Matrix3d central_inertia(const ReducedBody& body) {
  const Eigen::Vector3d centre = body.first_moment / body.mass;
  const Eigen::Matrix3d P = body.second_moment - body.mass * centre * centre.transpose();
  return P.trace() * Eigen::Matrix3d::Identity() - P;
}

TEST(IltisArm, HasFourModesAndTheMassAndCentreOfTheBenchmark) {
  const Arm arm = iltis_arm(10);
  const ReducedBody body = fe::reduce(arm.mesh, arm.options, arm.frames);
  EXPECT_THAT(check(body), testing::IsEmpty());
  EXPECT_EQ(body.modes, 4);
  EXPECT_NEAR(body.mass / 6.0, 1, 0.01);
  EXPECT_LT((body.first_moment / body.mass - arm.ball / 2).norm(), 1e-6);
}

TEST(IltisArm, HasTheInertiaOfItsBars) {
  // Two slender bars in the arm's plane, and the polar inertia of their sections along them.
  const Arm arm = iltis_arm(10);
  const double m = 7850 * round_bar(0.0379).area * arm.bar_length;
  const double y2 = 2 * m * arm.ball.y() * arm.ball.y() / 12;
  const double x2 = 2 * m * 0.108 * 0.108 / 3;
  const double polar = 2 * m * 0.0379 * 0.0379 / 8;
  const double along_x = std::pow(0.108 / arm.bar_length, 2);
  const Eigen::Matrix3d inertia = central_inertia(fe::reduce(arm.mesh, arm.options, arm.frames));
  const Eigen::Vector3d expected(y2 + polar * along_x, x2 + polar * (1 - along_x), x2 + y2);
  EXPECT_LT((inertia.diagonal() - expected).norm(), 1e-9);

  // The published 0.052099, 0.023235, 0.068864. The first agrees; the second does but for the sections' polar
  // inertia. The third cannot: of a plane body it is the sum of the others, 0.0753, and the published arm is
  // none.
  EXPECT_NEAR(inertia(0, 0) / 0.052099, 1, 0.01);
  EXPECT_NEAR((inertia(1, 1) - polar * (1 - along_x)) / 0.023235, 1, 0.01);
  EXPECT_NEAR(inertia(2, 2) / (0.052099 + 0.023235), 1, 0.01);
}

TEST(IltisArm, DeflectionsAreTheStaticAmplitudesAtBallAndShockAbsorber) {
  const Arm arm = iltis_arm(10);
  const ReducedBody body = fe::reduce(arm.mesh, arm.options, arm.frames);
  EXPECT_LT((body.frames[0].X.row(2) - body.user_from_modal.row(0)).norm(), 1e-9);
  EXPECT_LT((body.frames[1].X.row(2) - body.user_from_modal.row(1)).norm(), 1e-9);
}

TEST(IltisArm, FineMeshHasTheFrequenciesOfACoarseOne) {
  const Arm arm = iltis_arm(100);
  const ReducedBody coarse = [] {
    const Arm few = iltis_arm(20);
    return fe::reduce(few.mesh, few.options, few.frames);
  }();
  const ReducedBody body = fe::reduce(arm.mesh, arm.options, arm.frames);
  EXPECT_LT((body.eigenfrequencies - coarse.eigenfrequencies).norm(), 1e-4 * coarse.eigenfrequencies.norm());
}

}  // namespace
}  // namespace mimbre::test::iltis_arm_test
