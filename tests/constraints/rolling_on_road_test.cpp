#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>

#include "constraints/rolling_on_road.h"
#include "math/turn.h"
#include "mimbre/generate.h"
#include "mimbre/model_builder.h"
#include "mimbre/simulation.h"
#include "roads/road_data.h"
#include "support/models.h"
#include "support/random_mechanism.h"
#include "support/simulate.h"

/// Wheels and balls that roll without slip on roads over grids.
namespace mimbre::test::rolling_on_road_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr double g = 9.81;

/// A grid of heights as YAML. Quadratic heights are what they are between its points, too, but for a
/// constant: the road is the mean over a cell of what is bilinear between them.
std::string grid_of(const std::function<double(double, double)>& height, double half = 3,
                    double spacing = 0.1) {
  const int points = 2 * static_cast<int>(std::lround(half / spacing)) + 1;
  std::string rows;
  for (int j = 0; j < points; ++j) {
    std::string row;
    for (int i = 0; i < points; ++i)
      row += fmt::format("{}{}", i > 0 ? ", " : "", height(-half + i * spacing, -half + j * spacing));
    rows += fmt::format("{}[{}]", j > 0 ? ", " : "", row);
  }
  return fmt::format("{{over: grid, origin: [{0}, {0}], spacing: [{1}, {1}], heights: [{2}]}}", -half,
                     spacing, rows);
}

/// Of f + ½ x · H x: the constant.
double lifted(const Eigen::Matrix2d& H, double spacing = 0.1) { return H.trace() * spacing * spacing / 8; }

std::string list(const Vector3d& v) { return fmt::format("[{}, {}, {}]", v[0], v[1], v[2]); }

/// What the work is refused with; empty: nothing.
std::string fault_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

struct Body {
  double mass = 2, radius = 0.3, crown = 0.1, transverse = 0.05, axial = 0.08;
  Vector3d place = Vector3d::Zero(), axis = Vector3d::UnitY(), omega = Vector3d::Zero();

  std::string text(const std::string& constraint) const {
    const Matrix3d I = transverse * Matrix3d::Identity() + (axial - transverse) * axis * axis.transpose();
    return fmt::format(R"(
bodies:
  wheel: {{mass: {}, com: {}, inertia: [{}, {}, {}, {}, {}, {}]}}
joints:
  free: {{type: floating, between: [ground, wheel], at: {}, velocity: [null, null, null, {}, {}, {}]}}
constraints:
  rim: {{{}, radius: {}, crown: {}}}
)",
                       mass, list(place), I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2), list(place),
                       omega[0], omega[1], omega[2], constraint, radius, crown);
  }
  std::string on_road(const std::string& road) const {
    return text(fmt::format("type: rolling_on_road, on: wheel, road: hills, at: {}, axis: {}", list(place),
                            list(axis))) +
           "roads:\n  hills: " + road + "\n";
  }
};

class RollingOnRoad : public testing::TestWithParam<Formulation> {
 protected:
  Simulation simulation(const std::string& text, double step) const {
    return precise_simulation_of(text, GetParam(), step);
  }
};
INSTANTIATE_TEST_SUITE_P(Formulations, RollingOnRoad,
                         testing::Values(Formulation::relative, Formulation::natural), [](const auto& of) {
                           return of.param == Formulation::natural ? "natural" : "relative";
                         });

TEST_P(RollingOnRoad, AGridThatIsAPlaneIsThatPlane) {
  const Vector3d normal = Vector3d(-0.2, 0.1, 1).normalized();
  Body wheel;
  wheel.axis = Vector3d(0.2, 0.9, 0.3).normalized();
  wheel.omega = Vector3d(0.4, 6, 0.8);
  const double s = normal.cross(wheel.axis).norm();
  wheel.place = ((wheel.radius - wheel.crown) * s + wheel.crown) * normal;
  const std::string on_grid = wheel.on_road(grid_of([](double x, double y) { return 0.2 * x - 0.1 * y; })),
                    on_plane = wheel.text(fmt::format(
                        "type: rolling, between: [ground, wheel], at: [[0, 0, 0], {}], axis: {}, axis2: {}",
                        list(wheel.place), list(normal), list(wheel.axis)));
  // The equations of velocities are others, which a step mixes with those of positions.
  double apart[2];
  for (int k = 0; k < 2; ++k) {
    const double step = k == 0 ? 0.004 : 0.002;
    Simulation one = simulation(on_grid, step), other = simulation(on_plane, step);
    run_to(one, 0.8);
    run_to(other, 0.8);
    const spec::Pose a = one.pose(one.body("wheel")), b = other.pose(other.body("wheel"));
    EXPECT_GT((b.position - wheel.place).norm(), 0.9);
    apart[k] = (a.position - b.position).norm() + (a.rotation - b.rotation).norm();
    EXPECT_LT(apart[k], 2e-6);
    if (k == 0) continue;
    // The reaction at the centre, however the equations are scaled.
    for (const char* part : {"force.x", "force.z", "moment.x", "moment.y"})
      EXPECT_NEAR(channel(one, std::string("constraint.rim.") + part),
                  channel(other, std::string("constraint.rim.") + part), 1e-4)
          << part;
  }
  EXPECT_LT(apart[1], 0.4 * apart[0]);
}

/// A ball at the bottom of a paraboloid of curvature k swings with ω² = 5/7 g / (1/k − r).
TEST_P(RollingOnRoad, ABallSwingsInABowl) {
  const double k = 0.8, r = 0.2, x = 1e-3, rate = std::sqrt(5.0 / 7 * g / (1 / k - r));
  Body ball;
  ball.radius = ball.crown = r;
  ball.transverse = ball.axial = 0.4 * ball.mass * r * r;
  const double low = lifted(k * Eigen::Matrix2d::Identity());
  ball.place = Vector3d(x * (1 - k * r), 0, low + k * x * x / 2 + r);
  Simulation s = simulation(
      ball.on_road(grid_of([&](double u, double v) { return k / 2 * (u * u + v * v); }, 1)), pi / rate / 500);
  const double from = s.pose(s.body("wheel")).position[0];
  run_to(s, pi / rate);
  EXPECT_NEAR(s.pose(s.body("wheel")).position[0], -from, 1e-4 * from);
}

/// On saddles, bowls and hills that bend less than the wheels: the energy is kept, and no point of the wheel
/// is below the ground, while one is on it.
TEST_P(RollingOnRoad, KeepsTheEnergyAndTheContactFromManyStarts) {
  Random random(11);
  for (int k = 0; k < 60; ++k) {
    Eigen::Matrix2d H;
    H << random.number(-0.5, 0.5), random.number(-0.4, 0.4), 0, random.number(-0.5, 0.5);
    H(1, 0) = H(0, 1);
    const Eigen::Vector2d slope(random.number(-0.3, 0.3), random.number(-0.3, 0.3));
    const auto height = [&](double x, double y) {
      const Eigen::Vector2d p(x, y);
      return slope.dot(p) + 0.5 * p.dot(H * p);
    };
    Body wheel;
    wheel.crown = k % 3 == 0 ? 0 : random.number(0, wheel.radius);
    wheel.axis = random.vector(1);
    if (std::abs(wheel.axis.normalized()[2]) > 0.7) wheel.axis[2] = 0.1;
    wheel.axis.normalize();
    wheel.omega = random.vector(4);
    wheel.place = Vector3d(0, 0, wheel.radius);
    Simulation s = simulation(wheel.on_road(grid_of(height, 2)), 0.002);
    const double at_play = wheel.mass * g * wheel.radius + s.energy().kinetic;
    for (int step = 0; step < 50; ++step) ASSERT_TRUE(s.step().ok()) << k;
    EXPECT_LT(std::abs(s.energy().numerical), 2e-3 * at_play) << k;
    const spec::Pose pose = s.pose(s.body("wheel"));
    const Vector3d axis = pose.rotation * wheel.axis, one = axis.unitOrthogonal(), two = axis.cross(one);
    double least = 1;
    for (int i = 0; i < 720; ++i)
      for (int j = 0; j <= 180; ++j) {
        const double around = pi * i / 360, across = pi * j / 180 - pi / 2;
        const Vector3d out = std::cos(around) * one + std::sin(around) * two;
        const Vector3d p = pose.position + (wheel.radius - wheel.crown) * out +
                           wheel.crown * (std::cos(across) * out + std::sin(across) * axis);
        least = std::min(least, p[2] - height(p[0], p[1]) - lifted(H));
      }
    EXPECT_GT(least, -1e-8) << k;
    EXPECT_LT(least, 1e-4) << k;  // of the samples
  }
}

TEST(RollingOnRoad, BothFormulationsAgreeToTheSquareOfTheStep) {
  Body wheel;
  wheel.axis = Vector3d(0.1, 1, 0.2).normalized();
  wheel.omega = Vector3d(0.3, 5, 0.5);
  wheel.place = Vector3d(-0.5, 0.2, 0.35);
  const std::string text =
      wheel.on_road(grid_of([](double x, double y) { return 0.15 * std::sin(1.3 * x) * std::cos(1.1 * y); }));
  double apart[2];
  for (int k = 0; k < 2; ++k) {
    Vector3d places[2];
    for (const Formulation formulation : {Formulation::relative, Formulation::natural}) {
      Simulation s = simulation_of(text, formulation, k == 0 ? 0.004 : 0.002);
      run_to(s, 0.8);
      places[formulation == Formulation::natural] = s.pose(s.body("wheel")).position;
    }
    apart[k] = (places[0] - places[1]).norm();
    EXPECT_GT((places[0] - wheel.place).norm(), 0.5);
  }
  EXPECT_LT(apart[1], 1e-3);
  EXPECT_NEAR(apart[0] / apart[1], 4, 1.2);
}

/// Along any motion, whether it touches or not: rates and second derivatives of the equations on a random
/// grid of heights up to `rough`. Returns how many places had no equations.
int check_derivatives(double rough, int samples) {
  int none = 0;
  RoadData road;
  road.over = spec::Road::Over::grid;
  road.origin = {-2, -2};
  road.spacing = {0.5, 0.4};
  road.rows = 12;
  road.columns = 9;
  Random random(5);
  for (int k = 0; k < road.rows * road.columns; ++k) road.heights.push_back(random.number(-rough, rough));
  for (int sample = 0; sample < samples; ++sample) {
    ConstraintData data;
    const double radius = 0.3, crown = sample % 4 == 0 ? 0.0 : random.number(0.02, 0.3);
    data.numbers = {radius, crown};
    const Vector3d origin = random.vector(0.5);
    const Matrix3d A = turn_by(random.vector(2));
    data.numbers.append(origin.begin(), origin.end());
    data.numbers.append(A.data(), A.data() + 9);
    // d(t), and turning by a vector that is even in time about a turned start.
    const Vector3d d0 = random.vector(0.3) + Vector3d(0, 0, 0.4), d1 = random.vector(1),
                   d2 = random.vector(1);
    const Vector3d spin = random.vector(3);
    const Matrix3d start =
        Eigen::AngleAxisd(random.number(-0.6, 0.6), Vector3d::UnitX()).toRotationMatrix() *
        Eigen::AngleAxisd(-pi / 2 + random.number(-0.4, 0.4), Vector3d::UnitX()).toRotationMatrix();
    const auto at = [&](double t, ScalarEquation<double>* out) {
      const RelativeMotion<double> motion{A.transpose() * turn_by(t * spin) * start,
                                          A.transpose() * (d0 + t * d1 + t * t / 2 * d2 - origin),
                                          A.transpose() * (d1 + t * d2),
                                          A.transpose() * d2,
                                          A.transpose() * spin,
                                          Vector3d::Zero()};
      constraints::RollingOnRoad::equations<double>(
          {data, {}, motion, nullptr, nullptr, nullptr, 0.01, &road}, out);
      return motion;
    };
    ScalarEquation<double> now[3], next[3], last[3];
    const double h = 1e-5;
    const RelativeMotion<double> motion = at(0, now), after = at(h, next), before = at(-h, last);
    if (std::isnan(next[2].value) || std::isnan(now[2].value) || std::isnan(last[2].value)) {
      ++none;
      continue;
    }
    for (int r = 0; r < 3 && rough < 0.1; ++r) {  // else curvatures jump too much at borders of cells
      const double second = (next[r].rate(after) - last[r].rate(before)) / (2 * h);
      EXPECT_NEAR(now[r].second(motion), second, 1e-5 * std::max(1.0, std::abs(second)))
          << sample << ' ' << r;
    }
    const double rate = (next[2].value - last[2].value) / (2 * h);
    EXPECT_NEAR(now[2].rate(motion), rate, (rough > 0.1 ? 1e-5 : 1e-8) * std::max(1.0, std::abs(rate)))
        << sample;
    for (int r = 0; r < 2; ++r) EXPECT_NEAR(now[r].value, 0.01 * now[r].rate(motion), 1e-14);
  }
  return none;
}

TEST(RollingOnRoad, EquationsHaveTheirDerivatives) {
  EXPECT_EQ(check_derivatives(0.02, 50), 0);
  // With hollows that are narrower than the wheel: their derivatives, or none.
  const int none = check_derivatives(0.8, 200);
  EXPECT_GT(none, 10);
  EXPECT_LT(none, 180);
}

TEST(RollingOnRoad, WarnsOfNarrowHollows) {
  Body wheel;
  wheel.place = Vector3d(0, 0, 0.3);
  for (const double bend : {3.0, 3.7}) {
    std::vector<Diagnostic> warnings;
    parse_model("mimbre: 1\ntitle: test\noutputs: [{name: z, position: wheel, component: z}]" +
                    wheel.on_road(grid_of([&](double x, double) { return bend / 2 * x * x; }, 0.5)),
                "test.yaml", ".", {}, &warnings);
    ASSERT_EQ(warnings.size(), bend * wheel.radius > 1 ? 1u : 0u);
    for (const Diagnostic& warning : warnings)
      EXPECT_THAT(warning.message, testing::HasSubstr("whose radius is 0.27 m"));
  }
}

TEST(RollingOnRoad, IsBuiltInCode) {
  ModelBuilder m;
  m.add_body("ball", {.mass = 1, .com = {0, 0, 0.3}, .inertia = build::inertia(0.036, 0.036, 0.036)});
  m.add_road("flat",
             {.over = spec::Road::Over::grid, .heights = Eigen::MatrixXd::Zero(3, 3), .origin = {-1, -1}});
  build::Constraint rim{.type = "rolling_on_road",
                        .between = {"ground", "ball"},
                        .axis = Vector3d::UnitY(),
                        .numbers = {{"radius", 0.3}, {"crown", 0.3}},
                        .road = "flat"};
  const auto fault = [&](const build::Constraint& given) {
    return fault_of([&] { m.add_constraint("rim", given); });
  };
  EXPECT_THAT(fault(rim), testing::HasSubstr("the wheel's centre needs its place"));
  rim.at[1] = Vector3d(0, 0, 0.3);
  rim.road.clear();
  EXPECT_THAT(fault(rim), testing::HasSubstr("'road' is missing"));
  rim.road = "flat";
  m.add_constraint("rim", rim);
  Simulation s(m.compile());
  EXPECT_EQ(s.degrees_of_freedom(), 3);
  run_to(s, 0.1);
  EXPECT_NEAR(s.pose(s.body("ball")).position[2], 0.3, 1e-12);
}

TEST(RollingOnRoad, RefusesARoadThatBendsMoreThanTheWheel) {
  Body ball;
  ball.radius = ball.crown = 2;
  ball.place = Vector3d(0.1, 0, 2);
  for (const Formulation formulation : {Formulation::relative, Formulation::natural}) try {
      simulation_of(ball.on_road(grid_of([](double x, double y) { return 0.4 * (x * x + y * y); })),
                    formulation);
      ADD_FAILURE() << "a ball of 2 m fits into a hollow of 1.25 m";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("narrower than itself"));
      EXPECT_THAT(error.what(), testing::HasSubstr("'rim'"));
    }
}

TEST(RollingOnRoad, SaysWhatIsWrong) {
  Body wheel;
  wheel.place = Vector3d(0, 0, 0.3);
  const std::string grid = grid_of([](double, double) { return 0.0; }, 1, 0.5);
  const auto message = [](const std::string& text) { return fault_of([&] { model_of(text); }); };
  EXPECT_THAT(message(wheel.on_road("{over: distance, points: [[0, 0], [1, 0]]}")),
              testing::HasSubstr("needs a road over a grid"));
  EXPECT_THAT(
      message(wheel.text("type: rolling_on_road, on: wheel, road: hill, at: [0, 0, 0.3], axis: [0, 1, 0]") +
              "roads:\n  hills: " + grid + "\n"),
      testing::HasSubstr("hills"));
  EXPECT_THAT(message(wheel.text("type: rolling_on_road, on: wheel, road: hills, at: [0, 0, 0.3]") +
                      "roads:\n  hills: " + grid + "\n"),
              testing::HasSubstr("'axis' is missing"));
  EXPECT_THAT(message(wheel.text("type: rolling_on_road, on: wheel, road: hills, axis: [0, 1, 0]") +
                      "roads:\n  hills: " + grid + "\n"),
              testing::HasSubstr("'at' is missing"));
  EXPECT_THAT(
      message(wheel.text("type: rolling_on_road, on: hub, road: hills, at: [0, 0, 0.3], axis: [0, 1, 0]") +
              "frames:\n  hub: {body: wheel, at: [0, 0, 0.3]}\nroads:\n  hills: " + grid + "\n"),
      testing::HasSubstr("a frame has its place already"));
  wheel.crown = 0.4;
  EXPECT_THAT(message(wheel.on_road(grid)), testing::HasSubstr("crown is 0.4 m"));
  wheel.crown = 0.1;
  EXPECT_THAT(message(wheel.on_road("{over: grid, file: " + road_path("bend_double.crg") + "}")),
              testing::HasSubstr("no wheel rolls over a kink"));
  EXPECT_THAT(fault_of([&] { generate_code(model_of(wheel.on_road(grid)), {}, "wheel"); }),
              testing::HasSubstr("code is not made of wheels that roll on a road"));
}

}  // namespace
}  // namespace mimbre::test::rolling_on_road_test
