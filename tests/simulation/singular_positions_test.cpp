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

/// A driven four-bar whose thin coupler bends so far that projections count its positions as near to
/// singular: a step of 0.5 ms is then repeated with a new matrix in each iteration, which lacks the tangent
/// of the forces in the joints.
TEST(SingularPositions, AThinCouplerThatBendsFar) {
  const auto model = model_of(R"yaml(gravity: [0, 0, 0]
materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7800}}
sections: {round: {type: round, diameter: 0.004}}
bodies:
  coupler:
    frame: {at: [0, 0, 0.1]}
    flexible:
      material: steel
      section: round
      nodes: {left: [0, 0, 0.1], mid: [0.20009842072787581, 0, 0.20484186033563212], right: [0.40019684145575163, 0, 0.30968372067126426]}
      bars: {a: {from: left, to: mid, elements: 5}, b: {from: mid, to: right, elements: 5}}
      clamped: [left]
      stiffness_damping: 2e-4
      static_modes: [{node: right, all: true}]
      dynamic_modes: 6
  crank: {mass: 0.1, com: [0, 0, 0.05], inertia: [1e-4, 1e-4, 1e-4]}
  rocker: {mass: 0.2, com: [0.43746169744852026, 0, 0.15484186033563213], inertia: [1e-3, 1e-3, 1e-3]}
joints:
  crank: {type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 1, 0], drive: {position: "75.60675273582623*(t < 0.2 ? 0.5*t - sin(5*pi*t)/(10*pi) : t - 0.1)"}}
  left: {type: revolute, between: [crank, coupler], at: [0, 0, 0.1], axis: [0, 1, 0]}
  rocker: {type: revolute, between: [ground, rocker], at: [0.47472655344128883, 0, 0], axis: [0, 1, 0]}
  right: {type: spherical, between: [coupler, rocker], at: [0.40019684145575163, 0, 0.30968372067126426], cut: always}
)yaml");
  const auto end = [&](double step) {
    RunOptions options;
    options.step = step;
    Simulation s(model, options);
    while (s.time() < 0.35 - 1e-9) {
      const StepReport report = s.step();
      EXPECT_TRUE(report.ok()) << s.explain(report);
      if (!report.ok()) break;
    }
    return Eigen::Vector3d(s.pose(s.body("rocker")).position);
  };
  const Eigen::Vector3d right = end(5e-5), long_steps = end(5e-4);
  EXPECT_LT((long_steps - right).norm(), 0.01);
  EXPECT_LT((end(1e-4) - right).norm(), 0.04 * (long_steps - right).norm());
}

/// The message of the step that fails; empty: none does.
std::string failure(const std::string& text, spec::Simulation::Integrator integrator, double step,
                    double end) {
  RunOptions options;
  options.step = step;
  options.integrator = integrator;
  Simulation s(model_of(text), options);
  while (s.time() < end - step / 2)
    if (const StepReport report = s.step(); !report.ok()) return s.explain(report);
  return "";
}

/// What integrators of high order cannot pass they name; a stiff spring is no singular position.
TEST(SingularPositions, AreNamedWhereAStepFails) {
  using Integrator = spec::Simulation::Integrator;
  const std::string loop = row_of_four_bars(2);
  EXPECT_EQ(failure(loop, Integrator::generalized_alpha, 0.01, 5), "");
  for (const Integrator integrator : {Integrator::dopri853, Integrator::radau})
    EXPECT_NE(failure(loop, integrator, 0.01, 5).find("close to a singular position there"),
              std::string::npos);
  const std::string stiff = row_of_four_bars(2) + R"(
springs: {s: {between: [ground, u0], at: [[-1, 0.5, 0], [0, 0.5, 0]], elastic: {stiffness: 1e9, zero: 1}}}
)";
  const std::string message = failure(stiff, Integrator::dopri853, 0.01, 0.3);
  EXPECT_NE(message.find("too long for an explicit integrator"), std::string::npos) << message;
  EXPECT_EQ(message.find("singular"), std::string::npos) << message;
}

}  // namespace
}  // namespace mimbre::test::singular_positions_test
