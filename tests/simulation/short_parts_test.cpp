#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "mimbre/simulation.h"
#include "support/simulate.h"

/// An event cuts a step into parts, one of which may be as short as 1e-7 of it.
namespace mimbre::short_parts_test {
using namespace test;
namespace {

/// A planar loop, whose equations across its plane are redundant, with a bent bar. A force across a joint
/// jumps.
std::string loop(const char* stiffening, double instant) {
  return fmt::format(R"(
gravity: [0, 0, -9.81]
materials: {{alloy: {{young: 2e11, poisson: 0.3, density: 2700}}}}
sections: {{thin: {{type: round, diameter: 0.01}}}}
bodies:
  crank: {{mass: 0.3, com: [0, 0, 0.1], inertia: [0.01, 0.01, 0.0005]}}
  coupler:
    frame: {{at: [0, 0, 0.2]}}
    flexible:
      material: alloy
      section: thin
      nodes: {{a: [0, 0, 0.2], b: [0.6, 0, 0.5]}}
      bars: {{bar: {{from: a, to: b, elements: 8}}}}
      clamped: [a]
      dynamic_modes: 4
      stiffness_damping: 1e-3
      stiffening: {}
  rocker: {{mass: 0.3, com: [0.6, 0, 0.25], inertia: [0.01, 0.01, 0.0005]}}
joints:
  a: {{type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 1, 0], velocity: -6}}
  b: {{type: revolute, between: [crank, coupler], at: [0, 0, 0.2], axis: [0, 1, 0]}}
  d: {{type: revolute, between: [ground, rocker], at: [0.6, 0, 0], axis: [0, 1, 0]}}
  e: {{type: revolute, between: [coupler, rocker], at: [0.6, 0, 0.5], axis: [0, 1, 0]}}
inputs: {{on: 0}}
loads: {{push: {{on: coupler, at: [0.6, 0, 0.5], force: [1, 2, 0], scale: "8*on"}}}}
events: {{hit: {{when: t, crosses: {:.17g}, set: {{on: 1}}}}}}
outputs:
  - {{name: angle, joint: a}}
  - {{name: speed, joint_velocity: d}}
  - {{name: force, joint_force: a, component: fx}}
simulation: {{step: 1e-3}}
)",
                     stiffening, instant);
}

/// Whether the force jumps just before or just after the beginning of a step, the motion is the same.
class ShortParts : public testing::TestWithParam<Formulation> {};

TEST_P(ShortParts, ChangeNothing) {
  for (const char* const stiffening : {"linear", "geometric_stiffness"}) {
    std::vector<Eigen::VectorXd> ends;
    for (const double instant : {0.254 - 1e-10, 0.254 + 1e-12}) {
      SCOPED_TRACE(fmt::format("{} {:.17g}", stiffening, instant));
      Simulation s = simulation_of(loop(stiffening, instant), GetParam(), 1e-3);
      while (s.time() < 0.3) {
        const StepReport report = s.step();
        ASSERT_TRUE(report.ok()) << s.explain(report);
      }
      ResultsRow row;
      s.sample(row);
      ends.push_back(row.channels.head(3));
    }
    EXPECT_LT(((ends[0] - ends[1]).cwiseQuotient(ends[0])).cwiseAbs().maxCoeff(), 1e-6)
        << ends[0].transpose() << "; " << ends[1].transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(BothFormulations, ShortParts,
                         testing::Values(Formulation::relative, Formulation::natural), [](const auto& at) {
                           return std::string(at.param == Formulation::natural ? "natural" : "relative");
                         });

}  // namespace
}  // namespace mimbre::short_parts_test
