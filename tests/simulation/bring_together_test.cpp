#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "mimbre/assembly.h"
#include "mimbre/model_builder.h"
#include "support/models.h"
#include "support/simulate.h"

/// Bodies drawn apart: lengths alone decide where they come to lie.
namespace mimbre::bring_together_test {
namespace {

using namespace test;
using spec::JointType;

spec::Model parsed(const std::string& text) {
  return parse_model("mimbre: 1\ntitle: test\n" + text, "test.yaml", ".");
}
std::shared_ptr<const Model> together(const std::string& text) {
  return Model::compile(brought_together(parsed(text)));
}

constexpr double crank = 0.2, coupler = 0.6, rocker = 0.5, base = 0.55;

/// A four-bar of bars that each lie along x from their own origin.
std::string four_bar(double angle, const std::string& at_rocker = "", double coupler_length = coupler) {
  return fmt::format(R"y(
gravity: [0, -9.81, 0]
bodies:
  crank: {{mass: 0.5, com: [0.1, 0, 0], inertia: [1e-4, 2e-3, 2e-3]}}
  coupler: {{mass: 0.8, com: [{1}, 0, 0], inertia: [1e-3, 0.05, 0.05]}}
  rocker: {{mass: 1, com: [{2}, 0, 0], inertia: [1e-3, 0.02, 0.02]}}
frames:
  base: {{body: ground, at: [0, 0, 0]}}
joints:
  crank: {{type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 0, 1], position: {0}}}
  crank_pin: {{type: revolute, between: [crank, coupler], at: [[{3}, 0, 0], [0, 0, 0]], axis: [0, 0, 1]}}
  rocker: {{type: revolute, between: [ground, rocker], at: [[{4}, 0, 0], [0, 0, 0]], axis: [0, 0, 1]{5}}}
  rocker_pin: {{type: revolute, between: [coupler, rocker], at: [[{6}, 0, 0], [{7}, 0, 0]], axis: [0, 0, 1]}}
outputs:
  - {{name: angle, joint: rocker}}
  - {{name: x, position: rocker_pin.b, component: x}}
  - {{name: y, position: rocker_pin.b, component: y}}
  - {{name: moved, displacement: rocker_pin.b, relative_to: base, component: y}}
)y",
                     angle, coupler / 2, rocker / 2, crank, base, at_rocker, coupler_length, rocker);
}

/// Angles of the rocker in both circuits: where the circles about crank pin and rocker's bearing meet.
std::array<double, 2> rocker_angles(double angle) {
  const double dx = base - crank * std::cos(angle), dy = -crank * std::sin(angle), d = std::hypot(dx, dy);
  const double at_bearing = std::acos((d * d + rocker * rocker - coupler * coupler) / (2 * d * rocker));
  const double towards_pin = std::atan2(-dy, -dx);
  return {std::remainder(towards_pin - at_bearing, 2 * std::numbers::pi),
          std::remainder(towards_pin + at_bearing, 2 * std::numbers::pi)};
}

class BringTogether : public testing::TestWithParam<Formulation> {};

TEST_P(BringTogether, AFourBarOfLengthsClosesInTheCircuitThatIsAskedFor) {
  for (const double angle : {-2.6, -1.1, 0.3, 1.5, 2.9})
    for (const double wanted : rocker_angles(angle)) {
      // A guess that is off by half a radian.
      Simulation s =
          simulation_of(together(four_bar(angle, fmt::format(", near: {}", wanted + 0.5))), GetParam());
      EXPECT_NEAR(channel(s, "angle"), wanted, 1e-9);
      EXPECT_NEAR(channel(s, "x"), base + rocker * std::cos(wanted), 1e-9);
      EXPECT_NEAR(channel(s, "y"), rocker * std::sin(wanted), 1e-9);
      EXPECT_NEAR(channel(s, "moved"), 0, 1e-9) << "the assembled position is the one that was found";
      EXPECT_THAT(s.warnings(), testing::IsEmpty());
    }
}

INSTANTIATE_TEST_SUITE_P(Both, BringTogether, testing::Values(Formulation::relative, Formulation::natural),
                         [](const auto& p) {
                           return p.param == Formulation::relative ? "relative" : "natural";
                         });

TEST(BringTogetherModel, BothCircuitsAreListed) {
  const auto choices = assembly_choices(*together(four_bar(0.8)));
  ASSERT_EQ(choices.size(), 1u);
  const AssemblyChoice& c = choices[0];
  ASSERT_EQ(c.ways.size(), 2u);
  const auto wanted = rocker_angles(0.8);
  for (std::size_t k = 0; k < c.coordinates.size(); ++k)
    if (c.coordinates[k].joint == "rocker") {
      EXPECT_NEAR(std::min(c.ways[0][k], c.ways[1][k]), std::min(wanted[0], wanted[1]), 1e-7);
      EXPECT_NEAR(std::max(c.ways[0][k], c.ways[1][k]), std::max(wanted[0], wanted[1]), 1e-7);
    }
}

/// Two dyads behind each other, and one beside: loops that share nothing are choices of their own.
TEST(BringTogetherModel, IndependentLoopsAreIndependentChoices) {
  std::string text = four_bar(0.8);
  const auto insert = [&](const std::string& section, const std::string& lines) {
    text.insert(text.find(section) + section.size() + 1, lines);
  };
  insert("joints:", R"y(
  second: {type: revolute, between: [ground, arm], at: [[2, 0, 0], [0, 0, 0]], axis: [0, 0, 1], position: 1.2}
  elbow: {type: revolute, between: [arm, link], at: [[0.3, 0, 0], [0, 0, 0]], axis: [0, 0, 1]}
  slide: {type: prismatic, between: [ground, block], at: [[2, 0, 0], [0, 0, 0]], axis: [1, 0, 0]}
  wrist: {type: revolute, between: [link, block], at: [[0.7, 0, 0], [0, 0, 0]], axis: [0, 0, 1]}
)y");
  insert("bodies:", R"y(
  arm: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
  link: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
  block: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
)y");
  const auto choices = assembly_choices(*together(text));
  ASSERT_EQ(choices.size(), 2u);
  for (const AssemblyChoice& c : choices) EXPECT_EQ(c.ways.size(), 2u) << c.loops.front();
  // The slider of a crank of 0.3 and a rod of 0.7.
  for (const AssemblyChoice& c : choices)
    for (std::size_t k = 0; k < c.coordinates.size(); ++k)
      if (c.coordinates[k].joint == "slide") {
        const double half = std::sqrt(0.49 - std::pow(0.3 * std::sin(1.2), 2));
        for (const auto& way : c.ways) EXPECT_NEAR(std::abs(way[k] - 0.3 * std::cos(1.2)), half, 1e-8);
      }
}

TEST(BringTogetherModel, LengthsThatDoNotFitAreAnError) {
  // The crank pin is at least base − crank from the rocker's bearing.
  const auto model = together(four_bar(0.0, "", 1.4));
  try {
    Simulation simulation(model, {});
    FAIL();
  } catch (const InputError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("cannot be closed"), std::string::npos) << what;
    EXPECT_NE(what.find("test.yaml:"), std::string::npos) << what;
  }
}

/// Spatial loops of revolute, universal and spherical joints, taken apart and turned anyhow, close again with
/// axes the right way round.
TEST(BringTogetherModel, SpatialLoopsTakenApartCloseAgain) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&] { return Eigen::Vector3d(uniform(random), uniform(random), uniform(random)); };
  int closed = 0;
  for (int trial = 0; trial < 40; ++trial) {
    // Where they belong: ground, five links, ground.
    const int links = 4;
    std::vector<Eigen::Vector3d> points, axes;
    for (int k = 0; k <= links; ++k) points.push_back(vector()), axes.push_back(vector().normalized());
    ModelBuilder b;
    std::vector<Eigen::Isometry3d> drawn{Eigen::Isometry3d::Identity()};
    std::vector<std::string> names{"ground"};
    for (int k = 0; k < links; ++k) {
      Eigen::Isometry3d moved = Eigen::Isometry3d::Identity();
      moved.linear() = Eigen::AngleAxisd(3 * uniform(random), vector().normalized()).toRotationMatrix();
      moved.translation() = 2 * vector();
      drawn.push_back(moved);
      names.push_back(fmt::format("link{}", k));
      b.add_body(names.back(), {.mass = 1,
                                .com = moved * points[static_cast<std::size_t>(k)],
                                .inertia = build::inertia(1, 1, 1)});
    }
    drawn.push_back(drawn.front());
    names.push_back("ground");
    for (int k = 0; k <= links; ++k) {
      const auto i = static_cast<std::size_t>(k);
      build::Joint joint{.type = k % 2 == 0 ? JointType::revolute : JointType::spherical,
                         .between = {names[i], names[i + 1]}};
      joint.at = drawn[i] * points[i];
      joint.at_b = drawn[i + 1] * points[i];
      if (joint.type == JointType::revolute) {
        joint.axis = drawn[i].linear() * axes[i];
        joint.axis_b = drawn[i + 1].linear() * axes[i];
      }
      b.add_joint(fmt::format("j{}", k), joint);
    }
    const spec::Model found = brought_together(b.build());
    for (const spec::Joint& j : found.joints) {
      const auto placed = [&](int frame) {
        const spec::Frame& f = found.frames[static_cast<std::size_t>(frame)];
        spec::Pose body;
        if (f.body >= 0) body = found.bodies[static_cast<std::size_t>(f.body)].pose;
        return spec::Pose{body.position + body.rotation * f.pose.position, body.rotation * f.pose.rotation};
      };
      const spec::Pose a = placed(j.frame_a), c = placed(j.frame_b);
      EXPECT_LT((a.position - c.position).norm(), 1e-7) << trial << " " << j.name;
      if (j.type == JointType::revolute) {
        EXPECT_GT(a.rotation.col(2).dot(c.rotation.col(2)), 1 - 1e-9) << trial << " " << j.name;
      }
    }
    ++closed;
    Simulation s(Model::compile(found), {});
    for (int k = 0; k < 5; ++k) EXPECT_TRUE(s.step().ok());
  }
  EXPECT_EQ(closed, 40);
}

/// Templates that are mirrored mean the mirrored lengths.
TEST(BringTogetherModel, MirroredTemplatesAreTheMirrorImage) {
  const std::string text = R"y(
subsystems:
  side:
    bodies:
      crank: {mass: 1, com: [0.1, 0, 0.02], inertia: [0.1, 0.2, 0.3]}
      rod: {mass: 1, com: [0.3, 0, 0], inertia: [0.1, 0.2, 0.3]}
      block: {mass: 1, com: [0, 0, 0], inertia: [0.1, 0.2, 0.3]}
    joints:
      crank: {type: revolute, between: [ground, crank], at: [0, 0.4, 0], axis: [0, 1, 0], position: 0.7}
      pin: {type: spherical, between: [crank, rod], at: [[0.2, 0.4, 0.1], [0, 0, 0]]}
      eye: {type: universal, between: [rod, block], at: [[0.8, 0, 0], [0, 0, 0]], axis: [0, 1, 0], axis2: [0, 0, 1]}
      guide: {type: prismatic, between: [ground, block], at: [[0, 0.5, 0], [0, 0, 0]], axis: [1, 0, 0], near: -0.5}
    outputs:
      - {name: "{instance}.x", position: block, component: x}
      - {name: "{instance}.y", position: rod, component: y}
      - {name: "{instance}.z", position: rod, component: z}
instances:
  left: {of: side}
  right: {of: side, mirror: y}
)y";
  Simulation s = simulation_of(together(text), Formulation::relative);
  EXPECT_LT(channel(s, "left.x"), -0.4);
  EXPECT_NEAR(channel(s, "left.x"), channel(s, "right.x"), 1e-9);
  EXPECT_NEAR(channel(s, "left.y"), -channel(s, "right.y"), 1e-9);
  EXPECT_NEAR(channel(s, "left.z"), channel(s, "right.z"), 1e-9);
}

}  // namespace
}  // namespace mimbre::bring_together_test
