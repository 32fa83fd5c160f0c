#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <thread>
#include <vector>

#include "support/models.h"
#include "support/simulate.h"

/// Inputs, signals and actuators, in both formulations.
namespace mimbre::signals_test {
namespace {

using namespace test;

std::string refusal(const std::string& text) {
  try {
    model_of(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

/// An arm of 2 kg m² about a vertical axis, which gravity does not move, and what is put behind.
std::string arm(const std::string& more, double step = 1e-3) {
  return fmt::format(R"y(
bodies:
  arm: {{mass: 2, com: [0, 0, 0], inertia: [2, 2, 2]}}
joints:
  shoulder: {{type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 1]}}
outputs:
  - {{name: angle, joint: shoulder}}
  - {{name: rate, joint_velocity: shoulder}}
  - {{name: turning, acceleration: arm, component: x}}
simulation: {{step: {}, end: 1}}
{})y",
                     step, more);
}

class Signals : public testing::TestWithParam<Formulation> {};

/// 2 θ̈ = −200 (θ − 0.5) − 8 θ̇: damped by ζ = 0.2 at ω = 10 rad/s.
double step_response(double t) {
  const double omega = 10, zeta = 0.2, damped = omega * std::sqrt(1 - zeta * zeta);
  return 0.5 * (1 - std::exp(-zeta * omega * t) *
                        (std::cos(damped * t) + zeta * omega / damped * std::sin(damped * t)));
}

TEST_P(Signals, AControllerInTheModelFileGivesTheExactStepResponse) {
  const std::string controller = R"y(
inputs:
  wanted: {start: 0.5, unit: rad, range: [-1, 1]}
signals:
  error: {value: "wanted - angle", unit: rad}
actuators:
  motor: {joint: shoulder, torque: "200*error - 8*rate"}
)y";
  double before = 0;
  for (const double step : {4e-4, 2e-4}) {
    Simulation simulation = simulation_of(arm(controller, step), GetParam());
    double worst = 0;
    while (simulation.time() < 1 - 1e-9) {
      ASSERT_TRUE(simulation.step().ok());
      worst = std::max(worst, std::abs(channel(simulation, "angle") - step_response(simulation.time())));
    }
    if (before > 0) {
      EXPECT_LT(worst, 1e-6);
      EXPECT_GT(before / worst, 3.5);  // second order
    }
    before = worst;
  }
}

/// Sampled every 10 ms: between instants the torque is constant, and the motion a parabola.
TEST_P(Signals, ASampledControllerGivesTheExactResponseOfASampledOne) {
  Simulation simulation = simulation_of(arm(R"y(
signals:
  torque: {value: "200*(0.5 - angle) - 8*rate", every: 0.01}
actuators:
  motor: {joint: shoulder, torque: torque}
)y",
                                            1e-4),
                                        GetParam());
  double angle = 0, rate = 0, torque = 0;
  for (int k = 0; k < 5000; ++k) {
    const double h = 1e-4;
    if (k % 100 == 0) torque = 200 * (0.5 - angle) - 8 * rate;
    angle += h * rate + 0.25 * torque * h * h;
    rate += 0.5 * torque * h;
    ASSERT_TRUE(simulation.step().ok());
    ASSERT_NEAR(channel(simulation, "angle"), angle, 1e-6) << k;
  }
  EXPECT_NEAR(channel(simulation, "signal.torque"), torque, 2e-4 * 200);
}

/// What takes others that are evaluated at the same instants takes their new values, by way of continuous
/// ones and whatever the order in the file; in a circle one of them is an instant late.
TEST_P(Signals, AChainOfSampledOnesHasNoDelay) {
  Simulation simulation = simulation_of(arm(R"y(
signals:
  total: {value: "second + between", every: 0.02}
  second: {value: first, every: 0.02}
  between: {value: "3*second"}
  first: {value: "t + 1", every: 0.02}
  slower: {value: total, every: 0.04}
  there: {value: "back + 1", every: 0.02}
  back: {value: there, every: 0.02}
  seen: {value: sum_of_both, every: 0.02}
  sum_of_both: {value: "counted + one"}
  counted: {value: sum_of_both, every: 0.02}
  one: {value: "1 + 0*t", every: 0.02}
)y",
                                            0.01),
                                        GetParam());
  for (int k = 0; k < 20; ++k) {
    ASSERT_TRUE(simulation.step().ok());
    const int instant = k / 2;
    const double first = 0.02 * instant + 1;
    EXPECT_NEAR(channel(simulation, "signal.first"), first, 1e-9);
    EXPECT_NEAR(channel(simulation, "signal.second"), first, 1e-9);
    EXPECT_NEAR(channel(simulation, "signal.total"), 4 * first, 1e-9);
    EXPECT_NEAR(channel(simulation, "signal.slower"), 4 * (0.04 * (k / 4) + 1), 1e-9);
    EXPECT_EQ(channel(simulation, "signal.there"), instant + 1);
    EXPECT_EQ(channel(simulation, "signal.back"), instant);
    EXPECT_EQ(channel(simulation, "signal.counted"), instant + 1);
    EXPECT_EQ(channel(simulation, "signal.seen"), instant + 2);
  }
}

/// The first value of what takes a sampled signal is made of that signal's first value, not of none.
TEST_P(Signals, SampledBlocksStartFromTheFirstSample) {
  Simulation simulation = simulation_of(arm(R"y(
signals:
  measured: {value: "angle + 0.5", every: 0.01}
  rate_of_change: {pid: measured, setpoint: 0.5, kp: 0, ki: 0, kd: 1, filter: 0.01, every: 0.01}
  limited: {rate_limit: measured, rising: 1, every: 0.01}
  late: {delay: measured, time: 0.03, every: 0.01}
)y",
                                            0.01),
                                        GetParam());
  for (int k = 0; k < 8; ++k) {
    ASSERT_TRUE(simulation.step().ok());
    EXPECT_NEAR(channel(simulation, "signal.rate_of_change"), 0, 1e-12) << k;
    EXPECT_NEAR(channel(simulation, "signal.limited"), 0.5, 1e-12) << k;
    EXPECT_NEAR(channel(simulation, "signal.late"), 0.5, 1e-12) << k;
  }
}

TEST_P(Signals, InputsActFromTheStepAfterTheyAreSet) {
  Simulation simulation = simulation_of(arm(R"y(
inputs: {push: {start: 0, range: [-10, 10]}, ramp: {hold: linear}}
actuators:
  motor: {joint: shoulder, torque: "2*push + 4*ramp"}
)y"),
                                        GetParam());
  const int push = simulation.input("push"), ramp = simulation.input("ramp");
  for (int k = 0; k < 10; ++k) simulation.step();
  EXPECT_NEAR(channel(simulation, "angle"), 0, 1e-15);
  simulation.set_input(push, 3);
  for (int k = 0; k < 100; ++k) simulation.step();
  // 6 N m on 2 kg m² over 0.1 s.
  EXPECT_NEAR(channel(simulation, "rate"), 0.3, 1e-7);
  EXPECT_NEAR(channel(simulation, "angle"), 0.015, 1e-7);
  simulation.set_input(push, 30);
  EXPECT_EQ(simulation.input_value(push), 10);
  simulation.set_input(push, 0);
  simulation.set_input(ramp, 5);
  EXPECT_EQ(simulation.input_value(ramp), 0);
  simulation.step();
  EXPECT_EQ(simulation.input_value(ramp), 5);
  EXPECT_EQ(channel(simulation, "input.ramp"), 5);
  EXPECT_THROW(simulation.input("pusch"), InputError);
}

TEST_P(Signals, ParametersThatAreTunableChangeLawsBetweenSteps) {
  Simulation simulation = simulation_of(R"y(
parameters: {k: {value: 100, tunable: true, min: 0}, c: 2}
bodies: {mass: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {guide: {type: prismatic, between: [ground, mass], at: [0, 0, 0], axis: [1, 0, 0], position: 0.1}}
springs:
  spring: {between: [ground, mass], at: [[-1, 0, 0], [0, 0, 0]], elastic: "k*(l - 1)", damping: "c*v"}
outputs: [{name: x, joint: guide}, {name: f, spring_force: spring}]
simulation: {step: 0.001, end: 1}
)y",
                                        GetParam());
  EXPECT_NEAR(channel(simulation, "f"), 10, 1e-9);
  simulation.set_input(simulation.input("k"), 300);
  EXPECT_NEAR(channel(simulation, "f"), 30, 1e-9);
}

/// What inputs start with counts at the start: the same bits as of a model that says so.
TEST_P(Signals, InputsAreSetBeforeTheStart) {
  const std::string text = R"y(
parameters: {k: {value: 100, tunable: true, min: 0, max: 500}}
inputs: {place: {start: 0, hold: linear}, push: {start: 0, range: [-10, 10]}}
bodies:
  a: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
  b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
joints:
  slide: {type: prismatic, between: [ground, a], at: [0, 0, 0], axis: [1, 0, 0], drive: {position: place}}
  guide: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [0, 0, 1]}
actuators: {motor: {joint: guide, force: push}}
springs:
  spring: {between: [a, b], at: [[0, 0, 2], [0, 0, 0]], elastic: "k*(l - 1)"}
initial: equilibrium
simulation: {step: 0.01, end: 1}
)y";
  std::string made = text;
  for (const auto& [from, to] :
       {std::pair("value: 100", "value: 300"), std::pair("start: 0, hold", "start: 0.3, hold"),
        std::pair("start: 0, range", "start: 4, range")})
    made.replace(made.find(from), std::string(from).size(), to);
  RunOptions options;
  options.formulation = GetParam();
  Simulation wanted(model_of(made), options);
  const auto model = model_of(text);
  options.inputs = {{"k", 300}, {"place", 0.3}, {"push", 4}};
  Simulation simulation(model, options);
  ResultsRow a, b;
  for (int k = 0; k < 5; ++k) {
    wanted.sample(a);
    simulation.sample(b);
    for (Eigen::Index c = 0; c < a.channels.size(); ++c)
      EXPECT_EQ(a.channels[c], b.channels[c]) << simulation.channels()[static_cast<std::size_t>(c)].name;
    ASSERT_TRUE(wanted.step().ok() && simulation.step().ok());
  }
  EXPECT_NEAR(channel(simulation, "joint.slide.position"), 0.3, 1e-12);
  options.inputs = {{"push", 40}};
  Simulation within(model, options);
  EXPECT_EQ(within.input_value(within.input("push")), 10);
  options.inputs = {{"pusch", 1}};
  EXPECT_THROW(Simulation(model, options), InputError);
  options.inputs = {{"push", std::nan("")}};
  EXPECT_THROW(Simulation(model, options), InputError);
}

/// A speed that a signal says is a rate that the drive follows.
TEST_P(Signals, DrivesFollowThem) {
  Simulation simulation = simulation_of(R"y(
inputs: {speed: {start: 2, hold: linear}}
signals: {place: 0.1*sin(3*t)}
bodies:
  a: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
  b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
joints:
  turn: {type: revolute, between: [ground, a], at: [0, 0, 0], axis: [0, 0, 1], drive: {speed: speed}}
  slide: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [0, 0, 1], drive: {position: 2*place}}
outputs:
  - {name: angle, joint: turn}
  - {name: rate, joint_velocity: turn}
  - {name: z, joint: slide}
  - {name: w, joint_velocity: slide}
simulation: {step: 0.01, end: 1}
)y",
                                        GetParam());
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(simulation.step().ok());
  EXPECT_NEAR(channel(simulation, "angle"), 1, 1e-9);
  simulation.set_input(simulation.input("speed"), 3);
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(simulation.step().ok());
  // A step of 0.01 s from 2 to 3 rad/s, then 49 at 3 rad/s.
  EXPECT_NEAR(channel(simulation, "angle"), 1 + 0.025 + 0.49 * 3, 1e-9);
  EXPECT_NEAR(channel(simulation, "rate"), 3, 1e-9);
  EXPECT_NEAR(channel(simulation, "z"), 0.2 * std::sin(3), 1e-9);
  EXPECT_NEAR(channel(simulation, "w"), 0.6 * std::cos(3), 1e-8);
}

INSTANTIATE_TEST_SUITE_P(BothFormulations, Signals,
                         testing::Values(Formulation::relative, Formulation::natural));

/// Threads share a model and its expressions: each gives the bits that one alone does.
TEST(SignalThreads, ShareAModel) {
  const auto model = test::controlled_four_bar();
  const auto course = [&](std::vector<double>& out) {
    Simulation simulation(model);
    const int wanted = simulation.input("wanted");
    ResultsRow row;
    for (int k = 0; k < 200; ++k) {
      simulation.set_input(wanted, 0.3 * std::sin(0.05 * k));
      if (!simulation.step().ok()) return;
      simulation.sample(row);
      out.insert(out.end(), row.channels.data(), row.channels.data() + row.channels.size());
    }
  };
  std::vector<double> alone;
  course(alone);
  ASSERT_FALSE(alone.empty());
  std::vector<std::vector<double>> together(8);
  std::vector<std::thread> threads;
  for (std::vector<double>& out : together) threads.emplace_back([&] { course(out); });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<double>& out : together) EXPECT_TRUE(out == alone);
}

TEST(SignalErrors, NameWhatIsWrong) {
  using testing::HasSubstr;
  EXPECT_THAT(refusal(arm("signals: {a: \"b + 1\", b: \"2*c\", c: \"a\"}\n")),
              HasSubstr("'a' → 'b' → 'c' → 'a'"));
  EXPECT_THAT(refusal(arm("actuators: {m: {joint: shoulder, torque: \"3*turning\"}}\n")),
              HasSubstr("uses 'turning' (`acceleration`), which forces decide at the same instant"));
  EXPECT_THAT(refusal(arm("signals: {felt: {joint_force: shoulder, component: mz}}\n"
                          "actuators: {m: {joint: shoulder, torque: \"felt\"}}\n")),
              HasSubstr("signal 'felt' measures `joint_force`, which forces decide"));
  EXPECT_EQ(refusal(arm("signals: {s: {value: \"turning\", every: 0.01}}\n"
                        "actuators: {m: {joint: shoulder, torque: \"s\"}}\n")),
            "accepted");
  EXPECT_THAT(refusal(arm("inputs: {t: 0}\n")), HasSubstr("taken by expressions"));
  EXPECT_THAT(refusal(arm("inputs: {push: 0}\nactuators: {m: {joint: shoulder, torque: \"push + l\"}}\n")),
              testing::AllOf(HasSubstr("'l' is no variable of this law"), HasSubstr("depends on t, push,")));
  EXPECT_THAT(refusal(arm("inputs: {a: 0}\nsignals: {a: \"1\"}\n")), HasSubstr("choose another"));
  EXPECT_THAT(refusal(arm("actuators: {m: {joint: shoulder, torque: \"3*anlge\"}}\n")), HasSubstr("anlge"));
  EXPECT_THAT(refusal(arm("actuators: {m: {joint: shoulder, force: 3}}\n")), HasSubstr("write 'torque'"));
  EXPECT_THAT(refusal(R"y(
parameters: {m: {value: 2, tunable: true}}
bodies: {a: {mass: m, com: [0, 0, 0], inertia: [1, 1, 1]}}
)y"),
              HasSubstr("tunable"));
}

}  // namespace
}  // namespace mimbre::signals_test
