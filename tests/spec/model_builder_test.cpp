#include "mimbre/model_builder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "compile/compiled.h"
#include "mimbre/simulation.h"
#include "support/models.h"
#include "support/random_mechanism.h"

/// Mechanisms in code are those of model files, to the bit.
namespace mimbre::test::model_builder_test {
namespace {

using spec::JointType;
using testing::AllOf;
using testing::HasSubstr;

const Vec3d y_axis = Vec3d::UnitY();

void expect_same(const Model& built, const Model& read) {
  const Compiled &a = built.compiled(), &b = read.compiled();
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.velocities, b.velocities);
  EXPECT_EQ(a.equations, b.equations);
  EXPECT_EQ(a.gravity, b.gravity);
  EXPECT_EQ(a.mass_scale, b.mass_scale);
  EXPECT_EQ(a.length_scale, b.length_scale);
  ASSERT_EQ(a.bodies.size(), b.bodies.size());
  for (std::size_t k = 0; k < a.bodies.size(); ++k) {
    const BodyData &c = a.bodies[k], &d = b.bodies[k];
    EXPECT_EQ(a.spec().bodies[c.spec].name, b.spec().bodies[d.spec].name);
    EXPECT_EQ(c.parent, d.parent);
    EXPECT_EQ(c.joint, d.joint);
    EXPECT_EQ(c.reversed, d.reversed);
    EXPECT_EQ(c.mass, d.mass);
    EXPECT_EQ(c.first_moment, d.first_moment);
    EXPECT_EQ(c.inertia, d.inertia);
  }
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t k = 0; k < a.frames.size(); ++k) {
    EXPECT_EQ(a.spec().frames[a.frames[k].spec].name, b.spec().frames[b.frames[k].spec].name);
    EXPECT_EQ(a.frames[k].body, b.frames[k].body);
    EXPECT_EQ(a.frames[k].position, b.frames[k].position);
    EXPECT_EQ(a.frames[k].rotation, b.frames[k].rotation);
    EXPECT_EQ(a.frames[k].flexible, b.frames[k].flexible);
    EXPECT_EQ(a.frames[k].X.matrix(), b.frames[k].X.matrix());
  }
  EXPECT_EQ(a.loops.size(), b.loops.size());
  EXPECT_EQ(a.drives.size(), b.drives.size());
}

/// All channels of both, step by step.
void expect_same_run(const std::shared_ptr<const Model>& built, const std::shared_ptr<const Model>& read,
                     int steps) {
  Simulation a(built), b(read);
  ASSERT_EQ(a.channels().size(), b.channels().size());
  for (std::size_t k = 0; k < a.channels().size(); ++k) {
    EXPECT_EQ(a.channels()[k].name, b.channels()[k].name);
    EXPECT_EQ(a.channels()[k].meaning, b.channels()[k].meaning);
  }
  ResultsRow row_a, row_b;
  for (int k = 0; k < steps; ++k) {
    ASSERT_TRUE(a.step().ok());
    ASSERT_TRUE(b.step().ok());
    a.sample(row_a);
    b.sample(row_b);
    ASSERT_EQ(row_a.channels, row_b.channels) << k;
    ASSERT_EQ(row_a.poses, row_b.poses) << k;
  }
}

std::string error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

ModelBuilder pendulum(double mass, const Mat3d& inertia) {
  ModelBuilder m("Pendulum");
  m.add_body(
      "bar",
      {.mass = mass, .com = {0.5, 0, 0}, .inertia = inertia, .lines = {{Vec3d::Zero(), Vec3d::UnitX()}}});
  m.add_joint(
      "hinge",
      {.type = JointType::revolute, .between = {"ground", "bar"}, .at = Vec3d{0, 0, 0}, .axis = y_axis});
  m.add_output("angle", {.kind = "joint", .of = "hinge"});
  m.add_output("tip.z", {.kind = "position", .of = "bar", .component = "z", .at = Vec3d{1, 0, 0}});
  m.add_output("hinge.fz", {.kind = "joint_force", .of = "hinge", .component = "fz"});
  m.set_simulation({.step = 0.01, .end = 5});
  return m;
}

TEST(ModelBuilder, MakesThePendulumOfTheModelFile) {
  const auto read = example("tutorial/pendulum.yaml");
  const spec::Body& bar = read->spec().bodies[0];
  const auto built = pendulum(bar.mass, bar.inertia).compile();
  EXPECT_EQ(built->spec().title, "Pendulum");
  expect_same(*built, *read);
  expect_same_run(built, read, 200);
}

TEST(ModelBuilder, MakesTheFourBarOfTheModelFile) {
  const auto read = example("tutorial/four-bar.yaml");
  ModelBuilder m;
  m.add_body("crank", {.mass = 0.5, .com = {0, 0, 0.1}, .inertia = build::inertia(0.002, 0.002, 0.0001)});
  m.add_flexible_body("coupler", read->spec().bodies[1].flexible,
                      {.at = {0, 0, 0.2}, .axes = {.x = Vec3d{0.6, 0, 0.3}, .y = y_axis}});
  m.add_body("rocker", {.mass = 1, .com = {0.6, 0, 0.25}, .inertia = build::inertia(0.02, 0.02, 0.0005)});
  const auto revolute = [&](const char* name, const char* a, const char* b, const Vec3d& at,
                            std::vector<spec::Drive> drives = {},
                            spec::Joint::Cut cut = spec::Joint::Cut::automatic) {
    m.add_joint(name, {.type = JointType::revolute,
                       .between = {a, b},
                       .at = at,
                       .axis = y_axis,
                       .cut = cut,
                       .drives = std::move(drives)});
  };
  revolute("motor", "ground", "crank", {0, 0, 0},
           {{.law = Function::expression("2*pi*1*(t - 0.5*(1 - exp(-2*t)))", "t")}});
  revolute("crank_pin", "crank", "coupler", {0, 0, 0.2});
  revolute("pivot", "ground", "rocker", {0.6, 0, 0});
  revolute("rocker_pin", "coupler", "rocker", {0.6, 0, 0.5}, {}, spec::Joint::Cut::always);
  m.add_output("crank", {.kind = "joint", .of = "motor"});
  m.add_output("rocker", {.kind = "joint", .of = "pivot"});
  const Vec3d across{-0.3, 0, 0.6};
  m.add_output("coupler.middle", {.kind = "deflection", .of = "coupler.middle", .along = across});
  m.add_output("coupler.end", {.kind = "deflection", .of = "coupler.rocker", .along = across});
  m.add_output("motor.torque", {.kind = "joint_force", .of = "motor", .component = "my"});
  m.set_simulation({.step = 0.001, .end = 5});
  const auto built = m.compile();
  expect_same(*built, *read);
  expect_same_run(built, read, 200);
}

/// A corner of a vehicle: its arm, link and rod flexible, two loops, springs, a tyre on a road that drops.
ModelBuilder suspension(const spec::Model& read) {
  const auto reduced = [&](const std::string& name) {
    for (const spec::Body& b : read.bodies)
      if (b.name == name) return b.flexible;
    return std::shared_ptr<const ReducedBody>();
  };
  const Vec3d corner{0.970, 0, 0.57}, x = Vec3d::UnitX();
  const auto at = [&](double px, double py, double pz) { return Vec3d(Vec3d(px, py, pz) + corner); };
  const std::string f = "front_left.";

  ModelBuilder m("Suspension");
  m.add_body("chassis", {.mass = 315, .com = {0, 0, 0.57}, .inertia = build::inertia(32.5, 405, 417.5)});
  m.add_flexible_body(f + "arm", reduced(f + "arm"),
                      {.at = at(0, 0.259, -0.268), .axes = {.x = x, .y = Vec3d{0, 0.313066, -0.072982}}});
  m.add_flexible_body(f + "link", reduced(f + "link"),
                      {.at = at(0, 0.1585, 0.030), .axes = {.x = Vec3d{0, 0.3295, -0.069}, .y = x}});
  m.add_flexible_body(f + "rod", reduced(f + "rod"),
                      {.at = at(-0.14, 0.070, 0.030), .axes = {.x = Vec3d{0, 0.377998, -0.069009}, .y = x}});
  m.add_body(
      f + "axle",
      {.mass = 57.35, .com = at(0, 0.615038, -0.213972), .inertia = build::inertia(1.2402, 1.908, 1.2402)});
  const auto joint = [&](const std::string& name, build::Joint given) { m.add_joint(f + name, given); };
  m.add_joint("column", {.type = JointType::prismatic,
                         .between = {"ground", "chassis"},
                         .at = Vec3d{0, 0, 0.57},
                         .axis = Vec3d{0, 0, 1}});
  using Cut = spec::Joint::Cut;
  joint("arm", {.type = JointType::revolute,
                .between = {"chassis", f + "arm"},
                .at = at(0, 0.259, -0.268),
                .axis = x,
                .cut = Cut::never});
  joint("ball", {.type = JointType::spherical,
                 .between = {f + "arm", f + "axle"},
                 .at = at(0, 0.572066, -0.340982),
                 .cut = Cut::never});
  joint("link", {.type = JointType::revolute,
                 .between = {"chassis", f + "link"},
                 .at = at(0, 0.1585, 0.030),
                 .axis = x,
                 .cut = Cut::never});
  joint("rod", {.type = JointType::universal,
                .between = {"chassis", f + "rod"},
                .at = at(-0.14, 0.070, 0.030),
                .axis = x,
                .axis2 = Vec3d{0, 0.069009, 0.377998},
                .cut = Cut::never});
  joint("link_ball", {.type = JointType::spherical,
                      .between = {f + "link", f + "axle"},
                      .at = at(0, 0.488, -0.039),
                      .cut = Cut::always});
  joint("rod_ball", {.type = JointType::spherical,
                     .between = {f + "rod", f + "axle"},
                     .at = at(-0.14, 0.447998, -0.039009),
                     .cut = Cut::always});
  m.add_spring(f + "leaf",
               {.between = {f + "axle", "chassis"},
                .at = {at(0, 0.488, -0.039), at(0, 0.488, 0.137)},
                .elastic = Function::piecewise(
                    {0.106}, {{35906 * (0.106 - 0.252) - 1.0e7 * 0.106, 1.0e7}, {-35906 * 0.252, 35906}})});
  m.add_spring(f + "shock",
               {.between = {f + "arm", "chassis"},
                .at = {at(0.075, 0.500065, -0.328989), at(0.075, 0.297, 0.062)},
                .elastic = Function::polynomial({-4.0092e6, 2.8397e7, -6.7061e7, 5.2796e7}),
                .damping = Function::piecewise({-0.2, 0.21}, {{-416.42, 1844.3},
                                                              {0, 9945.627, 33955.72, -59832.25, -395651},
                                                              {1919.1638, 1634.727}})});
  m.add_road("track", {.over = spec::Road::Over::time, .points = {{0, 0}, {2, 0}, {2, -0.2}, {5, -0.2}}});
  m.add_tyre(f + "tyre", {.on = f + "axle", .road = "track", .stiffness = 4.6e5, .radius = 0.364325});
  m.add_output("chassis.z", {.kind = "position", .of = "chassis", .component = "z"});
  m.add_output("wheel.z", {.kind = "position", .of = f + "axle", .component = "z"});
  m.add_output("arm.deflection",
               {.kind = "deflection", .of = f + "arm.ball", .along = Vec3d{0, 0.072982, 0.313066}});
  m.add_output("tyre.force", {.kind = "tyre_force", .of = f + "tyre"});
  m.set_simulation({.step = 0.01, .end = 5, .output_interval = 0.01, .substeps = 6});
  return m;
}

TEST(ModelBuilder, RoadsAreLevelBeyondTheirPoints) {
  ModelBuilder m;
  m.add_body("b", {.mass = 1, .inertia = build::inertia(1, 1, 1)});
  m.add_road("bump", {.points = {{0, 0}, {0.5, 0.05}, {1, 0.02}}});
  m.add_road("gap", {.points = {{0, 0}, {1, 0.1}}, .repeat = 2});
  const std::vector<spec::Road> roads = m.build().roads;
  EXPECT_EQ(roads[0].height.value(-3), 0);
  EXPECT_EQ(roads[0].height.value(3), 0.02);
  EXPECT_EQ(roads[1].height.value(-0.5), 0.1);
  EXPECT_NEAR(roads[1].height.value(2.5), 0.05, 1e-15);
}

TEST(ModelBuilder, MakesTheSuspensionOfTheModelFile) {
  const auto read = example("iltis/suspension.yaml");
  const auto built = suspension(read->spec()).compile();
  expect_same(*built, *read);
  expect_same_run(built, read, 250);  // the road drops after 200
}

TEST(ModelBuilder, TakesWhatModelFilesTakeOfTheOtherThings) {
  const auto read = model_of(R"(
gravity: [0, 0, -1.6]
bodies:
  hub: {mass: 2, com: [0.1, 0.2, 0.3], inertia: [0.2, 0.3, 0.4, 0.01, -0.02, 0.03], frame: {at: [0, 0, 0.3], z: [1, 1, 0]}}
  top: {mass: 1, com: [0, 0, 1], inertia: [0.1, 0.1, 0.1]}
frames:
  peg: {body: ground, at: [0, 1, 0], x: [0, 0, 1], y: [1, 0, 0]}
  eye: {body: hub, at: [0.5, 0, 0.3], y: [0, 1, 1]}
joints:
  free: {type: floating, between: [ground, hub], velocity: [1, 2, 3, 0.1, 0.2, 0.3], position: [0, 0, 0, 0.3, 0.2, 0.1]}
  slide: {type: cylindrical, between: [hub, top], at: [0, 0, 0.6], axis: [0, 1, 2], position: [0.1, null],
          velocity: [0, 2], spring: {stiffness: 50, damping: 2, zero: 0.1, coordinate: 1}}
springs:
  rope: {between: [peg, top], at: [null, [0, 0.3, 1]], force: "20*(l-0.5) + v"}
loads:
  jet: {on: top, at: [0, 0, 1.2], force: [0, 3, 0], moment: [0, 0, 0.1], follower: true, scale: "1 - t"}
  wind: {on: eye, force: [0.3, 0, 0]}
outputs:
  - {name: w, angular_velocity: eye, component: y, axes: own}
  - {name: u, displacement: top, relative_to: eye, component: x}
  - {name: turn, joint: slide, component: 0, offset: 1.5}
  - {name: rate, joint_velocity: free, component: 4}
  - {name: L, angular_momentum: [hub, top], component: z, about: [0, 0, 1]}
  - {name: p, linear_momentum: all, component: x}
  - {name: rope, spring_length: rope}
  - {name: yaw, yaw: hub}
)");
  ModelBuilder m;
  m.set_gravity({0, 0, -1.6});
  m.add_body("hub", {.mass = 2,
                     .com = {0.1, 0.2, 0.3},
                     .inertia = build::inertia(0.2, 0.3, 0.4, 0.01, -0.02, 0.03),
                     .at = Vec3d{0, 0, 0.3},
                     .axes = {.z = Vec3d{1, 1, 0}}});
  m.add_body("top", {.mass = 1, .com = {0, 0, 1}, .inertia = build::inertia(0.1, 0.1, 0.1)});
  m.add_frame("peg", {.on = "ground", .at = {0, 1, 0}, .axes = {.x = Vec3d{0, 0, 1}, .y = Vec3d{1, 0, 0}}});
  m.add_frame("eye", {.on = "hub", .at = {0.5, 0, 0.3}, .axes = {.y = Vec3d{0, 1, 1}}});
  m.add_joint("free", {.type = JointType::floating,
                       .between = {"ground", "hub"},
                       .position = {0, 0, 0, 0.3, 0.2, 0.1},
                       .velocity = {1, 2, 3, 0.1, 0.2, 0.3}});
  m.add_joint(
      "slide",
      {.type = JointType::cylindrical,
       .between = {"hub", "top"},
       .at = Vec3d{0, 0, 0.6},
       .axis = Vec3d{0, 1, 2},
       .springs = {{.coordinate = 1, .elastic = Function::linear(50, 0.1), .damping = Function::linear(2)}},
       .position = {0.1, std::nullopt},
       .velocity = {0, 2}});
  m.add_spring("rope", {.between = {"peg", "top"},
                        .at = {std::nullopt, Vec3d{0, 0.3, 1}},
                        .force = Formula::expression("20*(l-0.5) + v", {"l", "v", "t"})});
  m.add_load("jet", {.on = "top",
                     .at = Vec3d{0, 0, 1.2},
                     .force = {0, 3, 0},
                     .moment = {0, 0, 0.1},
                     .scale = Function::expression("1 - t", "t"),
                     .follower = true});
  m.add_load("wind", {.on = "eye", .force = {0.3, 0, 0}});
  m.add_output("w", {.kind = "angular_velocity", .of = "eye", .component = "y", .own_axes = true});
  m.add_output("u", {.kind = "displacement", .of = "top", .component = "x", .relative_to = "eye"});
  m.add_output("turn", {.kind = "joint", .of = "slide", .component = "0", .offset = 1.5});
  m.add_output("rate", {.kind = "joint_velocity", .of = "free", .component = "4"});
  m.add_output(
      "L", {.kind = "angular_momentum", .bodies = {"hub", "top"}, .component = "z", .about = Vec3d{0, 0, 1}});
  m.add_output("p", {.kind = "linear_momentum", .component = "x"});
  m.add_output("rope", {.kind = "spring_length", .of = "rope"});
  m.add_output("yaw", {.kind = "yaw", .of = "hub"});
  const auto built = m.compile();
  expect_same(*built, *read);
  expect_same_run(built, read, 100);
}

/// A chain whose second body is described in the first one's frame, the first turned and moved somewhere.
std::vector<double> chain(const spec::Pose& place) {
  ModelBuilder m;
  m.set_gravity(place.rotation * Vec3d(0, 0, -9.81));
  const Vec3d turned_x = place.rotation.col(0), turned_y = place.rotation.col(1);
  m.add_body("first", {.mass = 1,
                       .com = place.position,
                       .inertia = build::inertia(0.1, 0.2, 0.3),
                       .axes = {.x = turned_x, .y = turned_y}});
  m.add_body("second",
             {.mass = 2, .com = {0.3, 0.2, 0.1}, .inertia = build::inertia(0.3, 0.2, 0.1), .in = "first"});
  m.add_frame("tip", {.on = "second", .at = {0.6, 0, 0}, .axes = {.x = Vec3d{0, 0, 1}}, .in = "second"});
  m.add_joint("root", {.type = JointType::revolute,
                       .between = {"ground", "first"},
                       .at = Vec3d{-0.5, 0, 0},
                       .axis = y_axis,
                       .in = "first"});
  m.add_joint("elbow", {.type = JointType::universal,
                        .between = {"first", "second"},
                        .at = Vec3d{0.1, 0, 0},
                        .axis = y_axis,
                        .axis2 = Vec3d{0, 0, 2},
                        .velocity = {1, 2},
                        .in = "first"});
  m.add_load("push", {.on = "tip", .force = {0, 1, 2}, .moment = {0.1, 0, 0}, .in = "first"});
  m.add_spring("band", {.between = {"ground", "second"},
                        .at = {Vec3d{0, 0, 1}, Vec3d{0, 0.1, 0}},
                        .elastic = Function::linear(20, 0.2),
                        .in = "first"});
  m.add_output("root", {.kind = "joint", .of = "root"});
  m.add_output("elbow", {.kind = "joint", .of = "elbow", .component = "1"});
  m.add_output("w", {.kind = "angular_velocity", .of = "tip", .component = "x", .own_axes = true});
  Simulation simulation(m.compile());
  for (int k = 0; k < 50; ++k) EXPECT_TRUE(simulation.step().ok());
  ResultsRow row;
  simulation.sample(row);
  return {row.channels[0], row.channels[1], row.channels[2]};
}

/// Inputs, controllers, actuators on a joint and about an axis, bushings and gas springs run as those that a
/// file describes.
TEST(ModelBuilder, MakesWhatSignalsMove) {
  const auto read = model_of(R"y(
bodies:
  arm: {mass: 2, com: [0.5, 0, 0], inertia: [0.01, 0.2, 0.2]}
  hand: {mass: 1, com: [1.2, 0, 0], inertia: [0.01, 0.02, 0.02]}
joints:
  shoulder: {type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 1, 0]}
outputs:
  - {name: angle, joint: shoulder}
  - {name: rate, joint_velocity: shoulder}
inputs: {wanted: {start: 0.3, range: [-1, 1], hold: linear}}
signals:
  error: wanted - angle
  command: {value: 200*error - 20*rate + 0.1*sin(t), every: 0.02}
  twist: 0.2*error
actuators:
  motor: {joint: shoulder, torque: command}
bushings:
  wrist:
    between: [arm, hand]
    at: [1, 0, 0]
    stiffness: [1e4, 1e4, 1e4, 50, 60, 70]
    damping: [10, 10, 10, 0.1, 0.1, 0.1]
    maxwell: [{stiffness: [1e3, 1e3, 1e3, 5, 5, 5], relaxation: 0.05}]
gas_springs:
  strut: {between: [ground, arm], at: [[0, 0, -0.5], [0.5, 0, 0]], pressure: 5e5, area: 2e-4, length: 0.7, gas_length: 0.3}
)y");
  ModelBuilder m;
  m.add_body("arm", {.mass = 2, .com = {0.5, 0, 0}, .inertia = build::inertia(0.01, 0.2, 0.2)});
  m.add_body("hand", {.mass = 1, .com = {1.2, 0, 0}, .inertia = build::inertia(0.01, 0.02, 0.02)});
  m.add_joint("shoulder", {.type = JointType::revolute,
                           .between = {"ground", "arm"},
                           .at = Vec3d{0, 0, 0},
                           .axis = Vec3d{0, 1, 0}});
  m.add_output("angle", {.kind = "joint", .of = "shoulder"});
  m.add_output("rate", {.kind = "joint_velocity", .of = "shoulder"});
  m.add_input("wanted", {.start = 0.3, .min = -1, .max = 1, .hold = spec::Input::Hold::linear});
  m.add_signal("error", {.value = "wanted - angle", .of = {"wanted", "angle"}});
  m.add_signal("command",
               {.value = "200*error - 20*rate + 0.1*sin(t)", .of = {"error", "rate", "t"}, .every = 0.02});
  m.add_element("motor", {.law = "actuator", .joint = "shoulder", .signals = {"command"}});
  build::Element wrist{.law = "bushing", .between = {"arm", "hand"}, .at = {Vec3d{1, 0, 0}, Vec3d{1, 0, 0}}};
  wrist.stiffness.diagonal() << 1e4, 1e4, 1e4, 50, 60, 70;
  wrist.damping.diagonal() << 10, 10, 10, 0.1, 0.1, 0.1;
  wrist.branches.push_back({wrist.stiffness / 10, 0.05});
  wrist.branches[0].stiffness.diagonal() << 1e3, 1e3, 1e3, 5, 5, 5;
  m.add_element("wrist", wrist);
  m.add_element("strut", {.law = "gas_spring",
                          .between = {"ground", "arm"},
                          .at = {Vec3d{0, 0, -0.5}, Vec3d{0.5, 0, 0}},
                          .numbers = {5e5, 2e-4, 0.7, 0.3, 1.2, 0, 101325}});
  const auto built = m.compile();
  const auto course = [](const std::shared_ptr<const Model>& model) {
    Simulation simulation(model);
    std::vector<double> values;
    for (int k = 0; k < 100; ++k) {
      if (k == 50) simulation.set_input(simulation.input("wanted"), -0.2);
      EXPECT_TRUE(simulation.step().ok());
      for (const char* name :
           {"angle", "rate", "actuator.motor.force", "bushing.wrist.force.z", "gas_spring.strut.force"})
        values.push_back(simulation.value(simulation.channel(name)));
    }
    return values;
  };
  const std::vector<double> one = course(built), other = course(read);
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t k = 0; k < one.size(); ++k)
    ASSERT_NEAR(one[k], other[k], 1e-9 * (1 + std::abs(other[k]))) << k;
  EXPECT_GT(std::abs(one.back()), 1);
  try {
    m.add_signal("more", {.value = "3*angel", .of = {"angel"}});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("did you mean 'angle'"));
  }
  try {
    m.add_element("more", {.law = "actuater", .joint = "shoulder"});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("did you mean 'actuator'"));
  }
}

TEST(ModelBuilder, CoordinatesOfABodyTurnAndMoveWithIt) {
  const auto here = chain({});
  EXPECT_GT(std::abs(here[0]), 0.1);
  for (unsigned seed = 0; seed < 10; ++seed) {
    Random random(seed);
    const auto there = chain(random.pose(3));
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(here[k], there[k], 1e-7) << seed << ", " << k;
  }
}

TEST(ModelBuilder, NamesWhatIsWrongAndWhatCouldBeMeant) {
  ModelBuilder m = pendulum(1, build::inertia(0.1, 0.1, 0.1));
  const auto joint = [&](build::Joint given) { return error_of([&] { m.add_joint("pin", given); }); };
  const JointType revolute = JointType::revolute;
  const Vec3d at = Vec3d::Zero();
  EXPECT_THAT(joint({.type = revolute, .between = {"ground", "baar"}, .at = at, .axis = y_axis}),
              AllOf(HasSubstr("joint 'pin'"), HasSubstr("there is no body, frame or node 'baar'"),
                    HasSubstr("did you mean 'bar'?")));
  EXPECT_THAT(joint({.type = revolute, .between = {"bar", "bar"}, .at = at, .axis = y_axis}),
              HasSubstr("one body"));
  EXPECT_THAT(joint({.type = revolute, .between = {"ground", "ground"}, .at = at, .axis = y_axis}),
              HasSubstr("both sides are the ground"));
  EXPECT_THAT(joint({.type = revolute, .between = {"ground", "bar"}, .axis = y_axis}),
              HasSubstr("'at' is missing"));
  EXPECT_THAT(joint({.type = revolute, .between = {"ground", "bar"}, .at = at}),
              HasSubstr("'axis' is missing"));
  EXPECT_THAT(joint({.type = revolute, .between = {"ground", "bar"}, .at = at, .axis = at}),
              HasSubstr("no length"));
  EXPECT_THAT(joint({.type = JointType::spherical, .between = {"ground", "bar"}, .at = at, .axis = y_axis}),
              HasSubstr("has no axis"));
  EXPECT_THAT(joint({.type = JointType::universal, .between = {"ground", "bar"}, .at = at, .axis = y_axis}),
              HasSubstr("'axis2' is missing"));
  EXPECT_THAT(joint({.type = JointType::universal,
                     .between = {"ground", "bar"},
                     .at = at,
                     .axis = y_axis,
                     .axis2 = y_axis}),
              HasSubstr("not perpendicular"));
  EXPECT_THAT(joint({.between = {"ground", ""}}), HasSubstr("is missing"));
  EXPECT_THAT(error_of([&] { m.add_joint("hinge", {}); }), HasSubstr("there is a joint of this name"));
  EXPECT_THAT(error_of([&] { m.add_body("ground", {}); }), HasSubstr("fixed world"));
  EXPECT_THAT(error_of([&] { m.add_body("b ar", {}); }), HasSubstr("is no name for a body"));
  EXPECT_THAT(error_of([&] { m.add_frame("bar", {.on = "bar"}); }), HasSubstr("share their names"));
  EXPECT_THAT(error_of([&] { m.add_frame("end", {.on = "bar", .in = "bra"}); }),
              AllOf(HasSubstr("in:"), HasSubstr("did you mean 'bar'?")));
  EXPECT_THAT(error_of([&] {
                m.add_frame("end", {.on = "bar", .axes = {.x = Vec3d{1, 0, 0}, .z = Vec3d{1, 0, 1}}});
              }),
              HasSubstr("not perpendicular"));
  EXPECT_THAT(error_of([&] { m.add_output("a", {.kind = "jont", .of = "hinge"}); }),
              HasSubstr("did you mean 'joint'?"));
  EXPECT_THAT(error_of([&] { m.add_output("a", {.kind = "joint", .of = "hing"}); }),
              AllOf(HasSubstr("output 'a'"), HasSubstr("did you mean 'hinge'?")));
  EXPECT_THAT(error_of([&] { m.add_output("a", {.kind = "joint_force", .of = "hinge", .component = "fw"}); }),
              HasSubstr("fx, fy, fz"));
  EXPECT_THAT(error_of([&] { m.add_output("a", {.kind = "roll", .of = "bar", .component = "x"}); }),
              HasSubstr("no component"));
  EXPECT_THAT(error_of([&] { m.add_output("angle", {.kind = "roll", .of = "bar"}); }),
              HasSubstr("of this name"));
  EXPECT_THAT(error_of([&] { m.add_output("a", {.kind = "roll", .of = "bar", .offset = 1}); }),
              HasSubstr("'offset' belongs to 'joint'"));
  EXPECT_THAT(error_of([&] { m.add_tyre("t", {.on = "bar", .road = "track"}); }),
              AllOf(HasSubstr("tyre 't'"), HasSubstr("no road 'track'")));
  EXPECT_THAT(error_of([&] { m.add_road("r", {.points = {{1, 0}, {0, 0}}}); }), HasSubstr("road 'r'"));
  EXPECT_THAT(error_of([&] { m.add_flexible_body("f", nullptr); }), HasSubstr("no reduced body"));
  m.add_flexible_body("f", random_flexible_body(1), {.at = {0, 2, 0}});
  EXPECT_THAT(error_of([&] { m.add_load("l", {.on = "f.frist"}); }),
              AllOf(HasSubstr("did you mean 'first'?"), HasSubstr("nodes of 'f'")));
  EXPECT_THAT(error_of([&] {
                m.add_load("l", {.on = "f", .at = Vec3d{9, 9, 9}});
              }),
              AllOf(HasSubstr("has no node at"), HasSubstr("clamped")));
}

TEST(ModelBuilder, AFailedCallLeavesNothingBehind) {
  ModelBuilder m = pendulum(1, build::inertia(0.1, 0.1, 0.1));
  const std::size_t frames = m.build().frames.size();
  // The first side makes a frame before the second is found to be wrong.
  EXPECT_THROW(m.add_spring("s", {.between = {"ground", "bra"}, .at = {Vec3d{0, 0, 1}, std::nullopt}}),
               InputError);
  EXPECT_EQ(m.build().frames.size(), frames);
  m.add_spring(
      "s",
      {.between = {"ground", "bar"}, .at = {Vec3d{0, 0, 1}, std::nullopt}, .elastic = Function::linear(1)});
  EXPECT_EQ(m.build().frames.size(), frames + 1);
}

TEST(ModelBuilder, BuildSaysWhatTheWholeGetsWrong) {
  ModelBuilder m("nothing");
  EXPECT_THAT(error_of([&] { m.build(); }), HasSubstr("no body"));
  m.add_body("bar", {.mass = -1});
  m.add_joint("hinge", {.type = JointType::revolute,
                        .between = {"ground", "bar"},
                        .at = Vec3d{0, 0, 0},
                        .axis = y_axis,
                        .velocity = {1, 2}});
  const std::string error = error_of([&] { m.compile(); });
  EXPECT_THAT(error, AllOf(HasSubstr("body 'bar': mass is -1"),
                           HasSubstr("joint 'hinge': initial_velocity has 2 entries")));
}

TEST(ModelBuilder, CopiesGoTheirOwnWays) {
  ModelBuilder m = pendulum(1, build::inertia(0.1, 0.1, 0.1));
  ModelBuilder other = m;
  other.add_output("rate", {.kind = "joint_velocity", .of = "hinge"});
  EXPECT_EQ(m.build().outputs.size(), 3);
  EXPECT_EQ(other.build().outputs.size(), 4);
}

}  // namespace
}  // namespace mimbre::test::model_builder_test
