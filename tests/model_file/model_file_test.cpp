#include "mimbre/model_file.h"

#include <gtest/gtest.h>
#include <array>

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "math/once/decompositions.h"
#include "mimbre/reduced_body.h"

namespace mimbre::model_file_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

spec::Model parse(const std::string& text, const std::map<std::string, std::string>& overrides = {}) {
  return parse_model("mimbre: 1\n" + text, "test.yaml", "", overrides);
}

spec::Model example(const std::string& name, const std::map<std::string, std::string>& overrides = {}) {
  return load_model(std::string(MIMBRE_SOURCE_DIR) + "/examples/" + name, overrides);
}

template <class T>
const T& by_name(const std::vector<T>& things, const std::string& name) {
  for (const T& thing : things)
    if (thing.name == name) return thing;
  throw std::out_of_range("nothing called " + name);
}

spec::Pose global(const spec::Model& model, int frame) {
  const spec::Frame& f = model.frames.at(static_cast<std::size_t>(frame));
  if (f.body == spec::ground) return f.pose;
  const spec::Pose& body = model.bodies.at(static_cast<std::size_t>(f.body)).pose;
  return {body.position + body.rotation * f.pose.position, body.rotation * f.pose.rotation};
}

std::vector<std::string> output_names(const spec::Model& model) {
  std::vector<std::string> names;
  for (const auto& output : model.outputs) names.push_back(output.name);
  return names;
}

std::vector<int> modes(const spec::Model& model) {
  std::vector<int> result;
  for (const auto& body : model.bodies) result.push_back(body.flexible ? body.flexible->modes : 0);
  return result;
}

void expect_near(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double tolerance = 1e-12) {
  ASSERT_EQ(a.rows(), b.rows());
  ASSERT_EQ(a.cols(), b.cols());
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), tolerance) << a << "\nagainst\n" << b;
}

/// Every joint of a model is assembled: places coincide, and axes too.
void expect_assembled(const spec::Model& model) {
  for (const spec::Joint& joint : model.joints) {
    const spec::Pose a = global(model, joint.frame_a), b = global(model, joint.frame_b);
    EXPECT_LT((a.position - b.position).norm(), 1e-9) << joint.name;
    EXPECT_LT((a.rotation - b.rotation).norm(), 1e-9) << joint.name;
  }
  for (const spec::Frame& frame : model.frames) {
    EXPECT_NEAR(frame.pose.rotation.determinant(), 1, 1e-12) << frame.name;
    if (frame.flexible_frame < 0) continue;
    const auto& reduced = model.bodies[static_cast<std::size_t>(frame.body)].flexible;
    ASSERT_TRUE(reduced) << frame.name;
    const BodyFrame& node = reduced->frames.at(static_cast<std::size_t>(frame.flexible_frame));
    EXPECT_LT((node.position - frame.pose.position).norm(), 1e-6) << frame.name;
  }
}

const std::string arm =
    "  arm: {mass: 2, com: [1, 2, 3], inertia: [3, 2, 4, 0.1, 0.2, 0.3], frame: {at: [1, 0, 0], x: [0, 1, "
    "0], y: [0, 0, 1]}}\n";

TEST(ModelFile, MayBeginWithAMarkOfUtf8) {
  const std::string text =
      "\xEF\xBB\xBFmimbre: 1\ntitle: marked\nbodies: {a: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}\n";
  EXPECT_EQ(parse_model(text, "marked.yaml", "").title, "marked");
}

TEST(ModelFile, ExpressionsAndParameters) {
  const std::string text =
      "parameters:\n  a: 2\n  b: a*3 + 1\n  heavy: true\n  kind: {value: fine, choices: [fine, coarse]}\n"
      "gravity: [sqrt(a^2), \"heavy ? -pi : 5\", \"kind == coarse ? 1 : 2\"]\ntitle: $kind\n"
      "bodies:\n  m: {mass: b, com: [0, 0, 0], inertia: [b, b, $a]}\n";
  const auto model = parse(text);
  expect_near(model.gravity, Vector3d(2, -pi, 2));
  EXPECT_EQ(model.title, "fine");
  EXPECT_EQ(model.bodies[0].mass, 7);
  EXPECT_EQ(model.bodies[0].inertia(2, 2), 2);
  const auto other = parse(text, {{"a", "1+2"}, {"heavy", "false"}, {"kind", "coarse"}});
  expect_near(other.gravity, Vector3d(3, 5, 1));
  EXPECT_EQ(other.bodies[0].mass, 10);
  EXPECT_EQ(other.title, "coarse");
}

TEST(ModelFile, BodyQuantitiesLieInBodyAxes) {
  const auto model = parse("bodies:\n" + arm);
  const spec::Body& body = model.bodies[0];
  // Body x is global y, body y is global z, so body z is global x.
  expect_near(body.pose.rotation, (Matrix3d() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished());
  expect_near(body.com, Vector3d(2, 3, 0));
  EXPECT_EQ(body.inertia(0, 2), 0.2);
  // The body's frame carries its name; a body without joints floats.
  EXPECT_EQ(model.frames[0].name, "arm");
  ASSERT_EQ(model.joints.size(), 1u);
  EXPECT_EQ(model.joints[0].name, "arm.floating");
  EXPECT_EQ(model.joints[0].type, spec::JointType::floating);
  expect_assembled(model);
}

TEST(ModelFile, JointFramesHaveTheAxisAsZ) {
  const auto model =
      parse("bodies:\n" + arm +
            "joints:\n  hinge: {type: revolute, between: [ground, arm], at: [1, 1, 1], axis: [0, 3, 4]}\n");
  const spec::Joint& joint = model.joints.at(0);
  expect_near(global(model, joint.frame_a).rotation.col(2), Vector3d(0, 0.6, 0.8));
  expect_near(global(model, joint.frame_a).position, Vector3d(1, 1, 1));
  EXPECT_EQ(model.frames[static_cast<std::size_t>(joint.frame_a)].name, "hinge.a");
  EXPECT_EQ(model.frames[static_cast<std::size_t>(joint.frame_b)].name, "hinge.b");
  expect_assembled(model);
}

TEST(ModelFile, UniversalAxes) {
  const auto model =
      parse("bodies:\n" + arm +
            "joints:\n  cross: {type: universal, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 1], "
            "axis2: [0, 1, 0]}\n");
  const Matrix3d axes = global(model, model.joints[0].frame_a).rotation;
  expect_near(axes.col(0), Vector3d(0, 0, 1));
  expect_near(axes.col(1), Vector3d(0, 1, 0));
}

TEST(ModelFile, FloatingVelocityTurnsIntoTheJointsAxes) {
  const auto model =
      parse("bodies:\n" + arm +
            "joints:\n  free: {type: floating, between: [ground, arm], velocity: [1, 2, 3, 4, 5, 6]}\n");
  const auto& velocity = model.joints.at(0).initial_velocity;
  ASSERT_EQ(velocity.size(), 6u);
  const Matrix3d R = global(model, model.joints[0].frame_a).rotation;
  const Vector3d linear = R * Vector3d(*velocity[0], *velocity[1], *velocity[2]);
  const Vector3d angular = model.bodies[0].pose.rotation * Vector3d(*velocity[3], *velocity[4], *velocity[5]);
  expect_near(linear, Vector3d(1, 2, 3));
  expect_near(angular, Vector3d(4, 5, 6));
}

TEST(ModelFile, InitialValuesDrivesAndSpringsOfJoints) {
  const auto model =
      parse("parameters: {w: 3}\nbodies:\n" + arm +
            "joints:\n  slide:\n    type: cylindrical\n    between: [ground, arm]\n    at: [0, 0, 0]\n"
            "    axis: [0, 0, 1]\n    position: [null, 0.5]\n    drive: {position: sin(w*t), coordinate: 0}\n"
            "    spring: {stiffness: 100, damping: 2, zero: 0.1, coordinate: 1}\n    cut: always\n");
  const spec::Joint& joint = model.joints.at(0);
  EXPECT_FALSE(joint.initial_position.at(0));
  EXPECT_EQ(joint.initial_position.at(1), 0.5);
  EXPECT_EQ(joint.cut, spec::Joint::Cut::always);
  EXPECT_NEAR(joint.drives.at(0).law.value(0.2), std::sin(0.6), 1e-14);
  EXPECT_EQ(joint.drives.at(0).of, spec::Drive::Of::position);
  EXPECT_EQ(joint.springs.at(0).coordinate, 1);
  EXPECT_NEAR(joint.springs[0].elastic.value(0.3), 20, 1e-12);
  EXPECT_NEAR(joint.springs[0].damping.value(0.5), 1, 1e-12);
}

TEST(ModelFile, Laws) {
  const auto model = parse(
      "bodies:\n" + arm +
      "springs:\n"
      "  a: {between: [ground, arm], at: [[0, 0, 0], null], elastic: {pieces: [{until: 1, polynomial: "
      "[0, 2]}, {polynomial: [2]}]}, damping: 7}\n"
      "  b: {between: [ground, arm], at: [[0, 0, 0], [1, 1, 1]], elastic: {table: [[0, 0], [1, 5], [2, 5]]}, "
      "force: l*v + t}\n"
      "  c: {between: [ground, arm], at: [[0, 0, 0], null], elastic: 3*(x - 1)^2, damping: {coefficient: "
      "4}}\n");
  const auto &a = model.springs.at(0), &b = model.springs.at(1), &c = model.springs.at(2);
  EXPECT_NEAR(a.elastic.value(0.5), 1, 1e-14);
  EXPECT_NEAR(a.elastic.value(3), 2, 1e-14);
  EXPECT_NEAR(a.damping.value(2), 14, 1e-14);
  EXPECT_NEAR(b.elastic.value(0.5), 2.5, 1e-14);
  EXPECT_NEAR(b.general.formula.value(std::array{2.0, 3.0, 4.0}.data()), 10, 1e-14);
  EXPECT_NEAR(c.elastic.value(3), 12, 1e-12);
  EXPECT_NEAR(c.damping.value(0.5), 2, 1e-14);
  expect_near(global(model, b.frame_b).position, Vector3d(1, 1, 1));
}

TEST(ModelFile, LoadsRoadsAndTyres) {
  const auto model =
      parse("bodies:\n" + arm +
            "loads:\n  push: {on: arm, at: [0, 0, 0], force: [1, 2, 3], scale: 2*t, follower: true}\n"
            "roads:\n  track: {over: distance, points: [[0, 0], [4, 0], [4, -1], [8, -1]], repeat: 10}\n"
            "tyres:\n  wheel: {on: arm, road: track, stiffness: 5, radius: 0.3}\n");
  const spec::Load& load = model.loads.at(0);
  expect_near(global(model, load.frame).rotation * load.force, Vector3d(1, 2, 3));
  EXPECT_NEAR(load.scale.value(3), 6, 1e-14);
  const spec::Road& road = model.roads.at(0);
  EXPECT_NEAR(road.height.value(3.9), 0, 1e-14);
  EXPECT_NEAR(road.height.value(4.1), -1, 1e-14);
  EXPECT_NEAR(road.height.value(12), 0, 1e-14);
  EXPECT_EQ(road.draw_to, 8);
  EXPECT_EQ(model.tyres.at(0).road, 0);
  EXPECT_EQ(model.frames.at(static_cast<std::size_t>(model.tyres[0].frame)).name, "arm");
}

/// A profile is as high beyond its ends as at them, also where it repeats with a gap.
TEST(ModelFile, RoadsAreLevelBeyondTheirPoints) {
  const auto model = parse("bodies:\n" + arm +
                           "roads:\n  bump: {over: distance, points: [[0, 0], [0.5, 0.05], [1, 0.02]]}\n"
                           "  rig: {over: time, points: [[0.5, 0.1], [1, 0.2]]}\n"
                           "  gap: {over: distance, points: [[0, 0], [1, 0.1]], repeat: 2}\n"
                           "  none: {over: distance, points: [[0.1, 0], [0.2, 0.1], [0.3, 0]], repeat: 0.2}\n"
                           "  jumps: {over: distance, points: [[0, 1], [0, 0], [1, 0.1], [1, 0.3]]}\n");
  const auto height = [&](std::size_t road, double x) { return model.roads.at(road).height.value(x); };
  EXPECT_EQ(height(0, -0.25), 0);
  EXPECT_EQ(height(0, -100), 0);
  EXPECT_NEAR(height(0, 0.25), 0.025, 1e-15);
  EXPECT_NEAR(height(0, 0.75), 0.035, 1e-15);
  EXPECT_EQ(height(0, 1.25), 0.02);
  EXPECT_EQ(height(0, 100), 0.02);
  EXPECT_EQ(height(1, 0), 0.1);
  EXPECT_EQ(height(1, 9), 0.2);
  for (const double turn : {-4.0, 0.0, 2.0}) {
    EXPECT_NEAR(height(2, turn + 0.5), 0.05, 1e-14) << turn;
    EXPECT_EQ(height(2, turn + 1.01), 0.1) << turn;
    EXPECT_EQ(height(2, turn + 1.99), 0.1) << turn;
    EXPECT_NEAR(height(3, 0.1 * turn + 0.15), 0.05, 1e-14) << turn;
  }
  EXPECT_EQ(height(4, -1), 1);
  EXPECT_EQ(height(4, 2), 0.3);
  // Over what does not change nothing is added.
  EXPECT_NEAR(model.roads[0].height.antiderivative(3) - model.roads[0].height.antiderivative(1), 0.04, 1e-15);
}

const std::string leg_template =
    "subsystems:\n  side:\n    parameters: {m: 2}\n    bodies:\n"
    "      leg: {mass: m, com: [0.1, 0.2, 0.3], inertia: [3, 2, 4, 0.1, 0.2, 0.3], frame: {at: [0.3, 0.1, "
    "0], x: [1, 2, 0], y: [-2, 1, 0]}}\n"
    "      foot: {mass: m, com: [0.4, 0.5, 0.6], inertia: [1, 1, 1]}\n"
    "    frames:\n      knee: {body: leg, at: [0.5, 0.6, 0.7], x: [0, 1, 1], y: [1, 0, 0]}\n"
    "      ankle: {body: foot, at: [0.5, 0.6, 0.7], x: [0, 1, 1], y: [1, 0, 0]}\n"
    "    joints:\n      hip: {type: revolute, between: [ground, leg], at: [0.3, 0.1, 0], axis: [1, 2, 3]}\n"
    "      slide: {type: prismatic, between: [leg, foot], at: [0, 0.4, 0], axis: [1, 2, 3], cut: always}\n"
    "      knee: {type: revolute, between: [knee, ankle]}\n"
    "    outputs:\n      - {name: \"z.{instance}\", position: foot, component: z}\n"
    "      - {name: \"q.{instance}\", joint: hip}\n";

TEST(ModelFile, MirroringIsMRM) {
  const auto model =
      parse(leg_template +
            "instances:\n  plain: {of: side}\n"
            "  turned: {of: side, mirror: y, rotate: [0, 0, 0.3], at: [1, 2, 3], with: {m: 5}}\n");
  expect_assembled(model);
  const Matrix3d M = Vector3d(1, -1, 1).asDiagonal();
  const Matrix3d T = Eigen::AngleAxisd(0.3, Vector3d::UnitZ()).toRotationMatrix();
  const Vector3d t(1, 2, 3);
  const spec::Body &a = by_name(model.bodies, "plain.leg"), &b = by_name(model.bodies, "turned.leg");
  EXPECT_EQ(a.mass, 2);
  EXPECT_EQ(b.mass, 5);
  expect_near(b.pose.rotation, T * M * a.pose.rotation * M);
  expect_near(b.pose.position, t + T * M * a.pose.position);
  expect_near(b.com, M * a.com);
  expect_near(b.inertia, M * a.inertia * M);
  // Axes: of revolutes as pseudo-vectors, of prismatic joints as vectors.
  const auto axis = [&](const std::string& joint) -> Vector3d {
    return global(model, by_name(model.joints, joint).frame_a).rotation.col(2);
  };
  expect_near(axis("turned.hip"), -T * M * axis("plain.hip"));
  expect_near(axis("turned.slide"), T * M * axis("plain.slide"));
  // A joint between frames too: turning the second body by q in both keeps them mirror images.
  expect_near(axis("turned.knee"), -T * M * axis("plain.knee"));
}

TEST(ModelFile, OutputsOfTemplatesGoInstanceByInstance) {
  const auto model = parse(leg_template +
                           "instances: {l: {of: side}, r: {of: side, mirror: y}}\n"
                           "outputs:\n  - {name: x, position: r.leg, component: x}\n");
  EXPECT_EQ(output_names(model), (std::vector<std::string>{"x", "z.l", "z.r", "q.l", "q.r"}));
}

/// A bent frame of two bars, in a template, rigidly offset spring seat included.
const std::string bent =
    "materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}\nsections: {rod: {type: rectangle, "
    "width: 0.02, height: 0.01}}\n"
    "subsystems:\n  side:\n    bodies:\n      bar:\n        frame: {at: [0, 0, 0], x: [1, 1, 0]}\n        "
    "flexible:\n"
    "          material: steel\n          section: rod\n"
    "          nodes: {root: [0, 0, 0], knee: [1, 0.5, 0], tip: [1.5, 1, 0.5], seat: {at: [0.5, 0.3, 0.1], "
    "on: [upper, 0.5]}}\n"
    "          bars:\n            upper: {from: root, to: knee, elements: 4, y: [0, 0, 1]}\n            "
    "lower: {from: knee, to: tip, elements: 3}\n"
    "          clamped: [root]\n          static_modes:\n            - {node: tip, along: [0, 0, 1]}\n"
    "            - {node: tip, about: [0, 0, 1]}\n            - {node: seat, all: true}\n          "
    "dynamic_modes: 2\n"
    "    joints:\n      root: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 0, 1]}\n"
    "    outputs:\n      - {name: \"tip.{instance}\", deflection: bar.tip, along: [0, 0, 1]}\n";

TEST(ModelFile, FlexibleBodies) {
  const auto model = parse(bent +
                           "instances: {a: {of: side}, b: {of: side, mirror: x}, c: {of: side, at: [3, 4, "
                           "5], rotate: [0.1, 0.2, 0.3]}}\n");
  expect_assembled(model);
  const auto &a = *model.bodies[0].flexible, &b = *model.bodies[1].flexible;
  EXPECT_EQ(a.modes, 10);
  EXPECT_EQ(a.frames.size(), 4u);
  EXPECT_EQ(a.nodes.cols(), 4 + 1 + 1 + 2);
  const double length = std::sqrt(1.25) + std::sqrt(0.75);
  EXPECT_NEAR(a.mass, 7850 * 2e-4 * length, 1e-9);
  // Moved and turned it is the same body, mirrored it has the mirrored integrals and the same frequencies.
  EXPECT_EQ(model.bodies[2].flexible.get(), &a);
  EXPECT_NE(&b, &a);
  const Matrix3d M = Vector3d(-1, 1, 1).asDiagonal();
  expect_near(b.first_moment, M * a.first_moment, 1e-9);
  expect_near(b.eigenfrequencies.cwiseQuotient(a.eigenfrequencies), Eigen::VectorXd::Ones(a.modes), 1e-6);
  // The static mode moves the tip by one along global z.
  const spec::Output& output = model.outputs.at(0);
  EXPECT_EQ(output.name, "tip.a");
  const int tip = model.frames[static_cast<std::size_t>(output.item)].flexible_frame;
  const Eigen::VectorXd y = mimbre::solve(a.user_from_modal, Eigen::VectorXd::Unit(a.modes, 0));
  EXPECT_NEAR(output.direction.dot(a.frames[static_cast<std::size_t>(tip)].X * y), 1, 1e-8);
}

/// Other names of the nodes at a bar's ends; modes that a parameter leaves out.
TEST(ModelFile, EndsOfBarsAndModesUnderAConditionOfFlexibleBodies) {
  std::string text = bent;
  const auto put = [&](const std::string& before, const std::string& added) {
    text.insert(text.find(before), added);
  };
  put("root: [0, 0, 0], knee", "eye: {on: [lower, 1]}, foot: {on: [upper, 0]}, ");
  put("            - {node: seat", "            - {node: eye, along: [1, 0, 0], when: wide}\n");
  text +=
      "instances: {a: {of: side}}\noutputs: [{name: eye, position: a.bar.eye, component: x}]\nparameters: "
      "{wide: "
      "true}\n";
  const auto model = parse(text), narrow = parse(text, {{"wide", "false"}});
  const auto &wide_body = *model.bodies[0].flexible, &body = *narrow.bodies[0].flexible;
  EXPECT_EQ(wide_body.modes, 11);
  EXPECT_EQ(body.modes, 10);
  ASSERT_EQ(body.frames.size(), 6u);
  EXPECT_EQ(body.nodes.cols(), 4 + 1 + 1 + 2);
  const auto frame = [&](const char* name) {
    return body.frames[static_cast<std::size_t>(body.find_frame(name))];
  };
  EXPECT_EQ(frame("eye").position, frame("tip").position);
  EXPECT_EQ(frame("eye").X, frame("tip").X);
  EXPECT_EQ(frame("foot").position, frame("root").position);
  EXPECT_TRUE(frame("foot").X.isZero(0));
  const int eye = by_name(model.outputs, "eye").item;
  const spec::Frame& seen = model.frames[static_cast<std::size_t>(eye)];
  EXPECT_EQ(wide_body.frames[static_cast<std::size_t>(seen.flexible_frame)].name, "eye");
  expect_near(global(model, eye).position, Vector3d(1.5, 1, 0.5));
}

/// A bent chain of two bars with a seat beside the first, in a turned body frame away from the origin.
std::string chain(const std::string& more) {
  return "materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}\nsections: {rod: {type: "
         "rectangle, "
         "width: 0.02, height: 0.01}}\nbodies:\n  bar:\n    frame: {at: [1, 2, 3], x: [1, 1, 0]}\n    "
         "flexible:\n      material: steel\n      section: rod\n"
         "      nodes: {root: [1, 2, 3], knee: [2, 2.5, 3], tip: [2.5, 3, 3.5], seat: {at: [1.5, 2.3, 3.1], "
         "on: "
         "[upper, 0.5]}}\n"
         "      bars:\n        upper: {from: root, to: knee, elements: 4}\n        lower: {from: knee, to: "
         "tip, "
         "elements: 4}\n      clamped: [root]\n      dynamic_modes: 3\n" +
         more +
         "joints:\n  root: {type: revolute, between: [ground, bar], at: [1, 2, 3], axis: [0, 0, 1]}\n"
         "outputs:\n  - {name: tip, deflection: bar.tip, along: [0, 0, 1]}\n"
         "  - {name: seat, deflection: bar.seat, along: [0, 1, 0]}\n"
         "  - {name: last, modal_amplitude: bar, component: 8}\n"
         "  - {name: tip.x, displacement: bar.tip, relative_to: bar, component: x}\n";
}

TEST(ModelFile, SubstructuresAreBodiesJoinedByBrackets) {
  const auto model = parse(chain("      substructures: {count: 4, dynamic_modes: 2}\n"));
  std::vector<std::string> names;
  for (const auto& body : model.bodies) names.push_back(body.name);
  EXPECT_EQ(names, (std::vector<std::string>{"bar", "bar.2", "bar.3", "bar.4"}));
  EXPECT_EQ(modes(model), (std::vector<int>{8, 8, 8, 3}));
  expect_assembled(model);
  double mass = 0;
  for (const auto& body : model.bodies) mass += body.flexible->mass;
  EXPECT_NEAR(mass, 7850 * 2e-4 * (std::sqrt(1.25) + std::sqrt(0.75)), 1e-9);
  for (const char* joint : {"bar.2.bracket", "bar.3.bracket", "bar.4.bracket"}) {
    const spec::Joint& bracket = by_name(model.joints, joint);
    EXPECT_EQ(bracket.type, spec::JointType::bracket);
    expect_near(global(model, bracket.frame_a).rotation, global(model, bracket.frame_b).rotation);
  }
  // The pieces begin at the seat (half of the upper bar), at the knee and at half of the lower bar.
  expect_near(by_name(model.bodies, "bar.2").pose.position, Vector3d(1.5, 2.3, 3.1));
  expect_near(by_name(model.bodies, "bar.3").pose.position, Vector3d(2, 2.5, 3));
  expect_near(by_name(model.bodies, "bar.4").pose.position, Vector3d(2.25, 2.75, 3.25));

  // Frames stay where they were, on the piece that carries them.
  const spec::Output &tip = by_name(model.outputs, "tip"), &seat = by_name(model.outputs, "seat");
  expect_near(global(model, tip.item).position, Vector3d(2.5, 3, 3.5));
  expect_near(global(model, seat.item).position, Vector3d(1.5, 2.3, 3.1));
  EXPECT_EQ(model.frames[static_cast<std::size_t>(tip.item)].body, 3);
  EXPECT_EQ(model.frames[static_cast<std::size_t>(seat.item)].body, 0);
  EXPECT_EQ(seat.kind, "deflection");
  EXPECT_EQ(tip.kind, "displacement");
  EXPECT_EQ(model.frames[static_cast<std::size_t>(tip.reference)].name, "bar");
  for (const spec::Frame& frame : model.frames) {
    if (frame.flexible_frame < 0) continue;
    const auto& node = model.bodies[static_cast<std::size_t>(frame.body)].flexible->frames.at(
        static_cast<std::size_t>(frame.flexible_frame));
    expect_near(node.position, frame.pose.position);
  }
  // Eight amplitudes of the first piece come before it.
  const spec::Output& last = by_name(model.outputs, "last");
  EXPECT_EQ(last.item, 1);
  EXPECT_EQ(last.component, 0);
}

TEST(ModelFile, EqualSubstructuresAreReducedOnce) {
  const auto model = parse(
      "materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}\nsections: {rod: {type: round, "
      "diameter: 0.02}}\nbodies:\n  bar:\n    frame: {at: [0, 0, 0]}\n    flexible: {material: steel, "
      "section: "
      "rod, nodes: {a: [0, 0, 0], b: [1, 0, 0]}, bars: {bar: {from: b, to: a, elements: 12}}, clamped: [a], "
      "dynamic_modes: 2, planar: [0, 1, 0], substructures: 6}\n"
      "joints:\n  a: {type: fixed, between: [ground, bar], at: [0, 0, 0]}\n");
  EXPECT_EQ(modes(model), (std::vector<int>{5, 5, 5, 5, 5, 2}));  // two displacements, a turn, two dynamic
  for (const int k : {2, 3, 4})
    EXPECT_EQ(model.bodies[static_cast<std::size_t>(k)].flexible, model.bodies[1].flexible);
}

TEST(ModelFile, Displacement) {
  const auto model = parse(
      "bodies:\n  a: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1], frame: {at: [1, 0, 0], x: [0, 1, 0], y: "
      "[-1, 0, "
      "0]}}\n  b: {mass: 1, com: [2, 3, 4], inertia: [1, 1, 1]}\n"
      "outputs:\n  - {name: x, displacement: b, relative_to: a, component: x}\n"
      "  - {name: y, displacement: b, at: [5, 6, 7], relative_to: a, component: y}\n");
  const spec::Output &x = by_name(model.outputs, "x"), &y = by_name(model.outputs, "y");
  EXPECT_NEAR(x.offset, -3, 1e-12);  // a's x is the global y
  EXPECT_NEAR(y.offset, 4, 1e-12);   // and its y the global -x
  expect_near(x.direction, Vector3d::UnitX());
  EXPECT_EQ(model.frames[static_cast<std::size_t>(y.reference)].name, "a");
}

TEST(ModelFile, Sections) {
  const auto frequency = [](const std::string& section) {
    const auto model =
        parse("materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}\nsections: {s: " + section +
              "}\nbodies:\n  bar:\n    frame: {at: [0, 0, 0]}\n    flexible:\n      material: steel\n      "
              "section: s\n"
              "      nodes: {a: [0, 0, 0], b: [1, 0, 0]}\n      bars: {bar: {from: a, to: b, y: [0, 1, "
              "0]}}\n      clamped: [a]\n"
              "      static_modes: [{node: b, along: [0, 0, 1]}]\n      dynamic_modes: 2\n      planar: [0, "
              "1, 0]\n");
    return model.bodies[0].flexible->eigenfrequencies[0];
  };
  // A cantilever's first bending frequency: 1.8751² √(EI/ρA) / L².
  const auto expected = [](double I, double A) { return 3.516015 * std::sqrt(2.1e11 * I / (7850 * A)); };
  const double d = 0.02, i = 0.015;
  EXPECT_NEAR(frequency("{type: round, diameter: 0.02}") / expected(d * d / 16, 1), 1, 1e-3);
  EXPECT_NEAR(
      frequency("{type: tube, diameter: 0.02, inner_diameter: 0.015}") / expected((d * d + i * i) / 16, 1), 1,
      1e-3);
  EXPECT_NEAR(frequency("{type: rectangle, width: 0.05, height: 0.02}") / expected(d * d / 12, 1), 1, 1e-3);
  EXPECT_NEAR(frequency("{area: 1e-4, Iy: 2e-9, Iz: 5e-9, J: 7e-9}") / expected(2e-9, 1e-4), 1, 1e-3);
}

/// A rectangle by its numbers has the stress of the rectangle.
TEST(ModelFile, OutermostFibresOfSections) {
  const auto text = [](const std::string& section) {
    return "materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}\nsections: {s: " + section +
           "}\nbodies:\n  bar:\n    frame: {at: [0, 0, 0]}\n    flexible:\n      material: steel\n      "
           "section: s\n      nodes: {a: [0, 0, 0], b: [1, 0, 0]}\n      bars: {bar: {from: a, to: b, y: "
           "[0, 1, 0]}}\n      clamped: [a]\n      static_modes: [{node: b, all: true}]\n"
           "outputs: [{name: peak, section_force: bar, at: [0, 0, 0], component: von_mises}]\n";
  };
  const auto shaped = parse(text("{type: rectangle, width: 0.05, height: 0.02}")).bodies[0].flexible;
  const double b = 0.05, h = 0.02,
               J = b * h * h * h * (1. / 3 - 0.21 * h / b * (1 - std::pow(h / b, 4) / 12)),
               modulus = shaped->sections->sections[0].torsion_modulus;
  const std::string numbers = fmt::format("{{area: {:.17g}, Iy: {:.17g}, Iz: {:.17g}, J: {:.17g}, ", b * h,
                                          b * h * h * h / 12, h * b * b * b / 12, J);
  const auto given =
      parse(text(numbers +
                 fmt::format("outermost: [25 mm, 1 cm], torsion_modulus: {:.17g} mm^3}}", 1e9 * modulus)))
          .bodies[0]
          .flexible;
  ASSERT_TRUE(shaped->bar_stress && given->bar_stress);
  const auto& expected = shaped->bar_stress->shapes;
  EXPECT_LT((given->bar_stress->shapes - expected).cwiseAbs().maxCoeff(),
            1e-9 * expected.cwiseAbs().maxCoeff());
  EXPECT_GT(expected.cwiseAbs().maxCoeff(), 0);
}

TEST(ModelFile, Simulation) {
  const auto model = parse(
      "bodies:\n" + arm +
      "initial: equilibrium\nsimulation: {step: 0.002, end: 3, output_interval: 0.01, integrator: {type: "
      "newmark, xi: -0.1}, tolerance: 1e-9, max_iterations: 12}\n");
  const auto& s = model.simulation;
  EXPECT_TRUE(s.start_at_equilibrium);
  EXPECT_EQ(s.step, 0.002);
  EXPECT_EQ(s.integrator, spec::Simulation::Integrator::newmark);
  EXPECT_EQ(s.xi, -0.1);
  EXPECT_EQ(s.max_iterations, 12);
}

TEST(ModelFile, MethodOfTheSimulation) {
  const auto of = [](const std::string& simulation) {
    return parse("bodies:\n" + arm + "simulation: " + simulation + "\n").simulation;
  };
  using S = spec::Simulation;
  const S preset = of("{step: 0.01}");
  EXPECT_EQ(preset.formulation, S::Formulation::relative);
  EXPECT_EQ(preset.inertia, S::Inertia::integrals);
  EXPECT_EQ(preset.formalism, S::Formalism::index3);
  EXPECT_EQ(preset.integrator, S::Integrator::generalized_alpha);
  const S s =
      of("{formulation: natural, inertia: projection_translations, formalism: index1_augmented, integrator: "
         "{type: "
         "hht, rho: 0.5}}");
  EXPECT_EQ(s.formulation, S::Formulation::natural);
  EXPECT_EQ(s.inertia, S::Inertia::projection_translations);
  EXPECT_EQ(s.formalism, S::Formalism::index1_augmented);
  EXPECT_EQ(s.integrator, S::Integrator::hht);
  EXPECT_EQ(s.rho, 0.5);
  EXPECT_EQ(of("{inertia: projection}").inertia, S::Inertia::projection);
  const std::vector<std::pair<std::string, S::Formalism>> formalisms{
      {"index3", S::Formalism::index3},
      {"index1", S::Formalism::index1},
      {"baumgarte", S::Formalism::baumgarte},
      {"penalty", S::Formalism::penalty},
      {"independent", S::Formalism::independent},
      {"global_modes", S::Formalism::global_modes},
      {"transfer_matrices", S::Formalism::transfer_matrices}};
  for (const auto& [name, formalism] : formalisms)
    EXPECT_EQ(of("{formalism: " + name + "}").formalism, formalism);
}

TEST(ModelFile, WarnsOfWhatIsNotUsed) {
  std::vector<Diagnostic> warnings;
  parse_model("mimbre: 1\nbodies:\n" + arm + "roads:\n  track: {over: time, points: [[0, 0], [1, 0]]}\n",
              "w.yaml", "", {}, &warnings);
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_EQ(warnings[0].mark.line, 5);
  EXPECT_NE(warnings[0].message.find("'track' is not used"), std::string::npos);
}

TEST(Examples, IltisVehicle) {
  const auto model = example("iltis/vehicle.yaml");
  EXPECT_EQ(model.bodies.size(), 17u);
  EXPECT_EQ(model.joints.size(), 25u);
  EXPECT_EQ(model.springs.size(), 8u);
  EXPECT_EQ(model.tyres.size(), 4u);
  expect_assembled(model);
  EXPECT_EQ(modes(model), (std::vector<int>{0, 4, 6, 6, 0, 4, 6, 6, 0, 4, 6, 6, 0, 4, 6, 6, 0}));
  EXPECT_EQ(output_names(model),
            (std::vector<std::string>{
                "chassis.z", "chassis.roll", "chassis.pitch", "chassis.yaw", "wheel.front_left.z",
                "wheel.front_right.z", "wheel.rear_left.z", "wheel.rear_right.z", "arm.front_left.deflection",
                "arm.front_right.deflection", "arm.rear_left.deflection", "arm.rear_right.deflection",
                "tyre.front_left.force", "tyre.front_right.force", "tyre.rear_left.force",
                "tyre.rear_right.force"}));
  EXPECT_EQ(by_name(model.joints, "free").initial_velocity.at(0), 5.0);
  // The corner lies in the results too.
  EXPECT_NE(model.text.find("# corner.yaml:"), std::string::npos);
}

/// The published forces in the nominal configuration.
TEST(Examples, IltisNominalForces) {
  const auto model =
      example("iltis/vehicle.yaml",
              {{"arms", "rigid"}, {"links", "rigid"}, {"rods", "rigid"}, {"massless_links", "true"}});
  const auto tension = [&](const spec::Spring& s) {
    return s.elastic.value((global(model, s.frame_a).position - global(model, s.frame_b).position).norm());
  };
  for (const char* corner : {"front_left", "front_right", "rear_left", "rear_right"}) {
    const std::string name = corner;
    EXPECT_NEAR(tension(by_name(model.springs, name + ".leaf")), -2728.9, 0.1) << corner;
    EXPECT_NEAR(tension(by_name(model.springs, name + ".shock")), -127.0, 0.2) << corner;
    const spec::Tyre& tyre = by_name(model.tyres, name + ".tyre");
    const double force = tyre.stiffness * (tyre.radius - global(model, tyre.frame).position.z());
    // The rounded heights miss the published force by 28 µm of compression.
    EXPECT_NEAR(force, name.starts_with("front") ? 3829.6 : 3593.6, 14) << corner;
    EXPECT_EQ(by_name(model.bodies, name + ".link").mass, 0);
  }
}

TEST(Examples, IltisMasslessLinksNeedRigidOnes) {
  EXPECT_THROW(example("iltis/vehicle.yaml", {{"massless_links", "true"}}), InputError);
  const auto stairs = example("iltis/vehicle.yaml",
                              {{"stairs", "0.2"}, {"arms", "rigid"}, {"links", "rigid"}, {"rods", "rigid"}});
  EXPECT_NEAR(stairs.roads.at(0).height.value(18), 1.0, 1e-12);
  EXPECT_NEAR(stairs.roads.at(0).height.value(10), 0.5, 1e-12);
  EXPECT_NEAR(stairs.roads.at(0).height.value(29), 0.4, 1e-12);
  EXPECT_NEAR(stairs.roads.at(0).height.value(60), 0, 1e-12);
  EXPECT_EQ(modes(stairs), std::vector<int>(17, 0));
  EXPECT_EQ(by_name(stairs.bodies, "rear_right.rod").mass, 0.9476);
}

TEST(Examples, IltisSuspension) {
  const auto model = example("iltis/suspension.yaml", {{"elements", "5"}});
  EXPECT_EQ(modes(model), (std::vector<int>{0, 4, 6, 6, 0}));
  EXPECT_EQ(model.joints.size(), 7u);
  EXPECT_EQ(output_names(model),
            (std::vector<std::string>{"chassis.z", "wheel.z", "arm.deflection", "tyre.force"}));
  EXPECT_NEAR(model.roads.at(0).height.value(3), -0.2, 1e-12);
  EXPECT_EQ(model.roads[0].over, spec::Road::Over::time);
  expect_assembled(model);
}

TEST(Examples, DoubleFourBar) {
  // Bars become flexible in the order 2, 3, 4, 5, 1, three modes each.
  const std::vector<int> order{1, 2, 3, 4, 0};
  for (int count = 0; count <= 5; ++count) {
    const auto model = example("double-four-bar/mechanism.yaml", {{"flexible_bars", std::to_string(count)}});
    std::vector<int> expected(5, 0);
    for (int k = 0; k < count; ++k)
      expected[static_cast<std::size_t>(order[static_cast<std::size_t>(k)])] = 3;
    EXPECT_EQ(modes(model), expected);
    expect_assembled(model);
    EXPECT_EQ(output_names(model), std::vector<std::string>{"theta"});
    EXPECT_EQ(by_name(model.joints, "A").initial_velocity.at(0), -1.0);
    EXPECT_EQ(model.joints.size(), 7u);
  }
  const auto model = example("double-four-bar/mechanism.yaml", {{"flexible_bars", "5"}});
  // Equal bars are reduced once; first fixed-interface mode in the plane, not out of it.
  for (const auto& body : model.bodies) EXPECT_EQ(body.flexible, model.bodies[0].flexible);
  EXPECT_NEAR(model.bodies[0].flexible->mass, 1, 1e-9);
  for (const auto& frame : model.bodies[0].flexible->frames) {
    EXPECT_LT(frame.X.row(2).norm(), 1e-12);
    EXPECT_LT(frame.X_theta.topRows(2).norm(), 1e-12);
  }
}

TEST(Examples, PendulumAndSliderCrank) {
  const auto pendulum = example("pendulum/flexible.yaml");
  EXPECT_EQ(modes(pendulum), std::vector<int>{3});
  EXPECT_EQ(output_names(pendulum),
            (std::vector<std::string>{"angle", "tip.z", "tip.deflection", "hinge.fz"}));
  EXPECT_NEAR(example("pendulum/flexible.yaml", {{"bar", "rigid"}}).bodies[0].mass,
              pendulum.bodies[0].flexible->mass, 1e-9);
  expect_assembled(pendulum);
  const auto crank = example("slider-crank/slider-crank.yaml");
  EXPECT_EQ(modes(crank), (std::vector<int>{0, 4, 0}));
  EXPECT_EQ(crank.joints.size(), 4u);
  EXPECT_NEAR(by_name(crank.joints, "main").drives.at(0).law.value(0.5), 15, 1e-12);
  expect_assembled(crank);
}

/// A length is `l` or `x`, a rate `v` or `x`, in every law; `?:` chooses in all of them.
TEST(ModelFileLaws, OneTableOfVariables) {
  const spec::Model model = parse(R"(parameters:
  stiff: {value: yes_, choices: [yes_, no_]}
bodies:
  arm: {mass: 1, com: [0.5, 0, 0], inertia: [1, 1, 1]}
joints:
  hinge:
    type: revolute
    between: [ground, arm]
    at: [0, 0, 0]
    axis: [0, 1, 0]
    spring: {elastic: "l > 1 ? 2*l : 3*x", damping: "v > 0 ? 4*v : 5*x"}
springs:
  split: {between: [ground, arm], at: [[1, 0, 1], [1, 0, 0]], elastic: "6*l", damping: "7*v"}
  force: {between: [ground, arm], at: [[1, 0, 2], [1, 0, 0]], force: "l > 1 ? 10*x + v : t > 2 ? 1 : 0/0"}
  word: {between: [ground, arm], at: [[1, 0, 2], [1, 0, 0]], force: "stiff == no_ ? 8*l : 9*l"}
loads:
  push: {on: arm, force: [1, 0, 0], scale: "t < 1 ? 0 : 2"}
)");
  const spec::JointSpring& hinge = by_name(model.joints, "hinge").springs.at(0);
  EXPECT_EQ(hinge.elastic.value(2), 4);
  EXPECT_EQ(hinge.elastic.value(1), 3);
  EXPECT_EQ(hinge.damping.value(2), 8);
  EXPECT_EQ(hinge.damping.value(-1), -5);
  EXPECT_EQ(by_name(model.springs, "split").elastic.value(2), 12);
  EXPECT_EQ(by_name(model.springs, "split").damping.value(2), 14);
  const Formula& force = by_name(model.springs, "force").general.formula;
  EXPECT_EQ(force.value(std::array{2.0, 3.0, 0.0}.data()), 23);
  EXPECT_EQ(force.value(std::array{0.5, 3.0, 3.0}.data()), 1);
  EXPECT_NEAR(force.derivatives(std::array{2.0, 3.0, 0.0}.data()).first, 10, 1e-9);
  EXPECT_EQ(by_name(model.springs, "word").general.formula.value(std::array{2.0, 0.0, 0.0}.data()), 18);
  EXPECT_EQ(by_name(model.loads, "push").scale.value(1), 2);
}

/// The start of a drive may lie where a branch that is not taken has no value.
TEST(ModelFileLaws, ABranchThatIsNotTakenMayBeNoNumber) {
  const spec::Model model = parse(R"(parameters: {ramp: 0, slope: "ramp > 0 ? 1/ramp : 0.6"}
bodies: {arm: {mass: 1, com: [0.5, 0, 0], inertia: [1, 1, 1]}}
joints:
  A:
    type: revolute
    between: [ground, arm]
    at: [0, 0, 0]
    axis: [0, 0, 1]
    drive: {position: "t < ramp ? t^2/ramp : slope*t"}
)");
  const Function& drive = by_name(model.joints, "A").drives.at(0).law;
  EXPECT_NEAR(drive.derivative(0), 0.6, 1e-9);
  EXPECT_NEAR(drive.second_derivative(0), 0, 1e-7);
}

}  // namespace
}  // namespace mimbre::model_file_test
