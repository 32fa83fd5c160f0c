#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "math/space_curve.h"
#include "mimbre/model_builder.h"
#include "mimbre/simulation.h"
#include "support/models.h"

/// Curves through points, and what slides along them.
namespace mimbre::test::curves_test {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;
using Formulation = spec::Simulation::Formulation;

std::vector<Vector3d> circle(int count, double radius) {
  std::vector<Vector3d> points;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * pi * k / count;
    points.emplace_back(radius * std::sin(angle), 0, -radius * std::cos(angle));
  }
  return points;
}

TEST(SpaceCurves, GoThroughTheirPointsAndAreSmooth) {
  for (const bool closed : {false, true}) {
    const std::vector<Vector3d> points{
        {0, 0, 0}, {1, 0.3, 0}, {1.5, 1, 0.4}, {0.7, 1.6, 0.1}, {-0.4, 0.8, -0.3}};
    const SpaceCurve curve = space_curve(points, closed);
    CurvePoint<double> at, before, behind;
    double s = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      curve_point(curve, s, at);
      EXPECT_LT((at.value[0] - points[k]).norm(), 1e-13) << k;
      EXPECT_NEAR(at.value[1].norm(), 1, 1e-12) << k;
      EXPECT_NEAR(at.value[1].dot(at.value[2]), 0, 1e-12) << k;
      curve_point(curve, s - 1e-9, before);
      curve_point(curve, s + 1e-9, behind);
      for (int row = 0; row < 3; ++row) {
        EXPECT_LT((behind.value[row] - before.value[row]).norm(), 2e-8) << k;
        EXPECT_LT((behind.first[row] - before.first[row]).norm(), 1e-7) << k;
      }
      EXPECT_LT((behind.second[0] - before.second[0]).norm(), 1e-7) << k;
      if (k + 1 < points.size()) s += (points[k + 1] - points[k]).norm();
    }
    // Derivatives are those of what is given, and directions stay across the curve.
    for (double x = -0.4; x < curve.length + 0.4; x += 0.0937) {
      const double h = 1e-5;
      curve_point(curve, x, at);
      curve_point(curve, x - h, before);
      curve_point(curve, x + h, behind);
      for (int row = 0; row < 3; ++row) {
        EXPECT_LT(((behind.value[row] - before.value[row]) / (2 * h) - at.first[row]).norm(), 1e-8);
        EXPECT_LT(((behind.first[row] - before.first[row]) / (2 * h) - at.second[row]).norm(), 1e-3);
      }
      const Vector3d t = at.first[0].normalized();
      const Vector3d across =
          (at.value[1] - t.dot(at.value[1]) * t).cross(at.value[2] - t.dot(at.value[2]) * t);
      EXPECT_GT(across.norm(), 0.3) << x;
    }
  }
}

/// Fourth order in the distance of the points.
TEST(SpaceCurves, OfACircleAreRound) {
  double off[2];
  for (int k = 0; k < 2; ++k) {
    const SpaceCurve curve = space_curve(circle(16 << k, 1), true);
    CurvePoint<double> at;
    off[k] = 0;
    for (double s = 0; s < curve.length; s += 0.01) {
      curve_point(curve, s, at);
      off[k] = std::max(off[k], std::abs(at.value[0].norm() - 1));
    }
  }
  EXPECT_LT(off[1], 2e-5);
  EXPECT_GT(off[0] / off[1], 12);
}

TEST(SpaceCurves, OfTwoPointsAreALine) {
  const SpaceCurve curve = space_curve({{0, 0, 0}, {0, 3, 4}}, false);
  EXPECT_NEAR(nearest_on(curve, Vector3d(1, 1.5, 2)), 2.5, 1e-12);
  EXPECT_NEAR(nearest_on(curve, Vector3d(1, 6, 8)), 10, 1e-9) << "straight beyond its end";
  EXPECT_NEAR(nearest_on(curve, Vector3d(1, -3, -4)), -5, 1e-9);
}

/// The nearest point is found from afar, by numbers and by dual numbers with its derivative.
TEST(SpaceCurves, KnowTheirNearestPoint) {
  const SpaceCurve curve = space_curve(circle(24, 1), true);
  CurvePoint<double> at;
  for (double angle = 0.3; angle < 2.8; angle += 0.2) {
    const Vector3d place(1.2 * std::sin(angle), 0.1, -1.2 * std::cos(angle));
    const double s = nearest_near<double>(curve, place, 0.0, at);
    EXPECT_NEAR(s / curve.length * 2 * pi, angle, 1e-4);
    EXPECT_NEAR((place - at.value[0]).dot(at.first[0]), 0, 1e-12);
    const Eigen::Matrix<Dual, 3, 1> moving(Dual(place[0], 0.3), Dual(place[1], 0.1), Dual(place[2], -0.2));
    CurvePoint<Dual> dual;
    const Dual found = nearest_near<Dual>(curve, moving, Dual(0), dual);
    const auto moved = [&](double h) {
      CurvePoint<double> scratch;
      return nearest_near<double>(curve, place + h * Vector3d(0.3, 0.1, -0.2), s, scratch);
    };
    EXPECT_NEAR(found.derivative, (moved(1e-5) - moved(-1e-5)) / 2e-5, 1e-8);
  }
}

class Curves : public testing::TestWithParam<Formulation> {
 protected:
  RunOptions options(double step) const {
    RunOptions o;
    o.formulation = GetParam();
    o.step = step;
    o.tolerance = 1e-9;
    return o;
  }
};
INSTANTIATE_TEST_SUITE_P(Formulations, Curves, testing::Values(Formulation::relative, Formulation::natural),
                         [](const auto& of) {
                           return of.param == Formulation::natural ? "natural" : "relative";
                         });

/// A bead without size on a curve in the plane z–x.
std::shared_ptr<const Model> bead(std::vector<Vector3d> points, bool closed, const Vector3d& start,
                                  const Vector3d& velocity = Vector3d::Zero()) {
  ModelBuilder m("bead");
  m.add_body("bead", {.mass = 0.7, .com = start, .inertia = build::inertia(1e-4, 1e-4, 1e-4)});
  m.add_joint("free", {.type = spec::JointType::floating,
                       .between = {"ground", "bead"},
                       .velocity = {velocity[0], velocity[1], velocity[2], 0, 0, 0}});
  m.add_constraint("wire", {.type = "on_curve",
                            .between = {"ground", "bead"},
                            .at = {std::nullopt, start},
                            .points = std::move(points),
                            .closed = closed});
  return m.compile();
}

double read(Simulation& s, const std::string& channel) { return s.value(s.channel(channel)); }

void run(Simulation& s, double until) {
  while (s.time() < until - 1e-12) {
    const StepReport report = s.step();
    ASSERT_TRUE(report.ok()) << s.explain(report);
  }
}

/// Huygens: along a cycloid of a rolling circle of radius r every swing takes 2π √(4 r/g), however large.
TEST_P(Curves, SwingsAlongACycloidTakeTheSameTime) {
  const double r = 0.25, g = 9.81, period = 2 * pi * std::sqrt(4 * r / g);
  std::vector<Vector3d> points;  // upside down, its lowest point in the origin
  for (int k = -60; k <= 60; ++k) {
    const double a = 2.6 * k / 60;
    points.emplace_back(r * (a + std::sin(a)), 0, r * (1 - std::cos(a)));
  }
  for (const double angle : {0.3, 1.2, 2.2}) {
    const Vector3d start(r * (angle + std::sin(angle)), 0, r * (1 - std::cos(angle)));
    Simulation s(bead(points, false, start), options(period / 800));
    run(s, period / 4);
    EXPECT_NEAR(s.pose(s.body("bead")).position[0], 0, 3e-4 * start[0]) << angle;
    run(s, period);
    EXPECT_LT((s.pose(s.body("bead")).position - start).norm(), 3e-4) << angle;
    EXPECT_NEAR(s.energy().kinetic, 0, 1e-3);
  }
}

/// Round a circle it is a pendulum, also where it goes over the top, and its force is that of the rod.
TEST_P(Curves, ABeadOnACircleIsAPendulum) {
  const double speed = 7;  // over the top: v² > 4 g
  Simulation on_curve(bead(circle(128, 1), true, {0, 0, -1}, {speed, 0, 0}), options(5e-4)),
      pendulum(model_of(fmt::format(R"(
bodies: {{bead: {{mass: 0.7, com: [0, 0, -1], inertia: [1e-12, 1e-12, 1e-12]}}}}
joints: {{hinge: {{type: revolute, between: [ground, bead], at: [0, 0, 0], axis: [0, -1, 0], velocity: {}}}}}
)",
                                    speed)),
               options(5e-4));
  for (int k = 1; k <= 20; ++k) {
    run(on_curve, 0.1 * k);
    run(pendulum, 0.1 * k);
    const Vector3d x = on_curve.pose(on_curve.body("bead")).position,
                   y = pendulum.pose(pendulum.body("bead")).position;
    EXPECT_NEAR(x.norm(), 1, 1e-6);
    EXPECT_LT((x - y).norm(), 2e-4) << k;
    EXPECT_NEAR(read(on_curve, "constraint.wire.force.x"), read(pendulum, "joint.hinge.force.x"), 0.05) << k;
    EXPECT_NEAR(read(on_curve, "constraint.wire.force.z"), read(pendulum, "joint.hinge.force.z"), 0.05) << k;
  }
}

/// Down a helix around a vertical axis at the steady acceleration g sin α, α its slope: over straight ends
/// too.
TEST_P(Curves, DownAHelixItGainsWhatItsSlopeSays) {
  const double radius = 0.5, slope = 0.2;
  std::vector<Vector3d> points;
  for (int k = 0; k <= 240; ++k) {
    const double a = 4 * pi * k / 240;
    points.emplace_back(radius * std::cos(a), radius * std::sin(a), -radius * slope * a);
  }
  Simulation s(bead(points, false, points[12]), options(1e-3));
  const double gravity = 9.81 * slope / std::sqrt(1 + slope * slope), time = 1.2;
  run(s, time);
  const double way = gravity * time * time / 2;
  const double fallen = points[12][2] - s.pose(s.body("bead")).position[2];
  EXPECT_NEAR(fallen, way * slope / std::sqrt(1 + slope * slope), 2e-4);
}

/// Over the end of an open curve it goes straight on.
TEST_P(Curves, GoOnStraightBeyondTheirEnds) {
  Simulation s(bead({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, false, {0.5, 0, 0}, {3, 0, 0}), options(0.01));
  run(s, 2);
  EXPECT_NEAR(s.pose(s.body("bead")).position[0], 6.5, 1e-9);
  EXPECT_NEAR(s.pose(s.body("bead")).position[2], 0, 1e-9);
}

/// A cam lifts a follower: its profile turns with it.
TEST_P(Curves, TurnWithTheirBody) {
  ModelBuilder m("cam");
  m.add_body("cam", {.mass = 1, .com = {0, 0, 0}, .inertia = build::inertia(0.01, 0.01, 0.01)});
  m.add_body("follower", {.mass = 0.2, .com = {0, 0, 0.5}, .inertia = build::inertia(0.001, 0.001, 0.001)});
  m.add_joint("shaft", {.type = spec::JointType::revolute,
                        .between = {"ground", "cam"},
                        .at = Vector3d{0, 0, 0},
                        .axis = Vector3d{0, 1, 0},
                        .drives = {{0, Function::polynomial({0, 4})}}});
  m.add_joint("guide", {.type = spec::JointType::prismatic,
                        .between = {"ground", "follower"},
                        .at = Vector3d{0, 0, 0.5},
                        .axis = Vector3d{0, 0, 1}});
  // A circle of radius 0.5 around a point 0.1 beside the shaft; the plane of the cam holds the follower
  // twice.
  std::vector<Vector3d> points = circle(96, 0.5);
  for (Vector3d& p : points) p[0] += 0.1;
  m.add_constraint("profile", {.type = "on_curve",
                               .between = {"cam", "follower"},
                               .at = {Vector3d(0, 0, 0), Vector3d(0, 0, 0.5)},
                               .points = std::move(points),
                               .closed = true});
  Simulation s(m.compile(), options(2e-3));
  for (int k = 1; k <= 20; ++k) {
    run(s, 0.08 * k);
    // The middle of the circle at (e cos φ, −e sin φ), above the shaft: z = −e sin φ + √(R² − e² cos² φ).
    const double angle = 4 * s.time(), e = 0.1;
    const double lift = -e * std::sin(angle) + std::sqrt(0.25 - std::pow(e * std::cos(angle), 2));
    EXPECT_NEAR(s.pose(s.body("follower")).position[2], lift, 1e-6) << k;
  }
}

/// What the curve remembers belongs to the state.
TEST_P(Curves, RememberTheirPlaceInTheState) {
  const auto model = bead(circle(64, 1), true, {0, 0, -1}, {7, 0, 0});
  Simulation s(model, options(1e-3)), other(model, options(1e-3));
  run(s, 0.7);
  other.restore(Simulation::Snapshot::from_bytes(s.save().bytes()));
  for (int k = 0; k < 50; ++k) {
    ASSERT_TRUE(s.step().ok());
    ASSERT_TRUE(other.step().ok());
    EXPECT_EQ(s.pose(s.body("bead")).position, other.pose(other.body("bead")).position);
  }
}

}  // namespace
}  // namespace mimbre::test::curves_test
