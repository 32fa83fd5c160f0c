#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "mimbre/assembly.h"
#include "mimbre/simulation.h"
#include "support/models.h"
#include "support/simulate.h"

/// A model in other units of length, mass and time is the same model: each run takes the same steps and
/// iterations, and its results are the same numbers in those units.
namespace mimbre::unit_systems_test {
using namespace test;
namespace {

/// A model whose numbers are products of L, M and T and what follows from them, and its outputs' units as
/// powers of these.
struct Case {
  const char* name;
  const char* text;
  std::vector<std::array<int, 3>> units;  ///< of outputs
  int steps = 100;
  double step = 0.01;  ///< in units of T

  friend void PrintTo(const Case& of, std::ostream* out) { *out << of.name; }
};

/// Powers of two.
struct Units {
  int length, mass, time;
};

constexpr std::array<int, 3> angle{0, 0, 0}, length{1, 0, 0}, speed{1, 0, -1}, rate{0, 0, -1},
    force{1, 1, -2};

const Case cases[] = {
    {"ball",
     R"(
gravity: [0, 0, -9.81*L/(T*T)]
bodies:
  b: {mass: 2*M, com: [0.05*L, 0.02*L, 0.5*L], inertia: [0.03*J, 0.04*J, 0.05*J], frame: {at: [0.3*L, 0.1*L, 0.2*L]}}
joints:
  j: {type: floating, between: [ground, b], at: [0, 0, 0.5*L], velocity: [L/T, 0.2*L/T, 0, 2/T, 1/T, -3/T]}
surfaces: {f: {type: half_space, at: [0, 0, 0], z: [0, 0, 1]}}
contacts:
  c: {spheres: {on: b, at: [0.05*L, 0.02*L, 0.45*L], radius: 0.2*L}, surfaces: [f], stiffness: 9000*k, restitution: 0.4,
      friction: 0.3}
outputs:
  - {name: x, position: b, at: [0.05*L, 0.02*L, 0.5*L], component: x}
  - {name: z, position: b, at: [0.05*L, 0.02*L, 0.5*L], component: z}
  - {name: w, angular_velocity: b, component: y}
)",
     {length, length, rate}},
    {"sliding_ball",  // where its friction falls goes by the mechanism
     R"(
gravity: [0, 0, -9.81*L/(T*T)]
bodies: {b: {mass: 2*M, com: [0, 0, 0.199*L], inertia: [0.03*J, 0.03*J, 0.03*J]}}
joints: {j: {type: floating, between: [ground, b], at: [0, 0, 0.199*L], velocity: [0.1*L/T, 0.02*L/T, 0, 2/T, 1/T, -3/T]}}
surfaces: {f: {type: half_space, at: [0, 0, 0], z: [0, 0, 1]}}
contacts:
  c: {spheres: {on: b, at: [0, 0, 0.199*L], radius: 0.2*L}, surfaces: [f], stiffness: 9000*k, restitution: 0.4,
      friction: 0.3, static_ratio: 1.5, rolling: 0.01*L, spinning: 0.01*L}
outputs:
  - {name: x, position: b, at: [0, 0, 0.199*L], component: x}
  - {name: y, position: b, at: [0, 0, 0.199*L], component: y}
  - {name: w, angular_velocity: b, component: z}
)",
     {length, length, rate}},
    {"mixed",  // speeds that are not given: those of the least motion by the scales of the coordinates
     R"(
gravity: [0, 0, -9.81*L/(T*T)]
bodies:
  crank: {mass: 0.5*M, com: [0, 0.05*L, 0.05*L], inertia: [0.002*J, 0.002*J, 0.0005*J]}
  rod: {mass: 0.8*M, com: [0.3*L, 0.05*L, 0.1*L], inertia: [0.004*J, 0.03*J, 0.03*J]}
  slider: {mass: M, com: [0.65*L, 0.02*L, 0], inertia: [0.004*J, 0.005*J, 0.005*J]}
joints:
  main: {type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [1, 0, 0], velocity: 4/T}
  pin: {type: spherical, between: [crank, rod], at: [0, 0.1*L, 0.15*L]}
  knuckle: {type: spherical, between: [rod, slider], at: [0.6*L, 0.05*L, 0]}
  guide: {type: cylindrical, between: [ground, slider], at: [0.6*L, 0, 0], axis: [1, 0.3, 0]}
outputs:
  - {name: w, joint_velocity: main}
  - {name: turn, joint_velocity: guide, component: 0}
  - {name: x, position: slider, component: x}
)",
     {rate, rate, length}},
    {"four_bar",
     R"(
gravity: [0, 0, -9.81*L/(T*T)]
bodies:
  c: {mass: 0.5*M, com: [0, 0, 0.1*L], inertia: [0.002*J, 0.002*J, 0.0001*J]}
  k: {mass: M, com: [0.3*L, 0, 0.35*L], inertia: [0.02*J, 0.02*J, 0.0005*J]}
  r: {mass: M, com: [0.6*L, 0, 0.25*L], inertia: [0.02*J, 0.02*J, 0.0005*J]}
joints:
  a: {type: revolute, between: [ground, c], at: [0, 0, 0], axis: [0, 1, 0], velocity: 3/T}
  b: {type: revolute, between: [c, k], at: [0, 0, 0.2*L], axis: [0, 1, 0]}
  d: {type: revolute, between: [ground, r], at: [0.6*L, 0, 0], axis: [0, 1, 0],
      spring: {stiffness: 40*k*L*L, damping: 0.1*J/T}}
  e: {type: revolute, between: [k, r], at: [0.6*L, 0, 0.5*L], axis: [0, 1, 0]}
springs:
  s: {between: [ground, k], at: [[0.3*L, 0, 1.5*L], [0.3*L, 0, 0.4*L]], elastic: {stiffness: 20*k, zero: L}}
outputs: [{name: a, joint: a}, {name: w, joint_velocity: d}, {name: f, joint_force: e, component: fx}]
)",
     {angle, rate, force}},
    {"equilibrium",
     R"(
gravity: [0, 0, -9.81*L/(T*T)]
initial: equilibrium
bodies:
  c: {mass: 0.5*M, com: [0, 0, 0.1*L], inertia: [0.002*J, 0.002*J, 0.0001*J]}
  k: {mass: M, com: [0.3*L, 0, 0.35*L], inertia: [0.02*J, 0.02*J, 0.0005*J]}
  r: {mass: M, com: [0.6*L, 0, 0.25*L], inertia: [0.02*J, 0.02*J, 0.0005*J]}
joints:
  a: {type: revolute, between: [ground, c], at: [0, 0, 0], axis: [0, 1, 0]}
  b: {type: revolute, between: [c, k], at: [0, 0, 0.2*L], axis: [0, 1, 0]}
  d: {type: revolute, between: [ground, r], at: [0.6*L, 0, 0], axis: [0, 1, 0],
      spring: {stiffness: 40*k*L*L, damping: 0.1*J/T}}
  e: {type: revolute, between: [k, r], at: [0.6*L, 0, 0.5*L], axis: [0, 1, 0]}
loads: {push: {on: k, at: [0.3*L, 0, 0.35*L], force: [F, 0, 0]}}
outputs: [{name: a, joint: a}, {name: w, joint_velocity: d}, {name: f, joint_force: e, component: fx}]
)",
     {angle, rate, force}},
    {"open",
     R"(
gravity: [0, -9.81*L/(T*T), 0]
bodies:
  crank: {mass: 0.5*M, com: [0.1*L, 0, 0], inertia: [1e-4*J, 2e-3*J, 2e-3*J]}
  coupler: {mass: 0.8*M, com: [0.3*L, 0, 0], inertia: [1e-3*J, 0.05*J, 0.05*J]}
  rocker: {mass: M, com: [0.25*L, 0, 0], inertia: [1e-3*J, 0.02*J, 0.02*J]}
joints:
  crank: {type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 0, 1], position: 0.7}
  crank_pin: {type: revolute, between: [crank, coupler], at: [[0.2*L, 0, 0], [0, 0, 0]], axis: [0, 0, 1]}
  rocker: {type: revolute, between: [ground, rocker], at: [[0.55*L, 0, 0], [0, 0, 0]], axis: [0, 0, 1]}
  rocker_pin: {type: revolute, between: [coupler, rocker], at: [[0.6*L, 0, 0], [0.5*L, 0, 0]], axis: [0, 0, 1]}
outputs: [{name: a, joint: rocker}, {name: y, position: rocker_pin.b, component: y}]
)",
     {angle, length}},
    {"beam",
     R"(
gravity: [0, 0, -9.81*L/(T*T)]
materials: {alloy: {young: 7e8*M/(L*T*T), poisson: 0.3, density: 2700*M/(L*L*L)}}
sections: {thin: {area: 4e-4*L*L, Iy: 2e-7*L*L*L*L, Iz: 2e-7*L*L*L*L, J: 4e-7*L*L*L*L}}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: alloy
      section: thin
      nodes: {root: [0, 0, 0], tip: [L, 0, 0]}
      bars: {beam: {from: root, to: tip, elements: 8}}
      clamped: [root]
      dynamic_modes: 4
      stiffening: geometric_stiffness
joints: {hub: {type: revolute, between: [ground, beam], at: [0, 0, 0], axis: [0, 1, 0], velocity: -1/T}}
outputs: [{name: a, joint: hub}, {name: z, position: beam.tip, component: z}]
)",
     {angle, length},
     100,
     0.002},
    {"friction",
     R"(
gravity: [0, 0, -9.81*L/(T*T)]
bodies:
  block: {mass: 2*M, com: [0, 0, 0], inertia: [J, J, J]}
  arm: {mass: M, com: [0, 0, -0.5*L], inertia: [0.1*J, 0.1*J, 0.01*J]}
joints:
  guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0], velocity: 2*L/T}
  pivot: {type: revolute, between: [block, arm], at: [0, 0, 0], axis: [0, 1, 0], velocity: 2/T}
frictions: 
  base: {joint: guide, force: 8*F, static_ratio: 1.3}
  rub: {joint: pivot, torque: 0.1*F*L, static_ratio: 1.2}
stops:
  end: {joint: guide, upper: 0.2*L, stiffness: 8000*k, restitution: 0.5}
  wall: {joint: pivot, lower: -0.2, upper: 0.2, stiffness: 200*F*L, restitution: 0.3}
outputs: [{name: x, joint: guide}, {name: v, joint_velocity: guide}, {name: a, joint: pivot}]
)",
     {length, speed, angle},
     300,
     0.002},
    {"weightless",  // what slow is goes by the friction's own limit, which varies, and by the stiffness
     R"(
gravity: [0, 0, 0]
bodies:
  block: {mass: 2*M, com: [0, 0, 0], inertia: [J, J, J]}
  arm: {mass: M, com: [0, 0, -0.5*L], inertia: [0.1*J, 0.1*J, 0.01*J]}
joints:
  guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0], velocity: 1*L/T}
  pivot: {type: revolute, between: [block, arm], at: [0, 0, 0], axis: [0, 1, 0], velocity: 2/T}
frictions:
  base: {joint: guide, force: 'F*(3 + 2*sin(9*t/T))', static_ratio: 1.3}
  rub: {joint: pivot, torque: 0.5*F*L, static_ratio: 1.2}
surfaces: {wall: {type: half_space, at: [0.5*L, 0, 0], z: [-1, 0, 0]}}
contacts:
  c: {spheres: {on: arm, at: [0, 0, -0.9*L], radius: 0.1*L}, surfaces: [wall], stiffness: 9000*k, restitution: 0.4,
      friction: 0.4, static_ratio: 1.4, rolling: 0.01*L}
outputs: [{name: x, joint: guide}, {name: v, joint_velocity: guide}, {name: a, joint: pivot}]
)",
     {length, speed, angle}},
    {"held",  // in an equilibrium, and after it
     R"(
gravity: [2*L/(T*T), 0, -9.81*L/(T*T)]
initial: equilibrium
bodies:
  block: {mass: 2*M, com: [0, 0, 0], inertia: [J, J, J]}
  arm: {mass: M, com: [0, 0, -0.5*L], inertia: [0.1*J, 0.1*J, 0.01*J]}
joints:
  guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0]}
  pivot: {type: revolute, between: [block, arm], at: [0, 0, 0], axis: [0, 1, 0]}
frictions:
  base: {joint: guide, force: 8*F}
  rub: {joint: pivot, torque: 0.1*F*L}
actuators: {push: {joint: guide, force: "t > 0.1*T ? 3*F : 0"}}
outputs: [{name: x, joint: guide}, {name: v, joint_velocity: guide}, {name: a, joint: pivot}]
)",
     {length, speed, angle}},
    {"surfaces",
     R"(
gravity: [0, 0, -9.81*L/(T*T)]
bodies:
  b1: {mass: M, com: [0, 0, 0.52*L], inertia: [0.02*J, 0.02*J, 0.02*J]}
  b2: {mass: 2*M, com: [2*L, 0, 0.52*L], inertia: [0.03*J, 0.03*J, 0.03*J]}
  b3: {mass: M, com: [4*L, 0, 0.52*L], inertia: [0.02*J, 0.02*J, 0.02*J]}
  b4: {mass: M, com: [6*L, 0, 0.52*L], inertia: [0.02*J, 0.02*J, 0.02*J]}
  b5: {mass: M, com: [8*L, 0, 0.52*L], inertia: [0.02*J, 0.02*J, 0.02*J]}
  b6: {mass: M, com: [10*L, 0, 0.52*L], inertia: [0.02*J, 0.02*J, 0.02*J]}
  b7: {mass: 0.5*M, com: [10.1*L, 0, 0.95*L], inertia: [0.01*J, 0.01*J, 0.01*J]}
joints:
  j1: {type: floating, between: [ground, b1], velocity: [0.5*L/T, 0.1*L/T, 0, 1/T, 2/T, 0]}
  j2: {type: floating, between: [ground, b2], velocity: [0.5*L/T, 0.1*L/T, 0, 1/T, 2/T, 0]}
  j3: {type: floating, between: [ground, b3], velocity: [0.2*L/T, 0.1*L/T, 0, 1/T, 2/T, 0]}
  j4: {type: floating, between: [ground, b4], velocity: [0.5*L/T, 0.1*L/T, 0, 1/T, 2/T, 0]}
  j5: {type: floating, between: [ground, b5], velocity: [0.5*L/T, 0.1*L/T, 0, 1/T, 2/T, 0]}
  j6: {type: floating, between: [ground, b6], velocity: [0, 0.1*L/T, 0, 1/T, 2/T, 0]}
  j7: {type: floating, between: [ground, b7]}
surfaces:
  s1: {type: box, at: [0, 0, 0.2*L], size: [3*L, 1*L, 0.2*L]}
  s2: {type: sphere, at: [2*L, 0, 0], radius: 0.3*L}
  s3: {type: cylinder, at: [4*L, 0, 0], radius: 0.3*L, length: 2*L, z: [0, 1, 0]}
  s4: {type: capsule, at: [6*L, 0, 0], radius: 0.3*L, length: 2*L, z: [0, 1, 0]}
  s5: {type: heights, at: [7*L, -1*L, 0.2*L], spacing: [L, L],
       heights: [[0, 0.1*L, 0, 0.1*L], [0, 0.1*L, 0.1*L, 0], [0, 0, 0.1*L, 0]]}
  s6: {type: mesh, at: [10*L, 0, 0.3*L], vertices: [[-1*L, -1*L, 0], [L, -1*L, 0], [0, L, 0], [0, 0, -1*L]],
       triangles: [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]}
contacts:
  balls: {spheres: [{on: b1, radius: 0.2*L}, {on: b2, radius: 0.2*L}, {on: b3, radius: 0.2*L}, {on: b4, radius: 0.2*L},
                    {on: b5, radius: 0.2*L}, {on: b6, radius: 0.2*L}, {on: b7, radius: 0.2*L}],
          surfaces: [s1, s2, s3, s4, s5, s6], among: true, stiffness: 5000*k, restitution: 0.5, friction: 0.4,
          static_ratio: 1.2}
outputs:
  - {name: x1, position: b1, component: x}
  - {name: x2, position: b2, component: x}
  - {name: x3, position: b3, component: x}
  - {name: x4, position: b4, component: x}
  - {name: x5, position: b5, component: x}
  - {name: x6, position: b6, component: y}
  - {name: x7, position: b7, component: z}
)",
     {length, length, length, length, length, length, length},
     120,
     0.004},
    {"swarm",
     R"(
gravity: [0, 0, -9.81*L/(T*T)]
bodies:
  b1: {mass: M, com: [0, 0, 0.25*L], inertia: [0.02*J, 0.02*J, 0.02*J]}
  b2: {mass: M, com: [0.1*L, 0, 0.68*L], inertia: [0.02*J, 0.02*J, 0.02*J]}
  b3: {mass: 2*M, com: [0, 0.1*L, 1.12*L], inertia: [0.04*J, 0.04*J, 0.04*J]}
joints:
  j1: {type: floating, between: [ground, b1]}
  j2: {type: floating, between: [ground, b2]}
  j3: {type: floating, between: [ground, b3]}
surfaces: {floor: {type: half_space}}
contacts:
  balls: {spheres: [{on: b1, radius: 0.2*L}, {on: b2, radius: 0.2*L}, {on: b3, radius: 0.2*L}], surfaces: [floor],
          among: true, swarm: true, stiffness: 2000*k, restitution: 0.5, friction: 0.4}
outputs:
  - {name: z1, position: b1, component: z}
  - {name: z2, position: b2, component: z}
  - {name: x3, position: b3, component: x}
)",
     {length, length, length},
     150,
     0.004},
    {"springy",  // depths are not given
     R"(
gravity: [0, 0, -9.81*L/(T*T)]
bodies:
  a: {mass: M, com: [0, 0, 0.5*L], inertia: [0.02*J, 0.02*J, 0.02*J]}
  b: {mass: 2*M, com: [0.7*L, 0, 0], inertia: [0.1*J, 0.2*J, 0.2*J]}
  c: {mass: M, com: [0, L, 0], inertia: [0.1*J, 0.1*J, 0.1*J]}
joints:
  free: {type: floating, between: [ground, a], velocity: [0.5*L/T, 0.1*L/T, 0, 1/T, 2/T, 0]}
  arm: {type: revolute, between: [ground, b], at: [0, 0, 0], axis: [0, 1, 0]}
  guide: {type: prismatic, between: [ground, c], at: [0, 40*L, 0], axis: [0, 1, 0], velocity: 2*L/T}
surfaces: {floor: {type: half_space, at: [0, 0, 0.2*L]}}
contacts: {ball: {spheres: {on: a, radius: 0.2*L}, surfaces: [floor], stiffness: 2000*k, exponent: 1.5, restitution: 0.5}}
stops:
  turn: {joint: arm, lower: -0.4, upper: 0.4, stiffness: 3000*F*L, exponent: 1.5, restitution: 0.6}
  way: {joint: guide, lower: -0.3*L, upper: 0.3*L, stiffness: 1000*k, exponent: 2, restitution: 0.6}
outputs:
  - {name: x, position: a, component: x}
  - {name: z, position: a, component: z}
  - {name: arm, joint: arm}
  - {name: guide, joint: guide}
)",
     {length, length, angle, length},
     120,
     0.004},
    {"elements",
     R"(
gravity: [0, 0, -9.81*L/(T*T)]
bodies:
  a: {mass: 2*M, com: [0, 0, 0], inertia: [0.2*J, 0.3*J, 0.4*J]}
  b: {mass: M, com: [L, 0, 0], inertia: [0.1*J, 0.1*J, 0.02*J]}
  c: {mass: M, com: [2*L, 0, 0.5*L], inertia: [0.1*J, 0.1*J, 0.05*J]}
  d: {mass: 0.5*M, com: [0, L, 0], inertia: [0.02*J, 0.02*J, 0.02*J]}
  e: {mass: 0.5*M, com: [0, 2*L, 0], inertia: [0.02*J, 0.02*J, 0.02*J]}
joints:
  free: {type: floating, between: [ground, a], at: [0, 0, 0], velocity: [0.1*L/T, 0, 0, 1/T, 0.5/T, 2/T]}
  arm: {type: revolute, between: [ground, b], at: [0.5*L, 0, 0], axis: [0, 1, 0]}
  slide: {type: prismatic, between: [b, c], at: [2*L, 0, 0.5*L], axis: [1, 0, 0.3]}
  shaft: {type: revolute, between: [ground, d], at: [0, L, 0], axis: [1, 0, 0]}
  wheel: {type: revolute, between: [ground, e], at: [0, 2*L, 0], axis: [1, 0, 0]}
constraints:
  gear: {type: gear, joints: [shaft, wheel], teeth: [17, 51]}
bushings:
  mount: {between: [ground, a], at: [0.1*L, 0, 0.2*L], stiffness: [600*k, 900*k, 800*k, 20*k*L*L, 30*k*L*L, 25*k*L*L],
          damping: [3*M/T, 3*M/T, 3*M/T, 0.2*J/T, 0.2*J/T, 0.2*J/T],
          maxwell: [{stiffness: [100*k, 100*k, 100*k, 0, 0, 0], relaxation: 0.05*T}]}
springs:
  s: {between: [a, b], at: [[0, 0.3*L, 0.2*L], [L, 0.3*L, 0]], elastic: {stiffness: 40*k, zero: 0.8*L}, damping: 2*M/T}
torsion_springs:
  bar: {coordinates: [{joint: arm}, {joint: shaft, factor: -0.7}], stiffness: 10*k*L*L, damping: 0.1*J/T}
cables:
  sling: {over: [ground, b, ground], at: [[0.5*L, 0, 1.5*L], [1.2*L, 0, 0], [2*L, 0, 1.5*L]], axial_stiffness: 80*F,
          damping: M/T, preload: 3*F}
gas_springs:
  strut: {between: [ground, c], at: [[2*L, 0, 1.3*L], [2*L, 0, 0.5*L]], pressure: 5e4*F/(L*L), area: 1e-4*L*L, length: 0.8*L,
          gas_length: 0.6*L, ambient: 1e4*F/(L*L)}
hydraulic_dampers:
  shock: {between: [ground, c], at: [[2.5*L, 0, 0], [2*L, 0, 0.5*L]], damping: 8*M/T, quadratic: 2*M/L, area: 1e-3*L*L,
          length: 0.2*L, bulk_modulus: 1e6*F/(L*L)}
drags:
  sail: {on: c, at: [2*L, 0, 0.5*L], area: 0.5*L*L, coefficients: [1, 1, 1], density: 1.2*M/(L*L*L), wind: [2*L/T, 0, 0]}
stops:
  end: {joint: slide, lower: -0.05*L, upper: 0.05*L, stiffness: 3000*k, restitution: 0.4}
  gap: {joint: wheel, upper: 0.4, stiffness: 500*F*L, restitution: 0.6}
frictions:
  rub: {joint: arm, torque: 0.3*F*L}
  seal: {joint: slide, force: F, static_ratio: 1.3}
motors:
  dc: {joint: shaft, ratio: 3, inertia: 1e-3*J, constant: 0.2*F*L, resistance: 0.8*F*L/T, voltage: 5*F*L/T, drag: 1e-3*J/T,
       efficiency: 0.9}
  servo: {joint: arm, ratio: 2, curve: {table: [[0, 0.5*F*L], [30/T, 0.2*F*L]]}, command: '0.8*sin(5*t/T)', efficiency: 0.8}
actuators:
  jet: {between: [ground, a], at: [0, 0, 0], along: [1, 0, 0], force: '3*F*cos(4*t/T)'}
outputs:
  - {name: x, position: a, component: x}
  - {name: y, position: a, component: y}
  - {name: w, angular_velocity: a, component: z}
  - {name: arm, joint: arm}
  - {name: slide, joint: slide}
  - {name: shaft, joint_velocity: shaft}
)",
     {length, length, rate, angle, length, rate}},
    {"controller",
     R"(
gravity: [0, 0, -9.81*L/(T*T)]
bodies:
  cart: {mass: 2*M, com: [0, 0, 0], inertia: [J, J, J]}
  pole: {mass: M, com: [0, 0, 0.5*L], inertia: [0.1*J, 0.1*J, 0.01*J]}
joints:
  guide: {type: prismatic, between: [ground, cart], at: [0, 0, 0], axis: [1, 0, 0]}
  pivot: {type: revolute, between: [cart, pole], at: [0, 0, 0], axis: [0, 1, 0], position: 0.1}
signals:
  wanted: '0.3*L*sin(2*t/T)'
  servo: {pid: way, setpoint: wanted, kp: 60*k, ki: 20*k/T, kd: 12*M/T, filter: 0.02*T, lower: -30*F, upper: 30*F}
  smooth: {transfer_function: tilt, numerator: [100/(T*T)], denominator: [1, 20/T, 100/(T*T)]}
  sampled: {pid: smooth, setpoint: 0, kp: 10*F*L, ki: 0, kd: F*L*T, filter: 0.05*T, every: 0.02*T}
  late: {delay: way, time: 0.05*T}
  latch: {hysteresis: late, rises_at: 0.1*L, falls_at: 0, low: 0, high: 1}
  ramp: {rate_limit: latch, rising: 3/T, falling: -3/T}
actuators:
  drive: {joint: guide, force: "servo - 2*F*ramp"}
  hinge: {joint: pivot, torque: "sampled"}
frictions: {rail: {joint: guide, force: 0.5*F, static_ratio: 1.2}}
outputs: [{name: way, joint: guide}, {name: v, joint_velocity: guide}, {name: tilt, joint: pivot}]
)",
     {length, speed, angle}},
    {"driven",
     R"(
gravity: [0, 0, -9.81*L/(T*T)]
bodies:
  a: {mass: M, com: [0.3*L, 0, 0], inertia: [0.02*J, 0.1*J, 0.1*J]}
  b: {mass: M, com: [0.9*L, 0, 0], inertia: [0.02*J, 0.1*J, 0.1*J]}
joints:
  crank: {type: revolute, between: [ground, a], at: [0, 0, 0], axis: [0, 1, 0], drive: {position: '0.4*sin(5*t/T)'}}
  knee: {type: revolute, between: [a, b], at: [0.6*L, 0, 0], axis: [0, 1, 0]}
frictions: {knee: {joint: knee, torque: 0.2*F*L, static_ratio: 1.5}}
outputs: [{name: a, joint: knee}, {name: z, position: b, component: z}, {name: f, joint_force: crank, component: fx}]
)",
     {angle, length, force}},
    {"tyre",
     R"(
gravity: [0, 0, -9.81*L/(T*T)]
bodies:
  fork: {mass: 250*M, com: [0, 0, 0.3*L], inertia: [10*J, 10*J, 10*J]}
  wheel: {mass: 20*M, com: [0, 0, 0.3*L], inertia: [0.5*J, J, 0.5*J]}
joints:
  way: {type: planar, between: [ground, fork], at: [0, 0, 0.3*L], axis: [0, 1, 0], velocity: [8*L/T, 0, 0]}
  axle: {type: revolute, between: [fork, wheel], at: [0, 0, 0.3*L], axis: [0, 1, 0], velocity: 20/T}
tyres:
  t: {on: wheel, at: [0, 0, 0.3*L], road: track, model: brush, stiffness: 2e5*k, damping: 500*M/T, radius: 0.31*L,
      longitudinal_stiffness: 8e4*F, cornering_stiffness: 6e4*F, friction: 1, longitudinal_relaxation: 0.3*L,
      lateral_relaxation: 0.5*L, half_length: 0.08*L, load: 3000*F, rolling_resistance: 0.012}
roads: {track: {over: distance, points: [[-1000*L, 0], [1000*L, 0]], friction: 0.9}}
outputs:
  - {name: x, position: wheel, at: [0, 0, 0.3*L], component: x}
  - {name: y, position: wheel, at: [0, 0, 0.3*L], component: y}
  - {name: w, joint_velocity: axle}
)",
     {length, length, rate},
     200,
     0.002},
    {"standing",  // on a slope: brakes and carcasses hold
     R"(
gravity: [-1*L/(T*T), 0, -9.81*L/(T*T)]
bodies:
  fork: {mass: 250*M, com: [0, 0, 0.3*L], inertia: [10*J, 10*J, 10*J]}
  wheel: {mass: 20*M, com: [0, 0, 0.3*L], inertia: [0.5*J, J, 0.5*J]}
  other: {mass: 20*M, com: [L, 0, 0.3*L], inertia: [0.5*J, J, 0.5*J]}
joints:
  way: {type: planar, between: [ground, fork], at: [0, 0, 0.3*L], axis: [0, 1, 0]}
  axle: {type: revolute, between: [fork, wheel], at: [0, 0, 0.3*L], axis: [0, 1, 0]}
  front: {type: revolute, between: [fork, other], at: [L, 0, 0.3*L], axis: [0, 1, 0]}
frictions:
  brake: {joint: axle, torque: 900*F*L}
  drum: {joint: front, torque: 900*F*L}
tyres:
  t: {on: wheel, at: [0, 0, 0.3*L], road: track, model: brush, stiffness: 2e5*k, damping: 500*M/T, radius: 0.31*L,
      longitudinal_stiffness: 8e4*F, cornering_stiffness: 6e4*F, friction: 1, longitudinal_relaxation: 0.3*L,
      lateral_relaxation: 0.5*L, half_length: 0.08*L, load: 3000*F, rolling_resistance: 0.012}
  u: {on: other, at: [L, 0, 0.3*L], road: track, model: tmeasy, stiffness: 2e5*k, damping: 500*M/T, radius: 0.31*L,
      longitudinal_stiffness: 8e4*F, longitudinal_peak: 3000*F, longitudinal_peak_slip: 0.1, longitudinal_sliding: 2800*F,
      longitudinal_sliding_slip: 0.5, cornering_stiffness: 6e4*F, lateral_peak: 2800*F, lateral_peak_slip: 0.2,
      lateral_sliding: 2600*F, lateral_sliding_slip: 0.8, longitudinal_relaxation: 0.3*L, lateral_relaxation: 0.5*L,
      half_length: 0.08*L, load: 3000*F}
roads: {track: {over: distance, points: [[-1000*L, 0], [1000*L, 0]], friction: 0.9}}
outputs:
  - {name: x, position: wheel, at: [0, 0, 0.3*L], component: x}
  - {name: z, position: other, at: [L, 0, 0.3*L], component: z}
  - {name: a, joint: axle}
)",
     {length, length, angle},
     150,
     0.005},
    {"event",
     R"(
gravity: [0, 0, -9.81*L/(T*T)]
inputs: {on: 0}
bodies: {b: {mass: 2*M, com: [0, 0, L], inertia: [J, J, J]}}
joints: {j: {type: prismatic, between: [ground, b], at: [0, 0, L], axis: [0, 0, 1]}}
actuators: {up: {joint: j, force: "40*F*on"}}
events: {low: {when: z, crosses: -0.1*L, direction: falling, set: {on: 1}}}
outputs: [{name: z, joint: j}, {name: v, joint_velocity: j}]
)",
     {length, speed}},
};

struct Ran {
  Eigen::VectorXd outputs;  ///< in units of the model
  std::vector<int> iterations, substeps;
};

Ran ran(const Case& of, Formulation formulation, const Units& units) {
  const double L = std::ldexp(1.0, units.length), M = std::ldexp(1.0, units.mass),
               T = std::ldexp(1.0, units.time);
  const std::string text = fmt::format(
      "mimbre: 1\ntitle: test\nparameters: {{L: {:.17g}, M: {:.17g}, T: {:.17g}, J: M*L*L, F: M*L/(T*T), "
      "k: M/(T*T)}}\n{}",
      L, M, T, of.text);
  Simulation s = simulation_of(Model::compile(brought_together(parse_model(text, "test.yaml", "."))),
                               formulation, of.step * T);
  Ran found;
  for (int k = 0; k < of.steps; ++k) {
    const StepReport report = s.step();
    if (!report.ok()) {
      ADD_FAILURE() << s.explain(report);
      break;
    }
    found.iterations.push_back(report.iterations);
    found.substeps.push_back(report.substeps);
  }
  ResultsRow row;
  s.sample(row);
  found.outputs = row.channels.head(static_cast<Eigen::Index>(of.units.size()));
  for (std::size_t k = 0; k < of.units.size(); ++k) {
    const auto& [l, m, t] = of.units[k];
    found.outputs[static_cast<Eigen::Index>(k)] *=
        std::ldexp(1.0, -(l * units.length + m * units.mass + t * units.time));
  }
  return found;
}

class UnitSystems : public testing::TestWithParam<std::tuple<Case, Formulation>> {};

TEST_P(UnitSystems, AreAlike) {
  const auto& [of, formulation] = GetParam();
  const Ran unit = ran(of, formulation, {0, 0, 0});
  const double size = unit.outputs.cwiseAbs().maxCoeff();
  for (const Units& units : {Units{-30, 0, 0},
                             {30, 0, 0},
                             {0, -20, 0},
                             {0, 30, 0},
                             {0, 0, -10},
                             {0, 0, 10},
                             {-30, -20, 3},
                             {30, 30, -5},
                             {-30, 30, 0},
                             {30, -20, 0}}) {
    SCOPED_TRACE(fmt::format("2^{} m, 2^{} kg, 2^{} s", units.length, units.mass, units.time));
    const Ran other = ran(of, formulation, units);
    EXPECT_LE((other.outputs - unit.outputs).cwiseAbs().maxCoeff(), 1e-9 * size)
        << other.outputs.transpose() << " instead of " << unit.outputs.transpose();
    // A step that starts in balance ends by round-off.
    if (std::string(of.name) != "equilibrium" && std::string(of.name) != "held") {
      EXPECT_EQ(other.iterations, unit.iterations);
    }
    EXPECT_EQ(other.substeps, unit.substeps);
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, UnitSystems,
                         testing::Combine(testing::ValuesIn(cases),
                                          testing::Values(Formulation::relative, Formulation::natural)),
                         [](const auto& at) {
                           return fmt::format(
                               "{}_{}", std::get<0>(at.param).name,
                               std::get<1>(at.param) == Formulation::natural ? "natural" : "relative");
                         });

}  // namespace
}  // namespace mimbre::unit_systems_test
