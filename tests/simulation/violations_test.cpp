#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mimbre/simulation.h"
#include "simulation/describe/explain.h"
#include "simulation/describe/names.h"
#include "simulation/step/mechanism.h"
#include "support/models.h"

/// Violations of lengths and of angles are two numbers with their units.
namespace mimbre::test::violations_test {
namespace {

using Formulation = spec::Simulation::Formulation;
using testing::HasSubstr;

/// Two pendulums of size L whose angles a gear ties and whose ends a rod, and a slide that a rack moves.
std::shared_ptr<const Model> geared(double length) {
  return model_of(fmt::format(R"(
parameters: {{L: {:.17g}}}
gravity: [0, 0, -9.81*L]
bodies:
  a: {{mass: 1, com: [0.5*L, 0, 0], inertia: [0.01*L^2, 0.1*L^2, 0.1*L^2]}}
  b: {{mass: 2, com: [0.5*L, L, 0], inertia: [0.01*L^2, 0.1*L^2, 0.1*L^2]}}
  c: {{mass: 1, com: [L, 2*L, 0], inertia: [0.01*L^2, 0.1*L^2, 0.1*L^2]}}
  slide: {{mass: 1, com: [0, 0, 0], inertia: [0.01*L^2, 0.01*L^2, 0.01*L^2]}}
joints:
  ja: {{type: revolute, between: [ground, a], at: [0, 0, 0], axis: [0, 1, 0], velocity: 1}}
  jb: {{type: revolute, between: [ground, b], at: [0, L, 0], axis: [0, 1, 0]}}
  jc: {{type: spherical, between: [ground, c], at: [0, 2*L, 0]}}
  js: {{type: prismatic, between: [ground, slide], at: [0, 0, 0], axis: [1, 0, 0]}}
constraints:
  gear: {{type: coupling, terms: [{{joint: ja, factor: 1}}, {{joint: jb, factor: -0.5}}]}}
  rack: {{type: rack, joints: [ja, js], radius: 0.1*L}}
  rod: {{type: distance, between: [b, c], at: [[L, L, 0], [L, 2*L, 0.2*L]]}}
)",
                              length));
}

StepReport largest_of(const std::shared_ptr<const Model>& model, Formulation formulation,
                      spec::Simulation::Formalism formalism, int steps = 60) {
  RunOptions options;
  options.step = 0.01;
  options.formulation = formulation;
  options.formalism = formalism;
  Simulation s(model, options);
  StepReport most;
  for (int k = 0; k < steps; ++k) {
    const StepReport report = s.step();
    if (!report.ok()) {
      ADD_FAILURE() << s.explain(report);
      break;
    }
    most.raise(report);
    // The channels are of the last step.
    EXPECT_EQ(s.value(s.channel("solver.position_violation")), report.position_violation);
    EXPECT_EQ(s.value(s.channel("solver.angle_violation")), report.angle_violation);
    EXPECT_EQ(s.value(s.channel("solver.velocity_violation")), report.velocity_violation);
    EXPECT_EQ(s.value(s.channel("solver.angular_velocity_violation")), report.angular_velocity_violation);
  }
  return most;
}

/// A penalty alone leaves what the constraint forces are over it: of a mechanism a thousand times as large
/// lengths are that much more off, angles are not.
TEST(Violations, OfLengthsGrowWithTheSizeAndThoseOfAnglesDoNot) {
  constexpr auto penalty = spec::Simulation::Formalism::penalty;
  for (const Formulation formulation : {Formulation::relative, Formulation::natural}) {
    const StepReport unit = largest_of(geared(1), formulation, penalty);
    EXPECT_GT(unit.position_violation, 1e-12);
    EXPECT_GT(unit.angle_violation, 1e-12);
    EXPECT_GT(unit.velocity_violation, 1e-12);
    EXPECT_GT(unit.angular_velocity_violation, 1e-12);
    for (const double length : {1e-3, 1e3}) {
      const StepReport r = largest_of(geared(length), formulation, penalty);
      EXPECT_NEAR(r.position_violation / (length * unit.position_violation), 1, 1e-3) << length;
      EXPECT_NEAR(r.velocity_violation / (length * unit.velocity_violation), 1, 1e-3) << length;
      EXPECT_NEAR(r.angle_violation / unit.angle_violation, 1, 1e-3) << length;
      EXPECT_NEAR(r.angular_velocity_violation / unit.angular_velocity_violation, 1, 1e-3) << length;
    }
  }
}

/// Each equation's own, with its unit: of a gear, a rack, a rod, a joint that was cut, a drive, a body that
/// must stay rigid.
TEST(Violations, MessagesHaveTheUnitOfTheEquation) {
  const auto model = model_of(R"(
bodies:
  a: {mass: 1, com: [0.5, 0, 0], inertia: [0.01, 0.1, 0.1]}
  b: {mass: 1, com: [1, 0, 0.5], inertia: [0.1, 0.1, 0.01]}
  c: {mass: 1, com: [0, 1, 0], inertia: [0.1, 0.1, 0.1]}
joints:
  ja: {type: revolute, between: [ground, a], at: [0, 0, 0], axis: [0, 1, 0]}
  jb: {type: revolute, between: [a, b], at: [1, 0, 0], axis: [0, 1, 0]}
  cut: {type: revolute, between: [ground, b], at: [1, 0, 1], axis: [0, 1, 0], cut: always}
  driven: {type: cylindrical, between: [ground, c], at: [0, 1, 0], axis: [0, 0, 1], drive: [{coordinate: 0, position: "t"}, {coordinate: 1, position: "t"}]}
)");
  const auto geared_model = geared(1);
  for (const auto& m : {model, geared_model})
    for (const Formulation formulation : {Formulation::relative, Formulation::natural}) {
      RunOptions options;
      options.formulation = formulation;
      Simulation s(m, options);
      const Mechanism mechanism(m->compiled(), s.method());
      int lengths = 0, angles = 0;
      for (int k = 0; k < s.constraints(); ++k) {
        StepReport report;
        report.code = StepReport::Code::drifted;
        report.equation = k;
        report.equation_violation = 0.03;
        report.position_violation = 7;
        const std::string text = s.explain(report);
        const std::string name = equation_name(m->compiled(), mechanism.natural.get(), k);
        const bool length = text.find("is off by 0.03 m;") != std::string::npos;
        EXPECT_TRUE(length || text.find("is off by 0.03 rad;") != std::string::npos) << text;
        (length ? lengths : angles) += 1;
        for (const char* of_angle : {"'gear'", "rigidity"})
          if (name.find(of_angle) != std::string::npos) {
            EXPECT_FALSE(length) << text;
          }
        for (const char* of_length : {"'rack'", "'rod'"})
          if (name.find(of_length) != std::string::npos) {
            EXPECT_TRUE(length) << text;
          }
      }
      EXPECT_GT(lengths, 0);
      EXPECT_GT(angles, 0);
    }
}

/// Lengths and angles are never one number.
TEST(Violations, OfStaticsHaveTheirUnits) {
  const auto model = geared(1);
  StaticsStatus status;
  status.coordinate = 0;
  status.residual = 5;
  EXPECT_THAT(explain_imbalance(model->compiled(), nullptr, status), testing::Not(HasSubstr(" off by ")));
  status.position_violation = 0.25;
  status.angle_violation = 0.5;
  EXPECT_THAT(explain_imbalance(model->compiled(), nullptr, status),
              testing::AllOf(HasSubstr("lengths off by 0.25 m"), HasSubstr("angles off by 0.5 rad")));
}

/// What a formalism without stabilisation lets drift is reported with the equation that is off most.
TEST(Violations, TheWorstEquationIsNamed) {
  RunOptions options;
  options.step = 0.02;
  options.formalism = spec::Simulation::Formalism::index1;
  Simulation s(geared(1), options);
  StepReport report;
  for (int k = 0; k < 20000 && report.ok(); ++k) report = s.step();
  ASSERT_EQ(report.code, StepReport::Code::drifted);
  ASSERT_GE(report.equation, 0);
  EXPECT_GT(report.equation_violation, 0);
  const bool angle = s.explain(report).find(" rad;") != std::string::npos;
  EXPECT_EQ(report.equation_violation, angle ? report.angle_violation : report.position_violation);
}

}  // namespace
}  // namespace mimbre::test::violations_test
