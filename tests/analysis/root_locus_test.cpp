#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <string>
#include <vector>

#include "mimbre/campbell.h"
#include "mimbre/trim.h"
#include "support/models.h"
#include "support/plain_car.h"

/// Modes of steady driving over a held condition, an input and a parameter: against steady driving at single
/// values and closed forms.
namespace mimbre::test::root_locus_test {
namespace {

ModesOptions driving(const TrimConditions& conditions) {
  ModesOptions options;
  options.linear.point.at = LinearPoint::At::trim;
  options.linear.trim = conditions;
  return options;
}

CampbellDiagram over_condition(const std::shared_ptr<const Model>& model, const TrimConditions& conditions,
                               const std::string& name, const std::vector<double>& values) {
  CampbellOptions options;
  options.parameter = name;
  options.rad_per_second = 0;
  NeighbouringModes modes;
  return campbell(
      [&](double value) {
        ModesOptions here = driving(conditions);
        *held_condition(here.linear.trim, name) = value;
        return modes.find(value, model, here);
      },
      values, options);
}

std::vector<double> from_to(double from, double to, int count) {
  std::vector<double> out;
  for (int k = 0; k < count; ++k) out.push_back(from + (to - from) * k / (count - 1));
  return out;
}

/// The largest real part of a mode that is not rigid.
double growth(const std::shared_ptr<const Model>& model, double speed) {
  double most = -1e300;
  for (const Mode& m : find_modes(model, driving(turn(speed, 0, {"steer", "push"}))).modes)
    if (m.kind != Mode::Kind::rigid) most = std::max(most, m.value.real());
  return most;
}

/// An oversteering car begins to grow at its critical speed, v² = L/(−K): found between values that are far
/// apart, as by halving the interval.
TEST(RootLocus, BeginsToGrowAtTheCriticalSpeed) {
  PlainCar car;
  car.front_grip = 1.5;
  const double critical = std::sqrt(car.base() / -car.understeer());
  const auto model = model_of(car.text());
  const CampbellDiagram found = over_condition(model, turn(10, 0, {"steer", "push"}), "speed",
                                               from_to(0.7 * critical, 1.3 * critical, 7));
  ASSERT_EQ(found.onsets.size(), 1u);
  EXPECT_TRUE(found.onsets[0].grows);
  EXPECT_NEAR(found.onsets[0].frequency, 0, 1e-9);
  EXPECT_NEAR(found.onsets[0].value, critical, 0.1 * critical);
  const double low = 0.9 * critical, high = 1.1 * critical;
  ASSERT_LT(growth(model, low), 0);
  ASSERT_GT(growth(model, high), 0);
  // Straight lines through two speeds, at last just beside the onset on both sides: λ of the onset itself is
  // that of a rigid motion.
  double a = low, b = high, fa = growth(model, a), fb = growth(model, b), exact = 0;
  for (const double beside : {1e-2, -1e-2, 1e-3, -1e-3, 1e-4, -1e-4}) {
    exact = b - fb * (b - a) / (fb - fa);
    a = b, fa = fb;
    b = exact + beside * critical, fb = growth(model, b);
  }
  exact = b - fb * (b - a) / (fb - fa);
  EXPECT_NEAR(found.onsets[0].value, exact, 1e-6 * exact);
}

/// Values are those of single searches, on a circle, where inputs, sideslip and loads differ from each to the
/// next.
TEST(RootLocus, HasTheModesOfEachValue) {
  const auto model = model_of(PlainCar().text());
  TrimConditions c;
  c.speed = 10;
  c.radius = 60;
  c.find = {"steer", "push"};
  const std::vector<double> values = from_to(6, 18, 5);
  const CampbellDiagram found = over_condition(model, c, "speed", values);
  EXPECT_TRUE(found.warnings.empty()) << found.warnings.front();
  EXPECT_TRUE(found.onsets.empty());
  for (std::size_t k = 0; k < values.size(); ++k) {
    c.speed = values[k];
    const LinearisedModes alone = find_modes(model, driving(c));
    ASSERT_TRUE(alone.model.driving);
    EXPECT_NEAR(alone.model.driving->speed, values[k], 1e-9);
    EXPECT_NEAR(alone.model.driving->yaw_rate, values[k] / 60, 1e-9);
    for (const Mode& mode : alone.modes) {
      double nearest = 1e300;
      for (const ModeBranch& b : found.branches)
        if (std::isfinite(b.values[k].real()))
          nearest = std::min(nearest, std::abs(b.values[k] - mode.value));
      EXPECT_LE(nearest, 1e-6 * std::max(1.0, std::abs(mode.value))) << values[k] << ' ' << mode.value;
    }
  }
}

/// Around a circle of 5 m the wheels are turned by half a radian: too far from the start of the model,
/// straight on, and found from neighbours.
TEST(RootLocus, GoesOnFromNeighbours) {
  const auto model = model_of(PlainCar().text());
  TrimConditions c = turn(3, 0, {"steer", "push"});
  c.lateral_acceleration.reset();
  c.yaw_rate = 0.6;
  EXPECT_THROW(find_modes(model, driving(c)), std::runtime_error);
  NeighbouringModes modes;
  std::shared_ptr<const DrivingState> last;
  for (const double rate : {0.3, 0.4, 0.5, 0.6}) {
    ModesOptions here = driving(c);
    here.linear.trim.yaw_rate = rate;
    last = modes.find(rate, model, here).model.driving;
    ASSERT_TRUE(last);
    EXPECT_NEAR(last->yaw_rate, rate, 1e-9);
    EXPECT_NEAR(last->speed, 3, 1e-9);
  }
  // Without slip the front wheels steer by atan(L/R), with R that of the rear axle.
  const PlainCar car;
  const double radius = std::sqrt(25 - car.rear * car.rear);
  EXPECT_NEAR(last->inputs.at("steer"), std::atan(car.base() / radius), 0.07);
}

/// Where there is no steady driving the message has the value.
TEST(RootLocus, NamesTheValueThatFails) {
  const auto model = model_of(PlainCar().text());
  TrimConditions c;
  c.speed = 20;
  c.find = {"steer", "push"};
  try {
    over_condition(model, c, "lateral_acceleration", {2, 12});
    ADD_FAILURE();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::StartsWith("lateral_acceleration = 12: no steady driving"));
  }
}

/// Over a parameter each value has its own trim: the heavier chassis sinks, and more of it is to be pushed.
TEST(RootLocus, TrimsAnewForEachModel) {
  const auto model_at = [](double chassis) {
    PlainCar car;
    car.chassis = chassis;
    return model_of(car.text());
  };
  TrimConditions c;
  c.speed = 20;
  c.lateral_acceleration = 2;
  c.find = {"steer", "push"};
  CampbellOptions options;
  options.parameter = "chassis";
  options.rad_per_second = 0;
  NeighbouringModes modes;
  const std::vector<double> values{1000, 1200, 1400};
  const CampbellDiagram found =
      campbell([&](double value) { return modes.find(value, model_at(value), driving(c)); }, values, options);
  EXPECT_TRUE(found.warnings.empty()) << found.warnings.front();
  for (std::size_t k = 0; k < values.size(); ++k)
    for (const Mode& mode : find_modes(model_at(values[k]), driving(c)).modes) {
      double nearest = 1e300;
      for (const ModeBranch& b : found.branches)
        nearest = std::min(nearest, std::abs(b.values[k] - mode.value));
      EXPECT_LE(nearest, 1e-6 * std::max(1.0, std::abs(mode.value))) << values[k] << ' ' << mode.value;
    }
}

}  // namespace
}  // namespace mimbre::test::root_locus_test
