#include "mimbre/timings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace mimbre::timings_test {
namespace {

TEST(Timings, NothingMeasured) {
  const Timings timings;
  EXPECT_EQ(timings.count(), 0);
  EXPECT_EQ(timings.quantile(0.5), 0);
  EXPECT_EQ(timings.worst(), 0);
  EXPECT_EQ(timings.mean(), 0);
}

TEST(Timings, QuantilesAreThoseOfTheSortedTimes) {
  std::mt19937 random(3);
  std::lognormal_distribution<double> any(std::log(3e-4), 1.5);
  std::vector<double> all(20'000);
  Timings timings;
  for (double& t : all) timings.add(t = any(random));
  std::sort(all.begin(), all.end());
  for (const double share : {0.001, 0.25, 0.5, 0.99, 0.9999, 1.0}) {
    const double right = all[static_cast<std::size_t>(std::ceil(share * 20'000)) - 1];
    EXPECT_GE(timings.quantile(share), right * (1 - 1e-9)) << share;
    EXPECT_LE(timings.quantile(share), right * 1.0101) << share;
  }
  EXPECT_EQ(timings.worst(), all.back());
  EXPECT_NEAR(timings.mean(), std::accumulate(all.begin(), all.end(), 0.0) / 20'000, 1e-12);
}

TEST(Timings, CountsBetweenEdges) {
  Timings timings;
  for (const double t : {0.0, 5e-7, 5e-6, 5e-6, 5e-5, 2.0, 1e9}) timings.add(t);
  const std::vector<double> edges{1e-7, 1e-6, 1e-5, 1e-4};
  EXPECT_EQ(timings.between(edges), (std::vector<std::int64_t>{1, 2, 1}));
  EXPECT_EQ(timings.worst(), 1e9);
  EXPECT_EQ(timings.quantile(1), 1e9);
  EXPECT_EQ(timings.count(), 7);
}

}  // namespace
}  // namespace mimbre::timings_test
