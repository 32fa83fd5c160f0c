#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "mimbre/modes.h"
#include "mimbre/simulation.h"
#include "mimbre/statics.h"
#include "support/models.h"

/// Static equilibria that do not last are told from those that do.
namespace mimbre::test::stability_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using Formulation = spec::Simulation::Formulation;

RunOptions in(Formulation formulation) {
  RunOptions options;
  options.formulation = formulation;
  return options;
}

/// A pendulum of 1 kg a metre above its hinge, 0.1 kg m² about its centre, held by a torsional spring.
std::string inverted(double stiffness) {
  std::string spring;
  if (stiffness > 0) spring = ", spring: {stiffness: " + std::to_string(stiffness) + "}";
  return "bodies: {a: {mass: 1, com: [0, 0, 1], inertia: [0.1, 0.1, 0.1]}}\n"
         "joints: {h: {type: revolute, between: [ground, a], at: [0, 0, 0], axis: [0, 1, 0]" +
         spring + "}}\noutputs: [{name: angle, joint: h}]\n";
}

TEST(Stability, OfAnInvertedPendulum) {
  for (const Formulation f : {Formulation::relative, Formulation::natural}) {
    const StaticResult alone = static_equilibrium(model_of(inverted(0)), in(f));
    EXPECT_NEAR(alone.values[0], 0, 1e-9);
    EXPECT_FALSE(alone.stable);
    // λ² = m g l / (J + m l²)
    char text[32];
    std::snprintf(text, sizeof text, "%.3g s", 1 / std::sqrt(9.81 / 1.1));
    EXPECT_THAT(alone.warnings, ElementsAre(HasSubstr(text)));
    EXPECT_FALSE(static_equilibrium(model_of(inverted(9.7)), in(f)).stable);
    const StaticResult held = static_equilibrium(model_of(inverted(9.9)), in(f));
    EXPECT_TRUE(held.stable);
    EXPECT_THAT(held.warnings, IsEmpty());
  }
}

/// A straight rod of segments, 1 kg and 1 m, on a joint at its end.
std::string rod(const std::string& kind, int elements, double young, const std::string& joint,
                const std::string& gravity) {
  return fmt::format(R"yaml(
gravity: {}
materials: {{stuff: {{young: {}, poisson: 0.3, density: 10000}}}}
sections: {{square: {{type: rectangle, width: 0.01, height: 0.01}}}}
bodies:
  rod:
    frame: {{at: [0, 0, 0]}}
    flexible:
      material: stuff
      section: square
      nodes: {{root: [0, 0, 0], tip: [0.48, -0.64, 0.6]}}
      bars: {{all: {{from: root, to: tip, elements: {}}}}}
      clamped: [root]
      beam: {}
joints:
  root: {{{}, between: [ground, rod], at: [0, 0, 0]}}
outputs: [{{name: tip, position: rod.tip, component: z}}]
)yaml",
                     gravity, young, elements, kind, joint);
}

/// Nothing resists the motions of a free rod but the round-off of its stiff parts: these are neither
/// instabilities nor anything but rigid.
TEST(Stability, RoundOffOfStiffPartsIsNoInstability) {
  for (const char* kind : {"segments", "stretching_segments"})
    for (const int elements : {2, 5, 8})
      for (const double young : {1e8, 9e9, 2.1e11}) {
        const auto model = model_of(rod(kind, elements, young, "type: floating", "[0, 0, 0]"));
        const StaticResult r = static_equilibrium(model);
        EXPECT_TRUE(r.stable) << kind << elements << ' ' << young;
        EXPECT_THAT(r.warnings, IsEmpty()) << kind << elements << ' ' << young;
        const LinearisedModes modes = find_modes(model);
        EXPECT_EQ(std::count_if(modes.modes.begin(), modes.modes.end(),
                                [](const Mode& m) { return m.kind == Mode::Kind::rigid; }),
                  6)
            << kind << elements << ' ' << young;
      }
}

/// On its tip the same rod falls, λ² = 3/2 g/l, however stiff it is.
TEST(Stability, OfAStiffRodOnItsTip) {
  for (const char* kind : {"segments", "stretching_segments"}) {
    const StaticResult r = static_equilibrium(
        model_of(rod(kind, 8, 2.1e11, "type: universal, axis: [0.8, 0.6, 0], axis2: [-0.36, 0.48, 0.8]",
                     "[-4.7088, 6.2784, -5.886]")));
    EXPECT_FALSE(r.stable);
    char text[32];
    std::snprintf(text, sizeof text, "%.2g", std::sqrt(1 / (1.5 * 9.81)));
    EXPECT_THAT(r.warnings, ElementsAre(HasSubstr(text)));
  }
}

TEST(Stability, OfNeutralMotionsNothingIsSaid) {
  // A disc on its axle: any angle will do.
  for (const Formulation f : {Formulation::relative, Formulation::natural}) {
    const StaticResult r = static_equilibrium(
        model_of("bodies: {a: {mass: 1000, com: [0, 0, 0], inertia: [30, 30, 50]}}\n"
                 "joints: {h: {type: revolute, between: [ground, a], at: [0, 0, 0], axis: [0, 1, 0]}}\n"
                 "outputs: [{name: angle, joint: h}]\n"),
        in(f));
    EXPECT_TRUE(r.stable);
    EXPECT_THAT(r.warnings, IsEmpty());
  }
}

TEST(Stability, OfALoopCountsTheForcesInIt) {
  // A parallelogram's platform is stable below its pivots and unstable above: constraint forces tell.
  for (const double side : {-1.0, 1.0}) {
    const std::string z = std::to_string(side), half = std::to_string(side / 2);
    const auto model = model_of(
        "bodies:\n  l: {mass: 1, com: [0, 0, " + half +
        "], inertia: [0.1, 0.1, 0.01]}\n  r: {mass: 1, com: [2, 0, " + half +
        "], inertia: [0.1, 0.1, 0.01]}\n  p: {mass: 3, com: [1, 0, " + z +
        "], inertia: [0.1, 1, 1]}\njoints:\n"
        "  a: {type: revolute, between: [ground, l], at: [0, 0, 0], axis: [0, 1, 0]}\n"
        "  d: {type: revolute, between: [ground, r], at: [2, 0, 0], axis: [0, 1, 0]}\n"
        "  b: {type: revolute, between: [l, p], at: [0, 0, " +
        z + "], axis: [0, 1, 0]}\n  c: {type: revolute, between: [r, p], at: [2, 0, " + z +
        "], axis: [0, 1, 0]}\noutputs: [{name: angle, joint: a}, {name: az, joint_force: a, component: fz}, "
        "{name: dz, joint_force: d, component: fz}]\n");
    for (const Formulation f : {Formulation::relative, Formulation::natural}) {
      const StaticResult r = static_equilibrium(model, in(f));
      EXPECT_EQ(r.stable, side < 0);
      EXPECT_NEAR(r.values[1], 2.5 * 9.81, 1e-6);
      EXPECT_NEAR(r.values[2], 2.5 * 9.81, 1e-6);
    }
  }
}

TEST(Stability, NamesWhatNothingHolds) {
  const auto model = model_of(
      "bodies:\n  a: {mass: 1, com: [0, 0, 1], inertia: [0.1, 0.1, 0.1]}\n"
      "  loose: {mass: 1, com: [0, 0, 1], inertia: [0.1, 0.1, 0.1]}\n"
      "joints: {h: {type: revolute, between: [ground, a], at: [0, 0, 0], axis: [0, 1, 0]}}\n");
  for (const Formulation f : {Formulation::relative, Formulation::natural}) {
    try {
      static_equilibrium(model, in(f));
      ADD_FAILURE();
    } catch (const std::runtime_error& e) {
      EXPECT_THAT(e.what(), HasSubstr("loose"));
    }
  }
}

/// A four-bar whose coupler's far pin is drawn `off` metres from the rocker's.
std::string open_four_bar(double off) {
  return "bodies:\n"
         "  crank: {mass: 1, com: [0, 0, 0.1], inertia: [0.01, 0.01, 0.01]}\n"
         "  coupler: {mass: 1, com: [0.3, 0, 0.2], inertia: [0.01, 0.01, 0.01]}\n"
         "  rocker: {mass: 1, com: [0.6, 0, 0.2], inertia: [0.01, 0.01, 0.01]}\n"
         "frames:\n  pin: {body: coupler, at: [0.6, 0, " +
         std::to_string(0.4 + off) +
         "]}\n  eye: {body: rocker, at: [0.6, 0, 0.4]}\n"
         "joints:\n"
         "  a: {type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 1, 0], position: 0.3}\n"
         "  b: {type: revolute, between: [crank, coupler], at: [0, 0, 0.2], axis: [0, 1, 0]}\n"
         "  d: {type: revolute, between: [ground, rocker], at: [0.6, 0, 0], axis: [0, 1, 0]}\n"
         "  e: {type: spherical, between: [pin, eye]}\n";
}

TEST(DrawnOpen, IsSaidWithJointAndMotion) {
  // The given angle moves the mechanism too, but that is meant.
  EXPECT_THAT(Simulation(model_of(open_four_bar(0))).warnings(), IsEmpty());
  EXPECT_THAT(Simulation(model_of(open_four_bar(1e-5))).warnings(), IsEmpty());
  EXPECT_THAT(Simulation(model_of(open_four_bar(0.05))).warnings(),
              ElementsAre(testing::AllOf(HasSubstr("'e'"), HasSubstr("0.05 m"))));
}

/// Round-off of a stiff part reaches only what it is coupled with: beside it a spring of 1e-14 of its
/// stiffness has its frequency, on a part of its own. On a spring in series with the stiff one 1e-12 are
/// seen.
TEST(Stability, SoftSpringsBesideStiffOnesAreSeen) {
  const auto slowest = [](const char* between, double soft) {
    ModesOptions options;
    options.linear.point.at = LinearPoint::At::start;
    const LinearisedModes found = find_modes(
        model_of(fmt::format(
            "gravity: [0, 0, 0]\nbodies:\n  hard: {{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}\n"
            "  soft: {{mass: 1, com: [1, 0, 0], inertia: [1, 1, 1]}}\njoints:\n"
            "  a: {{type: prismatic, between: [ground, hard], at: [0, 0, 0], axis: [0, 0, 1], spring: "
            "{{stiffness: 1e9}}}}\n"
            "  b: {{type: prismatic, between: [{}, soft], at: [1, 0, 0], axis: [0, 0, 1], spring: "
            "{{stiffness: {:.17g}}}}}\n",
            between, soft)),
        options);
    EXPECT_EQ(found.modes[0].kind, Mode::Kind::oscillating) << between;
    return std::abs(found.modes[0].value);
  };
  EXPECT_NEAR(slowest("ground", 1e-5), std::sqrt(1e-5), 1e-9 * std::sqrt(1e-5));
  EXPECT_NEAR(slowest("hard", 1e-3), std::sqrt(1e-3), 1e-2 * std::sqrt(1e-3));
}

}  // namespace
}  // namespace mimbre::test::stability_test
