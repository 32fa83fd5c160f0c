#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "support/fmu_importer.h"
#include "support/models.h"

/// Directional derivatives of FMUs for co-simulation: outputs by inputs, parameters and the time, the motion
/// being that of a communication point.
namespace mimbre::test::fmu_directions_test {
namespace {

using Role = FmuVariable::Role;

FmuCode fmu_of(const std::shared_ptr<const Model>& model, int version, const std::string& name) {
  FmuOptions options;
  options.version = version;
  options.name = name;
  return generate_fmu(model, {}, options);
}

/// Outputs that show inputs at once: by expressions with the motion, by controllers, by forces of elements.
/// One input is reached in a straight line.
std::shared_ptr<const Model> shown_inputs() {
  return model_of(four_bar_text({{"rocker", ", cut: always, spring: {stiffness: 4, damping: 0.2}"}}) + R"yaml(
inputs:
  wanted: {start: 0.2, range: [-1, 1]}
  gain: {start: 1.5}
  wind: {start: 1, hold: linear}
parameters: {k: {value: 30, tunable: true}}
springs:
  rope: {between: [ground, coupler], at: [[0, 0, 2], null], force: "k*(l - 0.5)*(1 + gain^2) + 2*v"}
signals:
  angle: {joint: crank}
  rate: {joint_velocity: crank}
  mixed: "sin(angle + wanted)*gain^2 + rate*wanted*k"
  slow: {rate_limit: wanted + 0.1*angle, rising: 3}
  gentle: {rate_limit: gain, rising: 0.5}
  both: "slow^2 + 2*gain + gentle*angle"
  servo: {pid: angle, setpoint: wanted*gain, kp: 2, ki: 3, kd: 0.05, filter: 0.04, upper: 40, lower: -40}
  gust: {transfer_function: wanted + wind, numerator: [1, 2], denominator: [0.02, 1]}
  in_time: "exp(-t)*gain + wanted^2*t^2"
  airy: "wind*gain"
  map: {table: [angle, wanted*gain], x: [-1, 0, 1], y: [-9, 0, 9], values: [[0, 1, 0], [1, 0, 2], [0.5, 0, 1]]}
  late: {delay: angle + 0.1*wanted, time: 0.011}
  soon: {delay: gain + 0.2*rate, time: 0.7 ms}
  trailing: "late*gain + sin(soon)"
actuators:
  motor: {joint: crank, torque: "servo + 0.1*gust - 0.2*rate"}
outputs:
  - {name: rope, spring_force: rope}
  - {name: height, position: coupler, component: z}
simulation: {step: 0.002, end: 1}
)yaml");
}

/// Only functions of time and the motion: no controllers.
std::shared_ptr<const Model> plain() {
  return model_of(R"yaml(
bodies: {link: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0.5, 0, 0]}}
joints: {hinge: {type: revolute, between: [ground, link], at: [0, 0, 0], axis: [0, 1, 0]}}
inputs: {moment: {start: 0.3}}
signals:
  angle: {joint: hinge}
  wave: "sin(5*t)*moment"
  product: "angle*moment^2 + wave"
actuators: {motor: {joint: hinge, torque: moment + wave}}
simulation: {step: 0.01, end: 1}
)yaml");
}

class FmuDirections : public testing::TestWithParam<int> {
 protected:
  const FmuLibrary& library(const std::shared_ptr<const Model>& model, const std::string& name) const {
    static std::map<std::pair<std::string, int>, std::unique_ptr<FmuLibrary>> made;
    std::unique_ptr<FmuLibrary>& one = made[{name, GetParam()}];
    if (!one) one = std::make_unique<FmuLibrary>(fmu_of(model, GetParam(), name), "directions");
    return *one;
  }
};

/// Outputs at the same communication point with other inputs, which are set and taken back.
std::vector<double> outputs_with(FmuInstance& f, const std::vector<unsigned>& inputs,
                                 const std::vector<double>& given, const std::vector<double>& seed,
                                 double ahead) {
  void* state = nullptr;
  EXPECT_EQ(f.get_state(&state), fmi_ok);
  for (std::size_t k = 0; k < inputs.size(); ++k)
    EXPECT_EQ(f.set(inputs[k], given[k] + ahead * seed[k]), fmi_ok);
  const std::vector<double> out = f.outputs();
  EXPECT_EQ(f.set_state(state), fmi_ok);
  EXPECT_EQ(f.free_state(&state), fmi_ok);
  return out;
}

/// By central differences of fourth order of what the FMU itself shows; the largest derivative.
double expect_directions(FmuInstance& f, const FmuCode& fmu, int direction) {
  const std::vector<unsigned> inputs = references(fmu, {Role::input, Role::parameter}),
                              outputs = references(fmu, {Role::output});
  std::vector<double> given, seed, exact(outputs.size());
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    given.push_back(f.get(inputs[k]));
    seed.push_back(std::sin(1.7 * static_cast<double>(k) + direction));
  }
  const std::vector<double> before = f.outputs();
  EXPECT_EQ(f.vary(outputs, inputs, seed, exact.data()), fmi_ok) << f.messages();
  EXPECT_EQ(f.outputs(), before);
  constexpr double h = 1e-3;
  const auto at = [&](double ahead) { return outputs_with(f, inputs, given, seed, ahead); };
  const std::vector<double> a = at(h), b = at(-h), c = at(2 * h), d = at(-2 * h);
  double most = 0;
  for (std::size_t k = 0; k < outputs.size(); ++k) {
    const double found = (8 * (a[k] - b[k]) - (c[k] - d[k])) / (12 * h);
    EXPECT_NEAR(exact[k], found, 1e-8 * std::max(1.0, std::abs(found)) + 1e-9 * std::abs(before[k]))
        << fmu.code.outputs[k].name;
    most = std::max(most, std::abs(exact[k]));
  }
  return most;
}

TEST_P(FmuDirections, AreThoseOfDifferences) {
  for (const auto& [model, name] : {std::pair(shown_inputs(), "shown_inputs"), {plain(), "plain"}}) {
    SCOPED_TRACE(name);
    const FmuLibrary& of = library(model, name);
    ASSERT_TRUE(of.fmu().code.varies);
    const double h = of.fmu().code.step;
    FmuInstance f(of);
    EXPECT_EQ(f.enter(), fmi_ok);
    expect_directions(f, of.fmu(), 0);
    EXPECT_EQ(f.exit(), fmi_ok);
    expect_directions(f, of.fmu(), 1);
    for (int k = 0; k < 40; ++k) {
      f.set(reference(of.fmu(), of.fmu().code.inputs[0].name), 0.1 + 0.02 * k);
      EXPECT_EQ(f.step(k * h, h), fmi_ok) << f.messages();
      if (k % 10 == 3) {
        EXPECT_GT(expect_directions(f, of.fmu(), 2 + k), 0.05);
      }
    }
    const std::vector<unsigned> outputs = references(of.fmu(), {Role::output});
    std::vector<double> before(outputs.size()), after(outputs.size());
    EXPECT_EQ(f.vary(outputs, {1, 0}, {0.7, 0.1}, before.data()), fmi_ok);
    EXPECT_EQ(f.simple("Terminate"), fmi_ok);
    EXPECT_EQ(f.vary(outputs, {1, 0}, {0.7, 0.1}, after.data()), fmi_ok);
    EXPECT_EQ(after, before);
  }
}

/// Inputs within their ranges, so that differences to both sides are there.
void set_inside(FmuInstance& f, const FmuCode& fmu) {
  for (const FmuVariable& v : fmu.variables) {
    if (v.role != Role::input && v.role != Role::parameter) continue;
    const double low = std::isfinite(v.min) ? v.min : v.start - 1,
                 high = std::isfinite(v.max) ? v.max : v.start + 1;
    EXPECT_EQ(f.set(v.reference, 0.6 * low + 0.4 * high), fmi_ok);
  }
}

TEST_P(FmuDirections, OfExamplesAreThoseOfDifferences) {
  for (const auto& [file, name] : {std::pair("robot/model.yaml", "robot"), {"iltis/drive.yaml", "drive"}}) {
    if (GetParam() == 2 && std::string(name) == "drive") continue;  // takes the compiler long
    SCOPED_TRACE(name);
    const FmuLibrary& of = library(example(file), name);
    const double h = of.fmu().code.step;
    FmuInstance f(of);
    EXPECT_EQ(f.enter(), fmi_ok);
    set_inside(f, of.fmu());
    EXPECT_EQ(f.exit(), fmi_ok);
    for (int k = 0; k < 10; ++k) EXPECT_EQ(f.step(k * h, h), fmi_ok) << f.messages();
    for (const int direction : {0, 1, 2}) expect_directions(f, of.fmu(), direction);
  }
}

/// Single columns, by hand where the formula is known.
TEST_P(FmuDirections, AreThoseOfTheFormulas) {
  const FmuLibrary& of = library(shown_inputs(), "shown_inputs");
  const auto ref = [&](const char* name) { return reference(of.fmu(), name); };
  FmuInstance f(of);
  f.start();
  std::vector<double> angles;
  for (int k = 0; k < 20; ++k) {
    angles.push_back(f.get(ref("angle")));
    EXPECT_EQ(f.step(k * of.fmu().code.step, of.fmu().code.step), fmi_ok);
  }
  const double angle = f.get(ref("angle")), rate = f.get(ref("rate")), wanted = 0.2, gain = 1.5, k = 30,
               time = 20 * of.fmu().code.step;
  std::vector<double> found(4);
  EXPECT_EQ(
      f.vary({ref("mixed"), ref("in_time"), ref("height"), ref("servo")}, {ref("wanted")}, {2}, found.data()),
      fmi_ok);
  EXPECT_NEAR(found[0], 2 * (std::cos(angle + wanted) * gain * gain + rate * k), 1e-9);
  EXPECT_NEAR(found[1], 2 * 2 * wanted * time * time, 1e-12);
  EXPECT_EQ(found[2], 0);
  EXPECT_EQ(f.vary({ref("in_time"), ref("mixed")}, {0}, {1}, found.data()), fmi_ok);
  EXPECT_NEAR(found[0], -std::exp(-time) * gain + 2 * wanted * wanted * time, 1e-12);
  EXPECT_EQ(found[1], 0);  // the motion is held
  // On the line between what was five and a half steps before, and nothing of what is set now.
  EXPECT_EQ(f.vary({ref("late"), ref("trailing")}, {0, ref("wanted")}, {1, 1}, found.data()), fmi_ok);
  EXPECT_NEAR(found[0], (angles[15] - angles[14]) / of.fmu().code.step, 1e-9);
  EXPECT_EQ(f.vary({ref("mixed")}, {ref("gain"), ref("gain"), ref("k")}, {1, 2, 0.5}, found.data()), fmi_ok);
  EXPECT_NEAR(found[0], 3 * 2 * gain * std::sin(angle + wanted) + 0.5 * rate * wanted, 1e-9);
  // What is reached in a straight line does not act at once.
  EXPECT_EQ(f.vary({ref("airy"), ref("gust")}, {ref("wind")}, {1}, found.data()), fmi_ok);
  EXPECT_EQ(found[0], 0);
}

/// Between the model's steps outputs are on a line, on which inputs do not act.
TEST_P(FmuDirections, BetweenStepsAreThoseOfTheLine) {
  const FmuLibrary& of = library(plain(), "plain");
  const double h = of.fmu().code.step;
  const unsigned wave = reference(of.fmu(), "wave"), moment = reference(of.fmu(), "moment");
  FmuInstance f(of), ahead(of);
  f.start();
  ahead.start();
  EXPECT_EQ(f.step(0, 2.4 * h), fmi_ok);
  EXPECT_EQ(ahead.step(0, 2.6 * h), fmi_ok);
  double by_time = 7, by_input = 7;
  EXPECT_EQ(f.vary({wave}, {0}, {1}, &by_time), fmi_ok);
  EXPECT_NEAR(by_time, (ahead.get(wave) - f.get(wave)) / (0.2 * h), 1e-9);
  EXPECT_EQ(f.vary({wave}, {moment}, {1}, &by_input), fmi_ok);
  EXPECT_EQ(by_input, 0);
}

TEST_P(FmuDirections, RefusesWrongDirections) {
  const FmuLibrary& of = library(plain(), "plain");
  const unsigned wave = reference(of.fmu(), "wave"), moment = reference(of.fmu(), "moment"),
                 steps = reference(of.fmu(), "solver.steps");
  FmuInstance f(of);
  double result = 7;
  EXPECT_EQ(f.vary({wave}, {moment}, {1}, &result), fmi_error);  // before initialization
  f.start();
  EXPECT_EQ(f.vary({moment}, {moment}, {1}, &result), fmi_error);
  EXPECT_EQ(f.vary({steps}, {moment}, {1}, &result), fmi_error);
  EXPECT_EQ(f.vary({wave}, {wave}, {1}, &result), fmi_error);
  EXPECT_EQ(f.vary({wave}, {4000000000u}, {1}, &result), fmi_error);
  EXPECT_EQ(f.vary({wave}, {moment}, {std::nan("")}, &result), fmi_error);
  EXPECT_EQ(f.vary({wave}, {moment}, {1}, nullptr), fmi_error);
  EXPECT_EQ(result, 7);
  EXPECT_EQ(f.vary({}, {}, {}, nullptr), fmi_ok);
}

/// Neither inputs nor outputs: all of the model's are left out. The compiler warns of nothing.
TEST_P(FmuDirections, OfNothingAreNone) {
  const auto model = model_of(R"yaml(
bodies: {link: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0.5, 0, 0]}}
joints: {hinge: {type: revolute, between: [ground, link], at: [0, 0, 0], axis: [0, 1, 0]}}
outputs: [{name: force, joint_force: hinge, component: fx}]
simulation: {step: 0.01, end: 1}
)yaml");
  const FmuLibrary& of = library(model, "nothing");
  ASSERT_TRUE(of.fmu().code.outputs.empty());
  FmuInstance f(of);
  f.start();
  EXPECT_EQ(f.step(0, 0.015), fmi_ok);
  double none = 7;
  EXPECT_EQ(f.vary({}, {0}, {1}, &none), fmi_ok);
  EXPECT_EQ(none, 7);
  EXPECT_EQ(f.vary({0}, {0}, {1}, &none), fmi_error);
}

/// Nothing of it is in code that is no FMU.
TEST(FmuDirectionsCode, LeavesGeneratedCodeAsItIs) {
  const GeneratedCode code = generate_code(shown_inputs(), {}, "plain_code");
  EXPECT_FALSE(code.varies);
  EXPECT_EQ(code.source.find("vary"), std::string::npos);
  EXPECT_EQ(code.header.find("d_"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Versions, FmuDirections, testing::Values(2, 3),
                         [](const testing::TestParamInfo<int>& version) {
                           return "Fmi" + std::to_string(version.param);
                         });

}  // namespace
}  // namespace mimbre::test::fmu_directions_test
