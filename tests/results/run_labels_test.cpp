#include "results/run_labels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mimbre::run_labels_test {
namespace {

using testing::ElementsAre;

ComparedRun run(const std::string& file, const std::string& options, const std::string& summary,
                double step = 0.01) {
  ComparedRun made;
  made.file = file;
  made.results.header.options_json = options;
  made.results.header.step = step;
  made.results.summary_json = summary;
  return made;
}

const std::string relative = R"({"formulation": "relative", "integrator": "newmark", "xi": 0.0})";

TEST(RunLabels, OnlyWhatDiffers) {
  EXPECT_THAT(results::run_labels({run("a.h5", R"({"set": {"length": "2", "mass": "1"}})", relative),
                                   run("b.h5", R"({"set": {"length": "3", "mass": "1"}})", relative, 0.005)}),
              ElementsAre("length=2, 10 ms", "length=3, 5 ms"));
}

TEST(RunLabels, TheMethodIsThatInForce) {
  EXPECT_THAT(results::run_labels(
                  {run("a.h5", "{}", relative),
                   run("b.h5", "{}",
                       R"({"formulation": "natural", "integrator": "generalized_alpha", "rho": 0.4})")}),
              ElementsAre("relative, newmark", "natural, generalized_alpha"));
}

TEST(RunLabels, AParameterSetInOneRunOnlyIsADifference) {
  EXPECT_THAT(results::run_labels({run("folder/base.h5", "{}", relative),
                                   run("b.h5", R"({"set": {"method": "linear"}})", relative)}),
              ElementsAre("base", "method=linear"));
}

TEST(RunLabels, ARunCutShortIsNotTakenForAnotherMethod) {
  EXPECT_THAT(results::run_labels({run("a.h5", R"({"set": {"k": "1"}})", relative),
                                   run("b.h5", R"({"set": {"k": "2"}})", "")}),
              ElementsAre("k=1", "k=2"));
  EXPECT_THAT(
      results::run_labels({run("a.h5", "", relative), run("b.h5", R"({"formulation": "natural"})", "")}),
      ElementsAre("relative", "natural"));
}

TEST(RunLabels, NoTwoAreAlike) {
  EXPECT_THAT(results::run_labels({run("a.h5", "", ""), run("a.h5", "", ""), run("b.h5", "", "")}),
              ElementsAre("a", "a (2)", "b"));
  const std::string one = R"({"set": {"k": "1"}})", two = R"({"set": {"k": "2"}})";
  EXPECT_THAT(results::run_labels({run("a.h5", one, ""), run("b.h5", two, ""), run("c.h5", one, "")}),
              ElementsAre("k=1 (a)", "k=2", "k=1 (c)"));
}

TEST(RunLabels, GivenOnesAreTakenAsTheyAre) {
  ComparedRun named = run("a.h5", R"({"set": {"k": "1"}})", "");
  named.label = "soft";
  EXPECT_THAT(results::run_labels({named, run("b.h5", "not JSON", "")}), ElementsAre("soft", "b"));
}

}  // namespace
}  // namespace mimbre::run_labels_test
