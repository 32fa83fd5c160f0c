#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <pugixml.hpp>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "support/exchange_importer.h"

/// What FMUs for model exchange say of themselves.
namespace mimbre::test::model_exchange_description_test {
namespace {

using Role = FmuVariable::Role;

class ModelExchangeDescription : public ExchangeTest {};

/// What validators look for.
TEST_P(ModelExchangeDescription, IsDescribedAsTheStandardWantsIt) {
  const auto model = driven_loop();
  const FmuCode fmu = exchange_fmu(model, GetParam(), "driven");
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
TEST_P(ModelExchangeDescription, DeclaresWhatItCanDo) {
  const auto model = double_pendulum();
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
TEST_P(ModelExchangeDescription, ListsNothingWhereThereIsNothing) {
  for (const auto& [rest, states, outputs] :
       {std::tuple(", drive: {position: \"sin(t)\"}}}\noutputs: [{name: x, joint: guide}]", 0u, 1u),
        {"}}\noutputs: [{name: push, joint_force: guide, component: fz}]", 2u, 0u}}) {
    const auto model = model_of(
        "bodies: {block: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}}\n"
        "joints: {guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0]" +
        std::string(rest));
    const FmuCode fmu = exchange_fmu(model, GetParam(), "sparse");
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

TEST_P(ModelExchangeDescription, KnowsWhatOutputsShowAtOnce) {
  const FmuCode fmu = exchange_fmu(driven_loop(), GetParam(), "driven");
  const auto of = [&](const std::string& name) { return fmu.variables[reference(fmu, name)]; };
  const std::vector<unsigned> states = references(fmu, {Role::state}), wanted{reference(fmu, "wanted")};
  EXPECT_EQ(of("shown").dependencies, wanted);
  EXPECT_EQ(of("angle").dependencies, states);
  EXPECT_EQ(of("rate").dependencies, states);
  EXPECT_EQ(of("gust").dependencies, states);  // without feedthrough
  EXPECT_EQ(of("servo").dependencies, wanted + states);
  for (const FmuVariable& v : fmu.variables)
    EXPECT_EQ(v.depends_on_all, v.role == Role::derivative || v.role == Role::indicator);
  const FmuCode pendulum = exchange_fmu(double_pendulum(), GetParam(), "double_pendulum");
  EXPECT_TRUE(pendulum.variables[reference(pendulum, "tip")].depends_on_all);
}

/// Both versions count the time among the knowns, and FMI 3 parameters, too.
TEST_P(ModelExchangeDescription, DependenciesNameTheTimeAndParameters) {
  const FmuCode fmu = exchange_fmu(timed_outputs(), GetParam(), "timed_outputs");
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

/// The C library's mathematics and memory alone.
TEST_P(ModelExchangeDescription, NeedsOnlyTheMathematicsOfC) {
  const std::string folder = fmu_sources(exchange_fmu(driven_loop(), GetParam(), "symbols"), "symbols");
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

INSTANTIATE_TEST_SUITE_P(Versions, ModelExchangeDescription, testing::Values(2, 3), name_of_version);

}  // namespace
}  // namespace mimbre::test::model_exchange_description_test
