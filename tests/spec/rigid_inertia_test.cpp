#include "spec/rigid_inertia.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mimbre/model.h"
#include "mimbre/model_file.h"
#include "mimbre/simulation.h"
#include "support/simulate.h"

namespace mimbre::rigid_inertia_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// A body with the inertia, of which the joints are said; gravity along −y.
std::string file(const std::string& inertia, const std::string& joints) {
  return "mimbre: 1\ngravity: [0, -9.81, 0]\nbodies:\n"
         "  arm: {mass: 2, com: [0.5, 0, 0], inertia: " +
         inertia +
         ", frame: {at: [0, 0, 0]}}\n"
         "  carrier: {mass: 1, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}\n"
         "joints:\n" +
         joints + "outputs:\n  - {name: turn, joint: j}\n";
}
const std::string hinge =
    "  c: {type: prismatic, between: [ground, carrier], at: [0, 0, 0], axis: [1, 0, 0]}\n"
    "  j: {type: revolute, between: [carrier, arm], at: [0, 0, 0], axis: [0, 0, 1]}\n";

struct Read {
  std::vector<Diagnostic> warnings;
  std::string error;
};
Read read(const std::string& text) {
  Read result;
  try {
    const spec::Model model = parse_model(text, "model.yaml", "", {}, &result.warnings);
    Model::compile(model);
  } catch (const InputError& error) {
    result.error = error.what();
  }
  return result;
}

TEST(RigidInertia, PointsAndRodsAreMatter) {
  for (const char* inertia : {"[0, 1, 1]", "[0, 0, 0]", "[1, 1, 2]"}) {
    const Read rod = read(file(inertia, hinge));
    EXPECT_THAT(rod.error, IsEmpty()) << inertia;
    EXPECT_THAT(rod.warnings, IsEmpty()) << inertia;
  }
}

TEST(RigidInertia, WhatNoMatterCanHaveIsTakenWhereJointsMakeItHarmless) {
  // Only the moment about z counts.
  for (const char* inertia : {"[0.1, 0.1, 9]", "[-1, 1, 0.2]"}) {
    const Read one = read(file(inertia, hinge));
    EXPECT_THAT(one.error, IsEmpty()) << inertia;
    ASSERT_EQ(one.warnings.size(), 1u) << inertia;
    EXPECT_THAT(one.warnings[0].message, HasSubstr("about one direction only"));
  }
  const std::string slide =
      "  c: {type: fixed, between: [ground, carrier]}\n"
      "  j: {type: prismatic, between: [arm, carrier], at: [0, 0, 0], axis: [0, 1, 0]}\n";
  EXPECT_THAT(read(file("[-1, -1, -1]", slide)).error, IsEmpty());
  EXPECT_THAT(read(file("[-1, -1, -1]", slide)).warnings.at(0).message, HasSubstr("cannot turn"));
}

TEST(RigidInertia, WhatNoMatterCanHaveIsRefusedWhereItMatters) {
  EXPECT_THAT(read(file("[0.1, 0.1, -1]", hinge)).error, HasSubstr("not positive definite"));
  const std::string ball =
      "  c: {type: fixed, between: [ground, carrier]}\n"
      "  j: {type: spherical, between: [carrier, arm], at: [0, 0, 0]}\n";
  std::string text = file("[0.1, 0.1, 9]", ball);
  text.resize(text.find("outputs:"));
  EXPECT_THAT(read(text).error, HasSubstr("triangle inequality"));
  const std::string skew =
      "  c: {type: revolute, between: [ground, carrier], at: [0, 0, 0], axis: [1, 0, 0]}\n"
      "  j: {type: revolute, between: [carrier, arm], at: [0, 0, 0], axis: [0, 0, 1]}\n";
  EXPECT_THAT(read(file("[0.1, 0.1, 9]", skew)).error, HasSubstr("triangle inequality"));
  const std::string in_line =
      "  c: {type: revolute, between: [ground, carrier], at: [3, 0, 0], axis: [0, 0, -1]}\n"
      "  j: {type: revolute, between: [carrier, arm], at: [0, 0, 0], axis: [0, 0, 1]}\n";
  EXPECT_THAT(read(file("[0.1, 0.1, 9]", in_line)).error, IsEmpty());
}

/// The motion is that of a body with the same moment about the hinge.
TEST(RigidInertia, HarmlessMomentsChangeNoMotion) {
  for (const auto formulation :
       {spec::Simulation::Formulation::relative, spec::Simulation::Formulation::natural}) {
    double turn[2] = {};
    int which = 0;
    for (const char* inertia : {"[5, 5, 9]", "[0.1, 0.1, 9]"}) {
      const auto model = Model::compile(parse_model(file(inertia, hinge), "model.yaml", ""));
      Simulation simulation = test::simulation_of(model, formulation);
      for (int k = 0; k < 60; ++k) ASSERT_TRUE(simulation.step().ok());
      turn[which++] = test::channel(simulation, "turn");
    }
    EXPECT_LT(turn[0], -0.1);
    EXPECT_NEAR(turn[1], turn[0], 1e-9 * std::abs(turn[0]));
  }
}

}  // namespace
}  // namespace mimbre::rigid_inertia_test
