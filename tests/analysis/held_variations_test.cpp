#include "analysis/held_variations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "support/models.h"

/// Derivatives of channels by inputs and the time, against differences of what a simulation itself shows.
namespace mimbre::test::held_variations_test {
namespace {

/// Inputs in laws of springs, in loads, in controllers and in a drive's torque; a loop, and outputs of its
/// reactions.
const char* const inputs_everywhere = R"yaml(
inputs:
  wanted: {start: 0.2, range: [-1, 1]}
  gain: {start: 1.5}
  wind: {start: 1, hold: linear}
  push: {start: 20, unit: N}
parameters: {k: {value: 30, tunable: true}}
springs:
  rope: {between: [ground, coupler], at: [[0, 0, 2], null], force: "k*(l - 0.5)*(1 + gain^2) + 2*v"}
loads:
  gust: {on: coupler, at: [0, 0, 1], force: [1, 0, 0.5], scale: push*gain^2}
signals:
  angle: {joint: crank}
  rate: {joint_velocity: crank}
  mixed: "sin(angle + wanted)*gain^2 + rate*wanted*k"
  slow: {rate_limit: wanted + 0.1*angle, rising: 3}
  servo: {pid: angle, setpoint: wanted*gain, kp: 2, ki: 3, kd: 0.05, filter: 0.04, upper: 40, lower: -40}
  lag: {transfer_function: wanted + wind, numerator: [1, 2], denominator: [0.02, 1]}
  in_time: "exp(-t)*gain + wanted^2*t^2"
actuators:
  motor: {joint: crank, torque: "servo + 0.1*lag - 0.2*rate"}
outputs:
  - {name: rope, spring_force: rope}
  - {name: height, position: coupler, component: z}
  - {name: held.x, joint_force: crank, component: fx}
  - {name: held.z, joint_force: crank, component: fz}
  - {name: rocker.x, joint_force: rocker, component: fx}
simulation: {step: 0.002, end: 1}
)yaml";

class HeldVariationsOf : public testing::TestWithParam<spec::Simulation::Formulation> {
 protected:
  static std::shared_ptr<const Model> model() {
    return model_of(four_bar_text({{"rocker", ", cut: always, spring: {stiffness: 4, damping: 0.2}"}}) +
                    inputs_everywhere);
  }
  static RunOptions options() {
    RunOptions options;
    options.formulation = GetParam();
    return options;
  }
};

std::vector<double> shown(Simulation& s, const std::vector<int>& channels) {
  std::vector<double> out;
  for (const int channel : channels) out.push_back(s.value(Simulation::Channel{channel}));
  return out;
}

TEST_P(HeldVariationsOf, InputsAreThoseOfDifferences) {
  const auto of = model();
  Simulation s(of, options());
  for (int k = 0; k < 60; ++k) ASSERT_TRUE(s.step().ok());
  std::vector<int> channels;
  for (int k = 0; k < std::ssize(s.channels()); ++k)
    if (!s.channels()[static_cast<std::size_t>(k)].name.starts_with("energy.")) channels.push_back(k);
  const Redundancy found = s.redundancy();
  HeldVariations variations(of, s.method(), found.equations + found.nearly > 0);
  const Simulation::Snapshot there = s.save();
  for (int direction = 0; direction < 3; ++direction) {
    std::vector<double> seed, exact(channels.size());
    for (std::size_t k = 0; k < s.inputs().size(); ++k)
      seed.push_back(std::sin(1.7 * static_cast<double>(k) + direction));
    variations.along(there, seed, 0, channels, exact.data());
    constexpr double h = 1e-3;
    const auto at = [&](double ahead) {
      s.restore(there);
      for (std::size_t k = 0; k < seed.size(); ++k)
        s.set_input(static_cast<int>(k), s.input_value(static_cast<int>(k)) + ahead * seed[k]);
      return shown(s, channels);
    };
    const std::vector<double> a = at(h), b = at(-h), c = at(2 * h), d = at(-2 * h);
    int others = 0;
    for (std::size_t k = 0; k < channels.size(); ++k) {
      const std::string& name = s.channels()[static_cast<std::size_t>(channels[k])].name;
      if (std::isnan(a[k])) continue;
      const double difference = (8 * (a[k] - b[k]) - (c[k] - d[k])) / (12 * h);
      EXPECT_NEAR(exact[k], difference, 1e-8 * std::max(1.0, std::abs(difference)) + 1e-9 * std::abs(a[k]))
          << name;
      if (std::abs(difference) > 1e-3) ++others;
    }
    EXPECT_GT(others, 10);
  }
}

TEST_P(HeldVariationsOf, TheTimeIsThatOfTheFormulas) {
  const auto of = model();
  Simulation s(of, options());
  for (int k = 0; k < 60; ++k) ASSERT_TRUE(s.step().ok());
  HeldVariations variations(of, s.method(), false);
  const std::vector<int> channels{s.channel("signal.in_time").index, s.channel("signal.mixed").index,
                                  s.channel("rope").index};
  std::vector<double> found(channels.size());
  variations.along(s.save(), std::vector<double>(s.inputs().size()), 1, channels, found.data());
  const double t = s.time();
  EXPECT_NEAR(found[0], -std::exp(-t) * 1.5 + 2 * 0.04 * t, 1e-12);
  EXPECT_EQ(found[1], 0);  // the motion is held
  EXPECT_EQ(found[2], 0);
}

INSTANTIATE_TEST_SUITE_P(Formulations, HeldVariationsOf,
                         testing::Values(spec::Simulation::Formulation::relative,
                                         spec::Simulation::Formulation::natural),
                         [](const auto& formulation) {
                           return formulation.param == spec::Simulation::Formulation::relative ? "Relative"
                                                                                               : "Natural";
                         });

}  // namespace
}  // namespace mimbre::test::held_variations_test
