#pragma once
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "mimbre/linearise.h"

namespace mimbre::test {

/// A car of rigid bodies without a suspension, steered in front by an input, driven at the rear axle by
/// another.
struct PlainCar {
  static constexpr double g = 9.81;
  double front = 1.2, rear = 1.4, track = 1.5, height = 0.35, chassis = 1200, wheel = 20, knuckle = 2;
  double radius = 0.3, stiffness = 2e5, cornering = 45e3, load = 3200, half_length = 0.06, front_grip = 0.8;
  double speed = 15;
  double frame = 0;  ///< x of the frame of the joint on the ground

  double base() const { return front + rear; }
  double mass() const { return chassis + 4 * (wheel + knuckle); }
  double load_of(bool at_front) const { return 0.5 * mass() * g * (at_front ? rear : front) / base(); }

  std::string text() const {
    const double com = -(2 * (wheel + knuckle) * (front - rear)) / chassis;
    std::string bodies =
        fmt::format("bodies:\n  chassis: {{mass: {}, com: [{}, 0, {}], inertia: [400, 1600, 1800]}}\n",
                    chassis, com, height);
    std::string joints = fmt::format(
        "joints:\n  free: {{type: floating, between: [ground, chassis], at: [{}, 0, 0], position: [0, 0, {}, "
        "0, 0, 0], velocity: [{}, 0, 0, 0, 0, 0]}}\n",
        frame, -load_of(true) / stiffness, speed);
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

  /// Of a bicycle with these tyres at their loads: forces of an axle for each radian, and where they act.
  double grip(bool at_front) const {
    return 2 * (at_front ? front_grip : 1) * cornering * load_of(at_front) / load;
  }
  double trail(bool at_front) const { return half_length * std::sqrt(load_of(at_front) / load) / 3; }
  double a() const { return front - trail(true); }
  double b() const { return rear + trail(false); }
  /// rad s²/m
  double understeer() const { return mass() / (a() + b()) * (b() / grip(true) - a() / grip(false)); }
  /// Slip of the rear axle, rad s²/m of the lateral acceleration.
  double rear_slip() const { return mass() * a() / (a() + b()) / grip(false); }
};

inline TrimConditions turn(double speed, double across, std::vector<std::string> find) {
  TrimConditions c;
  c.speed = speed;
  c.lateral_acceleration = across;
  c.find = std::move(find);
  return c;
}

}  // namespace mimbre::test
