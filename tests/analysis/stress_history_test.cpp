#include "mimbre/stress_history.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mimbre::test::stress_history_test {
namespace {

/// Points in a row; mode 0 pulls along x, growing along the row, mode 1 shears the first point alone.
BodyDrawing row_of_points() {
  BodyDrawing body;
  constexpr int n = 11;
  body.modes = 2;
  body.points = Eigen::Matrix3Xd::Zero(3, n);
  body.stress = Eigen::MatrixXd::Zero(6 * n, 2);
  for (int k = 0; k < n; ++k) {
    body.points(0, k) = 0.1 * k;
    body.stress(6 * k, 0) = 1e6 * (k + 1);
  }
  body.stress(3, 1) = 1e7;
  return body;
}

TEST(StressHistory, FindsTheLargestOfEachPointAndSpotsApart) {
  const BodyDrawing body = row_of_points();
  constexpr int instants = 1000;
  Eigen::VectorXd time(instants);
  Eigen::MatrixXd y(instants, 2);
  for (int k = 0; k < instants; ++k) {
    time[k] = 0.01 * k;
    y(k, 0) = std::sin(0.01 * k);    // largest at t = π/2
    y(k, 1) = k == 700 ? 2.0 : 0.0;  // at t = 7
  }
  const StressHistory h = stress_history(body, time, y, 3, 0.35);
  EXPECT_NEAR(h.envelope[5], 6e6, 100);
  ASSERT_EQ(h.spots.size(), 3u);
  EXPECT_EQ(h.spots[0].node, 0);
  EXPECT_EQ(h.spots[0].time, 7);
  const double pull = 1e6 * std::sin(7.0), shear = 2e7;
  EXPECT_NEAR(h.spots[0].von_mises, std::hypot(pull, std::sqrt(3.0) * shear), 1);
  EXPECT_NEAR(h.spots[0].stress[3], shear, 1e-3);
  EXPECT_EQ(h.spots[1].node, 10);
  EXPECT_NEAR(h.spots[1].time, 1.57, 1e-9);
  EXPECT_EQ(h.spots[2].node, 6);  // four tenths from the one before
}

}  // namespace
}  // namespace mimbre::test::stress_history_test
