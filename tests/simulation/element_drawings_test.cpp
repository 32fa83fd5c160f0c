#include "simulation/describe/element_drawings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "mimbre/simulation.h"
#include "support/models.h"

namespace mimbre::test::element_drawings_test {
namespace {

const char* const rig = R"yaml(
materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}
sections: {round: {type: round, diameter: 0.02}}
bodies:
  carriage: {mass: 40, com: [0, 0, 0], inertia: [1, 1, 1]}
  arm:
    frame: {at: [0, 0, 0]}
    flexible:
      material: steel
      section: round
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {bar: {from: root, to: tip, elements: 4}}
      clamped: [root]
      static_modes: [{node: tip, along: [0, 0, 1]}]
joints:
  hinge: {type: revolute, between: [carriage, arm], at: [0, 0, 0], axis: [0, 1, 0], velocity: 2}
  column: {type: prismatic, between: [ground, carriage], at: [0, 0, 0], axis: [0, 0, 1]}
springs:
  strut: {between: [ground, carriage], at: [[0, 0, 1], [0, 0, 0]], elastic: {stiffness: 1e4, zero: 1}, damping: 100}
  dashpot: {between: [ground, arm.tip], at: [[1, 0, 1], null], damping: 10}
loads:
  push: {on: arm.tip, force: [0, 0, 3], scale: "sin(20*t)"
}
  thrust: {on: arm.tip, force: [5, 0, 0], moment: [0, 0, 2], follower: true}
roads:
  plate: {over: time, points: [[0, 0], [1, 0.1]]}
tyres:
  wheel: {on: carriage, at: [0, 0, -0.5], road: plate, stiffness: 1e4, radius: 0.4}
outputs:
  - {name: tip.x, position: arm.tip, component: x}
  - {name: tip.z, position: arm.tip, component: z}
  - {name: angle, joint: hinge}
simulation: {step: 0.002, end: 1}
)yaml";

double value(const Simulation& s, const ResultsRow& row, const std::string& name) {
  const auto& channels = s.channels();
  const auto found =
      std::find_if(channels.begin(), channels.end(), [&](const ChannelInfo& c) { return c.name == name; });
  EXPECT_NE(found, channels.end()) << name;
  return found == channels.end() ? NAN : row.channels[found - channels.begin()];
}

TEST(ElementDrawings, HoldAllThatHoldsOrActs) {
  const Simulation s(model_of(rig));
  const ResultsHeader header = s.header("");
  std::vector<std::string> kinds;
  for (const ElementDrawing& element : header.elements) kinds.push_back(element.name + ": " + element.kind);
  EXPECT_EQ(kinds, (std::vector<std::string>{"hinge: revolute", "column: prismatic", "strut: spring damper",
                                             "dashpot: damper", "push: load", "thrust: load",
                                             "wheel: tyre on rig"}));
  EXPECT_EQ(header.elements.back().size, 0.4);
  EXPECT_EQ(header.elements.back().frame_b, -1);
  // The tip has a damper and two loads, and is one frame.
  EXPECT_EQ(header.elements[3].frame_b, header.elements[4].frame_a);
  EXPECT_EQ(header.elements[4].frame_a, header.elements[5].frame_a);
}

TEST(ElementDrawings, SpringsOfJointsActOnTheJointsAxes) {
  const Simulation s(model_of(R"yaml(
bodies:
  link: {mass: 1, com: [1, 0, 0], inertia: [1, 1, 1]}
  shaft: {mass: 1, com: [1, 0, 0], inertia: [1, 1, 1]}
  slide: {mass: 1, com: [2, 0, 0], inertia: [1, 1, 1]}
  sleeve: {mass: 1, com: [3, 0, 0], inertia: [1, 1, 1]}
  puck: {mass: 1, com: [0, 5, 0], inertia: [1, 1, 1]}
joints:
  pin: {type: revolute, between: [ground, link], at: [0, 0, 0], axis: [0, 1, 0], spring: {stiffness: 9, damping: 1}}
  cross:
    {type: universal, between: [link, shaft], at: [1, 0, 0], axis: [1, 0, 0], axis2: [0, 1, 0], spring: {stiffness: 9, coordinate: 1}}
  guide: {type: prismatic, between: [shaft, slide], at: [2, 0, 0], axis: [1, 0, 0], spring: {stiffness: 100}}
  sleeve: {type: cylindrical, between: [ground, sleeve], at: [3, 0, 0], axis: [1, 0, 0], spring: {damping: 100, coordinate: 1}}
  table: {type: planar, between: [ground, puck], at: [0, 5, 0], axis: [0, 0, 1], spring: {stiffness: 100, damping: 1, coordinate: 1}}
simulation: {step: 0.01, end: 1}
)yaml"));
  const ResultsHeader header = s.header("");
  std::vector<std::string> kinds;
  for (const ElementDrawing& element : header.elements) kinds.push_back(element.name + ": " + element.kind);
  EXPECT_EQ(kinds, (std::vector<std::string>{
                       "pin: revolute", "cross: universal", "guide: prismatic", "sleeve: cylindrical",
                       "table: planar", "pin: torsional spring damper about z",
                       "cross: torsional spring about y", "guide: sliding spring along z",
                       "sleeve: sliding damper along z", "table: sliding spring damper along y"}));
  EXPECT_EQ(header.elements[5].frame_a, header.elements[0].frame_a);
  EXPECT_EQ(header.elements[5].frame_b, header.elements[0].frame_b);
}

std::vector<std::string> kinds_of(const ResultsHeader& header, std::size_t joints) {
  std::vector<std::string> kinds;
  for (const ElementDrawing& e : header.elements) kinds.push_back(e.name + ": " + e.kind);
  kinds.erase(kinds.begin(), kinds.begin() + static_cast<std::ptrdiff_t>(joints));
  return kinds;
}

/// Drives, cables, drag, and springs over several joints.
TEST(ElementDrawings, HoldForceElementsOfEveryPlace) {
  const Simulation s(geared_four_bar());
  const ResultsHeader header = s.header("");
  EXPECT_EQ(kinds_of(header, 4),
            (std::vector<std::string>{"rocker: torsional spring damper about z", "bar: coupling spring",
                                      "bar: coupling spring", "hoist: actuator", "hoist: actuator",
                                      "hoist: actuator", "dc: motor about z", "curve: motor about z",
                                      "sail: drag"}));
  const auto joint = [&](std::size_t k) -> const ElementDrawing& { return header.elements[k]; };
  ASSERT_EQ(joint(0).name, "crank");
  const auto place = [&](const std::string& name) {
    const auto found = std::find_if(header.elements.begin(), header.elements.end(),
                                    [&](const ElementDrawing& e) { return e.name == name; });
    return found == header.elements.end() ? std::pair(-2, -2) : std::pair(found->frame_a, found->frame_b);
  };
  EXPECT_EQ(place("bar").first, joint(0).frame_b);
  EXPECT_EQ(place("dc"), std::pair(joint(0).frame_a, joint(0).frame_b));
  EXPECT_GE(place("sail").first, 0);
  EXPECT_EQ(place("sail").second, -1);
}

TEST(ElementDrawings, HoldConstraintsOfEveryKind) {
  const Simulation s(every_constraint());
  const ResultsHeader header = s.header("");
  EXPECT_EQ(
      kinds_of(header, s.model().spec().joints.size()),
      (std::vector<std::string>{"gear: coupling", "pinion: coupling", "half_shaft: constant_velocity",
                                "slot: on_line", "cross: perpendicular", "rod: distance", "wire: on_curve",
                                "table: on_plane", "upright: parallel", "thread: screw"}));
  // A closed curve through its points, as the frame on the plate sees them.
  const auto wire = std::find_if(header.elements.begin(), header.elements.end(),
                                 [](const ElementDrawing& e) { return e.name == "wire"; });
  ASSERT_NE(wire, header.elements.end());
  ASSERT_GT(wire->curve.cols(), 50);
  EXPECT_LT((wire->curve.leftCols<1>() - wire->curve.rightCols<1>()).norm(), 1e-12);
  const spec::Pose& plate = s.model().spec().bodies[0].pose;  // with global axes
  const spec::Pose& pose = header.frames[static_cast<std::size_t>(wire->frame_a)].pose;
  for (const Eigen::Vector3d& given :
       {Eigen::Vector3d(-0.9, 0, -0.6), Eigen::Vector3d(0.1, 0, -1.2), Eigen::Vector3d(0.8, 0.2, -0.4)}) {
    const Eigen::Matrix3Xd global = (pose.rotation * wire->curve).colwise() + pose.position;
    EXPECT_LT((global.colwise() - (given - plate.position)).colwise().norm().minCoeff(), 0.03);
  }
}

/// A frame on its body, moved by the modes as a picture moves it, is where the output says that it is.
TEST(ElementDrawings, FramesAreWhereTheModelHasThem) {
  Simulation s(model_of(rig));
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(s.step().ok());
  ResultsRow row;
  s.sample(row);
  const ResultsHeader header = s.header("");
  const FrameDrawing& tip = header.frames[static_cast<std::size_t>(header.elements[4].frame_a)];
  ASSERT_EQ(header.bodies[static_cast<std::size_t>(tip.body)].name, "arm");
  const Eigen::VectorXd pose = row.poses.col(tip.body);
  const Eigen::Quaterniond turn(pose[3], pose[4], pose[5], pose[6]);
  const Eigen::Vector3d place =
      pose.head<3>() + turn * (tip.pose.position + tip.motion.topRows(3) * row.modes);
  EXPECT_GT(std::abs(row.modes[0]), 1e-5);
  EXPECT_NEAR(place.x(), value(s, row, "tip.x"), 1e-12);
  EXPECT_NEAR(place.z(), value(s, row, "tip.z"), 1e-12);
  // A cantilever's end turns by 3/2 of its deflection over its length.
  EXPECT_NEAR(tip.motion(4, 0), -1.5 * tip.motion(2, 0), 1e-6 * std::abs(tip.motion(4, 0)));
}

TEST(ElementDrawings, LoadsAndRoadsAreChannels) {
  Simulation s(model_of(rig));
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(s.step().ok());
  ResultsRow row;
  s.sample(row);
  EXPECT_NEAR(value(s, row, "load.push.force.z"), 3 * std::sin(20 * 0.1), 1e-12);
  EXPECT_EQ(value(s, row, "load.push.force.x"), 0);
  for (const ChannelInfo& channel : s.channels()) EXPECT_NE(channel.name, "load.push.moment.x");
  // It follows the tip, which has turned with the hinge, and a little by bending.
  const double angle = value(s, row, "angle");
  EXPECT_GT(std::abs(angle), 0.05);
  EXPECT_NEAR(value(s, row, "load.thrust.force.z"), -5 * std::sin(angle), 0.05);
  EXPECT_NEAR(std::hypot(value(s, row, "load.thrust.force.x"), value(s, row, "load.thrust.force.z")), 5,
              1e-12);
  EXPECT_NEAR(value(s, row, "load.thrust.moment.x"), 2 * std::sin(angle), 0.05);
  EXPECT_NEAR(value(s, row, "tyre.wheel.road"), 0.01, 1e-12);
}

}  // namespace
}  // namespace mimbre::test::element_drawings_test
