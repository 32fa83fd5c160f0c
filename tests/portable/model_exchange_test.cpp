#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <pugixml.hpp>
#include <set>
#include <thread>

#include "mimbre/diagnostics.h"
#include "mimbre/fmu.h"
#include "mimbre/simulation.h"
#include "support/fmu_importer.h"
#include "support/hostile_importer.h"
#include "support/models.h"

/// FMUs for model exchange: their derivatives, integrated here by an explicit rule, against fine runs of the
/// library; changes of coordinates, events in time, and importers that call wrongly.
namespace mimbre::test::model_exchange_test {
namespace {

using testing::HasSubstr;
using Role = FmuVariable::Role;

constexpr const char* double_pendulum = R"yaml(
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
)yaml";

FmuCode fmu_of(const std::shared_ptr<const Model>& model, int version, const std::string& name) {
  FmuOptions options;
  options.kind = FmuOptions::Kind::model_exchange;
  options.version = version;
  options.name = name;
  return generate_fmu(model, {}, options);
}

/// A solver as importers have them: Runge-Kutta's rule with steps of h, events in time at their instants, and
/// of states at the ends of steps.
class Solver {
 public:
  Solver(const FmuLibrary& library, double h) : f_(library), h_(h) {
    const ExchangeInstance::Update first = f_.start_continuous();
    next_ = first.has_next ? first.next : HUGE_VAL;
    x_ = f_.states();
  }

  void go_to(double end) {
    while (time_ < end - 1e-12) {
      const double to = std::min({time_ + h_, end, next_});
      step(to - time_);
      time_ = to;
      f_.set_time(time_);
      f_.set_states(x_);
      const std::vector<double> indicators = f_.indicators();
      const bool event = std::any_of(indicators.begin(), indicators.end(), [](double z) { return z < 0; });
      if (event || time_ >= next_) update();
    }
  }
  ExchangeInstance& instance() { return f_; }
  int changes() const { return changes_; }
  int times() const { return times_; }

 private:
  void step(double h) {
    const auto at = [&](double ahead, const std::vector<double>& k) {
      std::vector<double> x = x_;
      for (std::size_t i = 0; i < x.size(); ++i) x[i] += ahead * k[i];
      return f_.derivatives(time_ + ahead, x);
    };
    const std::vector<double> a = f_.derivatives(time_, x_), b = at(h / 2, a), c = at(h / 2, b), d = at(h, c);
    for (std::size_t i = 0; i < x_.size(); ++i) x_[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
  }
  void update() {
    times_ += time_ >= next_ ? 1 : 0;
    const ExchangeInstance::Update u = f_.event();
    next_ = u.has_next ? u.next : HUGE_VAL;
    EXPECT_GT(next_, time_ + 1e-9);  // and none is told twice
    if (!u.changed) return;
    ++changes_;
    x_ = f_.states();
    for (const double z : f_.indicators()) EXPECT_GT(z, 0);
  }

  ExchangeInstance f_;
  double h_, time_ = 0, next_ = HUGE_VAL;
  std::vector<double> x_;
  int changes_ = 0, times_ = 0;
};

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
/// From steps of h and h/2, whose errors are of second order.
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

/// Largest difference over both of the outputs, by their size or 1.
double difference(Solver& solver, const std::vector<std::vector<double>>& expected, double every) {
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

class ModelExchange : public testing::TestWithParam<int> {
 protected:
  /// Compiled once in a process.
  const FmuLibrary& library(const std::shared_ptr<const Model>& model, const std::string& name) const {
    static std::map<std::pair<std::string, int>, std::unique_ptr<FmuLibrary>> made;
    std::unique_ptr<FmuLibrary>& one = made[{name, GetParam()}];
    if (!one) one = std::make_unique<FmuLibrary>(fmu_of(model, GetParam(), name), "exchange");
    return *one;
  }
};

/// A loop, controllers, and elements that remember.
std::shared_ptr<const Model> driven() {
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

/// A top, and a body that flies.
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

/// What validators look for.
TEST_P(ModelExchange, IsDescribedAsTheStandardWantsIt) {
  const auto model = driven();
  const FmuCode fmu = fmu_of(model, GetParam(), "driven");
  const bool two = GetParam() == 2;
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(fmu_description(fmu, *model, true).c_str()));
  const pugi::xml_node root = document.child("fmiModelDescription");
  EXPECT_TRUE(root.child("ModelExchange"));
  EXPECT_FALSE(root.child("CoSimulation"));
  std::map<std::string, std::string> known;  // by name
  std::set<std::string> states, derivatives, outputs;
  int index = 0;
  for (const pugi::xml_node node : root.child("ModelVariables")) {
    ++index;
    const std::string name = node.attribute("name").value();
    const std::string id = two ? std::to_string(index) : node.attribute("valueReference").value();
    EXPECT_TRUE(known.emplace(name, id).second) << name;
    const pugi::xml_node type = two ? node.first_child() : node;
    if (type.attribute("derivative")) {
      derivatives.insert(id);
      EXPECT_TRUE(states.insert(type.attribute("derivative").value()).second);
      EXPECT_STREQ(node.attribute("causality").value(), "local");
    }
    if (std::string(node.attribute("causality").value()) == "output") outputs.insert(id);
  }
  EXPECT_EQ(states.size(), fmu.code.states.size());
  EXPECT_EQ(known["state.1"], *states.begin());
  const pugi::xml_node structure = root.child("ModelStructure");
  const auto listed = [&](const pugi::xml_node list, const char* element) {
    std::set<std::string> all;
    for (const pugi::xml_node unknown : list.children(element))
      EXPECT_TRUE(all.insert(unknown.attribute(two ? "index" : "valueReference").value()).second);
    return all;
  };
  const char* const unknown = two ? "Unknown" : nullptr;
  EXPECT_EQ(listed(two ? structure.child("Outputs") : structure, two ? unknown : "Output"), outputs);
  EXPECT_EQ(
      listed(two ? structure.child("Derivatives") : structure, two ? unknown : "ContinuousStateDerivative"),
      derivatives);
  std::set<std::string> initial = outputs;
  initial.insert(states.begin(), states.end());
  initial.insert(derivatives.begin(), derivatives.end());
  EXPECT_EQ(listed(two ? structure.child("InitialUnknowns") : structure, two ? unknown : "InitialUnknown"),
            initial);
  if (two)
    EXPECT_EQ(root.attribute("numberOfEventIndicators").as_int(), fmu.code.indicators);
  else
    EXPECT_EQ(listed(structure, "EventIndicator").size(), static_cast<std::size_t>(fmu.code.indicators));
}

/// The schemas of the standards have these attributes, and no others.
TEST_P(ModelExchange, DeclaresWhatItCanDo) {
  const auto model = model_of(double_pendulum);
  const bool two = GetParam() == 2;
  const auto declared = [&](FmuOptions::Kind kind, bool varies) {
    FmuOptions options;
    options.kind = kind;
    options.version = GetParam();
    options.name = "declared";
    FmuCode fmu = generate_fmu(model, {}, options);
    fmu.code.varies = varies;
    pugi::xml_document document;
    EXPECT_TRUE(document.load_string(fmu_description(fmu, *model, true).c_str()));
    const bool exchange = kind == FmuOptions::Kind::model_exchange;
    const pugi::xml_node node =
        document.child("fmiModelDescription").child(exchange ? "ModelExchange" : "CoSimulation");
    std::set<std::string> names;
    for (const pugi::xml_attribute a : node.attributes()) EXPECT_TRUE(names.insert(a.name()).second);
    return names;
  };
  std::set<std::string> both{"modelIdentifier", two ? "canGetAndSetFMUstate" : "canGetAndSetFMUState",
                             two ? "canSerializeFMUstate" : "canSerializeFMUState"};
  std::set<std::string> steps = both;
  steps.insert("canHandleVariableCommunicationStepSize");
  if (!two) steps.insert("fixedInternalStepSize");
  EXPECT_EQ(declared(FmuOptions::Kind::co_simulation, false), steps);
  both.insert(two ? "completedIntegratorStepNotNeeded" : "needsCompletedIntegratorStep");
  EXPECT_EQ(declared(FmuOptions::Kind::model_exchange, false), both);
  both.insert(two ? "providesDirectionalDerivative" : "providesDirectionalDerivatives");
  EXPECT_EQ(declared(FmuOptions::Kind::model_exchange, true), both);
}

/// The schema of FMI 2 has no empty lists: of a mechanism without states, and of one without outputs.
TEST_P(ModelExchange, ListsNothingWhereThereIsNothing) {
  for (const auto& [rest, states, outputs] :
       {std::tuple(", drive: {position: \"sin(t)\"}}}\noutputs: [{name: x, joint: guide}]", 0u, 1u),
        {"}}\noutputs: [{name: push, joint_force: guide, component: fz}]", 2u, 0u}}) {
    const auto model = model_of(
        "bodies: {block: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}}\n"
        "joints: {guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0]" +
        std::string(rest));
    const FmuCode fmu = fmu_of(model, GetParam(), "sparse");
    EXPECT_EQ(fmu.code.states.size(), states);
    EXPECT_EQ(fmu.code.outputs.size(), outputs);
    pugi::xml_document document;
    ASSERT_TRUE(document.load_string(fmu_description(fmu, *model, true).c_str()));
    const pugi::xml_node structure = document.child("fmiModelDescription").child("ModelStructure");
    for (const pugi::xml_node list : structure) EXPECT_TRUE(GetParam() == 3 || list.first_child());
    EXPECT_EQ(structure.select_nodes("//Outputs | //Output").empty(), outputs == 0);
    EXPECT_EQ(structure.select_nodes("//Derivatives | //ContinuousStateDerivative").empty(), states == 0);
  }
}

std::vector<unsigned> operator+(std::vector<unsigned> a, const std::vector<unsigned>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST_P(ModelExchange, KnowsWhatOutputsShowAtOnce) {
  const FmuCode fmu = fmu_of(driven(), GetParam(), "driven");
  const auto of = [&](const std::string& name) { return fmu.variables[reference(fmu, name)]; };
  const std::vector<unsigned> states = references(fmu, {Role::state}), wanted{reference(fmu, "wanted")};
  EXPECT_EQ(of("shown").dependencies, wanted);
  EXPECT_EQ(of("angle").dependencies, states);
  EXPECT_EQ(of("rate").dependencies, states);
  EXPECT_EQ(of("gust").dependencies, states);  // without feedthrough
  EXPECT_EQ(of("servo").dependencies, wanted + states);
  for (const FmuVariable& v : fmu.variables)
    EXPECT_EQ(v.depends_on_all, v.role == Role::derivative || v.role == Role::indicator);
  const FmuCode pendulum = fmu_of(model_of(double_pendulum), GetParam(), "double_pendulum");
  EXPECT_TRUE(pendulum.variables[reference(pendulum, "tip")].depends_on_all);
}

/// Functions of time in signals and in a drive, and a parameter.
std::shared_ptr<const Model> timed_outputs() {
  return model_of(R"yaml(
bodies:
  block: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}
  slider: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}
joints:
  guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 30}, velocity: 1}
  rail: {type: prismatic, between: [block, slider], at: [0, 0, 0], axis: [1, 0, 0], drive: {position: "0.1*sin(7*t)"}}
inputs: {ramp: {start: 0.2, hold: linear}}
parameters: {gain: {value: 3, tunable: true}}
signals:
  clock: sin(3*t)
  scaled: gain*t
  twice: 2*gain
  held: 2*ramp
  place: {joint: rail}
outputs: [{name: x, joint: guide}]
actuators: {motor: {joint: guide, force: "ramp + gain*cos(5*t)"}}
)yaml");
}

/// Both versions count the time among the knowns, and FMI 3 parameters, too.
TEST_P(ModelExchange, DependenciesNameTheTimeAndParameters) {
  const FmuCode fmu = fmu_of(timed_outputs(), GetParam(), "timed_outputs");
  const auto of = [&](const std::string& name) { return fmu.variables[reference(fmu, name)].dependencies; };
  const std::vector<unsigned> time{0},
      states = references(fmu, {Role::state}),
      gain = GetParam() == 2 ? std::vector<unsigned>{} : std::vector<unsigned>{reference(fmu, "gain")};
  EXPECT_EQ(of("clock"), time);
  EXPECT_EQ(of("scaled"), time + gain);
  EXPECT_EQ(of("twice"), gain);
  EXPECT_EQ(of("held"), std::vector<unsigned>{reference(fmu, "ramp")});
  EXPECT_EQ(of("place"), time + states);
}

TEST_P(ModelExchange, DoublePendulumSwingsAsInTheLibrary) {
  const auto model = model_of(double_pendulum);
  const FmuLibrary& of = library(model, "double_pendulum");
  EXPECT_EQ(of.fmu().code.states.size(), 4u);
  EXPECT_EQ(of.fmu().code.indicators, 0);
  EXPECT_EQ(of.fmu().code.states[0].unit, "rad");
  Solver solver(of, 5e-4);
  EXPECT_LE(difference(solver, accurate_run(model, of.fmu(), 2, 0.1), 0.1), 1e-8);
}

TEST_P(ModelExchange, LoopsControllersAndElementsThatRememberMoveAsInTheLibrary) {
  const auto model = driven();
  const FmuLibrary& of = library(model, "driven");
  Solver solver(of, 1e-4);
  EXPECT_LE(difference(solver, extrapolated_run(model, of.fmu(), 1e-4, 0.5, 0.05), 0.05), 1e-6);
}

/// A four-bar that swings over: no coordinate is independent all the way.
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

TEST_P(ModelExchange, ChangesCoordinatesWhereTheyBecomeSingular) {
  const auto model = swinging();
  const FmuLibrary& of = library(model, "swinging");
  Solver solver(of, 1e-4);
  EXPECT_LE(difference(solver, extrapolated_run(model, of.fmu(), 5e-5, 2, 0.1), 0.1), 1e-6);
  EXPECT_GE(solver.changes(), 2);
}

/// Rotations are counted from a reference that follows them; a body may fly, which co-simulation leaves out.
TEST_P(ModelExchange, RotationsGoOnThroughAnyNumberOfTurns) {
  const auto model = turning();
  const FmuLibrary& of = library(model, "turning");
  EXPECT_EQ(of.fmu().code.indicators, 2);
  Solver solver(of, 2e-4);
  EXPECT_LE(difference(solver, accurate_run(model, of.fmu(), 2, 0.1), 0.1), 1e-7);
  EXPECT_GE(solver.changes(), 4);
}

/// A road drops, another has kinks that come again, and a load has some.
TEST_P(ModelExchange, KnowsWhenFunctionsOfTimeJump) {
  const auto model = model_of(R"yaml(
bodies:
  front: {mass: 10, inertia: [1, 1, 1], com: [0, 0, 0.3]}
  rear: {mass: 10, inertia: [1, 1, 1], com: [1, 0, 0.3]}
joints:
  front: {type: prismatic, between: [ground, front], at: [0, 0, 0.3], axis: [0, 0, 1]}
  rear: {type: prismatic, between: [ground, rear], at: [1, 0, 0.3], axis: [0, 0, 1]}
roads:
  drop: {over: time, points: [[0, 0], [0.25, 0], [0.25, -0.05], [2, -0.05]]}
  teeth: {over: time, points: [[0, 0], [0.1, 0.01], [0.2, 0]], repeat: 0.2}
tyres:
  front: {on: front, road: drop, stiffness: 2e4, radius: 0.31}
  rear: {on: rear, road: teeth, stiffness: 2e4, radius: 0.32}
loads: {push: {on: rear, force: [0, 0, 1], scale: {table: [[0, 0], [0.33, 9], [0.4, 9]], interpolation: linear}}}
outputs:
  - {name: z, position: front, component: z}
  - {name: rear, position: rear, component: z}
)yaml");
  const FmuLibrary& of = library(model, "timed");
  Solver solver(of, 1e-4);
  EXPECT_LE(difference(solver, accurate_run(model, of.fmu(), 0.45, 0.05), 0.05), 1e-6);
  EXPECT_EQ(solver.times(), 6);  // 0.1, 0.2, 0.25, 0.3, 0.33, 0.4
}

/// A block on a spring, pushed by what is added.
std::shared_ptr<const Model> pushed(const std::string& by) {
  return model_of(R"yaml(
bodies: {block: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}}
joints: {guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 50, damping: 1}}}
outputs: [{name: x, joint: guide}]
)yaml" + by);
}

/// A road that falls back at the end of each period: the instants are no whole numbers of binary digits.
TEST_P(ModelExchange, EventsThatComeAgainAreToldOnce) {
  const auto model = model_of(R"yaml(
bodies: {block: {mass: 10, inertia: [1, 1, 1], com: [0, 0, 0.3]}}
joints: {guide: {type: prismatic, between: [ground, block], at: [0, 0, 0.3], axis: [0, 0, 1], spring: {damping: 100}}}
roads: {saw: {over: time, points: [[0, 0], [0.2, 0.002]], repeat: 0.2}}
tyres: {tyre: {on: block, road: saw, stiffness: 2e4, radius: 0.31}}
outputs: [{name: z, position: block, component: z}]
)yaml");
  const FmuLibrary& of = library(model, "saw");
  Solver solver(of, 5e-4);
  EXPECT_LE(difference(solver, accurate_run(model, of.fmu(), 2.5, 0.05), 0.05), 1e-7);
  EXPECT_EQ(solver.times(), 12);
}

/// An importer that oversteps events is told of the next one ahead.
TEST_P(ModelExchange, NextEventsAreAhead) {
  const FmuLibrary& of = library(pushed(R"yaml(
loads: {push: {on: block, force: [1, 0, 0], scale: {table: [[0, 0], [0.1, 1], [0.25, 0], [0.3, 2], [0.31, 3]], interpolation: linear}}}
)yaml"),
                                 "overstepped");
  ExchangeInstance f(of);
  EXPECT_EQ(f.start_continuous().next, 0.1);
  EXPECT_EQ(f.set_time(0.27), fmi_ok);
  const ExchangeInstance::Update passed = f.event();
  EXPECT_EQ(passed.next, 0.3);
  EXPECT_EQ(f.set_time(1e16), fmi_ok);
  EXPECT_FALSE(f.event().has_next);
}

TEST_P(ModelExchange, TablesOfTheTimeTellTheirKinks) {
  const auto model = pushed(R"yaml(
signals: {force: {table: t, points: [[0, 0], [0.1037, 8], [0.1037, 0], [0.3021, 5]]}}
actuators: {motor: {joint: guide, force: force}}
)yaml");
  const FmuLibrary& of = library(model, "tabled");
  Solver solver(of, 5e-3);
  EXPECT_LE(difference(solver, accurate_run(model, of.fmu(), 0.4, 0.05), 0.05), 1e-8);
  EXPECT_EQ(solver.times(), 1);  // beyond its ends a table goes on
}

/// Behind the event the force is infinite.
TEST_P(ModelExchange, UpdatesThatFailChangeNothing) {
  const FmuLibrary& of = library(pushed(R"yaml(
signals: {level: {table: t, points: [[0, 1], [0.1, 1], [0.1, 0], [0.2, 0], [0.2, 1], [0.3, 1]]}}
actuators: {motor: {joint: guide, force: 1/level}}
)yaml"),
                                 "failing_update");
  ExchangeInstance f(of);
  EXPECT_EQ(f.start_continuous().next, 0.1);
  EXPECT_EQ(f.set_time(0.1), fmi_ok);
  const std::vector<double> before = f.derivatives(), states = f.states();
  EXPECT_EQ(f.simple("EnterEventMode"), fmi_ok);
  const ExchangeInstance::Update failed = f.update();
  EXPECT_EQ(failed.status, fmi_discard);
  EXPECT_FALSE(failed.changed);
  EXPECT_EQ(f.states(), states);
  EXPECT_EQ(f.derivatives(), before);
  EXPECT_EQ(f.set_time(0.05), fmi_ok);
  EXPECT_EQ(f.update().next, 0.1);
  EXPECT_EQ(f.set_time(0.2), fmi_ok);  // over what cannot be
  EXPECT_EQ(f.update().status, fmi_ok);
}

struct Refused {
  std::string what;
  std::size_t reasons = 0;
};
/// Why there is no FMU of a model; empty: there is one.
Refused refused(const std::string& text, int version) {
  try {
    fmu_of(model_of(text), version, "refused");
  } catch (const InputError& error) {
    return {error.what(), error.diagnostics().size()};
  }
  return {};
}

TEST_P(ModelExchange, RefusesWhatHasNoDerivatives) {
  const auto refusal = [&](const std::string& text) { return refused(text, GetParam()).what; };
  const std::string slider = R"yaml(
bodies: {block: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}}
joints: {guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0]MORE}}
)yaml";
  const auto with = [&](const std::string& joint, const std::string& rest) {
    std::string text = slider;
    return text.replace(text.find("MORE"), 4, joint) + rest;
  };
  EXPECT_EQ(refusal(with("", "")), "");
  EXPECT_THAT(refusal(with("", "frictions: {base: {joint: guide, force: 3}}")),
              testing::AllOf(HasSubstr("base"), HasSubstr("friction")));
  EXPECT_THAT(refusal(with(", drive: {position: place}", "inputs: {place: 0}")),
              testing::AllOf(HasSubstr("guide"), HasSubstr("input")));
  EXPECT_THAT(refusal(with("", "signals: {place: {joint: guide}, slow: {rate_limit: place, rising: 2}}")),
              testing::AllOf(HasSubstr("slow"), HasSubstr("rate_limit, which switches between steps")));
  EXPECT_THAT(refusal(with("", "stops: {end: {joint: guide, lower: 0, stiffness: 1e6}}")),
              testing::AllOf(HasSubstr("stop 'end'"), HasSubstr("no differential equation")));
  EXPECT_THAT(refusal(with("", R"yaml(
roads: {field: {over: distance, points: [[-9, 0], [9, 0]]}}
tyres:
  tyre:
    {on: block, at: [0, 0, 0.3], road: field, model: brush, stiffness: 2e5, damping: 500, radius: 0.32,
     longitudinal_stiffness: 6e4, cornering_stiffness: 5e4, friction: 0.9, longitudinal_relaxation: 0.3,
     lateral_relaxation: 0.5, half_length: 0.07, load: 4000}
)yaml")),
              testing::AllOf(HasSubstr("tyre 'tyre'"), HasSubstr("footprint")));
  const auto hoist = [&](const std::string& length) {
    return with("",
                "cables: {hoist: {over: [ground, block], at: [[0, 0, 3], [0, 0, 0]], axial_stiffness: 5e5, "
                "length: " +
                    length + "}}");
  };
  EXPECT_EQ(refusal(hoist("2.9")), "");
  EXPECT_THAT(refusal(hoist("\"2.9 - 0.2*t\"")),
              testing::AllOf(HasSubstr("cable 'hoist'"), HasSubstr("no differential equation")));
  EXPECT_THAT(refusal(R"yaml(
bodies: {disc: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0.3]}}
joints: {free: {type: floating, between: [ground, disc], at: [0, 0, 0.3]}}
constraints:
  wheel: {type: rolling, between: [ground, disc], at: [[0, 0, 0], [0, 0, 0.3]], axis: [0, 0, 1], axis2: [0, 1, 0], radius: 0.3}
)yaml"),
              testing::AllOf(HasSubstr("constraint 'wheel'"), HasSubstr("velocities")));
  // Accelerations are seen at instants alone, which code does not have.
  EXPECT_THAT(refusal(with("", "signals: {a: {joint_acceleration: guide}}")),
              testing::AllOf(HasSubstr("signal 'a'"), HasSubstr("every")));
  EXPECT_THAT(refusal(with("", "signals: {a: {joint_acceleration: guide, every: 0.01}}")),
              HasSubstr("leave 'every' away"));
}

/// All reasons at once: of elements, and of what is found once the model is recorded.
TEST_P(ModelExchange, RefusesWithAllReasons) {
  const auto reasons = [&](const std::string& text) { return refused(text, GetParam()).reasons; };
  EXPECT_EQ(reasons(R"yaml(
bodies: {block: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}}
joints: {guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0]}}
stops: {end: {joint: guide, lower: 0, stiffness: 1e6}}
frictions: {base: {joint: guide, force: 3}}
signals: {place: {joint: guide}, slow: {rate_limit: place, rising: 2}}
)yaml"),
            3u);
  EXPECT_EQ(reasons(R"yaml(
inputs: {place: 0}
bodies:
  a: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}
  b: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}
  hub: {mass: 0, inertia: [0, 0, 0], com: [0, 0, 0]}
  pin: {mass: 0, inertia: [0, 0, 0], com: [0, 0, 0]}
joints:
  first: {type: prismatic, between: [ground, a], at: [0, 0, 0], axis: [1, 0, 0], drive: {position: place}}
  second: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [1, 0, 0], drive: {position: "2*place"}}
  slide: {type: prismatic, between: [ground, hub], at: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 10}}
  lift: {type: prismatic, between: [ground, pin], at: [0, 0, 0], axis: [0, 0, 1], spring: {stiffness: 10}}
)yaml"),
            4u);
}

TEST_P(ModelExchange, RefusesMotionsWithoutMass) {
  const Refused found = refused(R"yaml(
bodies: {hub: {mass: 0, inertia: [0, 0, 0], com: [0, 0, 0]}, arm: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0.5, 0, 0]}}
joints:
  slide: {type: prismatic, between: [ground, hub], at: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 10}}
  lift: {type: prismatic, between: [ground, arm], at: [0.5, 0, 0], axis: [0, 0, 1]}
)yaml",
                                GetParam());
  EXPECT_EQ(found.reasons, 1u);
  EXPECT_THAT(found.what, testing::AllOf(HasSubstr("slide"), HasSubstr("mass")));
}

/// The C library's mathematics and memory alone.
TEST_P(ModelExchange, NeedsOnlyTheMathematicsOfC) {
  const std::string folder = fmu_sources(fmu_of(driven(), GetParam(), "symbols"), "symbols");
  const std::string wrapper = "fmi" + std::to_string(GetParam());
  for (const std::string& file : {std::string("symbols"), wrapper})
    EXPECT_EQ(printed_by("cc -std=c99 -O2 -Wall -Wextra -Wpedantic -Werror -c " + folder + "/" + file +
                         ".c -o " + folder + "/" + file + ".o"),
              "");
  std::istringstream symbols(printed_by("nm -u " + folder + "/symbols.o"));
  const std::set<std::string> known{"sqrt",
                                    "sin",
                                    "cos",
                                    "tan",
                                    "atan2",
                                    "exp",
                                    "pow",
                                    "log",
                                    "fabs",
                                    "ceil",
                                    "round",
                                    "floor",
                                    "hypot",
                                    "memcpy",
                                    "memset",
                                    "memcmp",
                                    "nextafter",
                                    "sincos",
                                    "_GLOBAL_OFFSET_TABLE_"};
  std::string mark, name;
  while (symbols >> mark >> name) EXPECT_TRUE(known.contains(name)) << name;
}

TEST_P(ModelExchange, EightThreadsHaveTheSameBits) {
  const FmuLibrary& of = library(driven(), "driven");
  std::vector<std::vector<double>> found(8);
  std::vector<std::thread> threads;
  for (std::vector<double>& one : found)
    threads.emplace_back([&] {
      Solver solver(of, 1e-3);
      solver.go_to(0.05);
      one = solver.instance().states();
    });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<double>& one : found) EXPECT_EQ(one, found[0]);
}

TEST_P(ModelExchange, RefusesWrongCalls) {
  const FmuLibrary& of = library(driven(), "driven");
  const double nan = std::nan("");
  ExchangeInstance f(of);
  const std::size_t n = f.size();
  std::vector<double> x(n + 1, 0.0);
  EXPECT_EQ(f.set_time(0), fmi_error);
  EXPECT_EQ(f.set_states(x.data(), n), fmi_error);
  EXPECT_EQ(f.simple("EnterContinuousTimeMode"), fmi_error);
  EXPECT_EQ(f.simple("EnterEventMode"), fmi_error);
  f.start();
  EXPECT_EQ(f.set(reference(of.fmu(), "k"), 2), fmi_ok);  // at an event
  EXPECT_EQ(f.update().status, fmi_ok);
  EXPECT_EQ(f.set_states(x.data(), n), fmi_error);
  EXPECT_EQ(f.set_time(0), fmi_ok);  // importers do so at events
  EXPECT_EQ(f.simple("EnterEventMode"), GetParam() == 2 ? fmi_ok : fmi_error);
  EXPECT_EQ(f.simple("EnterContinuousTimeMode"), fmi_ok);
  EXPECT_EQ(f.update().status, fmi_error);
  const std::vector<double> before = f.derivatives(), states = f.states();
  EXPECT_EQ(f.set(reference(of.fmu(), "k"), 1), fmi_error);
  EXPECT_THAT(f.messages(), HasSubstr("events"));
  EXPECT_EQ(f.set(reference(of.fmu(), "wanted"), nan), fmi_error);
  EXPECT_EQ(f.set(reference(of.fmu(), "state.1"), 1), fmi_error);
  EXPECT_EQ(f.get({static_cast<unsigned>(of.fmu().variables.size())}, x.data()), fmi_error);
  EXPECT_EQ(f.set_time(nan), fmi_error);
  EXPECT_EQ(f.set_states(states.data(), n - 1), fmi_error);
  EXPECT_EQ(f.set_states(nullptr, n), fmi_error);
  std::vector<double> wrong = states;
  wrong[0] = nan;
  EXPECT_EQ(f.set_states(wrong), fmi_error);
  for (const char* function : {"GetContinuousStates", "GetNominalsOfContinuousStates", "GetEventIndicators"})
    EXPECT_EQ(f.read(function, x.data(), n + 1), fmi_error) << function;
  EXPECT_EQ(f.read(f.derivatives_function(), x.data(), n + 1), fmi_error);
  EXPECT_EQ(f.read(f.derivatives_function(), nullptr, n), fmi_error);
  EXPECT_EQ(f.derivatives(), before);
  EXPECT_EQ(f.simple("Terminate"), fmi_ok);
  EXPECT_EQ(f.set_time(1), fmi_error);
  EXPECT_EQ(f.simple("Reset"), fmi_ok);
  f.start_continuous();
  EXPECT_NE(f.derivatives(), std::vector<double>(n, 0.0));
}

/// Positions that the loop cannot reach: the importer may try a shorter step.
TEST_P(ModelExchange, DiscardsStatesOutOfReach) {
  const FmuLibrary& of = library(swinging(), "swinging");
  ExchangeInstance f(of);
  f.start_continuous();
  const std::vector<double> before = f.derivatives(), states = f.states();
  std::vector<double> far = states, found(f.size());
  far[0] += 3;
  EXPECT_EQ(f.set_states(far), fmi_ok);
  EXPECT_EQ(f.read(f.derivatives_function(), found.data(), f.size()), fmi_discard);
  EXPECT_THAT(f.messages(), HasSubstr("dependent"));
  EXPECT_EQ(f.get({reference(of.fmu(), "crank")}, found.data()), fmi_discard);
  EXPECT_EQ(f.set_states(states), fmi_ok);
  const std::vector<double> after = f.derivatives();
  for (std::size_t k = 0; k < f.size(); ++k) EXPECT_NEAR(after[k], before[k], 1e-12 * std::abs(before[k]));
}

/// Derivatives, outputs and indicators along random directions of states and inputs, by differences of
/// fourth order; largest difference by the size of each.
double difference_of_directions(ExchangeInstance& f, const FmuCode& fmu, double step) {
  const std::vector<double> x = f.states(), nominals = f.nominals();
  const std::vector<unsigned> inputs = references(fmu, {Role::input}),
                              states = references(fmu, {Role::state});
  const std::vector<unsigned> unknowns = references(fmu, {Role::derivative, Role::output, Role::indicator});
  std::vector<unsigned> knowns = states;
  knowns.insert(knowns.end(), inputs.begin(), inputs.end());
  std::vector<double> given;
  for (const unsigned input : inputs) given.push_back(f.get(input));
  double most = 0;
  for (int direction = 0; direction < 6; ++direction) {
    std::vector<double> seed, exact(unknowns.size());
    for (std::size_t k = 0; k < knowns.size(); ++k)
      seed.push_back(std::sin(1.7 * static_cast<double>(k) + direction) * (k < x.size() ? nominals[k] : 1));
    EXPECT_EQ(f.vary(unknowns, knowns, seed, exact.data()), fmi_ok) << f.messages();
    const auto at = [&](double ahead) {
      std::vector<double> y = x, out(unknowns.size());
      for (std::size_t k = 0; k < x.size(); ++k) y[k] += ahead * seed[k];
      for (std::size_t k = 0; k < inputs.size(); ++k)
        EXPECT_EQ(f.set(inputs[k], given[k] + ahead * seed[x.size() + k]), fmi_ok);
      EXPECT_EQ(f.set_states(y), fmi_ok);
      EXPECT_EQ(f.get(unknowns, out.data()), fmi_ok) << f.messages();
      return out;
    };
    const std::vector<double> a = at(step), b = at(-step), c = at(2 * step), d = at(-2 * step);
    at(0);
    for (std::size_t k = 0; k < unknowns.size(); ++k) {
      const double found = (8 * (a[k] - b[k]) - (c[k] - d[k])) / (12 * step);
      const double off = std::abs(found - exact[k]) / std::max(1.0, std::abs(exact[k]));
      EXPECT_TRUE(std::isfinite(off));
      EXPECT_LE(off, 1e-4) << fmu.variables[unknowns[k]].name << " " << found << " " << exact[k];
      most = off <= most ? most : off;
    }
  }
  return most;
}

TEST_P(ModelExchange, DirectionalDerivativesAreThoseOfDifferences) {
  for (const auto& [model, name, tolerance] : {std::tuple(model_of(double_pendulum), "double_pendulum", 1e-9),
                                               {driven(), "driven", 1e-7},
                                               {swinging(), "swinging", 1e-8},
                                               {turning(), "turning", 1e-8}}) {
    SCOPED_TRACE(name);
    const FmuLibrary& of = library(model, name);
    EXPECT_TRUE(of.fmu().code.varies);
    Solver solver(of, 5e-4);
    solver.go_to(0.15);
    EXPECT_LE(difference_of_directions(solver.instance(), of.fmu(), 1e-4), tolerance);
  }
}

/// Partial derivatives by the time, states and inputs held, against differences of fourth order.
TEST_P(ModelExchange, DirectionalDerivativesByTheTime) {
  for (const auto& [model, name] :
       {std::pair(driven(), "driven"), std::pair(timed_outputs(), "timed_outputs")}) {
    SCOPED_TRACE(name);
    const FmuLibrary& of = library(model, name);
    const std::vector<unsigned> unknowns = references(of.fmu(), {Role::derivative, Role::output});
    Solver solver(of, 5e-4);
    solver.go_to(0.15);
    ExchangeInstance& f = solver.instance();
    const std::vector<double> x = f.states();
    const auto at = [&](double time) {
      std::vector<double> out(unknowns.size());
      EXPECT_EQ(f.set_time(time), fmi_ok);
      EXPECT_EQ(f.set_states(x), fmi_ok);
      EXPECT_EQ(f.get(unknowns, out.data()), fmi_ok);
      return out;
    };
    constexpr double h = 1e-3;
    const std::vector<double> a = at(0.15 + h), b = at(0.15 - h), c = at(0.15 + 2 * h), d = at(0.15 - 2 * h);
    const std::vector<double> before = at(0.15);
    std::vector<double> exact(unknowns.size());
    EXPECT_EQ(f.vary(unknowns, {0}, {2}, exact.data()), fmi_ok) << f.messages();
    EXPECT_EQ(at(0.15), before);
    double largest = 0;
    for (std::size_t k = 0; k < unknowns.size(); ++k) {
      const double found = (8 * (a[k] - b[k]) - (c[k] - d[k])) / (12 * h);
      EXPECT_NEAR(exact[k] / 2, found, 1e-6 * std::max(1.0, std::abs(found)))
          << of.fmu().variables[unknowns[k]].name;
      largest = std::max(largest, std::abs(found));
    }
    EXPECT_GT(largest, 0.1);
  }
}

TEST_P(ModelExchange, DrivesOverRoadsAsInTheLibrary) {
  const auto model = model_of(R"yaml(
bodies: {car: {mass: 10, inertia: [1, 1, 1], com: [0, 0, 0.3]}, wheel: {mass: 1, inertia: [1, 1, 1], com: [0, 0, 0.3]}}
joints:
  way: {type: prismatic, between: [ground, car], at: [0, 0, 0.3], axis: [1, 0, 0], velocity: 3}
  column: {type: prismatic, between: [car, wheel], at: [0, 0, 0.3], axis: [0, 0, 1]}
roads: {track: {over: distance, points: [[-9, -0.45], [9, 0.45]]}}
tyres: {tyre: {on: wheel, road: track, stiffness: 981, radius: 0.31}}
outputs: [{name: z, position: wheel, component: z}]
)yaml");
  const FmuLibrary& of = library(model, "uphill");
  Solver solver(of, 2e-4);
  EXPECT_LE(difference(solver, accurate_run(model, of.fmu(), 0.5, 0.1), 0.1), 1e-7);
  EXPECT_TRUE(of.fmu().code.varies);
  EXPECT_LE(difference_of_directions(solver.instance(), of.fmu(), 1e-4), 1e-8);
}

TEST_P(ModelExchange, RefusesWrongDirections) {
  const FmuLibrary& of = library(driven(), "driven");
  const unsigned state = reference(of.fmu(), "state.1"), rate = reference(of.fmu(), "der(state.1)"),
                 speed = reference(of.fmu(), "state.2");
  ExchangeInstance f(of);
  double result = 7;
  EXPECT_EQ(f.vary({rate}, {speed}, {1}, &result), fmi_error);
  f.start_continuous();
  EXPECT_EQ(f.vary({state}, {speed}, {1}, &result), fmi_error);
  EXPECT_EQ(f.vary({rate}, {rate}, {1}, &result), fmi_error);
  EXPECT_EQ(f.vary({rate}, {4000000000u}, {1}, &result), fmi_error);
  EXPECT_EQ(f.vary({rate}, {speed}, {std::nan("")}, &result), fmi_error);
  EXPECT_EQ(f.vary({rate}, {speed}, {1}, nullptr), fmi_error);
  EXPECT_EQ(result, 7);
  EXPECT_EQ(f.vary({rate}, {speed}, {3}, &result), fmi_ok);
  EXPECT_EQ(result, 3);
  EXPECT_EQ(f.vary({rate}, {0}, {1}, &result), fmi_ok);  // by the time, the states held
  EXPECT_EQ(result, 0);
}

TEST_P(ModelExchange, NamesDirectionalDerivativesWhereAdjointOnesAreCalled) {
  const FmuLibrary& of = library(driven(), "driven");
  ExchangeInstance f(of);
  f.start_continuous();
  if (of.two()) {
    EXPECT_FALSE(of.has("fmi2GetAdjointDerivative"));  // FMI 3 has introduced them
    return;
  }
  const unsigned unknown = reference(of.fmu(), "der(state.1)"), known = reference(of.fmu(), "state.1");
  const double seed = 1;
  double result = 7;
  EXPECT_EQ(of.call("GetAdjointDerivative", f.handle(), &unknown, std::size_t{1}, &known, std::size_t{1},
                    &seed, std::size_t{1}, &result, std::size_t{1}),
            fmi_error);
  EXPECT_EQ(result, 7);
  EXPECT_THAT(f.messages(),
              testing::AllOf(HasSubstr("no adjoint"), HasSubstr("fmi3GetDirectionalDerivative")));
}

/// The scales of the mechanism: 1 rad, a length, and rates by a pace that is one of all.
TEST_P(ModelExchange, NominalsAreOfTheScaleOfTheStates) {
  for (const auto& [model, name] : {std::pair(model_of(double_pendulum), "double_pendulum"),
                                    {driven(), "driven"},
                                    {swinging(), "swinging"},
                                    {turning(), "turning"}}) {
    SCOPED_TRACE(name);
    const FmuLibrary& of = library(model, name);
    Solver solver(of, 5e-4);
    std::vector<double> largest(of.fmu().code.states.size());
    for (int k = 0; k <= 20; ++k) {
      solver.go_to(0.01 * k);
      const std::vector<double> x = solver.instance().states();
      for (std::size_t i = 0; i < x.size(); ++i) largest[i] = std::max(largest[i], std::abs(x[i]));
    }
    const std::vector<double> nominals = solver.instance().nominals();
    ASSERT_EQ(nominals.size(), largest.size());
    for (std::size_t i = 0; i < nominals.size(); ++i) {
      EXPECT_TRUE(std::isfinite(nominals[i]) && nominals[i] > 0) << nominals[i];
      EXPECT_LE(largest[i], 30 * nominals[i]) << i << " " << of.fmu().code.states[i].meaning;
    }
  }
  const std::vector<double> nominals = [&] {
    ExchangeInstance f(library(model_of(double_pendulum), "double_pendulum"));
    f.start_continuous();
    return f.nominals();
  }();
  EXPECT_EQ(nominals[0], 1);  // rad
  EXPECT_EQ(nominals[1], 1);
  EXPECT_EQ(nominals[2], nominals[3]);
  EXPECT_GT(nominals[2], 1);  // rad/s: the pace of a pendulum of the mechanism's length
  EXPECT_LT(nominals[2], 10);
}

TEST_P(ModelExchange, GoesOnFromSavedStates) {
  const FmuLibrary& of = library(driven(), "driven");
  Solver solver(of, 1e-3);
  solver.go_to(0.1);
  ExchangeInstance& f = solver.instance();
  void* state = nullptr;
  ASSERT_EQ(f.get_state(&state), fmi_ok);
  const std::vector<double> x = f.states();
  const auto ahead = [&](ExchangeInstance& g) {
    std::vector<double> y = g.states();
    for (double& z : y) z += 1e-3;
    std::vector<double> out = g.derivatives(0.101, y);
    y[0] += 1e-3;
    const std::vector<double> more = g.derivatives(0.102, y);
    out.insert(out.end(), more.begin(), more.end());
    return out;
  };
  const std::vector<double> first = ahead(f);
  ASSERT_EQ(f.set_state(state), fmi_ok);
  EXPECT_EQ(f.states(), x);
  EXPECT_EQ(ahead(f), first);
  std::vector<char> bytes(f.state_size(state));
  ASSERT_EQ(f.write_state(state, bytes.data(), bytes.size()), fmi_ok);
  ExchangeInstance other(of);
  void* read = nullptr;
  ASSERT_EQ(other.read_state(bytes.data(), bytes.size(), &read), fmi_ok);
  ASSERT_EQ(other.set_state(read), fmi_ok);
  EXPECT_EQ(ahead(other), first);
}

/// Random calls with wrong arguments, under the sanitizers.
TEST_P(ModelExchange, StandsHostileImporters) {
  const FmuCode fmu = fmu_of(driven(), GetParam(), "hostile_exchange");
  const std::string printed =
      printed_by_hostile(fmu, "hostile_exchange", "-DSTATES=" + std::to_string(fmu.code.states.size()));
  if (printed.empty()) GTEST_SKIP() << "the compiler has no sanitizers";
  expect_good_calls(printed, 15, {});
}

INSTANTIATE_TEST_SUITE_P(Versions, ModelExchange, testing::Values(2, 3),
                         [](const testing::TestParamInfo<int>& version) {
                           return "Fmi" + std::to_string(version.param);
                         });

}  // namespace
}  // namespace mimbre::test::model_exchange_test
