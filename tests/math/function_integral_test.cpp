#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mimbre/function.h"

/// Functions that are given by their derivative, against closed forms.
namespace mimbre::test::function_integral_test {
namespace {

using std::numbers::pi;

TEST(FunctionIntegral, OfManyPeriods) {
  const double w = 2 * pi * 10;
  const Function f = Function::expression("sin(2*pi*10*t)", "t").integral(0.3, 20);
  for (double t = 0; t < 20; t += 0.0371)
    EXPECT_NEAR(f.value(t), 0.3 + (1 - std::cos(w * t)) / w, 3e-12) << t;
  // Beyond the end, and before the start.
  EXPECT_NEAR(f.value(57.3), 0.3 + (1 - std::cos(w * 57.3)) / w, 1e-10);
  EXPECT_NEAR(f.value(-0.02), 0.3 + (1 - std::cos(w * 0.02)) / w, 1e-12);
}

TEST(FunctionIntegral, OfKinksAndJumps) {
  const Function kink = Function::expression("abs(t - 0.3)", "t").integral(0, 1),
                 jump = Function::expression("t < 0.3 ? 1 : 3", "t").integral(0, 1);
  for (double t = 0; t <= 1; t += 0.01) {
    const double past = std::max(0.0, t - 0.3), before = std::min(t, 0.3);
    EXPECT_NEAR(kink.value(t), 0.3 * before - before * before / 2 + past * past / 2, 1e-13) << t;
    EXPECT_NEAR(jump.value(t), before + 3 * past, 1e-13) << t;
  }
}

TEST(FunctionIntegral, IsExactForPieces) {
  const Function ramp =
      Function::table({0, 1, 2}, {0, 4, 0}, Function::Interpolation::linear).integral(-1, 0.5);
  EXPECT_DOUBLE_EQ(ramp.value(0), -1);
  EXPECT_DOUBLE_EQ(ramp.value(1), 1);
  EXPECT_DOUBLE_EQ(ramp.value(2), 3);
  EXPECT_DOUBLE_EQ(ramp.value(1.5), -1 + 2 + 1.5);
  EXPECT_DOUBLE_EQ(Function::constant(7).integral(2, 1).value(100), 702);
  EXPECT_DOUBLE_EQ(Function().integral(2, 1).value(3), 2);
}

TEST(FunctionIntegral, HasTheFunctionAsItsDerivative) {
  const Function law = Function::expression("exp(-t)*cos(3*t)", "t"), f = law.integral(5, 2);
  for (double t = 0.1; t < 2; t += 0.17) {
    EXPECT_EQ(f.derivative(t), law.value(t));
    EXPECT_EQ(f.second_derivative(t), law.derivative(t));
    EXPECT_NEAR((f.value(t + 1e-4) - f.value(t - 1e-4)) / 2e-4, law.value(t), 1e-7);
    // ∫ (5 + (e^{−s}(3 sin 3s − cos 3s) + 1)/10) ds, by Simpson's rule.
    double sum = 0;
    for (int k = 0; k < 200; ++k) {
      const double h = t / 200, a = k * h;
      sum += h / 6 * (f.value(a) + 4 * f.value(a + h / 2) + f.value(a + h));
    }
    EXPECT_NEAR(f.antiderivative(t), sum, 1e-10);
    EXPECT_NEAR(f.value(t), 5 + (std::exp(-t) * (3 * std::sin(3 * t) - std::cos(3 * t)) + 1) / 10, 1e-13);
  }
}

TEST(FunctionIntegral, OfWhatIsNotFiniteIsNotFinite) {
  const Function f = Function::expression("sqrt(1 - t)", "t").integral(0, 4);
  EXPECT_NEAR(f.value(0.75), 2. / 3 * (1 - 0.125), 1e-13);
  EXPECT_TRUE(std::isnan(f.value(3)));
  EXPECT_TRUE(std::isnan(f.value(std::nan(""))));
}

}  // namespace
}  // namespace mimbre::test::function_integral_test
