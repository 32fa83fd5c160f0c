#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "math/once/spline.h"

/// Splines of degree 5 against polynomials and sines.
namespace mimbre::test::spline_test {
namespace {

std::vector<double> grid(int count, double end, bool uneven) {
  std::vector<double> x;
  for (int k = 0; k < count; ++k)
    x.push_back(end * (k + (uneven && k % 2 == 1 ? 0.3 : 0)) / std::max(count - 1, 1));
  return x;
}

TEST(Spline, ReproducesPolynomials) {
  for (const int count : {1, 2, 3, 4, 5, 6, 7, 8, 30}) {
    const int degree = std::min(count - 1, 5);
    const std::vector<double> x = grid(count, 2, count > 3);
    std::vector<double> y;
    for (const double t : x) y.push_back(1 + std::pow(t, degree) - 2 * t);
    const Function f = quintic_function(quintic_spline(x, y, SplineEnds::not_a_knot));
    for (double t = 0; t < 1.9; t += 0.13) {
      const Jet jet = f.jet(t);
      if (count == 1) {
        EXPECT_EQ(jet.value, y[0]);
        continue;
      }
      const bool line = degree == 1;
      EXPECT_NEAR(jet.value, 1 + std::pow(t, degree) - 2 * t, 1e-11) << count;
      EXPECT_NEAR(jet.first, degree * std::pow(t, degree - 1) - 2, 1e-10) << count;
      EXPECT_NEAR(jet.second, line ? 0 : degree * (degree - 1) * std::pow(t, degree - 2), 1e-8) << count;
    }
  }
}

TEST(Spline, ApproachesASineWithTheSixthPowerOfTheInterval) {
  double errors[2], accelerations[2];
  for (int k = 0; k < 2; ++k) {
    const std::vector<double> x = grid(k == 0 ? 81 : 161, 4, false);
    std::vector<double> y;
    for (const double t : x) y.push_back(std::sin(3 * t));
    const Function f = quintic_function(quintic_spline(x, y, SplineEnds::not_a_knot));
    errors[k] = accelerations[k] = 0;
    for (double t = 0.5; t < 3.5; t += 0.0171) {
      errors[k] = std::max(errors[k], std::abs(f.value(t) - std::sin(3 * t)));
      accelerations[k] = std::max(accelerations[k], std::abs(f.second_derivative(t) + 9 * std::sin(3 * t)));
    }
  }
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 6, 0.5);
  EXPECT_NEAR(std::log2(accelerations[0] / accelerations[1]), 4, 0.5);
}

TEST(Spline, SmoothingHalvesASineOfItsPeriodAndLeavesLongOnes) {
  const std::vector<double> x = grid(2001, 20, false);
  for (const double period : {1.0, 0.5, 2.0, 0.25}) {
    std::vector<double> y;
    for (const double t : x) y.push_back(std::sin(2 * std::numbers::pi * t / period));
    const std::vector<double> f = smoothed(x, y, 1);
    const double share = 1 / (1 + std::pow(1 / period, 6));
    for (std::size_t k = 600; k < 1400; k += 7) EXPECT_NEAR(f[k], share * y[k], 2e-3) << period;
  }
  // Parabolas have no third derivative.
  std::vector<double> y;
  for (const double t : x) y.push_back(3 - t + 0.5 * t * t);
  const std::vector<double> f = smoothed(x, y, 5);
  for (std::size_t k = 0; k < x.size(); k += 11) EXPECT_NEAR(f[k], y[k], 1e-5);
}

}  // namespace
}  // namespace mimbre::test::spline_test
