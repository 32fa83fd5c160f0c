#include <dlfcn.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>

#include "mimbre/generate.h"
#include "mimbre/simulation.h"
#include "support/models.h"

/// Generated code against the library, step by step.
namespace mimbre::test::generated_code_test {
namespace {

/// Of this process alone: tests of one model run beside each other.
std::string folder() {
  const std::string made = testing::TempDir() + "generated_code_" + std::to_string(getpid()) + "/";
  std::filesystem::create_directories(made);
  return made;
}

/// What a command prints; it has to succeed.
std::string output_of(const std::string& command) {
  const std::string file = folder() + "output.txt";
  EXPECT_EQ(std::system((command + " > " + file + " 2>&1").c_str()), 0) << command;
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// Compiled code of a model, loaded.
class Code {
 public:
  Code(const GeneratedCode& code, const std::string& compiler = "cc") : code_(code) {
    folder_ = folder() + code.name;
    write_code(code, folder_);
    const std::string stem = folder_ + "/" + code.name;
    const std::string made = output_of(compiler + " -std=c99 -O1 -Wall -Wextra -Wpedantic -Werror -fPIC -c " +
                                       stem + ".c -o " + stem + ".o");
    EXPECT_EQ(made, "");
    output_of(compiler + " -shared " + stem + ".o -o " + stem + ".so -lm");
    library_ = dlopen((stem + ".so").c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library_) throw std::runtime_error(dlerror());
    state_.resize(static_cast<std::size_t>(code.bytes) / 8 + 1);
    function<void (*)(void*)>("init")(state_.data());
  }
  ~Code() { dlclose(library_); }
  Code(const Code&) = delete;
  Code& operator=(const Code&) = delete;

  int step() { return function<int (*)(void*)>("step")(state_.data()); }
  int set_input(int input, double value) {
    return function<int (*)(void*, int, double)>("set_input")(state_.data(), input, value);
  }
  double output(int k) { return function<double (*)(void*, int)>("get_output")(state_.data(), k); }
  double time() { return function<double (*)(const void*)>("time")(state_.data()); }
  std::vector<double>& state() { return state_; }
  void save(std::vector<double>& to) {
    to.resize(state_.size());
    function<void (*)(const void*, void*)>("save")(state_.data(), to.data());
  }
  void restore(const std::vector<double>& from) {
    function<void (*)(void*, const void*)>("restore")(state_.data(), from.data());
  }
  void init() { function<void (*)(void*)>("init")(state_.data()); }
  std::string object() const { return folder_ + "/" + code_.name + ".o"; }

 private:
  template <class F>
  F function(const std::string& name) {
    return reinterpret_cast<F>(dlsym(library_, (code_.name + "_" + name).c_str()));
  }
  const GeneratedCode& code_;
  std::string folder_;
  void* library_ = nullptr;
  std::vector<double> state_;
};

RunOptions fixed_cost() {
  RunOptions options;
  options.fixed_cost = true;
  options.energies = options.validity = options.warnings = false;
  return options;
}

/// The channel of an output: a signal's has another name.
Simulation::Channel channel_of(const Simulation& s, const GeneratedVariable& output) {
  for (const ChannelInfo& channel : s.channels())
    if (channel.name == output.name) return s.channel(output.name);
  return s.channel("signal." + output.name);
}

/// Largest difference of an output over a second, by its largest value or 1.
double difference(const std::shared_ptr<const Model>& model, const GeneratedCode& code, Code& made,
                  double seconds = 1) {
  Simulation s(model, fixed_cost());
  std::vector<Simulation::Channel> channels;
  for (const GeneratedVariable& o : code.outputs) channels.push_back(channel_of(s, o));
  std::vector<double> off(channels.size(), 0), size(channels.size(), 1);
  const int steps = static_cast<int>(std::lround(seconds / s.step_size()));
  for (int step = 0; step <= steps; ++step) {
    for (std::size_t k = 0; k < channels.size(); ++k) {
      const double expected = s.value(channels[k]), apart = made.output(static_cast<int>(k)) - expected;
      size[k] = std::max(size[k], std::abs(expected));
      off[k] = std::abs(apart) <= off[k] ? off[k] : std::abs(apart);
    }
    EXPECT_EQ(made.time(), s.time());
    // Inputs move, the same in both.
    for (std::size_t k = 0; k < code.inputs.size(); ++k) {
      const double value = code.inputs[k].start + 0.2 * std::sin(3 * s.time() + static_cast<double>(k));
      s.set_input(static_cast<int>(k), value);
      made.set_input(static_cast<int>(k), value);
    }
    EXPECT_TRUE(s.step().ok());
    EXPECT_LE(made.step(), 1);
  }
  double most = 0;
  for (std::size_t k = 0; k < off.size(); ++k) most = off[k] / size[k] <= most ? most : off[k] / size[k];
  return most;
}

struct Case {
  const char *name, *path;
  double tolerance;
  friend void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }
};

class GeneratedCodeOf : public testing::TestWithParam<Case> {};

TEST_P(GeneratedCodeOf, StepsAsTheLibraryDoes) {
  const auto model = example(GetParam().path);
  const GeneratedCode code = generate_code(model, {}, GetParam().name);
  ASSERT_FALSE(code.outputs.empty());
  Code made(code);
  EXPECT_LE(difference(model, code, made), GetParam().tolerance);
}

TEST_P(GeneratedCodeOf, NeedsOnlyTheMathematicsOfC) {
  const GeneratedCode code = generate_code(example(GetParam().path), {}, GetParam().name);
  const Code made(code);
  std::istringstream symbols(output_of("nm -u " + made.object()));
  std::istringstream names(
      "sqrt sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp expm1 log log2 log10 fabs round "
      "floor "
      "ceil atan2 pow hypot memcpy memset sincos _GLOBAL_OFFSET_TABLE_");
  const std::set<std::string> known{std::istream_iterator<std::string>(names), {}};
  std::string mark, name;
  while (symbols >> mark >> name) EXPECT_TRUE(known.contains(name)) << name;
}

TEST_P(GeneratedCodeOf, GoesOnFromASavedState) {
  const GeneratedCode code = generate_code(example(GetParam().path), {}, GetParam().name);
  Code made(code), other(code);
  for (int k = 0; k < 10; ++k) made.step();
  std::vector<double> saved;
  made.save(saved);
  other.restore(saved);
  for (int k = 0; k < 10; ++k) {
    made.step();
    other.step();
  }
  EXPECT_EQ(made.time(), other.time());
  for (int k = 0; k < static_cast<int>(code.outputs.size()); ++k) EXPECT_EQ(made.output(k), other.output(k));
}

// A step whose iterations are just about over may end one earlier or later than the library's: then they
// differ by what the tolerance leaves of a stiff deformation.
INSTANTIATE_TEST_SUITE_P(Examples, GeneratedCodeOf,
                         testing::Values(Case{"pendulum", "tutorial/pendulum.yaml", 1e-13},
                                         Case{"double_four_bar", "double-four-bar/mechanism.yaml", 1e-10},
                                         Case{"flexible_pendulum", "pendulum/flexible.yaml", 1e-12},
                                         Case{"bricard", "bricard/mechanism.yaml", 1e-10},
                                         Case{"suspension", "iltis/suspension.yaml", 1e-10},
                                         Case{"slider_crank", "slider-crank/slider-crank.yaml", 1e-9},
                                         Case{"four_bar", "tutorial/four-bar.yaml", 1e-10},
                                         Case{"crank_train", "crank-train/model.yaml", 1e-10},
                                         Case{"washing_machine", "washing-machine/model.yaml", 1e-10},
                                         Case{"wind_turbine", "wind-turbine/model.yaml", 1e-10}),
                         [](const testing::TestParamInfo<Case>& c) { return std::string(c.param.name); });

/// Inputs, a controller that remembers, a spring with a law of an input: what jumps, is held and is fed back.
TEST(GeneratedCode, FollowsInputsAndBlocks) {
  std::string text = four_bar_text({{"rocker", ", cut: always, spring: {stiffness: 4, damping: 0.2}"}});
  const auto model = model_of(text + R"yaml(
inputs:
  wanted: {start: 0.2, range: [-1, 1]}
  wind: {start: 1, hold: linear}
signals:
  angle: {joint: crank}
  rate: {joint_velocity: crank}
  gust: {transfer_function: wind, numerator: [1], denominator: [2e-4, 0.02, 1]}
  servo: {pid: angle, setpoint: wanted, kp: 2, ki: 3, kd: 0.05, filter: 0.04, upper: 4, lower: -4}
  slow: {rate_limit: wanted, rising: 2}
  chosen: "angle > 0 ? sin(rate)*slow : max(gust, wanted^2)"
actuators:
  motor: {joint: crank, torque: "servo + 0.1*chosen - 0.2*rate"}
)yaml");
  const GeneratedCode code = generate_code(model, {}, "driven");
  ASSERT_EQ(code.inputs.size(), 2u);
  EXPECT_EQ(code.inputs[0].identifier, "IN_WANTED");
  Code made(code);
  EXPECT_LE(difference(model, code, made), 1e-10);
  // Out of range it is kept at the range's end; wrong ones are refused and change nothing.
  EXPECT_NE(made.set_input(7, 0), 0);
  EXPECT_NE(made.set_input(-1, 0), 0);
  EXPECT_NE(made.set_input(0, std::nan("")), 0);
  EXPECT_TRUE(std::isnan(made.output(1000)));
}

/// Of halves the even number, as the library does.
TEST(GeneratedCode, RoundsToWholeNumbers) {
  const auto model = model_of(R"yaml(
gravity: [0, 0, 0]
bodies: {b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {slide: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [1, 0, 0]}}
signals:
  eighths: "8*t - 2"
  halves: "rint(eighths) + 100*rint(0.49999999999999994 + 0*t)"
  large: "rint(4503599627370497 + 0*t) - 4503599627370497"
outputs: [{name: place, joint: slide}]
simulation: {step: 0.0625}
)yaml");
  const GeneratedCode code = generate_code(model, {}, "rounds");
  ASSERT_EQ(code.outputs.size(), 4u);
  Code made(code);
  EXPECT_EQ(difference(model, code, made), 0);
  Simulation s(model, fixed_cost());
  EXPECT_EQ(s.value(s.channel("signal.large")), 0);
  ASSERT_TRUE(s.step().ok());
  EXPECT_EQ(s.value(s.channel("signal.eighths")), -1.5);
  EXPECT_EQ(s.value(s.channel("signal.halves")), -2);
}

/// A loop whose joints rub: some break away at the start, some hold, and in the end all do.
TEST(GeneratedCode, SticksAndSlides) {
  const auto model = model_of(four_bar_text({{"crank", ", velocity: 4"}}) + R"yaml(
frictions:
  a: {joint: crank, torque: 0.2}
  b: {joint: crank_pin, torque: 0.3, sticking: 1e-7}
  c: {joint: rocker, torque: 0.2, static_ratio: 1.2}
simulation: {step: 5 ms}
)yaml");
  const GeneratedCode code = generate_code(model, {}, "rubs");
  Code made(code);
  EXPECT_LE(difference(model, code, made), 1e-8);
}

/// A digital controller: what it sees, remembers and holds.
TEST(GeneratedCode, EvaluatesSignalsAtInstants) {
  std::string text = four_bar_text({{"rocker", ", cut: always, spring: {stiffness: 4, damping: 0.2}"}});
  const auto model = model_of(text + R"yaml(
inputs:
  wanted: {start: 0.2, range: [-1, 1]}
signals:
  angle: {joint: crank, every: 0.02}
  tip: {position: coupler, component: x, every: 0.01}
  servo: {pid: angle, setpoint: wanted, kp: 2, ki: 3, kd: 0.05, filter: 0.04, upper: 4, lower: -4, every: 0.02}
  notch: {transfer_function: servo + 0.1*tip, numerator: [1, 0.2], denominator: [1, -0.3, 0.1], every: 0.02}
  above: {hysteresis: tip, rises_at: 0.31, falls_at: 0.29, every: 0.01}
  slow: {rate_limit: "above > 0.5 ? servo : notch", rising: 20, falling: -30, every: 0.047}
  smooth: {transfer_function: slow, numerator: [1], denominator: [0.01, 1]}
actuators:
  motor: {joint: crank, torque: 0.5*servo + 0.5*smooth}
simulation: {step: 10 ms}
)yaml");
  const GeneratedCode code = generate_code(model, {}, "digital");
  Code made(code);
  EXPECT_LE(difference(model, code, made), 2e-9);  // round-off grows as it moves back and forth
  // The relay has switched both ways.
  std::set<double> seen;
  Simulation s(model, fixed_cost());
  for (int k = 0; k < 100 && s.step().ok(); ++k) seen.insert(s.value(s.channel("signal.above")));
  EXPECT_EQ(seen, (std::set<double>{0, 1}));
}

/// Delays of many steps, of part of one, of instants and in a circle; noise; a relay that switches a motor.
TEST(GeneratedCode, DelaysAndSwitches) {
  const auto model = model_of(R"yaml(
bodies: {crank: {mass: 1, com: [0.5, 0, 0], inertia: [0.1, 0.1, 0.1]}}
joints: {crank: {type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 1, 0], position: 0.3}}
inputs:
  wanted: {start: 0.2, range: [-1, 1]}
signals:
  angle: {joint: crank}
  rate: {joint_velocity: crank}
  late: {delay: angle - 0.3*wanted, time: 0.053}
  soon: {delay: rate + 0.1*wanted, time: 0.7 ms}
  still: {delay: angle, time: 0.04, every: 0.02}
  echo: {delay: "0.5*echo + wanted + 0.1*angle", time: 0.021}
  shake: {noise: normal, deviation: 0.3, mean: 0.1, seed: 9007199254740991, every: 0.01}
  rattle: {noise: uniform, every: 0.013, seed: 7}
  warm: {hysteresis: rate, rises_at: 0.4, falls_at: -0.5, low: 1.5, high: -2}
  after: {delay: warm, time: 0.015}
  map: {table: [angle, wanted], x: [-1, 0, 0.3, 0.5, 1], y: [-0.2, 0, 0.2], values: [[0, 1, 0], [1, 0, 2], [0.5, 0, 1], [3, 1, 0], [0, 2, 1]]}
actuators:
  motor: {joint: crank, torque: "-2*late - 0.2*soon - still + echo + shake + rattle + warm + 0.3*after + map"}
simulation: {step: 2 ms}
)yaml");
  const GeneratedCode code = generate_code(model, {}, "late");
  Code made(code);
  EXPECT_LE(difference(model, code, made, 2), 1e-10);
  std::map<std::string, std::set<double>> seen;
  Simulation s(model, fixed_cost());
  for (int k = 0; k < 1000 && s.step().ok(); ++k)
    for (const char* name : {"warm", "still", "shake", "rattle", "echo"})
      seen[name].insert(s.value(s.channel(std::string("signal.") + name)));
  EXPECT_EQ(seen["warm"], (std::set<double>{-2, 1.5}));
  EXPECT_GT(seen["still"].size(), 90u);
  EXPECT_GT(seen["shake"].size(), 190u);
  EXPECT_GT(seen["rattle"].size(), 140u);
  EXPECT_GT(seen["echo"].size(), 10u);
}

/// Relays that switch each other at one moment: by the motion, by a controller's instants, by an event; the
/// last of them ends the run.
TEST(GeneratedCode, RelaysSwitchEachOther) {
  const auto model = model_of(R"yaml(
bodies: {crank: {mass: 1, com: [0.5, 0, 0], inertia: [0.1, 0.1, 0.1]}}
joints: {crank: {type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 1, 0], position: 0.3}}
inputs: {kick: 0}
signals:
  angle: {joint: crank}
  rate: {joint_velocity: crank}
  seen: {joint_velocity: crank, every: 0.01}
  r1: {hysteresis: rate, rises_at: 0.4, falls_at: -0.5}
  r2: {hysteresis: r1, rises_at: 0.6, falls_at: 0.3}
  r3: {hysteresis: r2, rises_at: 0.6, falls_at: 0.3}
  s1: {hysteresis: seen, rises_at: 0.6, falls_at: -0.7}
  s2: {hysteresis: s1 + 0*angle, rises_at: 0.6, falls_at: 0.3}
  k1: {hysteresis: kick, rises_at: 0.5, falls_at: 0.3}
  k2: {hysteresis: k1, rises_at: 0.5, falls_at: 0.3}
  servo: {pid: angle, setpoint: r2 - 0.3*k2, kp: 2, ki: 3, kd: 0.05, filter: 0.04}
actuators:
  motor: {joint: crank, torque: "r1 - 2*r2 + 0.7*r3 + 0.4*s1 - 0.2*s2 + 0.3*k2 + 0.1*servo"}
events:
  far: {when: angle, crosses: 0.5, direction: rising, set: {kick: 1}}
  last: {when: k2 + t/100, crosses: 1.015, stop: true}
simulation: {step: 2 ms, end: 5}
)yaml");
  const GeneratedCode code = generate_code(model, {}, "relays");
  Code made(code);
  Simulation s(model, fixed_cost());
  int status = 0;
  std::map<std::string, std::set<double>> seen;
  while (status <= 1 && s.time() < 5) {
    ASSERT_TRUE(s.step().ok());
    status = made.step();
    for (std::size_t k = 0; k < code.outputs.size(); ++k) {
      const double value = s.value(channel_of(s, code.outputs[k]));
      ASSERT_NEAR(made.output(static_cast<int>(k)), value, 1e-12) << code.outputs[k].name << " " << s.time();
      seen[code.outputs[k].name].insert(value);
    }
    // All at once.
    EXPECT_EQ(s.value(s.channel("signal.r1")), s.value(s.channel("signal.r3")));
    EXPECT_EQ(s.value(s.channel("signal.s1")), s.value(s.channel("signal.s2")));
    EXPECT_EQ(s.value(s.channel("input.kick")), s.value(s.channel("signal.k2")));
  }
  EXPECT_TRUE(s.stopped());
  EXPECT_EQ(status, 7);
  for (const char* name : {"r3", "s2", "k2"}) EXPECT_EQ(seen[name].size(), 2u) << name;
}

/// Events of time, motion, forces and inputs, which make others happen; the last ends the run.
TEST(GeneratedCode, LetsEventsHappen) {
  const auto model = model_of(R"yaml(
bodies: {slider: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {guide: {type: prismatic, between: [ground, slider], at: [0, 0, 0], axis: [1, 0, 0]}}
springs: {back: {between: [ground, slider], at: [[-1, 0, 0], [0, 0, 0]], elastic: {stiffness: 40, zero: 1}}}
inputs: {push: 1, stage: 0, wind: {start: 0, range: [-1, 1]}, held: 0, laps: {start: 0, range: [0, 3]}}
signals:
  place: {joint: guide}
  smooth: {transfer_function: push, numerator: [1], denominator: [0.02, 1]}
actuators: {motor: {joint: guide, force: "9*smooth + wind"}}
events:
  far: {when: place, crosses: 0.1, direction: rising, set: {push: -1, held: "place*10", stage: "stage + 1"}}
  near: {when: place, crosses: -0.1, direction: falling, set: {push: 1}}
  staged: {when: stage, crosses: 1.5, set: {stage: 0, laps: "laps + 1"}}
  pulled: {when: pull, crosses: 3.9}
  gust: {when: wind, crosses: 0.1, direction: falling, set: {held: -wind}}
  late: {when: t, crosses: 0.5, set: {held: "sqrt(stage - 5)"}}   # no number: it is not set
  last: {when: laps, crosses: 2.5, stop: true}
outputs: [{name: x, joint: guide}, {name: v, joint_velocity: guide}, {name: pull, spring_force: back}]
simulation: {step: 3 ms, end: 20}
)yaml");
  const GeneratedCode code = generate_code(model, {}, "stages");
  Code made(code);
  Simulation s(model, fixed_cost());
  const auto wind = static_cast<int>(
      std::find_if(code.inputs.begin(), code.inputs.end(), [](const auto& v) { return v.name == "wind"; }) -
      code.inputs.begin());
  std::vector<double> saved;
  int status = 0, steps = 0;
  for (; status <= 1 && steps < 6000; ++steps) {
    const double gust = std::sin(1.7 * s.time());
    s.set_input(wind, gust);
    made.set_input(wind, gust);
    ASSERT_TRUE(s.step().ok());
    status = made.step();
    for (std::size_t k = 0; k < code.outputs.size(); ++k)
      ASSERT_NEAR(made.output(static_cast<int>(k)), s.value(channel_of(s, code.outputs[k])), 1e-11)
          << code.outputs[k].name << " " << steps;
    ASSERT_EQ(made.time(), s.time());
    // From what it saved it goes on the same.
    if (steps % 50 == 49) {
      made.save(saved);
      made.init();
      made.restore(saved);
    }
  }
  EXPECT_TRUE(s.stopped());
  EXPECT_EQ(status, 7);
  EXPECT_GT(steps, 300);
  for (const EventRecord& e : s.events()) EXPECT_GT(e.count, 0) << e.name;
  // It may go on.
  EXPECT_LE(made.step(), 1);
  EXPECT_TRUE(s.step().ok());
  EXPECT_EQ(made.time(), s.time());
  EXPECT_NEAR(made.output(0), s.value(s.channel("x")), 1e-11);
}

/// What flies freely: a tumbling body, one that is thrust for a while, and one that holds the other end of
/// its joint and moves its arms, one of which bends.
TEST(GeneratedCode, KeepsMomentum) {
  const auto model = model_of(R"yaml(
gravity: [0.3, 0, -9.81]
materials: {plastic: {young: 2e9, poisson: 0.3, density: 2000}}
sections: {rod: {type: round, diameter: 0.02}}
bodies:
  top: {mass: 2, com: [0.1, 0, 0], inertia: [1, 2, 2.5]}
  rocket: {mass: 3, com: [5, 0, 0], inertia: [1, 3, 3]}
  trunk: {mass: 4, com: [0, 5, 0], inertia: [1, 1.5, 0.7]}
  arm: {mass: 1, com: [0.5, 5, 0], inertia: [0.02, 0.1, 0.1]}
  hand: {mass: 0.6, com: [1.2, 5, 0], inertia: [0.02, 0.03, 0.025]}
  feeler:
    frame: {at: [0, 5.2, 0]}
    flexible:
      material: plastic
      section: rod
      nodes: {in: [0, 5.2, 0], out: [0, 6, 0]}
      bars: {bar: {from: in, to: out, elements: 4}}
      clamped: [in]
      static_modes: [{node: out, along: [1, 0, 0]}, {node: out, along: [0, 0, 1]}]
      dynamic_modes: 2
joints:
  thrown: {type: floating, between: [ground, top], velocity: [1, 2, 3, 0.1, 5, 0.2]}
  flight: {type: floating, between: [ground, rocket], velocity: [0, 1, 0, 0.3, 0.2, 0.1]}
  leap: {type: floating, between: [trunk, ground], velocity: [0.2, 0.1, -1, 0.5, 1, 0.4]}
  shoulder: {type: spherical, between: [trunk, arm], at: [0.2, 5, 0], velocity: [0.3, -2, 1]}
  wrist: {type: revolute, between: [arm, hand], at: [1, 5, 0], axis: [0, 1, 0.2], velocity: -3, spring: {stiffness: 2, damping: 0.05}}
  root: {type: fixed, between: [trunk, feeler], at: [0, 5.2, 0]}
loads:
  thrust: {on: rocket, at: [5, 0, 0.1], force: [8, 0, 0], scale: "t < 0.3 ? sin(10*t)^2 : 0"}
outputs:
  - {for: {b: [top, rocket, hand], c: [x, y, z]}, name: $b.$c, position: $b, component: $c}
  - {for: {b: [top, rocket, trunk], c: [x, y, z]}, name: $b.spin.$c, angular_velocity: $b, component: $c}
  - {name: tip, deflection: feeler.out, along: [1, 0, 0]}
simulation: {step: 2 ms, end: 2}
)yaml");
  const GeneratedCode code = generate_code(model, {}, "flyers");
  Code made(code);
  EXPECT_LE(difference(model, code, made, 2), 1e-10);
}

/// A die that falls on a tetrahedron: faces, edges and corners of triangles; contacts that begin within the
/// iterations of a step.
TEST(GeneratedCode, TouchesTriangles) {
  const auto model = model_of(R"yaml(
bodies: {die: {mass: 0.5, com: [0, 0, 0.6], inertia: [8e-4, 8e-4, 8e-4]}}
joints: {thrown: {type: floating, between: [ground, die], velocity: [1, 0.15, 0, 5, 8, 3]}}
surfaces:
  rock:
    type: mesh
    at: [0.3, 0, 0]
    vertices: [[-0.5, -0.5, 0], [0.6, -0.4, 0], [0, 0.7, 0.1], [0.05, 0, 0.4]]
    triangles: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
contacts:
  corners:
    spheres:
      on: die
      at:
        - [-0.04, -0.04, 0.56]
        - [0.04, -0.04, 0.56]
        - [-0.04, 0.04, 0.56]
        - [0.04, 0.04, 0.56]
        - [-0.04, -0.04, 0.64]
        - [0.04, -0.04, 0.64]
        - [-0.04, 0.04, 0.64]
        - [0.04, 0.04, 0.64]
      radius: 0.01
    surfaces: [rock]
    stiffness: 1e5
    restitution: 0.4
    friction: 0.4
simulation: {step: 2 ms}
)yaml");
  const GeneratedCode code = generate_code(model, {}, "die");
  Code made(code);
  EXPECT_LE(difference(model, code, made, 0.6), 1e-11);
  double deepest = 0;
  Simulation s(model, fixed_cost());
  while (s.time() < 0.6 && s.step().ok())
    deepest = std::max(deepest, s.value(s.channel("contact.corners.depth")));
  EXPECT_GT(deepest, 1e-3);
}

/// A braked wheel that leans and goes askew, over a rise and beyond the road's points.
TEST(GeneratedCode, ShowsWhatTyresDo) {
  const auto model = model_of(R"yaml(
bodies:
  hub: {mass: 300, com: [0, 0, 0.31], inertia: [9, 9, 9]}
  wheel: {mass: 20, com: [0, 0, 0.31], inertia: [0.6, 1, 0.6]}
joints:
  way: {type: prismatic, between: [ground, hub], at: [0, 0, 0.31], axis: [0.98, 0.1, -0.01], velocity: 9}
  turn: {type: revolute, between: [hub, wheel], at: [0, 0, 0.31], axis: [0, 1, 0.1], velocity: 27, spring: {damping: 3}}
roads: {field: {over: distance, points: [[-9, 0], [0.5, -0.004], [1, 0.01]]}}
tyres:
  tyre:
    {on: wheel, at: [0, 0, 0.31], axis: [0, 1, 0.1], road: field, model: brush, stiffness: 2e5, damping: 500, radius: 0.32,
     longitudinal_stiffness: 6e4, cornering_stiffness: 5e4, friction: 0.9, longitudinal_relaxation: 0.3,
     lateral_relaxation: 0.5, half_length: 0.07, load: 4000}
outputs:
  - {for: {c: [vertical, longitudinal, lateral]}, name: force.$c, tyre_force: tyre, component: $c}
  - {for: {c: [overturning, rolling, aligning]}, name: moment.$c, tyre_moment: tyre, component: $c}
  - {name: slip, tyre_slip: tyre}
  - {name: slip_angle, tyre_slip_angle: tyre}
  - {name: camber, tyre_camber: tyre}
  - {name: deflection, tyre_deflection: tyre}
simulation: {step: 1 ms}
)yaml");
  const GeneratedCode code = generate_code(model, {}, "wheel");
  ASSERT_EQ(code.outputs.size(), 10u);
  Code made(code);
  EXPECT_LE(difference(model, code, made, 0.3), 1e-10);
  // Brushes have no moments about the wheel's axis and about forwards.
  for (int k = 0; k < 10; ++k) {
    const std::string& name = code.outputs[static_cast<std::size_t>(k)].name;
    if (name == "moment.overturning" || name == "moment.rolling") continue;
    EXPECT_NE(made.output(k), 0) << name;
  }
}

/// A rod that starts fast and is stiffened by what its own inertia does to it.
TEST(GeneratedCode, StartsWithLoadsOfInertia) {
  const auto model = example("slider-crank/slider-crank.yaml", {{"approach", "geometric_stiffness"}});
  const GeneratedCode code = generate_code(model, {}, "stiffened");
  Code made(code);
  EXPECT_LE(difference(model, code, made, 0.2), 1e-9);
}

/// A position that is followed through a filter, which sees how far it is from there: what it makes is needed
/// first.
constexpr const char* circle = R"yaml(
signals:
  angle: {joint: crank}
  rate: {joint_velocity: crank}
  lag: {transfer_function: "GAIN*sin(angle - 0.3*reached)", numerator: [1], denominator: [0.05, 1]}
  lead: {transfer_function: "angle - lag + 0.2*shown", numerator: [1, 0.5], denominator: [0.02, 0.3, 1]}
  reached: lag + 0.1*lead
  shown: 2*reached - lead^2
actuators:
  motor: {joint: crank, torque: "0.5 - 0.3*shown - 0.2*rate"}
)yaml";

std::string circle_text(double gain) {
  std::string text =
      four_bar_text({{"rocker", ", cut: always, spring: {stiffness: 4, damping: 0.2}"}}) + circle;
  return text.replace(text.find("GAIN"), 4, std::to_string(gain));
}

TEST(GeneratedCode, SettlesSignalsInLoops) {
  const auto model = model_of(circle_text(4));
  const GeneratedCode code = generate_code(model, {}, "circle");
  Code made(code);
  EXPECT_LE(difference(model, code, made), 1e-10);
}

TEST(GeneratedCode, FailsWhereALoopOfSignalsIsTooFast) {
  const auto model = model_of(circle_text(1e6));
  const GeneratedCode code = generate_code(model, {}, "fast_circle");
  Code made(code);
  Simulation s(model, fixed_cost());
  EXPECT_FALSE(s.step().ok());
  EXPECT_GT(made.step(), 1);
}

/// Also past the end of the run, up to which the integrals are tables.
TEST(GeneratedCode, FollowsIntegralsOfFormulas) {
  for (const char* const drive :
       {"speed: \"2 + sin(9*t)/(1.1 + cos(5*t))\"", "speed: \"t < 0.3 ? 20*t : 6*exp(0.3 - t)\""}) {
    const auto model = model_of(four_bar_text({{"crank", std::string(", drive: {") + drive + "}"}}) +
                                "simulation: {end: 0.4}\n");
    const GeneratedCode code = generate_code(model, {}, "integral");
    Code made(code);
    EXPECT_LE(difference(model, code, made), 1e-10) << drive;
  }
}

/// Equations of velocities alone: their value is their rate times the rule's time (System::set_rate_time).
struct Rolls {
  const char *name, *text;
  friend void PrintTo(const Rolls& c, std::ostream* out) { *out << c.name; }
};

class GeneratedCodeOfRates : public testing::TestWithParam<Rolls> {};

TEST_P(GeneratedCodeOfRates, StepsAsTheLibraryDoes) {
  const auto model = model_of(GetParam().text);
  const GeneratedCode code = generate_code(model, {}, GetParam().name);
  ASSERT_EQ(code.outputs.size(), model->spec().outputs.size());
  Code made(code);
  EXPECT_LE(difference(model, code, made, 0.2), 1e-10);
}

constexpr const char* leaning_disc = R"yaml(
bodies: {disc: {mass: 1, com: [0, 0, 0.3], inertia: [0.0225, 0.045, 0.0225]}}
joints: {free: {type: floating, between: [ground, disc], velocity: [0.6, -0.15, 0, 0.5, 2, 1]}}
constraints:
  wheel:
    {type: rolling, between: [ground, disc], at: [[0, 0, 0], [0, 0, 0.3]], axis: [0, 0, 1], axis2: [0, 1, 0],
     radius: 0.3}
outputs:
  - {name: x, position: disc, component: x}
  - {name: y, position: disc, component: y}
  - {name: z, position: disc, component: z}
  - {name: vx, velocity: disc, component: x}
  - {name: vy, velocity: disc, component: y}
simulation: {step: 0.002}
)yaml";

constexpr const char* skate = R"yaml(
bodies: {blade: {mass: 1, com: [0, 0, 0.3], inertia: [0.0225, 0.045, 0.0225]}}
joints: {free: {type: floating, between: [ground, blade], velocity: [0.6, 0, 0, 0.5, 2, 1]}}
constraints: {edge: {type: knife_edge, between: [ground, blade], at: [0, 0, 0.3], axis: [0, 1, 0]}}
outputs:
  - {name: x, position: blade, component: x}
  - {name: y, position: blade, component: y}
  - {name: z, position: blade, component: z}
  - {name: vx, velocity: blade, component: x}
  - {name: vy, velocity: blade, component: y}
simulation: {step: 0.002}
)yaml";

constexpr const char* wheel_on_a_bar = R"yaml(
materials: {plastic: {young: 2e9, poisson: 0.3, density: 1200}}
sections: {rod: {type: round, diameter: 0.02}}
bodies:
  bar:
    frame: {at: [0, 0, 0.3], x: [0, 1, 0], y: [-1, 0, 0]}
    flexible:
      material: plastic
      section: rod
      nodes: {root: [0, 0, 0.3], tip: [0, 0.5, 0.3]}
      bars: {bar: {from: root, to: tip, elements: 4}}
      clamped: [root]
      static_modes: [{node: tip, all: true}]
      dynamic_modes: 2
      stiffness_damping: 1e-3
joints:
  pivot: {type: universal, between: [ground, bar], at: [0, 0, 0.3], axis: [0, 0, 1], axis2: [0, 1, 0]}
constraints:
  wheel:
    {type: rolling, between: [ground, bar], at: [[0, 0.5, 0], [0, 0.5, 0.3]], axis: [0, 0, 1],
     axis2: [0, 1, 0], radius: 0.3}
inputs: {push: 1}
loads: {push: {on: bar, at: [0, 0.5, 0.3], force: [2, 0, -0.5], scale: push}}
outputs:
  - {name: x, position: bar.tip, component: x}
  - {name: y, position: bar.tip, component: y}
  - {name: z, position: bar.tip, component: z}
  - {name: bent, modal_amplitude: bar, component: 6}
simulation: {step: 0.002}
)yaml";

INSTANTIATE_TEST_SUITE_P(Constraints, GeneratedCodeOfRates,
                         testing::Values(Rolls{"leaning_disc", leaning_disc}, Rolls{"skate", skate},
                                         Rolls{"wheel_on_a_bar", wheel_on_a_bar}),
                         [](const testing::TestParamInfo<Rolls>& c) { return std::string(c.param.name); });

TEST(GeneratedCode, CompilesWithClang) {
  if (std::system("command -v clang > /dev/null 2>&1") != 0) GTEST_SKIP() << "there is no clang";
  const GeneratedCode code = generate_code(example("iltis/suspension.yaml"), {}, "suspension");
  Code made(code, "clang");
  EXPECT_EQ(made.step(), 0);
}

std::string refusal(const std::string& text) {
  try {
    generate_code(model_of(text), {}, "model");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(GeneratedCode, SaysWhatItIsNotMadeOf) {
  const std::string event = refusal(four_bar_text({}) + R"yaml(
outputs: [{name: pin, joint_force: crank, component: fx}]
events: {hard: {when: pin, crosses: 1}}
)yaml");
  EXPECT_NE(event.find("has an event that sees a joint_force"), std::string::npos) << event;
  const std::string natural = refusal(four_bar_text({}) + "simulation: {formulation: natural}\n");
  EXPECT_NE(natural.find("formulation: relative"), std::string::npos) << natural;
  spec::Model crank = example("slider-crank/slider-crank.yaml", {{"approach", "elastodynamics"}})->spec();
  try {
    generate_code(Model::compile(crank), {}, "crank");
    ADD_FAILURE() << "code of linear elastodynamics";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("body 'rod' bends by linear elastodynamics"), std::string::npos)
        << error.what();
  }
  // By what was asked for, not by the fixed cost that code has.
  RunOptions global;
  global.formalism = spec::Simulation::Formalism::global_modes;
  try {
    generate_code(model_of(four_bar_text({})), global, "model");
    ADD_FAILURE() << "code of global modes";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("formalism index3 only"), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find("fixed_cost"), std::string::npos) << error.what();
  }
  for (const char* const rule : {"radau", "rk4", "conserve"}) {
    const std::string other = refusal(four_bar_text({}) + "simulation: {integrator: {type: " + rule + "}}\n");
    EXPECT_NE(other.find("integrators generalized_alpha, hht and newmark only"), std::string::npos) << other;
  }
  const std::string late = refusal(four_bar_text({}) + R"yaml(
signals: {seen: {joint: crank, every: 0.015}}
simulation: {step: 10 ms}
)yaml");
  EXPECT_NE(late.find("signal 'seen' is evaluated every 0.015 s: that needs steps of that length or less "
                      "than half of it, not of 0.01 s"),
            std::string::npos)
      << late;
  const std::string circle = refusal(four_bar_text({}) + R"yaml(
signals:
  slow: {transfer_function: "cos(t) - gain", numerator: [1], denominator: [0.1, 1]}
  gain: 0.5*slow
)yaml");
  EXPECT_NE(circle.find("in loops by the time alone; write them as one formula"), std::string::npos)
      << circle;
  EXPECT_THROW(generate_code(example("tutorial/pendulum.yaml"), {}, "no name"), InputError);
  for (const char* taken : {"double", "sin", "expf", "memcpy", "size_t", "NULL", "INFINITY"})
    EXPECT_THROW(generate_code(example("tutorial/pendulum.yaml"), {}, taken), InputError) << taken;
}

TEST(GeneratedCode, NamesAreIdentifiers) {
  EXPECT_EQ(identifier_of("a/double-four-bar.yaml"), "double_four_bar");
  EXPECT_EQ(identifier_of("4bar.yaml"), "m4bar");
}

}  // namespace
}  // namespace mimbre::test::generated_code_test
