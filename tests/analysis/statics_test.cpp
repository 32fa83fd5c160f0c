#include "mimbre/statics.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <tuple>

#include "mimbre/simulation.h"
#include "support/models.h"

namespace mimbre::test::statics_test {
namespace {

double value(const StaticResult& r, const std::string& channel) {
  for (std::size_t k = 0; k < r.channels.size(); ++k)
    if (r.channels[k].name == channel) return r.values[static_cast<Eigen::Index>(k)];
  ADD_FAILURE() << "no channel " << channel;
  return std::nan("");
}

TEST(Statics, IltisOnTheFlatRoad) {
  const StaticResult r = static_equilibrium(
      example("iltis/vehicle.yaml",
              {{"arms", "rigid"}, {"links", "rigid"}, {"rods", "rigid"}, {"massless_links", "true"}}));
  EXPECT_NEAR(value(r, "chassis.z"), 0.562776, 0.5e-6);
  EXPECT_NEAR(value(r, "chassis.pitch") * 180 / std::numbers::pi, 0.1490, 0.5e-4);
  EXPECT_NEAR(value(r, "chassis.roll"), 0, 1e-8);
  for (const char* side : {"left", "right"}) {
    EXPECT_NEAR(value(r, std::string("tyre.front_") + side + ".force"), 3831.3, 0.05);
    EXPECT_NEAR(value(r, std::string("tyre.rear_") + side + ".force"), 3591.9, 0.05);
  }
  EXPECT_LT(r.residual, 1e-3);
}

/// In an equilibrium time stands still: the winch's speed is none of the damper's.
TEST(Statics, AWinchIsAtRest) {
  for (const char* formulation : {"relative", "natural"}) {
    const StaticResult r = static_equilibrium(model_of(fmt::format(R"y(
bodies: {{load: {{mass: 10, com: [0, 0, 0], inertia: [1, 1, 1]}}}}
joints: {{guide: {{type: prismatic, between: [ground, load], at: [0, 0, 0], axis: [0, 0, 1]}}}}
cables: {{hoist: {{over: [ground, load], at: [[0, 0, 3], [0, 0, 0]], axial_stiffness: 5e4, damping: 500, length: "2.99 - 0.2*t"}}}}
outputs: [{{name: z, joint: guide}}]
simulation: {{formulation: {}}}
)y",
                                                                   formulation)));
    EXPECT_NEAR(value(r, "z"), 0.01 - 98.1 * 2.99 / 5e4, 1e-9) << formulation;
    EXPECT_NEAR(value(r, "cable.hoist.force"), -98.1, 1e-4) << formulation;
  }
}

std::string cantilever(const std::string& gravity, const std::string& load) {
  return "gravity: " + gravity + R"(
materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}
sections: {round: {type: round, diameter: 0.02}}
bodies:
  bar:
    frame: {at: [0, 0, 0]}
    flexible:
      material: steel
      section: round
      nodes: {root: [0, 0, 0], tip: [2, 0, 0]}
      bars: {bar: {from: root, to: tip, elements: 8}}
      clamped: [root]
      static_modes:
        - {node: tip, along: [0, 0, 1]}
        - {node: tip, about: [0, 1, 0]}
      dynamic_modes: 6
joints:
  wall: {type: bracket, between: [ground, bar], at: [0, 0, 0]}
)" + load +
         R"(
outputs:
  - {name: tip, deflection: bar.tip, along: [0, 0, 1]}
  - {name: wall.fz, joint_force: wall, component: fz}
  - {name: wall.my, joint_force: wall, component: my}
)";
}

TEST(Statics, InputsAreThoseOfTheOptions) {
  const auto model = model_of(R"(
gravity: [0, 0, 0]
bodies: {block: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [0, 0, 1], spring: {stiffness: 100}}}
inputs: {push: {start: 0}}
actuators: {push: {joint: guide, force: push}}
outputs: [{name: z, joint: guide}]
)");
  RunOptions options;
  options.inputs = {{"push", 25}};
  EXPECT_NEAR(value(static_equilibrium(model, options), "z"), 0.25, 1e-9);
  options.inputs = {{"pull", 25}};
  EXPECT_THROW(static_equilibrium(model, options), InputError);
}

/// What one slider's place does to the other is no instability; what they do to each other is one.
TEST(Statics, FeedforwardIsNoInstability) {
  const auto sliders = [](const std::string& back) {
    return static_equilibrium(model_of(R"(
gravity: [0, 0, 0]
bodies: {a: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}, b: {mass: 2, com: [0, 0, 1], inertia: [1, 1, 1]}}
joints:
  a: {type: prismatic, between: [ground, a], at: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 100}}
  b: {type: prismatic, between: [ground, b], at: [0, 0, 1], axis: [1, 0, 0], spring: {stiffness: 100}}
outputs: [{name: xa, joint: a}, {name: xb, joint: b}]
actuators:
  forward: {joint: b, force: 1000*xa}
  back: {joint: a, force: )" + back + "}\n"))
        .stable;
  };
  EXPECT_TRUE(sliders("5"));
  EXPECT_TRUE(sliders("-0.1*xb"));
  EXPECT_FALSE(sliders("1000*xb"));
}

TEST(Statics, CantileverBendsAsABeam) {
  const double E = 2.1e11, I = std::numbers::pi * std::pow(0.01, 4) / 4, A = std::numbers::pi * 0.01 * 0.01,
               L = 2;
  const StaticResult tip =
      static_equilibrium(model_of(cantilever("[0, 0, 0]", "loads: {push: {on: bar.tip, force: [0, 0, 3]}}")));
  EXPECT_NEAR(value(tip, "tip"), 3 * L * L * L / (3 * E * I), 1e-8);
  EXPECT_NEAR(value(tip, "wall.fz"), -3, 1e-8);

  const double weight = 7850 * A * 9.81;  // per length
  const StaticResult own = static_equilibrium(model_of(cantilever("[0, 0, -9.81]", "")));
  EXPECT_NEAR(value(own, "tip"), -weight * std::pow(L, 4) / (8 * E * I),
              1e-5 * weight * std::pow(L, 4) / (8 * E * I));
  EXPECT_NEAR(value(own, "wall.fz"), weight * L, 1e-6);
  // Positive about y turns z to x, so that the weight at +x wants to turn the bar by +y.
  EXPECT_NEAR(value(own, "wall.my"), -weight * L * L / 2, 1e-6);
}

/// From a micrometre to a metre, by the dense search and by that of large models: a beam of any kind sags by
/// w l⁴/(8 E I). A search that takes amplitudes of small bodies for nothing finds none.
TEST(Statics, BeamsOfAllSizesSag) {
  for (const double l : {1.0, 1e-2, 1e-4, 1e-6})
    for (const auto& [beam, stiffening, elements] :
         std::vector<std::tuple<const char*, const char*, int>>{{"corotational", "linear", 8},
                                                                {"corotational", "linear", 60},
                                                                {"reduced", "linear", 8},
                                                                {"reduced", "foreshortening", 8},
                                                                {"ancf_cable", "linear", 8}}) {
      SCOPED_TRACE(fmt::format("{} m, {} {} {}", l, beam, stiffening, elements));
      const auto model = model_of(fmt::format(R"(
gravity: [0, 0, -9.81]
materials: {{steel: {{young: 2.1e11, poisson: 0.3, density: 7850}}}}
sections: {{square: {{type: rectangle, width: {0:.17g}, height: {0:.17g}}}}}
bodies:
  beam:
    frame: {{at: [0, 0, 0]}}
    flexible:
      material: steel
      section: square
      nodes: {{root: [0, 0, 0], tip: [{1:.17g}, 0, 0]}}
      bars: {{bar: {{from: root, to: tip, elements: {2}}}}}
      clamped: [root]
      dynamic_modes: {3}
      beam: {4}
      stiffening: {5}
joints:
  wall: {{type: fixed, between: [ground, beam], at: [0, 0, 0]}}
outputs:
  - {{name: tip, displacement: beam.tip, relative_to: beam, component: z}}
)",
                                              0.02 * l, l, elements, beam == std::string("reduced") ? 6 : 0,
                                              beam, stiffening));
      const StaticResult found = static_equilibrium(model);
      const double h = 0.02 * l,
                   sag = -7850 * h * h * 9.81 * l * l * l * l / (8 * 2.1e11 * h * h * h * h / 12);
      EXPECT_NEAR(value(found, "tip"), sag, 1e-3 * std::abs(sag));
    }
}

TEST(Statics, FlexiblePendulumHangsStraightDown) {
  const StaticResult r = static_equilibrium(example("pendulum/flexible.yaml"));
  EXPECT_NEAR(std::remainder(value(r, "angle") - std::numbers::pi / 2, 2 * std::numbers::pi), 0, 1e-7);
  EXPECT_NEAR(value(r, "tip.z"), -1.5, 1e-7);
  EXPECT_NEAR(value(r, "tip.deflection"), 0, 1e-8);
  EXPECT_NEAR(value(r, "hinge.fz"), 7850 * std::numbers::pi / 4 * 1e-4 * 1.5 * 9.81, 1e-6);
}

TEST(Statics, DriveHoldsWithTheTorqueOfTheWeight) {
  const StaticResult r = static_equilibrium(model_of(R"(
bodies:
  bar: {mass: 2, com: [0.5, 0, 0], inertia: [0.01, 0.2, 0.2]}
joints:
  hinge: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0], drive: {position: 0.3}}
outputs:
  - {name: angle, joint: hinge}
  - {name: my, joint_force: hinge, component: my}
  - {name: fz, joint_force: hinge, component: fz}
)"));
  EXPECT_NEAR(value(r, "angle"), 0.3, 1e-10);
  EXPECT_NEAR(value(r, "my"), -2 * 9.81 * 0.5 * std::cos(0.3), 1e-7);
  EXPECT_NEAR(value(r, "fz"), 2 * 9.81, 1e-7);
}

/// The cart rolls freely: it must neither move nor spoil the solution. The pendulum on it falls until it
/// hangs.
TEST(Statics, NeutralDirectionsStayPut) {
  const StaticResult r = static_equilibrium(model_of(R"(
bodies:
  cart: {mass: 3, com: [0, 0, 0], inertia: [1, 1, 1]}
  bar: {mass: 2, com: [0.5, 0, 0], inertia: [0.01, 0.2, 0.2]}
joints:
  floor: {type: planar, between: [ground, cart], at: [0, 0, 0], axis: [0, 0, 1]}
  hinge: {type: revolute, between: [cart, bar], at: [0, 0, 0], axis: [0, 1, 0]}
outputs:
  - {name: x, position: cart, component: x}
  - {name: y, position: cart, component: y}
  - {name: yaw, yaw: cart}
  - {name: angle, joint: hinge}
)"));
  EXPECT_NEAR(value(r, "angle"), std::numbers::pi / 2, 1e-7);
  EXPECT_LT(std::abs(value(r, "x")), 2);
  EXPECT_NEAR(value(r, "y"), 0, 1e-9);
  EXPECT_NEAR(value(r, "yaw"), 0, 1e-9);
}

TEST(Statics, WithoutEquilibriumAnError) {
  EXPECT_THROW(static_equilibrium(model_of(R"(
bodies:
  stone: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
joints:
  fall: {type: prismatic, between: [ground, stone], at: [0, 0, 0], axis: [0, 0, 1]}
)")),
               std::runtime_error);
}

/// A nut of 1 kg on a screw of 20 mm, which hangs on a spring of 100 N/m: it comes down by m g/k, in nearly
/// five turns.
TEST(Statics, ScrewsAreFollowedThroughManyTurns) {
  for (const auto formulation :
       {spec::Simulation::Formulation::relative, spec::Simulation::Formulation::natural}) {
    RunOptions options;
    options.formulation = formulation;
    const StaticResult r = static_equilibrium(model_of(R"(
bodies: {nut: {mass: 1, com: [0, 0, 0], inertia: [0.001, 0.001, 0.001]}}
joints: {p: {type: cylindrical, between: [ground, nut], at: [0, 0, 0], axis: [0, 0, 1]}}
constraints: {s: {type: screw, between: [ground, nut], at: [0, 0, 0], axis: [0, 0, 1], lead: 20 mm}}
springs: {k: {between: [ground, nut], at: [[0, 0, 1], [0, 0, 0]], elastic: {stiffness: 100, zero: 1}}}
outputs: [{name: z, position: nut, component: z}, {name: turned, joint: p, component: 0}]
)"),
                                              options);
    EXPECT_NEAR(value(r, "z"), -0.0981, 1e-9);
    EXPECT_NEAR(value(r, "turned"), -0.0981 / 0.02 * 2 * std::numbers::pi, 1e-6);
  }
}

/// A moment of 40 N m against 2 N m/rad about the axis: three turns and a bit.
TEST(Statics, BushingsAreFollowedThroughManyTurns) {
  const StaticResult r = static_equilibrium(model_of(R"(
gravity: [0, 0, 0]
bodies: {a: {mass: 1, com: [0, 0, 0], inertia: [0.01, 0.02, 0.03]}}
joints: {r: {type: revolute, between: [ground, a], at: [0, 0, 0], axis: [0.6, 0, 0.8]}}
bushings: {b: {between: [ground, a], at: [0, 0, 0], x: [0.8, 0, -0.6], z: [0.6, 0, 0.8], stiffness: [1, 1, 1, 3, 3, 2]}}
loads: {l: {on: a, at: [0, 0, 0], moment: [24, 0, 32]}}
outputs: [{name: turned, joint: r}]
)"));
  EXPECT_NEAR(value(r, "turned"), 20, 1e-6);
}

/// A bead on a wave of wire of six metres, x = ½ sin 2z, that is pulled to a place beside it: three bends on,
/// where the pull is square to the wire.
TEST(Statics, ABeadComesToRestOnItsWire) {
  std::string points;
  for (int k = 0; k <= 60; ++k)
    points += fmt::format("{}[{}, 0, {}]", k > 0 ? ", " : "", 0.5 * std::sin(0.2 * k), 0.1 * k);
  for (const auto formulation :
       {spec::Simulation::Formulation::relative, spec::Simulation::Formulation::natural}) {
    RunOptions options;
    options.formulation = formulation;
    const StaticResult r = static_equilibrium(model_of(fmt::format(R"(
gravity: [0, 0, 0]
bodies: {{bead: {{mass: 1, com: [0, 0, 0], inertia: [0.01, 0.01, 0.01]}}}}
joints:
  f: {{type: planar, between: [ground, bead], at: [0, 0, 0], axis: [0, 1, 0], spring: {{coordinate: 2, stiffness: 1}}}}
constraints:
  wire: {{type: on_curve, between: [ground, bead], at: [0, 0, 0], closed: false, points: [{}]}}
springs: {{k: {{between: [ground, bead], at: [[1, 0, 5], [0, 0, 0]], elastic: {{stiffness: 30, zero: 0.1}}}}}}
outputs: [{{name: x, position: bead, component: x}}, {{name: z, position: bead, component: z}}]
)",
                                                                   points)),
                                              options);
    const double x = value(r, "x"), z = value(r, "z");
    EXPECT_NEAR(x, 0.5 * std::sin(2 * z), 1e-5);  // the wire is a spline of its points
    EXPECT_NEAR((x - 1) * std::cos(2 * z) + (z - 5), 0, 1e-3);
    EXPECT_GT(z, 4);
  }
}

TEST(Statics, ARunStartedAtEquilibriumStays) {
  const auto model = model_of(cantilever("[0, 0, -9.81]", "") + "initial: equilibrium\n");
  Simulation s(model);
  const Simulation::Snapshot before = s.save();
  EXPECT_LT(before.a.cwiseAbs().maxCoeff(), 1e-5);
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(s.step().ok());
  EXPECT_LT((s.save().q - before.q).cwiseAbs().maxCoeff(), 1e-8);
}

/// A sampled force counts as 0, and so a body that it carries falls: the error names it, and no other signal.
TEST(Statics, NamesTheSampledSignalsThatForcesFollow) {
  const auto error_of = [](const std::string& every, const std::string& force) -> std::string {
    try {
      static_equilibrium(model_of(R"(
bodies: {b: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {slide: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [0, 0, 1]}}
outputs: [{name: z, joint: slide}]
signals:
  seen: {value: z, every: 0.01}
  weight: {value: "2*9.81", every: )" +
                                  every +
                                  R"(}
  held: {pid: z, setpoint: 0, kp: 10, ki: 0, kd: 0, every: 0.01}
  smooth: {transfer_function: weight, numerator: [1], denominator: [0.01, 1]}
  both: "smooth + 0*held"
actuators: {lift: {joint: slide, force: )" +
                                  force + "}}\n"));
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  const std::string end = "; a signal without `every` acts there";
  for (const char* const force : {"weight", "smooth", "2*weight - weight"}) {
    const std::string error = error_of("0.01", force);
    EXPECT_TRUE(
        error.ends_with("; forces follow 'weight', which is sampled (`every`) and counts as 0 in an "
                        "equilibrium" +
                        end))
        << error;
  }
  EXPECT_TRUE(error_of("0.01", "both")
                  .ends_with("; forces follow 'weight', 'held', which are sampled (`every`) and count as 0 "
                             "in an equilibrium" +
                             end));
  EXPECT_TRUE(error_of("0.01", "1").find("no static equilibrium") == 0);
  EXPECT_EQ(error_of("0.01", "1").find("sampled"), std::string::npos);
}

}  // namespace
}  // namespace mimbre::test::statics_test
