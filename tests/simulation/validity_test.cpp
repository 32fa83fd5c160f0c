#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "math/once/decompositions.h"
#include "mimbre/reduced_body.h"
#include "mimbre/simulation.h"
#include "support/models.h"

/// The watch over what linear theory neglects, against closed forms of beams.
namespace mimbre::test::validity_test {
namespace {

using std::numbers::pi;
using testing::AllOf;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// A round steel cantilever along x.
constexpr double length = 1, diameter = 0.01, young = 2.1e11, density = 7850;
constexpr double area = pi / 4 * diameter * diameter,
                 inertia = pi / 64 * diameter * diameter * diameter * diameter;
constexpr double bending = young * inertia;
constexpr double buckling_load = pi * pi * bending / (4 * length * length);

const std::string both_planes =
    "static_modes: [{node: tip, along: [0, 1, 0]}, {node: tip, along: [0, 0, 1]}]\n      dynamic_modes: 4";
const std::string one_plane =
    "planar: [0, 1, 0]\n      static_modes: [{node: tip, along: [0, 0, 1]}]\n      dynamic_modes: 3";

/// With the given joints and whatever else.
std::shared_ptr<const Model> cantilever(const std::string& gravity, const std::string& more,
                                        const std::string& modes = both_planes) {
  return model_of("gravity: " + gravity + R"(
materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}
sections: {round: {type: round, diameter: 0.01}}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: steel
      section: round
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {bar: {from: root, to: tip, elements: 20}}
      clamped: [root]
      )" + modes + "\n" +
                  more);
}

const std::string held = "joints: {root: {type: fixed, between: [ground, beam], at: [0, 0, 0]}}\n";

std::string end_load(double x, double z) {
  return held + "loads: {end: {on: beam.tip, force: [" + std::to_string(x) + ", 0, " + std::to_string(z) +
         "]}}\n";
}

TEST(Validity, CompressionIsOverEulersLoad) {
  const double force = 0.3 * buckling_load;
  const Simulation pressed(cantilever("[0, 0, 0]", end_load(-force, 0)));
  EXPECT_NEAR(pressed.validity().at(0).compression.value, 0.3, 0.003);
  EXPECT_EQ(pressed.validity().at(0).tension.value, 0);
  EXPECT_THAT(pressed.warnings(),
              ElementsAre(AllOf(HasSubstr("'beam'"), HasSubstr("buckling load"), HasSubstr("foreshortening"),
                                Not(HasSubstr("deflection")))));

  const Simulation pulled(cantilever("[0, 0, 0]", end_load(force, 0)));
  EXPECT_EQ(pulled.validity().at(0).compression.value, 0);
  EXPECT_NEAR(pulled.validity().at(0).tension.value, 0.3, 0.003);
}

/// A column under its own weight buckles at a height with ρAgL³ = 7.837 EI (Greenhill 1881).
TEST(Validity, AColumnsOwnWeightPresses) {
  const Simulation s(cantilever("[-9.81, 0, 0]", held));
  const double ratio = density * area * 9.81 * length * length * length / (7.837 * bending);
  EXPECT_NEAR(s.validity().at(0).compression.value, ratio, 0.01 * ratio);
}

/// The joint's own force is seen where the body hangs on its free end, too.
TEST(Validity, ForcesOfTheBodysOwnJointCount) {
  const Simulation s(cantilever(
      "[-9.81, 0, 0]", "joints: {top: {type: spherical, between: [ground, beam], at: [1, 0, 0]}}\n"));
  const Validity v = s.validity().at(0);
  // Held at x = 1 against a pull to −x: tension that grows towards the tip, at most the weight.
  const double weight = density * area * length * 9.81;
  EXPECT_EQ(v.compression.value, 0);
  EXPECT_GT(v.tension.value, 0.3 * weight / buckling_load);
  EXPECT_LT(v.tension.value, weight / buckling_load);
}

/// Rotation stiffens the first flapping mode: ω² = ω₁² + 1.193 Ω² (Southwell, Gough 1921; Wright et al.
/// 1982). The shape that it stiffens most does so a little more. The blade hardly bends.
TEST(Validity, AFastBladeIsStiffened) {
  const double first = 3.5160 * std::sqrt(bending / (density * area)) / (length * length), spin = 0.8 * first;
  Simulation s(cantilever("[0, 0, 0]",
                          "joints: {hub: {type: revolute, between: [ground, beam], at: [0, 0, 0], axis: "
                          "[0, 0, 1], drive: {position: \"" +
                              std::to_string(spin) + "*t\"}}}\n"));
  const Validity v = s.validity().at(0);
  EXPECT_GT(v.tension.value, 0.999 * 1.193 * 0.64);
  EXPECT_LT(v.tension.value, 1.05 * 1.193 * 0.64);
  EXPECT_LT(v.deflection.value, 1e-6);
  EXPECT_THAT(s.warnings(), ElementsAre(AllOf(HasSubstr("'beam'"), HasSubstr("rotation"))));
}

TEST(Validity, ALargeEndLoadBendsTooFar) {
  const auto bent = [](double share) {
    const double force = share * 3 * bending / (length * length);
    return Simulation(cantilever("[0, 0, 0]", end_load(0, force) + "initial: equilibrium\n"));
  };
  const Simulation far = bent(0.2);
  const Validity v = far.validity().at(0);
  EXPECT_NEAR(v.deflection.value, 0.2, 1e-4);
  EXPECT_NEAR(v.foreshortening.value, 0.6 * 0.04, 0.002 * 0.024);  // 6/10 δ²/L of a tip load
  EXPECT_LT(v.axial, 1e-12);
  EXPECT_THAT(far.warnings(),
              ElementsAre(AllOf(HasSubstr("deflection"), HasSubstr("20 %"), HasSubstr("shortening"))));
  EXPECT_THAT(bent(0.05).warnings(), IsEmpty());
}

/// A rod that hangs from its clamped end, with a ball at the other that a load pushes aside: under tension it
/// swings faster than by linear theory. `body`: what the rod is made as.
std::string hanging_rod(const std::string& body, double ball) {
  return R"(
gravity: [9.81, 0, 0]
materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}
sections: {round: {type: round, diameter: 0.01}}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: steel
      section: round
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {bar: {from: root, to: tip, elements: 10}}
      clamped: [root]
      )" +
         body + "\n  ball: {mass: " + std::to_string(ball) + R"(, com: [1, 0, 0], inertia: [1e-4, 1e-4, 1e-4]}
joints:
  root: {type: fixed, between: [ground, beam], at: [0, 0, 0]}
  end: {type: fixed, between: [beam, ball], at: [1, 0, 0]}
loads: {push: {on: beam.tip, force: [0, 0, 3]}}
outputs: [{name: z, position: ball, component: z}]
simulation: {step: 0.002, end: 1.5}
)";
}

std::vector<double> tip_of(Simulation& s) {
  std::vector<double> z;
  ResultsRow row;
  for (int k = 0; k < 750; ++k) {
    EXPECT_TRUE(s.step().ok());
    s.sample(row);
    z.push_back(row.channels[0]);
  }
  return z;
}

/// What the lag is estimated as is what corotational beams find, which know of tension by their own means.
TEST(Validity, TheLagIsTheErrorOfVibrationsUnderTension) {
  for (const double ball : {0.2, 1.0, 2.0}) {
    Simulation linear(
        model_of(hanging_rod("static_modes: [{node: tip, all: true}]\n      dynamic_modes: 4", ball))),
        right(model_of(hanging_rod("beam: corotational", ball)));
    const std::vector<double> z = tip_of(linear), exact = tip_of(right);
    double error = 0, least = 0, most = 0;
    for (std::size_t k = 0; k < z.size(); ++k) {
      error = std::max(error, std::abs(z[k] - exact[k]));
      least = std::min(least, z[k]);
      most = std::max(most, z[k]);
    }
    const Validity v = linear.validity().at(0);
    EXPECT_TRUE(v.lag.watched);
    EXPECT_NEAR(v.lag.value, error / (most - least), 0.12 * v.lag.value) << ball << " kg";
    EXPECT_LT(v.tension.value, 0.15);  // which warns of nothing
    if (v.lag.value > 0.1)
      EXPECT_THAT(linear.warnings(), ElementsAre(HasSubstr("under tension or compression"))) << ball << " kg";
    else
      EXPECT_THAT(linear.warnings(), IsEmpty()) << ball << " kg";
  }
}

/// A run that stops says that the body is bent too far, not that the step is too long.
TEST(Validity, AStepThatFailsWithABodyBentTooFarNamesIt) {
  Simulation s(cantilever("[0, 0, 0]", held, one_plane));
  StepReport failed;
  failed.code = StepReport::Code::not_converged;
  EXPECT_THAT(s.explain(failed), AllOf(HasSubstr("smaller step"), Not(HasSubstr("of its length"))));
  Simulation::Snapshot state = s.save();
  const ReducedBody& body = *s.model().spec().bodies.at(0).flexible;
  const Eigen::VectorXd shape = mimbre::inverse(body.user_from_modal).col(0);
  state.q = shape / (body.frames.back().X * shape).norm() * 0.5;
  s.restart(state);
  EXPECT_THAT(s.explain(failed),
              AllOf(HasSubstr("'beam' was bent by 50 % of its length"), Not(HasSubstr("smaller step"))));
}

/// One that is fixed to the ground and guided by it bends alone: what its deflection causes is no more than
/// in a cantilever.
TEST(Validity, ABeamBetweenWallsIsNoLink) {
  const std::string guided = R"(joints:
  root: {type: fixed, between: [ground, beam], at: [0, 0, 0]}
  guide: {type: cylindrical, between: [ground, beam], at: [1, 0, 0], axis: [1, 0, 0], cut: always}
)";
  const std::string modes = "static_modes: [{node: tip, all: true}]\n      dynamic_modes: 4";
  Simulation s(cantilever("[0, 0, -1900]", guided + "initial: equilibrium\n", modes));
  EXPECT_GT(s.validity().at(0).deflection.value, 0.02);
  EXPECT_LT(s.validity().at(0).foreshortening.value, 0.005);
  EXPECT_THAT(s.warnings(), IsEmpty());
}

/// States in which one of the user's modes moves alone: the last of three dynamic ones is a high one.
TEST(Validity, EnergyInTheHighestModeOfASeries) {
  const auto model = cantilever("[0, 0, 0]", held, one_plane);
  const ReducedBody& body = *model->spec().bodies.at(0).flexible;
  ASSERT_EQ(body.modes, 4);  // static, three dynamic
  const Eigen::MatrixXd modal = mimbre::inverse(body.user_from_modal);
  for (int mode = 0; mode < 4; ++mode) {
    Simulation s(model);
    Simulation::Snapshot state = s.save();
    state.q = 1e-4 * modal.col(mode) / modal.col(mode).norm();
    s.restart(state);
    EXPECT_NEAR(s.validity().at(0).high_modes.value, mode == 3 ? 1 : 0, 1e-9) << mode;
    EXPECT_EQ(s.warnings().size(), mode == 3 ? 1u : 0u);
  }
}

/// With as many modes across as along, the higher of two is the first of its plane: nothing is said of it.
TEST(Validity, TheFirstModeOfEachPlaneIsNotAHighOne) {
  Simulation s(example("pendulum/flexible.yaml"));
  for (int k = 0; k < 400; ++k) ASSERT_TRUE(s.step().ok());
  EXPECT_EQ(s.validity().at(0).high_modes.value, 0);
  EXPECT_THAT(s.warnings(), Each(Not(HasSubstr("highest modes"))));
}

/// Kane's manoeuvre: the linear beam bends without bound. That is said while it still bends little.
TEST(Validity, TheSpinUpWarnsBeforeItDiverges) {
  Simulation s(example("spin-up-beam/beam-2d.yaml", {{"method", "linear"}}));
  while (s.warnings().empty() && s.step().ok()) {
  }
  const double warned = s.time(), deflection = s.validity().at(0).deflection.value;
  EXPECT_LT(deflection, 0.1);
  EXPECT_THAT(s.warnings(), ElementsAre(HasSubstr("body 'beam'")));
  while (s.time() < 20 && s.step().ok() && s.validity().at(0).deflection.value < 1) {
  }
  EXPECT_GT(s.validity().at(0).deflection.value, 1);
  EXPECT_GT(s.time(), warned + 1);
}

/// The same with what linear theory neglects, and in pieces.
TEST(Validity, WhatKnowsOfStiffeningDoesNotWarn) {
  for (const char* method : {"foreshortening", "substructuring", "geometric_stiffness"}) {
    Simulation s(example("spin-up-beam/beam-2d.yaml", {{"method", method}}));
    while (s.time() < 16) ASSERT_TRUE(s.step().ok()) << method;
    EXPECT_THAT(s.warnings(), IsEmpty()) << method;
  }
}

/// Joint forces come from other multipliers in natural coordinates.
TEST(Validity, FormulationsAgree) {
  std::vector<Validity> seen[2];
  for (int k = 0; k < 2; ++k) {
    RunOptions o;
    o.formulation = k == 0 ? spec::Simulation::Formulation::relative : spec::Simulation::Formulation::natural;
    Simulation s(example("slider-crank/slider-crank.yaml"), o);
    while (s.time() < 0.1) ASSERT_TRUE(s.step().ok());
    EXPECT_THAT(s.warnings(), IsEmpty());
    seen[k] = s.validity();
  }
  ASSERT_EQ(seen[0].size(), 1u);
  const Validity &a = seen[0][0], &b = seen[1][0];
  EXPECT_GT(a.compression.value, 0.05);
  EXPECT_NEAR(a.compression.value, b.compression.value, 0.02 * a.compression.value);
  EXPECT_NEAR(a.tension.value, b.tension.value, 0.02 * a.tension.value);
  EXPECT_NEAR(a.deflection.value, b.deflection.value, 0.02 * a.deflection.value);
}

/// A strut clamped at one end and guided at the other, bent by a force in its middle: what its free end would
/// do says nothing. F L³/(192 EI) in the middle.
TEST(Validity, TheMiddleIsWatchedWhereTheEndIsHeld) {
  const auto strut =
      [](double share, const std::string& stiffening) {
        const double force = share * 192 * bending / (length * length);
        return Simulation(model_of(R"(
gravity: [0, 0, 0]
materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}
sections: {round: {type: round, diameter: 0.01}}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: steel
      section: round
      nodes: {root: [0, 0, 0], mid: [0.5, 0, 0], tip: [1, 0, 0]}
      bars: {a: {from: root, to: mid, elements: 4}, b: {from: mid, to: tip, elements: 4}}
      clamped: [root]
      static_modes: [{node: mid, along: [0, 0, 1]}, {node: tip, all: true}]
      dynamic_modes: 4
      stiffening: )" + stiffening + R"(
joints:
  root: {type: fixed, between: [ground, beam], at: [0, 0, 0]}
  guide: {type: cylindrical, between: [ground, beam], at: [1, 0, 0], axis: [1, 0, 0], cut: always}
loads: {push: {on: beam.mid, force: [0, 0, )" +
                                   std::to_string(force) + "]}}\ninitial: equilibrium\n"));
      };
  // By corotational beams 3 % is off by less than 1 % of it, and 6 % by more.
  const Simulation little = strut(0.03, "linear"), more = strut(0.06, "linear"), far = strut(0.12, "linear");
  EXPECT_NEAR(little.validity().at(0).deflection.value, 0.03, 3e-4);
  EXPECT_THAT(little.warnings(), IsEmpty());
  EXPECT_NEAR(more.validity().at(0).deflection.value, 0.06, 6e-4);
  EXPECT_THAT(more.warnings(), ElementsAre(HasSubstr("shortening by bending")));
  EXPECT_NEAR(far.validity().at(0).deflection.value, 0.12, 1.2e-3);
  EXPECT_THAT(far.warnings(), ElementsAre(HasSubstr("deflection over length")));

  // With foreshortening nothing tells of compression; that is no 0 %.
  const Validity watched = far.validity().at(0), not_watched = strut(0.01, "foreshortening").validity().at(0);
  EXPECT_TRUE(watched.compression.watched && watched.foreshortening.watched && watched.deflection.watched);
  EXPECT_FALSE(not_watched.compression.watched || not_watched.tension.watched ||
               not_watched.foreshortening.watched);
  EXPECT_TRUE(not_watched.deflection.watched);
}

TEST(Validity, ARestoredStateStartsAfresh) {
  Simulation s(example("pendulum/flexible.yaml"));
  const Simulation::Snapshot start = s.save();
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(s.step().ok());
  EXPECT_GT(s.validity().at(0).deflection.value, 1e-3);
  s.restore(start);
  EXPECT_EQ(s.validity().at(0).deflection.value, 0);
  EXPECT_EQ(s.validity().at(0).body, "bar");
}

}  // namespace
}  // namespace mimbre::test::validity_test
