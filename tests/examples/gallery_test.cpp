#include "examples/example.h"

/// What every example of an engineer's mechanism does: both formulations agree about it, and it has a page.
namespace mimbre::examples_test::gallery_test {
namespace {

class Gallery : public ExampleTest, public testing::WithParamInterface<std::string> {};

TEST_P(Gallery, BothFormulationsAgree) {
  const app_test::Outcome outcome = run({"verify", model_of(GetParam()).string(), "--json", "--strict"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.json().at("agree"), true) << outcome.out;
}

TEST_P(Gallery, HasAReport) {
  ASSERT_EQ(run({"run", model_of(GetParam()).string(), "-o", "run.h5"}).code, 0);
  ASSERT_EQ(run({"report", "run.h5", "-o", "page.html"}).code, 0);
  EXPECT_GT(app_test::fs::file_size(folder / "page.html"), 100'000u);
}

INSTANTIATE_TEST_SUITE_P(Examples, Gallery,
                         testing::Values("ball-cascade", "crank-train", "delta-robot", "double-wishbone",
                                         "robot", "rotor", "solar-array", "stewart-platform",
                                         "washing-machine", "wind-turbine"),
                         [](const auto& example) {
                           std::string name = example.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace mimbre::examples_test::gallery_test
