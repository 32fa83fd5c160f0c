#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "app/program.h"
#include "support/text.h"

/// Every example runs, and the tutorial quotes its files to the letter.
namespace mimbre::app_test::examples_test {
namespace {

const fs::path source = MIMBRE_SOURCE_DIR;

/// Complete models: they have a simulation section (templates that others include have none).
std::vector<std::string> examples() {
  std::vector<std::string> paths;
  for (const auto& entry : fs::recursive_directory_iterator(source / "examples"))
    if (entry.path().extension() == ".yaml" &&
        read_file(entry.path()).find("\nsimulation:") != std::string::npos)
      paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end());
  return paths;
}

class Examples : public ProgramTest, public testing::WithParamInterface<std::string> {};

TEST_P(Examples, Run) {
  const Outcome outcome = run({"run", GetParam(), "--until", "0.3", "--json"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.json().at("status"), "ok");
  EXPECT_LE(outcome.json().at("max_position_violation"), 1e-8);
  EXPECT_LE(outcome.json().at("max_velocity_violation"), 1e-6);
  EXPECT_TRUE(outcome.json().at("warnings").empty()) << outcome.err;
}

INSTANTIATE_TEST_SUITE_P(All, Examples, testing::ValuesIn(examples()), [](const auto& example) {
  return test::replaced(fs::relative(example.param, source / "examples").replace_extension().string(),
                        "[^A-Za-z0-9]", "_");
});

TEST(Tutorial, QuotesItsFiles) {
  const std::string tutorial = read_file(source / "docs/tutorial.md");
  const auto quotes = test::matches(tutorial, "<!-- file: ([^ ]+) -->\\s*```yaml\\n([^`]*)```");
  for (const std::vector<std::string>& quote : quotes) {
    const std::string& name = quote[1];
    const fs::path file = fs::exists(source / name) ? source / name : source / "docs" / name;
    EXPECT_EQ(quote[2], read_file(file)) << name;
  }
  EXPECT_GE(quotes.size(), 2u);
}

}  // namespace
}  // namespace mimbre::app_test::examples_test
