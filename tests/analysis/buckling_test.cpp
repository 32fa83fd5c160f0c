#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mimbre/buckling.h"
#include "mimbre/diagnostics.h"
#include "support/models.h"

/// Buckling loads against closed forms.
namespace mimbre::test::buckling_test {
namespace {

using testing::HasSubstr;

/// Two links of 0.5 m upright, with springs of 40 and 30 N m/rad in their hinges, and a load on their top.
std::string links(const std::string& load, const std::string& springs = "40 30") {
  const std::size_t gap = springs.find(' ');
  return fmt::format(R"(
gravity: [0, 0, 0]
bodies:
  lower: {{mass: 1, com: [0, 0, 0.25], inertia: [0.1, 0.1, 0.1]}}
  upper: {{mass: 1, com: [0, 0, 0.75], inertia: [0.1, 0.1, 0.1]}}
frames: {{top: {{body: upper, at: [0, 0, 1]}}}}
joints:
  foot: {{type: revolute, between: [ground, lower], at: [0, 0, 0], axis: [0, 1, 0], spring: {{stiffness: {}}}}}
  knee: {{type: revolute, between: [lower, upper], at: [0, 0, 0.5], axis: [0, 1, 0], spring: {{stiffness: {}}}}}
loads: {{press: {}}}
)",
                     springs.substr(0, gap), springs.substr(gap + 1), load);
}

TEST(Buckling, OfTwoLinksWithSprings) {
  // In absolute angles K0 = [[70, -30], [-30, 30]], K1 = -P/2 I: P = 2 eig K0.
  const Buckling found = buckling(model_of(links("{on: top, force: [0, 0, -3]}")));
  ASSERT_EQ(found.modes.size(), 2u);
  const double root = std::sqrt(20 * 20 + 30 * 30);
  EXPECT_NEAR(3 * found.modes[0].factor, 2 * (50 - root), 1e-6);
  EXPECT_NEAR(3 * found.modes[1].factor, 2 * (50 + root), 1e-5);
  EXPECT_EQ(found.loads, std::vector<std::string>{"press"});
  EXPECT_THAT(found.modes[0].text, HasSubstr("'foot'"));
  EXPECT_TRUE(found.warnings.empty());
}

TEST(Buckling, OfALoadThatPullsIsInTheOppositeDirection) {
  const Buckling found = buckling(model_of(links("{on: top, force: [0, 0, 1e5]}")));
  ASSERT_FALSE(found.modes.empty());
  EXPECT_NEAR(1e5 * found.modes[0].factor, -2 * (50 - std::sqrt(1300)), 1e-5);
}

/// A strip clamped at its root, 1 m long.
std::string strip(const std::string& force) {
  return R"(
gravity: [0, 0, 0]
materials: {unit: {young: 2.5e5, poisson: 0.3, density: 1}}
sections: {unit: {area: 1, Iy: 4e-3, Iz: 4e-6, J: 1.04e-5}}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: unit
      section: unit
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {beam: {from: root, to: tip, elements: 20, y: [0, 1, 0]}}
      clamped: [root]
      static_modes:
        - {node: tip, along: [0, 0, 1]}
        - {node: tip, along: [1, 0, 0]}
      dynamic_modes: 20
      stiffening: geometric_stiffness
joints:
  base: {type: fixed, between: [ground, beam], at: [0, 0, 0]}
loads:
  end: {on: beam.tip, force: )" +
         force + "}\n";
}

/// E Iz = 1, G J = 1: P = 4.0126 (Prandtl 1899), either way.
TEST(Buckling, OfACantileverSidewaysIsPrandtls) {
  const Buckling found = buckling(model_of(strip("[0, 0, -2]")));
  ASSERT_GE(found.modes.size(), 2u);
  for (int k = 0; k < 2; ++k)
    EXPECT_NEAR(2 * std::abs(found.modes[static_cast<std::size_t>(k)].factor), 4.0126, 0.04);
}

TEST(Buckling, OfAColumnIsEulers) {
  const Buckling found = buckling(model_of(strip("[-1, 0, 0]")));
  ASSERT_FALSE(found.modes.empty());
  EXPECT_NEAR(found.modes[0].factor, std::numbers::pi * std::numbers::pi / 4, 0.01);
}

TEST(Buckling, OfAColumnInALoopIsTheSameInAnyDirection) {
  // Pinned at both ends, π² E I / L²; on a plane the slide of its top, several coordinates of the column are
  // equally good to express the others, and which are best goes by round-off.
  const double I = 0.03 * std::pow(0.012, 3) / 12;
  for (const double angle : {0.0, 5.0, 37.0, 90.0}) {
    const double turn = angle * std::numbers::pi / 180;
    const Buckling found = buckling(model_of(fmt::format(R"(
gravity: [0, 0, 0]
parameters: {{c: {}, s: {}}}
materials: {{m: {{young: 7e10, poisson: 0.3, density: 2700}}}}
sections: {{s: {{type: rectangle, width: 0.03, height: 0.012}}}}
bodies:
  column:
    frame: {{at: [0, 0, 0], x: [c, s, 0], y: [-s, c, 0]}}
    flexible:
      material: m
      section: s
      nodes: {{a: [0, 0, 0], t: [c, s, 0]}}
      bars: {{q: {{from: a, to: t, elements: 8, y: [-s, c, 0]}}}}
      clamped: [a]
      beam: corotational
  slide: {{mass: 1, com: [c, s, 0], inertia: [1, 1, 1]}}
joints:
  foot: {{type: revolute, between: [ground, column], at: [0, 0, 0], axis: [-s, c, 0]}}
  guide: {{type: prismatic, between: [ground, slide], at: [c, s, 0], axis: [c, s, 0]}}
  top: {{type: revolute, between: [slide, column.t], axis: [-s, c, 0]}}
loads: {{press: {{on: slide, force: [-c, -s, 0]}}}}
)",
                                                         std::cos(turn), std::sin(turn))));
    ASSERT_FALSE(found.modes.empty()) << angle;
    EXPECT_NEAR(found.modes[0].factor / (std::numbers::pi * std::numbers::pi * 7e10 * I), 1, 2e-3) << angle;
  }
}

TEST(Buckling, RefusesByName) {
  const auto said = [](const std::string& text, const BucklingOptions& options = {}) -> std::string {
    try {
      buckling(model_of(text), options);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  };
  const std::string down = "{on: top, force: [0, 0, -3]}";
  EXPECT_THAT(said(links(down, "0 30")), HasSubstr("nothing holds 'foot'"));
  EXPECT_THAT(said(links("{on: top, force: [0, 0, -3], follower: true}")), HasSubstr("flutter"));
  BucklingOptions other;
  other.loads = {"pres"};
  EXPECT_THAT(said(links(down), other), HasSubstr("did you mean 'press'"));
  other.loads = {"gravity"};
  EXPECT_THAT(said(links(down), other), HasSubstr("no gravity"));
}

}  // namespace
}  // namespace mimbre::test::buckling_test
