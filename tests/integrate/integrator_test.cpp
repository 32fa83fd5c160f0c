#include "integrate/index3.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <ostream>

#include "mimbre/simulation.h"
#include "support/models.h"
#include "support/probe.h"
#include "support/run.h"

namespace mimbre::test::integrator_test {
namespace {

/// A bar on a hinge, let go from the horizontal: θ̈ = (3 g / 2 L) cos θ with θ about the hinge's axis,
/// downwards.
constexpr const char* pendulum = R"(
bodies:
  bar: {mass: 2, com: [0.5, 0, 0], inertia: [0.001, 0.16666666666666666, 0.16666666666666666]}
joints:
  hinge: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0]}
)";

/// A heavy top: mass above the ball joint, spinning about its own axis and leaning.
constexpr const char* top = R"(
bodies:
  top: {mass: 3, com: [0.1, 0.05, 0.4], inertia: [0.1, 0.12, 0.06]}
joints:
  ball: {type: spherical, between: [ground, top], at: [0, 0, 0], velocity: [0.5, 1, 9]}
)";

/// Nothing but inertia, all principal values different; turning about nearly the middle one it tumbles.
constexpr const char* tumbling = R"(
gravity: [0, 0, 0]
bodies:
  brick: {mass: 2, com: [0, 0, 0], inertia: [0.1, 0.2, 0.26]}
joints:
  free: {type: floating, between: [ground, brick], velocity: [0.3, -0.2, 0.1, 0.05, 3, 0.02]}
)";

struct Rule {
  const char* name;
  IntegratorOptions (*options)(double step);
  double order;  ///< of positions and velocities
};

void PrintTo(const Rule& rule, std::ostream* out) { *out << rule.name; }

const Rule rules[] = {
    {"newmark", [](double h) { return newmark(h); }, 2},
    {"alpha_03", [](double h) { return generalised_alpha(h, 0.3); }, 2},
    {"alpha_08", [](double h) { return generalised_alpha(h, 0.8); }, 2},
    {"newmark_damped", [](double h) { return newmark(h, -0.2); }, 1},
};

struct Case {
  const char* name;
  std::string text;
  double step, duration;
};

void PrintTo(const Case& problem, std::ostream* out) { *out << problem.name; }

const Case cases[] = {
    {"pendulum", pendulum, 0.004, 1},
    {"top", top, 0.004, 0.4},
    {"tumbling", tumbling, 0.02, 2},
    {"four_bar", four_bar_text({{"crank", ", position: 2.2"}}), 0.002, 0.4},
};

class Convergence : public testing::TestWithParam<std::tuple<Rule, Case>> {};

TEST_P(Convergence, OrderOfPositionsAndVelocities) {
  const auto& [rule, problem] = GetParam();
  const auto model = model_of(problem.text);
  Outcome runs[3];
  for (int k = 0; k < 3; ++k) {
    runs[k] = run(model, rule.options(problem.step / (1 << k)), problem.duration);
    ASSERT_EQ(runs[k].failed_step, -1);
  }
  const double position = order(runs[0].state.q, runs[1].state.q, runs[2].state.q),
               velocity = order(runs[0].state.v, runs[1].state.v, runs[2].state.v);
  EXPECT_NEAR(position, rule.order, 0.15);
  EXPECT_NEAR(velocity, rule.order, 0.15);
}

INSTANTIATE_TEST_SUITE_P(RulesAndCases, Convergence,
                         testing::Combine(testing::ValuesIn(rules), testing::ValuesIn(cases)),
                         [](const auto& row) {
                           return std::string(std::get<0>(row.param).name) + "_" +
                                  std::get<1>(row.param).name;
                         });

/// θ̈ = f(θ) by Runge and Kutta's classical rule.
template <class F>
Eigen::Vector2d reference(Eigen::Vector2d x, double duration, int steps, F&& f) {
  const double h = duration / steps;
  const auto rate = [&](const Eigen::Vector2d& s) { return Eigen::Vector2d(s[1], f(s[0])); };
  for (int k = 0; k < steps; ++k) {
    const Eigen::Vector2d k1 = rate(x), k2 = rate(x + h / 2 * k1), k3 = rate(x + h / 2 * k2),
                          k4 = rate(x + h * k3);
    x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return x;
}

TEST(Integrator, PendulumFollowsItsDifferentialEquation) {
  const auto model = model_of(pendulum);
  const Eigen::Vector2d exact = reference({0, 0}, 2, 4000, [](double x) { return 1.5 * 9.81 * std::cos(x); });
  for (const Rule& rule : rules) {
    const Outcome r = run(model, rule.options(0.001), 2);
    const double tolerance = rule.order == 2 ? 2e-4 : 2e-2;
    EXPECT_NEAR(r.state.q[0], exact[0], tolerance) << rule.name;
    EXPECT_NEAR(r.state.v[0], exact[1], 5 * tolerance) << rule.name;
  }
}

TEST(Integrator, RigidDoubleFourBarThroughItsSingularPositions) {
  const auto model = example("double-four-bar/mechanism.yaml");
  // All three standing bars move alike: θ̈ = −3.5 g cos θ / 3.
  const Eigen::Vector2d exact =
      reference({std::numbers::pi / 2, -1}, 5, 20000, [](double x) { return -3.5 * 9.81 * std::cos(x) / 3; });
  EXPECT_NEAR(exact[0], -15.08355716, 1e-8);
  for (const double h : {0.01, 0.001}) {
    const Outcome r = run(model, newmark(h), 5);
    ASSERT_EQ(r.failed_step, -1) << "step " << h;
    EXPECT_NEAR(r.state.q[0] + std::numbers::pi / 2, exact[0], 1e-3);
    EXPECT_LT(r.position_violation, 1e-8);
    EXPECT_LT(r.velocity_violation, 1e-6);
  }
  // With loops closed this tightly the singular positions leave no trace: the error is 1.31 h².
  for (const double h : {0.008, 0.004, 0.002, 0.001}) {
    IntegratorOptions options = newmark(h);
    options.penalty = 1e7;
    const Outcome r = run(model, options, 5);
    ASSERT_EQ(r.failed_step, -1) << "step " << h;
    EXPECT_NEAR((r.state.q[0] + std::numbers::pi / 2 - exact[0]) / (h * h), -1.31, 0.05) << "step " << h;
  }
}

/// With equations a matrix leads through five steps at most, where it converges as fast as a new one and
/// little is projected by it; not by a rule without damping, as the model has it.
TEST(Integrator, AMatrixOfAMechanismWithLoopsIsKept) {
  RunOptions options;
  options.step = 2e-3;
  options.integrator = spec::Simulation::Integrator::generalized_alpha;
  options.rho = 0.8;
  Simulation simulation(example("double-four-bar/mechanism.yaml"), options);
  constexpr int steps = 500;
  int factorisations = 0;
  for (int k = 0; k < steps; ++k) factorisations += simulation.step().factorisations;
  EXPECT_GE(factorisations, steps / 5);
  EXPECT_LE(factorisations, steps / 3);
}

/// Stiff bars hardly change the motion, and the trapezoidal rule at the benchmark's step gets through.
TEST(Integrator, FlexibleDoubleFourBar) {
  for (const char* flexible : {"1", "3", "5"}) {
    const auto model = example("double-four-bar/mechanism.yaml", {{"flexible_bars", flexible}});
    IntegratorOptions options = newmark(0.01);
    options.tolerance = 1e-5;
    const Outcome r = run(model, options, 5);
    ASSERT_EQ(r.failed_step, -1) << flexible;
    EXPECT_NEAR(r.state.q[0] + std::numbers::pi / 2, -15.08, 0.03) << flexible;
  }
}

TEST(Integrator, TumblingBodyKeepsEnergyAndAngularMomentum) {
  const auto model = model_of(tumbling);
  const Mat3d inertia = Vec3d(0.1, 0.2, 0.26).asDiagonal();
  for (const Rule& rule : {rules[0], rules[2]}) {
    double energy_drift[2] = {}, momentum_drift[2] = {};
    for (int k = 0; k < 2; ++k) {
      Vec3d lowest = Vec3d::Constant(1), highest = -lowest;
      const State start = initial_state(model);
      double first_energy = -1;
      Vec3d first_momentum;
      const auto watch = [&](relative::RelativeSystem& system, const State& s) {
        const auto& body = system.workspace().bodies[0];
        const Vec3d momentum = body.rotation * inertia * body.rotation.transpose() * body.omega;
        const double energy = 0.5 * momentum.dot(body.omega) + body.velocity.squaredNorm();
        if (first_energy < 0) first_energy = energy, first_momentum = momentum;
        energy_drift[k] = std::max(energy_drift[k], std::abs(energy / first_energy - 1));
        momentum_drift[k] =
            std::max(momentum_drift[k], (momentum - first_momentum).norm() / first_momentum.norm());
        lowest = lowest.cwiseMin(body.rotation.row(1).transpose());
        highest = highest.cwiseMax(body.rotation.row(1).transpose());
        EXPECT_NEAR((s.q.segment<4>(3).norm()), 1, 1e-14);
      };
      const Outcome r = run(model, rule.options(0.02 / (1 << k)), 30, start, watch);
      ASSERT_EQ(r.failed_step, -1);
      // The middle axis has pointed along the momentum and against it: the body has turned over.
      EXPECT_LT(lowest[1], -0.95);
      EXPECT_GT(highest[1], 0.95);
    }
    EXPECT_LT(energy_drift[1], 1e-2) << rule.name;
    EXPECT_LT(momentum_drift[1], 1e-2) << rule.name;
    EXPECT_GT(energy_drift[0] / energy_drift[1], 3.3) << rule.name;
    EXPECT_GT(momentum_drift[0] / momentum_drift[1], 3.3) << rule.name;
  }
}

TEST(Integrator, LoopsStayClosed) {
  for (const auto& model :
       {model_of(four_bar_text({{"crank", ", velocity: 6"}})), example("tutorial/four-bar.yaml"),
        example("iltis/suspension.yaml", {{"elements", "4"}})}) {
    for (const Rule& rule : {rules[0], rules[1]}) {
      const Outcome r = run(model, rule.options(0.002), 1);
      ASSERT_EQ(r.failed_step, -1);
      EXPECT_LT(r.position_violation, 1e-8);
      EXPECT_LT(r.velocity_violation, 1e-6);
    }
  }
}

/// Revolutes all round leave three equations redundant; a ball in the last joint leaves one. The motion is
/// the same.
TEST(Integrator, RedundantEquationsChangeNothing) {
  const std::map<std::string, std::string> start{{"crank", ", velocity: 6"}};
  const auto redundant = model_of(four_bar_text(start)), ball = model_of(four_bar_text(start, "spherical"));
  ASSERT_EQ(redundant->constraints(), 5);
  ASSERT_EQ(ball->constraints(), 3);
  EXPECT_EQ(Simulation(redundant).degrees_of_freedom(), 1);
  EXPECT_EQ(Simulation(ball).degrees_of_freedom(), 1);
  const Outcome a = run(redundant, newmark(0.002), 1), b = run(ball, newmark(0.002), 1);
  EXPECT_LT((a.state.q - b.state.q).norm(), 1e-6);
  EXPECT_LT((a.state.v - b.state.v).norm(), 1e-5);
}

/// A linkage with a coupler that bends, clamped to its own frame at the crank's end. Cut at the crank's pin
/// the coupler hangs on the rocker by the end that its modes move.
std::string flexible_four_bar(const std::string& cut_joint) {
  const auto cut = [&](const char* joint) {
    return std::string(", cut: ") + (joint == cut_joint ? "always" : "never") + "}";
  };
  return R"(
materials: {soft: {young: 2e9, poisson: 0.3, density: 1500}}
sections: {round: {type: round, diameter: 0.02}}
bodies:
  crank: {mass: 0.5, com: [0, 0, 0.1], inertia: [0.002, 0.002, 0.0001]}
  coupler:
    frame: {at: [0, 0, 0.2], x: [0.6, 0, 0.3], y: [0, 1, 0]}
    flexible:
      material: soft
      section: round
      nodes: {crank: [0, 0, 0.2], rocker: [0.6, 0, 0.5]}
      bars: {bar: {from: crank, to: rocker, elements: 6}}
      planar: [0, 1, 0]
      clamped: [crank]
      static_modes:
        - {node: rocker, along: [0.6, 0, 0.3]}
        - {node: rocker, along: [-0.3, 0, 0.6]}
      dynamic_modes: 1
      stiffness_damping: 1e-4
  rocker: {mass: 1, com: [0.6, 0, 0.25], inertia: [0.02, 0.02, 0.0005]}
joints:
  crank: {type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 1, 0])" +
         cut("crank") + R"(
  crank_pin: {type: revolute, between: [crank, coupler], at: [0, 0, 0.2], axis: [0, 1, 0])" +
         cut("crank_pin") + R"(
  rocker: {type: revolute, between: [ground, rocker], at: [0.6, 0, 0], axis: [0, 1, 0])" +
         cut("rocker") + R"(
  rocker_pin: {type: revolute, between: [coupler, rocker], at: [0.6, 0, 0.5], axis: [0, 1, 0])" +
         cut("rocker_pin") + R"(
loads:
  push: {on: coupler.rocker, force: [3, 0, 20], moment: [0, 1, 0]}
)";
}

/// Poses, velocities and accelerations of all bodies, in the order of the file.
Eigen::VectorXd motion_of_bodies(const Model& model, const State& s) {
  const Compiled& m = model.compiled();
  relative::RelativeSystem system(m);
  system.kinematics(s.time, s.q.data(), s.v.data(), s.a.data());
  Eigen::VectorXd out(18 * static_cast<Eigen::Index>(m.bodies.size()));
  Eigen::Index at = 0;
  for (const int body : m.body_of_spec) {
    const auto& b = system.workspace().bodies[static_cast<std::size_t>(body)];
    out.segment<18>(at) << b.position, b.velocity, b.omega, b.rotation.col(0), b.acceleration, b.alpha;
    at += 18;
  }
  return out;
}

TEST(Integrator, MotionDoesNotDependOnWhereTheLoopIsCut) {
  std::vector<Eigen::VectorXd> at_start, at_end;
  bool hangs_on_moving_end = false;
  for (const char* cut : {"rocker_pin", "crank_pin", "rocker", "crank"}) {
    const auto model = model_of(flexible_four_bar(cut));
    for (const BodyData& b : model->compiled().bodies)
      hangs_on_moving_end |=
          model->compiled().frames[static_cast<std::size_t>(b.outboard_frame)].flexible >= 0;
    const State start = initial_state(model);
    at_start.push_back(motion_of_bodies(*model, start));
    const Outcome r = run(model, newmark(0.0005), 0.2, start);
    ASSERT_EQ(r.failed_step, -1) << cut;
    at_end.push_back(motion_of_bodies(*model, r.state));
  }
  EXPECT_TRUE(hangs_on_moving_end);
  for (std::size_t k = 1; k < at_start.size(); ++k) {
    EXPECT_LT(relative_difference(at_start[k], at_start[0]), 1e-8) << k;
    EXPECT_LT(relative_difference(at_end[k], at_end[0]), 1e-3) << k;
  }
}

TEST(Integrator, AFailedStepLeavesTheState) {
  const auto model = model_of(four_bar_text({{"crank", ", velocity: 6"}}));
  IntegratorOptions options = newmark(0.01);
  options.max_iterations = 1;
  relative::RelativeSystem system(model->compiled());
  IndexThree integrator(system, options);
  const State start = initial_state(model);
  State s = start;
  EXPECT_EQ(integrator.step(s).code, StepCode::not_converged);
  EXPECT_EQ(s.time, start.time);
  EXPECT_EQ(s.q, start.q);
  EXPECT_EQ(s.v, start.v);
  EXPECT_EQ(s.a, start.a);

  s.v[0] = std::nan("");
  const State broken = s;
  EXPECT_NE(integrator.step(s).code, StepCode::ok);
  EXPECT_EQ(s.q, broken.q);
}

}  // namespace
}  // namespace mimbre::test::integrator_test
