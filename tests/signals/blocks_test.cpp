#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "mimbre/diagnostics.h"
#include "signals/block_models.h"
#include "support/models.h"
#include "support/simulate.h"

/// Blocks against what they are said to do, in both formulations.
namespace mimbre::test::blocks_test {
namespace {

using testing::HasSubstr;

class Blocks : public testing::TestWithParam<Formulation> {
 protected:
  /// Largest difference of a channel to what it should be, over a second.
  double worst(const std::string& model, const std::string& channel,
               const std::function<double(double)>& expected, double step, double from = 0) {
    Simulation s = simulation_of(slider(model, step), GetParam());
    const Simulation::Channel of = s.channel(channel);
    double most = from > 0 ? 0 : std::abs(s.value(of) - expected(0));
    while (s.time() < 1 - 1e-9) {
      if (!s.step().ok()) return NAN;
      if (s.time() >= from) most = std::max(most, std::abs(s.value(of) - expected(s.time())));
    }
    return most;
  }
};

TEST_P(Blocks, TransferFunctionsGiveTheirStepResponses) {
  EXPECT_LT(worst(
                "signals: {y: {transfer_function: 1, numerator: [3], denominator: [0.2, 1]}}\n", "signal.y",
                [](double t) { return 3 * (1 - std::exp(-t / 0.2)); }, 0.01),
            1e-13);
  // (s + 2) / (s² + 2 s + 26): poles −1 ± 5 i.
  EXPECT_LT(
      worst(
          "signals: {y: {transfer_function: 1, numerator: [1, 2], denominator: [1, 2, 26]}}\n", "signal.y",
          [](double t) {
            const double c = std::cos(5 * t), s = std::sin(5 * t), e = std::exp(-t);
            return 2.0 / 26 + e * (-2.0 / 26 * c + (1 - 2.0 / 26) / 5 * s);
          },
          0.01),
      1e-13);
  // A ramp, which is what lies between the steps, into a double integrator with a gain beside.
  EXPECT_LT(worst(
                "signals: {y: {transfer_function: \"2*t\", numerator: [4, 0, 1], denominator: [1, 0, 0]}}\n",
                "signal.y", [](double t) { return 8 * t + t * t * t / 3; }, 0.01),
            1e-13);
  // Fast poles and slow ones, in units of their own.
  EXPECT_LT(
      worst(
          "signals: {y: {transfer_function: 1, numerator: [1e8], denominator: [1, 10001, 10000]}}\n",
          "signal.y",
          [](double t) { return 1e8 / 9999 * ((1 - std::exp(-t)) - (1 - std::exp(-1e4 * t)) / 1e4); }, 0.01),
      1e-8);
}

TEST_P(Blocks, StateSpaceHasSeveralInputsAndOutputs) {
  const std::string model = R"y(
signals:
  plant:
    state_space: [1, "sin(3*t)"]
    A: [[0, 1], [-4, 0]]
    B: [[0, 0], [1, 0]]
    C: [[1, 0], [0, 1], [0, 0]]
    D: [[0, 0], [0, 0], [2, 5]]
    initial: [0.5, 0]
    outputs: [place, speed, through]
)y";
  EXPECT_LT(worst(
                model, "signal.plant.place", [](double t) { return 0.25 + 0.25 * std::cos(2 * t); }, 0.01),
            1e-13);
  EXPECT_LT(worst(
                model, "signal.plant.speed", [](double t) { return -0.5 * std::sin(2 * t); }, 0.01),
            1e-13);
  EXPECT_LT(worst(
                model, "signal.plant.through", [](double t) { return 2 + 5 * std::sin(3 * t); }, 0.01),
            1e-13);
}

TEST_P(Blocks, APidControllerGivesItsStepResponse) {
  const std::string of =
      "signals: {y: {pid: \"-0.5*t\", setpoint: 2, kp: 3, ki: 4, kd: 0.5, filter: 0.05, setpoint_weight: "
      "0.7, integral: 1}}\n";
  // e = 2 + t/2; the derivative of t/2 through its filter.
  EXPECT_LT(worst(
                of, "signal.y",
                [](double t) {
                  return 3 * (0.7 * 2 + 0.5 * t) + 1 + 4 * (2 * t + 0.25 * t * t) +
                         0.5 * 0.5 * (1 - std::exp(-t / 0.05));
                },
                0.01),
            1e-12);
}

/// At the limit the integral stands still; when the error turns, the output leaves the limit at once.
TEST_P(Blocks, ThePidDoesNotWindUp) {
  const auto error = [](double t) { return t < 0.5 ? 1.0 : 1 - 20 * (t - 0.5); };
  const std::string of =
      "signals: {y: {pid: \"t < 0.5 ? -1 : 20*(t - 0.5) - 1\", kp: 1, ki: 10, upper: 2, lower: -3}}\n";
  EXPECT_LT(worst(
                of, "signal.y",
                [&](double t) {
                  // The integral stops at 1, where the output comes to 2; from t = 0.5 on the proportional
                  // part falls.
                  const double integral = t < 0.1   ? 10 * t
                                          : t < 0.5 ? 1
                                                    : 1 + 10 * ((t - 0.5) - 10 * (t - 0.5) * (t - 0.5));
                  return std::max(-3.0, error(t) + integral);
                },
                0.001),
            1e-12);
}

/// A mass that a PID moves: 1 kg, with a filtered derivative, so of fourth order, against the matrix
/// exponential.
TEST_P(Blocks, APidOnAMotorAxisGivesTheExactClosedLoop) {
  const double kp = 60, ki = 90, kd = 12, T = 0.02;
  // States x, v, ∫(r − x), f with ḟ = (−x − f)/T.
  Eigen::Matrix4d A;
  A << 0, 1, 0, 0,                   //
      -kp - kd / T, 0, ki, -kd / T,  //
      -1, 0, 0, 0,                   //
      -1 / T, 0, 0, -1 / T;
  const Eigen::Vector4d b(0, kp, 1, 0);
  const auto rate = [&](const Eigen::Vector4d& y) -> Eigen::Vector4d { return A * y + b; };
  double before = 0;
  for (const double step : {1e-3, 5e-4}) {
    Simulation s = simulation_of(slider(fmt::format(R"y(
signals:
  force: {{pid: place, setpoint: 1, kp: {}, ki: {}, kd: {}, filter: {}}}
actuators:
  motor: {{joint: guide, force: force}}
)y",
                                                    kp, ki, kd, T),
                                        step),
                                 GetParam());
    const Simulation::Channel x = s.channel("place");
    Eigen::Vector4d y = Eigen::Vector4d::Zero();
    double most = 0;
    int iterations = 0, steps = 0;
    while (s.time() < 1 - 1e-9) {
      const StepReport report = s.step();
      ASSERT_TRUE(report.ok());
      iterations += report.iterations;
      ++steps;
      const int parts = 20;
      for (int k = 0; k < parts; ++k) {
        const double h = step / parts;
        const Eigen::Vector4d k1 = rate(y), k2 = rate(y + h / 2 * k1), k3 = rate(y + h / 2 * k2),
                              k4 = rate(y + h * k3);
        y += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
      }
      most = std::max(most, std::abs(s.value(x) - y[0]));
    }
    EXPECT_LT(most, 2e-4);
    EXPECT_LT(iterations, 2.5 * steps);  // Newton sees the tangents of the loop
    if (before > 0) {
      EXPECT_NEAR(before / most, 4, 0.5);
    }
    before = most;
  }
}

TEST_P(Blocks, SampledOnesAreDifferenceEquations) {
  // y[k] = 0.8 y[k−1] − 0.15 y[k−2] + 0.5 u[k−1] + 0.1 u[k−2], sampled every 10 ms of a step of 2 ms; the PID
  // by the trapezoidal rule; a rate limit; a delay of three samples.
  Simulation s = simulation_of(slider(R"y(
signals:
  u: "sin(7*t) + 1"
  y: {transfer_function: u, numerator: [0.5, 0.1], denominator: [1, -0.8, 0.15], every: 0.01}
  z: {state_space: u, A: [[0.5, 0.2], [0, 0.3]], B: [1, 2], C: [1, 1], D: 3, every: 0.01}
  pid: {pid: u, setpoint: 3, kp: 2, ki: 5, kd: 0.1, filter: 0.02, every: 0.01}
  limited: {rate_limit: u, rising: 3, falling: -1, every: 0.01}
  late: {delay: u, time: 0.03, every: 0.01}
  relay: {hysteresis: u, rises_at: 1.8, falls_at: 0.3, low: -1, high: 2, every: 0.01}
)y",
                                      0.002),
                               GetParam());
  std::vector<double> u, y, limited;
  double I = 0, f = 0, relay = -1;
  Eigen::Vector2d x = Eigen::Vector2d::Zero();
  const Eigen::Matrix2d A = (Eigen::Matrix2d() << 0.5, 0.2, 0, 0.3).finished();
  for (int k = 0; k < 90; ++k) {
    u.push_back(std::sin(0.07 * k) + 1);
    const auto before = [&](const std::vector<double>& of, int back) {
      return k - back >= 0 ? of[static_cast<std::size_t>(k - back)] : 0;
    };
    y.push_back(0.8 * before(y, 1) - 0.15 * before(y, 2) + 0.5 * before(u, 1) + 0.1 * before(u, 2));
    limited.push_back(k == 0 ? u[0] : std::clamp(u.back(), limited.back() - 0.01, limited.back() + 0.03));
    if (k == 0) {
      f = -u[0];
    } else {
      I += 5 * 0.01 * 0.5 * (6 - u.back() - before(u, 1));
      const double phi = std::exp(-0.5), gamma = 1 - (1 - phi) / 0.5;
      f = phi * f + (1 - phi) * -before(u, 1) + gamma * (before(u, 1) - u.back());
    }
    const double pid = 2 * (3 - u.back()) + I + 0.1 * (-u.back() - f) / 0.02;
    relay = u.back() >= 1.8 ? 2 : u.back() <= 0.3 ? -1 : relay;
    const double z = x.sum() + 3 * u.back();
    x = A * x + Eigen::Vector2d(1, 2) * u.back();
    for (int part = 0; part < 5; ++part) ASSERT_TRUE(s.step().ok());
    const auto is = [&](const char* name, double value) {
      EXPECT_NEAR(s.value(s.channel(std::string("signal.") + name)), value, 1e-12 * (1 + std::abs(value)))
          << name << ' ' << k;
    };
    is("y", y.back());
    is("z", z);
    is("pid", pid);
    is("limited", limited.back());
    is("late", k < 3 ? u[0] : before(u, 3));
    is("relay", relay);
  }
}

TEST_P(Blocks, ARateLimitFollowsAsFastAsItMay) {
  EXPECT_LT(worst(
                "signals: {y: {rate_limit: \"sin(4*t)\", rising: 2}}\n", "signal.y",
                [](double t) {
                  // At 2 per second until it meets the sine; then with that, until that falls faster.
                  const double leaves = std::acos(-0.5) / 4;
                  return t < leaves ? std::min(2 * t, std::sin(4 * t))
                                    : std::sin(4 * leaves) - 2 * (t - leaves);
                },
                0.001),
            1e-5);
}

TEST_P(Blocks, ADelayGivesWhatWas) {
  // Lines are exact; the step may be longer than the delay.
  for (const double step : {0.01, 0.1})
    EXPECT_LT(worst(
                  "signals: {y: {delay: \"3*t + 1\", time: 0.055}}\n", "signal.y",
                  [](double t) { return t < 0.055 ? 1 : 3 * (t - 0.055) + 1; }, step, step + 1e-9 + 0.055),
              1e-12);
  EXPECT_LT(worst(
                "signals: {y: {delay: \"sin(5*t)\", time: 0.2}}\n", "signal.y",
                [](double t) { return t < 0.2 ? 0 : std::sin(5 * (t - 0.2)); }, 0.01),
            25 * 1e-4 / 8 + 1e-9);
  // More steps over the delay than it keeps points.
  EXPECT_LT(worst(
                "signals: {y: {delay: \"sin(5*t)\", time: 0.9}}\n", "signal.y",
                [](double t) { return t < 0.9 ? 0 : std::sin(5 * (t - 0.9)); }, 5e-4),
            1e-5);
}

TEST_P(Blocks, AnInputThatJumpsCountsFromThereOn) {
  Simulation s = simulation_of(slider(R"y(
inputs: {push: 0}
signals:
  smooth: {transfer_function: push, numerator: [1], denominator: [0.1, 1]}
  late: {delay: push, time: 0.025}
)y",
                                      0.01),
                               GetParam());
  const auto smooth = s.channel("signal.smooth"), late = s.channel("signal.late");
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(s.step().ok());
  s.set_input(s.input("push"), 4);
  for (int k = 1; k <= 50; ++k) {
    ASSERT_TRUE(s.step().ok());
    EXPECT_NEAR(s.value(smooth), 4 * (1 - std::exp(-0.1 * k)), 1e-12);
    EXPECT_NEAR(s.value(late), k <= 2 ? 0 : 4, 1e-12) << k;
  }
}

TEST_P(Blocks, HysteresisSwitchesAtItsThresholds) {
  // A triangle from 0 to 1 and back.
  Simulation s = simulation_of(slider("signals: {y: {hysteresis: \"t < 0.5 ? 2*t : 2 - 2*t\", rises_at: "
                                      "0.69, falls_at: 0.31, high: 5}}\n",
                                      0.01),
                               GetParam());
  for (int k = 1; k <= 100; ++k) {
    ASSERT_TRUE(s.step().ok());
    EXPECT_EQ(s.value(s.channel("signal.y")), k >= 35 && k < 85 ? 5 : 0) << k;
  }
}

/// A mass that a relay pushes to and fro goes on parabolas from one switching to the next, at whatever steps.
TEST_P(Blocks, HysteresisSwitchesWithinAStep) {
  for (const double step : {0.01, 0.007, 0.1}) {
    Simulation s = simulation_of(slider("signals: {push: {hysteresis: place, rises_at: 0.1, falls_at: -0.1, "
                                        "low: 3, high: -3}}\n"
                                        "actuators: {motor: {joint: guide, force: push}}\n",
                                        step, 4),
                                 GetParam());
    double place = 0, speed = 0, force = 3, at = 0;
    int switches = 0;
    while (s.time() < 4 - 1e-9) {
      ASSERT_TRUE(s.step().ok());
      for (;;) {
        // The next time at which place + speed t + ½ force t² passes the threshold ahead, moving towards it.
        const double to = force > 0 ? 0.1 : -0.1;
        const double root = std::sqrt(speed * speed + 2 * force * (to - place));
        const double wait = ((force > 0 ? root : -root) - speed) / force;
        const double rest = s.time() - at, go = std::min(wait, rest);
        place += speed * go + 0.5 * force * go * go;
        speed += force * go;
        at += go;
        if (wait > rest) break;
        force = -force;
        ++switches;
      }
      ASSERT_NEAR(s.value(s.channel("place")), place, 1e-6) << s.time() << " " << step;
      ASSERT_NEAR(s.value(s.channel("speed")), speed, 1e-6) << s.time() << " " << step;
      ASSERT_EQ(s.value(s.channel("signal.push")), force);
    }
    EXPECT_GE(switches, 4);
  }
}

/// What is due more often than there are steps is refused, with both numbers.
TEST(BlockIntervals, AreNoShorterThanTheSteps) {
  const auto refused = [](const std::string& signal, double step) {
    const auto model = model_of(slider("signals: {s: {" + signal + "}}\n", 0.01));
    try {
      simulation_of(model, Formulation::relative, step);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  for (const char* signal : {"noise: normal, every: 0.004", "value: place, every: 0.004",
                             "delay: place, time: 0.02, every: 0.004"}) {
    EXPECT_THAT(refused(signal, 0.01),
                HasSubstr("signal 's' is evaluated every 0.004 s, and the steps are of "
                          "0.01 s: take steps of 0.004 s or shorter"));
    EXPECT_EQ(refused(signal, 0.004), "accepted");
    EXPECT_EQ(refused(signal, 0.003), "accepted");
  }
}

TEST_P(Blocks, TablesOfOneAndOfTwoVariables) {
  EXPECT_LT(worst(
                "signals: {y: {table: \"4*t\", points: [[0, 1], [1, 3], [3, 0]]}}\n", "signal.y",
                [](double t) { return 4 * t < 1 ? 1 + 8 * t : 3 - 1.5 * (4 * t - 1); }, 0.01),
            1e-12);
  // Bilinear functions are met exactly, also beyond the edges.
  EXPECT_LT(worst(
                "signals: {y: {table: [\"3*t - 1\", \"2 - 4*t\"], x: [0, 0.5, 1], y: [-1, 1], "
                "values: [[-2, 4], [-2.5, 6.5], [-3, 9]]}}\n",
                "signal.y",
                [](double t) {
                  const double x = 3 * t - 1, y = 2 - 4 * t;
                  return 1 + 2 * x + 3 * y + 3 * x * y;
                },
                0.01),
            1e-12);
}

TEST_P(Blocks, NoiseHasItsMomentsAndItsSeed) {
  for (const char* kind : {"normal", "uniform"}) {
    const auto course = [&](double step, int seed) {
      Simulation s = simulation_of(
          slider(fmt::format("signals: {{n: {{noise: {}, mean: 2, deviation: 3, seed: {}, every: 0.01}}}}\n",
                             kind, seed),
                 step, 100),
          GetParam());
      std::vector<double> values;
      const auto n = s.channel("signal.n");
      const int parts = static_cast<int>(std::lround(0.01 / step));
      for (int k = 0; k < 4000; ++k) {
        for (int part = 0; part < parts; ++part) s.step();
        values.push_back(s.value(n));
      }
      return values;
    };
    const std::vector<double> values = course(0.01, 1);
    double mean = 0, square = 0, fourth = 0, next = 0;
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double x = (values[k] - 2) / 3;
      mean += x / 4000, square += x * x / 4000, fourth += x * x * x * x / 4000;
      if (k > 0) next += x * (values[k - 1] - 2) / 3 / 4000;
    }
    // Within four standard deviations of these sums.
    EXPECT_NEAR(mean, 0, 4 / std::sqrt(4000.0));
    EXPECT_NEAR(square, 1, 4 * std::sqrt(2 / 4000.0));
    EXPECT_NEAR(fourth, std::string(kind) == "normal" ? 3 : 1.8, 4 * std::sqrt(96 / 4000.0));
    EXPECT_NEAR(next, 0, 4 / std::sqrt(4000.0));
    EXPECT_EQ(course(0.005, 1), values);  // whatever the step
    EXPECT_NE(course(0.01, 2), values);
  }
}

/// ẏ = −5 (y − 1), by an integrator that sees itself.
TEST_P(Blocks, LoopsThroughWhatDoesNotFeedThroughAreSolved) {
  const std::string loop =
      "signals: {y: {transfer_function: error, numerator: [1], denominator: [1, 0]}, error: \"5*(1 - y)\"}\n";
  double before = 0;
  for (const double step : {0.02, 0.01}) {
    const double off = worst(
        loop, "signal.y", [](double t) { return 1 - std::exp(-5 * t); }, step);
    EXPECT_LT(off, 2e-3);
    if (before > 0) {
      EXPECT_NEAR(before / off, 4, 0.3);  // lines between the steps: second order
    }
    before = off;
  }
  // With the motion in the loop.
  EXPECT_LT(worst(
                "signals: {y: {transfer_function: error, numerator: [1], denominator: [1, 0]}, error: \"5*(1 "
                "- y) + 0*place\"}\n",
                "signal.y", [](double t) { return 1 - std::exp(-5 * t); }, 0.01),
            2e-3);
}

/// Saved and restored, cloned, in parts: the same bits.
TEST_P(Blocks, WhatTheyRememberIsInTheState) {
  const std::string model = slider(R"y(
inputs: {push: 0}
signals:
  force: {pid: place, setpoint: "1 + push", kp: 60, ki: 90, kd: 12, filter: 0.02, upper: 50}
  smooth: {transfer_function: "place + push", numerator: [1, 2], denominator: [0.1, 0.5, 1]}
  late: {delay: "speed", time: 0.031}
  limited: {rate_limit: "sin(20*place)", rising: 3}
  relay: {hysteresis: place, rises_at: 0.3, falls_at: 0.1}
  sampled: {state_space: place, A: 0.9, B: 1, C: 1, every: 0.004}
  n: {noise: normal, seed: 4, every: 0.003}
actuators: {motor: {joint: guide, force: "force + 0.1*relay + late + 0.01*n"}}
)y",
                                   0.001);
  Simulation a = simulation_of(model, GetParam()), b = simulation_of(model, GetParam());
  for (int k = 0; k < 137; ++k) ASSERT_TRUE(a.step().ok());
  a.set_input(a.input("push"), 0.2);
  b.restore(Simulation::Snapshot::from_bytes(a.save().bytes()));
  ResultsRow one, other;
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(a.step().ok());
    ASSERT_TRUE(b.step().ok());
    a.sample(one);
    b.sample(other);
    ASSERT_TRUE(one.channels == other.channels) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(BothFormulations, Blocks,
                         testing::Values(Formulation::relative, Formulation::natural));

TEST(BlockErrors, NameWhatIsWrong) {
  const auto refused = [](const std::string& signals) {
    return refusal_of(slider("signals: {" + signals + "}\n", 0.01));
  };
  EXPECT_THAT(refused("a: {pid: b, kp: 1}, b: {rate_limit: a, rising: 1}"), HasSubstr("'a' → 'b' → 'a'"));
  EXPECT_THAT(refused("a: {transfer_function: b, numerator: [1, 0], denominator: [1, 1]}, b: 2*a"),
              HasSubstr("in a circle"));
  EXPECT_EQ(refused("a: {transfer_function: b, numerator: [1], denominator: [1, 1]}, b: 2*a"), "accepted");
  EXPECT_EQ(refused("a: {delay: b, time: 0.1}, b: 0.5*a + 1"), "accepted");
  EXPECT_THAT(refused("a: {transfer_function: place, numerator: [1, 0, 0], denominator: [1, 1]}"),
              HasSubstr("of degree 2, above 1"));
  EXPECT_THAT(refused("a: {transfer_function: place, numerator: [1], denominator: [0, 0]}"),
              HasSubstr("denominator is 0"));
  EXPECT_THAT(refused("a: {state_space: place, A: [[1, 2], [3, 4]], B: [1, 2, 3], C: [1, 0]}"),
              HasSubstr("B is 3 x 1"));
  EXPECT_THAT(refused("a: {state_space: place, A: -1, B: 1, C: [[1], [1]]}"),
              HasSubstr("2 outputs and 1 names"));
  EXPECT_THAT(refused("a: {pid: place, kp: 1, kd: 2}"), HasSubstr("filter"));
  EXPECT_THAT(refused("a: {pid: place}"), HasSubstr("no gain"));
  EXPECT_THAT(refused("a: {pid: place, kp: 1, lower: 2, upper: 1}"), HasSubstr("lower"));
  EXPECT_THAT(refused("a: {pid: place, kpp: 1}"), HasSubstr("kpp"));
  EXPECT_THAT(refused("a: {delay: place}"), HasSubstr("'time' is missing"));
  EXPECT_THAT(refused("a: {delay: place, time: 0.015, every: 0.01}"), HasSubstr("whole number of 'every'"));
  EXPECT_THAT(refused("a: {delay: place, time: -1}"), HasSubstr("above 0"));
  EXPECT_THAT(refused("a: {hysteresis: place, rises_at: 1, falls_at: 2}"), HasSubstr("falls_at is 2"));
  EXPECT_THAT(refused("a: {noise: normal}"), HasSubstr("'every' is missing"));
  EXPECT_THAT(refused("a: {noise: pink, every: 1}"), HasSubstr("pink"));
  EXPECT_THAT(refused("a: {noise: normal, seed: 0.5, every: 1}"), HasSubstr("whole number"));
  EXPECT_THAT(refused("a: {table: [place, speed], x: [0, 1], y: [1, 1], values: [[1, 2], [3, 4]]}"),
              HasSubstr("y does not ascend"));
  EXPECT_THAT(refused("a: {table: [place, speed], x: [0, 1], y: [0, 1], values: [[1, 2]]}"),
              HasSubstr("values is 1 x 2"));
  EXPECT_THAT(refused("a: {rate_limit: a2, rising: 1}"), HasSubstr("a2"));
  EXPECT_THAT(refusal_of(slider("signals: {a: {rate_limit: t, rising: 1}}\n", 0.01)
                             .replace(slider("", 0.01).find("axis: [1, 0, 0]"), 15,
                                      "axis: [1, 0, 0], drive: {position: a}")),
              HasSubstr("whose rate is not known"));
}

}  // namespace
}  // namespace mimbre::test::blocks_test
