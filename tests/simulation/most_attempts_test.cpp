#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "mimbre/simulation.h"
#include "support/models.h"

/// What a step may cost is known beforehand.
namespace mimbre::test::most_attempts_test {
namespace {

/// Balls that fall on a plate and on each other, each at another time, without damping: impacts in nearly
/// every step.
std::shared_ptr<const Model> rain(int balls) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(0, 1);
  std::string bodies, joints, spheres;
  for (int k = 0; k < balls; ++k) {
    bodies += fmt::format("  b{}: {{mass: 1, com: [0, {}, 0], inertia: [0.001, 0.001, 0.001]}}\n", k, k);
    joints += fmt::format(
        "  j{}: {{type: prismatic, between: [ground, b{}], at: [0, {}, 0], axis: [0, 0, 1], "
        "position: {:.3f}}}\n",
        k, k, k, 0.06 + 0.05 * place(random));
    spheres += fmt::format("{}{{on: b{}, at: [[0, {}, 0]], radius: 0.05}}", k > 0 ? ", " : "", k, k);
  }
  return model_of(fmt::format(R"(
bodies:
{}joints:
{}surfaces:
  plate: {{type: half_space, at: [0, 0, 0]}}
contacts:
  impacts: {{spheres: [{}], surfaces: plate, stiffness: 1e7, restitution: 0.9}}
)",
                              bodies, joints, spheres));
}

TEST(MostAttempts, BoundTheIterationsOfEveryStep) {
  for (const int balls : {1, 12})
    for (const int substeps : {1, 2, 4, 36, 100}) {
      RunOptions options;
      options.step = 0.02;
      options.substeps = substeps;
      options.max_iterations = 12;
      Simulation s(rain(balls), options);
      ASSERT_GE(s.most_attempts(), 1);
      // So that the bound is of use for a step that has to be ready in time.
      EXPECT_LE(s.most_attempts(), substeps == 1 ? 1 : 1 + 80 * std::max(16, substeps)) << substeps;
      int most = 0;
      for (int k = 0; k < (balls == 1 ? 60 : 25); ++k) {
        const StepReport report = s.step();
        if (!report.ok()) break;
        most = std::max(most, report.iterations);
        ASSERT_LE(report.iterations, s.most_attempts() * *options.max_iterations) << substeps;
      }
      EXPECT_GT(most, 0);
    }
}

/// Corrections that leap across bristles of a nanometre are searched along, within a bound too.
TEST(MostAttempts, BoundTheIterationsWhereFrictionSticks) {
  const auto model = model_of(four_bar_text({{"crank", ", velocity: 4"}}) + R"(
frictions:
  a: {joint: crank, torque: 0.2, sticking: 1e-10, static_ratio: 1.5}
  b: {joint: crank_pin, torque: 0.3, sticking: 1e-9, static_ratio: 1.3}
  c: {joint: rocker, torque: 0.2, sticking: 1e-10}
)");
  for (const int iterations : {10, 12, 30})
    for (const int substeps : {1, 4}) {
      RunOptions options;
      options.step = 0.01;
      options.substeps = substeps;
      options.max_iterations = iterations;
      Simulation s(model, options);
      int most = 0;
      for (int k = 0; k < 300; ++k) {
        const StepReport report = s.step();
        most = std::max(most, report.iterations);
        if (!report.ok()) break;
        // Of one attempt that nothing divides; with loops it is made twice at most.
        ASSERT_LE(report.iterations, s.most_attempts() * iterations) << substeps;
      }
      EXPECT_GT(most, 8);
    }
}

/// Overflowed from 36 on.
TEST(MostAttempts, GrowWithThePartsOnly) {
  const auto model = rain(1);
  for (int substeps = 2; substeps <= 100; ++substeps) {
    RunOptions options;
    options.substeps = substeps;
    const int attempts = Simulation(model, options).most_attempts();
    EXPECT_GT(attempts, substeps);
    EXPECT_LT(attempts, 64 * (substeps + 12));
  }
}

}  // namespace
}  // namespace mimbre::test::most_attempts_test
