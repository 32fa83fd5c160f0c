#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>

#include "mimbre/model_file.h"
#include "support/json.h"

/// The schema, which editors use, and the loader allow the same words under `simulation`.
namespace mimbre::schema_test {
namespace {

const test::Json& schema() {
  static const test::Json read = [] {
    std::ostringstream text;
    text << std::ifstream(MIMBRE_SOURCE_DIR "/schema/model.schema.json").rdbuf();
    return test::Json::parse(text.str());
  }();
  return read;
}

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

/// Every word of the schema is taken, each for something else, and no other.
template <class Get>
void same_choices(const test::Json& words, const std::string& before, const std::string& after,
                  const Get& get) {
  std::set<int> meanings;
  std::string list;
  for (const test::Json& entry : words) {
    const std::string word = entry;
    meanings.insert(static_cast<int>(get(simulation(before + word + after))));
    list += (list.empty() ? "" : ", ") + word;
  }
  EXPECT_EQ(meanings.size(), words.size());
  // The loader's message lists its words in order.
  EXPECT_NE(complaint(before + "no-such-word" + after).find("is not one of " + list), std::string::npos)
      << complaint(before + "no-such-word" + after);
}

TEST(Schema, ChoicesOfTheMethodAreTheLoaders) {
  const auto& properties = schema().at("$defs").at("simulation").at("properties");
  same_choices(properties.at("formulation").at("enum"), "{formulation: ", "}",
               [](const spec::Simulation& s) { return s.formulation; });
  same_choices(properties.at("inertia").at("enum"), "{inertia: ", "}",
               [](const spec::Simulation& s) { return s.inertia; });
  same_choices(properties.at("formalism").at("enum"), "{formalism: ", "}",
               [](const spec::Simulation& s) { return s.formalism; });
  same_choices(schema().at("$defs").at("integrator").at("properties").at("type").at("enum"),
               "{integrator: {type: ", "}}", [](const spec::Simulation& s) { return s.integrator; });
}

/// The loader's message about an unknown key lists the ones that it knows.
void same_keys(const test::Json& properties, const std::string& with_unknown_key) {
  const std::string text = complaint(with_unknown_key), before = "known: ";
  ASSERT_NE(text.find(before), std::string::npos) << text;
  std::istringstream list(text.substr(text.find(before) + before.size()));
  std::set<std::string> known, keys;
  for (std::string key; std::getline(list >> std::ws, key, ',');) known.insert(key);
  for (const std::string& key : properties.keys()) keys.insert(key);
  EXPECT_EQ(known, keys);
}

TEST(Schema, KeysOfTheSimulationAreTheLoaders) {
  const auto& rules = schema().at("$defs");
  same_keys(rules.at("simulation").at("properties"), "{zzz: 1}");
  same_keys(rules.at("integrator").at("properties"), "{integrator: {type: newmark, zzz: 1}}");
}

}  // namespace
}  // namespace mimbre::schema_test
