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
      friction: 0.3, stribeck: 0.01*L/T, settling: 1e-3*T}
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
      depth: 0.001*L, friction: 0.3, static_ratio: 1.5, settling: 1e-3*T, rolling: 0.01*L,
      spinning: 0.01*L}
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
  base: {joint: guide, force: 8*F, static_ratio: 1.3, stribeck: 0.01*L/T, sticking: 1e-4*L, settling: 1e-3*T}
  rub: {joint: pivot, torque: 0.1*F*L, sticking: 1e-4, stribeck: 0.01/T, settling: 1e-3*T}
stops:
  end: {joint: guide, upper: 0.2*L, stiffness: 8000*k, restitution: 0.5}
  wall: {joint: pivot, lower: -0.2, upper: 0.2, stiffness: 200*F*L, restitution: 0.3}
outputs: [{name: x, joint: guide}, {name: v, joint_velocity: guide}, {name: a, joint: pivot}]
)",
     {length, speed, angle}},
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
    if (std::string(of.name) != "equilibrium") {
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
