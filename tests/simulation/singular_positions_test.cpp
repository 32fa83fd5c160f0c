#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mimbre/simulation.h"
#include "support/models.h"

/// Mechanisms that go through positions where their constraints lose rank: on the branch that momentum leads
/// to, and as accurate as without them.
namespace mimbre::test::singular_positions_test {
namespace {

using Formulation = spec::Simulation::Formulation;
constexpr double pi = std::numbers::pi;

/// A row of four-bars (IFToMM benchmark A02): links of 1 m and 1 kg; all couplers lie in one line twice a
/// turn.
std::string row_of_four_bars(int loops) {
  std::string text = "gravity: [0, -9.81, 0]\nbodies:\n", joints = "joints:\n";
  for (int k = 0; k <= loops; ++k) {
    text += fmt::format("  u{0}: {{mass: 1, com: [{0}, 0.5, 0], inertia: [1/12, 1e-4, 1/12]}}\n", k);
    joints += fmt::format(
        "  A{0}: {{type: revolute, between: [ground, u{0}], at: [{0}, 0, 0], axis: [0, 0, 1]{1}}}\n", k,
        k == 0 ? ", velocity: -1" : "");
  }
  for (int k = 0; k < loops; ++k) {
    text += fmt::format("  c{0}: {{mass: 1, com: [{0} + 0.5, 1, 0], inertia: [1e-4, 1/12, 1/12]}}\n", k);
    joints += fmt::format(
        "  B{0}: {{type: revolute, between: [u{0}, c{0}], at: [{0}, 1, 0], axis: [0, 0, 1]}}\n", k);
    joints += fmt::format(
        "  C{0}: {{type: revolute, between: [c{0}, u{1}], at: [{1}, 1, 0], axis: [0, 0, 1]}}\n", k, k + 1);
  }
  return text + joints +
         fmt::format(
             "outputs:\n  - {{name: first, joint: A0, offset: pi/2}}\n  - {{name: last, joint: A{}, offset: "
             "pi/2}}\n",
             loops);
}

/// θ̈ = −c g cos θ of the uprights, c = 3 (3N + 1) / (2 (4N + 1)), by Runge and Kutta with steps of 0.1 ms.
struct Uprights {
  double angle = pi / 2, rate = -1;
  void advance(int loops) {
    const double c = 9.81 * 3 * (3 * loops + 1) / (2.0 * (4 * loops + 1)), h = 1e-4;
    const auto bend = [&](double x) { return -c * std::cos(x); };
    const double a1 = bend(angle), v2 = rate + h / 2 * a1, a2 = bend(angle + h / 2 * rate),
                 v3 = rate + h / 2 * a2, a3 = bend(angle + h / 2 * v2), v4 = rate + h * a3,
                 a4 = bend(angle + h * v3);
    angle += h / 6 * (rate + 2 * v2 + 2 * v3 + v4);
    rate += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
};

/// Largest error of the first and the last upright over 5 s.
double error(int loops, double step, Formulation formulation) {
  RunOptions options;
  options.step = step;
  options.formulation = formulation;
  Simulation s(model_of(row_of_four_bars(loops)), options);
  Uprights exact;
  ResultsRow row;
  double largest = 0;
  const int substeps = static_cast<int>(std::lround(step / 1e-4));
  for (int k = static_cast<int>(std::lround(5 / step)); k > 0; --k) {
    const StepReport report = s.step();
    if (!report.ok()) {
      ADD_FAILURE() << s.explain(report);
      return INFINITY;
    }
    EXPECT_LT(report.velocity_violation, 1e-7) << s.time() << " s";
    for (int j = 0; j < substeps; ++j) exact.advance(loops);
    s.sample(row);
    largest =
        std::max({largest, std::abs(row.channels[0] - exact.angle), std::abs(row.channels[1] - exact.angle)});
  }
  return largest;
}

TEST(SingularPositions, ManyLoopsMoveAsOne) {
  for (const Formulation formulation : {Formulation::relative, Formulation::natural})
    for (const double step : {0.01, 0.005, 0.004, 0.002}) {
      const double one = error(1, step, formulation);
      EXPECT_LT(one, 0.1) << step;
      for (const int loops : {2, 3, 4, 7, 10})
        EXPECT_LT(error(loops, step, formulation), 3 * one)
            << loops << " loops at " << step << " s, " << static_cast<int>(formulation);
    }
}

}  // namespace
}  // namespace mimbre::test::singular_positions_test
