#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "support/brush.h"
#include "support/models.h"
#include "support/simulate.h"

/// The Iltis with a driver, examples/iltis: between cones, around circles, on the brakes; its understeer
/// against that of a bicycle, and what energy is left.
namespace mimbre::examples_test::iltis_manoeuvres_test {
namespace {

using test::channel, test::run_to;

constexpr double base = 2.017;                                         ///< from axle to axle, m
constexpr double half_track = 0.66;                                    ///< m
constexpr double front_end = 0.97 + 0.364, rear_end = -1.047 - 0.364;  ///< of the wheels, m
constexpr double width = 1.52;                                         ///< m

const std::array<std::string, 4> wheels{"front_left", "front_right", "rear_left", "rear_right"};

Simulation car(const std::string& manoeuvre, std::map<std::string, std::string> set = {}) {
  return test::simulation_of(test::example("iltis/" + manoeuvre + ".yaml", set),
                             spec::Simulation::Formulation::relative);
}
std::map<std::string, std::string> all_of(const std::string& kind) {
  return {{"arms", kind}, {"links", kind}, {"rods", kind}};
}

/// A lane between cones: from and to along x, its right and its left edge, m.
struct Lane {
  double begin, end, right, left;
};
/// ISO 3888-1, from the first lane's beginning; that one's middle is y = 0.
std::array<Lane, 3> lanes() {
  const double first = 1.1 * width + 0.25, right = -0.5 * first;
  return {Lane{0, 15, right, -right}, Lane{45, 70, right + 3.5, right + 3.5 + 1.2 * width + 0.25},
          Lane{95, 125, right, right + 1.3 * width + 0.25}};
}

/// How far the car's corners stay away from the cones at least, m; below 0: it ran over one.
double clearance(Simulation& s) {
  double least = 1;
  for (int k = 1; k <= 480; ++k) {
    run_to(s, 0.02 * k);
    const double yaw = channel(s, "yaw");
    for (const double ahead : {front_end, rear_end})
      for (const double left : {0.5 * width, -0.5 * width}) {
        const double x = channel(s, "x") - 40 + ahead * std::cos(yaw) - left * std::sin(yaw);
        const double y = channel(s, "y") + ahead * std::sin(yaw) + left * std::cos(yaw);
        for (const Lane& lane : lanes())
          if (x >= lane.begin && x <= lane.end) least = std::min({least, y - lane.right, lane.left - y});
      }
  }
  return least;
}

TEST(IltisManoeuvres, ChangesLanesBetweenTheCones) {
  for (const char* kind : {"rigid", "flexible"}) {
    Simulation s = car("double-lane-change", all_of(kind));
    EXPECT_GT(clearance(s), 0.04) << kind;
    EXPECT_GT(channel(s, "x"), 40 + 125 - rear_end) << kind;  // it is through
    EXPECT_NEAR(channel(s, "speed"), 80 / 3.6, 0.1) << kind;
  }
}

/// It knows who does not make it.
TEST(IltisManoeuvres, ConesStandInTheWayOfWhoIsTooFast) {
  Simulation s = car("double-lane-change", {{"speed", "100/3.6"}});
  EXPECT_LT(clearance(s), 0);
}

/// How far outside of bend.yaml's circle the car is, m.
double outside(Simulation& s, double radius, double entry) {
  const double x = entry / 2 - std::pow(entry, 3) / 240 / std::pow(radius, 2);
  const double y = radius + entry * entry / 24 / radius - std::pow(entry, 4) / 2688 / std::pow(radius, 3);
  return std::hypot(channel(s, "x") - x, channel(s, "y") - y) - radius;
}

TEST(IltisManoeuvres, KeepsToTheCircleUpToSixTenthsOfGravity) {
  Simulation s = car("constant-radius");
  for (int k = 8; k <= 51; ++k) {
    run_to(s, k);
    EXPECT_NEAR(outside(s, 40, 20), 0, 0.13) << k;
  }
  EXPECT_NEAR(channel(s, "yaw_rate") * 15.5, 6, 0.3);
}

/// The driver who brakes in the bend stays on it; who holds the wheel turns further in, but does not spin.
TEST(IltisManoeuvres, BrakesInABend) {
  for (const bool held : {false, true}) {
    Simulation s = car("brake-in-bend", {{"hands", held ? "held" : "driver"}});
    run_to(s, 7.9);
    const double before = channel(s, "yaw_rate");
    EXPECT_NEAR(before, 20.0 / 100, 0.004);
    double most = 0, off = 0;
    for (int k = 0; k < 60; ++k) {
      run_to(s, 8 + 0.1 * k);
      most = std::max(most, channel(s, "yaw_rate"));
      off = std::max(off, std::abs(outside(s, 100, 40)));
    }
    EXPECT_GT(most, (held ? 1.6 : 1.3) * before);
    EXPECT_LT(most, (held ? 2.1 : 1.6) * before);
    EXPECT_LT(off, held ? 35 : 0.7);
  }
}

/// The driver brakes harder, comes to a stop in the bend, and stays there.
TEST(IltisManoeuvres, StopsInABend) {
  Simulation s = car("brake-in-bend", {{"hands", "driver"}, {"foot", "0.4"}});
  run_to(s, 14);
  const double x = channel(s, "x"), y = channel(s, "y");
  EXPECT_NEAR(channel(s, "speed"), 0, 1e-3);
  run_to(s, 15);
  EXPECT_NEAR(channel(s, "x"), x, 1e-4);
  EXPECT_NEAR(channel(s, "y"), y, 1e-4);
}

/// Slope and offset of the straight line through points.
struct Line {
  double slope, offset;
};
Line line(const std::vector<double>& x, const std::vector<double>& y) {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  const double n = static_cast<double>(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) sx += x[k], sy += y[k], sxx += x[k] * x[k], sxy += x[k] * y[k];
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return {slope, (sy - slope * sx) / n};
}

/// The slip angle at which both wheels of an axle, of these loads, make this force together.
double slip_angle(double force, double left, double right) {
  double low = 0, high = 0.15;
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (low + high);
    double sum = 0;
    for (const double load : {left, right})
      sum += forces::brush(forces::BrushInput<double>{.Fz = load,
                                                      .sigma_x = 0,
                                                      .sigma_y = std::tan(middle),
                                                      .Cx = 8e4 * load / 3700,
                                                      .Cy = 6e4 * load / 3700,
                                                      .mu = 0.9,
                                                      .a = 0.08 * std::sqrt(load / 3700)})
                 .Fy;
    (sum < force ? low : high) = middle;
  }
  return low;
}

/// The understeer gradient up to 0.25 g: what the bicycle's tyres make of their shares of the lateral force,
/// and by what the suspension turns the wheels beside what the rack says.
TEST(IltisManoeuvres, UndersteersAsItsBicycleAndItsSuspensionSay) {
  const double mass = 1522.91, radius = 40;
  Simulation s = car("constant-radius");
  const auto of = [&](const std::string& wheel, const char* what) {
    return channel(s, fmt::format("tyre.{}.tyre.{}", wheel, what));
  };
  const auto loads = [&](int axle) {
    return of(wheels[2 * axle], "vertical") + of(wheels[2 * axle + 1], "vertical");
  };
  // By what an axle's wheels are turned: each counts by its load, as its cornering stiffness does.
  const auto steer = [&](int axle) {
    double sum = 0;
    for (const std::string& w : {wheels[2 * axle], wheels[2 * axle + 1]})
      sum +=
          of(w, "vertical") * std::remainder(channel(s, w + ".yaw") - channel(s, "yaw"), 6.283185307179586);
    return sum / loads(axle);
  };
  run_to(s, 7.9);  // at constant speed
  const double share = loads(0) / (loads(0) + loads(1));

  std::vector<double> across, rack, tyres, front, rear;
  for (int k = 24; k <= 56; ++k) {
    run_to(s, 0.5 * k);
    const double ay = std::pow(channel(s, "yaw_rate"), 2) * (radius + outside(s, radius, 20));
    // Of the moments about the vertical, the forces across bear what trails and rolling resistance make.
    double moment = half_track * (of("front_right", "longitudinal") - of("front_left", "longitudinal") +
                                  of("rear_right", "longitudinal") - of("rear_left", "longitudinal"));
    for (const std::string& w : wheels) moment += of(w, "aligning");
    const double shifted = -moment / base;
    across.push_back(ay);
    rack.push_back(channel(s, "rack"));
    front.push_back(steer(0));
    rear.push_back(steer(1));
    tyres.push_back(
        slip_angle(mass * ay * share + shifted, of("front_left", "vertical"), of("front_right", "vertical")) -
        slip_angle(mass * ay * (1 - share) - shifted, of("rear_left", "vertical"),
                   of("rear_right", "vertical")));
  }
  EXPECT_LT(across.front(), 1);
  EXPECT_NEAR(across.back(), 2.5, 0.2);
  // At the steering that the circle takes without any lateral acceleration the ratio of rack and wheels is
  // found.
  const Line of_rack = line(across, rack);
  const double ratio = base / radius / of_rack.offset;
  const double measured = ratio * of_rack.slope;
  // What the rack steers and the front wheels do not: roll and compliance turn them back.
  const double lost = measured - line(across, front).slope;
  const double predicted = line(across, tyres).slope + lost + line(across, rear).slope;
  EXPECT_NEAR(measured, predicted, 0.05 * measured);
  EXPECT_NEAR(measured, 0.0030, 0.0002);
}

/// One gradient for all ways to turn: the yaw rate after a step of the steering.
TEST(IltisManoeuvres, TurnsAfterAStepAsItUndersteers) {
  Simulation s = car("step-steer", {{"turn", "0.04"}});
  run_to(s, 6);
  const double v = 80 / 3.6, ratio = base / 40 / 0.00676;
  const double expected = v * ratio * -channel(s, "rack") / (base + 0.0030 * v * v);
  EXPECT_NEAR(channel(s, "yaw_rate"), expected, 0.05 * expected);
  EXPECT_NEAR(expected * v, 1.7, 0.3);
}

/// What the engine put in is there, or was rubbed away.
TEST(IltisManoeuvres, KeepTheBalanceOfEnergy) {
  for (const char* manoeuvre : {"step-steer", "double-lane-change", "brake-in-bend", "constant-radius"}) {
    Simulation s = car(manoeuvre);
    run_to(s, manoeuvre == std::string("step-steer") ? 6 : 10);
    const EnergyBalance e = s.energy();
    EXPECT_GT(e.dissipated, 3e3) << manoeuvre;
    EXPECT_LT(std::abs(e.numerical), 5e-5 * e.dissipated) << manoeuvre;
  }
}

/// With locked wheels it goes straight on however it steers; on anti-lock brakes, which keep the slips near
/// their target, it goes around what lies there.
TEST(IltisManoeuvres, SteersOnAntiLockBrakes) {
  std::map<std::string, std::string> set = all_of("rigid");
  Simulation locked = car("anti-lock", set);
  set["anti_lock"] = "true";
  Simulation held = car("anti-lock", set);
  std::array<double, 4> mean{};
  const int samples = 200;
  for (int k = 0; k < samples; ++k)
    for (Simulation* const s : {&locked, &held}) {
      run_to(*s, 2 + 0.01 * k);
      for (std::size_t w = 0; w < wheels.size(); ++w) {
        const double slip = channel(*s, "slip." + wheels[w]);
        EXPECT_LT(slip, s == &locked ? -0.97 : 0.1) << wheels[w];
        EXPECT_GT(slip, s == &locked ? -1.03 : -0.5) << wheels[w];
        if (s == &held) mean[w] += slip / samples;
      }
    }
  for (const double slip : mean) EXPECT_NEAR(slip, -0.16, 0.08);
  EXPECT_GT(channel(held, "y"), 2.5);
  run_to(locked, 9);
  run_to(held, 9);
  for (Simulation* const s : {&locked, &held}) EXPECT_NEAR(channel(*s, "speed"), 0, 0.01);
  EXPECT_NEAR(channel(locked, "y"), 0, 0.05);
}

/// On 15 % with the brakes on, from its equilibrium on: nothing moves.
TEST(IltisManoeuvres, StandsOnASlope) {
  Simulation s = car("slope");
  const double x = channel(s, "x"), y = channel(s, "y"), z = channel(s, "z");
  for (int k = 1; k <= 20; ++k) {
    run_to(s, 0.5 * k);
    EXPECT_NEAR(channel(s, "x"), x, 1e-6);
    EXPECT_NEAR(channel(s, "y"), y, 1e-6);
    EXPECT_NEAR(channel(s, "z"), z, 1e-6);
  }
  double along = 0;
  for (const std::string& w : wheels) along += channel(s, fmt::format("tyre.{}.tyre.longitudinal", w));
  EXPECT_NEAR(along, 1522.91 * 9.81 * std::sin(std::atan(0.15)), 5);
}

}  // namespace
}  // namespace mimbre::examples_test::iltis_manoeuvres_test
