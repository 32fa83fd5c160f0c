#include "simulation/start/jumping_law.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compile/compiled.h"
#include "support/models.h"
#include "support/simulate.h"

/// What is said of steps that do not converge, where a law jumps with the motion.
namespace mimbre::test::jumping_law_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// A block of 1 kg on a slide, pushed at first, with more of the file.
std::string block(const std::string& more, double speed = 0.1) {
  return fmt::format(R"y(
gravity: [0, 0, 0]
bodies: {{block: {{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}}}
joints:
  slide: {{type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0], velocity: [{}]}}
outputs: [{{name: rate, joint_velocity: slide}}, {{name: place, joint: slide}}]
{})y",
                     speed, more);
}

/// What is said where it fails; empty: it does not, in 20 steps of 0.1 s.
std::string failure_of(const std::string& text, Formulation formulation) {
  Simulation s = simulation_of(text, formulation, 0.1);
  for (int k = 0; k < 20; ++k)
    if (const StepReport report = s.step(); !report.ok()) return s.explain(report);
  return {};
}

class JumpingLaw : public testing::TestWithParam<Formulation> {};
INSTANTIATE_TEST_SUITE_P(BothFormulations, JumpingLaw,
                         testing::Values(Formulation::relative, Formulation::natural));

TEST_P(JumpingLaw, IsNamedWhereItStopsTheIteration) {
  const std::string both = "alternate between both";
  EXPECT_THAT(
      failure_of(block("actuators: {brake: {joint: slide, force: \"-100*sign(rate)\"}}\n"), GetParam()),
      AllOf(HasSubstr("did not converge"), HasSubstr("the expression of 'brake' jumps with the motion"),
            HasSubstr("100"), HasSubstr(both)));
  EXPECT_THAT(failure_of(block("signals: {drag: \"rate > 0 ? -100 : 80\"}\n"
                               "actuators: {brake: {joint: slide, force: drag}}\n"),
                         GetParam()),
              AllOf(HasSubstr("signal 'drag' jumps with the motion"), HasSubstr("-100"), HasSubstr("80"),
                    HasSubstr("`frictions`")));
  EXPECT_THAT(
      failure_of(block("springs: {s: {between: [ground, block], at: [[-1, 0, 0], [0, 0, 0]], damping: "
                       "\"100*sign(v)\"}}\n"),
                 GetParam()),
      HasSubstr("spring 's' jumps with the motion"));
}

/// What is continuous, or jumps elsewhere, is not blamed for a step that fails by itself.
TEST_P(JumpingLaw, IsNotBlamedElsewhere) {
  const std::string steep =
      "simulation: {max_iterations: 2, substeps: 1}\n"
      "actuators: {push: {joint: slide, force: \"-1e3*(rate > 0 ? 2*rate : rate) - 1e5*place^3 + (place > 50 "
      "? 1 : 0)\"}}\n";
  EXPECT_THAT(failure_of(block(steep, 3), GetParam()),
              AllOf(HasSubstr("did not converge"), Not(HasSubstr("jumps"))));
}

/// What is said of a step does not depend on how often it is asked for, or on what is looked at meanwhile.
TEST_P(JumpingLaw, IsSaidAgain) {
  Simulation s = simulation_of(block("actuators: {brake: {joint: slide, force: \"-100*sign(rate)\"}}\n"),
                               GetParam(), 0.1);
  StepReport report;
  while (report.ok() && s.time() < 2) report = s.step();
  const std::string said = s.explain(report);
  EXPECT_THAT(said, HasSubstr("jumps with the motion"));
  channel(s, "rate");
  EXPECT_EQ(s.explain(report), said);
}

TEST(JumpingLaws, BetweenWhatTheyJump) {
  const auto model = model_of(block("actuators: {brake: {joint: slide, force: \"-100*sign(rate)\"}}\n"));
  const Compiled& m = model->compiled();
  SeenByLaws start{std::vector<double>(static_cast<std::size_t>(m.signals.slots), 0.0),
                   std::vector<double>(static_cast<std::size_t>(m.element_storage), 0.0)};
  SeenByLaws last = start;
  for (std::size_t k = static_cast<std::size_t>(m.signals.first_moving); k < start.signals.size(); ++k) {
    start.signals[k] = 0.02;
    last.signals[k] = 0.01;  // on the same side: the line beyond it goes through zero
  }
  EXPECT_EQ(jumping_law(m, start, last), "the expression of 'brake' jumps with the motion, from -100 to 100");
  for (double& value : last.signals) value = 0.04;  // away from it
  EXPECT_EQ(jumping_law(m, start, last), "the expression of 'brake' jumps with the motion, from 100 to -100");
  for (double& value : start.signals) value = 1;
  for (double& value : last.signals) value = 1.01;
  EXPECT_EQ(jumping_law(m, start, last), "");
}

}  // namespace
}  // namespace mimbre::test::jumping_law_test
