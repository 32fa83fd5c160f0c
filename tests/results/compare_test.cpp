#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mimbre/diagnostics.h"
#include "mimbre/results.h"

namespace mimbre::compare_test {
namespace {

/// Channels `names`, all with the values f(t) at t = start, start + step, …
template <class F>
Results series(const std::vector<std::string>& names, double start, double step, int count, F f) {
  Results results;
  for (const std::string& name : names) results.header.channels.push_back({name, "m", ""});
  results.time.resize(count);
  results.channels.resize(count, static_cast<Eigen::Index>(names.size()));
  for (int i = 0; i < count; ++i) {
    results.time[i] = start + step * i;
    results.channels.row(i).setConstant(f(results.time[i]));
  }
  return results;
}

TEST(Compare, TheSameDiffersNowhere) {
  const Results a = series({"x", "y"}, 0, 0.1, 11, [](double t) { return std::sin(t); });
  const auto differences = compare(a, a);
  ASSERT_EQ(differences.size(), 2u);
  EXPECT_EQ(differences[1].name, "y");
  EXPECT_EQ(differences[1].max_difference, 0);
  EXPECT_EQ(differences[1].mean_difference, 0);
  EXPECT_EQ(differences[1].amplitude, std::sin(1.0));
}

TEST(Compare, FindsTheLargestDifferenceAndItsTime) {
  const Results a = series({"x"}, 0, 1, 4, [](double) { return -2; });
  Results b = a;
  b.channels(1, 0) = -2.5;
  b.channels(2, 0) = 1;
  const auto difference = compare(a, b).at(0);
  EXPECT_EQ(difference.max_difference, 3);
  EXPECT_EQ(difference.at_time, 2);
  EXPECT_EQ(difference.mean_difference, 3.5 / 4);
  EXPECT_EQ(difference.amplitude, 2);
}

TEST(Compare, PairsChannelsByName) {
  const Results a = series({"only a", "x", "y"}, 0, 1, 3, [](double t) { return t; });
  Results b = series({"y", "only b", "x"}, 0, 1, 3, [](double t) { return t; });
  b.channels.col(0).array() += 5;
  const auto differences = compare(a, b);
  ASSERT_EQ(differences.size(), 2u);
  EXPECT_EQ(differences[0].name, "x");
  EXPECT_EQ(differences[0].max_difference, 0);
  EXPECT_EQ(differences[1].name, "y");
  EXPECT_EQ(differences[1].max_difference, 5);
}

TEST(Compare, LeavesOutWhatHasOtherUnits) {
  const Results a = series({"x", "y"}, 0, 1, 3, [](double t) { return t; });
  Results b = a;
  b.header.channels[0].unit = "m/s";
  const auto differences = compare(a, b);
  ASSERT_EQ(differences.size(), 1u);
  EXPECT_EQ(differences[0].name, "y");
}

TEST(Compare, InterpolatesTheFinerAtTheInstantsOfTheCoarser) {
  // Between instants the fine series is a chord of t²; the coarse instants lie in the middle of chords.
  const auto square = [](double t) { return t * t; };
  const Results coarse = series({"x"}, 0.05, 1, 3, square), fine = series({"x"}, 0, 0.1, 30, square);
  for (const auto& difference : {compare(coarse, fine).at(0), compare(fine, coarse).at(0)}) {
    EXPECT_NEAR(difference.max_difference, 0.05 * 0.05, 1e-14);
    EXPECT_NEAR(difference.mean_difference, 0.05 * 0.05, 1e-14);
  }
}

TEST(Compare, UsesTheCommonTimeOnly) {
  const Results a = series({"x"}, 0, 1, 5, [](double t) { return t; });
  Results b = series({"x"}, 2, 1, 5, [](double t) { return t; });
  b.channels(3, 0) = 100;  // at t = 5, which A has not
  EXPECT_EQ(compare(a, b).at(0).max_difference, 0);
  EXPECT_EQ(compare(b, a).at(0).max_difference, 0);
}

TEST(Compare, RoundedEndTimesStillMatch) {
  const Results a = series({"x"}, 0, 0.1, 11, [](double t) { return t < 0.95 ? 0 : 1; });
  Results b = a;
  b.time[10] = std::nextafter(b.time[10], 0);
  b.channels(10, 0) = 3;
  EXPECT_NEAR(compare(a, b).at(0).max_difference, 2, 1e-9);
}

TEST(Compare, ASingleInstantCanBeCompared) {
  const Results a = series({"x"}, 1, 1, 1, [](double) { return 4; });
  const Results b = series({"x"}, 0, 0.5, 5, [](double t) { return t; });
  EXPECT_EQ(compare(a, b).at(0).max_difference, 3);
  EXPECT_EQ(compare(a, a).at(0).max_difference, 0);
}

TEST(Compare, NotANumberShows) {
  const Results a = series({"x"}, 0, 1, 4, [](double) { return 1; });
  Results b = a;
  b.channels(2, 0) = std::nan("");
  const auto difference = compare(a, b).at(0);
  EXPECT_TRUE(std::isnan(difference.max_difference));
  EXPECT_EQ(difference.at_time, 2);
  EXPECT_EQ(compare(b, b).at(0).max_difference, 0);
}

TEST(Compare, WithoutCommonTimeIsAnError) {
  const auto one = [](double) { return 1; };
  EXPECT_THROW(compare(series({"x"}, 0, 1, 3, one), series({"x"}, 5, 1, 3, one)), InputError);
  EXPECT_THROW(compare(series({"x"}, 0, 1, 3, one), series({"x"}, 0, 1, 0, one)), InputError);
  EXPECT_THROW(compare(series({"x"}, 0, -1, 3, one), series({"x"}, 0, 1, 3, one)), InputError);
}

}  // namespace
}  // namespace mimbre::compare_test
