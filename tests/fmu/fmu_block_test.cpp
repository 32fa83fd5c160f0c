#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>

#include "fmu/fmu_files.h"
#include "mimbre/fmu_import.h"
#include "mimbre/model.h"
#include "mimbre/model_file.h"
#include "mimbre/simulation.h"

/// Blocks that FMUs compute, against the library's own blocks; their saved states; FMUs that misbehave.
namespace mimbre::test::fmu_blocks {
namespace {

using testing::HasSubstr;

constexpr int versions[] = {2, 3};

/// A mass on a spring that a signal `force` pushes.
std::string mass(const std::string& signals, double step = 0.01) {
  return fmt::format(R"y(
mimbre: 1
gravity: [0, 0, 0]
bodies:
  mass: {{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints:
  guide: {{type: prismatic, between: [ground, mass], at: [0, 0, 0], axis: [1, 0, 0], position: 0.3}}
outputs:
  - {{name: place, joint: guide}}
actuators:
  push: {{joint: guide, force: force}}
simulation: {{step: {}, end: 1}}
signals:
{})y",
                     step, signals);
}

class FmuBlocks : public testing::Test {
 protected:
  std::shared_ptr<const Model> model(const std::string& text) const {
    return Model::compile(parse_model(text, "test.yaml", folder.path()));
  }
  std::string refusal(const std::string& text) const {
    try {
      const Simulation simulation(model(text));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }
  /// Places at all steps.
  std::vector<double> places(const std::string& text, int steps = 100) const {
    Simulation simulation(model(text));
    return places(simulation, steps);
  }
  static std::vector<double> places(Simulation& simulation, int steps) {
    std::vector<double> all;
    for (int k = 0; k < steps; ++k) {
      const StepReport report = simulation.step();
      EXPECT_TRUE(report.ok()) << simulation.explain(report);
      if (!report.ok()) break;
      all.push_back(simulation.value(simulation.channel("place")));
    }
    return all;
  }
  /// Why a run ends.
  std::string failure(const std::string& text) const {
    try {
      Simulation simulation(model(text));
      for (int k = 0; k < 100; ++k)
        if (const StepReport report = simulation.step(); !report.ok()) {
          EXPECT_EQ(report.code, StepReport::Code::block_failed);
          return simulation.explain(report);
        }
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }
  static double difference(const std::vector<double>& a, const std::vector<double>& b) {
    EXPECT_EQ(a.size(), b.size());
    double most = 0;
    for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k)
      most = std::max(most, std::abs(a[k] - b[k]));
    return most;
  }
  FmuFolder folder;
};

TEST_F(FmuBlocks, AnIntegratorIsThatOfOurOwnBlock) {
  for (const int version : versions) {
    folder.unit(version);
    const auto own =
        places(mass("  total: {state_space: place, A: 1, B: 0.02, C: 1, every: 0.02}\n"
                    "  force: -20*place - 10*total\n"));
    const auto fmu =
        places(mass("  total: {fmu: unit.fmu, inputs: {y: place}, outputs: u, every: 0.02}\n"
                    "  force: -20*place - 10*total\n"));
    EXPECT_LT(difference(own, fmu), 1e-12) << version;
    EXPECT_GT(difference(own, places(mass("  force: -20*place\n"))), 1e-3);
  }
}

/// Formulas name the block before them, so that what they mean alone does not matter.
TEST_F(FmuBlocks, OutputsMayBeCalledLikeVariablesOfLaws) {
  folder.unit(3);
  for (const char* name : {"x", "t", "sin"}) {
    const std::string signals = fmt::format(
        "  p: {{fmu: unit.fmu, outputs: {{{0}: u}}, inputs: {{y: place}}}}\n  force: p.{0}\n", name);
    EXPECT_EQ(refusal(mass(signals)), "accepted") << name;
  }
  EXPECT_THAT(refusal(mass("  p: {fmu: unit.fmu, outputs: {a-b: u}}\n  force: 0\n")),
              HasSubstr("signal 'p.a-b': a name in expressions has letters"));
}

TEST_F(FmuBlocks, APiControllerIsThatOfOurOwnBlock) {
  for (const int version : versions) {
    folder.unit(version);
    const auto own = places(mass("  force: {pid: place, setpoint: 0.1*t, kp: 30, ki: 20, every: 0.01}\n"));
    const std::string fmu =
        "  force: {{fmu: unit.fmu, inputs: {{r: 0.1*t, y: place}}, outputs: u, inputs_at: end{}, "
        "parameters: {{kind: 2, kp: 3*10, ki: 20}}}}\n";
    EXPECT_LT(difference(own, places(mass(fmt::format(fmt::runtime(fmu), "")))), 1e-12) << version;
    EXPECT_EQ(difference(places(mass(fmt::format(fmt::runtime(fmu), ""))),
                         places(mass(fmt::format(fmt::runtime(fmu), ", process: true")))),
              0)
        << version;
  }
}

TEST_F(FmuBlocks, InputsOfTheStartComeAStepLater) {
  for (const int version : versions) {
    folder.unit(version);
    const auto own = places(mass("  late: {delay: place, time: 0.05, every: 0.05}\n  force: -20*late\n"));
    const auto fmu = places(mass(
        "  late: {fmu: unit.fmu, inputs: {y: place}, outputs: {u: u}, parameters: {kind: 1}, every: 0.05}\n"
        "  force: -20*late.u\n"));
    EXPECT_LT(difference(own, fmu), 1e-12) << version;
    const auto sampled = places(mass("  now: {value: place, every: 0.05}\n  force: -20*now\n"));
    const auto at_once = places(
        mass("  now: {fmu: unit.fmu, inputs: {y: place}, outputs: u, parameters: {kind: 1}, every: 0.05, "
             "inputs_at: end}\n  force: -20*now\n"));
    EXPECT_LT(difference(sampled, at_once), 1e-12) << version;
  }
}

TEST_F(FmuBlocks, StatesAreSavedWithOurs) {
  for (const int version : versions)
    for (const char* process : {"", ", process: true"}) {
      folder.unit(version);
      const auto compiled =
          model(mass(fmt::format("  total: {{fmu: unit.fmu, inputs: {{y: place}}, outputs: u, every: "
                                 "0.02{}}}\n  force: -20*place - 10*total\n",
                                 process)));
      Simulation simulation(compiled);
      const Simulation::Snapshot start = simulation.save();
      const std::vector<double> whole = places(simulation, 100);
      simulation.restore(start);
      const std::vector<double> first = places(simulation, 45);
      EXPECT_EQ(simulation.not_saved(), "");
      const auto bytes = simulation.save().bytes();
      Simulation other(compiled);
      other.restore(Simulation::Snapshot::from_bytes(bytes));
      const std::vector<double> second = places(other, 55), again = places(simulation, 55);
      EXPECT_EQ(difference(second, again), 0);
      std::vector<double> joined = first;
      joined.insert(joined.end(), second.begin(), second.end());
      EXPECT_EQ(difference(whole, joined), 0);
      // What is cut short is refused, and nothing has changed.
      Simulation::Snapshot cut = other.save();
      cut.memory.conservativeResize(cut.memory.size() - 1);
      EXPECT_THROW(other.restore(cut), InputError);
      EXPECT_TRUE(other.step().ok());
    }
}

TEST_F(FmuBlocks, AStateThatIsNotSavedIsRefusedUpFront) {
  folder.unit(3, "", "canGetAndSetFMUState=\"true\"");
  Simulation simulation(model(mass("  force: {fmu: unit.fmu, inputs: {y: place}, outputs: u}\n")));
  EXPECT_THAT(simulation.not_saved(), HasSubstr("canSerializeFMUState"));
  const Simulation::Snapshot start = simulation.save();
  EXPECT_TRUE(simulation.step().ok());
  const double time = simulation.time();
  try {
    simulation.restore(simulation.save());
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the state of signal 'force' (FMU 'unit.fmu') cannot be saved"));
  }
  EXPECT_EQ(simulation.time(), time);
  // Where it had not begun there is nothing to be saved.
  simulation.restore(start);
  EXPECT_TRUE(simulation.step().ok());
}

TEST_F(FmuBlocks, TheFingerprintHasItsContent) {
  const std::string text = mass("  force: {fmu: unit.fmu, inputs: {y: place}, outputs: u}\n");
  folder.unit(2);
  const std::uint64_t one = Simulation(model(text)).fingerprint();
  EXPECT_EQ(Simulation(model(text)).fingerprint(), one);
  folder.unit(2, "/* another */\n");
  EXPECT_NE(Simulation(model(text)).fingerprint(), one);
}

TEST_F(FmuBlocks, OneInAProcessIsOne) {
  folder.unit(2, "/* only one */\n",
              "canBeInstantiatedOnlyOncePerProcess=\"true\" canGetAndSetFMUstate=\"true\" "
              "canSerializeFMUstate=\"true\"");
  const std::string block = "  force: {{fmu: unit.fmu, inputs: {{y: place}}, outputs: u{}}}\n";
  const auto compiled = model(mass(fmt::format(fmt::runtime(block), "")));
  {
    Simulation first(compiled);
    EXPECT_THAT(refusal(mass(fmt::format(fmt::runtime(block), ""))),
                HasSubstr("can have but one instance in a process"));
    const Simulation::Snapshot start = first.save();
    EXPECT_TRUE(first.step().ok());
    first.restore(start);
    EXPECT_TRUE(first.step().ok());
    EXPECT_EQ(refusal(mass(fmt::format(fmt::runtime(block), ", process: true"))), "accepted");
  }
  EXPECT_EQ(refusal(mass(fmt::format(fmt::runtime(block), ""))), "accepted");
}

TEST_F(FmuBlocks, MistakesInTheModelAreNamed) {
  folder.unit(3);
  const auto refused = [&](const std::string& keys) { return refusal(mass("  force: {" + keys + "}\n")); };
  EXPECT_THAT(refused("fmu: no.fmu, outputs: u"), HasSubstr("no.fmu: there is no such file"));
  EXPECT_THAT(refused("fmu: unit.fmu"), HasSubstr("'outputs' is missing"));
  EXPECT_THAT(refused("fmu: unit.fmu, outputs: v"), HasSubstr("has no variable 'v'"));
  EXPECT_THAT(refused("fmu: unit.fmu, outputs: u, inputs: {yy: t}"),
              HasSubstr("has no variable 'yy' (did you mean 'y'?); its inputs are 'y', 'r'"));
  EXPECT_THAT(refused("fmu: unit.fmu, outputs: u, inputs: {kp: t}"), HasSubstr("is no input"));
  EXPECT_THAT(refused("fmu: unit.fmu, outputs: 'u[1]'"), HasSubstr("has 0 dimensions"));
  EXPECT_THAT(refused("fmu: unit.fmu, outputs: u, parameters: {kind: 1.5}"), HasSubstr("no whole number"));
  EXPECT_THAT(refused("fmu: unit.fmu, outputs: u, parameters: {gain: 1}"),
              HasSubstr("has no variable 'gain'"));
  EXPECT_THAT(refused("fmu: unit.fmu, outputs: u, every: 0.015"), HasSubstr("no whole number of steps"));
  EXPECT_THAT(refused("fmu: unit.fmu, outputs: u, every: 0.001"), HasSubstr("steps are of"));
  EXPECT_THAT(refused("fmu: unit.fmu, outputs: u, timeout: 3"), HasSubstr("process: true"));
  EXPECT_THAT(refused("fmu: unit.fmu, outputs: u, inputs_at: middle"), HasSubstr("start"));
  EXPECT_THAT(refused("fmu: unit.fmu, outputs: u, step: 1"), HasSubstr("step"));
}

struct Misbehaviour {
  int fault;
  const char* text;
};

TEST_F(FmuBlocks, WhatFailsIsNamed) {
  const std::string block = mass("  force: {fmu: unit.fmu, inputs: {y: place}, outputs: u}\n");
  for (const int version : versions)
    for (const auto& [fault, text] : {Misbehaviour{3, "the valve is stuck"},
                                      {4, "its output 1 is not a number"},
                                      {7, "returned no instance"},
                                      {11, "its library is of FMI '1.0'"},
                                      {14, "Discard"},
                                      {15, "Fatal"},
                                      {16, "no oil"}}) {
      folder.unit(version, fmt::format("#define FAULT {}\n", fault));
      const std::string said = failure(block);
      EXPECT_THAT(said, HasSubstr(text)) << version << ": " << fault;
      EXPECT_THAT(said, HasSubstr("'force'")) << version << ": " << fault;
      EXPECT_THAT(said, HasSubstr("unit.fmu")) << version << ": " << fault;
    }
}

TEST_F(FmuBlocks, AProcessTakesCrashesAndHangs) {
  const std::string block =
      mass("  force: {fmu: unit.fmu, inputs: {y: place}, outputs: u, process: true, timeout: 0.5}\n");
  for (const int version : versions)
    for (const auto& [fault, text] : {Misbehaviour{1, "ended by signal 11"},
                                      {2, "did not answer within 0.5 s during its step"},
                                      {3, "the valve is stuck"},
                                      {5, "ended with exit code 3 during its step"},
                                      {6, "ended by signal 11"},
                                      {8, "did not answer within 0.5 s while it was loaded"},
                                      {9, "ended by signal 11"}}) {
      folder.unit(version, fmt::format("#define FAULT {}\n", fault));
      const auto start = std::chrono::steady_clock::now();
      const std::string said = failure(block);
      EXPECT_THAT(said, HasSubstr(text)) << version << ": " << fault;
      EXPECT_THAT(said, HasSubstr("unit.fmu")) << version << ": " << fault;
      EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 20);
    }
}

TEST_F(FmuBlocks, AFailedStepLeavesTheState) {
  folder.unit(2, "#define FAULT 3\n");
  Simulation simulation(model(mass("  force: {fmu: unit.fmu, inputs: {y: place}, outputs: u}\n")));
  EXPECT_TRUE(simulation.step().ok());
  const double time = simulation.time(), place = simulation.value(simulation.channel("place"));
  for (int k = 0; k < 3; ++k) {
    const StepReport report = simulation.step();
    EXPECT_EQ(report.code, StepReport::Code::block_failed);
    EXPECT_THAT(simulation.explain(report), HasSubstr("the valve is stuck"));
  }
  EXPECT_EQ(simulation.time(), time);
  EXPECT_EQ(simulation.value(simulation.channel("place")), place);
}

TEST_F(FmuBlocks, LiesAboutStatesAreRefused) {
  for (const int version : versions)
    for (const auto& [fault, text] : {Misbehaviour{12, "lacks that of signal"}, {13, "does not take back"}}) {
      folder.unit(version, fmt::format("#define FAULT {}\n", fault));
      const auto compiled = model(mass("  force: {fmu: unit.fmu, inputs: {y: place}, outputs: u}\n"));
      Simulation simulation(compiled), other(compiled);
      EXPECT_TRUE(simulation.step().ok());
      const Simulation::Snapshot saved = simulation.save();
      try {
        other.restore(saved);
        ADD_FAILURE() << fault;
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr(text)) << version;
      }
    }
}

TEST_F(FmuBlocks, WarningsAreKept) {
  folder.unit(3, "#define FAULT 10\n");
  Simulation simulation(model(mass("  force: {fmu: unit.fmu, inputs: {y: place}, outputs: u}\n")));
  places(simulation, 5);
  EXPECT_THAT(simulation.warnings(),
              testing::Contains(
                  testing::AllOf(HasSubstr("FMU 'unit.fmu' warned 4 times"), HasSubstr("the oil is warm"))));
}

TEST_F(FmuBlocks, TheFloatingPointUnitIsKept) {
  folder.unit(2);
  const std::string text = mass("  free: {fmu: unit.fmu, outputs: u}\n  force: -20*place\n");
  const auto sound = places(text);
  folder.unit(2, "#define FAULT 17\n");
  EXPECT_EQ(difference(sound, places(text)), 0);
}

TEST_F(FmuBlocks, LibrariesThatLackFunctionsOrAreOfOtherPlatformsAreRefused) {
  const std::string block = mass("  force: {fmu: unit.fmu, inputs: {y: place}, outputs: u}\n");
  folder.unit(2, "#define WITHOUT_GET\n");
  EXPECT_THAT(refusal(block), HasSubstr("its library lacks the function fmi2GetReal"));
  folder.unit(3, "#define WITHOUT_GET\n");
  EXPECT_THAT(refusal(block), HasSubstr("its library lacks the function fmi3GetFloat64"));
  folder.unit(3, "#error is wrong\n");
  EXPECT_THAT(refusal(block), HasSubstr("does not compile its sources"));
  const auto with = [&](const std::string& name, const std::string& bytes) {
    folder.write("unit.fmu", zip_of({{"modelDescription.xml", unit_description(3)}, {name, bytes}}));
    return refusal(block);
  };
  EXPECT_THAT(with("binaries/x86_64-windows/unit.dll", "MZ"), HasSubstr("only for x86_64-windows"));
  EXPECT_THAT(with("documentation/index.html", ""), HasSubstr("neither a library nor sources"));
  EXPECT_THAT(with("binaries/x86_64-linux/unit.so", "no library"), HasSubstr("cannot be loaded"));
}

TEST_F(FmuBlocks, ManyInstancesComeAndGo) {
  folder.unit(3);
  const auto compiled = model(mass("  force: {fmu: unit.fmu, inputs: {y: place}, outputs: u}\n"));
  std::vector<std::unique_ptr<Simulation>> some;
  for (int k = 0; k < 200; ++k) {
    some.push_back(std::make_unique<Simulation>(compiled));
    EXPECT_TRUE(some.back()->step().ok());
    if (some.size() > 8) some.erase(some.begin());
  }
}

}  // namespace
}  // namespace mimbre::test::fmu_blocks
