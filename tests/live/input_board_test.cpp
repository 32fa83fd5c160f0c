#include "live/input_board.h"

#include <gtest/gtest.h>

#include "support/models.h"

namespace mimbre::test::input_board_test {
namespace {

/// One kilogram is pushed by 3 N from 0.2 s on, until the event at 0.5 s, and by 1 N from 0.8 s on.
TEST(InputBoard, WhatAnEventSetsLastsUntilTheNextPointThatIsPlayed) {
  Simulation simulation(model_of(R"(
inputs: {push: 0}
bodies: {b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {j: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [1, 0, 0]}}
actuators: {a: {joint: j, force: push}}
events: {half: {when: t, crosses: 0.5, direction: rising, set: {push: 0}}}
outputs: [{name: v, joint_velocity: j}]
simulation: {step: 0.01, end: 1}
)"));
  live::InputBoard board(simulation);
  live::InputTrack track;
  track.input = 0;
  track.times = {0.2, 0.8};
  track.values = {3, 1};
  ASSERT_TRUE(board.play(std::make_unique<live::InputTracks>(1, track)));
  for (int k = 0; k < 100; ++k) {
    board.before(simulation);
    EXPECT_EQ(board.playing(), k < 80) << k;
    ASSERT_TRUE(simulation.step().ok());
    const double pushed = k < 20 || (k > 50 && k < 80) ? 0 : k < 80 ? 3 : 1;
    if (k != 49 && k != 50) {
      EXPECT_EQ(simulation.input_value(0), pushed) << k;
    }
  }
  EXPECT_NEAR(simulation.value(simulation.channel("v")), 0.9 + 0.2, 0.03);
}

}  // namespace
}  // namespace mimbre::test::input_board_test
