#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mimbre/diagnostics.h"
#include "mimbre/simulation.h"
#include "support/models.h"
#include "support/random_mechanism.h"
#include "support/simulate.h"

/// Steps of a fixed cost: never more iterations than were allowed, never made again, never refused for it.
namespace mimbre::test::fixed_cost_test {
namespace {

using Formulation = spec::Simulation::Formulation;

RunOptions fixed(int iterations, Formulation formulation = Formulation::relative) {
  RunOptions options;
  options.fixed_cost = true;
  options.max_iterations = iterations;
  options.formulation = formulation;
  return options;
}

/// Hammers that fall on an anvil, each at another time: steps that do not converge in a few iterations.
std::shared_ptr<const Model> hammers() {
  return model_of(R"(
bodies:
  a: {mass: 1, com: [1, 0, 0], inertia: [0.01, 0.01, 0.01]}
  b: {mass: 2, com: [1.3, 0, 0], inertia: [0.01, 0.01, 0.01]}
joints:
  at_a: {type: revolute, between: [ground, a], at: [0, 0, 0], axis: [0, 1, 0], position: -0.2}
  at_b: {type: revolute, between: [ground, b], at: [0, 1, 0], axis: [0, 1, 0], position: -0.5}
surfaces:
  anvil: {type: half_space, at: [0, 0, 0]}
contacts:
  impacts:
    spheres: [{on: a, at: [[1, 0, 0]], radius: 0.05}, {on: b, at: [[1.3, 0, 0]], radius: 0.05}]
    surfaces: anvil
    stiffness: 1e5
    restitution: 0.5
simulation: {step: 0.002, end: 2}
)");
}

/// At an event the step is not made again: it happens at the end of the step that crosses.
TEST(FixedCost, EventsHappenAtTheEndOfTheStep) {
  const auto falls = model_of(R"(
bodies: {ball: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {way: {type: prismatic, between: [ground, ball], at: [0, 0, 0], axis: [0, 0, 1]}}
inputs: {lift: 0}
actuators: {engine: {joint: way, force: lift}}
outputs: [{name: z, joint: way}, {name: vz, joint_velocity: way}]
events:
  low: {when: z, crosses: -1, direction: falling, set: {lift: 19.62}}
  up: {when: z, crosses: -1, direction: rising, stop: true}
simulation: {step: 0.01, end: 5}
)");
  for (const Formulation formulation : {Formulation::relative, Formulation::natural}) {
    Simulation s(falls, fixed(6, formulation));
    EXPECT_EQ(s.most_attempts(), 1);
    while (!s.stopped() && s.time() < 5) {
      const StepReport report = s.step();
      ASSERT_TRUE(report.ok());
      EXPECT_LE(report.iterations, 6);
      EXPECT_NEAR(std::remainder(s.time(), 0.01), 0, 1e-12);
    }
    // √(2/g) = 0.4515 s: it brakes with g from the end of that step on or one later, and turns after as long
    // again.
    ASSERT_EQ(s.events()[0].count, 1);
    EXPECT_NEAR(s.events()[0].first, 0.46, 1e-12);
    ASSERT_TRUE(s.stopped());
    const auto up = [](double on) { return 2 * on + std::sqrt((9.81 * on * on - 1) * 2 / 9.81); };
    EXPECT_GE(s.time(), up(0.46));
    EXPECT_LE(s.time(), up(0.47) + 0.01);
    // The next one is a whole step.
    const double before = s.time();
    ASSERT_TRUE(s.step().ok());
    EXPECT_NEAR(s.time(), before + 0.01, 1e-12);
  }
}

TEST(FixedCost, NeverTakesMoreIterationsThanAllowed) {
  const auto drops = hammers();
  for (const Formulation formulation : {Formulation::relative, Formulation::natural})
    for (const int most : {2, 3, 6}) {
      Simulation simulation(drops, fixed(most, formulation));
      EXPECT_EQ(simulation.most_attempts(), 1);
      int unconverged = 0;
      for (int k = 0; k < 1000; ++k) {
        const StepReport report = simulation.step();
        ASSERT_TRUE(report.ok()) << simulation.explain(report);
        ASSERT_LE(report.iterations, most);
        ASSERT_EQ(report.substeps, 1);
        if (report.unconverged) ++unconverged;
      }
      if (most == 2) {
        EXPECT_GT(unconverged, 0) << most;
      }
      // They have come to rest on it, whatever the impacts were.
      EXPECT_LT(simulation.energy().kinetic, 1e-3) << most;
      EXPECT_LT(simulation.energy().numerical, 1) << most;
    }
}

/// Where all steps converge and nothing jumps it is a run without repeated steps, to the bit.
TEST(FixedCost, ConvergedStepsAreTheSame) {
  const auto model = geared_four_bar();
  RunOptions plain;
  plain.substeps = 1;
  plain.max_iterations = 30;
  Simulation a(model, plain), b(model, fixed(30));
  for (int k = 0; k < 500; ++k) {
    ASSERT_TRUE(a.step().ok());
    const StepReport report = b.step();
    ASSERT_TRUE(report.ok());
    ASSERT_FALSE(report.unconverged);
  }
  const auto x = a.save(), y = b.save();
  EXPECT_EQ(x.q, y.q);
  EXPECT_EQ(x.v, y.v);
  EXPECT_EQ(x.multipliers, y.multipliers);
}

/// A mass that an input pulls from now on, as sampled controllers do: the pull acts on it by a part of a step
/// later than it should, and by no more, and a copy from a snapshot taken in between goes on to the same
/// bits.
TEST(FixedCost, AJumpIsMetWithinItsStep) {
  const auto model = model_of(R"(
inputs: {pull: {start: 0}}
bodies:
  a: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}
joints: {slide: {type: prismatic, between: [ground, a], at: [0, 0, 0], axis: [1, 0, 0]}}
actuators: {pull: {joint: slide, force: pull}}
outputs: [{name: rate, joint_velocity: slide}]
simulation: {step: 0.01, end: 1}
)");
  Simulation simulation(model, fixed(6));
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(simulation.step().ok());
  simulation.set_input(simulation.input("pull"), 8);
  const Simulation::Snapshot snapshot = simulation.save();
  Simulation other(model, fixed(6));
  other.restore(snapshot);
  for (int k = 0; k < 20; ++k) {
    ASSERT_TRUE(simulation.step().ok() && other.step().ok());
    EXPECT_EQ(simulation.save().v, other.save().v);
  }
  const double late = 0.2 - simulation.value(simulation.channel("rate")) / 4;
  EXPECT_GT(late, 0);
  EXPECT_LT(late, 0.01);
}

/// What the iterations of a step leave is made up for in the next ones: mechanisms whose steps are no trouble
/// otherwise stay on their way with few of them. Others get through, or it is said that they do not.
TEST(FixedCost, RandomMechanismsStayOnTheirWay) {
  int unconverged = 0, easy = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    RandomOptions what;
    what.loops = static_cast<int>(seed % 3);
    what.springs = what.damping = what.loads = true;
    const RandomMechanism random = random_mechanism(seed, what);
    const Formulation formulation = seed % 2 == 0 ? Formulation::relative : Formulation::natural;
    for (const auto& [most, apart] : {std::pair(6, 1e-3), std::pair(4, 0.03)}) {
      RunOptions few = fixed(most, formulation), whole;
      whole.formulation = formulation;
      few.step = whole.step = 1e-3;
      Simulation a(random.model, whole), b(random.model, few);
      bool hard = false;
      StepReport report;
      for (int k = 0; k < 100 && report.ok(); ++k) {
        const StepReport usual = a.step();
        hard = hard || !usual.ok() || usual.substeps > 1 || usual.iterations > 10;
        report = b.step();
        ASSERT_TRUE(report.ok() || hard) << seed << ": " << b.explain(report);
        if (hard) {
          ASSERT_TRUE(b.save().q.allFinite() && b.save().v.allFinite()) << seed;
        } else {
          ASSERT_LT(report.position_violation, 1e-4) << seed;
          ASSERT_LT(report.velocity_violation, most == 6 ? 1e-6 : 1) << seed;
        }
        if (report.ok() && !report.unconverged) {
          ASSERT_LT(report.position_violation, 1e-7) << seed;
        }
        if (report.unconverged) ++unconverged;
      }
      if (hard) continue;
      ++easy;
      for (std::size_t body = 0; body < random.model->spec().bodies.size(); ++body) {
        const Simulation::Body which{static_cast<int>(body)};
        EXPECT_LT((a.pose(which).position - b.pose(which).position).norm(), apart) << seed << ", " << most;
      }
    }
  }
  EXPECT_GT(easy, 60);
  EXPECT_GT(unconverged, 200);
}

/// A pendulum of 1 kg whose brake could hold twice its weight stays where it is, and a block that slides
/// stops.
TEST(FixedCost, FrictionHolds) {
  for (const Formulation formulation : {Formulation::relative, Formulation::natural}) {
    Simulation held(model_of(R"(
bodies: {b: {mass: 1, com: [0.5, 0, 0], inertia: [0.02, 0.02, 0.02]}}
joints: {j: {type: revolute, between: [ground, b], at: [0, 0, 0], axis: [0, 1, 0]}}
frictions: {brake: {joint: j, torque: 9.81}}
outputs: [{name: q, joint: j}]
simulation: {step: 0.01, end: 5}
)"),
                    fixed(6, formulation));
    const double start = channel(held, "q");
    for (int k = 0; k < 500; ++k) ASSERT_TRUE(held.step().ok());
    EXPECT_NEAR(channel(held, "q"), start, 1e-5);

    Simulation stops(model_of(R"(
bodies: {b: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {j: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [1, 0, 0], velocity: 1}}
frictions: {floor: {joint: j, force: 5}}
outputs: [{name: q, joint: j}]
simulation: {step: 0.01, end: 2}
)"),
                     fixed(6, formulation));
    for (int k = 0; k < 200; ++k) ASSERT_TRUE(stops.step().ok());
    EXPECT_NEAR(channel(stops, "q"), 0.2, 1e-3);
  }
}

TEST(FixedCost, SaysWhatItDoesNotFit) {
  const auto model = controlled_four_bar();
  RunOptions other = fixed(6);
  other.formalism = spec::Simulation::Formalism::penalty;
  EXPECT_THAT([&] { Simulation(model, other); },
              testing::ThrowsMessage<InputError>(
                  testing::HasSubstr("formalism is penalty, but fixed_cost is of the formalism index3")));
  EXPECT_THAT([&] { Simulation(model, fixed(1)); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("two iterations")));
  const auto of = [](const std::string& words) {
    return "bodies:\n  a: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}\nsimulation: {fixed_cost: true, " +
           words + "}\n";
  };
  for (const auto& [words, said] :
       {std::pair("substeps: 4", "substeps is 4, but fixed_cost makes each step once"),
        std::pair("formalism: penalty", "fixed_cost is of the formalism index3"),
        std::pair("max_iterations: 1", "fixed_cost needs two iterations")})
    EXPECT_THAT([&] { model_of(of(words)); }, testing::ThrowsMessage<InputError>(testing::HasSubstr(said)));
  EXPECT_EQ(Simulation(model_of(of("step: 0.01")), {}).method().max_iterations, 6);
}

}  // namespace
}  // namespace mimbre::test::fixed_cost_test
