#include "portable/library/model_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "mimbre/model_bytes.h"
#include "mimbre/model_file.h"
#include "portable/library/record_source.h"

/// Models that are read again from what was kept of them.
namespace mimbre::test::model_source_test {
namespace {

using portable::ModelSource;
using testing::HasSubstr;

std::string example_path(const std::string& name) {
  return std::string(MIMBRE_SOURCE_DIR) + "/examples/" + name;
}

/// Through bytes.
ModelSource kept(const spec::Model& model, const std::map<std::string, std::string>& settings = {}) {
  const std::optional<ModelSource> source = portable::source_of(model, settings);
  EXPECT_TRUE(source) << model.file;
  return portable::source_from_bytes(portable::source_bytes(source.value_or(ModelSource{})));
}

/// Without the texts, to which what was included is added again.
std::vector<std::byte> bytes_of(spec::Model model) {
  model.text.clear();
  return model_bytes(model);
}

TEST(ModelSource, OfEveryExampleGivesTheSameModel) {
  int models = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(example_path(""))) {
    if (entry.path().extension() != ".yaml") continue;
    SCOPED_TRACE(entry.path());
    spec::Model model;
    try {
      model = load_model(entry.path().string());
    } catch (const InputError&) {
      continue;  // a template, or a study
    }
    if (std::any_of(model.blocks.begin(), model.blocks.end(), [](const spec::Block& b) { return b.outside; }))
      continue;
    const portable::ModelRead again = portable::read_model(kept(model), {});
    EXPECT_EQ(bytes_of(again.model), bytes_of(model));
    ++models;
  }
  EXPECT_GT(models, 20);
}

TEST(ModelSource, GivesTheModelOfOtherParameters) {
  const std::string path = example_path("tutorial/pendulum.yaml");
  const spec::Model model = load_model(path);
  const ModelSource source = kept(model);
  const portable::ModelRead first = portable::read_model(source, {});
  ASSERT_FALSE(first.parameters.empty());
  const std::string name = first.parameters.front().name;
  const double other = 1.25 * std::get<double>(first.parameters.front().value);
  EXPECT_EQ(bytes_of(portable::read_model(source, {{name, other}}).model),
            bytes_of(load_model(path, {{name, std::to_string(other)}})));
}

/// Files need not be there any more.
TEST(ModelSource, NeedsNoFiles) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(testing::TempDir()) / ("model_source_" + std::to_string(getpid()));
  fs::remove_all(folder);
  fs::create_directories(folder);
  std::ofstream(folder / "materials.yaml")
      << "mimbre: 1\nmaterials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}\n";
  std::ofstream(folder / "wheel.yaml") << "mimbre: 1\nparameters: {mass: 1}\n"
                                          "bodies: {hub: {mass: mass, com: [0, 0, 0], inertia: [1, 1, 1]}}\n";
  std::ofstream(folder / "model.yaml") << R"yaml(mimbre: 1
include: [materials.yaml]
parameters: {heavy: 3, count: {value: 2, min: 1, max: 9, integer: true}, twice: 2*heavy, kind: {value: a, choices: [a, b]}}
subsystems: {wheel: {file: wheel.yaml}}
instances: {left: {of: wheel, with: {mass: heavy}}}
bodies: {b: {mass: twice, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {j: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [0, 0, 1]}}
outputs: [{name: z, joint: j}]
)yaml";
  const spec::Model model = load_model((folder / "model.yaml").string());
  const ModelSource source = kept(model);
  fs::remove_all(folder);
  const portable::ModelRead again = portable::read_model(source, {{"heavy", 5}});
  EXPECT_EQ(again.model.bodies.at(0).mass + again.model.bodies.at(1).mass, 15);
  ASSERT_EQ(again.parameters.size(), 3u);
  EXPECT_EQ(again.parameters[0].name, "heavy");
  EXPECT_FALSE(again.parameters[0].derived);
  EXPECT_EQ(again.parameters[1].name, "twice");
  EXPECT_TRUE(again.parameters[1].derived);
  EXPECT_EQ(std::get<double>(again.parameters[1].value), 10);
  EXPECT_EQ(again.parameters[2].name, "count");
  EXPECT_TRUE(again.parameters[2].integer);
  EXPECT_THAT(
      [&] {
        portable::read_model(source, {{"count", 10}});
      },
      testing::ThrowsMessage<InputError>(HasSubstr("10 is not a whole number from 1 to 9")));
}

TEST(ModelSource, IsNoneOfOtherSettings) {
  const std::string path = example_path("tutorial/pendulum.yaml");
  const spec::Model model = load_model(path);
  const portable::ModelRead first = portable::read_model(kept(model), {});
  const std::string name = first.parameters.front().name;
  const std::map<std::string, std::string> settings{
      {name, std::to_string(1.25 * std::get<double>(first.parameters.front().value))}};
  EXPECT_FALSE(portable::source_of(load_model(path, settings), {}));
  EXPECT_TRUE(portable::source_of(load_model(path, settings), settings));
}

}  // namespace
}  // namespace mimbre::test::model_source_test
