#include "mimbre/urdf.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "dynamics/relative/system.h"
#include "mimbre/model_file.h"
#include "mimbre/simulation.h"
#include "spec/force_law.h"
#include "support/simulate.h"

namespace mimbre::urdf_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string data = MIMBRE_SOURCE_DIR "/tests/data/urdf/";

/// A robot's file that goes with the test.
class UrdfFile : public testing::Test {
 protected:
  UrdfFile() { fs::create_directories(folder_); }
  ~UrdfFile() override { fs::remove_all(folder_); }
  std::string file(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  ConvertedRobot convert(const std::string& content, const UrdfOptions& options = {}) const {
    return convert_urdf(file("robot.urdf", "<robot name=\"r\">\n" + content + "</robot>\n"), options);
  }
  spec::Model model(const std::string& content, const UrdfOptions& options = {}) const {
    return parse_model(convert(content, options).text, "robot.yaml", folder_.string());
  }
  std::string refusal(const std::string& content) const {
    try {
      convert(content);
    } catch (const InputError& error) {
      return error.what();
    }
    return "nothing is wrong";
  }
  fs::path folder_ = fs::path(testing::TempDir()) / fmt::format("mimbre_urdf_{}", getpid());
};

std::string all_of(const ConvertedRobot& robot) {
  std::string text;
  for (const Diagnostic& note : robot.notes) text += to_string(note) + "\n";
  return text;
}

std::string link(const std::string& name, const std::string& more = "") {
  return fmt::format(
      "<link name=\"{}\"><inertial><origin xyz=\"0.1 0 0\"/><mass value=\"2\"/><inertia ixx=\"1\" iyy=\"1\" "
      "izz=\"1\"/>"
      "</inertial>{}</link>\n",
      name, more);
}
std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& more = "<axis xyz=\"0 0 1\"/>") {
  return fmt::format("<joint name=\"{}\" type=\"{}\"><parent link=\"{}\"/><child link=\"{}\"/>{}</joint>\n",
                     name, type, parent, child, more);
}

template <class Thing>
const Thing& named(const std::vector<Thing>& things, const std::string& name) {
  for (const Thing& thing : things)
    if (thing.name == name) return thing;
  throw std::runtime_error("nothing is called " + name);
}

/// What Pinocchio says of a robot (tests/urdf/reference.py).
struct Reference {
  struct Placed {
    std::string name;
    Eigen::Vector3d position;
    Eigen::Matrix3d rotation;
  };
  struct Instant {
    Eigen::VectorXd q, v, a, tau;
    std::vector<Placed> links;
  };
  double mass = 0;
  std::vector<std::string> joints;
  std::vector<Instant> instants;
};

Reference reference(const std::string& robot) {
  Reference result;
  std::ifstream file(data + "reference.txt");
  bool ours = false;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string word, name;
    words >> word;
    if (word == "robot") {
      int count = 0;
      words >> name >> count;
      ours = name == robot;
      if (ours) words >> result.mass;
    }
    if (!ours) continue;
    if (word == "joint") result.joints.emplace_back(), words >> result.joints.back();
    if (word == "state") result.instants.emplace_back();
    const auto vector = [&](Eigen::VectorXd& to) {
      to.resize(static_cast<Eigen::Index>(result.joints.size()));
      for (double& value : to) words >> value;
    };
    if (word == "q") vector(result.instants.back().q);
    if (word == "v") vector(result.instants.back().v);
    if (word == "a") vector(result.instants.back().a);
    if (word == "tau") vector(result.instants.back().tau);
    if (word == "link") {
      auto& placed = result.instants.back().links.emplace_back();
      words >> placed.name;
      for (double& value : placed.position) words >> value;
      for (int k = 0; k < 9; ++k) words >> placed.rotation(k / 3, k % 3);
    }
  }
  return result;
}

/// Three public robots, and random ones.
class ReferenceRobots : public testing::TestWithParam<const char*> {};

/// Places of all links and torques of all joints in random motions, by an independent library.
TEST_P(ReferenceRobots, MoveAsPinocchioSays) {
  const Reference expected = reference(GetParam());
  ASSERT_EQ(expected.instants.size(), 5u);
  for (const bool keep_fixed : {false, true}) {
    UrdfOptions options;
    options.keep_fixed = keep_fixed;
    const ConvertedRobot robot = convert_urdf(data + GetParam() + ".urdf", options);
    if (all_of(robot).find("no matter has") != std::string::npos) {
      // Cameras on fixed joints, whose file says what cannot be; merged with what carries them they are no
      // matter.
      EXPECT_TRUE(keep_fixed && GetParam() == std::string("anymal"));
      continue;
    }
    spec::Model spec = parse_model(robot.text, "robot.yaml", MIMBRE_SOURCE_DIR);
    double mass = 0;
    for (const spec::Body& body : spec.bodies) mass += body.mass;
    const double base = mass - expected.mass;  // which Pinocchio leaves out, since it stands
    EXPECT_GT(base, -1e-9);
    // Only what the links' masses need.
    for (spec::Joint& j : spec.joints) j.springs.clear();
    spec.elements.clear();
    const auto model = Model::compile(spec);
    const Compiled& c = model->compiled();
    ASSERT_EQ(c.velocities, static_cast<int>(expected.joints.size()));
    // The coordinate of a joint is that of the body which it carries.
    std::vector<int> place;
    for (const std::string& name : expected.joints) {
      const spec::Joint& j = named(spec.joints, name);
      const int body = spec.frames[static_cast<std::size_t>(j.frame_b)].body;
      place.push_back(c.bodies[c.body_of_spec[static_cast<std::size_t>(body)]].v);
    }
    relative::RelativeSystem system(c);
    for (const Reference::Instant& instant : expected.instants) {
      const auto n = static_cast<Eigen::Index>(place.size());
      Eigen::VectorXd q(n), v(n), a(n), r(n);
      // Joints that mimic others move freely here: their couplings have no forces.
      const Eigen::VectorXd none = Eigen::VectorXd::Zero(c.equations);
      for (Eigen::Index k = 0; k < n; ++k) {
        const int at = place[static_cast<std::size_t>(k)];
        q[at] = instant.q[k], v[at] = instant.v[k], a[at] = instant.a[k];
      }
      system.begin_step(q.data());
      system.residual(0, q.data(), v.data(), a.data(), none.data(), 0, r.data());
      const double scale = instant.tau.cwiseAbs().maxCoeff();
      for (Eigen::Index k = 0; k < n; ++k)
        EXPECT_NEAR(r[place[static_cast<std::size_t>(k)]], instant.tau[k], 1e-9 * scale)
            << expected.joints[static_cast<std::size_t>(k)];
      const auto& w = system.workspace();
      for (const auto& placed : instant.links) {
        if (placed.name == "world" && GetParam() == std::string("panda")) continue;
        const spec::Frame& frame = named(spec.frames, placed.name);
        spec::Pose pose = frame.pose;
        if (frame.body >= 0) {
          const auto& motion = w.bodies[c.body_of_spec[static_cast<std::size_t>(frame.body)]];
          const Eigen::Matrix3d rotation = Eigen::Matrix3d(motion.rotation);
          pose.position = motion.position + w.origin + rotation * frame.pose.position;
          pose.rotation = rotation * frame.pose.rotation;
        }
        EXPECT_LT((pose.position - placed.position).norm(), 1e-9) << placed.name;
        EXPECT_LT((pose.rotation - placed.rotation).norm(), 1e-9) << placed.name;
      }
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Files, ReferenceRobots, testing::Values("ur5", "panda", "anymal"));
INSTANTIATE_TEST_SUITE_P(RandomTrees, ReferenceRobots,
                         testing::Values("tree1", "tree2", "tree3", "tree4", "tree5", "tree6", "tree7"));

TEST(PublicRobot, HasTheLimitsFrictionAndFollowersOfItsFile) {
  const ConvertedRobot robot = convert_urdf(data + "panda.urdf");
  const spec::Model model = parse_model(robot.text, "panda.yaml", "");
  const spec::Element& stop = named(model.elements, "panda_joint4_stop");
  EXPECT_EQ(stop.law, "stop");
  EXPECT_THAT(
      robot.text,
      AllOf(HasSubstr("panda_joint4_stop: {joint: panda_joint4, lower: -3.0718, upper: -0.0698"),
            HasSubstr("panda_finger_joint1_stop: {joint: panda_finger_joint1, lower: 0, upper: 0.04")));
  ASSERT_TRUE(named(model.joints, "panda_joint4").initial_position.at(0));
  EXPECT_NEAR(*named(model.joints, "panda_joint4").initial_position[0], -1.5708, 1e-12);
  EXPECT_EQ(named(model.joints, "panda_finger_joint1").type, spec::JointType::prismatic);
  EXPECT_THAT(robot.text,
              HasSubstr("panda_finger_joint2_mimic: {type: coupling, terms: [{joint: panda_finger_joint2, "
                        "factor: 1}, {joint: panda_finger_joint1, factor: -1}], constant: 0}"));
  EXPECT_THAT(all_of(robot), AllOf(HasSubstr("left out: 17 <collision>"), HasSubstr("11 meshes are left out"),
                                   HasSubstr("--package example-robot-data=FOLDER")));
}

/// The inertial's axes are turned, the visual's too, and the link hangs by a fixed joint at an angle.
TEST_F(UrdfFile, MergedLinksKeepTheirMassAndPlace) {
  const std::string content =
      "<link name=\"a\"><inertial><origin xyz=\"0.1 0.2 0.3\" rpy=\"0.3 0.2 0.1\"/><mass value=\"2\"/>"
      "<inertia ixx=\"1\" iyy=\"2\" izz=\"2.5\" ixy=\"0.1\" ixz=\"0.2\" iyz=\"0.3\"/></inertial></link>\n"
      "<link name=\"b\"><inertial><origin xyz=\"0 0.1 0\" rpy=\"1 2 3\"/><mass value=\"3\"/>"
      "<inertia ixx=\"2\" iyy=\"2\" izz=\"1\"/></inertial>"
      "<visual><origin rpy=\"0 1.5707963267948966 0\"/><geometry><cylinder radius=\"0.1\" "
      "length=\"0.5\"/></geometry></visual></link>\n" +
      joint("ab", "fixed", "a", "b", "<origin xyz=\"1 0 0\" rpy=\"0 0 1.5707963267948966\"/>");
  UrdfOptions floating;
  floating.floating = true;
  const spec::Model merged = model(content, floating);
  floating.keep_fixed = true;
  const spec::Model kept = model(content, floating);
  ASSERT_EQ(merged.bodies.size(), 1u);
  ASSERT_EQ(kept.bodies.size(), 2u);
  // Mass, first and second moments about the origin, in global axes.
  const auto moments = [](const spec::Model& m) {
    double mass = 0;
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (const spec::Body& body : m.bodies) {
      const Eigen::Vector3d c = body.pose.position + body.pose.rotation * body.com;
      mass += body.mass;
      first += body.mass * c;
      second += body.pose.rotation * body.inertia * body.pose.rotation.transpose() +
                body.mass * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
    }
    return std::tuple(mass, first, second);
  };
  const auto [mass, first, second] = moments(merged);
  const auto [mass2, first2, second2] = moments(kept);
  EXPECT_EQ(mass, 5);
  EXPECT_EQ(mass2, 5);
  // By hand: a's centre is (0.1, 0.2, 0.3), b's is (1, 0, 0) + (−0.1, 0, 0).
  EXPECT_LT((first - Eigen::Vector3d(2 * 0.1 + 3 * 0.9, 2 * 0.2, 2 * 0.3)).norm(), 1e-14);
  EXPECT_LT((first - first2).norm(), 1e-14);
  EXPECT_LT((second - second2).norm(), 1e-13);
  ASSERT_EQ(merged.bodies[0].shapes.size(), 1u);
  // About z by 90°, then the cylinder's z turned about y into x: along the global y.
  const spec::Body& body = merged.bodies[0];
  EXPECT_LT(((body.pose.rotation * body.shapes[0].pose.rotation).col(2) - Eigen::Vector3d(0, 1, 0)).norm(),
            1e-12);
  EXPECT_LT((named(merged.frames, "b").pose.position - Eigen::Vector3d(1, 0, 0)).norm(), 1e-15);
}

TEST_F(UrdfFile, DampingFrictionAndLimitsBecomeElements) {
  const std::string content =
      link("base") + link("arm") + link("slider") + link("wheel") +
      joint("hinge", "revolute", "base", "arm",
            "<axis xyz=\"0 2 0\"/><limit lower=\"-1\" upper=\"0.5\" effort=\"20\" velocity=\"1\"/>"
            "<dynamics damping=\"0.7\" friction=\"0.3\"/>") +
      joint("rail", "prismatic", "arm", "slider", "<limit lower=\"0\" upper=\"0.2\"/>") +
      joint("axle", "continuous", "arm", "wheel",
            "<axis xyz=\"0 0 1\"/><limit effort=\"3\" velocity=\"1\"/>");
  const ConvertedRobot robot = convert(content);
  EXPECT_THAT(robot.text, AllOf(HasSubstr("hinge_friction: {joint: hinge, torque: 0.3}"),
                                HasSubstr("hinge_stop: {joint: hinge, lower: -1, upper: 0.5, stiffness: "),
                                HasSubstr("rail_stop: {joint: rail, lower: 0, upper: 0.2, stiffness: "),
                                HasSubstr("axis: [0, 1, 0], spring: {stiffness: 0, damping: 0.7}")));
  EXPECT_THAT(all_of(robot), AllOf(HasSubstr("assumed"), HasSubstr("effort and speed of 2 joints")));
  const spec::Model m = parse_model(robot.text, "robot.yaml", "");
  EXPECT_EQ(m.elements.size(), 3u);
  const auto stop_number = [&](const char* stop, const std::string& key) {
    const auto numbers = law_info(find_law("stop")).numbers;
    const auto number =
        std::find_if(numbers.begin(), numbers.end(), [&](const LawNumber& one) { return one.key == key; });
    return named(m.elements, stop).numbers.at(static_cast<std::size_t>(number - numbers.begin()));
  };
  for (const char* stop : {"hinge_stop", "rail_stop"}) EXPECT_EQ(stop_number(stop, "restitution"), 0.1);
  EXPECT_EQ(stop_number("hinge_stop", "lower"), -1);
  EXPECT_EQ(stop_number("hinge_stop", "upper"), 0.5);
  // By hand, to the three digits that are written: at the start the hinge turns three centres 0.1 m off it.
  // The slider is nearest to it there; the wheel's centre may come as near as 0 elsewhere. The rail lies
  // along x, as joints without an axis do, and pushes the slider straight away from the hinge.
  const double rate = EIGEN_PI / 0.05, link = 1 + 2 * 0.1 * 0.1;
  EXPECT_GT(stop_number("hinge_stop", "stiffness"), 0.995 * (link + link + 1) * rate * rate);
  EXPECT_LT(stop_number("hinge_stop", "stiffness"), 1.005 * 3 * link * rate * rate);
  EXPECT_NEAR(stop_number("rail_stop", "stiffness"), 2 * rate * rate, 0.005 * 2 * rate * rate);
  Simulation simulation(Model::compile(m));
  for (int k = 0; k < 20; ++k) EXPECT_TRUE(simulation.step().ok()) << k;
}

/// A gripper whose second finger follows the first: half as far, from 0.05 on.
TEST_F(UrdfFile, MimicJointsFollow) {
  const ConvertedRobot robot =
      convert(link("hand") + link("one") + link("two") + joint("first", "prismatic", "hand", "one") +
              joint("second", "prismatic", "hand", "two",
                    "<axis xyz=\"0 0 1\"/><mimic joint=\"first\" multiplier=\"-0.5\" offset=\"0.05\"/>"));
  const auto model = Model::compile(parse_model(robot.text, "robot.yaml", ""));
  EXPECT_EQ(model->constraints(), 1);
  for (const auto formulation :
       {spec::Simulation::Formulation::relative, spec::Simulation::Formulation::natural}) {
    Simulation simulation = test::simulation_of(model, formulation);
    for (int k = 0; k < 20; ++k) ASSERT_TRUE(simulation.step().ok());
    const double first = test::channel(simulation, "first"), second = test::channel(simulation, "second");
    // The first falls with −g (m − m/2)/(m + m/4).
    const double t = simulation.time();
    EXPECT_NEAR(first, -0.5 * 9.81 * 0.4 * t * t, 1e-9);
    EXPECT_NEAR(second, 0.05 - 0.5 * first, 1e-9);
  }
}

TEST_F(UrdfFile, MeshesAreFoundByPackageAndPath) {
  file("my_robot/meshes/arm.STL", "");
  fs::copy_file(MIMBRE_SOURCE_DIR "/tests/data/surfaces/block.stl", folder_ / "my_robot/meshes/arm.STL",
                fs::copy_options::overwrite_existing);
  fs::copy_file(MIMBRE_SOURCE_DIR "/tests/data/surfaces/block.obj", folder_ / "my_robot/meshes/hand.obj");
  const auto mesh = [](const std::string& name, const std::string& more = "") {
    return fmt::format(
        "<visual><origin xyz=\"0 0 1\"/><geometry><mesh filename=\"{}\"{}/></geometry></visual>", name, more);
  };
  const std::string robot =
      "<robot name=\"r\">" +
      link("arm", mesh("package://my_robot/meshes/arm.STL", " scale=\"0.001 -0.001 0.001\"") +
                      mesh("../meshes/hand.obj") + mesh("package://other/lost.stl") +
                      mesh("../meshes/arm.step")) +
      "</robot>";
  const std::string path = file("my_robot/urdf/robot.urdf", robot);
  UrdfOptions options;
  options.folder = folder_.string();
  const ConvertedRobot converted = convert_urdf(path, options);
  EXPECT_THAT(
      converted.text,
      AllOf(HasSubstr("{mesh: my_robot/meshes/arm.STL, at: [0, 0, 1], scale: [0.001, -0.001, 0.001]}"),
            HasSubstr("{mesh: my_robot/meshes/hand.obj, at: [0, 0, 1]}")));
  EXPECT_THAT(all_of(converted),
              AllOf(HasSubstr("package://other/lost.stl"), HasSubstr("--package other=FOLDER"),
                    HasSubstr("format is not known")));
  EXPECT_EQ(parse_model(converted.text, "robot.yaml", folder_.string()).bodies[0].shapes.size(), 2u);
  file("elsewhere/lost.stl", "");
  options.packages = {{"other", (folder_ / "elsewhere").string()}};
  EXPECT_THAT(convert_urdf(path, options).text, HasSubstr("elsewhere/lost.stl"));
}

TEST_F(UrdfFile, NamesThatAModelCannotHaveAreChanged) {
  const spec::Model m =
      model(link("ground") + link("left arm") + link("left/arm") + link("true") +
            joint("a b", "revolute", "ground", "left arm") + joint("a/b", "planar", "ground", "left/arm") +
            joint("c", "floating", "left arm", "true"));
  std::vector<std::string> bodies, joints;
  for (const spec::Body& body : m.bodies) bodies.push_back(body.name);
  for (const spec::Joint& j : m.joints) joints.push_back(j.name);
  EXPECT_THAT(bodies, testing::ElementsAre("ground_", "left_arm", "true_", "left_arm_2"));
  EXPECT_THAT(joints, testing::ElementsAre("ground__to_ground", "a_b", "c", "a_b_2"));
}

TEST_F(UrdfFile, MistakesAreToldWithTheirPlace) {
  EXPECT_THAT(refusal("<link"), AllOf(HasSubstr("robot.urdf:"), HasSubstr("is no XML")));
  EXPECT_THAT(refusal(link("a") + joint("j", "revolut", "a", "a")),
              AllOf(HasSubstr("robot.urdf:3:1: "), HasSubstr("did you mean 'revolute'")));
  EXPECT_THAT(refusal(link("arm") + link("b") + joint("j", "fixed", "arn", "b")),
              HasSubstr("parent link 'arn' is not there (did you mean 'arm'?)"));
  EXPECT_THAT(refusal(link("a") + link("b") + joint("i", "fixed", "a", "b") + joint("j", "fixed", "a", "b")),
              HasSubstr("a URDF is a tree"));
  EXPECT_THAT(refusal(link("a") + link("b") + joint("i", "fixed", "a", "b") + joint("j", "fixed", "b", "a")),
              HasSubstr("in a ring"));
  EXPECT_THAT(refusal(link("a") + link("b")), HasSubstr("carried by nothing"));
  EXPECT_THAT(refusal(link("a") + link("a")), HasSubstr("there are two links 'a'"));
  EXPECT_THAT(refusal(link("a") + link("b") + joint("j", "revolute", "a", "b", "<axis xyz=\"0 0 0\"/>")),
              HasSubstr("the axis has no length"));
  EXPECT_THAT(refusal(link("a") + link("b") + joint("j", "revolute", "a", "b", "<origin xyz=\"0 nan 0\"/>")),
              HasSubstr("is not 3 finite numbers"));
  EXPECT_THAT(
      refusal(link("a") + link("b") + joint("j", "revolute", "a", "b", "<limit lower=\"1\" upper=\"0\"/>")),
      HasSubstr("above the upper"));
  EXPECT_THAT(refusal(link("a") + link("b") + joint("j", "revolute", "a", "b", "<mimic joint=\"k\"/>")),
              HasSubstr("mimics 'k', which is not there"));
  EXPECT_THAT(refusal("<xacro:include filename=\"x\"/>"), HasSubstr("program xacro first"));
  EXPECT_THAT(refusal(""), HasSubstr("has no links"));
  EXPECT_THAT(refusal("<link name=\"a\"><inertial><mass value=\"-1\"/></inertial></link>"),
              HasSubstr("mass -1 is negative"));
  EXPECT_THROW(convert_urdf("/nowhere/robot.urdf"), InputError);
}

TEST_F(UrdfFile, WhatCannotMoveIsTold) {
  EXPECT_THAT(all_of(convert(link("a") + "<link name=\"b\"/>" + joint("j", "revolute", "a", "b"))),
              HasSubstr("moves but has no mass"));
  EXPECT_THAT(all_of(convert("<link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" "
                             "izz=\"9\"/></inertial></link>")),
              HasSubstr("no matter has the principal moments"));
}

/// Names that may stay do so, whatever comes first; each that changes is told, where the model has it.
TEST_F(UrdfFile, NamesChangeWhereTheyHaveToAndAreTold) {
  const std::string axis = "<axis xyz=\"0 1 0\"/>", umlaut = std::string(89, 'x') + "ä";
  const ConvertedRobot robot = convert(
      link("ground") + link("left arm") + link("left_arm") + link("left_arm_2") + link(umlaut) +
      joint("the first", "continuous", "ground", "left arm", axis) +
      joint("the_first", "continuous", "left arm", "left_arm", axis + "<mimic joint=\"the first\"/>") +
      joint("a fixed one", "fixed", "left_arm", "left_arm_2") +
      joint("last", "continuous", "left_arm_2", umlaut, axis));
  const spec::Model m = parse_model(robot.text, "robot.yaml", "");
  const auto body = [&](const char* of_joint) {
    const spec::Frame& frame = m.frames[static_cast<std::size_t>(named(m.joints, of_joint).frame_b)];
    return m.bodies[static_cast<std::size_t>(frame.body)].name;
  };
  EXPECT_EQ(body("the_first"), "left_arm");
  EXPECT_EQ(body("the_first_2"), "left_arm_3");
  EXPECT_EQ(named(m.frames, "left_arm_2").name, "left_arm_2");
  const std::string notes = all_of(robot);
  EXPECT_THAT(notes, AllOf(HasSubstr("link 'ground' is called 'ground_' in the model"),
                           HasSubstr("link 'left arm' is called 'left_arm_3' in the model"),
                           HasSubstr("joint 'the first' is called 'the_first_2' in the model"),
                           HasSubstr("ä' is called '" + std::string(89, 'x') + "' in the model"),
                           Not(HasSubstr("a fixed one")), Not(HasSubstr("'left_arm'"))));
  EXPECT_THAT(robot.text, HasSubstr("line 2: link 'ground' is called 'ground_' in the model"));
}

TEST_F(UrdfFile, WithoutMassAndShapesThereIsNoBody) {
  const char* what = "no link has a mass or a shape";
  const std::string frames = "<link name=\"a\"/><link name=\"b\"/>" + joint("j", "fixed", "a", "b");
  EXPECT_THAT(all_of(convert(frames)), HasSubstr(what));
  EXPECT_THAT(all_of(convert(link("a"))), Not(HasSubstr(what)));
}

/// Half a period of the inertia (J + m a², at the fixed base) on the stop takes five default steps.
TEST_F(UrdfFile, StopsAreAsStiffAsTheInertiaStands) {
  const ConvertedRobot robot =
      convert(link("base") + link("arm") +
              joint("hinge", "revolute", "base", "arm",
                    "<axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" effort=\"1e6\" velocity=\"1\"/>"));
  const double rate = EIGEN_PI / 0.05, inertia = 1 + 2 * 0.1 * 0.1;
  EXPECT_THAT(robot.text, AllOf(HasSubstr(fmt::format("stiffness: {:.3g}", inertia * rate * rate)),
                                HasSubstr("# 1.02 kg m2")));
}

/// The arm lies on its stop, and falls on it without gravity.
TEST_F(UrdfFile, StopsAreAsSoftAsTheirNoteSays) {
  const ConvertedRobot robot =
      convert(link("base") + link("arm") +
              joint("hinge", "revolute", "base", "arm",
                    "<axis xyz=\"0 1 0\"/><limit lower=\"-1\" upper=\"0\" effort=\"1\" velocity=\"1\"/>"));
  const std::string note =
      "They are soft: an impact at 1 rad/s or m/s goes up to 0.016 rad or m deep, a load by 0.00025 s² times "
      "the "
      "acceleration of the free joint";
  EXPECT_THAT(robot.text, HasSubstr(note));
  EXPECT_THAT(all_of(robot), HasSubstr(note));
  const auto formulation = spec::Simulation::Formulation::relative;
  spec::Model resting = parse_model(robot.text, "robot.yaml", "");
  Simulation on_stop = test::simulation_of(Model::compile(resting), formulation);
  for (int k = 0; k < 200; ++k) ASSERT_TRUE(on_stop.step().ok());
  // Of the free joint: m g a/(J + m a²).
  const double acceleration = 2 * 9.81 * 0.1 / (1 + 2 * 0.1 * 0.1), softness = std::pow(0.05 / EIGEN_PI, 2);
  EXPECT_NEAR(test::channel(on_stop, "hinge"), acceleration * softness, 0.01 * acceleration * softness);
  spec::Model thrown = resting;
  thrown.gravity.setZero();
  thrown.joints.at(1).initial_velocity = {1.0};
  Simulation impact = test::simulation_of(Model::compile(thrown), formulation, 1e-3);
  double depth = 0;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(impact.step().ok());
    depth = std::max(depth, test::channel(impact, "hinge"));
  }
  // Without what the impact's damper takes it would go as deep as the note says.
  EXPECT_LT(depth, std::sqrt(softness));
  EXPECT_GT(depth, 0.3 * std::sqrt(softness));
}

/// Half a period of the inertia on the friction's bristles takes a default step; where 1e-5 rad is softer,
/// that is left.
TEST_F(UrdfFile, FrictionsGiveAsTheInertiaStands) {
  const auto friction = [](const std::string& value) {
    return link("base") + link("arm") +
           joint("hinge", "continuous", "base", "arm",
                 "<axis xyz=\"0 0 1\"/><dynamics friction=\"" + value + "\"/>");
  };
  const double inertia = 1 + 2 * 0.1 * 0.1, rate = EIGEN_PI / 0.01;
  const ConvertedRobot robot = convert(friction("40"));
  EXPECT_THAT(robot.text, AllOf(HasSubstr(fmt::format("sticking: {:.3g}}}", 40 / (inertia * rate * rate))),
                                HasSubstr("# 1.02 kg m2")));
  EXPECT_THAT(all_of(robot), HasSubstr("'sticking' of frictions is assumed"));
  EXPECT_THAT(convert(friction("0.5")).text, Not(HasSubstr("sticking")));
}

/// Gravity about the hinge is below the friction: the arm goes down by what the bristles give, and stays.
TEST_F(UrdfFile, WhatSticksGivesAsItsNoteSays) {
  const ConvertedRobot robot = convert(
      link("base") + link("arm") +
      joint("hinge", "continuous", "base", "arm", "<axis xyz=\"0 1 0\"/><dynamics friction=\"40\"/>"));
  const auto model = Model::compile(parse_model(robot.text, "robot.yaml", ""));
  Simulation simulation = test::simulation_of(model, spec::Simulation::Formulation::relative);
  for (int k = 0; k < 200; ++k) ASSERT_TRUE(simulation.step().ok());
  // Of the free joint: m g a/(J + m a²).
  const double acceleration = 2 * 9.81 * 0.1 / (1 + 2 * 0.1 * 0.1), softness = std::pow(0.01 / EIGEN_PI, 2);
  EXPECT_NEAR(test::channel(simulation, "hinge"), acceleration * softness, 0.01 * acceleration * softness);
}

TEST_F(UrdfFile, MasslessLinksOnFixedJointsKeepTheirInertia) {
  UrdfOptions floating;
  floating.floating = true;
  const std::string content =
      link("a") +
      "<link name=\"b\"><inertial><inertia ixx=\"0.1\" iyy=\"0.2\" izz=\"0.25\"/></inertial></link>" +
      joint("j", "fixed", "a", "b", "<origin xyz=\"1 0 0\" rpy=\"0 0 1.5707963267948966\"/>");
  for (const bool keep : {false, true}) {
    floating.keep_fixed = keep;
    const Eigen::Vector3d moments = model(content, floating).bodies[0].inertia.diagonal();
    EXPECT_LT((moments - Eigen::Vector3d(1.2, 1.1, 1.25)).norm(), 1e-12) << keep;
  }
}

/// Lower = upper, and followers of what is fixed, at the place that they have.
TEST_F(UrdfFile, JointsThatCannotMoveAreFixed) {
  const ConvertedRobot robot =
      convert(link("a") + link("b") + link("c") + link("d") +
              joint("still", "prismatic", "a", "b",
                    "<axis xyz=\"0 0 1\"/><limit lower=\"0.2\" upper=\"0.2\" effort=\"1\" velocity=\"1\"/>") +
              joint("mimic", "prismatic", "b", "c",
                    "<axis xyz=\"0 0 1\"/><mimic joint=\"still\" multiplier=\"2\" offset=\"0.1\"/>") +
              joint("free", "revolute", "c", "d"));
  EXPECT_THAT(all_of(robot), AllOf(HasSubstr("joint 'still' is fixed at 0.2: its lower limit is its upper"),
                                   HasSubstr("joint 'mimic' is fixed at 0.5: it mimics 'still'")));
  const spec::Model m = parse_model(robot.text, "robot.yaml", "");
  EXPECT_EQ(m.joints.size(), 2u);
  EXPECT_NEAR(named(m.bodies, "d").pose.position.z(), 0.7, 1e-12);
}

TEST_F(UrdfFile, WhatNoMatterCanHaveIsRepairedAndListed) {
  UrdfOptions repair;
  repair.repair = true;
  const std::string content =
      link("a") +
      "<link name=\"b\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" "
      "izz=\"9\"/></inertial></link>"
      "<link name=\"c\"><visual><geometry><box size=\"0.1 0.2 0.3\"/></geometry></visual></link>" +
      joint("ab", "revolute", "a", "b") + joint("bc", "revolute", "b", "c");
  const ConvertedRobot robot = convert(content, repair);
  ASSERT_EQ(robot.repairs.size(), 2u);
  EXPECT_THAT(robot.repairs[0].message, HasSubstr("link 'b': principal moments [1, 1, 9] are"));
  EXPECT_THAT(robot.repairs[1].message, HasSubstr("link 'c': mass 0 is 6 kg"));
  const spec::Model m = parse_model(robot.text, "robot.yaml", "");
  const spec::Body& box = named(m.bodies, "c");
  EXPECT_NEAR(box.mass, 6, 1e-9);
  EXPECT_LT((box.inertia.diagonal() - Eigen::Vector3d(0.065, 0.05, 0.025)).norm(), 1e-9);
  Simulation simulation(Model::compile(m));
  for (int k = 0; k < 20; ++k) EXPECT_TRUE(simulation.step().ok()) << k;
}

TEST_F(UrdfFile, CapsulesAreDrawnAndUnknownShapesLeftOut) {
  const ConvertedRobot robot =
      convert(link("a",
                   "<visual><geometry><capsule radius=\"0.1\" length=\"0.3\"/></geometry></visual>"
                   "<visual><geometry><torus/></geometry></visual>"));
  EXPECT_EQ(parse_model(robot.text, "robot.yaml", "").bodies[0].shapes.size(), 3u);
  EXPECT_THAT(all_of(robot), HasSubstr("of the kind <torus> is left out"));
}

/// URDF has one shape in a <geometry>; some files have several.
TEST_F(UrdfFile, AllShapesOfAVisualAreDrawn) {
  const ConvertedRobot robot =
      convert(link("a",
                   "<visual><origin xyz=\"0 0 0.5\"/><geometry><box size=\"1 2 3\"/><torus/>"
                   "<sphere radius=\"0.1\"/></geometry></visual>"
                   "<visual><geometry/></visual>"));
  EXPECT_THAT(robot.text, AllOf(HasSubstr("{box: [1, 2, 3], at: [0, 0, 0.5]}"),
                                HasSubstr("{sphere: 0.1, at: [0, 0, 0.5]}")));
  EXPECT_THAT(all_of(robot), AllOf(HasSubstr("of the kind <torus> is left out"),
                                   HasSubstr("a <visual> without a <geometry> is left out")));
}

}  // namespace
}  // namespace mimbre::urdf_test
