#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mimbre/diagnostics.h"
#include "mimbre/run.h"
#include "mimbre/simulation.h"
#include "support/models.h"

/// How wrong a step's energy balance may be before the step is repeated in parts.
namespace mimbre::test::energy_tolerance_test {
namespace {

struct Course {
  std::int64_t repeated = 0;
  Eigen::VectorXd heights;  ///< of the wheel, m, every 0.01 s
};

/// A wheel on a road that drops under it.
std::shared_ptr<const Model> suspension() {
  return example("iltis/suspension.yaml", {{"arms", "rigid"}, {"links", "rigid"}, {"rods", "rigid"}});
}

Course course(const RunOptions& options) {
  Simulation s(suspension(), options);
  const int every = static_cast<int>(std::lround(0.01 / s.step_size()));
  Course found{0, Eigen::VectorXd(150)};
  ResultsRow row;
  for (Eigen::Index k = 0; k < 2 * found.heights.size(); ++k) {
    for (int step = 0; step < every; ++step) {
      const StepReport report = s.step();
      EXPECT_TRUE(report.ok());
      found.repeated += report.substeps > 1;
    }
    if (k < found.heights.size()) continue;
    s.sample(row);
    found.heights[k - found.heights.size()] = row.channels[1];
  }
  return found;
}

Course with(std::optional<double> tolerance) {
  RunOptions options;
  options.step = 0.01;
  options.rho = 0.3;
  options.energy_tolerance = tolerance;
  return course(options);
}

TEST(EnergyTolerance, DecidesWhichStepsAreRepeated) {
  RunOptions fine;
  fine.step = 0.0005;
  fine.rho = 0.3;
  fine.substeps = 1;
  const Eigen::VectorXd exact = course(fine).heights;
  const auto error = [&](const Course& c) { return (c.heights - exact).lpNorm<1>() / 150; };
  const Course preset = with({}), same = with(1e-4), strict = with(1e-6), loose = with(0.1);
  EXPECT_EQ(preset.heights, same.heights);
  EXPECT_EQ(preset.repeated, same.repeated);
  EXPECT_GT(strict.repeated, preset.repeated);
  EXPECT_GT(preset.repeated, loose.repeated);
  EXPECT_LT(error(strict), error(preset));
  EXPECT_LT(error(preset), error(loose));
}

/// The model's, unless a caller asks for another.
TEST(EnergyTolerance, IsAnOptionOfTheModelToo) {
  spec::Simulation given;
  EXPECT_EQ(resolve_method(given, {}).energy_tolerance, 1e-4);
  given.energy_tolerance = 1e-3;
  EXPECT_EQ(resolve_method(given, {}).energy_tolerance, 1e-3);
  RunOptions asked;
  asked.energy_tolerance = 1e-5;
  EXPECT_EQ(resolve_method(given, asked).energy_tolerance, 1e-5);
  asked.fixed_cost = true;
  EXPECT_THAT([&] { resolve_method(given, asked); },
              testing::ThrowsMessage<InputError>(
                  testing::HasSubstr("energy_tolerance is 1e-05, but fixed_cost makes each step once")));
}

}  // namespace
}  // namespace mimbre::test::energy_tolerance_test
