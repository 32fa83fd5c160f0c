#include <fmt/format.h>
#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "forces/magic_formula.h"
#include "forces/road_surface.h"
#include "support/models.h"
#include "support/simulate.h"
#include "tyre_files/tyre_data.h"

/// Wheels that roll: on a rig, and under a vehicle of five rigid bodies without a suspension, against what a
/// bicycle does with the same tyres, what friction allows and what energy is left.
namespace mimbre::test::tyre_test {
namespace {

constexpr double g = 9.81;

/// The vehicle. Masses of wheels and knuckles included, its centre of mass is at x = 0.
struct Car {
  double front = 1.2, rear = 1.4, track = 1.5, height = 0.5, chassis = 1200, wheel = 20, knuckle = 2;
  double radius = 0.3, stiffness = 2e5, cornering = 45e3, slip = 60e3, friction = 0.9;
  double front_grip = 1;  ///< factor of the cornering stiffness of the front tyres
  double relaxation = 0.4, half_length = 0.06, load = 3200, resistance = 0;
  double speed = 0, height_of_start = 0, pitch = 0;
  double roll_rate = 0, sideways = 0;
  std::string steer = "0", road = "points: [[-1000, 0], [1000, 0]]";
  bool locked = false;
  double end = 10;
  std::string file;  ///< of a Magic Formula tyre

  double base() const { return front + rear; }
  double mass() const { return chassis + 4 * (wheel + knuckle); }
  /// Of one wheel that stands.
  double load_of(bool at_front) const { return 0.5 * mass() * g * (at_front ? rear : front) / base(); }
  double rolling_radius(bool at_front) const { return radius - load_of(at_front) / stiffness / 3; }

  std::string tyre(bool at_front) const {
    if (!file.empty()) return fmt::format("model: magic_formula, file: {}", tyre_path(file));
    return fmt::format(
        "model: brush, stiffness: {}, damping: 2000, radius: {}, longitudinal_stiffness: {}, "
        "cornering_stiffness: {}, friction: {}, longitudinal_relaxation: {}, lateral_relaxation: {}, "
        "half_length: {}, load: {}, rolling_resistance: {}",
        stiffness, radius, slip, at_front ? front_grip * cornering : cornering, friction, relaxation,
        relaxation, half_length, load, resistance);
  }

  std::string text() const {
    // The chassis where it makes up for the wheels, which are not symmetric about its centre.
    const double corner = wheel + knuckle, com = -(2 * corner * (front - rear)) / chassis;
    std::string bodies =
                    fmt::format("  chassis: {{mass: {}, com: [{}, 0, {}], inertia: [400, 1600, 1800]}}\n",
                                chassis, com, height),
                joints, tyres;
    joints = fmt::format(
        "  free: {{type: floating, between: [ground, chassis], at: [0, 0, 0], position: [0, 0, {}, 0, {}, "
        "0], "
        "velocity: [{}, {}, 0, {}, 0, 0]}}\n",
        height_of_start, pitch, speed * std::cos(pitch), sideways, roll_rate);
    for (const bool at_front : {true, false})
      for (const double side : {1.0, -1.0}) {
        const std::string name = fmt::format("{}{}", at_front ? 'f' : 'r', side > 0 ? 'l' : 'r');
        const std::string at =
            fmt::format("[{}, {}, {}]", at_front ? front : -rear, side * track / 2, radius);
        bodies += fmt::format(
            "  k{0}: {{mass: {2}, com: {1}, inertia: [0.02, 0.02, 0.02]}}\n"
            "  w{0}: {{mass: {3}, com: {1}, inertia: [0.5, 0.9, 0.5]}}\n",
            name, at, knuckle, wheel);
        joints += fmt::format(
            "  s{0}: {{type: revolute, between: [chassis, k{0}], at: {1}, axis: [0, 0, 1], drive: "
            "{{position: \"{2}\"}}}}\n",
            name, at, at_front ? steer : "0");
        joints += fmt::format(
            "  h{0}: {{type: revolute, between: [k{0}, w{0}], at: {1}, axis: [0, 1, 0], {2}}}\n", name, at,
            locked ? std::string("drive: {position: 0}")
                   : fmt::format("velocity: {}", speed / rolling_radius(at_front)));
        tyres += fmt::format("  {}: {{on: w{}, road: track, {}}}\n", name, name, tyre(at_front));
      }
    return fmt::format(R"y(
bodies:
{}joints:
{}roads: {{track: {{over: distance, {}}}}}
tyres:
{}outputs:
  - {{name: x, position: chassis, component: x}}
  - {{name: y, position: chassis, component: y}}
  - {{name: z, position: chassis, component: z}}
  - {{name: vx, velocity: chassis, component: x}}
  - {{name: vy, velocity: chassis, component: y}}
  - {{name: yaw, yaw: chassis}}
  - {{name: yaw_rate, angular_velocity: chassis, component: z}}
simulation: {{step: 1 ms, end: {}}}
)y",
                       bodies, joints, road, tyres, end);
  }
  Simulation simulation(Formulation formulation) const { return simulation_of(text(), formulation); }
};

const std::array<std::string, 4> wheels{"fl", "fr", "rl", "rr"};

class Tyres : public testing::TestWithParam<Formulation> {};

/// Loads are those of statics; a free roll goes on and on.
TEST_P(Tyres, RollFreely) {
  Car car;
  car.speed = 20;
  car.height_of_start = -car.load_of(true) / car.stiffness;
  Simulation s = car.simulation(GetParam());
  run_to(s, 1);
  const double speed = channel(s, "vx");
  EXPECT_NEAR(speed, 20, 0.01);
  for (const std::string& w : wheels) {
    EXPECT_NEAR(channel(s, fmt::format("tyre.{}.slip", w)), 0, 1e-5);
  }
  run_to(s, 3);
  for (const std::string& w : wheels)
    EXPECT_NEAR(channel(s, fmt::format("tyre.{}.vertical", w)), car.load_of(w[0] == 'f'), 2) << w;
  // The steps of natural coordinates take a little from wheels that turn by 4° in each.
  EXPECT_NEAR(channel(s, "vx"), speed, (GetParam() == Formulation::natural ? 2e-4 : 1e-5) * speed);
  EXPECT_NEAR(channel(s, "y"), 0, 1e-9);
}

/// Rolling resistance is the part of the weight that was given.
TEST_P(Tyres, RollingResistanceSlowsDown) {
  Car car;
  car.speed = 20;
  car.resistance = 0.02;
  car.height_of_start = -car.load_of(true) / car.stiffness;
  Simulation s = car.simulation(GetParam());
  run_to(s, 0.5);
  const double first = channel(s, "vx");
  run_to(s, 2.5);
  // What turns with the wheels is slowed down too; the arm of the moment is the wheel's radius.
  double turning = 0;
  for (const bool at_front : {true, false}) turning += 2 * 0.9 / std::pow(car.rolling_radius(at_front), 2);
  const double radius = 0.5 * (car.rolling_radius(true) + car.rolling_radius(false));
  EXPECT_NEAR((first - channel(s, "vx")) / 2,
              0.02 * g * car.radius / radius * car.mass() / (car.mass() + turning),
              (GetParam() == Formulation::natural ? 1e-2 : 2e-3) * 0.02 * g);
}

/// Locked wheels slow down by μ g, whatever they are, and then stand. What they rub away is what there was.
TEST_P(Tyres, LockedWheelsSlideAndStop) {
  Car car;
  car.speed = 10;
  car.locked = true;
  car.height_of_start = -car.load_of(true) / car.stiffness;
  Simulation s = car.simulation(GetParam());
  run_to(s, 0.3);
  const double first = channel(s, "vx");
  run_to(s, 0.8);
  EXPECT_NEAR((first - channel(s, "vx")) / 0.5, car.friction * g, 5e-3 * car.friction * g);
  run_to(s, 6);  // it has stopped, and nods no more
  const double x = channel(s, "x");
  EXPECT_NEAR(channel(s, "vx"), 0, 1e-6);
  const EnergyBalance e = s.energy();
  EXPECT_NEAR(e.dissipated, 0.5 * car.mass() * 100, 0.01 * 0.5 * car.mass() * 100);
  EXPECT_LT(std::abs(e.numerical), 5e-3 * 0.5 * car.mass() * 100);
  run_to(s, 8);
  EXPECT_NEAR(channel(s, "x"), x, 1e-6);
}

/// On a slope of 15 % with brakes on: what settles in the first seconds, and then nothing.
TEST_P(Tyres, StandOnASlope) {
  Car car;
  car.locked = true;
  car.road = "points: [[-100, -15], [100, 15]]";
  car.pitch = -std::atan(0.15);
  car.height_of_start = 0.005;
  Simulation s = car.simulation(GetParam());
  run_to(s, 5);
  const double x = channel(s, "x"), y = channel(s, "y"), z = channel(s, "z");
  run_to(s, 15);
  EXPECT_NEAR(channel(s, "x"), x, 1e-6);
  EXPECT_NEAR(channel(s, "y"), y, 1e-6);
  EXPECT_NEAR(channel(s, "z"), z, 1e-6);
  double along = 0;
  for (const std::string& w : wheels) along += channel(s, fmt::format("tyre.{}.longitudinal", w));
  EXPECT_NEAR(along, car.mass() * g * std::sin(std::atan(0.15)), 1);
}

/// Understeer gradient of a bicycle with the car's tyres at their loads and trails, rad s²/m.
double understeer(const Car& car) {
  const double front = 2 * car.front_grip * car.cornering * car.load_of(true) / car.load,
               rear = 2 * car.cornering * car.load_of(false) / car.load;
  const auto trail = [&](bool at_front) {
    return car.half_length * std::sqrt(car.load_of(at_front) / car.load) / 3;
  };
  const double a = car.front - trail(true), b = car.rear + trail(false);
  return car.mass() / (a + b) * (b / front - a / rear);
}

/// The steering angle beyond that of the radius is that of a bicycle with the same tyres, and the trails.
TEST_P(Tyres, CornerAsABicycleDoes) {
  Car car;
  car.speed = 20;
  car.height = 0.35;
  car.steer = "0.01*min(1, t)";
  car.height_of_start = -car.load_of(true) / car.stiffness;
  Simulation s = car.simulation(GetParam());
  run_to(s, 4);
  const double speed = std::hypot(channel(s, "vx"), channel(s, "vy")), rate = channel(s, "yaw_rate"),
               across = speed * rate;
  const double bicycle = understeer(car);
  const double measured = (0.01 - car.base() / speed * rate) / across;
  EXPECT_NEAR(across, 1.3, 0.5);
  EXPECT_NEAR(measured, bicycle, 0.05 * std::abs(bicycle) + 2e-5);
}

/// The understeer gradient by slowly rising steering: what the steering beyond that of the radius is at first
/// for each m/s² of lateral acceleration. The front tyres are the softer ones.
TEST_P(Tyres, UndersteerAsABicycleDoes) {
  Car car;
  car.speed = 20;
  car.height = 0.35;
  car.front_grip = 0.8;
  car.steer = "0.003*t";
  car.height_of_start = -car.load_of(true) / car.stiffness;
  Simulation s = car.simulation(GetParam());
  // By least squares c + K a + K₂ a²: c, since the car turns later than it is steered; K₂, since tyres
  // soften.
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Eigen::Vector3d moments = Eigen::Vector3d::Zero();
  double across = 0;
  for (int k = 10; k <= 70; ++k) {
    const double time = 0.1 * k;
    run_to(s, time);
    const double speed = std::hypot(channel(s, "vx"), channel(s, "vy")), rate = channel(s, "yaw_rate");
    across = speed * rate;
    const Eigen::Vector3d terms(1, across, across * across);
    squares += terms * terms.transpose();
    moments += terms * (0.003 * time - car.base() / speed * rate);
  }
  EXPECT_NEAR(across, 2.4, 0.2);
  const double measured = squares.ldlt().solve(moments)[1], bicycle = understeer(car);
  EXPECT_NEAR(measured, bicycle, 0.05 * bicycle);
}

/// To the right as to the left.
TEST_P(Tyres, AreTheSameOnBothSides) {
  Car left, right;
  left.speed = right.speed = 15;
  left.steer = "0.03*sin(3*t)";
  right.steer = "-0.03*sin(3*t)";
  Simulation a = left.simulation(GetParam()), b = right.simulation(GetParam());
  run_to(a, 1.5);
  run_to(b, 1.5);
  EXPECT_GT(std::abs(channel(a, "y")), 0.05);
  EXPECT_NEAR(channel(a, "y"), -channel(b, "y"), 1e-7);
  EXPECT_NEAR(channel(a, "x"), channel(b, "x"), 1e-7);
  EXPECT_NEAR(channel(a, "tyre.fl.lateral"), -channel(b, "tyre.fr.lateral"), 1e-3);
}

/// Through a slalom near the limit: energy that is not there any more was rubbed away.
TEST_P(Tyres, KeepTheBalanceOfEnergy) {
  Car car;
  car.speed = 15;
  car.steer = "0.1*sin(4*t)";
  Simulation s = car.simulation(GetParam());
  double lost = 0;
  const double start = 0.5 * car.mass() * 225;
  for (int k = 1; k <= 30; ++k) {
    run_to(s, 0.1 * k);
    const double now = s.energy().dissipated;
    EXPECT_GE(now, lost - 1e-3 * start);
    lost = now;
  }
  EXPECT_GT(lost, 0.05 * start);
  EXPECT_LT(std::abs(s.energy().numerical), 2e-3 * start);
}

/// Sideways at speed, it trips and rolls over: numbers all the way.
TEST_P(Tyres, SurviveARollOver) {
  Car car;
  car.height = 1.2;
  car.friction = 1.5;
  car.speed = 10;
  car.sideways = 9;
  car.roll_rate = -3;
  Simulation s = car.simulation(GetParam());
  for (int k = 1; k <= 30; ++k) {
    run_to(s, 0.05 * k);
    for (const char* name : {"x", "y", "z", "tyre.fl.vertical", "tyre.rr.lateral"})
      ASSERT_TRUE(std::isfinite(channel(s, name))) << name << k;
  }
}

/// In the air there is no force.
TEST_P(Tyres, NeedTheRoad) {
  Car car;
  car.speed = 10;
  car.height_of_start = 0.5;
  Simulation s = car.simulation(GetParam());
  run_to(s, 0.2);
  for (const std::string& w : wheels)
    for (const char* what : {"vertical", "longitudinal", "lateral", "aligning", "slip", "deflection"})
      EXPECT_EQ(channel(s, fmt::format("tyre.{}.{}", w, what)), 0) << w << what;
  EXPECT_NEAR(channel(s, "z"), car.height + 0.5 - 0.5 * g * 0.04, 1e-4);
}

/// The car on tyres of appendix 3.
Car on_magic_tyres() {
  Car car;
  car.file = "car_205_60R15_61.tir";
  car.radius = 0.3135;
  return car;
}

/// Its sliding friction, measured by the formula itself at the load of each wheel.
TEST_P(Tyres, OfTheMagicFormulaBrakeToAStop) {
  Car car = on_magic_tyres();
  car.speed = 15;
  car.locked = true;
  Simulation s = car.simulation(GetParam());
  run_to(s, 0.6);
  const TyreProperties tyre = tyre_of(car.file);
  double wanted = 0, measured = 0;
  for (const std::string& w : wheels) {
    const auto of = [&](const char* what) { return channel(s, fmt::format("tyre.{}.{}", w, what)); };
    forces::MagicInput<double> in{
        .Fz = of("vertical"), .kappa = -1, .alpha = 0, .gamma = 0, .Vx = channel(s, "vx")};
    wanted += forces::magic_formula(tyre.numbers.data(), in).Fx;
    measured += of("longitudinal");
  }
  EXPECT_LT(wanted, -0.5 * car.mass() * g);
  EXPECT_NEAR(measured, wanted, 0.02 * std::abs(wanted));
  run_to(s, 3);
  const double x = channel(s, "x");
  run_to(s, 5);
  EXPECT_NEAR(channel(s, "x"), x, 0.03);  // it nods: these tyres damp by 50 N s/m
  EXPECT_LT(std::abs(s.energy().numerical), 0.01 * 0.5 * car.mass() * 225);
}

TEST_P(Tyres, OfTheMagicFormulaStandOnASlope) {
  Car car = on_magic_tyres();
  car.locked = true;
  car.road = "points: [[-100, -15], [100, 15]]";
  car.pitch = -std::atan(0.15);
  car.height_of_start = -0.01;
  Simulation s = car.simulation(GetParam());
  run_to(s, 1);
  const double x = channel(s, "x");
  run_to(s, 5);  // its tyres damp by 50 N s/m: it nods on
  EXPECT_NEAR(channel(s, "x"), x, 2e-3);
  EXPECT_NEAR(channel(s, "vx"), 0, 5e-3);
}

/// A car whose hubs are put below the road is pushed out, and a warning names the tyres. Where its friction
/// under 150 times its load is too much for the step, the message names them, too.
TEST_P(Tyres, OfTheMagicFormulaPushHubsBelowTheRoadOut) {
  for (const double depth : {0.4, 0.8, 2.0, 10.0}) {
    Car car = on_magic_tyres();
    car.speed = 15;
    car.height_of_start = -depth;
    Simulation s = car.simulation(GetParam());
    StepReport report;
    while (s.time() < 0.15 && report.ok()) report = s.step();
    if (depth < 1) {
      EXPECT_TRUE(report.ok()) << s.explain(report);
    }
    if (!report.ok()) {
      EXPECT_NE(s.explain(report).find("tyre 'fl' had its hub below the road"), std::string::npos)
          << s.explain(report);
    }
    EXPECT_GT(channel(s, "z"), car.height - depth) << depth;
    for (const std::string& w : wheels)
      EXPECT_TRUE(std::isfinite(channel(s, fmt::format("tyre.{}.slip", w))));
    const std::vector<std::string> warnings = s.warnings();
    EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(), [](const std::string& text) {
      return text.find("its hub is below the road") != std::string::npos;
    }));
  }
}

/// Along straight on, then through a slalom: what is not there any more was rubbed away, and the force across
/// is that of the formula at the slip that there is.
TEST_P(Tyres, OfTheMagicFormulaKeepTheBalanceOfEnergy) {
  Car car = on_magic_tyres();
  car.speed = 15;
  car.steer = "0.05*sin(2*t)";
  Simulation s = car.simulation(GetParam());
  run_to(s, 3);
  const double start = 0.5 * car.mass() * 225;
  EXPECT_LT(std::abs(s.energy().numerical), 5e-3 * start);
  EXPECT_GT(s.energy().dissipated, 0.005 * start);
}

/// A hub that is led along at 0.36 m: beyond a bump, and before it, a tyre is pressed in as on a level road.
TEST_P(Tyres, FeelALevelRoadBeyondAProfile) {
  const auto pressed = [](const std::string& road) {
    return simulation_of(fmt::format(R"y(
gravity: [0, 0, 0]
bodies: {{hub: {{mass: 1, com: [-1, 0, 0.36], inertia: [1, 1, 1]}}}}
joints: {{way: {{type: prismatic, between: [ground, hub], at: [-1, 0, 0.36], axis: [1, 0, 0], drive: {{speed: 1}}}}}}
roads: {{bump: {}}}
tyres: {{tyre: {{on: hub, at: [-1, 0, 0.36], road: bump, stiffness: 1e5, radius: 0.4}}}}
outputs: [{{name: force, tyre_force: tyre}}]
simulation: {{step: 0.125, end: 3}}
)y",
                                     road),
                         GetParam());
  };
  // The hub is at x = t − 1.
  Simulation once = pressed("{over: distance, points: [[0, 0], [0.5, 0.05], [1, 0.01]]}"),
             again = pressed("{over: distance, points: [[0, 0], [0.5, 0.05], [1, 0.01]], repeat: 1.5}"),
             rig = pressed("{over: time, points: [[1, 0], [1.5, 0.05], [2, 0.01]]}");
  using Forces = std::vector<std::pair<double, double>>;  // by time
  for (const auto& [time, force] : Forces{{0.5, 4000}, {1, 4000}, {1.5, 9000}, {2.25, 5000}, {2.75, 5000}})
    for (Simulation* s : {&once, &rig}) {
      run_to(*s, time);
      EXPECT_NEAR(channel(*s, "force"), force, 1e-6) << time;
    }
  for (const auto& [time, force] :
       Forces{{0.25, 7000}, {0.75, 5000}, {1, 4000}, {1.5, 9000}, {2.25, 5000}, {2.75, 6500}}) {
    run_to(again, time);
    EXPECT_NEAR(channel(again, "force"), force, 1e-6) << time;
  }
  // Half of a footprint over the foot of the bump: the mean is that of a triangle, the slope half the bump's.
  const RoadData& road = once.model().compiled().roads.front();
  const roads::Height foot = roads::height(road, 0.1, 0, 0), end = roads::height(road, 0.1, 1, 0);
  EXPECT_NEAR(foot.z, 0.0025, 1e-15);
  EXPECT_NEAR(foot.x, 0.05, 1e-14);
  EXPECT_NEAR(end.z, 0.01 + 0.002, 1e-15);
  EXPECT_NEAR(end.x, -0.04, 1e-14);
}

INSTANTIATE_TEST_SUITE_P(BothFormulations, Tyres,
                         testing::Values(Formulation::relative, Formulation::natural));

}  // namespace
}  // namespace mimbre::test::tyre_test
