#include "mimbre/real_time_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "math/once/decompositions.h"
#include "mimbre/diagnostics.h"
#include "mimbre/reduced_body.h"
#include "support/models.h"

namespace mimbre::test::real_time_plan_test {
namespace {

RealTimePlanOptions quick() {
  RealTimePlanOptions options;
  options.deadline = 5e-3;
  options.end = 0.3;
  options.load = 1;
  options.watch = 0.2;
  options.modes = {1};
  options.divisors = {1, 2};
  options.loop.lock_memory = false;
  return options;
}

/// The lowest frequencies stay what they were.
TEST(WithLowestModes, KeepsTheLowest) {
  const spec::Model all = example("pendulum/flexible.yaml")->spec();
  const spec::Model few = with_lowest_modes(all, 2);
  int flexible = 0;
  for (std::size_t k = 0; k < all.bodies.size(); ++k) {
    if (!all.bodies[k].flexible) continue;
    ++flexible;
    const ReducedBody &before = *all.bodies[k].flexible, &after = *few.bodies[k].flexible;
    ASSERT_GT(before.modes, 2);
    ASSERT_EQ(after.modes, 2);
    const Eigen::VectorXd was = symmetric_eigenvalues(before.stiffness, before.mass_matrix),
                          is = symmetric_eigenvalues(after.stiffness, after.mass_matrix);
    EXPECT_NEAR(is[0], was[0], 1e-9 * was[1]);
    EXPECT_NEAR(is[1], was[1], 1e-9 * was[1]);
  }
  EXPECT_EQ(flexible, 1);
  EXPECT_EQ(with_lowest_modes(all, 1000).bodies[0].flexible, all.bodies[0].flexible);
}

/// Shorter steps are more accurate, and the errors are those against the fine run: of second order.
TEST(RealTimePlan, ErrorsFallWithTheStep) {
  RealTimePlanOptions options = quick();
  options.modes = {};
  options.run.formulation = spec::Simulation::Formulation::relative;
  const RealTimePlan plan = plan_real_time(example("double-four-bar/mechanism.yaml")->spec(), options);
  double coarse = 0, halved = 0;
  for (const RealTimeCandidate& c : plan.candidates)
    if (c.substeps == 1) (c.step == 5e-3 ? coarse : halved) = c.error;
  EXPECT_GT(coarse, 0);
  EXPECT_NEAR(std::log2(coarse / halved), 2, 0.5);
}

TEST(RealTimePlan, TheChosenOneKeepsTheDeadline) {
  const RealTimePlan plan = plan_real_time(example("pendulum/flexible.yaml")->spec(), quick());
  EXPECT_EQ(plan.candidates.size(), 2u * 2 * 2 * 2);  // formulations, modes, steps, parts
  ASSERT_GE(plan.chosen, 0);
  const RealTimeCandidate& chosen = plan.candidates[static_cast<std::size_t>(plan.chosen)];
  EXPECT_EQ(chosen.failure, "");
  EXPECT_GT(chosen.max_iterations, chosen.most_iterations);
  EXPECT_TRUE(plan.load <= 1 || plan.machine_late) << plan.load;
  EXPECT_GE(plan.watched->steps, 40);
  // Of a machine that has other work, those come first that have the most time left when it is late.
  const double late = plan.idle->latency.quantile(0.9999);
  const auto excess = [&](const RealTimeCandidate& c) { return std::max((c.p9999 + late) / c.step, 1.0); };
  for (const RealTimeCandidate& c : plan.candidates)
    EXPECT_TRUE(!c.failure.empty() || std::log10(excess(c)) > std::log10(excess(chosen)) ||
                std::log10(c.error) > std::log10(chosen.error) - 0.3);
}

/// A model's fixed cost is taken for what is proposed, unless it is not wanted.
TEST(RealTimePlan, AFixedCostIsProposedUnlessItIsTakenBack) {
  spec::Model model = example("pendulum/flexible.yaml")->spec();
  model.simulation.fixed_cost = true;
  RealTimePlanOptions options = quick();
  options.modes = {};
  const RealTimePlan plan = plan_real_time(model, options);
  EXPECT_EQ(plan.candidates.size(), 2u * 2);
  for (const RealTimeCandidate& c : plan.candidates) EXPECT_TRUE(c.fixed_cost || !c.failure.empty());
  options.run.fixed_cost = false;
  const RealTimePlan without = plan_real_time(model, options);
  EXPECT_EQ(without.candidates.size(), 2u * 2 * 2);
  for (const RealTimeCandidate& c : without.candidates) EXPECT_FALSE(c.fixed_cost);
}

TEST(RealTimePlan, SaysWhenNothingIsFastEnough) {
  RealTimePlanOptions options = quick();
  options.deadline = 1e-5;
  options.end = 1e-3;
  options.load = 0.05;
  const RealTimePlan plan = plan_real_time(example("iltis/vehicle.yaml")->spec(), options);
  EXPECT_EQ(plan.chosen, -1);
  for (const RealTimeCandidate& c : plan.candidates) EXPECT_NE(c.failure, "");
}

/// The end of a manoeuvre by an event is an end, and no failure.
TEST(RealTimePlan, AnEventMayEndTheManoeuvre) {
  const auto model = model_of(R"(
bodies:
  bar: {mass: 1, com: [0.5, 0, 0], inertia: [0.01, 0.1, 0.1]}
joints:
  hinge: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0]}
signals:
  angle: {joint: hinge}
events:
  down: {when: angle, crosses: 1, stop: true}
outputs:
  - {name: angle, joint: hinge}
simulation: {step: 0.005, end: 5}
)");
  RealTimePlanOptions options = quick();
  options.modes = {};
  options.end = 5;
  const RealTimePlan plan = plan_real_time(model->spec(), options);
  ASSERT_GE(plan.chosen, 0);
  EXPECT_GE(plan.watched->steps, 30);
}

TEST(RealTimePlan, RefusesWhatCannotBe) {
  const spec::Model model = example("pendulum/flexible.yaml")->spec();
  const auto refused = [&](auto&& change) {
    RealTimePlanOptions options = quick();
    change(options);
    EXPECT_THROW(plan_real_time(model, options), InputError);
  };
  refused([](auto& o) { o.deadline = 0; });
  refused([](auto& o) { o.deadline = 100; });
  refused([](auto& o) { o.load = 1.5; });
  refused([](auto& o) { o.watch = 0; });
}

}  // namespace
}  // namespace mimbre::test::real_time_plan_test
