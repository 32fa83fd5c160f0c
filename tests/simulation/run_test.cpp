#include "mimbre/run.h"

#include <gmock/gmock.h>

#include <cmath>

#include "mimbre/diagnostics.h"
#include "support/models.h"

namespace mimbre::test::run_test {
namespace {

using ::testing::ElementsAre;

std::vector<std::int64_t> rows(const RunPlan& plan) {
  std::vector<std::int64_t> list;
  for (std::int64_t k = 0; k < plan.steps;) list.push_back(k = plan.next_row(k));
  return list;
}

TEST(RunPlan, RowsAreTheFirstStepsAtOrAfterTheMultiples) {
  EXPECT_THAT(rows(plan_run(0.05, 0.01, 0.01)), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_THAT(rows(plan_run(0.05, 0.02, 0.01)), ElementsAre(2, 4, 5));
  // 12, 20, 32, 40, 50 ms.
  EXPECT_THAT(rows(plan_run(0.05, 0.01, 0.004)), ElementsAre(3, 5, 8, 10, 13));
  EXPECT_THAT(rows(plan_run(0.03, 0.001, 0.01)), ElementsAre(1, 2, 3));
  EXPECT_THAT(rows(plan_run(0.03, 0, 0.01)), ElementsAre(1, 2, 3));
  EXPECT_THAT(rows(plan_run(0.03, 5, 0.01)), ElementsAre(3));
  EXPECT_TRUE(rows(plan_run(0, 0.01, 0.01)).empty());
}

TEST(RunPlan, RowsDoNotDriftFromTheirMultiples) {
  const double step = 0.0007, interval = 0.01, end = 100;
  const RunPlan plan = plan_run(end, interval, step);
  std::int64_t multiple = 0;
  for (std::int64_t k = 0; plan.next_row(k) < plan.steps;) {
    k = plan.next_row(k);
    ++multiple;
    const double late = static_cast<double>(k) * step - static_cast<double>(multiple) * interval;
    ASSERT_GE(late, -1e-9);
    ASSERT_LT(late, step);
  }
  EXPECT_EQ(multiple, 9999);
}

TEST(RunPlan, TheRestOfAStepIsAStep) {
  EXPECT_EQ(plan_run(1, 0, 0.3).steps, 4);
  EXPECT_EQ(plan_run(0.9, 0, 0.3).steps, 3);
  EXPECT_EQ(plan_run(1, 0, 0.1).steps, 10);
  // But for what rounding leaves.
  EXPECT_EQ(plan_run(1, 0, 0.333333).steps, 3);
  EXPECT_EQ(plan_run(1, 0, 1.0001).steps, 1);
}

TEST(RunPlan, AStepLongerThanTheRunIsRefused) {
  EXPECT_THROW(plan_run(1, 0, 10), InputError);
  EXPECT_THROW(plan_run(1, 0, 1.01), InputError);
  EXPECT_NO_THROW(plan_run(1, 0, 1));
}

/// A run that ends at a multiple of its step ends at the same instant as the steps of a longer one, to the
/// last bit: 0.104 is not 52 · 0.002.
TEST(Run, EndsWhereLongerRunsPass) {
  const auto model = example("pendulum/flexible.yaml");
  RunOptions options;
  options.step = 0.002;
  Simulation whole(model, options), part(model, options);
  const RunPlan plan = plan_run(0.104, 0, 0.002);
  RunTotals totals;
  ASSERT_TRUE(advance(part, plan, plan.steps, totals).ok());
  for (int k = 0; k < 52; ++k) ASSERT_TRUE(whole.step().ok());
  EXPECT_EQ(part.time(), whole.time());
  EXPECT_NEAR(part.time(), 0.104, 1e-16);
  EXPECT_EQ(part.save().bytes(), whole.save().bytes());
}

/// An event that ends the run with a step's end has not cut that step short.
TEST(Run, CountsTheStepThatAnEventEnds) {
  const auto model = model_of(R"(
bodies: {ball: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {way: {type: prismatic, between: [ground, ball], at: [0, 0, 0], axis: [0, 0, 1]}}
events: {late: {when: t, crosses: 0.0995, stop: true}}
simulation: {step: 0.001, end: 1}
)");
  for (const bool fixed : {false, true}) {
    RunOptions options;
    options.fixed_cost = fixed;
    Simulation simulation(model, options);
    const RunPlan plan = plan_run(1, 0, 0.001);
    RunTotals totals;
    ASSERT_TRUE(advance(simulation, plan, plan.steps, totals).ok());
    EXPECT_TRUE(simulation.stopped());
    EXPECT_EQ(totals.steps, fixed ? 100 : 99);
    EXPECT_NEAR(simulation.time(), fixed ? 0.1 : 0.0995, 1e-9);
  }
}

/// The last step, shorter than the others, is as accurate as they are: the end is where a finer run comes to.
TEST(Run, EndsAtItsEnd) {
  const auto model = example("bricard/mechanism.yaml");
  for (const auto formulation :
       {spec::Simulation::Formulation::relative, spec::Simulation::Formulation::natural}) {
    const auto last = [&](double step) {
      RunOptions options;
      options.step = step;
      options.formulation = formulation;
      Simulation simulation(model, options);
      const RunPlan plan = plan_run(0.5, 0, step);
      RunTotals totals;
      const StepReport report = advance(simulation, plan, plan.steps, totals);
      EXPECT_TRUE(report.ok()) << simulation.explain(report);
      EXPECT_EQ(totals.steps, plan.steps);
      EXPECT_EQ(simulation.time(), 0.5);
      return simulation.save().q;
    };
    const Eigen::VectorXd exact = last(1e-4);
    const double coarse = (last(0.0023) - exact).norm(), fine = (last(0.00115) - exact).norm();
    EXPECT_LT(coarse, 1e-3 * exact.norm());
    EXPECT_NEAR(coarse / fine, 4, 0.4);
  }
}

}  // namespace
}  // namespace mimbre::test::run_test
