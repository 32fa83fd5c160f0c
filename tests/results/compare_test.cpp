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

/// A cubic is what it is between instants, at the ends of the series, too, and of a smooth channel little is
/// missing, less than is said.
TEST(Compare, InterpolatesTheFinerAtTheInstantsOfTheCoarser) {
  const auto cubic = [](double t) { return t * (t - 1) * (t - 2.5); };
  const Results coarse = series({"x"}, 0.05, 1, 3, cubic), fine = series({"x"}, 0, 0.1, 30, cubic);
  for (const auto& difference : {compare(coarse, fine).at(0), compare(fine, coarse).at(0)}) {
    EXPECT_LT(difference.max_difference, 1e-14);
    EXPECT_LT(difference.interpolation_error, 1e-12);
  }
  const auto wave = [](double t) { return std::sin(7 * t); };
  double last = 0;
  for (const double step : {0.03, 0.015, 0.0075}) {
    const auto d = compare(series({"x"}, 0, 0.05, 21, wave), series({"x"}, 0, step, 200, wave)).at(0);
    EXPECT_LT(d.max_difference,
              0.5 * std::pow(7 * step, 4) / 16);  // 3/128 h⁴ times the fourth derivative, in the middle
    EXPECT_LT(d.max_difference, d.interpolation_error);
    EXPECT_LT(d.interpolation_error, 0.6 * std::pow(7 * step, 4));
    EXPECT_NE(d.max_difference, last);
    last = d.max_difference;
  }
}

/// Falling bodies, written every 0.05 s and every 0.03 s.
TEST(Compare, TheSameMotionAtOtherInstantsIsTheSame) {
  const auto fall = [](double t) { return -4.905 * t * t; };
  const auto d = compare(series({"z"}, 0, 0.05, 5, fall), series({"z"}, 0, 0.03, 8, fall)).at(0);
  EXPECT_LT(d.max_difference, 1e-15);
  EXPECT_LT(d.interpolation_error, 1e-15);
}

/// Interpolated values stay within what stands beside a jump, however short the interval before it, and the
/// error that is said covers it.
TEST(Compare, NothingSwingsBesideAJump) {
  const auto step = [](double t) { return t < 1 ? 2.0 : 5.0; };
  const auto coarse_of = [](const auto& f) { return series({"x"}, 0.005, 0.1, 20, f); };
  const Results coarse = coarse_of(step);
  Results fine = series({"x"}, 0, 0.03, 70, step);
  const auto within = compare(coarse, fine).at(0);
  EXPECT_LE(within.max_difference, 3);
  EXPECT_LE(within.max_difference, within.interpolation_error);
  EXPECT_LT(within.interpolation_error, 5);
  // As an event has it: a row right before the jump, and one behind it.
  fine.time[33] = 1 - 1e-8;
  fine.time[34] = 1;
  fine.channels(34, 0) = 5;
  const auto between = compare(coarse, fine).at(0);
  EXPECT_EQ(between.max_difference, 0);
  EXPECT_EQ(between.interpolation_error, 0);
  const Results before = series({"x"}, 0.005, 0.1, 10, step);
  const auto apart = compare(before, series({"x"}, 0, 0.03, 70, step)).at(0);
  EXPECT_EQ(apart.max_difference, 0);
  // Also of a kink, wherever in its interval.
  for (const double at : {1.0, 1.005, 1.015, 1.02}) {
    const auto kink = [=](double t) { return std::abs(t - at); };
    const auto d = compare(coarse_of(kink), series({"x"}, 0, 0.03, 70, kink)).at(0);
    EXPECT_LE(d.max_difference, d.interpolation_error);
    EXPECT_LT(d.interpolation_error, 0.06);
  }
}

/// On instants of both there is nothing to interpolate, though they are sums of other steps.
TEST(Compare, CommonInstantsNeedNoInterpolation) {
  Results sums = series({"x"}, 0, 0.02, 51, [](double t) { return std::sin(9 * t); });
  double t = 0;
  for (int k = 0; k < 51; ++k, t += 0.02) sums.time[k] = t;
  const auto d = compare(sums, series({"x"}, 0, 0.1, 11, [](double s) { return std::sin(9 * s); })).at(0);
  EXPECT_EQ(d.interpolation_error, 0);
  EXPECT_LT(d.max_difference, 1e-14);
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
