#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mimbre/simulation.h"
#include "support/models.h"

/// Which states a run with error control warns of.
namespace mimbre::test::accuracy_limits_test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A mass of 1 kg on a bushing of 100 N/m that starts at 1 m/s.
std::string mass_on(const std::string& more) {
  return R"yaml(
gravity: [0, 0, 0]
bodies: {a: {mass: 1, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}}
joints: {j: {type: floating, between: [ground, a], velocity: [1, 0, 0, 0, 0, 0]}}
bushings: {b: {between: [ground, a], at: [0, 0, 0], stiffness: [100, 100, 100, 1, 1, 1])yaml" +
         more + R"yaml(}}
outputs: [{name: x, position: a, component: x}]
simulation: {step: 0.01, end: 1, integrator: {type: radau, accuracy: 1e-10}}
)yaml";
}

std::string warnings_of(Simulation& s) {
  std::string all;
  for (const std::string& text : s.warnings()) all += text + "\n";
  return all;
}

/// A bushing counts turns, which is no integration: x = sin(10 t)/10.
TEST(AccuracyLimits, DoNotNameBushingsWithoutBranches) {
  Simulation s(model_of(mass_on("")));
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(s.step().ok());
  EXPECT_NEAR(s.value(s.channel("x")), std::sin(10.0) / 10, 1e-10);
  EXPECT_THAT(warnings_of(s), Not(HasSubstr("accuracy does not cover")));
}

TEST(AccuracyLimits, NameBushingsWithBranches) {
  Simulation s(model_of(mass_on(", maxwell: [{stiffness: [50, 50, 50, 1, 1, 1], relaxation: 0.1}]")));
  EXPECT_THAT(warnings_of(s), HasSubstr("accuracy does not cover"));
  EXPECT_THAT(warnings_of(s), HasSubstr("bushing 'b'"));
}

}  // namespace
}  // namespace mimbre::test::accuracy_limits_test
