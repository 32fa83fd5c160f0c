#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "mimbre/simulation.h"
#include "support/models.h"
#include "support/random_elements.h"
#include "support/simulate.h"

/// What the energy balance books of forces is what they do, also where they jump.
namespace mimbre::test::booked_work_test {
namespace {

using Rule = spec::Simulation::Integrator;
using testing::IsEmpty;

struct Case {
  Rule rule;
  Formulation formulation;
};
void PrintTo(const Case& c, std::ostream* out) {
  *out << (c.rule == Rule::conserve ? "conserve" : "default")
       << (c.formulation == Formulation::natural ? "_natural" : "_relative");
}

class BookedWork : public testing::TestWithParam<Case> {
 protected:
  /// Natural coordinates turn by unit vectors: an angle has the rule's error, of second order.
  static double close(double exactly, double by_rule) {
    return GetParam().formulation == Formulation::natural ? by_rule : exactly;
  }
  Simulation simulation(const std::string& text, double step = 0) const {
    RunOptions options;
    options.formulation = GetParam().formulation;
    if (GetParam().rule == Rule::conserve) options.integrator = Rule::conserve;
    options.energies = true;
    if (step > 0) options.step = step;
    return Simulation(model_of(text), options);
  }
};

/// A torque of 2 N m about the global z on a body that tumbles: Lz grows by 2 N m s/s, and the work is the
/// gain of kinetic energy.
TEST_P(BookedWork, ATorqueAboutAnAxisOfATumblingBody) {
  Simulation s = simulation(R"(
gravity: [0, 0, 0]
bodies: {b: {mass: 1, com: [0, 0, 0], inertia: [1, 2, 3]}}
joints: {f: {type: floating, between: [ground, b], at: [0, 0, 0], velocity: [0, 0, 0, 1.0, 2.0, 0.5]}}
actuators: {g: {between: [ground, b], at: [0, 0, 0], about: [0, 0, 1], torque: "2.0"}}
outputs:
  - {name: wz, angular_velocity: b, component: z}
  - {name: Lz, angular_momentum: b, component: z}
  - {name: Lx, angular_momentum: b, component: x}
simulation: {step: 0.0005, end: 1}
)");
  // ∫ 2 ωz dt by Simpson's rule over pairs of steps.
  double work = 0, before = channel(s, "wz");
  while (s.time() < 1 - 1e-9) {
    ASSERT_TRUE(s.step().ok());
    const double middle = channel(s, "wz");
    ASSERT_TRUE(s.step().ok());
    const double after = channel(s, "wz");
    work += 2 * 0.001 / 6 * (before + 4 * middle + after);
    before = after;
  }
  EXPECT_NEAR(s.energy().load_work, work, close(1e-6, 1e-5));
  EXPECT_NEAR(work, 2.51, 0.01);
  EXPECT_NEAR(channel(s, "Lz"), 1.5 + 2, close(2e-6, 1e-5));
  EXPECT_NEAR(channel(s, "Lx"), 1, close(2e-6, 1e-5));
  EXPECT_NEAR(s.energy().numerical, 0, close(1e-6, 1e-5));
  EXPECT_THAT(s.warnings(), IsEmpty());
}

/// A hinge of 1 kg m² under torques that are constant from one jump to the next.
struct Hinge {
  double angle = 0, rate = 0;
  void turn(double torque, double time) {
    angle += rate * time + 0.5 * torque * time * time;
    rate += torque * time;
  }
};
constexpr const char* hinge = R"(
gravity: [0, 0, 0]
bodies: {b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {j: {type: revolute, between: [ground, b], at: [0, 0, 0], axis: [0, 0, 1]}}
actuators: {m: {joint: j, torque: u}}
outputs: [{name: a, joint: j}, {name: w, joint_velocity: j}]
)";

TEST_P(BookedWork, AnEventThatTurnsATorqueRound) {
  Simulation s = simulation(std::string(hinge) +
                            "inputs: {u: 1}\nevents: {e: {when: t, crosses: 0.5, set: {u: -1}}}\n"
                            "simulation: {step: 0.01, end: 1}\n");
  run_to(s, 0.5);
  EXPECT_NEAR(s.energy().load_work, 0.125, close(1e-7, 1e-5));
  run_to(s, 1);
  // The event is found 1e-9 s behind.
  EXPECT_NEAR(channel(s, "a"), 0.25, close(1e-8, 1e-5));
  EXPECT_NEAR(s.energy().load_work, 0, close(1e-8, 1e-5));
  EXPECT_NEAR(s.energy().numerical, 0, close(1e-10, 1e-5));
}

TEST_P(BookedWork, ASampledController) {
  Simulation s =
      simulation(std::string(hinge) +
                 "signals: {u: {value: \"sin(20*t)\", every: 0.02}}\nsimulation: {step: 0.002, end: 1}\n");
  Hinge exact;
  for (int k = 0; k < 50; ++k) {
    exact.turn(std::sin(20 * 0.02 * k), 0.02);
    run_to(s, 0.02 * (k + 1));
    ASSERT_NEAR(channel(s, "a"), exact.angle, close(1e-9, 1e-6)) << k;
    ASSERT_NEAR(s.energy().load_work, 0.5 * exact.rate * exact.rate, close(1e-9, 1e-6)) << k;
  }
  EXPECT_NEAR(exact.angle, 0.0468, 1e-4);
}

TEST_P(BookedWork, AnInputThatJumps) {
  Simulation s = simulation(std::string(hinge) + "inputs: {u: 0}\nsimulation: {step: 0.01, end: 1}\n");
  Hinge exact;
  const int u = s.input("u");
  for (int k = 0; k < 20; ++k) {
    const double torque = std::sin(1 + 14.3 * 0.05 * k);
    s.set_input(u, torque);
    exact.turn(torque, 0.05);
    run_to(s, 0.05 * (k + 1));
    ASSERT_NEAR(channel(s, "a"), exact.angle, close(1e-9, 1e-6)) << k;
    ASSERT_NEAR(s.energy().load_work, 0.5 * exact.rate * exact.rate, close(1e-9, 1e-6)) << k;
  }
}

/// Before the first step, too.
TEST_P(BookedWork, AnInputThatIsSetAtTheStart) {
  Simulation s = simulation(std::string(hinge) + "inputs: {u: -3}\nsimulation: {step: 0.01, end: 1}\n");
  s.set_input(s.input("u"), 2);
  run_to(s, 1);
  EXPECT_NEAR(channel(s, "a"), 1, close(1e-9, 3e-4));
  EXPECT_NEAR(s.energy().load_work, 2, close(1e-9, 6e-4));
}

/// A mass that a drive moves at 0.5 m/s against loads: the drive does what they take. One grows to 1 N in the
/// very step that begins anew since the other is sampled, which jumps to 3 N later.
TEST_P(BookedWork, ADriveAgainstLoadsThatJumpAndGrowInStepsThatBeginAnew) {
  for (const double step : {0.01, 0.002}) {
    Simulation s = simulation(R"(
gravity: [0, 0, 0]
inputs: {w: {start: 0, hold: linear}}
signals: {s: {value: "t > 0.15 ? 3 : 1e-9*t", every: 0.02
  }
}
bodies : {
b : {
mass:
  2, com : [ 0, 0, 0 ], inertia : [ 1, 1, 1 ]
}
}
joints : {
j : {
type:
  prismatic, between : [ ground, b ], at : [ 0, 0, 0 ], axis : [ 0, 0, 1 ], drive : {
  position:
    "0.5*t"
  }
}
}
loads : {
f : {
on:
  b, at : [ 0, 0, 0 ], force : [ 0, 0, -1 ], scale : w + s
}
}
simulation: {step: 0.01}
)",
                              step);
    run_to(s, 0.1);
    s.set_input(s.input("w"), 1);
    run_to(s, 0.2);
    const double work = 0.5 * (0.5 * step + (0.1 - step) + 3 * 0.04);
    EXPECT_NEAR(s.energy().load_work, -work, 1e-8);
    EXPECT_NEAR(s.energy().drive_work, work, 1e-8);
    EXPECT_NEAR(s.energy().numerical, 0, 1e-8);
  }
}

/// A drive past an event: what that leaves of the step, 85 µs, has whole multiples beside the end of the
/// step, none of which the time may move to.
TEST_P(BookedWork, ADrivePastAnEvent) {
  Simulation s = simulation(R"(
gravity: [1, 2, 3]
inputs: {u: 0.7}
bodies: {b: {mass: 0.7, com: [0.3, 0.1, 0], inertia: [0.05, 0.05, 0.07]}}
joints: {j: {type: revolute, between: [ground, b], at: [0, 0, 0], axis: [0, 0, 1], drive: {position: 0.3*sin(6*t)}}}
actuators: {m: {joint: j, torque: u}}
events: {e: {when: t, crosses: 0.28679, set: {u: -0.9}}}
outputs: [{name: a, joint_acceleration: j}]
simulation: {step: 1.25e-4}
)");
  while (s.time() < 0.2875) {
    ASSERT_TRUE(s.step().ok());
    ASSERT_NEAR(channel(s, "a"), -36 * 0.3 * std::sin(6 * s.time()), 2e-5) << s.time();
  }
  EXPECT_NEAR(s.energy().numerical, 0, 2e-8);
}

/// A beam that is pushed along itself as it swings: its inertia stiffens it, and jumps with the push.
TEST_P(BookedWork, LoadsOfInertiaThatJump) {
  std::vector<double> left;
  for (const double step : {5e-4, 1.25e-4}) {
    Simulation s = simulation(R"(
gravity: [0, 0, -2]
inputs: {u: 1}
materials: {soft: {young: 2e7, poisson: 0.3, density: 2700}}
sections: {thin: {area: 4e-4, Iy: 2e-7, Iz: 2e-7, J: 4e-7}}
bodies:
  base: {mass: 1, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: soft
      section: thin
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {beam: {from: root, to: tip, elements: 8}}
      clamped: [root]
      dynamic_modes: 4
      stiffening: geometric_stiffness
joints:
  slide: {type: prismatic, between: [ground, base], at: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 500}}
  hub: {type: revolute, between: [base, beam], at: [0, 0, 0], axis: [0, 1, 0], velocity: -3}
actuators: {m: {joint: slide, force: "8*u"}}
events: {e: {when: t, crosses: 0.313, set: {u: -0.8}}}
simulation: {step: 0.001}
)",
                              step);
    double most = 0, play = 0;
    while (s.time() < 0.8 - 1e-9) {
      if (std::abs(s.time() - 0.6) < 0.1 * step) s.set_input(s.input("u"), 0.9);
      const StepReport report = s.step();
      ASSERT_TRUE(report.ok()) << s.explain(report);
      most = std::max(most, std::abs(s.energy().numerical));
      play = std::max(play, s.energy().kinetic);
    }
    left.push_back(most / play);
  }
  EXPECT_LT(left[1], 1e-6);
  // `conserve` leaves nothing.
  EXPECT_GT(left[0], left[1] < 1e-10 ? 0 : 14 * left[1]);
}

/// Likewise in a loop: its accelerations are projected onto the constraints after a step, but its inertia has
/// stiffened the beam by those before.
TEST_P(BookedWork, LoadsOfInertiaInALoop) {
  std::vector<double> left;
  for (const double step : {2.5e-4, 1.25e-4, 6.25e-5}) {
    Simulation s = simulation(R"(
gravity: [0, 0, -2]
materials: {soft: {young: 2e8, poisson: 0.3, density: 2700}}
sections: {thin: {area: 4e-4, Iy: 2e-7, Iz: 2e-7, J: 4e-7}}
bodies:
  base: {mass: 2, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}
  link: {mass: 0.3, com: [1.2, 0, 0.2], inertia: [0.01, 0.01, 0.01]}
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: soft
      section: thin
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {beam: {from: root, to: tip, elements: 8}}
      clamped: [root]
      static_modes: [{node: tip, along: [0, 0, 1]}, {node: tip, along: [1, 0, 0]}]
      dynamic_modes: 4
      stiffness_damping: 2e-3
      stiffening: geometric_stiffness
joints:
  slide: {type: prismatic, between: [ground, base], at: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 500}}
  hub: {type: revolute, between: [base, beam], at: [0, 0, 0], axis: [0, 1, 0], velocity: -1}
  pin: {type: revolute, between: [beam, link], at: [1, 0, 0], axis: [0, 1, 0]}
  anchor: {type: spherical, between: [link, ground], at: [1.4, 0, 0.4]}
loads: {push: {on: base, at: [0, 0, 0], force: [8, 0, 0], scale: 'sin(5*t)'}}
simulation: {step: 0.001, integrator: {type: newmark, xi: 0}}
)",
                              step);
    while (s.time() < 0.4 - 1e-9) {
      const StepReport report = s.step();
      ASSERT_TRUE(report.ok()) << s.explain(report);
    }
    left.push_back(std::abs(s.energy().numerical));
  }
  // `conserve` leaves nothing.
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_GT(left[k], left[k + 1] < 1e-11 ? 0 : 3.9 * left[k + 1]);
    EXPECT_LT(left[k], left[k + 1] < 1e-11 ? 1e-10 : 4.2 * left[k + 1]);
  }
}

/// A load, a winch, wind, a motor, a spring with a tunable rate and a road, all of which jump on a moving
/// mass: the balance holds to the order of the rule.
TEST_P(BookedWork, WhateverJumps) {
  for (const char* const element :
       {"loads: {f: {on: b, at: [0, 0, 0.3], force: [3, 1, 2], moment: [0, 1, 0], scale: u}}",
        "cables: {c: {over: [ground, b], at: [[0, 0, 2], [0, 0, 0.2]], axial_stiffness: 40, damping: 0.4, "
        "length: "
        "\"1.6 - 0.1*u\"}}",
        "drags: {d: {on: b, at: [0, 0, 0.3], area: 1, coefficients: [1, 1, 1], wind: [\"3*u\", 0, 0]}}",
        "motors: {m: {joint: j, ratio: 3, constant: 0.3, resistance: 1, voltage: \"4*u\", inertia: 0.01}}",
        "springs: {s: {between: [ground, b], at: [[0, 0.5, 0.8], [0, 0, 0.4]], force: \"(20 + 8*u)*(l - "
        "0.4)\"}}",
        "frictions: {f: {joint: j, torque: \"0.5*(1.3 + u)\", sticking: 0.01, settling: 0.01}}",
        "roads: {r: {over: time, height: \"0.05*u\"}}\ntyres: {t: {on: b, at: [0, 0, 0.2], road: r, "
        "stiffness: 300, "
        "radius: 0.3}}"}) {
    const std::string text = fmt::format(R"(
gravity: [0, 0, -2]
inputs: {{u: 0.2}}
bodies: {{b: {{mass: 1, com: [0.1, 0, 0.3], inertia: [0.1, 0.1, 0.1]}}}}
joints:
  j: {{type: revolute, between: [ground, b], at: [0, 0, 0], axis: [1, 0.2, 0], velocity: 2, spring: {{stiffness: 3}}}}
{}
events: {{e: {{when: t, crosses: 0.313, set: {{u: -0.8}}}}}}
simulation: {{step: 0.001}}
)",
                                         element);
    double coarse = 0, play = 0;
    for (const double step : {4e-3, 1e-3}) {
      Simulation s = simulation(text, step);
      double most = 0;
      for (int k = 0; s.time() < 1 - 1e-9; ++k) {
        if (std::abs(s.time() - 0.6) < 0.1 * step) s.set_input(s.input("u"), 0.9);
        const StepReport report = s.step();
        ASSERT_TRUE(report.ok()) << s.explain(report);
        most = std::max(most, std::abs(s.energy().numerical));
        play = std::max(play, s.energy().kinetic);
      }
      if (coarse == 0) coarse = most;
      if (step > 1e-3) continue;
      EXPECT_LT(most, 5e-5 * play) << element;
      if (coarse > 1e-9 * play) {
        EXPECT_GT(coarse / most, 8) << element;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, BookedWork,
                         testing::Values(Case{Rule::generalized_alpha, Formulation::relative},
                                         Case{Rule::generalized_alpha, Formulation::natural},
                                         Case{Rule::conserve, Formulation::relative},
                                         Case{Rule::conserve, Formulation::natural}),
                         testing::PrintToStringParamName());

/// Two bodies in space and a spring between them, which the step hardly resolves: `conserve` gives back the
/// energy that the rule takes, and not at the cost of their momentum.
TEST(BookedWork, ConserveKeepsTheMomentumOfBodiesThatSpringsTie) {
  for (const Formulation formulation : {Formulation::relative, Formulation::natural}) {
    RunOptions options;
    options.formulation = formulation;
    options.integrator = Rule::conserve;
    Simulation s(model_of(R"(
gravity: [0, 0, 0]
bodies:
  a: {mass: 1, com: [0, 0, 0], inertia: [0.1, 0.2, 0.1]}
  b: {mass: 2, com: [1, 0, 0], inertia: [0.2, 0.2, 0.1]}
joints:
  a: {type: floating, between: [ground, a], at: [0, 0, 0], velocity: [1, 0.5, 0, 0, 0, 1]}
  b: {type: floating, between: [ground, b], at: [1, 0, 0], velocity: [-2, 0.5, 1, 0, 2, 0]}
springs: {s: {between: [a, b], at: [[0, 0.1, 0], [1, 0, 0.2]], elastic: {stiffness: 300, zero: 1}}}
outputs:
  - {name: px, linear_momentum: all, component: x}
  - {name: py, linear_momentum: all, component: y}
  - {name: pz, linear_momentum: all, component: z}
  - {name: Lx, angular_momentum: all, component: x}
  - {name: Ly, angular_momentum: all, component: y}
  - {name: Lz, angular_momentum: all, component: z}
simulation: {step: 0.02}
)"),
                 options);
    const char* const names[] = {"px", "py", "pz", "Lx", "Ly", "Lz"};
    double start[6];
    for (int k = 0; k < 6; ++k) start[k] = channel(s, names[k]);
    double energy = s.energy().total();
    run_to(s, 10);
    EXPECT_NEAR(s.energy().total(), energy, 1e-6 * energy);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(channel(s, names[k]), start[k], 1e-6) << names[k];
    for (int k = 3; k < 6; ++k) EXPECT_NEAR(channel(s, names[k]), start[k], 2e-2) << names[k];
  }
}

}  // namespace
}  // namespace mimbre::test::booked_work_test
