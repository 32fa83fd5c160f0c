#include "mimbre/trim.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "analysis/trim_point.h"
#include "mimbre/diagnostics.h"
#include "mimbre/modes.h"
#include "simulation/start/assembly.h"
#include "support/models.h"
#include "support/plain_car.h"
#include "support/simulate.h"

/// Steady driving: against a bicycle, against runs, and the Iltis of the examples.
namespace mimbre::test::trim_test {
namespace {

TEST(Trim, SaysWhichWayTheFloatingJointIsNeeded) {
  std::string text = PlainCar().text();
  const std::string joint = "between: [ground, chassis]";
  ASSERT_NE(text.find(joint), std::string::npos);
  text.replace(text.find(joint), joint.size(), "between: [chassis, ground]");
  try {
    trim(model_of(text), turn(15, 2, {"steer", "push"}));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("goes from the body to the ground; write it from the ground "
                                                 "to the body, `between: [ground, chassis]`"));
  }
}

/// The steering beyond that of the radius, for each m/s² of lateral acceleration, is the bicycle's.
TEST(Trim, SteersAsABicycleDoes) {
  const PlainCar car;
  const auto model = model_of(car.text());
  const double speed = 20;
  const auto steer = [&](double across) {
    return trim(model, turn(speed, across, {"steer", "push"})).found[0].value;
  };
  const double gradient = (steer(0.2) - steer(-0.2)) / 0.4 - car.base() / (speed * speed),
               bicycle = car.understeer();
  EXPECT_NEAR(gradient, bicycle, 0.05 * bicycle);  // as in runs (tyre_test.cpp)
  EXPECT_NEAR(steer(1.5), -steer(-1.5), 1e-9);
}

/// The car's origin, which is its centre of mass, moves to the side by b/R, less the slip of the rear axle.
TEST(Trim, SlipsAsABicycleDoes) {
  const PlainCar car;
  const auto model = model_of(car.text());
  const auto sideslip = [&](double speed, double across) {
    return trim(model, turn(speed, across, {"steer", "push"})).sideslip;
  };
  for (const double speed : {8., 20.}) {
    const double slope = (sideslip(speed, 0.2) - sideslip(speed, -0.2)) / 0.4,
                 slip = car.rear / (speed * speed) - slope;
    EXPECT_NEAR(slip, car.rear_slip(), 0.02 * car.rear_slip()) << speed;
  }
}

/// Speed, sideslip and radius are those of the body's origin, wherever the frames of its joint are.
TEST(Trim, IsThatOfTheBodyWhereverItsFrameIs) {
  PlainCar car;
  const TrimResult here = trim(model_of(car.text()), turn(12, 2, {"steer", "push"}));
  car.frame = 2;
  const TrimResult there = trim(model_of(car.text()), turn(12, 2, {"steer", "push"}));
  EXPECT_NEAR(here.speed, 12, 1e-9);
  EXPECT_NEAR(there.speed, 12, 1e-9);
  EXPECT_NEAR(there.sideslip, here.sideslip, 1e-9);
  EXPECT_NEAR(there.yaw_rate, here.yaw_rate, 1e-9);
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_NEAR(there.found[k].value, here.found[k].value, 1e-6 * std::abs(here.found[k].value));
}

/// Rolling resistance is what the motors push against, at the loaded radius.
TEST(Trim, PushesAgainstWhatResists) {
  const PlainCar car;
  const TrimResult straight = trim(model_of(car.text()), turn(25, 0, {"steer", "push"}));
  EXPECT_NEAR(straight.found[0].value, 0, 1e-10);
  const double resistance =
      0.01 * car.mass() * PlainCar::g;  // at the drawn radius, by moments about the wheels
  EXPECT_NEAR(2 * straight.found[1].value, resistance * car.radius, 0.02 * resistance * car.radius);
  EXPECT_NEAR(straight.speed, 25, 1e-9);
  EXPECT_LT(straight.residual, 1e-9);
}

/// Radius, yaw rate and lateral acceleration are one condition in three forms; held steering is the fourth.
TEST(Trim, TakesAnyConditionOfATurn) {
  const PlainCar car;
  const auto model = model_of(car.text());
  const TrimResult by_acceleration = trim(model, turn(20, 2, {"steer", "push"}));
  TrimConditions c;
  c.speed = 20;
  c.radius = 200;
  c.find = {"steer", "push"};
  const TrimResult by_radius = trim(model, c);
  c.radius.reset();
  c.yaw_rate = 0.1;
  const TrimResult by_rate = trim(model, c);
  c.yaw_rate.reset();
  c.find = {"push"};
  RunOptions held;
  held.inputs["steer"] = by_acceleration.found[0].value;
  const TrimResult by_steering = trim(model, c, held);
  EXPECT_NEAR(by_radius.found[0].value, by_acceleration.found[0].value, 1e-10);
  EXPECT_NEAR(by_rate.found[1].value, by_acceleration.found[1].value, 1e-6);
  EXPECT_NEAR(by_steering.yaw_rate, 0.1, 1e-9);
}

/// A run from there goes on so.
TEST(Trim, IsAMotionThatStays) {
  const PlainCar car;
  const auto model = model_of(car.text());
  const Compiled& m = model->compiled();
  relative::RelativeSystem system(m);
  const State start = assembled_state(m, system, {});
  const linear::Trim found = linear::find_trim(m, system, start, {}, turn(20, 3, {"steer", "push"}));
  RunOptions options;
  options.formulation = spec::Simulation::Formulation::relative;
  options.inputs = found.inputs;
  Simulation s(model, options);
  Simulation::Snapshot from = s.save();
  from.q = found.state.q;
  from.v = found.state.v;
  from.a = from.algorithmic = found.state.a;
  from.z = found.state.z;
  from.u = found.state.u;
  s.restart(from);
  run_to(s, 3);
  EXPECT_NEAR(channel(s, "yaw_rate"), 0.15, 2e-6);
  EXPECT_NEAR(std::hypot(channel(s, "vx"), channel(s, "vy")), 20, 2e-4);
}

LinearisedModes modes_at(const std::shared_ptr<const Model>& model, const TrimConditions& conditions) {
  ModesOptions options;
  options.linear.point.at = LinearPoint::At::trim;
  options.linear.trim = conditions;
  return find_modes(model, options);
}

int rigid_ones(const LinearisedModes& found) {
  return static_cast<int>(std::count_if(found.modes.begin(), found.modes.end(),
                                        [](const Mode& m) { return m.kind == Mode::Kind::rigid; }));
}

/// Straight on there are as many zeros as the plane has motions, and those of the wheels. At low speed the
/// car is stable; it grows unstable beyond the critical speed where it oversteers: v² = L/(−K).
TEST(Trim, ModesFindTheCriticalSpeed) {
  PlainCar car;
  car.front_grip = 1.5;
  const double gradient = car.understeer();
  ASSERT_LT(gradient, 0);
  const double critical = std::sqrt(car.base() / -gradient);
  const auto model = model_of(car.text());
  const auto grows = [&](double speed) {
    const LinearisedModes found = modes_at(model, turn(speed, 0, {"steer", "push"}));
    EXPECT_GE(rigid_ones(found), 6);  // x, y, four wheels
    return std::any_of(found.modes.begin(), found.modes.end(), [](const Mode& m) { return m.grows; });
  };
  EXPECT_FALSE(grows(0.9 * critical));
  EXPECT_TRUE(grows(1.1 * critical));
}

/// On a circle, too, A is constant, in axes that turn with the car: moved as a whole the car goes round
/// beside its circle, which is a mode ±iΩ there. To the left and to the right modes are the same.
TEST(Trim, ModesOnACircle) {
  const PlainCar car;
  const auto model = model_of(car.text());
  TrimConditions c;
  c.speed = 12;
  c.radius = 50;
  c.find = {"steer", "push"};
  const LinearisedModes left = modes_at(model, c);
  c.radius = -50;
  const LinearisedModes right = modes_at(model, c);
  EXPECT_EQ(rigid_ones(left), 5);  // heading, four wheels
  EXPECT_EQ(rigid_ones(right), 5);
  ASSERT_EQ(left.modes.size(), right.modes.size());
  int round = 0;
  for (std::size_t k = 0; k < left.modes.size(); ++k) {
    const std::complex<double> one = left.modes[k].value;
    EXPECT_LE(std::abs(one - right.modes[k].value), 1e-6 * std::abs(one)) << k << one;
    EXPECT_FALSE(left.modes[k].grows) << k;
    round += std::abs(one - std::complex<double>(0, 12. / 50)) < 1e-6;
  }
  EXPECT_EQ(round, 1);
}

TEST(Trim, NamesWhatDoesNotGoTogether) {
  using testing::HasSubstr;
  const auto model = model_of(PlainCar().text());
  const auto message = [&](const TrimConditions& c) {
    try {
      trim(model, c);
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(message(turn(20, 1, {"steer"})), HasSubstr("2 conditions"));
  EXPECT_THAT(message(turn(20, 1, {"steer", "pull"})), HasSubstr("pull"));
  EXPECT_THAT(message(turn(20, 12, {"steer", "push"})), HasSubstr("no steady driving"));
  TrimConditions c = turn(20, 1, {"steer", "push"});
  c.body = "wfl";
  EXPECT_THAT(message(c), HasSubstr("chassis"));
  c.body.clear();
  c.radius = 10;
  EXPECT_THAT(message(c), HasSubstr("one of"));
  EXPECT_THAT(message(turn(20, 1, {"steer", "steer"})), HasSubstr("to be found twice"));
}

/// Uphill the start is far from any steady motion; where a slope begins ahead of the front wheels it is not.
TEST(Trim, NeedsALevelRoad) {
  const std::string level = "[[-1000, 0], [1000, 0]]";
  for (const auto& [road, message] : {std::pair{"[[-1000, -30], [1000, 30]]", "no steady driving was found"},
                                      {"[[-1000, 0], [1.3, 0], [1000, 30]]", "further on"}}) {
    std::string text = PlainCar().text();
    text.replace(text.find(level), level.size(), road);
    try {
      trim(model_of(text), turn(20, 0, {"steer", "push"}));
      ADD_FAILURE() << road;
    } catch (const std::exception& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(message)) << road;
    }
  }
}

/// Where a controller's output rests at its limit, its states do not move: found all the same, or refused.
TEST(Trim, StandsLimitsOfControllers) {
  const auto model = example("iltis/steady.yaml", {{"arms", "rigid"}, {"links", "rigid"}, {"rods", "rigid"}});
  const auto found = [&](const TrimConditions& c) {
    try {
      const TrimResult r = trim(model, c);
      EXPECT_TRUE(r.values.allFinite());
      EXPECT_LT(r.residual, 1e-7);
      return true;
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("steady driving"));
      return false;
    }
  };
  TrimConditions c;
  c.find = {"steering"};
  c.lateral_acceleration = 1;
  found(c);
  c.lateral_acceleration.reset();
  c.radius = 30;
  found(c);
  c.radius.reset();
  c.speed = 30;
  found(c);
  c.speed.reset();
  c.yaw_rate = 0.3;
  c.find = {"throttle"};
  found(c);
}

/// A line through points.
struct Fit {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  void add(double x, double y) { n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y; }
  double slope() const { return (n * sxy - sx * sy) / (n * sxx - sx * sx); }
  double offset() const { return (sy - slope() * sx) / n; }
};

/// The understeer gradient on a circle of 40 m up to 0.25 g (docs/vehicles.md): by the rack, whose ratio is
/// that at no lateral acceleration. At constant speeds it is that of a run with a driver that speeds up
/// slowly.
TEST(Trim, IltisUndersteersAsInItsRuns) {
  const double base = 2.017, radius = 40, entry = 20;
  const auto kind_of = [](const std::string& kind) {
    return std::map<std::string, std::string>{{"arms", kind}, {"links", kind}, {"rods", kind}};
  };
  const auto gradient = [&](const Fit& rack) { return base / radius / rack.offset() * rack.slope(); };
  std::vector<double> found;
  for (const char* kind : {"rigid", "flexible"}) {
    const auto model = example("iltis/steady.yaml", kind_of(kind));
    Fit rack;
    for (double speed = 6; speed <= 10.01; speed += 0.5) {
      TrimConditions c;
      c.speed = speed;
      c.radius = radius;
      c.find = {"steering", "throttle"};
      const TrimResult r = trim(model, c);
      for (std::size_t k = 0; k < r.channels.size(); ++k)
        if (r.channels[k].name == "rack")
          rack.add(r.lateral_acceleration, r.values[static_cast<Eigen::Index>(k)]);
    }
    found.push_back(gradient(rack));
    EXPECT_NEAR(found.back(), 0.0030, 0.00025) << kind;
  }
  EXPECT_NEAR(found[1], found[0], 0.01 * found[0]);

  std::map<std::string, std::string> set = kind_of("rigid");
  set["gain"] = "0.05";
  Simulation s = simulation_of(example("iltis/constant-radius.yaml", set), Formulation::relative);
  const double x = entry / 2 - std::pow(entry, 3) / 240 / std::pow(radius, 2),
               y = radius + entry * entry / 24 / radius - std::pow(entry, 4) / 2688 / std::pow(radius, 3);
  Fit rack;
  for (int time = 28; time <= 108; time += 2) {
    run_to(s, time);
    rack.add(std::pow(channel(s, "yaw_rate"), 2) * std::hypot(channel(s, "x") - x, channel(s, "y") - y),
             channel(s, "rack"));
  }
  EXPECT_NEAR(gradient(rack), found[0], 0.015 * found[0]);
}

/// Links bend fast and little: the slow modes of the car are those of one that does not bend. Its stiffness
/// of 1e13 1/s² beside them must not take them for rigid motions.
TEST(Trim, IltisModesAreThoseOfRigidLinks) {
  for (const double speed : {10., 20.}) {
    std::vector<std::vector<std::complex<double>>> slow;
    for (const std::string kind : {"rigid", "flexible"}) {
      const auto model = example("iltis/steady.yaml", {{"arms", kind}, {"links", kind}, {"rods", kind}});
      TrimConditions c;
      c.speed = speed;
      c.find = {"throttle"};
      const LinearisedModes found = modes_at(model, c);
      EXPECT_EQ(rigid_ones(found), 6) << kind;  // x, y, four wheels; the heading begins a chain
      slow.emplace_back();
      for (const Mode& m : found.modes)
        if (m.kind != Mode::Kind::rigid && std::abs(m.value) < 19) slow.back().push_back(m.value);
    }
    // The speed that the throttle lets go, roll, pitch, bounce, and yaw: a pair or two real ones.
    ASSERT_EQ(slow[0].size(), speed < 15 ? 6 : 5);
    ASSERT_EQ(slow[1].size(), slow[0].size());
    for (std::size_t k = 0; k < slow[0].size(); ++k)
      EXPECT_LE(std::abs(slow[1][k] - slow[0][k]), 5e-3 * std::abs(slow[0][k])) << slow[1][k];
    EXPECT_NEAR(slow[1][0].real(), speed < 15 ? -0.0119 : -0.00595, 1e-4);
  }
}

}  // namespace
}  // namespace mimbre::test::trim_test
