#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "mimbre/model_builder.h"
#include "mimbre/simulation.h"
#include "support/models.h"
#include "support/simulate.h"

/// Constraints between two bodies against motions that are known.
namespace mimbre::test::between_bodies_test {
namespace {

using std::numbers::pi;
using testing::HasSubstr;

class BetweenBodies : public testing::TestWithParam<Formulation> {
 protected:
  RunOptions options(double step = 0.005) const {
    RunOptions o;
    o.formulation = GetParam();
    o.step = step;
    o.tolerance = 1e-9;
    return o;
  }
};
INSTANTIATE_TEST_SUITE_P(Formulations, BetweenBodies,
                         testing::Values(Formulation::relative, Formulation::natural), [](const auto& of) {
                           return of.param == Formulation::natural ? "natural" : "relative";
                         });

/// Poses of all bodies after the same time in two models.
void expect_same_motion(const std::shared_ptr<const Model>& a, const std::shared_ptr<const Model>& b,
                        const RunOptions& options, double until, double tolerance) {
  Simulation s(a, options), other(b, options);
  run_to(s, until);
  run_to(other, until);
  for (const spec::Body& body : a->spec().bodies) {
    const spec::Pose one = s.pose(s.body(body.name)), two = other.pose(other.body(body.name));
    EXPECT_LT((one.position - two.position).norm(), tolerance) << body.name;
    EXPECT_LT((one.rotation - two.rotation).norm(), tolerance) << body.name;
  }
}

/// A heavy bar on a spherical joint, whose other end something holds.
std::string bar(const std::string& constraints, const std::string& joints = "") {
  return fmt::format(R"(
bodies:
  bar: {{mass: 2, com: [0.5, 0, 0], inertia: [0.01, 0.2, 0.2]}}
  block: {{mass: 1, com: [1, 0.2, 0], inertia: [0.02, 0.03, 0.04]}}
joints:
  ball: {{type: spherical, between: [ground, bar], at: [0, 0, 0]}}
{}
constraints:
{}
)",
                     joints, constraints);
}

/// A massless rod between two points is a distance.
TEST_P(BetweenBodies, ADistanceIsARodWithoutMass) {
  const auto with_rod = model_of(R"(
bodies:
  bar: {mass: 2, com: [0.5, 0, 0], inertia: [0.01, 0.2, 0.2]}
  block: {mass: 1, com: [1, 0.2, -0.5], inertia: [0.02, 0.03, 0.04]}
  rod: {mass: 1e-9, com: [1, 0.1, -0.25], inertia: [1e-10, 1e-10, 1e-10]}
joints:
  hinge: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0]}
  free: {type: floating, between: [ground, block], velocity: [0, 0.3, 0, 0.2, 0, 0]}
  top: {type: spherical, between: [bar, rod], at: [1, 0, 0]}
  bottom: {type: universal, between: [rod, block], at: [1, 0.2, -0.5], axis: [1, 0, 0], axis2: [0, 0.9284766908852594, 0.3713906763541037]}
)");
  const auto with_distance = model_of(R"(
bodies:
  bar: {mass: 2, com: [0.5, 0, 0], inertia: [0.01, 0.2, 0.2]}
  block: {mass: 1, com: [1, 0.2, -0.5], inertia: [0.02, 0.03, 0.04]}
joints:
  hinge: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0]}
  free: {type: floating, between: [ground, block], velocity: [0, 0.3, 0, 0.2, 0, 0]}
constraints:
  rod: {type: distance, between: [bar, block], at: [[1, 0, 0], [1, 0.2, -0.5]]}
)");
  Simulation a(with_rod, options(1e-3)), b(with_distance, options(1e-3));
  for (const double time : {0.1, 0.3}) {
    run_to(a, time);
    run_to(b, time);
    const auto place = [](Simulation& s, const char* name) { return s.pose(s.body(name)).position; };
    EXPECT_LT((place(a, "block") - place(b, "block")).norm(), 2e-6) << time;
    EXPECT_LT((place(a, "bar") - place(b, "bar")).norm(), 2e-6) << time;
  }
}

/// A pendulum on a distance has the force of the thread: m (g cos θ + v²/L).
TEST_P(BetweenBodies, ADistanceBearsTheForceOfAThread) {
  Simulation s(model_of(R"(
bodies: {ball: {mass: 2, com: [0.6, 0, -0.8], inertia: [1e-3, 1e-3, 1e-3]}}
constraints: {thread: {type: distance, between: [ground, ball], at: [[0, 0, 0], null]}}
outputs:
  - {name: x, position: ball, component: x}
  - {name: z, position: ball, component: z}
)"),
               options(1e-3));
  run_to(s, 0.5);
  const double x = channel(s, "x"), z = channel(s, "z");
  EXPECT_NEAR(std::hypot(x, z), 1, 1e-8);
  const double force = 2 * (9.81 * -z + 2 * 9.81 * (-0.8 - z));
  EXPECT_NEAR(channel(s, "constraint.thread.force.x"), -x * force, 1e-4 * force);
  EXPECT_NEAR(channel(s, "constraint.thread.force.z"), -z * force, 1e-4 * force);
}

/// What joints say with the same equations. Of a sliding pivot, a point on a line and parallel axes are five
/// of its equations.
TEST_P(BetweenBodies, PointsOnLinesAndParallelAxesMakeACylindricalJoint) {
  const std::string joint =
      R"(  slide: {type: cylindrical, between: [bar, block], at: [1, 0, 0], axis: [0, 1, 0]})";
  const std::string equations = R"(
  line: {type: on_line, between: [bar, block], at: [1, 0, 0], axis: [0, 1, 0]}
  axes: {type: parallel, between: [bar, block], axis: [0, 1, 0]}
)";
  expect_same_motion(model_of(bar("", joint)), model_of(bar(equations)), options(1e-3), 0.4, 1e-4);
}

TEST_P(BetweenBodies, APointOnAPlaneAndParallelNormalsMakeAPlanarJoint) {
  const std::string joint =
      R"(  slide: {type: planar, between: [bar, block], at: [1, 0, 0], axis: [0, 0, 1]})";
  const std::string equations = R"(
  plane: {type: on_plane, between: [bar, block], at: [1, 0, 0], axis: [0, 0, 1]}
  normals: {type: parallel, between: [bar, block], axis: [0, 0, 1]}
)";
  expect_same_motion(model_of(bar("", joint)), model_of(bar(equations)), options(1e-3), 0.4, 1e-4);
}

TEST_P(BetweenBodies, ABallJointWithPerpendicularAxesIsUniversal) {
  const std::string joint =
      R"(  cross: {type: universal, between: [bar, block], at: [1, 0, 0], axis: [0, 1, 0], axis2: [0, 0, 1]})";
  const std::string ball = R"(  cross: {type: spherical, between: [bar, block], at: [1, 0, 0]})";
  const std::string equations =
      R"(  axes: {type: perpendicular, between: [bar, block], axis: [0, 1, 0], axis2: [0, 0, 1]})";
  expect_same_motion(model_of(bar("", joint)), model_of(bar(equations, ball)), options(1e-3), 0.4, 1e-4);
}

/// Two shafts at an angle β; what joins them is the difference. The first turns steadily.
std::string shafts(const std::string& joint, const std::string& constraint, double beta) {
  const double c = std::cos(beta), s = std::sin(beta);
  return fmt::format(R"(
gravity: [0, 0, 0]
bodies:
  in: {{mass: 1, com: [-0.3, 0, 0], inertia: [0.01, 0.02, 0.02]}}
  out: {{mass: 1, com: [{0}, {1}, 0], inertia: [0.01, 0.02, 0.02]}}
joints:
  in: {{type: revolute, between: [ground, in], at: [-0.3, 0, 0], axis: [1, 0, 0], drive: {{speed: 3}}}}
  out: {{type: revolute, between: [ground, out], at: [{0}, {1}, 0], axis: [{2}, {3}, 0]}}
{4}
constraints: {5}
)",
                     0.3 * c, 0.3 * s, c, s, joint, constraint);
}

/// At a bend a constant-velocity joint transmits equal angles; a universal joint's differ by the known
/// ripple, tan θ_out = tan θ_in · cos β (or / cos β, by where the cross stands at first).
TEST_P(BetweenBodies, AConstantVelocityJointTransmitsEqualSpeeds) {
  const double beta = 0.6, c = std::cos(beta), s = std::sin(beta);
  Simulation even(
      model_of(shafts("",
                      fmt::format("{{bend: {{type: constant_velocity, between: [in, out], at: [0, "
                                  "0, 0], axis: [1, 0, 0], axis2: [{}, {}, 0]}}}}",
                                  c, s),
                      beta)),
      options()),
      cross(model_of(shafts(
                "  cross: {type: universal, between: [in, out], at: [0, 0, 0], axis: [0, 0, 1], axis2: " +
                    fmt::format("[{}, {}, 0]}}", -s, c),
                "", beta)),
            options());
  double ripple = 0;
  for (int k = 1; k <= 60; ++k) {
    run_to(even, 0.05 * k);
    run_to(cross, 0.05 * k);
    const double in = channel(even, "joint.in.position");
    EXPECT_NEAR(in, 0.15 * k, 1e-9);
    EXPECT_NEAR(channel(even, "joint.out.position"), in, 1e-8);
    EXPECT_NEAR(channel(even, "joint.out.velocity"), 3, 1e-6);
    const double out = channel(cross, "joint.out.position");
    EXPECT_NEAR(std::remainder(out - std::atan2(std::sin(in) * c, std::cos(in)), pi), 0, 1e-6);
    ripple = std::max(ripple, std::abs(channel(cross, "joint.out.velocity") - 3));
  }
  EXPECT_GT(ripple, 0.5);
}

/// The bend may change while the shafts turn: of a ball joint it leaves all but the turning.
TEST_P(BetweenBodies, AConstantVelocityJointBendsFreely) {
  Simulation s(model_of(R"(
gravity: [0, 0, 0]
bodies:
  in: {mass: 1, com: [-0.3, 0, 0], inertia: [0.01, 0.02, 0.02]}
  out: {mass: 1, com: [0.3, 0, 0], inertia: [0.01, 0.02, 0.02]}
joints: {in: {type: revolute, between: [ground, in], at: [-0.3, 0, 0], axis: [1, 0, 0], velocity: 2}}
constraints: {bend: {type: constant_velocity, between: [in, out], at: [0, 0, 0], axis: [1, 0, 0]}}
)"),
               options());
  EXPECT_EQ(s.degrees_of_freedom(), 1 + 2);
}

/// Energy stays, whatever is constrained.
TEST_P(BetweenBodies, DoNoWork) {
  const auto model = model_of(bar(R"(
  plane: {type: on_plane, between: [bar, block], at: [1, 0.1, 0], axis: [0, 0.3, 1]}
  rod: {type: distance, between: [ground, block], at: [[0.8, 0.2, 0.5], [1, 0.2, 0]]}
)"));
  Simulation s(model, options(1e-3));
  const double start = s.energy().total();
  run_to(s, 0.5);
  EXPECT_NEAR(s.energy().total(), start, 2e-4);
}

/// The torque of a brake goes through a constant-velocity joint, and the moment that bends it does not.
TEST_P(BetweenBodies, AConstantVelocityJointBearsTheTorque) {
  Simulation s(model_of(shafts("",
                               "{bend: {type: constant_velocity, between: [in, out], at: [0, 0, 0], axis: "
                               "[1, 0, 0], axis2: [0.8253356149096783, 0.5646424733950354, 0]}}",
                               0.6) +
                        "loads: {brake: {on: out, moment: [-0.8253356149096783, -0.5646424733950354, 0]}}\n"),
               options());
  run_to(s, 0.2);
  // On the output: 1 along its shaft, about the bisector's direction.
  const double along = 0.8253356149096783 * channel(s, "constraint.bend.moment.x") +
                       0.5646424733950354 * channel(s, "constraint.bend.moment.y");
  EXPECT_NEAR(along, 1, 1e-6);
  EXPECT_NEAR(channel(s, "constraint.bend.moment.x"), 1, 1e-6) << "as much comes from the input";
}

/// A body whose axes follow those of a turning one falls freely, and needs the moment J θ̈.
TEST_P(BetweenBodies, AnOrientationTurnsABodyAndLetsItFall) {
  Simulation s(model_of(R"(
bodies:
  rotor: {mass: 2, com: [0, 0, 0], inertia: [0.02, 0.05, 0.04]}
  follower: {mass: 1, com: [1, 0, 0], inertia: [0.03, 0.06, 0.05]}
joints:
  shaft: {type: revolute, between: [ground, rotor], at: [0, 0, 0], axis: [1, 0, 0], drive: {position: "0.4*t*t"}}
constraints: {follow: {type: orientation, between: [rotor, follower]}}
outputs:
  - {name: x, position: follower, component: x}
  - {name: y, position: follower, component: y}
  - {name: z, position: follower, component: z}
)"),
               options());
  const Eigen::Vector3d start(channel(s, "x"), channel(s, "y"), channel(s, "z"));
  run_to(s, 1);
  const Eigen::Matrix3d expected = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()).toRotationMatrix();
  EXPECT_LT((s.pose(s.body("rotor")).rotation - expected).norm(), 1e-9);
  EXPECT_LT((s.pose(s.body("follower")).rotation - expected).norm(), 1e-9);
  const Eigen::Vector3d end(channel(s, "x"), channel(s, "y"), channel(s, "z"));
  EXPECT_LT((end - start - Eigen::Vector3d(0, 0, -0.5 * 9.81)).norm(), 1e-8);
  EXPECT_NEAR(channel(s, "constraint.follow.moment.x"), 0.03 * 0.8, 1e-8);
  EXPECT_NEAR(channel(s, "constraint.follow.moment.y"), 0, 1e-8);
  EXPECT_NEAR(channel(s, "constraint.follow.moment.z"), 0, 1e-8);
}

/// Two bodies that keep their relative orientation share a moment by their inertias, and no force.
TEST_P(BetweenBodies, AnOrientationAddsInertias) {
  ModelBuilder m;
  m.set_gravity({0, 0, 0});
  for (const char* name : {"one", "other"})
    m.add_body(name,
               {.mass = 1, .com = {0, 0, 0}, .inertia = Eigen::Vector3d(0.02, 0.03, 0.04).asDiagonal()});
  m.add_constraint("together", {.type = "orientation", .between = {"one", "other"}});
  m.add_load("twist", {.on = "one", .moment = {0, 0, 0.2}});
  m.add_load("push", {.on = "other", .force = {3, 0, 0}});
  Simulation s(m.compile(), options(1e-3));
  run_to(s, 0.5);
  const Eigen::Matrix3d expected =
      Eigen::AngleAxisd(0.5 * 0.2 / 0.08 * 0.25, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  // Unit vectors that turn have the error of the step, h² (4e-6 at 5 ms); angles here have none.
  const double turning = GetParam() == Formulation::natural ? 2e-7 : 1e-8;
  for (const char* name : {"one", "other"})
    EXPECT_LT((s.pose(s.body(name)).rotation - expected).norm(), turning) << name;
  EXPECT_LT(s.pose(s.body("one")).position.norm(), 1e-8);
  EXPECT_LT((s.pose(s.body("other")).position - Eigen::Vector3d(0.375, 0, 0)).norm(), 1e-8);
  EXPECT_NEAR(channel(s, "constraint.together.moment.z"), 0.1, 1e-8);
}

/// Axes of a frame that is named beside a body, else the global ones.
TEST(Orientation, HasTheSameAxesOnBothSides) {
  const auto model = model_of(R"(
bodies:
  one: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1], frame: {at: [0, 0, 0], x: [1, 2, 0], y: [-2, 1, 0]}}
  other: {mass: 1, com: [1, 0, 0], inertia: [1, 1, 1]}
frames: {turned: {body: other, at: [1, 0, 0], x: [0, 1, 1], y: [1, 0, 0]}}
constraints:
  bodies: {type: orientation, between: [one, other]}
  frame: {type: orientation, between: [one, turned]}
)");
  const spec::Model& m = model->spec();
  const auto axes = [&](int frame) -> Eigen::Matrix3d {
    const spec::Frame& f = m.frames[static_cast<std::size_t>(frame)];
    return m.bodies[static_cast<std::size_t>(f.body)].pose.rotation * f.pose.rotation;
  };
  for (const spec::Constraint& c : m.constraints)
    EXPECT_LT((axes(c.frame_a) - axes(c.frame_b)).norm(), 1e-15) << c.name;
  EXPECT_LT((axes(m.constraints[0].frame_a) - Eigen::Matrix3d::Identity()).norm(), 1e-15);
  EXPECT_LT((axes(m.constraints[1].frame_a).col(1) - Eigen::Vector3d::UnitX()).norm(), 1e-15);
}

TEST(ConstraintsOfCode, SayWhatIsWrong) {
  const auto message = [](const build::Constraint& c) -> std::string {
    ModelBuilder m("two");
    for (const char* name : {"a", "b"}) m.add_body(name, {.mass = 1, .inertia = build::inertia(1, 1, 1)});
    m.add_joint("hinge", {.type = spec::JointType::revolute,
                          .between = {"ground", "a"},
                          .at = Eigen::Vector3d{0, 0, 0},
                          .axis = Eigen::Vector3d{0, 0, 1}});
    try {
      m.add_constraint("it", c);
      m.compile();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message({}), HasSubstr("constraint 'it': couples nothing"));
  EXPECT_THAT(message({.terms = {{"hinge", 0}}}), HasSubstr("the factor of joint 'hinge' is 0"));
  EXPECT_THAT(message({.terms = {{"hing", 1}}}),
              HasSubstr("there is no joint 'hing' (did you mean 'hinge'?)"));
  EXPECT_THAT(message({.terms = {{"hinge", 1}, {"hinge", 2}}}),
              HasSubstr("coordinate 0 of joint 'hinge' twice"));
  EXPECT_THAT(message({.terms = {{"hinge", 1, 3}}}), HasSubstr("coordinate is 3"));
  EXPECT_THAT(message({.type = "distance", .between = {"a", "b"}}), HasSubstr("length is 0"));
  EXPECT_THAT(message({.type = "on_line", .between = {"a", "b"}}), HasSubstr("'axis' is missing"));
  EXPECT_THAT(message({.type = "parallel", .between = {"a", "a"}, .axis = Eigen::Vector3d{0, 0, 1}}),
              HasSubstr("both sides are on the rigid body 'a'"));
  EXPECT_THAT(message({.type = "screw",
                       .between = {"a", "b"},
                       .axis = Eigen::Vector3d{0, 0, 1},
                       .numbers = {{"lead", 0}}}),
              HasSubstr("lead is 0"));
  EXPECT_THAT(message({.type = "screw", .between = {"a", "b"}, .axis = Eigen::Vector3d{0, 0, 1}}),
              HasSubstr("'lead' is missing"));
  EXPECT_THAT(message({.type = "distance", .between = {"a", "b"}, .numbers = {{"length", -1}}}),
              HasSubstr("length is -1; it has to be above 0"));
  EXPECT_THAT(message({.type = "distance", .between = {"a", "b"}, .numbers = {{"lenght", 1}}}),
              HasSubstr("did you mean 'length'"));
  EXPECT_THAT(message({.type = "on_lime", .between = {"a", "b"}}), HasSubstr("did you mean 'on_line'"));
  EXPECT_THAT(message({.type = "on_curve", .between = {"a", "b"}, .points = {{0, 0, 0}}}),
              HasSubstr("has 1 points; an open curve needs 2 at least"));
  EXPECT_THAT(
      message({.type = "on_curve", .between = {"a", "b"}, .points = {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}}}),
      HasSubstr("points 1 and 2 of the curve are at one place"));
  EXPECT_THAT(message({.type = "on_plane", .between = {"a", "b"}, .axis = Eigen::Vector3d{0, 0, 0}}),
              HasSubstr("the direction has no length"));
}

}  // namespace
}  // namespace mimbre::test::between_bodies_test
