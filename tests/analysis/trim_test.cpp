#include "mimbre/trim.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "analysis/trim_point.h"
#include "mimbre/diagnostics.h"
#include "mimbre/modes.h"
#include "simulation/start/assembly.h"
#include "support/models.h"
#include "support/simulate.h"

/// Steady driving: against a bicycle, against runs, and the Iltis of the examples.
namespace mimbre::test::trim_test {
namespace {

constexpr double g = 9.81;

/// A car of rigid bodies without a suspension, steered in front by an input, driven at the rear axle by
/// another.
struct PlainCar {
  double front = 1.2, rear = 1.4, track = 1.5, height = 0.35, chassis = 1200, wheel = 20, knuckle = 2;
  double radius = 0.3, stiffness = 2e5, cornering = 45e3, load = 3200, half_length = 0.06, front_grip = 0.8;
  double speed = 15;

  double base() const { return front + rear; }
  double mass() const { return chassis + 4 * (wheel + knuckle); }
  double load_of(bool at_front) const { return 0.5 * mass() * g * (at_front ? rear : front) / base(); }

  std::string text() const {
    const double com = -(2 * (wheel + knuckle) * (front - rear)) / chassis;
    std::string bodies =
        fmt::format("bodies:\n  chassis: {{mass: {}, com: [{}, 0, {}], inertia: [400, 1600, 1800]}}\n",
                    chassis, com, height);
    std::string joints = fmt::format(
        "joints:\n  free: {{type: floating, between: [ground, chassis], at: [0, 0, 0], position: [0, 0, {}, "
        "0, 0, 0], "
        "velocity: [{}, 0, 0, 0, 0, 0]}}\n",
        -load_of(true) / stiffness, speed);
    std::string tyres = "tyres:\n", motors = "actuators:\n";
    for (const bool at_front : {true, false})
      for (const double side : {1.0, -1.0}) {
        const std::string name = fmt::format("{}{}", at_front ? 'f' : 'r', side > 0 ? 'l' : 'r');
        const std::string at =
            fmt::format("[{}, {}, {}]", at_front ? front : -rear, side * track / 2, radius);
        bodies += fmt::format(
            "  k{0}: {{mass: {2}, com: {1}, inertia: [0.02, 0.02, 0.02]}}\n  w{0}: {{mass: {3}, com: {1}, "
            "inertia: "
            "[0.5, 0.9, 0.5]}}\n",
            name, at, knuckle, wheel);
        joints += fmt::format(
            "  s{0}: {{type: revolute, between: [chassis, k{0}], at: {1}, axis: [0, 0, 1], drive: "
            "{{position: {2}}}}}\n"
            "  h{0}: {{type: revolute, between: [k{0}, w{0}], at: {1}, axis: [0, 1, 0], velocity: {3}}}\n",
            name, at, at_front ? "steer" : "\"0\"", speed / radius);
        tyres += fmt::format(
            "  {0}: {{on: w{0}, road: track, model: brush, stiffness: {1}, damping: 2000, radius: {2}, "
            "longitudinal_stiffness: 60000, cornering_stiffness: {3}, friction: 0.9, "
            "longitudinal_relaxation: 0.4, "
            "lateral_relaxation: 0.4, half_length: {4}, load: {5}, rolling_resistance: 0.01}}\n",
            name, stiffness, radius, at_front ? front_grip * cornering : cornering, half_length, load);
        if (!at_front) motors += fmt::format("  m{0}: {{joint: h{0}, torque: push}}\n", name);
      }
    return "inputs:\n  steer: {start: 0, unit: rad}\n  push: {start: 0, unit: N m}\n" + bodies + joints +
           tyres + motors +
           "roads: {track: {over: distance, points: [[-1000, 0], [1000, 0]]}}\noutputs:\n"
           "  - {name: yaw_rate, angular_velocity: chassis, component: z}\n"
           "  - {name: vx, velocity: chassis, component: x}\n  - {name: vy, velocity: chassis, component: "
           "y}\n"
           "simulation: {step: 1 ms, end: 10}\n";
  }

  /// Of a bicycle with these tyres at their loads and trails, rad s²/m.
  double understeer() const {
    const auto grip = [&](bool at_front) {
      return 2 * (at_front ? front_grip : 1) * cornering * load_of(at_front) / load;
    };
    const auto trail = [&](bool at_front) { return half_length * std::sqrt(load_of(at_front) / load) / 3; };
    const double a = front - trail(true), b = rear + trail(false);
    return mass() / (a + b) * (b / grip(true) - a / grip(false));
  }
};

TrimConditions turn(double speed, double across, std::vector<std::string> find) {
  TrimConditions c;
  c.speed = speed;
  c.lateral_acceleration = across;
  c.find = std::move(find);
  return c;
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

/// Rolling resistance is what the motors push against, at the loaded radius.
TEST(Trim, PushesAgainstWhatResists) {
  const PlainCar car;
  const TrimResult straight = trim(model_of(car.text()), turn(25, 0, {"steer", "push"}));
  EXPECT_NEAR(straight.found[0].value, 0, 1e-10);
  const double resistance = 0.01 * car.mass() * g;  // at the drawn radius, by moments about the wheels
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

/// Around a circle A is constant in axes that turn with the car: as many zeros as the plane has motions, and
/// those of the wheels. Straight on at low speed the car is stable; it grows unstable beyond the critical
/// speed where it oversteers: v² = L/(−K).
TEST(Trim, ModesFindTheCriticalSpeed) {
  PlainCar car;
  car.front_grip = 1.5;
  const double gradient = car.understeer();
  ASSERT_LT(gradient, 0);
  const double critical = std::sqrt(car.base() / -gradient);
  const auto model = model_of(car.text());
  const auto grows = [&](double speed) {
    ModesOptions options;
    options.linear.point.at = LinearPoint::At::trim;
    options.linear.trim = turn(speed, 0, {"steer", "push"});
    bool any = false;
    int rigid = 0;
    for (const Mode& mode : find_modes(model, options).modes) {
      any = any || mode.grows;
      rigid += mode.kind == Mode::Kind::rigid;
    }
    EXPECT_GE(rigid, 6);  // x, y, four wheels
    return any;
  };
  EXPECT_FALSE(grows(0.9 * critical));
  EXPECT_TRUE(grows(1.1 * critical));
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

}  // namespace
}  // namespace mimbre::test::trim_test
