#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "integrate/global_modes/spline.h"
#include "support/models.h"
#include "support/simulate.h"

/// Loops by tables over a joint coordinate and by modes of the whole loop, against the formalism index3.
namespace mimbre::test::global_modes_test {
namespace {

using Formalism = spec::Simulation::Formalism;
using testing::HasSubstr;

Simulation simulation(const std::shared_ptr<const Model>& model, Formalism formalism, double step) {
  RunOptions options;
  options.formalism = formalism;
  options.step = step;
  options.tolerance = 1e-7;
  return Simulation(model, options);
}

/// A channel every `interval` seconds.
std::vector<double> history(const std::shared_ptr<const Model>& model, Formalism formalism, double step,
                            const std::string& name, double end, double interval) {
  Simulation s = simulation(model, formalism, step);
  std::vector<double> out;
  for (int k = 1; k * interval <= end * (1 + 1e-9); ++k) {
    run_to(s, k * interval);
    out.push_back(channel(s, name));
  }
  return out;
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, std::abs(a[k] - b[k]));
  return most;
}

double range(const std::vector<double>& a) {
  return *std::max_element(a.begin(), a.end()) - *std::min_element(a.begin(), a.end());
}

/// Between its places a spline takes cubic functions as they are, with their derivatives.
TEST(GlobalModesSpline, HasCubicFunctionsExactly) {
  const auto f = [](double x) { return 1 - 2 * x + 0.5 * x * x + 3 * x * x * x; };
  Eigen::MatrixXd values(1, 6);
  for (int k = 0; k < 6; ++k) values(0, k) = f(-1 + 0.3 * k);
  const global_modes::Spline spline(values, -1, 0.3);
  for (double x = -1; x < 0.5; x += 0.07) {
    double value = 0, rate = 0, second = 0;
    spline.evaluate(x, &value, &rate, &second);
    EXPECT_NEAR(value, f(x), 1e-12);
    EXPECT_NEAR(rate, -2 + x + 9 * x * x, 1e-11);
    EXPECT_NEAR(second, 1 + 18 * x, 1e-10);
  }
}

/// Rigid bars: tables alone. The difference from a far finer run of the other formalism is that of the step.
TEST(GlobalModes, RigidFourBarConvergesWithOrderTwo) {
  const auto model =
      model_of(four_bar_text({{"crank", ", velocity: [3]"}}) + "outputs: [{name: angle, joint: crank}]\n");
  const std::vector<double> exact = history(model, Formalism::index3, 2.5e-4, "angle", 1, 0.02);
  double error[2];
  for (int k = 0; k < 2; ++k)
    error[k] = difference(history(model, Formalism::global_modes, 0.004 / (1 << k), "angle", 1, 0.02), exact);
  EXPECT_LT(error[1], 1e-3 * range(exact));
  EXPECT_NEAR(std::log2(error[0] / error[1]), 2, 0.3);
}

/// A loop in space, with spherical joints, whose quaternions are in the table.
TEST(GlobalModes, LoopsInSpaceMoveAlike) {
  const std::string text = R"(
gravity: [0, 0, -9.81]
bodies:
  crank: {mass: 1, com: [0.1, 0, 0], inertia: [0.002, 0.004, 0.004]}
  rod: {mass: 0.6, com: [0.35, 0.1, 0.05], inertia: [0.003, 0.01, 0.01]}
  slider: {mass: 2, com: [0.5, 0.2, 0.1], inertia: [0.01, 0.01, 0.01]}
joints:
  main: {type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 0.2, 1], velocity: [4]}
  pin: {type: spherical, between: [crank, rod], at: [0.2, 0, 0]}
  wrist: {type: universal, between: [rod, slider], at: [0.5, 0.2, 0.1], axis: [0, 0, 1], axis2: [0, 1, 0]}
  guide: {type: prismatic, between: [ground, slider], at: [0.5, 0.2, 0.1], axis: [1, 0, 0]}
outputs:
  - {name: angle, joint: main}
  - {name: x, position: slider, component: x}
)";
  const auto model = model_of(text);
  for (const char* name : {"angle", "x"}) {
    const std::vector<double> exact = history(model, Formalism::index3, 2.5e-4, name, 0.24, 0.005),
                              found = history(model, Formalism::global_modes, 0.001, name, 0.24, 0.005);
    EXPECT_LT(difference(found, exact), 1e-3 * range(exact)) << name;
  }
}

/// A slider–crank whose rod is damped so much that it only bends as it is loaded.
std::shared_ptr<const Model> damped_crank(std::map<std::string, std::string> set) {
  set["damping"] = "2e-3";
  return example("slider-crank/slider-crank.yaml", set);
}

/// Its rod through several turns of the crank. From the floating frame it differs by what goes with the axial
/// force over the buckling load, so with the square of the speed; 20 corotational elements agree.
TEST(GlobalModes, SliderCrankBendsAlike) {
  const auto run = [](const char* speed, const char* approach, Formalism formalism) {
    return history(damped_crank({{"speed", speed}, {"approach", approach}, {"elements", "20"}}), formalism,
                   2e-4, "rod.deflection", 0.5, 0.001);
  };
  double share[2];
  for (int k = 0; k < 2; ++k) {
    const char* speed = k == 0 ? "10" : "20";
    const std::vector<double> found = run(speed, "floating_frame", Formalism::global_modes),
                              other = run(speed, "floating_frame", Formalism::index3),
                              exact = run(speed, "corotational", Formalism::index3);
    share[k] = difference(found, other) / range(exact);
    EXPECT_LT(difference(found, exact), 0.012 * range(exact)) << speed;
  }
  EXPECT_LT(share[0], 0.012);
  EXPECT_NEAR(std::log2(share[1] / share[0]), 2, 0.5);
}

/// What drives need and joints carry are those of the other formalism.
TEST(GlobalModes, ReactionsAreThoseOfTheOtherFormalism) {
  const auto model = example("slider-crank/slider-crank.yaml", {{"rod", "rigid"}});
  const std::vector<double> exact = history(model, Formalism::index3, 2e-4, "main.torque", 0.4, 0.004),
                            found = history(model, Formalism::global_modes, 2e-4, "main.torque", 0.4, 0.004);
  EXPECT_LT(difference(found, exact), 1e-3 * range(exact));
}

/// The suspension of the Iltis with all its bars flexible, over a drop of the road.
TEST(GlobalModes, SuspensionMovesAlike) {
  const auto model = example("iltis/suspension.yaml");
  for (const char* name : {"chassis.z", "wheel.z", "arm.deflection"}) {
    const std::vector<double> exact = history(model, Formalism::index3, 0.002, name, 4, 0.01),
                              found = history(model, Formalism::global_modes, 0.002, name, 4, 0.01);
    EXPECT_LT(difference(found, exact), 0.01 * range(exact)) << name;
  }
}

/// A door on a hinge and a ball: what the ball adds are equations that see nothing but round-off.
TEST(GlobalModes, RedundantHingesAreNoDrives) {
  const auto model = model_of(R"(
gravity: [0, 0, -9.81]
bodies:
  door: {mass: 10, com: [0.4, 0, 1], inertia: [3, 3.5, 0.6]}
joints:
  h1: {type: revolute, between: [ground, door], at: [0.123, 0.456, 0.2], axis: [0.31, 0.47, 0.9], velocity: [1]}
  h2: {type: spherical, between: [ground, door], at: [0.65, 1.255, 1.73]}
outputs:
  - {name: a, joint: h1}
)");
  const std::vector<double> exact = history(model, Formalism::index3, 5e-4, "a", 0.5, 0.01),
                            found = history(model, Formalism::global_modes, 5e-4, "a", 0.5, 0.01);
  EXPECT_LT(difference(found, exact), 1e-4 * range(exact));
}

/// A flexible frame in two bearings: θ is its only joint coordinate, and the bearings hold some of its modes.
TEST(GlobalModes, FlexibleFramesTurnInTwoBearings) {
  const auto model = model_of(R"(
gravity: [0, -3, -9.81]
materials:
  steel: {young: 2.1e11, poisson: 0.3, density: 7850}
sections:
  round: {type: round, diameter: 0.01}
bodies:
  door:
    frame: {at: [0.1, 0, 0.2]}
    flexible:
      material: steel
      section: round
      nodes: {p: [0.1, 0, 0.2], e: [0.4, 0, 0.2], f: [0.4, 0, 1.2], q: [0.1, 0, 1.2]}
      bars: {b1: {from: p, to: e}, b2: {from: e, to: f}, b3: {from: f, to: q}}
      clamped: [p]
      static_modes: [{node: q, all: true}, {node: f, all: true}]
      stiffness_damping: 1e-3
joints:
  h1: {type: revolute, between: [ground, door], at: [0.1, 0, 0.2], axis: [0, 0, 1], velocity: [2]}
  h2: {type: revolute, between: [ground, door], at: [0.1, 0, 1.2], axis: [0, 0, 1]}
outputs:
  - {name: a, joint: h1}
  - {name: f, deflection: door.f, along: [1, 0, 0]}
)");
  for (const char* name : {"a", "f"}) {
    const std::vector<double> exact = history(model, Formalism::index3, 5e-4, name, 0.5, 0.01),
                              found = history(model, Formalism::global_modes, 5e-4, name, 0.5, 0.01);
    EXPECT_LT(difference(found, exact), 0.02 * range(exact)) << name;
  }
}

/// A load across the plane of a four-bar that comes later than the table has been made.
TEST(GlobalModes, LoadsThatComeLaterBendAlike) {
  const auto model = model_of(R"yaml(
gravity: [0, 0, -9.81]
materials:
  steel: {young: 2.1e11, poisson: 0.3, density: 7850}
sections:
  round: {type: round, diameter: 0.01}
bodies:
  crank: {mass: 0.5, com: [0, 0, 0.1], inertia: [0.002, 0.002, 0.0001]}
  rod:
    frame: {at: [0, 0, 0.2]}
    flexible:
      material: steel
      section: round
      nodes: {p: [0, 0, 0.2], q: [0.5, 0, 0.4], mid: {on: [bar, 0.5]}}
      bars: {bar: {from: p, to: q, elements: 6}}
      clamped: [p]
      static_modes: [{node: q, all: true}, {node: mid, along: [0, 1, 0], name: side}]
      dynamic_modes: 2
      stiffness_damping: 1e-3
  rocker: {mass: 0.5, com: [0.5, 0, 0.2], inertia: [0.005, 0.005, 0.0001]}
joints:
  a: {type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 1, 0], velocity: [3]}
  b: {type: revolute, between: [crank, rod], at: [0, 0, 0.2], axis: [0, 1, 0]}
  c: {type: spherical, between: [rod, rocker], at: [0.5, 0, 0.4]}
  d: {type: revolute, between: [ground, rocker], at: [0.5, 0, 0], axis: [0, 1, 0]}
loads:
  push: {on: rod.mid, force: [0, 20, 0], scale: "t < 0.1 ? 0 : (t < 0.2 ? (t - 0.1)*10 : 1)"}
outputs:
  - {name: y, deflection: rod.mid, along: [0, 1, 0]}
)yaml");
  const std::vector<double> exact = history(model, Formalism::index3, 5e-4, "y", 0.4, 0.01),
                            found = history(model, Formalism::global_modes, 5e-4, "y", 0.4, 0.01);
  EXPECT_GT(range(exact), 1e-4);
  EXPECT_LT(difference(found, exact), 0.02 * range(exact));
}

/// What bends a body far opens the loop, since its modes are those about the rigid mechanism.
TEST(GlobalModes, WarnOfLoopsThatTheyLeaveOpen) {
  const auto said = [](const char* speed) {
    Simulation s = simulation(example("slider-crank/slider-crank.yaml", {{"speed", speed}}),
                              Formalism::global_modes, 2e-4);
    run_to(s, 0.1);
    std::string all;
    for (const std::string& text : s.warnings()) all += text + '\n';
    return all;
  };
  EXPECT_THAT(said("20"), testing::Not(HasSubstr("loops are open")));
  EXPECT_THAT(said("100"), HasSubstr("loops are open by up to"));
}

/// What the validity monitor sees of joint forces.
TEST(GlobalModes, WarnOfLoadsBeyondLinearTheory) {
  const auto warned = [](Formalism formalism) {
    Simulation s = simulation(example("slider-crank/slider-crank.yaml", {{"speed", "60"}}), formalism, 2e-4);
    run_to(s, 0.2);
    for (const Validity& body : s.validity())
      if (body.body == "rod") return body.tension.value;
    return 0.;
  };
  const double exact = warned(Formalism::index3), found = warned(Formalism::global_modes);
  EXPECT_GT(exact, 0.1);
  EXPECT_NEAR(found, exact, 0.05 * exact);
}

/// What has no table says why, and where.
TEST(GlobalModes, RefuseWhatHasNoTable) {
  const auto message = [](const std::shared_ptr<const Model>& model, const RunOptions& asked = {}) {
    RunOptions options = asked;
    options.formalism = Formalism::global_modes;
    try {
      Simulation s(model, options);
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  RunOptions natural;
  natural.formulation = spec::Simulation::Formulation::natural;
  EXPECT_THAT(message(model_of(four_bar_text()), natural), HasSubstr("use formulation: relative"));
  EXPECT_THAT(message(example("double-wishbone/model.yaml")), HasSubstr("ways"));
  EXPECT_THAT(message(example("slider-crank/slider-crank.yaml", {{"approach", "elastodynamics"}})),
              HasSubstr("elastodynamics"));
}

}  // namespace
}  // namespace mimbre::test::global_modes_test
