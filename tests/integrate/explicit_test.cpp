#include "integrate/explicit/explicit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/dense.h"
#include "support/models.h"
#include "support/probe.h"
#include "support/random_mechanism.h"
#include "support/run.h"
#include "support/simulate.h"
#include "support/smooth_mechanisms.h"

/// Explicit integrators.
namespace mimbre::test::explicit_test {
namespace {

using Rule = spec::Simulation::Integrator;

RandomOptions smooth_tree() {
  RandomOptions o;
  o.springs = o.damping = o.loads = true;
  return o;
}

/// ẋ by finite differences of the motion from exp(x): q(x(t)) moves with v.
TEST(IncrementRate, FollowsTheVelocities) {
  const auto model = model_of(R"(
bodies:
  top: {mass: 3, com: [0.1, 0.05, 0.4], inertia: [0.1, 0.12, 0.06]}
joints:
  ball: {type: spherical, between: [ground, top], at: [0, 0, 0]}
)");
  relative::RelativeSystem system(model->compiled());
  VectorXd start(4);
  start << 0.5, 0.5, -0.5, 0.5;
  for (const double size : {1e-3, 0.1, 0.25, 0.35, 1.0, 2.5}) {
    const Eigen::Vector3d x = size * Eigen::Vector3d(0.48, -0.6, 0.64), v(0.7, 1.1, -0.4);
    Eigen::Vector3d rate;
    system.increment_rate(x.data(), v.data(), rate.data());
    const double h = 1e-5;
    const auto moved = [&](double t) {  // q(x + t ẋ), and q(x) then turned by t v
      const Eigen::Vector3d there = x + t * rate, turn = t * v;
      VectorXd by_increment(4), by_velocity(4);
      system.retract(start.data(), there.data(), by_increment.data());
      system.retract(start.data(), x.data(), by_velocity.data());
      system.retract(by_velocity.data(), turn.data(), by_velocity.data());
      return VectorXd(by_increment - by_velocity);
    };
    EXPECT_LE(((moved(h) - moved(-h)) / (2 * h)).norm(), 1e-9) << size;
  }
}

class ExplicitOrder : public testing::TestWithParam<std::tuple<SmoothMechanism, Formulation>> {
 protected:
  double order_of(Rule rule, int steps) const {
    const auto& [problem, formulation] = GetParam();
    const auto model = model_of(problem.text);
    VectorXd runs[3];
    for (int k = 0; k < 3; ++k) {
      RunOptions options = options_of(rule, problem.end / (steps << k));
      options.formulation = formulation;
      runs[k] = run_with(model, options, problem.end);
    }
    return order(runs[0], runs[1], runs[2]);
  }
};

TEST_P(ExplicitOrder, OfRungeKuttaIsFour) {
  EXPECT_NEAR(order_of(Rule::rk4, std::get<0>(GetParam()).steps_of_rk4), 4.2, 0.7);
}

TEST_P(ExplicitOrder, OfDormandAndPrinceIsEight) {
  EXPECT_GE(order_of(Rule::dopri853, std::get<0>(GetParam()).steps_of_dopri853), 7.2);
}

/// The error of a run follows the accuracy, whatever the step; both formulations have the same motion.
TEST_P(ExplicitOrder, ErrorsFollowTheAccuracy) {
  const auto& [problem, formulation] = GetParam();
  const auto model = model_of(problem.text);
  const auto run_of = [&](double accuracy, double step) {
    RunOptions options = options_of(Rule::dopri853, step, accuracy);
    options.formulation = formulation;
    Simulation simulation(model, options);
    run_to(simulation, problem.end);
    const spec::Pose pose = simulation.pose(Simulation::Body{0});
    VectorXd seen(12);
    seen << pose.position, pose.rotation.reshaped();
    return seen;
  };
  const VectorXd exact = run_of(1e-13, problem.end / 10);
  double last = 1;
  for (const double accuracy : {1e-4, 1e-6, 1e-8, 1e-10}) {
    const double error = (run_of(accuracy, problem.end) - exact).norm();
    EXPECT_LE(error, 100 * accuracy) << accuracy;
    EXPECT_LE(error, last) << accuracy;
    last = error + 1e-13;
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, ExplicitOrder,
                         testing::Combine(testing::ValuesIn(smooth_mechanisms()),
                                          testing::Values(Formulation::relative, Formulation::natural)),
                         [](const auto& row) {
                           return std::string(std::get<0>(row.param).name) +
                                  (std::get<1>(row.param) == Formulation::relative ? "_relative"
                                                                                   : "_natural");
                         });

/// The same motion as by the implicit rule, extrapolated from two of its steps, of random trees and loops
/// with springs, dampers and drives.
TEST(Explicit, MovesRandomMechanismsAsTheImplicitRuleDoes) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    RandomOptions options = smooth_tree();
    options.loops = static_cast<int>(seed % 3);
    options.flexible_share = 0;
    options.drives = options.loops == 0;
    const RandomMechanism mechanism = random_mechanism(seed, options);
    const double end = 0.1;
    const auto implicitly = [&](double step) {
      RunOptions by = options_of(Rule::generalized_alpha, step);
      by.rho = 1;
      by.tolerance = 1e-9;
      return run_with(mechanism.model, by, end);
    };
    const VectorXd coarse = implicitly(5e-4), fine = implicitly(2.5e-4);
    const VectorXd exact = fine + (fine - coarse) / 3;
    const VectorXd explicitly = run_with(mechanism.model, options_of(Rule::dopri853, 1e-3, 1e-11), end);
    EXPECT_LE((explicitly - exact).norm(), 1e-9 * exact.norm() + 0.02 * (fine - exact).norm()) << seed;
  }
}

/// A conservative mechanism keeps its energy to the accuracy, and a hundred times better with one a hundred
/// times as small.
TEST(Explicit, EnergyDriftFollowsTheAccuracy) {
  const auto model = model_of(smooth_mechanisms()[1].text);
  const auto drift = [&](double accuracy) {
    RunOptions options = options_of(Rule::dopri853, 0.5, accuracy);
    options.energies = true;
    Simulation simulation(model, options);
    run_to(simulation, 50);
    return std::abs(simulation.energy().numerical) / 30;  // J, of about 30 J at play
  };
  EXPECT_LE(drift(1e-8), 1e-6);
  EXPECT_LE(drift(1e-11), 1e-9);
}

const char* const oscillator = R"(
gravity: [0, 0, 0]
bodies:
  mass: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}
joints:
  slide: {type: prismatic, between: [ground, mass], at: [0, 0, 0], axis: [1, 0, 0], position: 0.1, spring: {stiffness: 2e6}}
)";

/// Of ω = 1000 rad/s: rk4 is stable for ω h up to 2.83, dopri853 up to 5.97, and says so beyond.
TEST(Explicit, FailsWhereTheStepIsUnstable) {
  const auto model = model_of(oscillator);
  for (const auto& [rule, stable, unstable, limit] : {std::tuple(Rule::rk4, 2.5e-3, 3.5e-3, "2.8e-03"),
                                                      std::tuple(Rule::dopri853, 5e-3, 7e-3, "5.9e-03")}) {
    run_with(model, options_of(rule, stable), 200 * stable);
    Simulation simulation(model, options_of(rule, unstable));
    StepReport report;
    for (int k = 0; k < 200 && report.ok(); ++k) report = simulation.step();
    EXPECT_EQ(report.code, StepReport::Code::unstable);
    EXPECT_LE(std::abs(simulation.save().q[0]), 1);
    EXPECT_THAT(simulation.explain(report), testing::HasSubstr(std::string("up to about ") + limit));
  }
}

/// With an accuracy it takes steps that are stable.
TEST(Explicit, FollowsAFastVibrationByAccuracy) {
  Simulation simulation(model_of(oscillator), options_of(Rule::dopri853, 0.05, 1e-10));
  run_to(simulation, 0.1);
  EXPECT_NEAR(simulation.save().q[0], 0.1 * std::cos(100.0), 1e-7);
}

/// An input that jumps acts from the step on that begins then: θ = ½ (M/J) t² in each piece.
TEST(Explicit, TakesJumpsOfInputs) {
  const auto model = model_of(R"(
gravity: [0, 0, 0]
inputs: {torque: 1}
bodies:
  rotor: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 0.5]}
joints:
  axle: {type: revolute, between: [ground, rotor], at: [0, 0, 0], axis: [0, 0, 1]}
actuators:
  motor: {joint: axle, torque: torque}
)");
  for (const Rule rule : {Rule::rk4, Rule::dopri853}) {
    Simulation simulation(model, options_of(rule, 0.1));
    double angle = 0, speed = 0;
    for (int k = 0; k < 10; ++k) {
      const double torque = k % 3 - 0.7, a = torque / 0.5;
      simulation.set_input(simulation.input("torque"), torque);
      ASSERT_TRUE(simulation.step().ok());
      angle += 0.1 * speed + 0.005 * a;
      speed += 0.1 * a;
      EXPECT_NEAR(simulation.save().q[0], angle, 1e-13);
      EXPECT_NEAR(simulation.save().a[0], a, 1e-13);
    }
  }
}

/// Without gravity nothing but the motion says how fast it goes, and at rest not even that: from there a
/// force that comes at once must not ask for ever shorter parts.
TEST(Explicit, StartsFromRestWithoutGravity) {
  RunOptions options = options_of(Rule::dopri853, 0.002, 1e-6);
  Simulation simulation(model_of(R"(
gravity: [0, 0, 0]
bodies: {block: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {way: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0]}}
loads: {push: {on: block, at: [0, 0, 0], force: [3, 0, 0], scale: "t < 0.501 ? 0 : 1"}}
)"),
                        options);
  run_to(simulation, 1);
  EXPECT_NEAR(simulation.save().q[0], 0.5 * 1.5 * 0.499 * 0.499, 1e-5);
  EXPECT_NEAR(simulation.save().v[0], 1.5 * 0.499, 1e-5);
}

/// A ball that falls on a plane, and bounces with half its speed: as by the implicit rule with small steps.
TEST(Explicit, RestartsAtImpacts) {
  const auto model = model_of(R"(
bodies:
  ball: {mass: 1, com: [0, 0, 0], inertia: [0.01, 0.01, 0.01]}
joints:
  free: {type: floating, between: [ground, ball], position: [0, 0, 1.1, 0, 0, 0]}
surfaces: {floor: {type: half_space}}
contacts:
  bounce: {spheres: {on: ball, radius: 0.1}, surfaces: [floor], stiffness: 1e7, restitution: 0.5}
)");
  const double impact = std::sqrt(2 * 1 / 9.81), end = impact + impact / 2;  // at the top of the bounce
  const auto height = [&](const RunOptions& options) {
    Simulation simulation(model, options);
    while (simulation.time() < end - 0.011) EXPECT_TRUE(simulation.step().ok());
    EXPECT_TRUE(simulation.step_to(end).ok());
    return simulation.save().q[2] - 0.1;
  };
  RunOptions fixed = options_of(Rule::rk4, 0.01);
  fixed.substeps = 4;
  EXPECT_NEAR(height(fixed), 0.25, 0.01);
  EXPECT_NEAR(height(options_of(Rule::dopri853, 0.01, 1e-8)), 0.25, 0.01);
}

TEST(Explicit, GoesOnFromASavedStateToTheSameBits) {
  const auto model = model_of(smooth_mechanisms()[5].text);
  for (const RunOptions& options : {options_of(Rule::rk4, 0.01), options_of(Rule::dopri853, 0.01),
                                    options_of(Rule::dopri853, 0.05, 1e-9)}) {
    Simulation first(model, options), second(model, options);
    for (int k = 0; k < 5; ++k) ASSERT_TRUE(first.step().ok());
    second.restore(first.save());
    for (int k = 0; k < 5; ++k) {
      ASSERT_TRUE(first.step().ok());
      ASSERT_TRUE(second.step().ok());
    }
    EXPECT_EQ(first.save().q, second.save().q);
    EXPECT_EQ(first.save().v, second.save().v);
    EXPECT_EQ(first.save().a, second.save().a);
    EXPECT_EQ(first.save().memory, second.save().memory);
  }
}

/// Steps of a fixed cost are what rk4 makes anyway.
TEST(Explicit, HasTheSameStepsWithAFixedCost) {
  const auto model = model_of(smooth_mechanisms()[5].text);
  RunOptions options = options_of(Rule::rk4, 0.005);
  const VectorXd plain = run_with(model, options, 0.2);
  options.substeps.reset();
  options.fixed_cost = true;
  EXPECT_EQ(run_with(model, options, 0.2), plain);
}

TEST(Explicit, RefusesWhatDoesNotFit) {
  const auto model = model_of(oscillator);
  const auto refused = [&](const RunOptions& options) {
    try {
      Simulation simulation(model, options);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(refused(options_of(Rule::rk4, 1e-3, 1e-6)),
              testing::HasSubstr("accuracy belongs to auto, dopri853 and radau"));
  RunOptions options = options_of(Rule::rk4, 1e-3);
  options.formalism = spec::Simulation::Formalism::penalty;
  EXPECT_THAT(refused(options), testing::HasSubstr("rk4 is explicit and has no formalism"));
  options = options_of(Rule::dopri853, 1e-3, 1e-6);
  options.fixed_cost = true;
  EXPECT_THAT(refused(options), testing::HasSubstr("has an accuracy to keep"));
  options = options_of(Rule::dopri853, 1e-3);
  options.rho = 0.5;
  EXPECT_THAT(refused(options), testing::HasSubstr("rho belongs to generalized_alpha and hht"));
}

}  // namespace
}  // namespace mimbre::test::explicit_test
