#include "mimbre/model_bytes.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "app/program.h"
#include "mimbre/model_file.h"
#include "mimbre/simulation.h"
#include "support/models.h"
#include "support/text.h"

/// A model read back from its bytes is the same model.
namespace mimbre::test::model_bytes_test {
namespace {

namespace fs = std::filesystem;
const fs::path folder = fs::path(MIMBRE_SOURCE_DIR) / "examples";

std::vector<std::string> examples() {
  std::vector<std::string> paths;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".yaml" &&
        app_test::read_file(entry.path()).find("\nsimulation:") != std::string::npos)
      paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end());
  return paths;
}

class OfExamples : public testing::TestWithParam<std::string> {};

TEST_P(OfExamples, SameFingerprintAndBits) {
  const spec::Model given = load_model(GetParam());
  const std::vector<std::byte> bytes = model_bytes(given);
  const spec::Model again = model_from_bytes(bytes);
  EXPECT_EQ(model_bytes(again), bytes);
  Simulation a(Model::compile(given)), b(Model::compile(again));
  EXPECT_EQ(a.fingerprint(), b.fingerprint());
  for (int k = 0; k < 5; ++k) {
    EXPECT_TRUE(a.step().ok());
    EXPECT_TRUE(b.step().ok());
  }
  EXPECT_EQ(a.save().bytes(), b.save().bytes());
}

INSTANTIATE_TEST_SUITE_P(ModelBytes, OfExamples, testing::ValuesIn(examples()), [](const auto& example) {
  return replaced(fs::relative(example.param, folder).replace_extension().string(), "[^A-Za-z0-9]", "_");
});

TEST(ModelBytes, OfAFlexiblePendulumEverythingComesBack) {
  const spec::Model given = load_model((folder / "pendulum/flexible.yaml").string());
  const spec::Model again = model_from_bytes(model_bytes(given));
  EXPECT_EQ(again.text, given.text);
  ASSERT_EQ(again.bodies.size(), given.bodies.size());
  for (std::size_t k = 0; k < given.bodies.size(); ++k) {
    EXPECT_EQ(again.bodies[k].mark.line, given.bodies[k].mark.line);
    if (!given.bodies[k].flexible) continue;
    EXPECT_EQ(again.bodies[k].flexible->stiffness, given.bodies[k].flexible->stiffness);
    EXPECT_EQ(again.bodies[k].flexible->mode_names, given.bodies[k].flexible->mode_names);
  }
}

TEST(ModelBytes, DamagedBytesAreRefused) {
  const spec::Model given = load_model((folder / "tutorial/pendulum.yaml").string());
  const std::vector<std::byte> bytes = model_bytes(given);
  EXPECT_THROW(model_from_bytes({}), InputError);
  for (const std::size_t kept : {std::size_t{7}, std::size_t{40}, bytes.size() / 2, bytes.size() - 1})
    EXPECT_THROW(model_from_bytes(std::span(bytes).first(kept)), InputError);
  for (const std::size_t at : {std::size_t{0}, std::size_t{10}, bytes.size() / 2}) {
    std::vector<std::byte> damaged = bytes;
    damaged[at] ^= std::byte{16};
    EXPECT_THROW(model_from_bytes(damaged), InputError);
  }
}

TEST(ModelBytes, ALawOfTheUsersIsRefusedByName) {
  spec::Model model;
  spec::Element element;
  element.name = "my damper";
  element.user = std::make_shared<spec::UserLaw>();
  model.elements.push_back(element);
  try {
    model_bytes(model);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("my damper"), std::string::npos);
  }
}

}  // namespace
}  // namespace mimbre::test::model_bytes_test
