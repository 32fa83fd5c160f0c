#pragma once
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <tuple>

#include "tyre_files/tyre_data.h"

/// A car for tests: a body on four wheels with brakes, and, where it has `arms`, on four swing arms along its
/// side, whose wheels go sideways as it comes down. What it stands on is tilted by gravity.
namespace mimbre::test {

struct Cart {
  std::string tyre{};     ///< of its description, what says the law
  std::string more{};     ///< sections
  double slope = 0;       ///< height over length, up ahead
  double brake = 1500;    ///< N m, at each wheel
  double friction = 0.9;  ///< factor on the tyres'
  double speed = 0;       ///< m/s
  bool arms = false;
};

inline const std::string brush_of_cart =
    "model: brush, stiffness: 2e5, damping: 500, radius: 0.32, longitudinal_stiffness: 8e4, "
    "cornering_stiffness: 6e4, friction: 1, longitudinal_relaxation: 0.3, lateral_relaxation: 0.5, "
    "half_length: 0.08, load: 3000, rolling_resistance: 0.012";
inline std::string formula_of_cart(const std::string& file) {
  return "model: magic_formula, file: " + tyre_path(file);
}

inline std::string cart_text(const Cart& c) {
  const double size = std::hypot(1.0, c.slope);
  std::string bodies = "  car: {mass: 1000, com: [0, 0, 0.6], inertia: [300, 1200, 1300]}\n",
              joints = fmt::format(
                  "  free: {{type: floating, between: [ground, car], velocity: [{}, 0, 0, 0, 0, 0]}}\n",
                  c.speed),
              frictions, tyres, springs;
  for (const auto& [name, x, y] :
       {std::tuple{"fl", 1.3, 0.75}, {"fr", 1.3, -0.75}, {"rl", -1.3, 0.75}, {"rr", -1.3, -0.75}}) {
    std::string carrier = "car";
    if (c.arms) {
      carrier = fmt::format("arm_{}", name);
      bodies += fmt::format("  {}: {{mass: 10, com: [{}, {}, 0.2], inertia: [0.2, 0.2, 0.2]}}\n", carrier, x,
                            0.7 * y);
      joints += fmt::format(
          "  {}: {{type: revolute, between: [car, {}], at: [{}, {}, 0.15], axis: [1, 0, 0], spring: "
          "{{stiffness: 12000, damping: 800}}}}\n",
          carrier, carrier, x, 0.3 * y);
    }
    bodies += fmt::format("  {}: {{mass: 20, com: [{}, {}, 0.31], inertia: [0.5, 0.9, 0.5]}}\n", name, x, y);
    joints += fmt::format(
        "  {}: {{type: revolute, between: [{}, {}], at: [{}, {}, 0.31], axis: [0, 1, 0], velocity: {}}}\n",
        name, carrier, name, x, y, c.speed / 0.31);
    frictions += fmt::format("  {}: {{joint: {}, torque: {}, sticking: 1e-3}}\n", name, name, c.brake);
    tyres += fmt::format("  {}: {{on: {}, at: [{}, {}, 0.31], road: track, {}}}\n", name, name, x, y, c.tyre);
  }
  return fmt::format(
      "gravity: [{}, 0, {}]\nbodies:\n{}joints:\n{}frictions:\n{}tyres:\n{}roads: {{track: {{over: distance, "
      "points: [[-1000, 0], [1000, 0]], friction: {}}}}}\noutputs:\n  - {{name: x, position: car, component: "
      "x}}\n  - {{name: y, position: car, component: y}}\n  - {{name: z, position: car, component: "
      "z}}\n{}simulation: {{step: 0.005, end: 10}}\n",
      -9.81 * c.slope / size, -9.81 / size, bodies, joints, frictions, tyres, c.friction, c.more);
}

}  // namespace mimbre::test
