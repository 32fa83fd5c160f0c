#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mimbre/model_file.h"

/// The section `constraints` of model files: what is wrong with them, and templates that are mirrored.
namespace mimbre::test::constraints_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string with(const std::string& constraint) {
  return fmt::format(R"(mimbre: 1
bodies:
  arm: {{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
  rod: {{mass: 1, com: [1, 0, 0], inertia: [1, 1, 1]}}
joints:
  hinge: {{type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 1]}}
  slide: {{type: prismatic, between: [ground, rod], at: [1, 0, 0], axis: [0, 0, 1]}}
  both: {{type: cylindrical, between: [arm, rod], at: [1, 0, 0], axis: [0, 0, 1]}}
constraints:
  it: {}
)",
                     constraint);
}

std::string message(const std::string& constraint) {
  try {
    parse_model(with(constraint), "model.yaml", "");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ConstraintsInFiles, SayWhatIsWrongAndWhere) {
  EXPECT_THAT(message("{type: geer, joints: [hinge, slide]}"),
              AllOf(HasSubstr("model.yaml:10:"), HasSubstr("constraint 'it': type"),
                    HasSubstr("did you mean 'gear'")));
  EXPECT_THAT(message("{joints: [hinge, slide]}"),
              HasSubstr("'type' is missing; it is one of: coupling, distance"));
  EXPECT_THAT(message("{type: gear, joints: [hing, slide], ratio: 2}"), HasSubstr("did you mean 'hinge'"));
  EXPECT_THAT(message("{type: gear, joints: [hinge], ratio: 2}"), HasSubstr("2 joints are needed"));
  EXPECT_THAT(message("{type: gear, joints: [hinge, slide], ratio: 2}"), HasSubstr("that is a rack"));
  EXPECT_THAT(message("{type: gear, joints: [hinge, both], ratio: 2}"),
              HasSubstr("the joint has 2 coordinates"));
  EXPECT_THAT(message("{type: gear, joints: [hinge, both], coordinates: [null, 0]}"),
              HasSubstr("needs 'ratio'"));
  EXPECT_THAT(message("{type: gear, joints: [hinge, both], coordinates: [null, 0], ratio: 0}"),
              HasSubstr("is 0"));
  EXPECT_THAT(
      message("{type: gear, joints: [hinge, both], coordinates: [null, 0], ratio: 2, internal: true}"),
      HasSubstr("belongs to 'teeth'"));
  EXPECT_THAT(message("{type: gear, joints: [hinge, both], coordinates: [null, 0], teeth: [17, -2]}"),
              HasSubstr("two positive numbers"));
  EXPECT_THAT(message("{type: rack, joints: [slide, hinge], radius: 0.1}"),
              HasSubstr("the pinion, and then one"));
  EXPECT_THAT(message("{type: rack, joints: [hinge, slide], radius: 3 kg}"), HasSubstr("kg"));
  EXPECT_THAT(message("{type: rack, joints: [hinge, slide]}"), HasSubstr("needs 'radius'"));
  EXPECT_THAT(message("{type: coupling, terms: []}"), HasSubstr("is empty; it couples nothing"));
  EXPECT_THAT(message("{type: coupling, terms: [{joint: hinge}]}"), HasSubstr("'factor' is missing"));
  EXPECT_THAT(message("{type: distance, between: [arm, rod], lenght: 2}"),
              HasSubstr("did you mean 'length'"));
  EXPECT_THAT(message("{type: distance, between: [arm, rod], at: [[1, 0, 0], null]}"),
              HasSubstr("type: spherical under 'joints'"));
  EXPECT_THAT(message("{type: distance, between: [ground, rod]}"),
              HasSubstr("a point of the ground needs its place"));
  EXPECT_THAT(message("{type: on_line, between: [arm, rod], at: [1, 0, 0]}"), HasSubstr("'axis' is missing"));
  EXPECT_THAT(message("{type: on_line, between: [arm, rod], axis: [1, 0, 0]}"), HasSubstr("'at' is missing"));
  EXPECT_THAT(message("{type: perpendicular, between: [arm, rod], axis: [1, 0, 0]}"),
              HasSubstr("'axis2' is missing"));
  EXPECT_THAT(message("{type: parallel, between: [arm, rod], axis2: [1, 0, 0]}"),
              HasSubstr("goes with 'axis'"));
  EXPECT_THAT(message("{type: screw, between: [arm, rod], at: [1, 0, 0], axis: [0, 0, 1]}"),
              HasSubstr("'lead' is missing"));
  EXPECT_THAT(message("{type: constant_velocity, between: [arm, rod], at: [1, 0, 0], axis: [0, 0, 1], axis2: "
                      "[0, 0, -1]}"),
              HasSubstr("point against each other"));
  EXPECT_THAT(message("{type: on_curve, between: [arm, rod], at: [1, 0, 0]}"),
              HasSubstr("'points' is missing"));
  EXPECT_THAT(message("12"), HasSubstr("a description is needed"));
}

TEST(ConstraintsInFiles, AreRead) {
  const auto read = [](const std::string& constraint) {
    const spec::Model model = parse_model(with(constraint), "model.yaml", "");
    EXPECT_EQ(model.constraints.size(), 1u);
    return model.constraints.at(0);
  };
  EXPECT_DOUBLE_EQ(
      read("{type: gear, joints: [hinge, both], coordinates: [null, 0], teeth: [20, 50]}").terms[1].factor,
      2.5);
  EXPECT_DOUBLE_EQ(
      read("{type: gear, joints: [hinge, both], coordinates: [null, 0], teeth: [20, 50], internal: true}")
          .terms[1]
          .factor,
      -2.5);
  EXPECT_DOUBLE_EQ(read("{type: rack, joints: [hinge, slide], radius: 12 mm}").terms[0].factor, -0.012);
  EXPECT_DOUBLE_EQ(read("{type: distance, between: [arm, rod]}").numbers[0], 1);
  EXPECT_DOUBLE_EQ(read("{type: distance, between: [arm, rod], length: 90 cm}").numbers[0], 0.9);
  EXPECT_DOUBLE_EQ(
      read("{type: screw, between: [arm, rod], at: [1, 0, 0], axis: [0, 0, 1], lead: -5 mm}").numbers[0],
      -0.005);
  EXPECT_EQ(read("{type: on_curve, between: [arm, rod], at: [1, 0, 0], points: [[1, 0, 0], [2, 1, 0]]}")
                .points.size(),
            2u);
}

/// The mirror image of a right-handed screw is left-handed, and lines and curves are mirrored with their
/// bodies.
TEST(ConstraintsInFiles, AreMirroredWithTheirTemplate) {
  const spec::Model model = parse_model(R"(mimbre: 1
subsystems:
  side:
    bodies: {rod: {mass: 1, com: [0.1, 0.5, 0], inertia: [1, 1, 1]}}
    constraints:
      thread: {type: screw, between: [ground, rod], at: [0.1, 0.5, 0], axis: [0, 1, 0.2], lead: 0.1}
      wire: {type: on_curve, between: [ground, rod], at: [0.1, 0.5, 0], points: [[0.1, 0.5, 0], [0.2, 0.7, 0.1]]}
instances:
  left: {of: side}
  right: {of: side, mirror: y}
)",
                                        "model.yaml", "");
  ASSERT_EQ(model.constraints.size(), 4u);
  const auto frame = [&](int number) { return model.frames[static_cast<std::size_t>(number)].pose; };
  const Eigen::Vector3d mirror(1, -1, 1);
  const spec::Constraint &left = model.constraints[0], &right = model.constraints[2];
  EXPECT_EQ(right.name, "right.thread");
  EXPECT_DOUBLE_EQ(right.numbers[0], -left.numbers[0]);
  EXPECT_LT((frame(right.frame_a).rotation.col(2) - mirror.cwiseProduct(frame(left.frame_a).rotation.col(2)))
                .norm(),
            1e-12);
  const auto place = [&](const spec::Constraint& c) -> Eigen::Vector3d {
    return frame(c.frame_a).position + frame(c.frame_a).rotation * c.points[1];
  };
  EXPECT_LT((place(model.constraints[3]) - mirror.cwiseProduct(place(model.constraints[1]))).norm(), 1e-12);
}

}  // namespace
}  // namespace mimbre::test::constraints_test
