#include "compile/topology.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>

#include "compile/compiled.h"
#include "support/models.h"

namespace mimbre::test::topology_test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> cut_joints(const Model& model) {
  std::vector<std::string> names;
  for (const Model::JointLine& line : model.joint_lines())
    if (line.cut) names.push_back(line.name);
  return names;
}

std::string error_of(const std::string& text) {
  try {
    model_of(text);
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

struct Sizes {
  const char* flexible;
  int suspension, vehicle;
};

void PrintTo(const Sizes& sizes, std::ostream* out) { *out << sizes.flexible; }

class Iltis : public testing::TestWithParam<Sizes> {
 protected:
  static std::map<std::string, std::string> set() {
    const std::string flexible = GetParam().flexible;
    const auto kind = [&](char letter) {
      return flexible.find(letter) == std::string::npos ? "rigid" : "flexible";
    };
    return {{"arms", kind('A')}, {"links", kind('L')}, {"rods", kind('R')}, {"elements", "4"}};
  }
};

TEST_P(Iltis, Coordinates) {
  EXPECT_EQ(example("iltis/suspension.yaml", set())->coordinates(), GetParam().suspension);
  EXPECT_EQ(example("iltis/vehicle.yaml", set())->coordinates(), GetParam().vehicle);
}

INSTANTIATE_TEST_SUITE_P(FlexibleSets, Iltis,
                         testing::Values(Sizes{"none", 8, 34}, Sizes{"A", 12, 50}, Sizes{"L", 14, 58},
                                         Sizes{"R", 14, 58}, Sizes{"AL", 18, 74}, Sizes{"AR", 18, 74},
                                         Sizes{"LR", 20, 82}, Sizes{"ALR", 24, 98}),
                         [](const auto& row) { return std::string(row.param.flexible); });

TEST(Topology, IltisCutsItsOuterBallJoints) {
  const auto model = example("iltis/suspension.yaml", {{"elements", "4"}});
  EXPECT_THAT(cut_joints(*model), ElementsAre("front_left.link_ball", "front_left.rod_ball"));
  EXPECT_EQ(model->constraints(), 6);
  EXPECT_EQ(model->bodies(), 5);
  EXPECT_EQ(model->elastic_coordinates(), 16);
  EXPECT_EQ(example("iltis/vehicle.yaml", {{"elements", "4"}})->constraints(), 24);
}

TEST(Topology, DoubleFourBar) {
  for (int flexible = 0; flexible <= 5; ++flexible) {
    const auto model =
        example("double-four-bar/mechanism.yaml", {{"flexible_bars", std::to_string(flexible)}});
    EXPECT_EQ(model->coordinates(), 5 + 3 * flexible);
    EXPECT_EQ(model->elastic_coordinates(), 3 * flexible);
    EXPECT_EQ(model->constraints(), 10);
  }
}

TEST(Topology, OfEqualJointsTheLastFarFromTheGroundIsCut) {
  const auto model = model_of(four_bar_text());
  EXPECT_THAT(cut_joints(*model), ElementsAre("rocker_pin"));
  EXPECT_EQ(model->coordinates(), 3);
  EXPECT_EQ(model->constraints(), 5);
}

TEST(Topology, TheJointWithFewestEquationsIsCut) {
  const auto model = model_of(four_bar_text({{"crank_pin", ""}}, "spherical"));
  EXPECT_THAT(cut_joints(*model), ElementsAre("rocker_pin"));
  EXPECT_EQ(model->constraints(), 3);
  // Also where it stands on the ground and first in the file.
  const auto first = model_of(R"(
bodies:
  crank: {mass: 1, com: [0, 0, 0.1], inertia: [1, 1, 1]}
  coupler: {mass: 1, com: [0, 0, 0.1], inertia: [1, 1, 1]}
joints:
  ball: {type: spherical, between: [ground, crank], at: [0, 0, 0]}
  pin: {type: revolute, between: [crank, coupler], at: [0, 0, 1], axis: [0, 1, 0]}
  slide: {type: cylindrical, between: [coupler, ground], at: [1, 0, 1], axis: [1, 0, 0]}
)");
  EXPECT_THAT(cut_joints(*first), ElementsAre("ball"));
}

TEST(Topology, UsersChoiceWins) {
  EXPECT_THAT(cut_joints(*model_of(four_bar_text({{"crank", ", cut: always"}}))), ElementsAre("crank"));
  EXPECT_THAT(cut_joints(*model_of(four_bar_text({{"rocker_pin", ", cut: never"}}))),
              ElementsAre("crank_pin"));
}

TEST(Topology, JointsWithDrivesSpringsAndInitialValuesStay) {
  for (const char* more :
       {", drive: {position: t}", ", spring: {stiffness: 5}", ", position: 0", ", velocity: 1"})
    EXPECT_THAT(cut_joints(*model_of(four_bar_text({{"rocker_pin", more}}))), ElementsAre("crank_pin"))
        << more;
}

TEST(Topology, ALoopOfJointsThatMustStayIsAnError) {
  const std::string never = ", cut: never";
  EXPECT_THAT(error_of(four_bar_text(
                  {{"crank", never}, {"crank_pin", never}, {"rocker", never}, {"rocker_pin", never}})),
              AllOf(HasSubstr("test.yaml:"), HasSubstr("rocker_pin"), HasSubstr("cut: always")));
}

TEST(Topology, TreeIsListedFromParentToChild) {
  const auto model = model_of(four_bar_text({{"rocker", ", cut: always"}}));
  const Compiled& m = model->compiled();
  for (std::size_t b = 0; b < m.bodies.size(); ++b) EXPECT_LT(m.bodies[b].parent, static_cast<int>(b));
  EXPECT_THAT(cut_joints(*model), ElementsAre("rocker"));
  EXPECT_EQ(m.bodies[2].parent, 1);
}

TEST(Topology, LooseBodiesFloat) {
  const auto model = model_of(R"(
bodies:
  light: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
  heavy: {mass: 5, com: [0, 0, 0], inertia: [1, 1, 1]}
  alone: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}
joints:
  hinge: {type: revolute, between: [light, heavy], at: [0, 0, 0], axis: [0, 0, 1]}
)");
  std::vector<std::string> names;
  for (const Model::JointLine& line : model->joint_lines())
    names.push_back(line.type + " " + line.name + ": " + line.parent + " → " + line.child);
  EXPECT_THAT(names, testing::UnorderedElementsAre("floating heavy.floating: ground → heavy",
                                                   "revolute hinge: heavy → light",
                                                   "floating alone.floating: ground → alone"));
  EXPECT_THAT(cut_joints(*model), IsEmpty());
  EXPECT_EQ(model->coordinates(), 13);
  EXPECT_TRUE(std::any_of(model->compiled().bodies.begin(), model->compiled().bodies.end(),
                          [](const BodyData& b) { return b.reversed; }));
}

TEST(Topology, FlexibleBodiesHangOnTheirClampedFrames) {
  // From the ground the coupler could hang on either end; the clamped one costs least.
  for (const char* clamped : {"a", "b"}) {
    const auto model = model_of(std::string(R"(
materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}
sections: {round: {type: round, diameter: 0.01}}
bodies:
  bar:
    frame: {at: [0, 0, 0]}
    flexible:
      material: steel
      section: round
      nodes: {a: [0, 0, 0], b: [1, 0, 0]}
      bars: {bar: {from: a, to: b, elements: 4}}
      clamped: [)") + clamped + R"(]
      static_modes: [{node: )" + (clamped[0] == 'a' ? "b" : "a") +
                                R"(, along: [0, 0, 1]}]
joints:
  left: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0]}
  right: {type: revolute, between: [ground, bar], at: [1, 0, 0], axis: [0, 1, 0]}
)");
    EXPECT_THAT(cut_joints(*model), ElementsAre(clamped[0] == 'a' ? "right" : "left"));
  }
}

TEST(Compile, ASpringWithoutLengthIsAnError) {
  spec::Model m = parse_model(R"(
mimbre: 1
title: test
bodies:
  a: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
joints:
  slide: {type: prismatic, between: [ground, a], at: [0, 0, 0], axis: [0, 0, 1]}
springs:
  coil: {between: [ground, a], at: [[0, 0, 0], [0, 0, 1]], elastic: {stiffness: 10, zero: 0}}
)",
                              "test.yaml", ".");
  const spec::Spring& coil = m.springs.front();
  for (const int frame : {coil.frame_a, coil.frame_b})
    m.frames[static_cast<std::size_t>(frame)].pose.position.setZero();
  try {
    Model::compile(m);
    FAIL() << "compiled";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("test.yaml:9"), HasSubstr("'coil'"), HasSubstr("length 0")));
  }
}

}  // namespace
}  // namespace mimbre::test::topology_test
