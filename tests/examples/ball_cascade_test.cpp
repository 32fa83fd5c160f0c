#include <cmath>
#include <string>

#include "examples/example.h"

/// examples/ball-cascade against the impacts of balls, one after the other: momentum and restitution.
namespace mimbre::examples_test::ball_cascade_test {
namespace {

class BallCascade : public ExampleTest, public testing::WithParamInterface<std::pair<double, double>> {};

/// Of an impact on a ball at rest, of `ratio` times the mass, the shares of the speed that it takes and that
/// are left. Where it takes more than there was, no ball comes after one that it has hit: there are nine
/// impacts and no more.
TEST_P(BallCascade, PassesOnWhatMomentumAndRestitutionSay) {
  const auto [ratio, bounce] = GetParam();
  const Table run = run_example("ball-cascade", {"--set", "ratio=" + std::to_string(ratio), "--set",
                                                 "bounce=" + std::to_string(bounce), "--until", "0.03"});
  const double taken = (1 + bounce) / (1 + ratio), left = (1 - bounce * ratio) / (1 + ratio);
  double speed = 1;
  for (int ball = 0; ball < 10; ++ball) {
    const double last = run["b" + std::to_string(ball) + ".v"].tail(1)[0];
    EXPECT_NEAR(last, ball < 9 ? speed * left : speed, 0.01 * speed) << ball;
    speed *= taken;
  }
  EXPECT_LT((run["momentum"] - 2).abs().maxCoeff(), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Balls, BallCascade,
                         testing::Values(std::pair{0.6, 0.9}, std::pair{0.6, 1.0}, std::pair{0.5, 0.8}),
                         [](const auto& test) { return "of" + std::to_string(test.index); });

}  // namespace
}  // namespace mimbre::examples_test::ball_cascade_test
