#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "mimbre/simulation.h"
#include "support/models.h"
#include "support/simulate.h"

/// A pin in a slot against the motion of a Scotch yoke.
namespace mimbre::test::pin_slot_test {
namespace {

struct Case {
  Formulation formulation;
  const char* cut;
};
class PinSlot : public testing::TestWithParam<Case> {};

/// A crank turns evenly; its pin runs in the yoke's slot, which moves the yoke to and fro:
/// x = r cos ωt, along the slot r sin ωt.
TEST_P(PinSlot, DrivesAScotchYoke) {
  RunOptions options;
  options.formulation = GetParam().formulation;
  options.step = 2e-3;
  options.tolerance = 1e-9;
  Simulation s(model_of(fmt::format(R"(
bodies:
  crank: {{mass: 1, com: [0, 0, 0], inertia: [0.01, 0.01, 0.02]}}
  yoke: {{mass: 2, com: [0.3, 0, 0], inertia: [0.01, 0.02, 0.03]}}
joints:
  shaft: {{type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 0, 1], drive: {{speed: 3}}}}
  slot: {{type: pin_slot, between: [yoke, crank], at: [0.2, 0, 0], axis: [0, 0, 1], axis2: [0, 1, 0], cut: {}}}
constraints:
  guide: {{type: on_plane, between: [ground, yoke], at: [0.2, 0, 0], axis: [0, 1, 0]}}
  level: {{type: perpendicular, between: [ground, yoke], axis: [0, 1, 0], axis2: [1, 0, 0]}}
outputs:
  - {{name: x, position: yoke, component: x}}
  - {{name: s, joint: slot, component: 0}}
  - {{name: angle, joint: slot, component: 1}}
  - {{name: fx, joint_force: slot, component: fx}}
)",
                                    GetParam().cut)),
               options);
  const double r = 0.2, start = channel(s, "x");
  for (const double time : {0.3, 0.9, 1.5, 2.6}) {
    run_to(s, time);
    EXPECT_NEAR(channel(s, "x") - start, r * std::cos(3 * time) - r, 2e-8) << time;
    EXPECT_NEAR(channel(s, "s"), r * std::sin(3 * time), 2e-8) << time;
    // A cut joint's angle counts no turns.
    EXPECT_NEAR(std::remainder(channel(s, "angle") - 3 * time, 2 * std::numbers::pi), 0, 2e-8) << time;
    EXPECT_NEAR(channel(s, "fx"), 2 * 9 * r * std::cos(3 * time), 2e-4) << time;
    EXPECT_LT((s.pose(s.body("yoke")).rotation - Eigen::Matrix3d::Identity()).norm(), 1e-8) << time;
  }
}
INSTANTIATE_TEST_SUITE_P(
    Formulations, PinSlot,
    testing::Values(Case{Formulation::relative, "never"}, Case{Formulation::relative, "always"},
                    Case{Formulation::natural, "never"}, Case{Formulation::natural, "always"}),
    [](const auto& of) {
      return std::string(of.param.formulation == Formulation::natural ? "natural_" : "relative_") +
             of.param.cut;
    });

/// In a mirrored part the pin's axis is mirrored as a pseudo-vector and the slot as a vector, so that the
/// coordinates of the mirror image are the same.
TEST(PinSlotInTemplates, HasTheSameCoordinatesInAMirrorImage) {
  const auto model = model_of(R"(
subsystems:
  side:
    bodies: {link: {mass: 1, com: [0.4, 0.5, 0], inertia: [1, 1, 1]}}
    joints:
      slot: {type: pin_slot, between: [ground, link], at: [0.1, 0.3, 0], axis: [1, 2, 2], axis2: [2, -2, 1], position: [0.1, 0.4]}
instances: {plain: {of: side}, turned: {of: side, mirror: y}}
)");
  Simulation s(model);
  const Eigen::Matrix3d M = Eigen::Vector3d(1, -1, 1).asDiagonal();
  const auto pose = [&](const char* body) { return s.pose(s.body(body)); };
  EXPECT_LT((pose("turned.link").position - M * pose("plain.link").position).norm(), 1e-12);
  EXPECT_LT((pose("turned.link").rotation - M * pose("plain.link").rotation * M).norm(), 1e-12);
  EXPECT_GT((pose("plain.link").rotation - Eigen::Matrix3d::Identity()).norm(), 0.1);
}

}  // namespace
}  // namespace mimbre::test::pin_slot_test
