#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "analysis/modes/body_shapes.h"
#include "math/rotation.h"
#include "simulation/observe/channels.h"
#include "support/models.h"
#include "support/probe.h"

/// Modes by body: against differences of positions, and circles of rotors.
namespace mimbre::test::mode_shapes_test {
namespace {

using Eigen::VectorXcd;

/// A turn as a rotation vector, of a small one.
Vec3d turn_between(const Eigen::Vector4d& from, const Eigen::Vector4d& to) {
  const Mat3d R = rotation_matrix<double>(to) * rotation_matrix<double>(from).transpose();
  return 0.5 * Vec3d(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
}

class BodyShapesOf : public testing::TestWithParam<unsigned> {
 protected:
  void SetUp() override {
    RandomOptions options;
    options.bodies = 2 + static_cast<int>(GetParam() % 5);
    options.flexible_share = 0.25 * (GetParam() % 4);
    options.loops = static_cast<int>(GetParam() % 3);
    options.drives = GetParam() % 2 == 0;
    mechanism = random_mechanism(GetParam(), options);
    Random random(GetParam() + 77);
    Probe probe(mechanism.compiled());
    at.model = mechanism.model;
    at.state.q = probe.moved(mechanism.q, random_increment(probe.m, random, 0.5));
    at.state.v = at.state.a = VectorXd::Zero(probe.n);
    at.state.u = at.state.z = VectorXd::Zero(1000);
    mode.motion.resize(probe.n);
    mode.motion.real() = random_increment(probe.m, random, 0.5);
    mode.motion.imag() = random_increment(probe.m, random, 0.5);
    shapes = linear::body_shapes(at, {mode});
  }

  /// Where the coordinates lead that have gone along the mode.
  ResultsRow retracted(double factor, double phase) {
    Probe probe(mechanism.compiled());
    const VectorXd x = (std::polar(factor, phase) * mode.motion).real();
    State moved = at.state;
    moved.q = probe.moved(at.state.q, x);
    probe.kinematics(moved.q, probe.zero, probe.zero);
    ResultsRow row;
    Channels(mechanism.compiled()).picture(probe.system, moved, row);
    return row;
  }

  RandomMechanism mechanism;
  linear::Linearised at;
  Mode mode;
  MechanismShapes shapes;
};

TEST_P(BodyShapesOf, AreDifferencesOfPositionsAlongTheCoordinates) {
  constexpr double h = 1e-5;
  const BodyShapes& shape = shapes.modes.front();
  for (const double phase : {0., 1.2, std::numbers::pi / 2}) {
    const ResultsRow ahead = retracted(h, phase), behind = retracted(-h, phase);
    const std::complex<double> turned = std::polar(1., phase);
    for (Eigen::Index b = 0; b < shapes.at.poses.cols(); ++b) {
      const Vec3d moved = (ahead.poses.col(b).head<3>() - behind.poses.col(b).head<3>()) / (2 * h),
                  turn = turn_between(behind.poses.col(b).tail<4>(), ahead.poses.col(b).tail<4>()) / (2 * h);
      EXPECT_LT((moved - (turned * shape.displacement.col(b)).real()).norm(), 1e-7) << b;
      EXPECT_LT((turn - (turned * shape.turn.col(b)).real()).norm(), 1e-7) << b;
    }
    const VectorXd bent = (ahead.modes - behind.modes) / (2 * h);
    EXPECT_LT((bent - (turned * shape.amplitudes).real()).norm(), 1e-7 * (1 + bent.norm()));
  }
}

TEST_P(BodyShapesOf, MoveBodiesAlongTheMechanismToTheSecondOrder) {
  const auto distance = [&](double factor) {
    const ResultsRow is = moved_by_mode(shapes, 0, factor, 0.7), wanted = retracted(factor, 0.7);
    double most = (is.modes - wanted.modes).norm();
    for (Eigen::Index b = 0; b < is.poses.cols(); ++b)
      most = std::max({most, (is.poses.col(b) - wanted.poses.col(b)).head<3>().norm(),
                       turn_between(is.poses.col(b).tail<4>(), wanted.poses.col(b).tail<4>()).norm()});
    return most;
  };
  const double far = distance(2e-2), near = distance(1e-2);
  EXPECT_LT(near, 0.3 * far + 1e-12);
  EXPECT_LT(far, 0.01);
}

TEST_P(BodyShapesOf, ReachIsTheLargestDisplacementOfADrawnPoint) {
  const BodyShapes& shape = shapes.modes.front();
  double most = 0, turn = 0;
  for (int k = 0; k < 180; ++k) {
    const std::complex<double> turned = std::polar(1., k * std::numbers::pi / 180);
    Eigen::Index first = 0;
    for (std::size_t b = 0; b < shapes.header.bodies.size(); ++b) {
      const BodyDrawing& body = shapes.header.bodies[b];
      const auto pose = shapes.at.poses.col(static_cast<Eigen::Index>(b));
      const Mat3d R = rotation_matrix<double>(pose.tail<4>());
      const Vec3d d = (turned * shape.displacement.col(static_cast<Eigen::Index>(b))).real(),
                  omega = (turned * shape.turn.col(static_cast<Eigen::Index>(b))).real();
      const VectorXd y = shapes.at.modes.segment(first, body.modes),
                     rate = (turned * shape.amplitudes.segment(first, body.modes)).real();
      first += body.modes;
      turn = std::max(turn, omega.norm());
      for (const FrameDrawing& frame : shapes.header.frames) {
        if (frame.body != static_cast<int>(b)) continue;
        const MatrixXd X = body.modes > 0 ? MatrixXd(frame.motion.topRows<3>()) : MatrixXd::Zero(3, 0);
        const Vec3d lever = R * (frame.pose.position + X * y);
        most = std::max(most, (d + omega.cross(lever) + R * X * rate).norm());
      }
    }
  }
  EXPECT_NEAR(shape.largest_turn, turn, 1e-3 * turn);
  EXPECT_GE(shape.reach, most * (1 - 1e-3) - 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Random, BodyShapesOf, testing::Range(0u, 24u));

LinearisedModes with_shapes(const std::shared_ptr<const Model>& model, LinearPoint::At at, int most = 0) {
  ModesOptions options;
  options.linear.point.at = at;
  options.most = most;
  options.shapes = true;
  return find_modes(model, options);
}

/// Twice the area that a place goes round in a period about the axis: the sense in which it goes.
double circulation(const Eigen::Vector3cd& x, const Vec3d& axis) {
  // The phase grows: Re x comes first, then −Im x.
  return axis.dot(Vec3d(x.real()).cross(Vec3d(-x.imag())));
}

TEST(MechanismShapes, WhirlInTheSenseThatTheGroundSees) {
  const LinearisedModes found = with_shapes(example("rotor/two-discs.yaml"), LinearPoint::At::steady);
  ASSERT_TRUE(found.shapes);
  ASSERT_EQ(found.shapes->modes.size(), found.modes.size());
  ASSERT_GT(found.turning, 0);
  int seen = 0;
  for (std::size_t k = 0; k < found.modes.size(); ++k) {
    const Mode& mode = found.modes[k];
    if (std::abs(mode.whirl) < 0.99) continue;
    double area = 0;
    for (const auto& x : found.shapes->modes[k].displacement.colwise())
      area += circulation(x, found.shapes->axis);
    // In axes that turn with Ω the angle grows by ± Im λ; the ground adds Ω.
    const double rate = (area > 0 ? 1 : -1) * mode.value.imag() + found.turning;
    EXPECT_NEAR(rate, mode.whirl * mode.fixed.imag(), 1e-6 * std::abs(rate)) << mode.text;
    ++seen;
  }
  EXPECT_GE(seen, 6);
}

TEST(MechanismShapes, OfTheSparseSolverAreThoseOfTheDenseOne) {
  std::string links;
  std::string joints = "  pin0: {type: revolute, between: [ground, link0], at: [0, 0, 0], axis: [0, 1, 0]}\n";
  for (int k = 0; k < 12; ++k) {
    links += "  link" + std::to_string(k) + ": {mass: 1, com: [0, 0, " + std::to_string(-k - 0.5) +
             "], inertia: [0.08, 0.08, 0.001]}\n";
    if (k > 0)
      joints += "  pin" + std::to_string(k) + ": {type: revolute, between: [link" + std::to_string(k - 1) +
                ", link" + std::to_string(k) + "], at: [0, 0, " + std::to_string(-k) +
                "], axis: [0, 1, 0]}\n";
  }
  const auto model = model_of("gravity: [0, 0, -9.81]\nbodies:\n" + links + "joints:\n" + joints);
  ModesOptions options;
  options.most = 4;
  options.shapes = true;
  options.solver = ModesSolver::dense;
  const LinearisedModes dense = find_modes(model, options);
  options.solver = ModesSolver::sparse;
  const LinearisedModes sparse = find_modes(model, options);
  ASSERT_TRUE(sparse.sparse && sparse.shapes && dense.shapes);
  EXPECT_NEAR(dense.shapes->size, 12, 1);
  EXPECT_NEAR(sparse.shapes->size, dense.shapes->size, 1e-9);
  for (std::size_t k = 0; k < 4; ++k) {
    const BodyShapes &a = dense.shapes->modes[k], &b = sparse.shapes->modes[k];
    EXPECT_LT((a.displacement - b.displacement).norm(), 1e-6 * a.displacement.norm());
    EXPECT_LT((a.turn - b.turn).norm(), 1e-6 * a.turn.norm());
    // Either the largest displacement or the largest turn is what it may be.
    const double factor = drawing_factor(*dense.shapes, static_cast<int>(k), 0.05);
    EXPECT_NEAR(std::max(factor * a.reach / dense.shapes->size, factor * a.largest_turn / 6), 0.05, 1e-12);
  }
}

/// A body far from the origin of its axes turns about its hinge, and not about that origin.
TEST(MechanismShapes, BodiesTurnAboutTheirHinges) {
  const LinearisedModes found = with_shapes(model_of(R"yaml(
gravity: [0, 0, -9.81]
bodies: {bob: {frame: {at: [0, 0, 0]}, mass: 1, com: [100, 0, -1], inertia: [0.1, 0.1, 0.1]}}
joints: {pin: {type: revolute, between: [ground, bob], at: [100, 0, 0], axis: [0, 1, 0]}}
)yaml"),
                                            LinearPoint::At::equilibrium);
  ASSERT_EQ(found.modes.size(), 1u);
  EXPECT_LT(found.shapes->at.poses.col(0).head<3>().norm(), 1e-12);
  const ResultsRow moved = moved_by_mode(*found.shapes, 0, 0.5, 0);
  EXPECT_GT(moved.poses.col(0).head<3>().norm(), 40);
  const Vec3d hinge =
      moved.poses.col(0).head<3>() + rotation_matrix<double>(moved.poses.col(0).tail<4>()) * Vec3d(100, 0, 0);
  EXPECT_LT((hinge - Vec3d(100, 0, 0)).norm(), 1e-12);
}

TEST(MechanismShapes, OfABodyWithoutAnyDrawing) {
  const LinearisedModes found = with_shapes(model_of(R"yaml(
gravity: [0, 0, 0]
bodies: {free: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {fly: {type: floating, between: [ground, free], at: [0, 0, 0]}}
)yaml"),
                                            LinearPoint::At::equilibrium);
  ASSERT_EQ(found.modes.size(), 6u);
  for (int k = 0; k < 6; ++k) {
    const double factor = drawing_factor(*found.shapes, k);
    EXPECT_TRUE(std::isfinite(factor));
    EXPECT_TRUE(moved_by_mode(*found.shapes, k, factor, 1).poses.allFinite());
  }
}

TEST(MechanismShapes, AreNotThereUnlessAskedFor) {
  EXPECT_FALSE(find_modes(example("double-wishbone/model.yaml")).shapes);
}

}  // namespace
}  // namespace mimbre::test::mode_shapes_test
