#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "forces/cart.h"
#include "mimbre/diagnostics.h"
#include "mimbre/method_names.h"
#include "support/models.h"
#include "support/simulate.h"

/// TMeasy: a wheel that is drawn at a given slip against the curves of Rill, Road Vehicle Dynamics (2012),
/// and a car that brakes, stands and keeps its balance of energy.
namespace mimbre::test::tmeasy_tyre_test {
namespace {

/// Of one direction, as in the book: slope, peak and its slip, sliding and its slip; at the load.
struct Direction {
  double slope, peak, peak_slip, sliding, sliding_slip;

  double force(double s) const {
    if (s <= peak_slip) {
      const double sigma = s / peak_slip;
      return peak_slip * slope * sigma / (1 + sigma * (sigma + slope * peak_slip / peak - 2));
    }
    if (s >= sliding_slip) return sliding;
    const double sigma = (s - peak_slip) / (sliding_slip - peak_slip);
    return peak - (peak - sliding) * sigma * sigma * (3 - 2 * sigma);
  }
};

constexpr double load = 3000, growth = 1.7, stiffness = 2e5, radius = 0.32, half_length = 0.08;
constexpr Direction along{9e4, 3300, 0.11, 3000, 0.5}, across{7e4, 3100, 0.18, 2900, 0.6};

std::string tyre(double damping = 0) {
  return fmt::format(
      "model: tmeasy, stiffness: {}, damping: {}, radius: {}, longitudinal_stiffness: {}, longitudinal_peak: "
      "{}, "
      "longitudinal_peak_slip: {}, longitudinal_sliding: {}, longitudinal_sliding_slip: {}, "
      "cornering_stiffness: {}, lateral_peak: {}, lateral_peak_slip: {}, lateral_sliding: {}, "
      "lateral_sliding_slip: {}, longitudinal_peak_growth: {}, lateral_peak_growth: {}, "
      "longitudinal_relaxation: 0.3, lateral_relaxation: 0.5, half_length: {}, load: {}, rolling_resistance: "
      "0",
      stiffness, damping, radius, along.slope, along.peak, along.peak_slip, along.sliding, along.sliding_slip,
      across.slope, across.peak, across.peak_slip, across.sliding, across.sliding_slip, growth, growth,
      half_length, load);
}

/// A wheel on an axle that is drawn along at 10 m/s, pressed down to a load, steered and turned at given
/// rates.
struct Drawn {
  double fz = load;
  double kappa = 0;  ///< (ω r − v)/(ω r): the slip along, by the speed of rolling
  double angle = 0;  ///< of the wheel's plane against its way, rad, to the left
  double friction = 1;

  static constexpr double speed = 10;
  double deflection() const { return fz / stiffness; }
  double rolling_radius() const { return radius - deflection() / 3; }
  /// Of the wheel: that slips along by kappa of the speed at which it rolls.
  double spin() const { return speed * std::cos(angle) / (1 - kappa) / rolling_radius(); }
  /// By the speed of rolling.
  double slip_across() const { return speed * std::sin(angle) / std::abs(spin() * rolling_radius()); }

  std::string text() const {
    const double z = radius - deflection();
    return fmt::format(R"y(
gravity: [0, 0, -9.81]
bodies:
  slide: {{mass: 10, com: [0, 0, {0}], inertia: [1, 1, 1]}}
  steered: {{mass: 10, com: [0, 0, {0}], inertia: [1, 1, 1]}}
  wheel: {{mass: 10, com: [0, 0, {0}], inertia: [1, 1, 1]}}
joints:
  rail: {{type: prismatic, between: [ground, slide], at: [0, 0, {0}], axis: [1, 0, 0], drive: {{position: "10*t"}}}}
  turned: {{type: revolute, between: [slide, steered], at: [0, 0, {0}], axis: [0, 0, 1], drive: {{position: "{1}"}}}}
  axle: {{type: revolute, between: [steered, wheel], at: [0, 0, {0}], axis: [0, 1, 0], drive: {{speed: "{2}"}}}}
roads: {{track: {{over: distance, points: [[-100, 0], [1000, 0]], friction: {3}}}}}
tyres: {{t: {{on: wheel, at: [0, 0, {0}], road: track, {4}}}}}
simulation: {{step: 0.005, end: 3}}
)y",
                       z, angle, spin(), friction, tyre());
  }
};

struct Forces {
  double along, across, aligning;
};

Forces steady(const Drawn& drawn, Formulation formulation) {
  Simulation s = simulation_of(drawn.text(), formulation);
  run_to(s, 2);
  EXPECT_NEAR(channel(s, "tyre.t.vertical"), drawn.fz, 1e-6 * drawn.fz);
  return {channel(s, "tyre.t.longitudinal"), channel(s, "tyre.t.lateral"), channel(s, "tyre.t.aligning")};
}

const char* const speed_of_car = "  - {name: vx, velocity: car, component: x}\n";

class TmeasyTyre : public testing::TestWithParam<Formulation> {};

/// Of both signs, on the slope, at the peak, behind it and where all slides.
TEST_P(TmeasyTyre, FollowsTheCurveOfEachDirection) {
  for (const double kappa : {-0.8, -0.3, -0.11, -0.02, 0.01, 0.05, 0.11, 0.25, 0.4}) {
    const Forces f = steady({.kappa = kappa}, GetParam());
    EXPECT_NEAR(f.along, std::copysign(along.force(std::abs(kappa)), kappa), 1e-6 * along.peak) << kappa;
    EXPECT_NEAR(f.across, 0, 1e-6 * across.peak);
  }
  for (const double degrees : {-8.0, -3.0, 1.0, 6.0, 12.0, 20.0}) {
    const Drawn drawn{.angle = degrees * std::numbers::pi / 180};
    const Forces f = steady(drawn, GetParam());
    const double s = drawn.slip_across();
    // Steered to the left it is pushed to the left.
    EXPECT_NEAR(f.across, std::copysign(across.force(std::abs(s)), s), 1e-6 * across.peak) << degrees;
    EXPECT_NEAR(f.along, 0, 1e-6 * along.peak);
  }
}

/// Peaks grow by less than the load, slopes with it: parabolas through the load and twice the load. Friction
/// scales peaks, sliding and their slips, not the slopes.
TEST_P(TmeasyTyre, DependsOnLoadAndFriction) {
  for (const double ratio : {0.5, 1.0, 1.5, 2.0}) {
    const double by_growth = ratio * (2 - growth / 2 - (1 - growth / 2) * ratio);
    const Direction expected{ratio * along.slope, by_growth * along.peak, along.peak_slip,
                             ratio * along.sliding, along.sliding_slip};
    for (const double kappa : {0.03, 0.11, 0.3, 0.7})
      EXPECT_NEAR(steady({.fz = ratio * load, .kappa = kappa}, GetParam()).along, expected.force(kappa),
                  1e-5 * along.peak)
          << ratio << " " << kappa;
  }
  const double mu = 0.5;
  const Direction slippery{along.slope, mu * along.peak, mu * along.peak_slip, mu * along.sliding,
                           mu * along.sliding_slip};
  for (const double kappa : {0.02, 0.055, 0.15, 0.4})
    EXPECT_NEAR(steady({.kappa = kappa, .friction = mu}, GetParam()).along, slippery.force(kappa),
                1e-6 * along.peak);
}

/// Along and across at once: the force is against the slip in the plane of slips over their sizes, and
/// between the peaks of both directions where it is largest.
TEST_P(TmeasyTyre, CombinesBothDirections) {
  const double flat_x = along.peak / along.slope, flat_y = across.peak / across.slope;
  const double size_x = along.peak_slip / (along.peak_slip + across.peak_slip) + flat_x / (flat_x + flat_y),
               size_y = across.peak_slip / (along.peak_slip + across.peak_slip) + flat_y / (flat_x + flat_y);
  for (const double kappa : {-0.2, 0.05})
    for (const double angle : {-0.1, 0.04}) {
      const Drawn drawn{.kappa = kappa, .angle = angle};
      const Forces f = steady(drawn, GetParam());
      const double a = kappa / size_x, b = drawn.slip_across() / size_y, all = std::hypot(a, b);
      const auto both = [&](double x, double y) { return std::hypot(x * a / all, y * b / all); };
      const Direction direction{
          both(along.slope * size_x, across.slope * size_y), both(along.peak, across.peak),
          both(along.peak_slip / size_x, across.peak_slip / size_y), both(along.sliding, across.sliding),
          both(along.sliding_slip / size_x, across.sliding_slip / size_y)};
      EXPECT_NEAR(f.along, direction.force(all) * a / all, 1e-6 * along.peak);
      EXPECT_NEAR(f.across, direction.force(all) * b / all, 1e-6 * along.peak);
    }
}

/// The force across acts behind the middle of the footprint, by a sixth of its length at small slips; before
/// the middle between the slips where the trail is 0 and where it ends.
TEST_P(TmeasyTyre, ReturnsByItsTrail) {
  const Forces small = steady({.angle = 0.002}, GetParam());
  EXPECT_NEAR(-small.aligning / small.across, 2 * half_length / 6, 0.03 * half_length / 3);
  const double s = 0.3, zero = 0.2, end = 0.5, w = zero / end;
  const Drawn far{.angle = std::atan(s)};  // rolls at speed cos(angle)
  const Forces f = steady(far, GetParam());
  const double share = -(1 - w) * (s - zero) / zero * std::pow((end - s) / (end - zero), 2);
  EXPECT_NEAR(far.slip_across(), s, 1e-12);
  EXPECT_NEAR(-f.aligning / f.across, share * 2 * half_length / 6, 1e-5 * half_length);
  EXPECT_NEAR(steady({.angle = std::atan(0.6)}, GetParam()).aligning, 0, 1e-9);
}

/// From 15 m/s with all wheels locked: it slides by the sliding force, about the load at each wheel.
TEST_P(TmeasyTyre, LockedWheelsSlideAndStop) {
  Simulation s = simulation_of(
      cart_text({.tyre = tyre(500), .more = speed_of_car, .brake = 5000, .friction = 1, .speed = 15}),
      GetParam());
  run_to(s, 0.5);
  const double x0 = channel(s, "x"), v0 = channel(s, "vx");
  run_to(s, 1);
  const double x1 = channel(s, "x"), v1 = channel(s, "vx");
  EXPECT_GT(v1, 5);
  // Of sliding, which goes with the load, whatever way it is distributed.
  const double mu = along.sliding / load;
  EXPECT_NEAR((v0 * v0 - v1 * v1) / (2 * (x1 - x0)), mu * 9.81, 0.01 * 9.81);
  // It rocks on its tyres before it stands.
  run_to(s, 8);
  EXPECT_NEAR(channel(s, "vx"), 0, 1e-6);
}

/// With its brakes on a slope of 20 % it stands for good.
TEST_P(TmeasyTyre, StandsOnASlope) {
  std::string text = cart_text({.tyre = tyre(500), .slope = 0.2, .friction = 1});
  text += "initial: equilibrium\n";
  Simulation s = simulation_of(text, GetParam());
  const double start = channel(s, "x");
  run_to(s, 10);
  EXPECT_NEAR(channel(s, "x"), start, 1e-6);
}

TEST_P(TmeasyTyre, KeepsTheBalanceOfEnergy) {
  Simulation s = simulation_of(
      cart_text(
          {.tyre = tyre(500), .more = speed_of_car, .brake = 300, .friction = 1, .speed = 12, .arms = true}),
      GetParam(), 0.001);
  const double at_first = s.energy().kinetic;
  run_to(s, 2);
  EXPECT_LT(s.energy().kinetic, 0.8 * at_first);
  EXPECT_LT(std::abs(s.energy().numerical), 1e-3 * at_first);
}

INSTANTIATE_TEST_SUITE_P(BothFormulations, TmeasyTyre,
                         testing::Values(Formulation::relative, Formulation::natural), [](const auto& row) {
                           return name_of(row.param) == std::string("relative") ? "Relative" : "Natural";
                         });

TEST(TmeasyTyreFile, SaysWhatIsWrong) {
  const auto refused = [](const std::string& from, const std::string& to) {
    std::string text = cart_text({.tyre = tyre()});
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
      text.replace(at, from.size(), to);
    try {
      model_of(text);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refused("tmeasy", "tmeasy"), "accepted");
  EXPECT_THAT(refused("longitudinal_sliding_slip: 0.5", "longitudinal_sliding_slip: 0.1"),
              testing::HasSubstr("all must slide from a slip on that is above the peak's"));
  EXPECT_THAT(refused("lateral_peak: 3100, ", ""), testing::HasSubstr("'lateral_peak' is missing"));
  EXPECT_THAT(refused("half_length", "friction: 1, half_length"),
              testing::HasSubstr("belongs to 'model: brush'"));
}

}  // namespace
}  // namespace mimbre::test::tmeasy_tyre_test
