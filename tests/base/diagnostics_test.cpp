#include "mimbre/diagnostics.h"

#include <gtest/gtest.h>

namespace mimbre::diagnostics_test {
namespace {

TEST(Diagnostics, TextStartsWithThePlace) {
  EXPECT_EQ(to_string(Diagnostic{{"arm.yaml", 12, 7}, "no such body"}), "arm.yaml:12:7: no such body");
}

TEST(Diagnostics, WithoutAFileOnlyTheMessageRemains) {
  EXPECT_EQ(to_string(Diagnostic{{}, "no such body"}), "no such body");
}

TEST(Diagnostics, AFileWithoutLinesStillNamesTheFile) {
  EXPECT_EQ(to_string(Diagnostic{{"run.h5", 0, 0}, "truncated"}), "run.h5: truncated");
}

TEST(Diagnostics, ErrorCarriesEveryDiagnosticOnePerLine) {
  const InputError error({{{"a.yaml", 1, 2}, "first"}, {{"a.yaml", 3, 4}, "second"}});
  EXPECT_STREQ(error.what(), "a.yaml:1:2: first\na.yaml:3:4: second");
  ASSERT_EQ(error.diagnostics().size(), 2u);
  EXPECT_EQ(error.diagnostics()[1].mark.line, 3);
}

TEST(Diagnostics, ErrorOfOneMessage) {
  const InputError error(Mark{"a.yaml", 5, 6}, "only");
  EXPECT_STREQ(error.what(), "a.yaml:5:6: only");
  EXPECT_EQ(error.diagnostics().size(), 1u);
}

TEST(DidYouMean, NamesTheNearest) {
  const std::vector<std::string> candidates{"stiffness", "damping", "interpolation"};
  EXPECT_EQ(did_you_mean("stifness", candidates), " (did you mean 'stiffness'?)");
  EXPECT_EQ(did_you_mean("Damping", candidates), " (did you mean 'damping'?)");
  EXPECT_EQ(did_you_mean("dapming", candidates), " (did you mean 'damping'?)");
}

TEST(DidYouMean, PrefersTheSmallerDistance) {
  EXPECT_EQ(did_you_mean("bars", {"barred", "bar", "bard"}), " (did you mean 'bar'?)");
  EXPECT_EQ(did_you_mean("bodies", {"bodied", "bodies"}), " (did you mean 'bodies'?)");
}

TEST(DidYouMean, IsSilentWhenNothingIsNear) {
  EXPECT_EQ(did_you_mean("wheel", {"stiffness", "damping"}), "");
  EXPECT_EQ(did_you_mean("x", {"y", "z"}), "");
  EXPECT_EQ(did_you_mean("x", {}), "");
  EXPECT_EQ(did_you_mean("", {"a"}), "");
  EXPECT_EQ(did_you_mean(std::string(1000000, 'a'), {std::string(1000000, 'b')}), "");
}

}  // namespace
}  // namespace mimbre::diagnostics_test
