#include "simulation/start/drive_smoothness.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mimbre/simulation.h"
#include "support/models.h"

/// Drives that no step can follow.
namespace mimbre::test::drive_smoothness_test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Break of(const std::string& text, double end = 1) {
  return largest_break(Function::expression(text, "t"), end);
}

TEST(DriveSmoothness, JumpsAndKinksAreFoundWhereTheyAre) {
  const Break jump = of("t < 0.5123 ? 0 : 2"), kink = of("abs(t - 0.3)*3"),
              both = of("(t < 0.7 ? 0 : 1e-3) + abs(t - 0.3)");
  EXPECT_EQ(jump.kind, Break::Kind::jump);
  EXPECT_NEAR(jump.at, 0.5123, 1e-6);
  EXPECT_NEAR(jump.size, 2, 1e-6);
  EXPECT_EQ(kink.kind, Break::Kind::kink);
  EXPECT_NEAR(kink.at, 0.3, 1e-6);
  EXPECT_NEAR(kink.size, 6, 0.01);
  EXPECT_EQ(both.kind, Break::Kind::jump);
}

TEST(DriveSmoothness, SizeAndUnitsDoNotMatter) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    EXPECT_EQ(
        largest_break(Function::table({0, 1, 2}, {0, scale, 3 * scale}, Function::Interpolation::linear), 2)
            .kind,
        Break::Kind::kink);
    EXPECT_EQ(
        largest_break(Function::table({0, 1, 2}, {0, scale, 3 * scale}, Function::Interpolation::cubic), 2)
            .kind,
        Break::Kind::none);
    EXPECT_EQ(largest_break(Function::linear(scale), 2).kind, Break::Kind::none);
    EXPECT_EQ(largest_break(Function::constant(scale), 2).kind, Break::Kind::none);
  }
}

/// Sharp, but smooth; and laws whose acceleration jumps, which steps bear.
TEST(DriveSmoothness, SmoothLawsAreNone) {
  for (const char* law : {"0.5*sin(2*pi*t)", "tanh(1e4*(t - 0.4))", "1e-3*sin(2000*t) + 5*t", "t^2",
                          "exp(-50*t)", "t < 0.5 ? 0 : (t - 0.5)^2", "100*t", "t < 0.2 ? 2.5*t^2 : t - 0.1"})
    EXPECT_EQ(of(law).kind, Break::Kind::none) << law;
}

TEST(DriveSmoothness, RunsWarn) {
  const auto driven = [](const std::string& law) {
    return Simulation(
               model_of(
                   "bodies: {a: {mass: 1, com: [0.5, 0, 0], inertia: [1, 1, 1]}}\n"
                   "joints: {hinge: {type: revolute, between: [ground, a], at: [0, 0, 0], axis: [0, 1, 0], "
                   "drive: {position: " +
                   law + "}}}\n"))
        .warnings();
  };
  EXPECT_THAT(driven("\"t < 0.5 ? 0 : 1\""), ElementsAre(AllOf(HasSubstr("'hinge'"), HasSubstr("jumps"))));
  EXPECT_THAT(driven("{table: [[0, 0], [1, 1], [2, 0]]}"),
              ElementsAre(AllOf(HasSubstr("'hinge'"), HasSubstr("speed"), HasSubstr("t = 1 s"))));
  EXPECT_THAT(driven("{table: [[0, 0], [1, 1], [2, 0]], interpolation: cubic}"), IsEmpty());
  EXPECT_THAT(driven("\"0.5*sin(2*pi*t)\""), IsEmpty());
}

}  // namespace
}  // namespace mimbre::test::drive_smoothness_test
