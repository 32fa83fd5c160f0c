#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <pugixml.hpp>
#include <vector>

#include "mimbre/diagnostics.h"
#include "support/exchange_importer.h"
#include "support/fmu_importer.h"
#include "support/hostile_importer.h"
#include "support/models.h"

/// Outputs that are vectors as arrays of FMI 3.
namespace mimbre::test::fmu_arrays_test {
namespace {

using Role = FmuVariable::Role;
using Kind = FmuOptions::Kind;

/// Vectors in any order of their components, one that lacks a component, and a name that is taken.
std::shared_ptr<const Model> arm() {
  return model_of(R"yaml(
gravity: [1, 2, -9.81]
inputs: {push: {start: 0.3}}
bodies: {link: {mass: 1, inertia: [0.1, 0.2, 0.3], com: [0.5, 0, 0]}}
frames: {tip: {body: link, at: [1, 0, 0.2]}}
joints: {ball: {type: spherical, between: [ground, link], at: [0, 0, 0]}}
signals: {speed: {velocity: tip, component: x}, shown: "push^2"}
loads: {load: {on: tip, force: [0, 1, 0], scale: "push"}}
outputs:
  - {name: tip.z, position: tip, component: z}
  - {name: tip.x, position: tip, component: x}
  - {name: turn, yaw: tip}
  - {name: tip.y, position: tip, component: y}
  - {name: part.x, velocity: tip, component: x}
  - {name: part.y, velocity: tip, component: y}
  - {name: speed_x, velocity: tip, component: x}
  - {name: speed_y, velocity: tip, component: y}
  - {name: speed_z, velocity: tip, component: z}
simulation: {step: 0.01, end: 1}
)yaml");
}

FmuCode fmu_of(const std::shared_ptr<const Model>& model, Kind kind, bool arrays) {
  FmuOptions options;
  options.kind = kind;
  options.arrays = arrays;
  options.name = arrays ? "arm_arrays" : "arm_scalars";
  return generate_fmu(model, {}, options);
}
const FmuVariable& variable(const FmuCode& fmu, const std::string& name) {
  for (const FmuVariable& v : fmu.variables)
    if (v.name == name) return v;
  throw std::runtime_error("no variable " + name);
}
std::vector<std::string> outputs_of(const FmuCode& fmu) {
  std::vector<std::string> out;
  for (const FmuVariable& v : fmu.variables)
    if (v.role == Role::output) out.push_back(v.name);
  return out;
}

TEST(FmuArrays, JoinAllComponentsOfAVector) {
  const auto model = arm();
  const FmuCode fmu = fmu_of(model, Kind::co_simulation, true);
  // The signal has the name that the second vector would have.
  EXPECT_THAT(outputs_of(fmu),
              testing::ElementsAre("tip", "turn", "part.x", "part.y", "output.speed", "speed", "shown"));
  EXPECT_EQ(variable(fmu, "tip").outputs, (std::vector<int>{1, 3, 0}));
  EXPECT_EQ(variable(fmu, "tip").meaning, "position of frame 'tip'");
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(fmu_description(fmu, *model, true).c_str()));
  const pugi::xml_node root = document.child("fmiModelDescription"),
                       tip = root.child("ModelVariables").find_child_by_attribute("name", "tip");
  EXPECT_EQ(tip.child("Dimension").attribute("start").as_int(), 3);
  EXPECT_FALSE(root.child("ModelVariables").find_child_by_attribute("name", "turn").child("Dimension"));
  int listed = 0;
  for (const pugi::xml_node output : root.child("ModelStructure").children("Output"))
    listed += output.attribute("valueReference").as_uint() == variable(fmu, "tip").reference;
  EXPECT_EQ(listed, 1);
}

TEST(FmuArrays, LeaveTheNamesAloneUnlessAskedFor) {
  EXPECT_EQ(outputs_of(fmu_of(arm(), Kind::co_simulation, false)).size(), 11u);
  FmuOptions two;
  two.version = 2;
  two.arrays = true;
  try {
    generate_fmu(arm(), {}, two);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("FMI 2 has no arrays"));
  }
}

int get_values(const FmuLibrary& of, FmuInstance& f, std::vector<unsigned> references,
               std::vector<double>& values) {
  const unsigned* const vr = references.data();
  return of.call("GetFloat64", f.handle(), vr, references.size(), values.data(), values.size());
}

TEST(FmuArrays, AreReadElementByElement) {
  const auto model = arm();
  const FmuLibrary arrays(fmu_of(model, Kind::co_simulation, true), "arrays"),
      scalars(fmu_of(model, Kind::co_simulation, false), "scalars");
  const double h = arrays.fmu().code.step;
  FmuInstance a(arrays), s(scalars);
  a.start();
  s.start();
  const unsigned tip = reference(arrays.fmu(), "tip"), speed = reference(arrays.fmu(), "output.speed"),
                 turn = reference(arrays.fmu(), "turn");
  double now = 0;
  for (const double length : {h, 2 * h, 0.3 * h, 1.7 * h, h}) {
    EXPECT_EQ(a.step(now, length), fmi_ok);
    EXPECT_EQ(s.step(now, length), fmi_ok);
    now += length;
    std::vector<double> values(8), expected;
    ASSERT_EQ(get_values(arrays, a, {speed, 0, turn, tip}, values), fmi_ok) << a.messages();
    for (const char* name : {"speed_x", "speed_y", "speed_z", "time", "turn", "tip.x", "tip.y", "tip.z"})
      expected.push_back(s.get(reference(scalars.fmu(), name)));
    EXPECT_EQ(values, expected);
  }
  // Sizes that lie, and references of elements.
  std::vector<double> values(3);
  EXPECT_EQ(get_values(arrays, a, {tip, turn}, values), fmi_error);
  EXPECT_EQ(get_values(arrays, a, {tip + 1}, values), fmi_error);
  std::vector<double> one(1), four(4), none;
  EXPECT_EQ(get_values(arrays, a, {tip + 1}, one), fmi_error);
  EXPECT_EQ(get_values(arrays, a, {tip + 1}, none), fmi_error);
  EXPECT_EQ(get_values(arrays, a, {tip}, one), fmi_error);
  EXPECT_EQ(get_values(arrays, a, {tip}, four), fmi_error);
  EXPECT_EQ(get_values(arrays, a, {tip, turn}, four), fmi_ok);
  EXPECT_EQ(get_values(arrays, a, {}, none), fmi_ok);
}

TEST(FmuArrays, HaveDirectionalDerivatives) {
  const auto model = arm();
  const FmuLibrary arrays(fmu_of(model, Kind::model_exchange, true), "arrays_me"),
      scalars(fmu_of(model, Kind::model_exchange, false), "scalars_me");
  ExchangeInstance a(arrays), s(scalars);
  a.start_continuous();
  s.start_continuous();
  std::vector<double> x = a.states();
  for (std::size_t k = 0; k < x.size(); ++k) x[k] += 0.1 * static_cast<double>(k + 1);
  EXPECT_EQ(a.set_states(x), fmi_ok);
  EXPECT_EQ(s.set_states(x), fmi_ok);
  const std::vector<unsigned> states = references(arrays.fmu(), {Role::state}),
                              states_of_scalars = references(scalars.fmu(), {Role::state});
  const std::vector<double> seed{0.3, -0.2, 0.7, 0.1, 0.4, -0.6};
  const unsigned tip = reference(arrays.fmu(), "tip"), rate = reference(arrays.fmu(), "der(state.2)");
  std::vector<double> found(4), expected(4);
  ASSERT_EQ(a.vary({tip, rate}, states, seed, found.data(), 4), fmi_ok) << a.messages();
  std::vector<unsigned> unknowns;
  for (const char* name : {"tip.x", "tip.y", "tip.z", "der(state.2)"})
    unknowns.push_back(reference(scalars.fmu(), name));
  ASSERT_EQ(s.vary(unknowns, states_of_scalars, seed, expected.data()), fmi_ok);
  EXPECT_EQ(found, expected);
  EXPECT_GT(std::abs(found[0]) + std::abs(found[1]) + std::abs(found[2]), 0.1);
  EXPECT_EQ(a.vary({tip, rate}, states, seed, found.data(), 2), fmi_error);
  EXPECT_EQ(a.vary({tip + 1}, states, seed, found.data(), 1), fmi_error);
}

TEST(FmuArrays, HaveDirectionalDerivativesAtCommunicationPoints) {
  const FmuLibrary arrays(fmu_of(arm(), Kind::co_simulation, true), "arrays_directions");
  const auto ref = [&](const char* name) { return reference(arrays.fmu(), name); };
  FmuInstance f(arrays);
  f.start();
  EXPECT_EQ(f.step(0, 0.02), fmi_ok);
  std::vector<double> found(4, 7.0);
  ASSERT_EQ(f.vary({ref("tip"), ref("shown")}, {ref("push")}, {2}, found.data(), 4), fmi_ok) << f.messages();
  EXPECT_EQ(found, (std::vector<double>{0, 0, 0, 2 * 2 * 0.3}));
  EXPECT_EQ(f.vary({ref("tip"), ref("shown")}, {ref("push")}, {2}, found.data(), 2), fmi_error);
  EXPECT_EQ(f.vary({ref("tip") + 1}, {ref("push")}, {2}, found.data(), 1), fmi_error);
}

/// Random calls with wrong arguments, under the sanitizers.
TEST(FmuArrays, StandHostileImporters) {
  const FmuCode fmu = fmu_of(arm(), Kind::co_simulation, true);
  const std::string printed =
      printed_by_hostile(fmu, "hostile_importer", "-DINSTANCE_STEP=" + std::to_string(fmu.code.step));
  if (printed.empty()) GTEST_SKIP() << "the compiler has no sanitizers";
  expect_good_calls(printed, 10, {14, 15});
}
TEST(FmuArrays, StandHostileSolvers) {
  const FmuCode fmu = fmu_of(arm(), Kind::model_exchange, true);
  const std::string printed =
      printed_by_hostile(fmu, "hostile_exchange", "-DSTATES=" + std::to_string(fmu.code.states.size()));
  if (printed.empty()) GTEST_SKIP() << "the compiler has no sanitizers";
  expect_good_calls(printed, 10, {});
}

}  // namespace
}  // namespace mimbre::test::fmu_arrays_test
