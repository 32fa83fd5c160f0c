#include "simulation/describe/drive_limit.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/models.h"
#include "support/simulate.h"

/// What is said of runs whose drives ask for positions that the mechanism does not have.
namespace mimbre::test::drive_limit_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// A slider crank whose crank of 0.1 m is longer than its rod of 0.08 m: it turns up to asin 0.8.
std::string crank(const std::string& angle, const std::string& method = "") {
  return fmt::format(R"y(
bodies:
  crank: {{mass: 1, com: [0.05, 0, 0], inertia: [0.001, 0.001, 0.001]}}
  rod: {{mass: 1, com: [0.14, 0, 0], inertia: [0.001, 0.001, 0.001]}}
  piston: {{mass: 1, com: [0.18, 0, 0], inertia: [0.001, 0.001, 0.001]}}
joints:
  crank: {{type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 0, 1], drive: {{position: "{}"}}}}
  pin: {{type: revolute, between: [crank, rod], at: [0.1, 0, 0], axis: [0, 0, 1]}}
  eye: {{type: revolute, between: [rod, piston], at: [0.18, 0, 0], axis: [0, 0, 1]}}
  bore: {{type: prismatic, between: [ground, piston], at: [0.18, 0, 0], axis: [1, 0, 0]}}
simulation: {{step: 0.001, end: 2{}}}
)y",
                     angle, method);
}

class DriveLimit : public testing::TestWithParam<Formulation> {};
INSTANTIATE_TEST_SUITE_P(BothFormulations, DriveLimit,
                         testing::Values(Formulation::relative, Formulation::natural));

TEST_P(DriveLimit, IsNamedWithTheDrive) {
  const double limit = std::asin(0.8);
  Simulation s = simulation_of(crank("t"), GetParam());
  StepReport report;
  while (s.time() < 2 && (report = s.step()).ok()) {
  }
  ASSERT_EQ(report.code, StepReport::Code::not_converged);
  EXPECT_NEAR(s.time(), limit, 2e-3);
  EXPECT_THAT(s.explain(report), AllOf(HasSubstr("the drive of joint 'crank' cannot be followed there"),
                                       HasSubstr("`mimbre kinematics`"), Not(HasSubstr("smaller step")),
                                       Not(HasSubstr("determine a motion twice"))));
  EXPECT_EQ(s.explain(report), s.explain(report));
}

/// With a fixed cost the run goes on until the constraints have come apart.
TEST_P(DriveLimit, IsNamedWithAFixedCost) {
  RunOptions options;
  options.formulation = GetParam();
  options.fixed_cost = true;
  Simulation s(model_of(crank("t")), options);
  StepReport report;
  while (s.time() < 2 && (report = s.step()).ok()) {
  }
  ASSERT_FALSE(report.ok());
  EXPECT_THAT(s.explain(report), HasSubstr("the drive of joint 'crank' cannot be followed there"));
}

TEST(DriveLimits, AreWhereTheLoopsDoNotClose) {
  Simulation s = simulation_of(crank("t"), Formulation::relative);
  run_to(s, 0.92);
  const Simulation::Snapshot at = s.save();
  State state;
  state.time = at.time;
  state.q = at.q;
  state.v = at.v;
  state.a = at.a;
  state.z = at.z;
  state.u = at.u;
  const auto model = model_of(crank("t"));
  const Method method = resolve_method(model->spec().simulation, {});
  const double limit = std::asin(0.8);
  const auto of = [&](double t) { return explain_drive_limit(model->compiled(), method, state, t); };
  EXPECT_EQ(of(limit - 1e-4), "");
  EXPECT_EQ(of(0.921), "");
  EXPECT_THAT(of(limit + 1e-4), HasSubstr("'crank'"));
  EXPECT_THAT(of(limit + 0.01), HasSubstr("'crank'"));
}

/// A drive that can be followed is not blamed for a step that fails by itself.
TEST_P(DriveLimit, IsNotBlamedElsewhere) {
  Simulation s = simulation_of(crank("40*t - 4*sin(10*t)", ", max_iterations: 1, substeps: 1"), GetParam());
  StepReport report;
  while (s.time() < 0.2 && (report = s.step()).ok()) {
  }
  ASSERT_EQ(report.code, StepReport::Code::not_converged);
  EXPECT_LT(4.0 * (10 * s.time() - std::sin(10 * s.time())), 0.8);
  EXPECT_THAT(s.explain(report), AllOf(HasSubstr("smaller step"), Not(HasSubstr("cannot be followed"))));
}

}  // namespace
}  // namespace mimbre::test::drive_limit_test
