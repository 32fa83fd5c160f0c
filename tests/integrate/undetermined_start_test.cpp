#include <gtest/gtest.h>

#include "dynamics/relative/system.h"
#include "integrate/step_motion.h"
#include "support/models.h"
#include "support/probe.h"
#include "support/run.h"

/// The first step makes its own accelerations; where it cannot, the step says so.
namespace mimbre::test::undetermined_start_test {
namespace {

using Formalism = spec::Simulation::Formalism;

/// Of two hinges in line, one body between them has neither mass nor inertia; nothing drives it.
std::shared_ptr<const Model> undetermined() {
  return model_of(R"(
bodies:
  between: {mass: 0, com: [0, 0, 0], inertia: [0, 0, 0]}
  bar: {mass: 1, com: [0.5, 0, 0], inertia: [0.01, 0.1, 0.1]}
joints:
  one: {type: revolute, between: [ground, between], at: [0, 0, 0], axis: [0, 1, 0]}
  other: {type: revolute, between: [between, bar], at: [0, 0, 0], axis: [0, 1, 0]}
)");
}

State at_rest(const Compiled& m) {
  State s;
  s.q.setZero(m.positions);
  for (Eigen::VectorXd* x : {&s.v, &s.a, &s.algorithmic}) x->setZero(m.velocities);
  s.multipliers.setZero(m.equations);
  return s;
}

TEST(UndeterminedStart, IsReported) {
  const auto model = undetermined();
  relative::RelativeSystem system(model->compiled());
  State s = at_rest(model->compiled());
  system.begin_step(s.q.data());
  StepMotion motion(system, generalised_alpha(0.01, 0.4));
  StepStatus status;
  EXPECT_EQ(motion.begin(s, status), StepCode::singular);
  EXPECT_GE(status.coordinate, 0);
}

TEST(UndeterminedStart, FailsTheStepAndLeavesTheState) {
  const auto model = undetermined();
  for (const Formalism formalism :
       {Formalism::index3, Formalism::index1, Formalism::baumgarte, Formalism::penalty,
        Formalism::index1_augmented, Formalism::independent}) {
    relative::RelativeSystem system(model->compiled());
    const auto stepper = make_stepper(system, formalism, generalised_alpha(0.01, 0.4));
    State s = at_rest(model->compiled());
    const StepStatus status = stepper->step(s);
    EXPECT_EQ(status.code, StepCode::singular);
    EXPECT_GE(status.coordinate, 0);
    EXPECT_EQ(s.time, 0);
    EXPECT_FALSE(s.started);
  }
}

/// Loads of inertia stiffen a body by its accelerations, which follow from them. In far bent bodies that
/// depends on itself so much that inserting one into the other diverges; the equations of motion have a
/// solution.
TEST(Start, OfFarBentBodiesSolvesTheEquationsOfMotion) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    RandomOptions options;
    options.bodies = 4;
    options.flexible_share = 1;
    options.stiffening = fe::Stiffening::geometric_stiffness;
    const RandomMechanism mechanism = random_mechanism(seed, options);
    Probe p(mechanism.compiled());
    Random random(seed + 70);
    State s = at_rest(p.m);
    s.q = p.moved(mechanism.q, random_increment(p.m, random, 3));
    s.v = random_increment(p.m, random, 1);
    p.system.begin_step(s.q.data());
    StepMotion motion(p.system, generalised_alpha(1e-8, 1));  // so short that stiffness plays no part
    StepStatus status;
    ASSERT_EQ(motion.begin(s, status), StepCode::ok);
    EXPECT_LT(p.residual(s.q, s.v, motion.start_a).norm(), 1e-6 * p.residual(s.q, s.v, p.zero).norm());
  }
}

}  // namespace
}  // namespace mimbre::test::undetermined_start_test
