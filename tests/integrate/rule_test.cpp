#include "integrate/rule.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/models.h"
#include "support/run.h"

namespace mimbre::test::rule_test {
namespace {

IntegratorOptions hht(double step, double rho) {
  IntegratorOptions o;
  o.step = step;
  o.rule = IntegratorOptions::Rule::hht;
  o.rho = rho;
  o.tolerance = 1e-9;
  return o;
}

TEST(Rule, CoefficientsOfHilberHughesAndTaylor) {
  for (const double rho : {0.5, 0.7, 1.0}) {
    const RuleCoefficients c = rule_coefficients(hht(0.01, rho));
    const double alpha = (1 - rho) / (1 + rho);
    EXPECT_EQ(c.alpha_m, 0);
    EXPECT_DOUBLE_EQ(c.alpha_f, alpha);
    EXPECT_DOUBLE_EQ(c.gamma, 0.5 + alpha);
    EXPECT_DOUBLE_EQ(c.beta, (1 + alpha) * (1 + alpha) / 4);
  }
  EXPECT_DOUBLE_EQ(rule_coefficients(hht(0.01, 0.1)).alpha_f, 1. / 3);
  // Without damping it is the trapezoidal rule.
  const RuleCoefficients a = rule_coefficients(hht(0.01, 1)), b = rule_coefficients(newmark(0.01));
  EXPECT_EQ(a.alpha_f, b.alpha_f);
  EXPECT_EQ(a.beta, b.beta);
  EXPECT_EQ(a.gamma, b.gamma);
}

/// A mass on a spring of 1 rad/s, without gravity.
constexpr const char* oscillator = R"(
gravity: [0, 0, 0]
bodies:
  block: {mass: 1, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}
joints:
  slide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0], position: 1, spring: {stiffness: 1}}
)";

TEST(Rule, HhtIsOfSecondOrder) {
  const auto model = model_of(oscillator);
  double error[2];
  for (int k = 0; k < 2; ++k) {
    const Outcome r = run(model, hht(0.02 / (1 << k), 0.6), 2);
    error[k] = std::abs(r.state.q[0] - std::cos(2.));
  }
  EXPECT_NEAR(std::log2(error[0] / error[1]), 2, 0.1);
}

/// Far above the step's frequency each step leaves the share ρ of an amplitude (in the long run: the root is
/// a multiple one); at ρ = 1 all of it.
TEST(Rule, HhtDampsHighFrequenciesByItsSpectralRadius) {
  const auto model = model_of(oscillator);
  for (const double rho : {0.5, 0.7, 1.0}) {
    const double h = 1e4;
    State s = initial_state(model);
    s.started = true;
    relative::RelativeSystem system(model->compiled());
    const auto stepper = make_stepper(system, spec::Simulation::Formalism::index3, hht(h, rho));
    double before = 0, after = 0;
    for (int k = 0; k < 400; ++k) {
      ASSERT_EQ(stepper->step(s).code, StepCode::ok);
      if (k == 199) before = std::abs(s.q[0]);
      if (k == 399) after = std::abs(s.q[0]);
    }
    EXPECT_NEAR(std::pow(after / before, 1. / 200), rho, 0.01) << rho;
  }
}

}  // namespace
}  // namespace mimbre::test::rule_test
