#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "mimbre/method_names.h"
#include "mimbre/model_file.h"
#include "mimbre/run_option.h"
#include "support/json.h"

/// The schemas, which editors use, and the loader allow the same options of a run.
namespace mimbre::schema_test {
namespace {

spec::Simulation simulation(const std::string& text) {
  return parse_model(
             "mimbre: 1\nbodies:\n  arm: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}\nsimulation: " + text +
                 "\n",
             "s.yaml", "")
      .simulation;
}

/// What the loader says of a word that it cannot know.
std::string complaint(const std::string& text) {
  try {
    simulation(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing";
}

const test::Json& file(const std::string& name) {
  static std::map<std::string, test::Json> read;
  const auto [found, fresh] = read.try_emplace(name);
  if (fresh) {
    std::ostringstream text;
    text << std::ifstream(MIMBRE_SOURCE_DIR "/schema/" + name + ".schema.json").rdbuf();
    found->second = test::Json::parse(text.str());
  }
  return found->second;
}

std::set<std::string> keys_of(const test::Json& properties) {
  std::set<std::string> keys;
  for (const std::string& key : properties.keys()) keys.insert(key);
  return keys;
}

void expect_words(const test::Json& words, const RunOption& option) {
  std::vector<std::string> listed;
  for (const test::Json& word : words) listed.push_back(word);
  EXPECT_EQ(listed, std::vector<std::string>(option.words.begin(), option.words.end())) << option.key;
}

/// The schema of models has the table's options, with their words and descriptions, and no others.
TEST(Schema, OptionsOfARunAreThoseOfTheTable) {
  const auto& rules = file("model").at("$defs");
  std::set<std::string> own, of_integrators;
  for (const RunOption& option : run_option_table()) {
    const bool nested = !option.section.empty();
    const std::string key(option.key_in_file());
    (nested ? of_integrators : own).insert(key);
    if (nested) own.insert(std::string(option.section));
    const auto& properties =
        rules.at(nested ? std::string(option.section) : std::string("simulation")).at("properties");
    ASSERT_TRUE(properties.contains(key)) << key;
    const auto& node = properties.at(key);
    const std::string about = node.at("description");
    EXPECT_EQ(about, option.about) << key;
    if (!option.words.empty()) expect_words(node.at("enum"), option);
  }
  EXPECT_EQ(keys_of(rules.at("simulation").at("properties")), own);
  EXPECT_EQ(keys_of(rules.at("integrator").at("properties")), of_integrators);
}

/// Studies, and so Python, have those that the command line has; their types are those of the table.
TEST(Schema, OptionsOfStudiesAreThoseOfTheTable) {
  const auto& properties = file("study").at("properties").at("method").at("properties");
  std::set<std::string> keys{"step"};
  for (const std::string& key : properties.keys()) keys.insert(key);
  std::set<std::string> wanted;
  for (const RunOption& option : run_option_table()) {
    if (option.option.empty()) continue;
    wanted.insert(std::string(option.key));
    if (option.key == "step") continue;
    ASSERT_TRUE(properties.contains(std::string(option.key))) << option.key;
    const auto& node = properties.at(std::string(option.key));
    if (!option.words.empty()) {
      expect_words(node.at("enum"), option);
    } else if (std::holds_alternative<OptionMember<double>>(option.member)) {
      EXPECT_TRUE(node.contains("$ref")) << option.key;
    } else {
      const std::string type = node.at("type");
      EXPECT_EQ(type, std::holds_alternative<OptionMember<int>>(option.member) ? "integer" : "boolean");
    }
  }
  EXPECT_EQ(keys, wanted);
}

/// What a run took, in its summary.
TEST(Schema, ResolvedOptionsAreThoseOfTheTable) {
  std::set<std::string> wanted{"default_end"};
  for (const RunOption& option : run_option_table()) wanted.insert(std::string(option.key));
  EXPECT_EQ(keys_of(file("output").at("$defs").at("resolved").at("properties")), wanted);
}

/// Every word is taken, each for something else, and no other.
TEST(Schema, ChoicesOfTheMethodAreTheLoaders) {
  for (const RunOption& option : run_option_table()) {
    if (option.words.empty()) continue;
    const std::string section(option.section);
    const std::string before =
        fmt::format("{{{}{}: ", section.empty() ? "" : section + ": {", option.key_in_file());
    const std::string after = section.empty() ? "}" : "}}";
    double place = 0;
    for (const char* word : option.words)
      EXPECT_EQ(value_in(option, simulation(before + word + after)), place++) << word;
    EXPECT_THAT(complaint(before + "no-such-word" + after),
                testing::HasSubstr(fmt::format("is not one of {}", fmt::join(option.words, ", "))));
  }
}

/// The loader's message about an unknown key lists the ones that it knows.
void same_keys(const test::Json& properties, const std::string& with_unknown_key) {
  const std::string text = complaint(with_unknown_key), before = "known: ";
  ASSERT_NE(text.find(before), std::string::npos) << text;
  std::istringstream list(text.substr(text.find(before) + before.size()));
  std::set<std::string> known;
  for (std::string key; std::getline(list >> std::ws, key, ',');) known.insert(key);
  EXPECT_EQ(known, keys_of(properties));
}

TEST(Schema, KeysOfTheSimulationAreTheLoaders) {
  const auto& rules = file("model").at("$defs");
  same_keys(rules.at("simulation").at("properties"), "{zzz: 1}");
  same_keys(rules.at("integrator").at("properties"), "{integrator: {type: newmark, zzz: 1}}");
}

/// Numbers at the bounds are taken by the model file as by a caller, and numbers beyond by neither.
TEST(RunOptionTable, HasOneRuleForTheFileAndForCallers) {
  const auto in_file = [](const RunOption& option, double value) {
    const std::string key(option.key_in_file());
    // Of an integrator that has it; steps and ends go together.
    const std::string text = option.section.empty() ? fmt::format("{{{}: {}}}", key, value)
                                                    : fmt::format("{{integrator: {{type: {}, {}: {}}}}}",
                                                                  name_of(option.of.front()), key, value);
    return complaint(text) == "nothing";
  };
  const auto by_caller = [](const RunOption& option, double value) {
    return wrong_value(option, value).empty();
  };
  for (const RunOption& option : run_option_table()) {
    if (!option.words.empty() || std::holds_alternative<OptionMember<bool>>(option.member)) continue;
    SCOPED_TRACE(option.key);
    std::vector<double> values;
    for (const double bound : {option.above, option.least, option.most})
      if (std::isfinite(bound)) values.insert(values.end(), {bound, bound - 1, bound + 1});
    for (const double value : values) {
      const bool allowed = by_caller(option, value);
      if (option.unit == "s" && allowed) continue;  // a run has a step within it
      EXPECT_EQ(in_file(option, value), allowed) << value;
    }
  }
}

}  // namespace
}  // namespace mimbre::schema_test
