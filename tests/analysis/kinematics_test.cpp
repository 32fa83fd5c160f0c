#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mimbre/kinematics.h"
#include "support/models.h"

/// Motions of drives alone against closed forms, and their singular positions.
namespace mimbre::test::kinematics_test {
namespace {

using std::numbers::pi;
using Kind = SpecialPosition::Kind;

constexpr double crank = 0.1, rod = 0.3;

/// The slider moves along x; the crank is drawn along x as well, its angle about y against the usual sense.
std::string slider_crank(const std::string& on_crank, const std::string& on_slider, double mass = 0) {
  return fmt::format(R"(
bodies:
  crank: {{mass: {0}, com: [0.05, 0, 0], inertia: [{0}, {0}, {0}]}}
  rod: {{mass: {0}, com: [0.2, 0, 0], inertia: [{0}, {0}, {0}]}}
  slider: {{mass: {0}, com: [0.4, 0, 0], inertia: [{0}, {0}, {0}]}}
joints:
  crank: {{type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, -1, 0]{1}}}
  pin: {{type: revolute, between: [crank, rod], at: [0.1, 0, 0], axis: [0, -1, 0]}}
  slide: {{type: prismatic, between: [ground, slider], at: [0.4, 0, 0], axis: [1, 0, 0]{2}}}
  wrist: {{type: revolute, between: [rod, slider], at: [0.4, 0, 0], axis: [0, -1, 0], cut: always}}
simulation: {{end: 1}}
)",
                     mass, on_crank, on_slider);
}

double slide(double angle) {
  return crank * std::cos(angle) + std::sqrt(rod * rod - std::pow(crank * std::sin(angle), 2)) - crank - rod;
}

Eigen::Index column(const Kinematics& k, const std::string& name) {
  const auto at = std::find(k.names.begin(), k.names.end(), name);
  EXPECT_NE(at, k.names.end()) << name;
  return at - k.names.begin();
}

TEST(Kinematics, ACrankMovesItsSliderAndTurnsItBackAtTheDeadCentres) {
  KinematicsOptions o;
  o.steps = 100;
  const Kinematics k = kinematics(model_of(slider_crank(", drive: {position: 7*t + 0.5}", "")), o);
  EXPECT_TRUE(k.complete);
  EXPECT_EQ(k.mobility, 1);
  EXPECT_EQ(k.free, 0);
  EXPECT_EQ(k.redundant, 3);
  const Eigen::Index x = column(k, "slide");
  for (Eigen::Index i = 0; i < k.time.size(); ++i) {
    const double angle = 7 * k.time[i] + 0.5, d = 1e-4;
    EXPECT_NEAR(k.position(i, x), slide(angle), 1e-11);
    EXPECT_NEAR(k.velocity(i, x), 7 * (slide(angle + d) - slide(angle - d)) / (2 * d), 1e-7);
    EXPECT_NEAR(k.acceleration(i, x), 49 * (slide(angle + d) - 2 * slide(angle) + slide(angle - d)) / (d * d),
                1e-5);
  }
  std::vector<double> turns;
  for (const SpecialPosition& s : k.special)
    if (s.kind == Kind::reversal && s.joint == "slide") turns.push_back(7 * s.time + 0.5);
  ASSERT_EQ(turns.size(), 2u);
  EXPECT_NEAR(turns[0], pi, 1e-8);
  EXPECT_NEAR(turns[1], 2 * pi, 1e-8);
}

TEST(Kinematics, ASliderThatPushesTooFarIsNamedWithItsLimit) {
  KinematicsOptions o;
  o.steps = 50;
  const Kinematics k = kinematics(
      model_of(slider_crank(", near: 0.6", fmt::format(", drive: {{position: {} + 0.05*t}}", slide(0.6)))),
      o);
  EXPECT_FALSE(k.complete);
  ASSERT_FALSE(k.special.empty());
  const SpecialPosition& end = k.special.back();
  EXPECT_EQ(end.kind, Kind::limit);
  EXPECT_EQ(end.joint, "slide");
  EXPECT_NEAR(end.position, 0, 1e-9);
  EXPECT_THAT(end.text, testing::HasSubstr("the drive of 'slide' cannot go beyond"));
}

TEST(Kinematics, AParallelogramPassesItsChangePoint) {
  KinematicsOptions o;
  o.steps = 41;
  const Kinematics k = kinematics(model_of(R"(
bodies:
  left: {mass: 1, com: [0, 0, 0.1], inertia: [1, 1, 1]}
  bar: {mass: 1, com: [0.2, 0, 0.2], inertia: [1, 1, 1]}
  right: {mass: 1, com: [0.4, 0, 0.1], inertia: [1, 1, 1]}
joints:
  a: {type: revolute, between: [ground, left], at: [0, 0, 0], axis: [0, 1, 0], drive: {position: 3*t}}
  b: {type: revolute, between: [left, bar], at: [0, 0, 0.2], axis: [0, 1, 0]}
  c: {type: revolute, between: [bar, right], at: [0.4, 0, 0.2], axis: [0, 1, 0]}
  d: {type: revolute, between: [ground, right], at: [0.4, 0, 0], axis: [0, 1, 0], cut: always}
simulation: {end: 1}
)"),
                                  o);
  EXPECT_TRUE(k.complete);
  ASSERT_EQ(k.special.size(), 1u);
  EXPECT_EQ(k.special[0].kind, Kind::change_point);
  EXPECT_NEAR(3 * k.special[0].time, pi / 2, 1e-6);
  // It stays a parallelogram: the bar does not turn.
  const Eigen::Index b = column(k, "b");
  EXPECT_NEAR(k.position(k.time.size() - 1, b), -3, 1e-9);
}

TEST(Kinematics, NamesWhatNoDriveMoves) {
  const Kinematics k = kinematics(model_of(R"(
bodies:
  one: {mass: 1, com: [0.5, 0, 0], inertia: [1, 1, 1]}
  two: {mass: 1, com: [1.5, 0, 0], inertia: [1, 1, 1]}
joints:
  first: {type: revolute, between: [ground, one], at: [0, 0, 0], axis: [0, 1, 0], drive: {position: t}}
  second: {type: revolute, between: [one, two], at: [1, 0, 0], axis: [0, 1, 0]}
)"));
  EXPECT_EQ(k.mobility, 2);
  EXPECT_EQ(k.free, 1);
  EXPECT_EQ(k.free_joints, std::vector<std::string>{"second"});
  EXPECT_EQ(k.warnings.size(), 1u);
}

/// 100 rad on a screw of 5 mm.
TEST(Kinematics, ScrewsCountTheirTurns) {
  KinematicsOptions o;
  o.end = 5;
  const Kinematics k = kinematics(model_of(R"(
bodies: {nut: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {p: {type: cylindrical, between: [ground, nut], at: [0, 0, 0], axis: [0, 0, 1], drive: {coordinate: 0, speed: '20'}}}
constraints: {s: {type: screw, between: [ground, nut], at: [0, 0, 0], axis: [0, 0, 1], lead: 5 mm}}
)"),
                                  o);
  ASSERT_TRUE(k.complete);
  const Eigen::Index turn = column(k, "p.0"), along = column(k, "p.1");
  for (Eigen::Index i = 0; i < k.time.size(); ++i)
    EXPECT_NEAR(k.position(i, along), k.position(i, turn) * 0.005 / (2 * pi), 1e-11);
  EXPECT_NEAR(k.position(k.time.size() - 1, turn), 100, 1e-9);
}

/// A parallelogram whose third quarter of a turn and a half lies on an instant, or does not: flat there, it
/// could fold, and goes on as it came.
TEST(Kinematics, AnInstantAtAChangePointKeepsTheBranch) {
  for (const int steps : {8, 40, 200, 201, 400, 1000}) {
    KinematicsOptions o;
    o.end = 1;
    o.steps = steps;
    const Kinematics k = kinematics(model_of(R"(
bodies:
  c: {mass: 1, com: [0.1, 0, 0.1], inertia: [0.01, 0.01, 0.01]}
  k: {mass: 1, com: [0.7, 0, 0.2], inertia: [0.01, 0.01, 0.01]}
  f: {mass: 1, com: [1.1, 0, 0.1], inertia: [0.01, 0.01, 0.01]}
joints:
  p1: {type: revolute, between: [ground, c], at: [0, 0, 0], axis: [0, -1, 0], drive: {position: 2*pi*t}}
  p2: {type: revolute, between: [c, k], at: [0.2, 0, 0.2], axis: [0, -1, 0]}
  p3: {type: revolute, between: [k, f], at: [1.2, 0, 0.2], axis: [0, -1, 0]}
  p4: {type: revolute, between: [ground, f], at: [1, 0, 0], axis: [0, -1, 0]}
)"),
                                    o);
    const Eigen::Index driven = column(k, "p1"), other = column(k, "p4");
    for (Eigen::Index i = 0; i < k.time.size(); ++i) {
      EXPECT_NEAR(k.position(i, other), k.position(i, driven), 1e-6) << steps << ' ' << k.time[i];
      EXPECT_NEAR(k.velocity(i, other), 2 * pi, 1e-4) << steps << ' ' << k.time[i];
    }
  }
}

}  // namespace
}  // namespace mimbre::test::kinematics_test
