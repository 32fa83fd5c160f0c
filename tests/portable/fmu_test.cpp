#include "mimbre/fmu.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <memory>
#include <pugixml.hpp>
#include <set>
#include <thread>

#include "mimbre/simulation.h"
#include "support/fmu_importer.h"
#include "support/hostile_importer.h"
#include "support/models.h"

/// FMUs: what their description says, their steps against the library's, and importers that call wrongly.
namespace mimbre::test::fmu_test {
namespace {

using testing::HasSubstr;
using Role = FmuVariable::Role;

/// Inputs of both kinds of hold, a parameter, a controller; an output that shows an input at once.
std::shared_ptr<const Model> driven() {
  return model_of(four_bar_text({{"rocker", ", cut: always, spring: {stiffness: 4, damping: 0.2}"}}) + R"yaml(
inputs:
  wanted: {start: 0.2, range: [-1, 1]}
  wind: {start: 1, hold: linear}
signals:
  angle: {joint: crank}
  rate: {joint_velocity: crank}
  gust: {transfer_function: wind, numerator: [1], denominator: [2e-4, 0.02, 1]}
  servo: {pid: angle, setpoint: wanted, kp: 2, ki: 3, kd: 0.05, filter: 0.04, upper: 4, lower: -4}
  shown: "2*wanted"
actuators:
  motor: {joint: crank, torque: "servo + 0.1*gust - 0.2*rate"}
)yaml");
}

FmuCode fmu_of(const std::shared_ptr<const Model>& model, int version, const std::string& name) {
  FmuOptions options;
  options.version = version;
  options.name = name;
  return generate_fmu(model, {}, options);
}

class Fmu : public testing::TestWithParam<int> {
 protected:
  /// Compiled once in a process.
  const FmuLibrary& library(const std::shared_ptr<const Model>& model, const std::string& name) const {
    static std::map<std::pair<std::string, int>, std::unique_ptr<FmuLibrary>> made;
    std::unique_ptr<FmuLibrary>& one = made[{name, GetParam()}];
    if (one) return *one;
    std::string label = testing::UnitTest::GetInstance()->current_test_info()->name();
    std::replace(label.begin(), label.end(), '/', '_');
    one = std::make_unique<FmuLibrary>(fmu_of(model, GetParam(), name), label);
    return *one;
  }
};

/// What validators look for.
TEST_P(Fmu, IsDescribedAsTheStandardWantsIt) {
  const auto model = driven();
  const FmuCode fmu = fmu_of(model, GetParam(), "driven");
  const bool two = GetParam() == 2;
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(fmu_description(fmu, *model, true).c_str()));
  const pugi::xml_node root = document.child("fmiModelDescription");
  EXPECT_STREQ(root.attribute("fmiVersion").value(), two ? "2.0" : "3.0");
  EXPECT_EQ(root.attribute(two ? "guid" : "instantiationToken").value(), fmu.token);

  std::set<std::string> units, names, references, inputs, outputs;
  for (const pugi::xml_node unit : root.child("UnitDefinitions"))
    EXPECT_TRUE(units.insert(unit.attribute("name").value()).second);
  int independent = 0, index = 0;
  for (const pugi::xml_node node : root.child("ModelVariables")) {
    ++index;
    const pugi::xml_node type = two ? node.first_child() : node;
    const std::string name = node.attribute("name").value(), causality = node.attribute("causality").value(),
                      variability = node.attribute("variability").value(),
                      initial = node.attribute("initial").value();
    SCOPED_TRACE(name);
    EXPECT_TRUE(names.insert(name).second);
    EXPECT_TRUE(references.insert(node.attribute("valueReference").value()).second);
    const std::string known = two ? std::to_string(index) : node.attribute("valueReference").value();
    const bool starts = !type.attribute("start").empty(), real = !type.attribute("unit").empty();
    EXPECT_TRUE(!real || units.contains(type.attribute("unit").value()));
    EXPECT_TRUE(real || variability != "continuous");
    if (causality == "independent") {
      ++independent;
      EXPECT_TRUE(initial.empty() && !starts);
    } else if (causality == "input") {
      EXPECT_TRUE(starts && initial.empty() && variability == "continuous");
      inputs.insert(known);
    } else if (causality == "parameter") {
      EXPECT_TRUE(starts && initial == "exact" && variability == "tunable");
    } else {
      EXPECT_EQ(causality, "output");
      EXPECT_TRUE(!starts && initial == "calculated");
      outputs.insert(known);
    }
  }
  EXPECT_EQ(independent, 1);
  EXPECT_EQ(inputs.size(), 2u);

  const pugi::xml_node structure = root.child("ModelStructure");
  std::set<std::string> listed, initial;
  const auto look = [&](const pugi::xml_node list, const char* element, std::set<std::string>& into) {
    for (const pugi::xml_node unknown : list.children(element)) {
      EXPECT_TRUE(into.insert(unknown.attribute(two ? "index" : "valueReference").value()).second);
      std::istringstream words(unknown.attribute("dependencies").value());
      for (std::string word; words >> word;) EXPECT_TRUE(inputs.contains(word)) << word;
    }
  };
  look(two ? structure.child("Outputs") : structure, two ? "Unknown" : "Output", listed);
  look(two ? structure.child("InitialUnknowns") : structure, two ? "Unknown" : "InitialUnknown", initial);
  EXPECT_EQ(listed, outputs);
  EXPECT_EQ(initial, outputs);
}

TEST_P(Fmu, KnowsWhichInputsOutputsShowAtOnce) {
  const FmuCode fmu = fmu_of(driven(), GetParam(), "driven");
  const auto of = [&](const std::string& name) { return fmu.variables[reference(fmu, name)].dependencies; };
  const unsigned wanted = reference(fmu, "wanted"), wind = reference(fmu, "wind");
  EXPECT_EQ(of("shown"), std::vector<unsigned>{wanted});
  EXPECT_EQ(of("gust"), std::vector<unsigned>{});  // without feedthrough
  EXPECT_EQ(of("servo"), std::vector<unsigned>{wanted});
  EXPECT_EQ(of("angle"), std::vector<unsigned>{});
  EXPECT_NE(wanted, wind);
}

TEST_P(Fmu, HasUnitsOfSi) {
  const auto model = model_of(R"yaml(
bodies: {link: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0.5, 0, 0]}}
joints: {hinge: {type: revolute, between: [ground, link], at: [0, 0, 0], axis: [0, 1, 0]}}
inputs: {moment: {start: 1, unit: N m}, share: {start: 0, unit: "%"}, odd: {start: 0, unit: furlong}}
actuators: {motor: {joint: hinge, torque: moment}}
)yaml");
  const FmuCode fmu = fmu_of(model, GetParam(), "units");
  pugi::xml_document document;
  document.load_string(fmu_description(fmu, *model, true).c_str());
  const pugi::xml_node units = document.child("fmiModelDescription").child("UnitDefinitions");
  const auto base = [&](const char* name) {
    return units.find_child_by_attribute("name", name).child("BaseUnit");
  };
  EXPECT_EQ(base("N m").attribute("kg").as_int(), 1);
  EXPECT_EQ(base("N m").attribute("m").as_int(), 2);
  EXPECT_EQ(base("N m").attribute("s").as_int(), -2);
  EXPECT_EQ(base("%").attribute("factor").as_double(), 0.01);
  EXPECT_EQ(base("rad").attribute("rad").as_int(), 1);
  EXPECT_NEAR(units.find_child_by_attribute("name", "rad")
                  .find_child_by_attribute("name", "deg")
                  .attribute("factor")
                  .as_double(),
              180 / M_PI, 1e-13);
  EXPECT_TRUE(units.find_child_by_attribute("name", "furlong"));
  EXPECT_FALSE(base("furlong"));
}

/// Largest difference of the outputs over a second, by their size or 1; inputs move.
double difference(const std::shared_ptr<const Model>& model, const FmuLibrary& library) {
  RunOptions options;
  options.fixed_cost = true;
  options.energies = options.validity = options.warnings = false;
  Simulation s(model, options);
  const GeneratedCode& code = library.fmu().code;
  FmuInstance f(library);
  f.start();
  double most = 0;
  const long steps = std::lround(1 / s.step_size());
  for (long k = 0; k <= steps; ++k) {
    const std::vector<double> found = f.outputs();
    for (std::size_t o = 0; o < found.size(); ++o) {
      const bool own = std::any_of(s.channels().begin(), s.channels().end(),
                                   [&](const ChannelInfo& c) { return c.name == code.outputs[o].name; });
      const double expected =
          s.value(s.channel(own ? code.outputs[o].name : "signal." + code.outputs[o].name));
      const double off = std::abs(found[o] - expected) / std::max(1.0, std::abs(expected));
      most = off <= most ? most : off;
    }
    EXPECT_EQ(f.get(0), s.time());
    for (std::size_t i = 0; i < code.inputs.size(); ++i) {
      const double value = code.inputs[i].start + 0.2 * std::sin(3 * s.time() + static_cast<double>(i));
      s.set_input(static_cast<int>(i), value);
      EXPECT_EQ(f.set(1 + static_cast<unsigned>(i), value), fmi_ok);
      EXPECT_EQ(f.get(1 + static_cast<unsigned>(i)), value);
    }
    const double before = s.time();
    EXPECT_TRUE(s.step().ok());
    EXPECT_EQ(f.step(before, s.time() - before), fmi_ok) << f.messages();
  }
  EXPECT_EQ(f.count(reference(library.fmu(), "solver.steps")), steps + 1);
  return most;
}

TEST_P(Fmu, StepsAsTheLibraryDoes) {
  for (const auto& [name, path] : {std::pair("pendulum", "tutorial/pendulum.yaml"),
                                   {"double_four_bar", "double-four-bar/mechanism.yaml"},
                                   {"suspension", "iltis/suspension.yaml"}}) {
    const auto model = example(path);
    EXPECT_LE(difference(model, library(model, name)), 1e-10) << name;
  }
  EXPECT_LE(difference(driven(), library(driven(), "driven")), 1e-10);
}

/// Twelve steps at once are twelve steps, to the bit; between two steps outputs are on a line.
TEST_P(Fmu, TakesCommunicationStepsOfAnyLength) {
  const FmuLibrary& of = library(driven(), "driven");
  const double h = of.fmu().code.step;
  FmuInstance small(of), large(of), odd(of);
  for (FmuInstance* f : {&small, &large, &odd}) f->start();
  std::vector<std::vector<double>> at{small.outputs()};
  for (int k = 0; k < 12; ++k) {
    EXPECT_EQ(small.step(k * h, h), fmi_ok);
    at.push_back(small.outputs());
  }
  EXPECT_EQ(large.step(0, 12 * h), fmi_ok);
  EXPECT_EQ(large.outputs(), at[12]);
  double now = 0;
  for (const double length : {0.25, 0.5, 0.25, 0.125, 2.125, 0.75, 1.5, 3.3, 2.2}) {
    EXPECT_EQ(odd.step(now * h, length * h), fmi_ok) << odd.messages();
    now += length;
    const std::size_t before = static_cast<std::size_t>(now + 1e-9);
    const double part = now - static_cast<double>(before);
    const std::vector<double> found = odd.outputs();
    for (std::size_t o = 0; o < found.size(); ++o) {
      const double expected =
          part < 1e-9 ? at[before][o] : at[before][o] + part * (at[before + 1][o] - at[before][o]);
      EXPECT_NEAR(found[o], expected, 1e-9 * std::max(1.0, std::abs(expected))) << now << " " << o;
    }
    EXPECT_NEAR(odd.get(0), now * h, 1e-12);
  }
  // At 11 steps it rests at a step again; the rest of the way has the same bits.
  EXPECT_EQ(odd.step(odd.get(0), 12 * h - odd.get(0)), fmi_ok);
  EXPECT_EQ(odd.outputs(), at[12]);
}

/// Between its steps a model is off by what its steps are off, and by a straight line: h²/8 times the second
/// derivative.
TEST_P(Fmu, StatesTheErrorBetweenItsSteps) {
  const auto model = example("tutorial/pendulum.yaml");
  const FmuLibrary& of = library(model, "pendulum");
  const double h = of.fmu().code.step;
  RunOptions fine;
  fine.step = h / 20;
  Simulation exact(model, fine);
  const auto channel = exact.channel(of.fmu().code.outputs[0].name);
  FmuInstance f(of), whole(of);
  f.start();
  whole.start();
  double off = 0, between = 0, bend = 0;
  std::vector<double> at{exact.value(channel)};
  for (int k = 0; k < 100; ++k) {
    EXPECT_EQ(f.step(k == 0 ? 0 : (k - 0.5) * h, k == 0 ? h / 2 : h), fmi_ok);
    EXPECT_EQ(whole.step(k * h, h), fmi_ok);
    for (int j = 0; j < 10; ++j) exact.step();
    between = std::max(between, std::abs(f.outputs()[0] - exact.value(channel)));
    for (int j = 0; j < 10; ++j) exact.step();
    at.push_back(exact.value(channel));
    off = std::max(off, std::abs(whole.outputs()[0] - at.back()));
    if (k > 0) bend = std::max(bend, std::abs(at.end()[-1] - 2 * at.end()[-2] + at.end()[-3]) / (h * h));
  }
  EXPECT_LE(between, off + 1.01 * h * h / 8 * bend);
  EXPECT_GT(between, off);
}

TEST_P(Fmu, RefusesWrongCalls) {
  const FmuLibrary& of = library(driven(), "driven");
  const double nan = std::nan(""), h = of.fmu().code.step;
  const unsigned wanted = reference(of.fmu(), "wanted"), shown = reference(of.fmu(), "shown"),
                 steps = reference(of.fmu(), "solver.steps");
  {
    FmuInstance stranger(of, {}, "{another}");
    EXPECT_EQ(stranger.handle(), nullptr);
    EXPECT_THAT(stranger.messages(), HasSubstr("token"));
    FmuInstance nameless(of, {}, nullptr, " ");
    EXPECT_EQ(nameless.handle(), nullptr);
    EXPECT_EQ(nameless.step(0, h), fmi_error);
    EXPECT_EQ(nameless.simple("Terminate"), fmi_error);
  }
  FmuInstance f(of);
  EXPECT_EQ(f.step(0, h), fmi_error);
  EXPECT_THAT(f.messages(), HasSubstr("cannot be called in this mode"));
  EXPECT_EQ(f.exit(), fmi_error);
  EXPECT_EQ(f.simple("Terminate"), fmi_error);
  EXPECT_EQ(f.enter(nan), fmi_error);
  EXPECT_EQ(f.enter(0, true, -1), fmi_error);
  EXPECT_EQ(f.enter(0, true, 10), fmi_ok);
  EXPECT_EQ(f.enter(0, true, 10), fmi_error);
  EXPECT_EQ(f.step(0, h), fmi_error);
  EXPECT_EQ(f.exit(), fmi_ok);

  const std::vector<double> before = f.outputs();
  for (const auto& [from, length] : {std::pair(0.0, 0.0),
                                     {0.0, -h},
                                     {0.0, nan},
                                     {nan, h},
                                     {h, h},
                                     {-h, h},
                                     {0.0, HUGE_VAL},
                                     {0.0, 1e300},
                                     {0.0, 10 + h}})
    EXPECT_EQ(f.step(from, length), fmi_error) << from << " " << length;
  EXPECT_EQ(f.set(wanted, nan), fmi_error);
  EXPECT_EQ(f.set(shown, 1), fmi_error);
  EXPECT_EQ(f.set(0, 1), fmi_error);
  EXPECT_EQ(f.set(4000000000u, 1), fmi_error);
  double value = 0;
  EXPECT_EQ(f.get({steps}, &value), fmi_error);
  EXPECT_EQ(f.get({4000000000u}, &value), fmi_error);
  EXPECT_EQ(f.get({0}, nullptr), fmi_error);
  EXPECT_EQ(f.outputs(), before);
  EXPECT_EQ(f.set(wanted, 7), fmi_warning);  // out of its range
  EXPECT_EQ(f.get(wanted), 1);
  EXPECT_EQ(f.step(0, h), fmi_ok);
  EXPECT_EQ(f.simple("Terminate"), fmi_ok);
  EXPECT_EQ(f.step(h, h), fmi_error);
  EXPECT_EQ(f.simple("Reset"), fmi_ok);
  f.start();
  EXPECT_EQ(f.outputs(), before);
}

TEST_P(Fmu, GoesOnFromSavedStates) {
  const FmuLibrary& of = library(driven(), "driven");
  const double h = of.fmu().code.step;
  FmuInstance f(of), other(of);
  f.start();
  other.start();
  for (int k = 0; k < 5; ++k) EXPECT_EQ(f.step(k * h, h), fmi_ok);
  EXPECT_EQ(f.step(5 * h, 0.4 * h), fmi_ok);
  void* state = nullptr;
  ASSERT_EQ(f.get_state(&state), fmi_ok);
  std::vector<char> bytes(f.state_size(state));
  ASSERT_EQ(f.write_state(state, bytes.data(), bytes.size()), fmi_ok);
  const auto on = [&](FmuInstance& g) {
    for (int k = 0; k < 5; ++k) EXPECT_EQ(g.step((5.4 + k) * h, h), fmi_ok) << g.messages();
    return g.outputs();
  };
  const std::vector<double> first = on(f);
  EXPECT_EQ(f.set_state(state), fmi_ok);
  EXPECT_EQ(on(f), first);
  void* read = nullptr;
  EXPECT_EQ(other.set_state(state), fmi_error);  // another instance's
  ASSERT_EQ(other.read_state(bytes.data(), bytes.size(), &read), fmi_ok);
  EXPECT_EQ(other.set_state(read), fmi_ok);
  EXPECT_EQ(on(other), first);

  // Sizes that lie, bytes that are damaged, handles that are none.
  void* none = nullptr;
  EXPECT_EQ(f.write_state(state, bytes.data(), bytes.size() - 1), fmi_error);
  EXPECT_EQ(f.read_state(bytes.data(), bytes.size() - 1, &none), fmi_error);
  EXPECT_EQ(f.read_state(bytes.data(), 0, &none), fmi_error);
  for (const std::size_t place : {std::size_t{3}, bytes.size() / 2, bytes.size() - 1}) {
    bytes[place] = static_cast<char>(bytes[place] ^ 1);
    EXPECT_EQ(f.read_state(bytes.data(), bytes.size(), &none), fmi_error);
    bytes[place] = static_cast<char>(bytes[place] ^ 1);
  }
  EXPECT_EQ(none, nullptr);
  EXPECT_EQ(f.set_state(&none), fmi_error);
  EXPECT_EQ(f.free_state(&state), fmi_ok);
  EXPECT_EQ(state, nullptr);
  EXPECT_EQ(f.free_state(&state), fmi_ok);
}

std::atomic<long> pieces{0};
void* counted_allocate(std::size_t count, std::size_t size) {
  ++pieces;
  return std::calloc(count, size);
}
void counted_release(void* memory) {
  if (memory) --pieces;
  std::free(memory);
}

TEST_P(Fmu, ReturnsItsMemory) {
  const FmuLibrary& of = library(driven(), "driven");
  FmuCallbacks counted;
  counted.allocate = counted_allocate;
  counted.release = counted_release;
  for (int k = 0; k < 1000; ++k) {
    FmuInstance f(of, counted);
    f.start();
    void* state = nullptr;
    EXPECT_EQ(f.get_state(&state), fmi_ok);  // goes with the instance
    EXPECT_EQ(f.step(0, of.fmu().code.step), fmi_ok);
  }
  EXPECT_EQ(pieces, 0);
}

TEST_P(Fmu, EightThreadsHaveTheSameBits) {
  const FmuLibrary& of = library(driven(), "driven");
  std::vector<std::vector<double>> found(8);
  std::vector<std::thread> threads;
  for (std::vector<double>& one : found)
    threads.emplace_back([&] {
      FmuInstance f(of);
      f.start();
      for (int k = 0; k < 200; ++k) f.step(k * of.fmu().code.step, of.fmu().code.step);
      one = f.outputs();
    });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<double>& one : found) EXPECT_EQ(one, found[0]);
}

/// A torque that is no number.
TEST_P(Fmu, SaysWhereAStepCannotBeMade) {
  const auto model = model_of(R"yaml(
bodies: {link: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0.5, 0, 0]}}
joints: {hinge: {type: revolute, between: [ground, link], at: [0, 0, 0], axis: [0, 1, 0]}}
inputs: {moment: {start: 0}}
actuators: {motor: {joint: hinge, torque: "moment^3"}}
)yaml");
  const FmuLibrary& of = library(model, "failing");
  const double h = of.fmu().code.step;
  FmuInstance f(of);
  f.start();
  EXPECT_EQ(f.step(0, h), fmi_ok);
  EXPECT_EQ(f.set(1, 1e150), fmi_ok);  // its cube is no number
  EXPECT_EQ(f.step(h, 3 * h), fmi_discard);
  EXPECT_NEAR(f.last(), h, 1e-15);
  EXPECT_FALSE(f.messages().empty());
  EXPECT_EQ(f.step(h, h), fmi_error);
  EXPECT_EQ(f.simple("Terminate"), fmi_ok);
}

/// Random calls with wrong arguments, under the sanitizers.
TEST_P(Fmu, StandsHostileImporters) {
  const FmuCode fmu = fmu_of(driven(), GetParam(), "hostile");
  const std::string printed =
      printed_by_hostile(fmu, "hostile_importer", "-DINSTANCE_STEP=" + std::to_string(fmu.code.step));
  if (printed.empty()) GTEST_SKIP() << "the compiler has no sanitizers";
  // Without a status of a pending step, and in FMI 3 without event mode.
  expect_good_calls(printed, 15, GetParam() == 2 ? std::set<int>{15} : std::set<int>{14, 15});
}

/// Likewise of a model with events, by importers half of which use event mode.
TEST(FmuEvents, StandHostileImporters) {
  const FmuCode fmu = fmu_of(model_of(R"yaml(
bodies: {slider: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {guide: {type: prismatic, between: [ground, slider], at: [0, 0, 0], axis: [1, 0, 0]}}
inputs: {push: 1, laps: {start: 0, range: [0, 9]}, shake: 0, sway: 0}
signals: {place: {joint: guide}, late: {delay: place, time: 0.011}}
actuators: {motor: {joint: guide, force: "9*push + shake + late"}}
events:
  far: {when: place, crosses: 0.001, direction: rising, set: {push: -1, laps: "laps + 1"}}
  near: {when: place, crosses: -0.001, direction: falling, set: {push: 1}}
  last: {when: laps, crosses: 3.5, stop: true}
outputs: [{name: x, joint: guide}, {name: v, joint_velocity: guide}]
simulation: {step: 3 ms, end: 20}
)yaml"),
                             3, "hostile_events");
  const std::string printed = printed_by_hostile(
      fmu, "hostile_importer", "-DINSTANCE_STEP=" + std::to_string(fmu.code.step) + " -DINSTANCE_EVENTS=2");
  if (printed.empty()) GTEST_SKIP() << "the compiler has no sanitizers";
  expect_good_calls(printed, 15, {});
}

INSTANTIATE_TEST_SUITE_P(Versions, Fmu, testing::Values(2, 3),
                         [](const testing::TestParamInfo<int>& version) {
                           return "Fmi" + std::to_string(version.param);
                         });

TEST(FmuArchive, HoldsWhatTheStandardWants) {
  const std::string path = fmu_folder() + "pendulum.fmu";
  FmuOptions options;
  options.version = 3;
  options.name = "pendulum";
  const WrittenFmu written = write_fmu(example("tutorial/pendulum.yaml"), {}, options, path);
  EXPECT_EQ(written.without_binary, "");
  EXPECT_THAT(
      written.files,
      testing::IsSupersetOf(
          {"modelDescription.xml", "sources/pendulum.c", "sources/fmi3.c", "sources/buildDescription.xml",
           "documentation/index.html", "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml",
           "extra/org.fmi-standard.fmi-ls-ref/reference.exp",
           "extra/org.fmi-standard.fmi-ls-ref/reference.csv", "terminalsAndIcons/terminalsAndIcons.xml",
           "terminalsAndIcons/icon.png", "terminalsAndIcons/terminal.png"}));
  const std::set<std::string> unique(written.files.begin(), written.files.end());
  EXPECT_EQ(unique.size(), written.files.size());
  for (const std::string& file : written.files) {
    EXPECT_EQ(file.find('\\'), std::string::npos);
    EXPECT_EQ(file.find(".."), std::string::npos);
    EXPECT_NE(file[0], '/');
  }
  // The same model, the same bytes.
  const auto bytes = [&] {
    std::stringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
  };
  const std::string first = bytes();
  EXPECT_EQ(first.substr(0, 2), "PK");
  write_fmu(example("tutorial/pendulum.yaml"), {}, options, path);
  EXPECT_EQ(bytes(), first);

  options.binary_only = true;
  const WrittenFmu binary = write_fmu(example("tutorial/pendulum.yaml"), {}, options, path);
  for (const std::string& file : binary.files) EXPECT_FALSE(file.starts_with("sources/"));
  EXPECT_THROW(write_fmu(example("tutorial/pendulum.yaml"), {}, options, "/no/such/folder/a.fmu"),
               InputError);
}

TEST(FmuArchive, HasSourcesAloneWhereThereIsNoCompiler) {
  setenv("CC", "no-such-compiler", 1);
  FmuOptions options;
  options.name = "pendulum";
  const std::string path = fmu_folder() + "sources.fmu";
  const WrittenFmu written = write_fmu(example("tutorial/pendulum.yaml"), {}, options, path);
  EXPECT_THAT(written.without_binary, HasSubstr("no-such-compiler"));
  options.binary_only = true;
  EXPECT_THROW(write_fmu(example("tutorial/pendulum.yaml"), {}, options, path), InputError);
  unsetenv("CC");
  options.version = 1;
  EXPECT_THROW(generate_fmu(example("tutorial/pendulum.yaml"), {}, options), InputError);
}

}  // namespace
}  // namespace mimbre::test::fmu_test
