#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mimbre/diagnostics.h"
#include "mimbre/model_builder.h"
#include "mimbre/reduced_body.h"
#include "support/models.h"
#include "support/simulate.h"

/// Spheres on surfaces: impacts, sticking, sliding, rolling, spinning, edges.
namespace mimbre::test::contact_test {
namespace {

/// A ball of 1 kg and radius 0.1 at a height, thrown; `velocity`: and spin.
std::string ball(const std::string& contact, const std::string& velocity, double height,
                 const std::string& surface = "{type: half_space}", double gravity = 0) {
  return fmt::format(R"y(
gravity: [0, 0, {}]
bodies: {{ball: {{mass: 1, com: [0, 0, {}], inertia: [0.004, 0.004, 0.004]}}}}
joints: {{free: {{type: floating, between: [ground, ball], velocity: {}}}}}
surfaces: {{floor: {}}}
contacts: {{touch: {{spheres: {{on: ball, radius: 0.1}}, surfaces: floor, {}}}}}
outputs:
  - {{name: x, position: ball, component: x}}
  - {{name: z, position: ball, component: z}}
  - {{name: vx, velocity: ball, component: x}}
  - {{name: vz, velocity: ball, component: z}}
  - {{name: wx, angular_velocity: ball, component: x}}
  - {{name: wy, angular_velocity: ball, component: y}}
  - {{name: wz, angular_velocity: ball, component: z}}
simulation: {{step: 0.001, end: 1}}
)y",
                     gravity, height, velocity, surface, contact);
}

class Contact : public testing::TestWithParam<Formulation> {};

/// Five speeds, two exponents, at a step that is longer than the impact itself.
TEST_P(Contact, AnImpactGivesBackTheShareThatIsAskedFor) {
  for (const double restitution : {0.05, 0.3, 0.7, 1.0})
    for (const double speed : {0.1, 0.5, 2.0, 8.0, 30.0})
      for (const double exponent : {1.0, 1.5}) {
        const double height = 0.1 + 0.0137 * speed;
        Simulation simulation = simulation_of(
            ball(fmt::format("stiffness: 1e6, exponent: {}, restitution: {}", exponent, restitution),
                 fmt::format("[0, 0, {}, 0, 0, 0]", -speed), height),
            GetParam(), 5e-3);
        run_to(simulation, 0.05);
        // What leaves slower than 0.01 m/s is not followed to its end.
        EXPECT_NEAR(channel(simulation, "vz"), restitution * speed, 1e-2 * speed + 1e-3)
            << speed << " " << exponent;
        EXPECT_NEAR(simulation.energy().numerical, 0, 1e-2 * 0.5 * speed * speed);
      }
}

/// From sliding without spin to rolling: 5/7 of the speed is left, and stays.
TEST_P(Contact, ASlidingBallComesToRollWithFiveSeventhsOfItsSpeed) {
  const double depth = 9.81 / 1e6, friction = 0.3, speed = 2;
  Simulation simulation =
      simulation_of(ball(fmt::format("stiffness: 1e6, restitution: 0.3, friction: {}", friction),
                         fmt::format("[{}, 0, 0, 0, 0, 0]", speed), 0.1 - depth, "{type: half_space}", -9.81),
                    GetParam());
  run_to(simulation, 0.1);
  EXPECT_NEAR(channel(simulation, "vx"), speed - friction * 9.81 * 0.1, 2e-4);
  EXPECT_NEAR(channel(simulation, "wy"), 2.5 * friction * 9.81 * 0.1 / 0.1, 1e-2);
  const double slid = 0.5 * (2. / 7) * speed * speed;  // J, of ½ v²
  run_to(simulation, 0.5);
  const double rolling = channel(simulation, "vx");
  EXPECT_NEAR(rolling, 5. / 7 * speed, 2e-4);
  EXPECT_NEAR(channel(simulation, "wy"), rolling / 0.1, 5e-3);
  EXPECT_NEAR(simulation.energy().dissipated, slid, 2e-3 * slid);
  run_to(simulation, 2);
  EXPECT_NEAR(channel(simulation, "vx"), rolling, 1e-5);
  EXPECT_NEAR(simulation.energy().numerical, 0, 2e-3 * slid);
}

/// A box on spheres at its lower corners, on a slope.
std::string box_on_slope(double slope, double friction) {
  const double sine = std::sin(slope), cosine = std::cos(slope);
  // Its middle is 0.06 above the slope, the corners' centres 0.01, in depth by the weight.
  const double lift = 0.06 - 0.5e-5;
  const auto place = [&](double x, double y, double z) {
    return fmt::format("[{}, {}, {}]", cosine * x + sine * z, y, -sine * x + cosine * z);
  };
  std::string corners;
  for (const double x : {-0.1, 0.1})
    for (const double y : {-0.1, 0.1}) corners += (corners.empty() ? "" : ", ") + place(x, y, lift - 0.05);
  return fmt::format(R"y(
bodies: {{box: {{mass: 2, com: {}, inertia: [0.01, 0.01, 0.015]}}}}
surfaces: {{slope: {{type: half_space, z: [{}, 0, {}]}}}}
contacts: {{feet: {{spheres: {{on: box, at: [{}], radius: 0.01}}, surfaces: [slope], stiffness: 1e6, restitution: 0.3, friction: {}}}}}
outputs: [{{name: x, position: box, component: x}}, {{name: z, position: box, component: z}}, {{name: vx, velocity: box, component: x}}, {{name: yaw, yaw: box}}]
simulation: {{step: 0.01, end: 1}}
)y",
                     place(0, 0, lift), sine, cosine, corners, friction);
}

TEST_P(Contact, ABoxBelowTheAngleOfFrictionDoesNotCreep) {
  Simulation simulation = simulation_of(box_on_slope(std::atan(0.29), 0.3), GetParam());
  run_to(simulation, 2);
  const double x = channel(simulation, "x"), z = channel(simulation, "z"), yaw = channel(simulation, "yaw");
  EXPECT_NEAR(channel(simulation, "contact.feet.count"), 4, 0);
  EXPECT_NEAR(channel(simulation, "contact.feet.normal"), 2 * 9.81 * std::cos(std::atan(0.29)), 1e-6);
  EXPECT_NEAR(channel(simulation, "contact.feet.force.z"), 2 * 9.81, 1e-6);
  EXPECT_NEAR(channel(simulation, "contact.feet.force.x"), 0, 1e-6);
  run_to(simulation, 102);
  EXPECT_NEAR(channel(simulation, "x"), x, 1e-9);
  EXPECT_NEAR(channel(simulation, "z"), z, 1e-9);
  EXPECT_NEAR(channel(simulation, "yaw"), yaw, 1e-9);
}

TEST_P(Contact, AboveItItSlidesAsCoulombSays) {
  const double slope = std::atan(0.4), friction = 0.3;
  Simulation simulation = simulation_of(box_on_slope(slope, friction), GetParam(), 1e-3);
  run_to(simulation, 0.5);
  const double before = channel(simulation, "vx");
  run_to(simulation, 1);
  EXPECT_NEAR((channel(simulation, "vx") - before) / 0.5 / std::cos(slope),
              9.81 * (std::sin(slope) - friction * std::cos(slope)), 1e-4);
}

/// From rest, with the acceleration of the slope from the first instant: nothing holds it even there.
TEST_P(Contact, WithoutFrictionItSlidesFromTheFirstStep) {
  const double slope = 0.3;
  Simulation simulation = simulation_of(box_on_slope(slope, 0), GetParam());
  const auto along = [&] {
    return std::cos(slope) * channel(simulation, "x") - std::sin(slope) * channel(simulation, "z");
  };
  const double start = along();
  for (int k = 1; k <= 3; ++k) {
    run_to(simulation, 0.01 * k);
    EXPECT_NEAR(along() - start, 0.5 * 9.81 * std::sin(slope) * 1e-4 * k * k, 1e-10) << k;
  }
}

/// What friction cannot hold has the acceleration of what slides from the first instant, though it starts at
/// rest, where bristles stick.
TEST_P(Contact, WithTooLittleFrictionItSlidesFromTheFirstStep) {
  const double slope = 0.3, friction = 0.1;
  Simulation simulation = simulation_of(box_on_slope(slope, friction), GetParam());
  const auto along = [&] {
    return std::cos(slope) * channel(simulation, "x") - std::sin(slope) * channel(simulation, "z");
  };
  const double start = along(), a = 9.81 * (std::sin(slope) - friction * std::cos(slope));
  for (int k = 1; k <= 3; ++k) {
    run_to(simulation, 0.01 * k);
    EXPECT_NEAR(along() - start, 0.5 * a * 1e-4 * k * k, 1e-3 * 0.5 * a * 1e-4) << k;
  }
}

/// m a = −F, J α = F r − M: a = 5/7 of g times the arm by the radius. Then it rests.
/// A wedge of 10 degrees under a press of 200 N: where both of its sides rub by more than half of its angle
/// it is locked for good; where they do not it is pressed out.
TEST_P(Contact, ALockedWedgeStaysLocked) {
  const auto wedge = [&](double friction) {
    return simulation_of(fmt::format(R"y(
parameters: {{mu: {}}}
bodies:
  wedge: {{mass: 2, com: [0, 0, 0.05], inertia: [0.02, 0.02, 0.02]}}
  press: {{mass: 1, com: [0, 0, 0.3], inertia: [0.01, 0.01, 0.01]}}
joints:
  free: {{type: planar, between: [ground, wedge], at: [0, 0, 0.05], axis: [0, 1, 0]}}
  guide: {{type: prismatic, between: [ground, press], at: [0, 0, 0.3], axis: [0, 0, 1]}}
surfaces:
  floor: {{type: half_space}}
  face: {{type: half_space, on: wedge, at: [0, 0, 0.1], z: [sin(10*pi/180), 0, cos(10*pi/180)]}}
contacts:
  base: {{spheres: {{on: wedge, at: [[-0.2, 0, 0.01], [0.2, 0, 0.01]], radius: 0.01}}, surfaces: floor, stiffness: 1e6, restitution: 0.1, friction: mu}}
  tip: {{spheres: {{on: press, at: [0, 0, 0.1103], radius: 0.01}}, surfaces: face, stiffness: 1e6, restitution: 0.1, friction: mu}}
loads: {{push: {{on: press, at: [0, 0, 0.3], force: [0, 0, -200]}}}}
outputs: [{{name: x, position: wedge, component: x}}]
)y",
                                     friction),
                         GetParam(), 0.01);
  };
  Simulation locked = wedge(0.3);
  run_to(locked, 15);
  const double settled = channel(locked, "x");
  EXPECT_LT(std::abs(settled), 1e-4);
  run_to(locked, 35);
  EXPECT_NEAR(channel(locked, "x"), settled, 1e-12);
  Simulation slides = wedge(0.05);
  run_to(slides, 0.2);
  EXPECT_LT(channel(slides, "x"), -0.1);
}

TEST_P(Contact, RollingIsResisted) {
  const double depth = 9.81 / 1e6, arm = 1e-3;
  Simulation simulation =
      simulation_of(ball(fmt::format("stiffness: 1e6, restitution: 0.3, friction: 0.5, rolling: {}", arm),
                         "[0.1, 0, 0, 0, 1, 0]", 0.1 - depth, "{type: half_space}", -9.81),
                    GetParam());
  run_to(simulation, 0.1);
  const double first = channel(simulation, "vx");
  run_to(simulation, 0.6);
  EXPECT_NEAR((channel(simulation, "vx") - first) / 0.5, -5. / 7 * 9.81 * arm / 0.1, 1e-4);
  run_to(simulation, 9);  // what vibrates on the bristles has died away
  const double x = channel(simulation, "x");
  EXPECT_NEAR(channel(simulation, "vx"), 0, 1e-9);
  run_to(simulation, 10);
  EXPECT_NEAR(channel(simulation, "x"), x, 1e-9);
}

TEST_P(Contact, SpinningIsResisted) {
  const double depth = 9.81 / 1e6, arm = 1e-3;
  Simulation simulation =
      simulation_of(ball(fmt::format("stiffness: 1e6, restitution: 0.3, friction: 0.5, spinning: {}", arm),
                         "[0, 0, 0, 0, 0, 5]", 0.1 - depth, "{type: half_space}", -9.81),
                    GetParam());
  run_to(simulation, 1);
  EXPECT_NEAR(channel(simulation, "wz"), 5 - arm * 9.81 / 0.004, 1e-3);
  EXPECT_NEAR(channel(simulation, "x"), 0, 1e-9);
  run_to(simulation, 5);
  EXPECT_NEAR(channel(simulation, "wz"), 0, 1e-6);
}

/// Five pendulums in a row: the first hands its speed to the last.
TEST_P(Contact, NewtonsCradle) {
  std::string bodies, joints, spheres, outputs;
  for (int k = 0; k < 5; ++k) {
    const double x = 0.0505 * k;
    bodies += fmt::format("  b{}: {{mass: 0.5, com: [{}, 0, 0], inertia: [1e-4, 1e-4, 1e-4]}}\n", k, x);
    joints +=
        fmt::format("  j{}: {{type: revolute, between: [ground, b{}], at: [{}, 0, 1], axis: [0, -1, 0]{}}}\n",
                    k, k, x, k == 0 ? ", velocity: 1" : "");
    spheres += fmt::format("{}{{on: b{}, radius: 0.025}}", k == 0 ? "" : ", ", k);
    outputs += fmt::format("  - {{name: v{}, joint_velocity: j{}}}\n", k, k);
  }
  Simulation simulation =
      simulation_of("bodies:\n" + bodies + "joints:\n" + joints + "contacts: {cradle: {spheres: [" + spheres +
                        "], among: true, stiffness: 1e7, exponent: 1.5}}\noutputs:\n" + outputs +
                        "simulation: {step: 0.001, end: 1}\n",
                    GetParam());
  run_to(simulation, 0.02);
  EXPECT_NEAR(channel(simulation, "v4"), 1, 1e-2);
  for (const char* other : {"v0", "v1", "v2", "v3"})
    EXPECT_NEAR(channel(simulation, other), 0, 2e-2) << other;
  // The last swings and comes back, half a period later; then the first moves.
  const double first = 2 * std::acos(-1.0) * std::sqrt(1 / 9.81);
  run_to(simulation, 0.75 * first);
  EXPECT_LT(channel(simulation, "v0"), -0.05);
  EXPECT_NEAR(channel(simulation, "v4"), 0, 5e-2);
  EXPECT_NEAR(simulation.energy().numerical, 0, 1e-2 * 0.25);
}

/// In a step of 10 ms the ball goes 0.3 m, far through each of these.
TEST_P(Contact, WhatIsThinIsNotGoneThrough) {
  for (const char* surface :
       {"{type: box, size: [1, 1, 0.002]}", "{type: cylinder, z: [0, 1, 0], radius: 0.002, length: 1}",
        "{type: capsule, z: [0, 1, 0], radius: 0.002, length: 1}", "{type: sphere, radius: 0.002}",
        "{type: mesh, vertices: [[-1, -1, -1e-3], [1, -1, -1e-3], [0, 1, -1e-3], [0, 0, 0]], triangles: [[0, "
        "2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]}"}) {
    Simulation simulation = simulation_of(
        ball("stiffness: 1e6, restitution: 0.5", "[0, 0, -30, 0, 0, 0]", 1.03, surface), GetParam(), 1e-2);
    run_to(simulation, 0.1);
    EXPECT_NEAR(channel(simulation, "vz"), 15, 0.3) << surface;
    EXPECT_NEAR(channel(simulation, "vx"), 0, 1e-3) << surface;
  }
}

/// Beside an edge the ball is thrown off along the line from the edge to its centre.
TEST_P(Contact, AnEdgeBetweenTwoStepsThrowsOff) {
  // The box's upper edge is at x = 0: 0.06 beside the ball's centre, so that the normal is (0.6, 0, 0.8).
  Simulation simulation = simulation_of(ball("stiffness: 1e6", "[0.06, 0, -10, 0, 0, 0]", 1.03,
                                             "{type: box, at: [-0.56618, 0, 0], size: [1, 1, 0.2]}"),
                                        GetParam(), 1e-2);
  run_to(simulation, 0.2);
  const double x = channel(simulation, "vx"), z = channel(simulation, "vz");
  EXPECT_NEAR(x * x + z * z, 100 + 0.0036, 1);
  EXPECT_GT(x, 5);
}

/// A box of eight spheres that is thrown tumbling onto rough ground comes to rest on a face, and at no moment
/// has it more energy than before.
TEST_P(Contact, EnergyIsNeverMade) {
  const std::string text = R"y(
bodies: {box: {mass: 1, com: [0, 0, 0.6], inertia: [0.004, 0.005, 0.003]}}
joints: {free: {type: floating, between: [ground, box], velocity: [1, 0.3, 0, 3, 7, 2]}}
surfaces: {floor: {type: half_space}}
contacts:
  feet:
    spheres: {on: box, at: [[-0.1, -0.08, 0.55], [0.1, -0.08, 0.55], [-0.1, 0.08, 0.55], [0.1, 0.08, 0.55], [-0.1, -0.08, 0.65], [0.1, -0.08, 0.65], [-0.1, 0.08, 0.65], [0.1, 0.08, 0.65]], radius: 0.01}
    surfaces: floor
    stiffness: 2e5
    restitution: 0.4
    friction: 0.5
    static_ratio: 1.3
    rolling: 1e-4
    spinning: 1e-4
outputs: [{name: z, position: box, component: z}]
simulation: {step: 0.002, end: 1}
)y";
  Simulation simulation = simulation_of(text, GetParam());
  const auto total = [&] { return simulation.energy().total(); };
  double least = total();
  const double start = least;
  while (simulation.time() < 4) {
    ASSERT_TRUE(simulation.step().ok());
    EXPECT_LT(total(), least + 2e-3 * start) << simulation.time();
    least = std::min(least, total());
    EXPECT_NEAR(simulation.energy().numerical, 0, 0.02 * start) << simulation.time();
  }
  EXPECT_GT(channel(simulation, "contact.feet.count"), 3);
  EXPECT_LT(simulation.energy().kinetic, 1e-9);
}

/// A beam that is clamped at one end and lies on a stone at the other: 3/8 of its weight, and the same at
/// once as an equilibrium.
TEST_P(Contact, AFlexibleBodyCarriesSpheresAtItsNodes) {
  const auto text = [](const char* initial) {
    return fmt::format(R"y(
materials: {{steel: {{young: 2.1e11, poisson: 0.3, density: 7850}}}}
sections: {{round: {{type: round, diameter: 0.02}}}}
bodies:
  beam:
    frame: {{at: [0, 0, 0]}}
    flexible:
      material: steel
      section: round
      nodes: {{root: [0, 0, 0], tip: [1, 0, 0]}}
      bars: {{bar: {{from: root, to: tip, elements: 10}}}}
      clamped: [root]
      static_modes: [{{node: tip, along: [0, 0, 1]}}]
      dynamic_modes: 6
      stiffness_damping: 1e-3
joints: {{root: {{type: fixed, between: [ground, beam], at: [0, 0, 0]}}}}
surfaces: {{stone: {{type: sphere, at: [1, 0, -1.01], radius: 1}}}}
contacts: {{touch: {{spheres: {{on: beam.tip, radius: 0.01}}, surfaces: stone, stiffness: 1e8, restitution: 0.2}}}}
initial: {}
simulation: {{step: 0.001, end: 2}}
)y",
                       initial);
  };
  const double weight = std::acos(-1.0) / 4 * 0.02 * 0.02 * 7850 * 9.81;
  Simulation falls = simulation_of(text("assembled"), GetParam()),
             rests = simulation_of(text("equilibrium"), GetParam());
  run_to(falls, 2);
  EXPECT_NEAR(channel(falls, "contact.touch.normal"), 3. / 8 * weight, 2e-4 * weight);
  EXPECT_NEAR(channel(rests, "contact.touch.normal"), channel(falls, "contact.touch.normal"), 1e-5 * weight);
}

/// A solid part that a mesh describes, dropped: spheres at all nodes of its surface bear its weight.
TEST_P(Contact, AMeshedBodyStandsOnTheNodesOfItsSurface) {
  Simulation simulation = simulation_of(fmt::format(R"y(
bodies: {{arm: {{frame: {{at: [0, 0, 0.4]}}, reduced: {}/examples/solid-arm/arm.h5}}}}
joints: {{guide: {{type: prismatic, between: [ground, arm.front], axis: [0, 0, 1]}}}}
surfaces: {{floor: {{type: half_space}}}}
contacts: {{touch: {{spheres: {{surface_of: arm, radius: 0.005}}, surfaces: floor, stiffness: 1e5, restitution: 0.3}}}}
simulation: {{step: 0.002, end: 2}}
)y",
                                                    MIMBRE_SOURCE_DIR),
                                        GetParam());
  run_to(simulation, 2);
  EXPECT_NEAR(channel(simulation, "contact.touch.normal"),
              simulation.model().spec().bodies[0].flexible->mass * 9.81, 1e-3);
  EXPECT_GE(channel(simulation, "contact.touch.count"), 1);
  EXPECT_NEAR(simulation.energy().numerical, 0, 0.02 * simulation.energy().dissipated);
}

/// A box of 3 kg that rests on a plate of 2 kg, on four spheres, all tilted by gravity: what presses, what
/// holds, on which of the two, and the other way round what the plate feels.
TEST_P(Contact, ForcesAreOutputs) {
  Simulation simulation = simulation_of(R"y(
gravity: [2, 0, -9.81]
bodies:
  plate: {mass: 2, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}
  box: {mass: 3, com: [0, 0, 0.2], inertia: [0.02, 0.02, 0.02]}
joints:
  held: {type: fixed, between: [ground, plate]}
  free: {type: floating, between: [ground, box]}
surfaces: {top: {type: half_space, on: plate, at: [0, 0, 0]}}
contacts:
  feet:
    spheres: {on: box, at: [[0.1, 0.1, 0.021], [0.1, -0.1, 0.021], [-0.1, 0.1, 0.021], [-0.1, -0.1, 0.021]], radius: 0.02}
    surfaces: top
    stiffness: 1e5
    restitution: 0.1
    friction: 0.8
outputs:
  - {name: fx, contact_force: feet, component: x}
  - {name: fz, contact_force: feet, component: z}
  - {name: normal, contact_force: feet, component: normal}
  - {name: tangential, contact_force: feet, component: tangential}
  - {name: box.fx, contact_force: feet, on: box, component: x}
  - {name: plate.fx, contact_force: feet, on: plate, component: x}
  - {name: plate.fz, contact_force: feet, on: plate, component: z}
  - {name: plate.normal, contact_force: feet, on: plate, component: normal}
  - {name: count, contact_count: feet}
  - {name: depth, contact_depth: feet}
simulation: {step: 0.002, end: 1}
)y",
                                        GetParam());
  EXPECT_EQ(channel(simulation, "count"), 0);
  run_to(simulation, 1);
  EXPECT_NEAR(channel(simulation, "fx"), -6, 1e-2);
  EXPECT_NEAR(channel(simulation, "fz"), 3 * 9.81, 1e-2);
  EXPECT_NEAR(channel(simulation, "normal"), 3 * 9.81, 1e-2);
  // The feet may also pull against each other, as far as friction holds.
  EXPECT_GT(channel(simulation, "tangential"), 6 - 1e-2);
  EXPECT_LT(channel(simulation, "tangential"), 0.8 * 3 * 9.81);
  EXPECT_EQ(channel(simulation, "box.fx"), channel(simulation, "fx"));
  EXPECT_EQ(channel(simulation, "plate.fx"), -channel(simulation, "fx"));
  EXPECT_EQ(channel(simulation, "plate.fz"), -channel(simulation, "fz"));
  EXPECT_EQ(channel(simulation, "plate.normal"), channel(simulation, "normal"));
  EXPECT_EQ(channel(simulation, "count"), 4);
  // The centre of mass is 0.2 m high, the feet 0.1 m to its sides.
  const double deepest = 0.25 * 3 * 9.81 + 6 * 0.2 / 0.4;
  EXPECT_NEAR(channel(simulation, "depth"), deepest / 1e5, 1e-6);
  EXPECT_EQ(channel(simulation, "contact.feet.normal"), channel(simulation, "normal"));
}

/// A finger presses harder and harder on a wall, until an event feels 20 N; a controller feels it at
/// instants.
TEST_P(Contact, AFingerFeelsWhatItTouches) {
  Simulation simulation = simulation_of(R"y(
gravity: [0, 0, 0]
bodies: {finger: {mass: 0.5, com: [0, 0, 0], inertia: [0.01, 0.01, 0.01]}}
joints: {guide: {type: prismatic, between: [ground, finger], at: [0, 0, 0], axis: [1, 0, 0]}}
actuators: {push: {joint: guide, force: "10*t - 40*rate"}}
surfaces: {wall: {type: half_space, at: [0.06, 0, 0], z: [-1, 0, 0]}}
contacts: {tip: {spheres: {on: finger, radius: 0.05}, surfaces: wall, stiffness: 1e5, restitution: 0.2}}
outputs:
  - {name: grip, contact_force: tip, component: normal}
  - {name: rate, joint_velocity: guide}
  - {name: touches, contact_count: tip}
signals: {felt: {value: grip, every: 0.01}}
events:
  meets: {when: touches, crosses: 0.5, direction: rising}
  firm: {when: grip, crosses: 20, stop: true}
simulation: {step: 0.005, end: 3}
)y",
                                        GetParam());
  double before = 0;
  while (!simulation.stopped() && simulation.time() < 3) {
    if (std::abs(std::remainder(simulation.time(), 0.01)) < 1e-9) before = channel(simulation, "grip");
    ASSERT_TRUE(simulation.step().ok());
  }
  ASSERT_TRUE(simulation.stopped());
  EXPECT_NEAR(simulation.time(), 2, 2e-3);  // behind the force by m and d over k
  EXPECT_NEAR(channel(simulation, "grip"), 20, 1e-4);
  EXPECT_EQ(channel(simulation, "signal.felt"), before);
  EXPECT_EQ(simulation.events()[0].count, 1);
  EXPECT_LT(simulation.events()[0].first, 0.5);
}

INSTANTIATE_TEST_SUITE_P(Both, Contact, testing::Values(Formulation::relative, Formulation::natural));

TEST(ContactFormulations, Agree) {
  Simulation relative = simulation_of(die_and_ball(), Formulation::relative),
             natural = simulation_of(die_and_ball(), Formulation::natural);
  run_to(relative, 1);
  run_to(natural, 1);
  for (const char* name : {"height", "contact.corners.normal", "contact.round.force.x"})
    EXPECT_NEAR(channel(relative, name), channel(natural, name),
                1e-4 * (1 + std::abs(channel(relative, name))))
        << name;
}

/// The builder makes what a file does.
TEST(ContactBuilder, BuildsWhatAFileSays) {
  ModelBuilder m;
  m.set_gravity({0, 0, -9.81});
  m.add_body("ball", {.mass = 1, .com = {0, 0, 0.3}, .inertia = build::inertia(0.004, 0.004, 0.004)});
  m.add_joint("free", {.type = spec::JointType::floating,
                       .between = {"ground", "ball"},
                       .velocity = {2., 0., 0., 0., 0., 0.}});
  m.add_surface("floor", {.kind = "box", .size = {10, 10, 0.1}});
  m.add_contact("touch", {.spheres = {{.on = "ball", .radius = 0.1}},
                          .surfaces = {"floor"},
                          .stiffness = 1e5,
                          .restitution = 0.5,
                          .friction = 0.3});
  m.add_output("x", {.kind = "position", .of = "ball", .component = "x"});
  m.add_output("grip", {.kind = "contact_force", .of = "touch", .component = "tangential", .on = "ball"});
  EXPECT_THROW(m.add_output("x2", {.kind = "position", .of = "ball", .component = "x", .on = "ball"}),
               InputError);
  EXPECT_THROW(m.add_output("grip2", {.kind = "contact_force", .of = "touch"}), InputError);
  EXPECT_THROW(m.add_output("depth", {.kind = "contact_depth", .of = "touch", .component = "x"}), InputError);
  Simulation built = simulation_of(m.compile(), Formulation::relative, 1e-3),
             read = simulation_of(ball("stiffness: 1e5, restitution: 0.5, friction: 0.3",
                                       "[2, 0, 0, 0, 0, 0]", 0.3, "{type: box, size: [10, 10, 0.1]}", -9.81),
                                  Formulation::relative, 1e-3);
  run_to(built, 1);
  run_to(read, 1);
  EXPECT_EQ(channel(built, "x"), channel(read, "x"));
  EXPECT_NEAR(channel(built, "grip"), 0, 1e-9);  // it rolls
  EXPECT_THROW(m.add_contact("other", {.spheres = {{.on = "ball", .radius = 0.1}}, .surfaces = {"flor"}}),
               InputError);
  EXPECT_THROW(m.add_surface("bad", {.on = "bal"}), InputError);
}

/// The block of the file, 1 by 2 by 3 m from its corner, is the box of that size; also mirrored.
TEST(ContactFile, AMeshMayBeThatOfAFile) {
  const std::string file = std::string(MIMBRE_SOURCE_DIR) + "/tests/data/surfaces/block.stl";
  const auto dropped = [](const std::string& surface) {
    Simulation simulation = simulation_of(
        ball("stiffness: 1e5, restitution: 0.5, friction: 0.3", "[0.3, 0, 0, 0, 0, 0]", 0.2, surface, -9.81),
        Formulation::relative);
    run_to(simulation, 0.6);
    return Eigen::Vector2d(channel(simulation, "x"), channel(simulation, "z"));
  };
  const Eigen::Vector2d box = dropped("{type: box, at: [0.1, 0, -0.6], size: [0.4, 0.8, 1.2]}");
  EXPECT_GT(box[1], 0);
  for (const auto& [at, scale] :
       {std::pair("[-0.1, -0.4, -1.2]", "0.4"), std::pair("[0.3, -0.4, -1.2]", "[-0.4, 0.4, 0.4]")}) {
    const Eigen::Vector2d mesh =
        dropped(fmt::format("{{type: mesh, at: {}, file: {}, scale: {}}}", at, file, scale));
    EXPECT_LT((mesh - box).norm(), 1e-6) << scale;
  }
  EXPECT_THROW(dropped("{type: mesh, file: nowhere.stl}"), InputError);
}

TEST(ContactFile, WhatIsWrongIsTold) {
  const auto said = [](const std::string& contact, const std::string& surface = "{type: half_space}") {
    try {
      model_of(ball(contact, "[0, 0, 0, 0, 0, 0]", 1, surface));
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  const auto says = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_EQ(said("stiffness: 1e5"), "nothing");
  EXPECT_TRUE(says(said("restitution: 0.5"), "'stiffness' is missing")) << said("restitution: 0.5");
  EXPECT_TRUE(says(said("stiffness: 1e5, friction: -1"), "cannot be below 0"));
  EXPECT_TRUE(says(said("stiffness: 1e5, frction: 1"), "friction"));
  EXPECT_TRUE(says(said("stiffness: 1e5", "{type: box}"), "size"));
  EXPECT_TRUE(says(said("stiffness: 1e5", "{type: bx, size: [1, 1, 1]}"), "box"));
  EXPECT_TRUE(says(said("stiffness: 1e5", "{type: sphere, radius: 1, size: [1, 1, 1]}"), "size"));
  EXPECT_TRUE(says(said("stiffness: 1e5", "{type: heights, spacing: [1, 1], heights: [[0, 1], [2, 3, 4]]}"),
                   "first row"));
  EXPECT_TRUE(
      says(said("stiffness: 1e5", "{type: heights, spacing: [0, 1], heights: [[0, 1], [2, 3]]}"), "spacing"));
  EXPECT_TRUE(says(said("stiffness: 1e5",
                        "{type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles: [[0, 1, 2]]}"),
                   "closed"));
}

}  // namespace
}  // namespace mimbre::test::contact_test
