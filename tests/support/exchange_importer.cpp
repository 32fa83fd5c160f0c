#include "support/exchange_importer.h"

#include <algorithm>
#include <map>
#include <utility>

#include "mimbre/simulation.h"

namespace mimbre::test {

FmuCode exchange_fmu(const std::shared_ptr<const Model>& model, int version, const std::string& name) {
  FmuOptions options;
  options.kind = FmuOptions::Kind::model_exchange;
  options.version = version;
  options.name = name;
  return generate_fmu(model, {}, options);
}

namespace {

/// Outputs of a run with steps of h, every `every` seconds.
std::vector<std::vector<double>> run(const std::shared_ptr<const Model>& model, const FmuCode& fmu,
                                     RunOptions options, double end, double every) {
  options.end = end;
  options.energies = options.validity = options.warnings = false;
  Simulation s(model, options);
  std::vector<Simulation::Channel> channels;
  for (const GeneratedVariable& o : fmu.code.outputs) {
    const bool own = std::any_of(s.channels().begin(), s.channels().end(),
                                 [&](const ChannelInfo& c) { return c.name == o.name; });
    channels.push_back(s.channel(own ? o.name : "signal." + o.name));
  }
  std::vector<std::vector<double>> out;
  for (double t = 0; t < end + every / 2; t += every) {
    while (s.time() < t - s.step_size() / 2) EXPECT_TRUE(s.step().ok());
    out.emplace_back();
    for (const Simulation::Channel c : channels) out.back().push_back(s.value(c));
  }
  return out;
}

}  // namespace

std::vector<std::vector<double>> extrapolated_run(const std::shared_ptr<const Model>& model,
                                                  const FmuCode& fmu, double h, double end, double every) {
  RunOptions coarse, fine;
  coarse.tolerance = fine.tolerance = 1e-10;
  coarse.step = h;
  fine.step = h / 2;
  const auto a = run(model, fmu, coarse, end, every);
  auto b = run(model, fmu, fine, end, every);
  for (std::size_t k = 0; k < b.size(); ++k)
    for (std::size_t i = 0; i < b[k].size(); ++i) b[k][i] += (b[k][i] - a[k][i]) / 3;
  return b;
}

std::vector<std::vector<double>> accurate_run(const std::shared_ptr<const Model>& model, const FmuCode& fmu,
                                              double end, double every) {
  RunOptions options;
  options.accuracy = 1e-11;
  return run(model, fmu, options, end, every);
}

double difference(ExchangeSolver& solver, const std::vector<std::vector<double>>& expected, double every) {
  double most = 0;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    solver.go_to(static_cast<double>(k) * every);
    const std::vector<double> found = solver.instance().outputs();
    for (std::size_t o = 0; o < found.size(); ++o) {
      const double off = std::abs(found[o] - expected[k][o]) / std::max(1.0, std::abs(expected[k][o]));
      EXPECT_TRUE(std::isfinite(off)) << found[o] << " " << expected[k][o];
      most = off <= most ? most : off;
    }
  }
  return most;
}

const FmuLibrary& ExchangeTest::library(const std::shared_ptr<const Model>& model,
                                        const std::string& name) const {
  static std::map<std::pair<std::string, int>, std::unique_ptr<FmuLibrary>> made;
  std::unique_ptr<FmuLibrary>& one = made[{name, GetParam()}];
  if (!one) one = std::make_unique<FmuLibrary>(exchange_fmu(model, GetParam(), name), "exchange");
  return *one;
}

std::string name_of_version(const testing::TestParamInfo<int>& version) {
  return "Fmi" + std::to_string(version.param);
}

std::shared_ptr<const Model> double_pendulum() {
  return model_of(R"yaml(
bodies:
  upper: {mass: 1, inertia: [0.02, 0.02, 0.001], com: [0, 0, -0.4]}
  lower: {mass: 0.6, inertia: [0.01, 0.01, 0.001], com: [0, 0, -1.1]}
joints:
  shoulder: {type: revolute, between: [ground, upper], at: [0, 0, 0], axis: [0, 1, 0], position: 1.2}
  elbow: {type: revolute, between: [upper, lower], at: [0, 0, -0.8], axis: [0, 1, 0], position: 0.7}
outputs:
  - {name: shoulder, joint: shoulder}
  - {name: elbow, joint: elbow}
  - {name: tip, acceleration: lower, component: x}
)yaml");
}

std::shared_ptr<const Model> driven_loop() {
  return model_of(four_bar_text({{"rocker", ", cut: always, spring: {stiffness: 4, damping: 0.2}"}}) + R"yaml(
inputs:
  wanted: {start: 0.2, range: [-1, 1]}
  wind: {start: 1, hold: linear}
parameters: {k: {value: 3, tunable: true}}
signals:
  angle: {joint: crank}
  rate: {joint_velocity: crank}
  gust: {transfer_function: wind, numerator: [1], denominator: [2e-3, 0.05, 1]}
  servo: {pid: angle, setpoint: wanted, kp: 2, ki: 30, kd: 0.05, filter: 0.04, upper: 2, lower: -2}
  shown: "2*wanted"
actuators:
  motor: {joint: crank, torque: "servo + 0.1*gust - 0.2*rate - 0.1*k*sin(9*t)"}
hydraulic_dampers:
  d: {between: [ground, coupler], at: [[0.3, 0, 0.9], [0.3, 0, 0.35]], damping: 20, quadratic: 5, area: 0.5 cm^2, length: 10 cm, bulk_modulus: 1e6}
bushings:
  mount:
    between: [crank, coupler]
    at: [0.1, 0, 0.3]
    stiffness: [40, 40, 60, 1, 1, 1]
    damping: [1, 1, 1, 0.1, 0.1, 0.1]
    maxwell: [{stiffness: [50, 30, 20, 1, 1, 1], relaxation: 0.03}]
)yaml");
}

std::shared_ptr<const Model> swinging() {
  return model_of(R"yaml(
bodies:
  crank: {mass: 1, com: [0.25, 0, 0], inertia: [0.01, 0.02, 0.02]}
  coupler: {mass: 1, com: [0.7, 0, 0.15], inertia: [0.01, 0.02, 0.02]}
  rocker: {mass: 1, com: [0.95, 0, 0.15], inertia: [0.01, 0.02, 0.02]}
joints:
  crank: {type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 1, 0], velocity: 9}
  crank_pin: {type: revolute, between: [crank, coupler], at: [0.5, 0, 0], axis: [0, 1, 0]}
  rocker_pin: {type: revolute, between: [coupler, rocker], at: [0.9, 0, 0.3], axis: [0, 1, 0]}
  rocker: {type: revolute, between: [ground, rocker], at: [1, 0, 0], axis: [0, 1, 0], cut: always}
outputs:
  - {name: crank, joint: crank}
  - {name: rocker, joint: rocker}
)yaml");
}

std::shared_ptr<const Model> turning() {
  return model_of(R"yaml(
bodies:
  top: {mass: 1, com: [0, 0, 0.2], inertia: [0.02, 0.03, 0.01]}
  flier: {mass: 2, com: [1, 0, 0], inertia: [0.1, 0.2, 0.25]}
joints:
  ball: {type: spherical, between: [ground, top], at: [0, 0, 0], velocity: [3, 1, 12]}
  free: {type: floating, between: [ground, flier], at: [1, 0, 0], velocity: [0, 0.2, 1, 0.1, 7, 0.2]}
outputs:
  - {name: x, position: top, component: x}
  - {name: z, position: top, component: z}
  - {name: flier.x, position: flier, component: x}
  - {name: flier.spin, angular_velocity: flier, component: x}
)yaml");
}

std::shared_ptr<const Model> timed_outputs() {
  return model_of(R"yaml(
bodies:
  block: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}
  slider: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}
  cart: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}
joints:
  guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 30}, velocity: 1}
  track: {type: prismatic, between: [block, cart], at: [0, 0, 0], axis: [1, 0, 0], drive: {speed: "0.6/(1.2 + cos(5*t))"}}
  rail: {type: prismatic, between: [block, slider], at: [0, 0, 0], axis: [1, 0, 0], drive: {position: "0.1*sin(7*t)"}}
inputs: {ramp: {start: 0.2, hold: linear}}
parameters: {gain: {value: 3, tunable: true}}
signals:
  clock: sin(3*t)
  scaled: gain*t
  twice: 2*gain
  held: 2*ramp
  place: {joint: rail}
  way: {joint: track}
outputs: [{name: x, joint: guide}]
actuators: {motor: {joint: guide, force: "ramp + gain*cos(5*t)"}}
)yaml");
}

std::shared_ptr<const Model> uphill() {
  return model_of(R"yaml(
bodies: {car: {mass: 10, inertia: [1, 1, 1], com: [0, 0, 0.3]}, wheel: {mass: 1, inertia: [1, 1, 1], com: [0, 0, 0.3]}}
joints:
  way: {type: prismatic, between: [ground, car], at: [0, 0, 0.3], axis: [1, 0, 0], velocity: 3}
  column: {type: prismatic, between: [car, wheel], at: [0, 0, 0.3], axis: [0, 0, 1]}
roads: {track: {over: distance, points: [[-9, -0.45], [9, 0.45]]}}
tyres: {tyre: {on: wheel, road: track, stiffness: 981, radius: 0.31}}
outputs: [{name: z, position: wheel, component: z}]
)yaml");
}

}  // namespace mimbre::test
