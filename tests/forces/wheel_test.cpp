#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "forces/carcass.h"
#include "forces/measure.h"
#include "forces/table.h"
#include "support/random_mechanism.h"
#include "tyre_files/tyre_data.h"

/// What a wheel measures on roads, the roads as it feels them, and the law of a footprint behind a carcass.
namespace mimbre::test::wheel_test {
namespace {

using forces::carcass::FootprintForce;
using forces::carcass::Patch;

RoadData slope(double along) {
  RoadData road;
  road.height =
      Function::table({-100, 100}, {-100 * along, 100 * along}, Function::Interpolation::linear).data();
  return road;
}
RoadData bumpy_grid(Random& random) {
  RoadData road;
  road.over = spec::Road::Over::grid;
  road.origin = {-3, -2};
  road.spacing = {0.5, 0.4};
  road.columns = 13;
  road.rows = 11;
  for (int k = 0; k < road.columns * road.rows; ++k) road.heights.push_back(random.number(-0.05, 0.05));
  return road;
}

ElementData wheel_element(double radius) {
  ElementData e;
  e.measure = Measure::wheel;
  e.law = find_law("brush_tyre");
  e.count = 6;
  e.road = 0;
  e.radius = radius;
  e.rolling = 1. / 3;
  e.footprint = 0.08;
  e.direction = Vec3d::UnitY();
  e.state_count = law_info(e.law).states;
  return e;
}

struct Wheel {
  Compiled model;
  ElementData element;
  Motion<double> b;
  std::vector<double> storage, before;

  Wheel(const RoadData& road, double radius) : element(wheel_element(radius)) {
    model.roads.push_back(road);
    storage.assign(static_cast<std::size_t>(element_storage(element)), std::nan(""));
    before.assign(static_cast<std::size_t>(element.state_count), 0.0);
    b.acceleration = b.alpha = Vec3d::Zero();
  }
  ElementState<double> at(double t) {
    Motion<double> moved = b;
    moved.position += t * b.velocity;
    moved.rotation = rotation_exp<double>(Vec3d(t * b.omega)) * b.rotation;
    ElementState<double> s = element_state(element, storage.data());
    const double none = 0;
    measure<double>(model, element, nullptr, moved, Vec3d(Vec3d::Zero()), &none, before.data(), s);
    wheel::set_stood<double>(element, 0.2, s);
    return s;
  }
};

TEST(Roads, GridsKeepPlanesAndTheirDerivativesAreThoseOfTheHeights) {
  Random random(3);
  RoadData plane = bumpy_grid(random);
  for (int j = 0; j < plane.rows; ++j)
    for (int i = 0; i < plane.columns; ++i)
      plane.heights[static_cast<std::size_t>(j * plane.columns + i)] =
          0.2 + 0.3 * (plane.origin[0] + plane.spacing[0] * i) -
          0.1 * (plane.origin[1] + plane.spacing[1] * j);
  const RoadData bumps = bumpy_grid(random);
  const double h = 1e-6;
  for (int k = 0; k < 500; ++k) {
    const double x = random.number(-2.4, 2.4), y = random.number(-1.7, 1.5);
    const roads::Height on = roads::grid_height(plane, x, y);
    EXPECT_NEAR(on.z, 0.2 + 0.3 * x - 0.1 * y, 1e-13);
    EXPECT_NEAR(on.x, 0.3, 1e-12);
    EXPECT_NEAR(on.y, -0.1, 1e-12);
    const double u = random.number(-5, 5), v = random.number(-4, 4);  // beyond the border too
    const auto bump = [&](double dx, double dy) { return roads::grid_height(bumps, u + dx, v + dy); };
    const roads::Height here = bump(0, 0);
    EXPECT_NEAR(here.x, (bump(h, 0).z - bump(-h, 0).z) / (2 * h), 1e-8);
    EXPECT_NEAR(here.y, (bump(0, h).z - bump(0, -h).z) / (2 * h), 1e-8);
    EXPECT_NEAR(here.xx, (bump(h, 0).x - bump(-h, 0).x) / (2 * h), 1e-5);
    EXPECT_NEAR(here.xy, (bump(0, h).x - bump(0, -h).x) / (2 * h), 1e-5);
    EXPECT_NEAR(here.yy, (bump(0, h).y - bump(0, -h).y) / (2 * h), 1e-5);
  }
  // Where it is not a number, and far away.
  EXPECT_TRUE(std::isfinite(roads::grid_height(bumps, std::nan(""), 1e300).z));
}

/// The mean of the bilinear surface over one cell, by summing it up.
TEST(Roads, AGridIsTheMeanOfItsBilinearSurfaceOverACell) {
  Random random(4);
  const RoadData road = bumpy_grid(random);
  const auto bilinear = [&](double x, double y) {
    const double u = std::clamp((x - road.origin[0]) / road.spacing[0], 0.0, road.columns - 1.0),
                 v = std::clamp((y - road.origin[1]) / road.spacing[1], 0.0, road.rows - 1.0);
    const int i = std::min(static_cast<int>(u), road.columns - 2),
              j = std::min(static_cast<int>(v), road.rows - 2);
    const auto z = [&](int a, int b) {
      return road.heights[static_cast<std::size_t>((j + b) * road.columns + i + a)];
    };
    const double s = u - i, t = v - j;
    return (1 - t) * ((1 - s) * z(0, 0) + s * z(1, 0)) + t * ((1 - s) * z(0, 1) + s * z(1, 1));
  };
  constexpr int parts = 200;
  for (int k = 0; k < 20; ++k) {
    const double x = random.number(-2.5, 2.5), y = random.number(-1.7, 1.7);
    double sum = 0;
    for (int i = 0; i < parts; ++i)
      for (int j = 0; j < parts; ++j)
        sum += bilinear(x + road.spacing[0] * ((i + 0.5) / parts - 0.5),
                        y + road.spacing[1] * ((j + 0.5) / parts - 0.5));
    EXPECT_NEAR(roads::grid_height(road, x, y).z, sum / (parts * parts), 1e-6);
  }
}

/// Over a step in the road, the mean along the footprint.
TEST(Roads, AProfileIsFeltAlongTheFootprint) {
  RoadData road;
  road.height = Function::table({0, 1, 1, 2}, {0, 0, 0.1, 0.1}, Function::Interpolation::linear).data();
  for (const double x : {0.5, 0.93, 0.97, 1.0, 1.04, 1.5}) {
    const roads::Height h = roads::profile_height(road.height, 0.08, x);
    const double share = std::clamp((x + 0.08 - 1) / 0.16, 0.0, 1.0);
    EXPECT_NEAR(h.z, 0.1 * share, 1e-14) << x;
    EXPECT_NEAR(h.x, share > 0 && share < 1 ? 0.1 / 0.16 : 0, 1e-13) << x;
  }
}

TEST(Roads, FrictionIsThatOfTheLastPatchThere) {
  RoadData road;
  road.friction = 0.9;
  road.patches.push_back({{0, -1}, {10, 1}, 0.3});
  road.patches.push_back({{8, -1e300}, {1e300, 1e300}, 0.5});
  EXPECT_EQ(roads::friction(road, -1, 0), 0.9);
  EXPECT_EQ(roads::friction(road, 5, 0), 0.3);
  EXPECT_EQ(roads::friction(road, 5, 2), 0.9);
  EXPECT_EQ(roads::friction(road, 9, 0), 0.5);
}

/// On a plane the rate of the gap is its derivative, for wheels that lean and steer, and that lie nearly
/// flat.
TEST(WheelMeasure, TheRateOfTheGapIsItsDerivative) {
  Random random(5);
  for (int round = 0; round < 400; ++round) {
    const double rise = random.number(-0.4, 0.4);
    Wheel w(slope(rise), 0.35);
    w.b.position = random.vector(2);
    w.b.rotation = random.rotation();
    if (round % 2 == 1) {
      const double lean = random.number(-0.15, 0.15);
      w.b.rotation = rotation_exp<double>(Vec3d(0, -std::atan(rise), 0)) *
                     rotation_exp<double>(Vec3d(0.5 * std::numbers::pi + lean, 0, 0)) *
                     rotation_exp<double>(Vec3d(0, random.number(-3, 3), 0));
    }
    w.b.velocity = random.vector(10);
    w.b.omega = random.vector(10);
    const double h = 1e-6, up = w.at(h).x[0], down = w.at(-h).x[0];
    const ElementState<double> s = w.at(0);
    EXPECT_NEAR(s.v[0], (up - down) / (2 * h), 1e-5);
    for (int k = 0; k < 6; ++k)
      EXPECT_NEAR(s.v[k], s.linear_of(k).dot(w.b.velocity) + s.angular_of(k).dot(w.b.omega), 1e-12);
  }
}

/// On a bumpy ground the gap changes as fast as the tread comes down, but for what the bending of the ground
/// does to a tyre that is pressed in.
TEST(WheelMeasure, OnBumpsTheRateOfTheGapIsNearlyItsDerivative) {
  Random random(6);
  const RoadData road = bumpy_grid(random);
  for (int round = 0; round < 200; ++round) {
    Wheel w(road, 0.35);
    w.b.position = {random.number(-2, 2), random.number(-1, 1), 0.35 - random.number(0, 0.02)};
    w.b.rotation = rotation_exp<double>(Vec3d(0, 0, random.number(-3, 3)));
    w.b.velocity = {random.number(-1, 1), random.number(-1, 1), 0};
    w.b.omega = {0, random.number(-3, 3), 0};
    const double h = 1e-6, up = w.at(h).x[0], down = w.at(-h).x[0];
    const ElementState<double> s = w.at(0);
    EXPECT_NEAR(s.v[0], (up - down) / (2 * h), 0.04 * w.b.velocity.norm());
  }
}

/// A slope is level ground that is tilted: everything along with it measures the same, up to the round-off of
/// heights of 40 m over the length of a footprint.
TEST(WheelMeasure, ATiltedWorldIsTheSame) {
  Random random(7);
  for (int round = 0; round < 100; ++round) {
    const double angle = random.number(-0.4, 0.4);
    const Mat3d tilt = rotation_exp<double>(Vec3d(0, -angle, 0));
    Wheel level(slope(0), 0.35), tilted(slope(std::tan(angle)), 0.35);
    level.b.position = {random.number(-1, 1), random.number(-1, 1), random.number(0.25, 0.4)};
    level.b.rotation =
        rotation_exp<double>(Vec3d(random.number(-0.5, 0.5), random.number(-3, 3), random.number(-3, 3)));
    level.b.velocity = random.vector(10);
    level.b.omega = random.vector(20);
    tilted.b.position = tilt * level.b.position;
    tilted.b.rotation = tilt * level.b.rotation;
    tilted.b.velocity = tilt * level.b.velocity;
    tilted.b.omega = tilt * level.b.omega;
    const ElementState<double> a = level.at(0), b = tilted.at(0);
    for (int k = 0; k < 6; ++k) {
      EXPECT_NEAR(a.x[k], b.x[k], 1e-10) << k;
      EXPECT_NEAR(a.v[k], b.v[k], 1e-10) << k;
      EXPECT_LT((tilt * a.linear_of(k) - b.linear_of(k)).norm(), 1e-10);
      EXPECT_LT((tilt * a.angular_of(k) - b.angular_of(k)).norm(), 1e-10);
    }
    EXPECT_NEAR(a.surroundings[wheel::camber], b.surroundings[wheel::camber], 1e-10);
    EXPECT_NEAR(a.surroundings[wheel::forward], b.surroundings[wheel::forward], 1e-10);
  }
}

TEST(WheelMeasure, SignsAreThoseOfISO8855) {
  Wheel w(slope(0), 0.35);
  w.b.position = {0, 0, 0.32};
  w.b.rotation = rotation_exp<double>(Vec3d(0.1, 0, 0));  // the top to the right
  w.b.velocity = {10, 1, 0};
  w.b.omega = w.b.rotation * Vec3d(0, 20, 0);
  const ElementState<double> s = w.at(0);
  EXPECT_NEAR(s.surroundings[wheel::camber], 0.1, 1e-12);
  EXPECT_NEAR(s.surroundings[wheel::forward], 10, 1e-12);
  EXPECT_NEAR(s.surroundings[wheel::spin], 20, 1e-12);
  EXPECT_NEAR(s.x[wheel::gap], 0.32 - 0.35 * std::cos(0.1), 1e-12);
  EXPECT_NEAR(s.v[wheel::forth], 10 - 20 * (0.35 + s.x[wheel::gap] / 3), 1e-12);
  EXPECT_LT((s.linear_of(wheel::across) - Vec3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((s.angular_of(wheel::aligning) - Vec3d::UnitZ()).norm(), 1e-12);
}

/// A wheel that lies on the ground: nothing but numbers, and no grip.
/// How far the tread of a wheel that stood has gone is what its slip rates are of; rolling is no slip,
/// however far it goes, and one that did not stand is held nowhere. What leans and turns about the normal
/// takes its footprint along at the loaded radius, where the rate has that of rolling.
TEST(WheelMeasure, WhatItHasGoneHasTheRatesOfItsSlip) {
  Random random(12);
  for (int round = 0; round < 50; ++round) {
    const double along = random.number(-0.3, 0.3), x = random.number(-1, 1);
    Wheel w(slope(along), 0.35);
    w.b.position = {x, random.number(-1, 1), along * x + 0.34};
    w.b.rotation =
        rotation_exp<double>(Vec3d(random.number(-0.2, 0.2), random.number(-3, 3), random.number(-0.5, 0.5)));
    w.b.velocity = w.b.omega = Vec3d::Zero();
    const ElementState<double> start = w.at(0);
    EXPECT_GT(start.states[wheel::stood], 0.2);
    std::copy_n(start.states, w.element.state_count, w.before.begin());
    w.b.velocity = {random.number(-1, 1), random.number(-1, 1), random.number(-1, 1)};
    w.b.omega = {random.number(-1, 1), random.number(-1, 1), random.number(-1, 1)};
    const double h = 1e-5;
    const auto after = [&](double t) { return wheel::gone(w.element, w.before.data(), w.at(t)); };
    const auto up = after(h), down = after(-h);
    const ElementState<double> s = w.at(0);
    const Vec3d forwards = s.linear_of(wheel::forth), axis = s.angular_of(wheel::rolling),
                n = s.angular_of(wheel::aligning);
    const double rolls = wheel::rolling_radius<double>(w.element, s.x[wheel::gap]),
                 loaded = wheel::loaded_radius<double>(w.element, s.x[wheel::gap]);
    // Of the direction forwards, about the normal.
    const double leans = axis.dot(n), heading = (n - leans * axis).dot(w.b.omega) / (1 - leans * leans);
    EXPECT_NEAR((up[0] - down[0]) / (2 * h), s.v[wheel::forth] + (rolls - loaded) * leans * heading, 1e-8);
    EXPECT_NEAR((up[1] - down[1]) / (2 * h), s.v[wheel::across], 1e-8);
    EXPECT_EQ(s.states[wheel::stood], 0);
    w.b.velocity = rolls * forwards;
    w.b.omega = axis;
    for (const double t : {-2.5, 0.3, 2.5})
      for (const double way : after(t)) EXPECT_NEAR(way, 0, 1e-10) << t;
    std::copy_n(s.states, w.element.state_count, w.before.begin());
    for (const double way : after(1)) EXPECT_EQ(way, 0);
  }
}

TEST(WheelMeasure, AWheelThatLiesFlatHasNoGrip) {
  for (const double angle : {0.5 * std::numbers::pi, -0.5 * std::numbers::pi, 1.5707}) {
    Wheel w(slope(0), 0.35);
    w.b.position = {0, 0, -0.01};
    w.b.rotation = rotation_exp<double>(Vec3d(angle, 0, 0));
    w.b.velocity = {1, 2, 3};
    w.b.omega = {4, 5, 6};
    const ElementState<double> s = w.at(0);
    for (int k = 0; k < 6; ++k) EXPECT_TRUE(std::isfinite(s.x[k]) && std::isfinite(s.v[k])) << k;
    EXPECT_NEAR(s.surroundings[wheel::friction], 0, 2e-3);
    // Pushed at its middle, where it does not turn it over.
    EXPECT_LT(s.angular_of(wheel::gap).norm(), 0.35 * 1.5 * 1e-4 / wheel::flat + 1e-12);
  }
}

/// The push moves from side to side as it tilts, by steps as small as those of the tilt.
TEST(WheelMeasure, AWheelThatLiesFlatIsPushedSmoothly) {
  Wheel w(slope(0), 0.35);
  double before = 0;
  for (int k = -200; k <= 200; ++k) {
    w.b.rotation = rotation_exp<double>(Vec3d(0.5 * std::numbers::pi + 1e-3 * k, 0, 0));
    const double lever = w.at(0).angular_of(wheel::gap).x();
    if (k > -200) {
      EXPECT_NEAR(lever, before, 1.01 * 1.5 * 0.35 * 1e-3 / wheel::flat) << k;
    }
    if (std::abs(k) > 101) {
      EXPECT_NEAR(std::abs(lever), 0.35 * std::cos(1e-3 * k), 1e-12) << k;
    }
    before = lever;
  }
}

/// Slips until the carcass no longer changes.
FootprintForce<double> steady(const double slip[2], double rolled, const double stiffness[2], double limit,
                              const double spring[2], double step = 1e-3) {
  double bend[2] = {0, 0};
  FootprintForce<double> shear{};
  for (int k = 0; k < 200000; ++k) {
    Patch<double> patch;
    double change = 0;
    for (int i = 0; i < 2; ++i) {
      patch.pull[i] = spring[i] * (bend[i] + step * slip[i]);
      patch.resistance[i] = spring[i] * step;
      patch.stiffness[i] = stiffness[i];
    }
    patch.rolled = rolled;
    patch.limit = limit;
    shear = forces::carcass::footprint_force(patch);
    for (int i = 0; i < 2; ++i) {
      change += std::abs(shear.force[i] / spring[i] - bend[i]);
      bend[i] = shear.force[i] / spring[i];
    }
    if (change < 1e-13) break;
  }
  return shear;
}

/// On a steady roll it is the brush, whatever the carcass.
TEST(Carcass, OnASteadyRollItIsABrush) {
  const double stiffness[2] = {60e3, 60e3}, spring[2] = {2e5, 1e5}, limit = 3600;
  for (const double size : {0.001, 0.02, 0.1, 0.17, 0.181, 0.3, 1.0})
    for (const double angle : {0.0, 0.7, 1.5708}) {
      const double rolled = 10, slip[2] = {rolled * size * std::cos(angle), rolled * size * std::sin(angle)};
      const FootprintForce<double> shear = steady(slip, rolled, stiffness, limit, spring);
      const double p = std::min(1.0, 60e3 * size / (3 * limit)), force = limit * (1 - std::pow(1 - p, 3));
      EXPECT_NEAR(shear.force[0], force * std::cos(angle), 1e-6 * limit) << size << " " << angle;
      EXPECT_NEAR(shear.force[1], force * std::sin(angle), 1e-6 * limit) << size << " " << angle;
    }
}

/// A locked wheel is held by its carcass up to the limit, then slides straight against the force.
TEST(Carcass, ALockedWheelSlidesStraightAgainstTheForce) {
  const double stiffness[2] = {80e3, 30e3}, spring[2] = {2e5, 1e5}, limit = 3000;
  const double slip[2] = {0.3, 0.4};
  const FootprintForce<double> shear = steady(slip, 0, stiffness, limit, spring);
  EXPECT_NEAR(shear.force[0], 0.6 * limit, 1e-6 * limit);
  EXPECT_NEAR(shear.force[1], 0.8 * limit, 1e-6 * limit);
  Patch<double> patch{{500, -1000}, {200, 100}, {80e3, 30e3}, 0, limit};
  const FootprintForce<double> stuck = forces::carcass::footprint_force(patch);
  EXPECT_EQ(stuck.force[0], 500);
  EXPECT_EQ(stuck.force[1], -1000);
}

/// The equations that define it, for any numbers: the velocity at which the footprint slips is along the
/// force, by the brush's law until all slides; and what it takes is never less than nothing.
TEST(Carcass, KeepsItsLawForAnyNumbers) {
  Random random(8);
  int sliding = 0, sticking = 0;
  for (int round = 0; round < 20000; ++round) {
    Patch<double> patch;
    for (int k = 0; k < 2; ++k) {
      patch.pull[k] = random.number(-1, 1) * std::pow(10, random.number(-2, 5));
      patch.resistance[k] = std::pow(10, random.number(0, 4));
      patch.stiffness[k] = std::pow(10, random.number(2, 5));
    }
    patch.rolled = round % 5 == 0 ? 0 : std::pow(10, random.number(-6, 2));
    patch.limit = std::pow(10, random.number(0, 4));
    const FootprintForce<double> shear = forces::carcass::footprint_force(patch);
    const double size = std::hypot(shear.force[0], shear.force[1]), L = patch.limit;
    EXPECT_LE(size, L * (1 + 1e-9));
    double slip[2], power = 0;
    for (int k = 0; k < 2; ++k) {
      slip[k] = (patch.pull[k] - shear.force[k]) / patch.resistance[k];
      power += slip[k] * shear.force[k];
    }
    EXPECT_GE(power, -1e-9 * L);
    if (shear.used < 1) {
      ++sticking;
      const double p = shear.used, q = 1 - p + p * p / 3;
      EXPECT_NEAR(size, L * (1 - std::pow(1 - p, 3)), 1e-6 * L) << round;
      for (int k = 0; k < 2; ++k)
        EXPECT_NEAR(shear.force[k] * patch.rolled, q * patch.stiffness[k] * slip[k],
                    1e-5 * std::max(L * patch.rolled, std::abs(patch.stiffness[k] * slip[k])))
            << round;
    } else {
      ++sliding;
      EXPECT_NEAR(size, L, 1e-9 * L) << round;
      // Beyond where all of it began to slide, straight against the force.
      double beyond[2];
      for (int k = 0; k < 2; ++k)
        beyond[k] = slip[k] - 3 * shear.force[k] * patch.rolled / patch.stiffness[k];
      const double across = beyond[0] * shear.force[1] - beyond[1] * shear.force[0],
                   along = beyond[0] * shear.force[0] + beyond[1] * shear.force[1];
      EXPECT_GE(along, -1e-9 * std::hypot(slip[0], slip[1]) * L);
      EXPECT_LE(std::abs(across), 1e-4 * std::hypot(slip[0], slip[1]) * L) << round;
    }
  }
  EXPECT_GT(sliding, 1000);
  EXPECT_GT(sticking, 1000);
}

/// Where both directions are alike the tangent is that of the force; it is always symmetric, and between 0
/// and 1.
TEST(Carcass, TheTangentIsThatOfTheForce) {
  Random random(9);
  for (int round = 0; round < 500; ++round) {
    Patch<double> patch;
    const double give = random.number(50, 500), stiffness = random.number(2e4, 1e5);
    for (int k = 0; k < 2; ++k) {
      patch.pull[k] = random.number(-6e3, 6e3);
      patch.resistance[k] = give;
      patch.stiffness[k] = stiffness;
    }
    patch.rolled = random.number(0, 30);
    patch.limit = 3000;
    const FootprintForce<double> shear = forces::carcass::footprint_force(patch);
    for (int c = 0; c < 2; ++c) {
      Patch<double> up = patch, down = patch;
      up.pull[c] += 1e-3;
      down.pull[c] -= 1e-3;
      const FootprintForce<double> above = forces::carcass::footprint_force(up),
                                   below = forces::carcass::footprint_force(down);
      for (int r = 0; r < 2; ++r)
        EXPECT_NEAR(shear.tangent[r + c], (above.force[r] - below.force[r]) / 2e-3, 1e-5) << round;
    }
  }
}

/// The force across follows a step of the slip angle on a way of the relaxation length.
TEST(Carcass, FollowsOnTheRelaxationLength) {
  const double stiffness = 50e3, relaxation = 0.5, spring = stiffness / relaxation, speed = 10, angle = 0.002,
               step = 1e-4;
  double bend = 0, way = 0, last = 0;
  const double settled = 1 - std::exp(-1.0);
  const double most = 4000 * (1 - std::pow(1 - stiffness * angle / 12000, 3));
  while (way < 2) {
    Patch<double> patch{{0, spring * (bend + step * speed * angle)},
                        {spring * step, spring * step},
                        {stiffness, stiffness},
                        speed,
                        4000};
    const double force = forces::carcass::footprint_force(patch).force[1];
    bend = force / spring;
    way += speed * step;
    if (force >= settled * most && last < settled * most) {
      EXPECT_NEAR(way, relaxation, 0.02 * relaxation);
      return;
    }
    last = force;
  }
  FAIL() << "it does not get there";
}

/// A wheel on a tyre of that file, that has not been anywhere yet.
Wheel magic_wheel(const TyreProperties& tyre) {
  Wheel w(slope(0), tyre.unloaded_radius);
  w.element.law = find_law("magic_tyre");
  w.element.state_count = law_info(w.element.law).states;
  w.element.rolling = 0.3;
  w.model.numbers = {0, tyre.unloaded_radius};
  w.model.numbers.append(tyre.numbers.begin(), tyre.numbers.end());
  w.model.numbers.push_back(0.02);
  w.storage.assign(static_cast<std::size_t>(element_storage(w.element)), std::nan(""));
  w.before.assign(static_cast<std::size_t>(w.element.state_count), 0.0);
  return w;
}
/// The next step of h seconds, with the same velocities.
ElementState<double> magic_step(Wheel& w, double h) {
  const double none = 0;
  ElementState<double> s = w.at(0);
  forces::magic_tyre_law<double>({w.model, w.element, 0, &none, w.before.data(), h}, s);
  std::copy_n(s.states, w.element.state_count, w.before.begin());
  return s;
}

/// Dragged over the road at constant slips until nothing changes: the formula at these slips, from 0.5 m/s
/// on.
TEST(MagicTyre, OnASteadyRollItIsTheFormula) {
  for (const char* file : {"car_205_60R15_61.tir", "every_term_61.tir", "car_52.tir"}) {
    const TyreProperties tyre = tyre_of(file);
    for (const double forward : {20.0, 2.0, 0.75, -0.75, -2.0, -20.0})
      for (const auto& [kappa, alpha, gamma] : {std::array{0.0, 0.0, 0.0},
                                                {0.02, 0.0, 0.0},
                                                {-0.05, 0.03, 0.02},
                                                {0.0, -0.08, -0.05},
                                                {-0.3, 0.1, 0.0}}) {
        SCOPED_TRACE(fmt::format("{} {} m/s {} {} {}", file, forward, kappa, alpha, gamma));
        Wheel w = magic_wheel(tyre);
        const double radius = tyre.unloaded_radius, deep = 0.02, size = std::abs(forward);
        w.b.rotation = rotation_exp<double>(Vec3d(gamma, 0, 0));
        w.b.position = {0, 0, radius * std::cos(gamma) - deep};
        w.b.velocity = {forward, size * std::tan(alpha), 0};
        const double turns = (forward + size * kappa) / (radius - w.element.rolling * deep);
        w.b.omega = w.b.rotation * Vec3d(0, turns, 0);
        ElementState<double> s = w.at(0);
        for (int k = 0; k < 2000; ++k) s = magic_step(w, 0.02 / size);
        const double load = -s.force[0];
        const auto out = forces::magic_formula(
            tyre.numbers.data(),
            forces::MagicInput<double>{
                .Fz = load, .kappa = kappa, .alpha = alpha, .gamma = gamma, .Vx = forward});
        EXPECT_GT(load, 2000);
        EXPECT_NEAR(-s.force[wheel::forth], out.Fx, 1e-6 * load);
        EXPECT_NEAR(-s.force[wheel::across], out.Fy, 1e-6 * load);
        EXPECT_NEAR(-s.force[wheel::overturning], out.Mx, 1e-6 * load * radius);
        EXPECT_NEAR(-s.force[wheel::rolling], out.My, 1e-6 * load * radius);
        EXPECT_NEAR(-s.force[wheel::aligning], out.Mz, 1e-6 * load * radius);
      }
  }
}

/// A hub below the road, at any depth and speed: numbers, no more of them than the load allows, and a push
/// that is the one at the hub.
TEST(MagicTyre, AHubBelowTheRoadIsPushedOutByFiniteForces) {
  Random random(14);
  for (const char* file : {"car_205_60R15_61.tir", "every_term_61.tir", "car_52.tir"}) {
    const TyreProperties tyre = tyre_of(file);
    const double R = tyre.unloaded_radius;
    for (int round = 0; round < 300; ++round) {
      Wheel w = magic_wheel(tyre);
      const double deep = R * std::pow(10, random.number(-0.3, 4));
      w.b.position = {0, 0, R - deep};
      w.b.rotation = rotation_exp<double>(Vec3d(random.number(-0.4, 0.4), 0, random.number(-3, 3)));
      w.b.velocity = random.vector(std::pow(10, random.number(-3, 3)));
      w.b.omega = random.vector(std::pow(10, random.number(-3, 3)));
      for (int k = 0; k < 5; ++k) {
        const ElementState<double> s = magic_step(w, k == 0 ? 0 : 1e-3);
        const double load = -s.force[0];
        for (int i = 0; i < s.count; ++i) ASSERT_TRUE(std::isfinite(s.force[i])) << deep << " " << i;
        for (int i = 0; i < s.count * s.count; ++i)
          ASSERT_TRUE(std::isfinite(s.damping[i]) && std::isfinite(s.stiffness[i])) << deep << " " << i;
        for (int i = 0; i < w.element.state_count; ++i) ASSERT_TRUE(std::isfinite(s.states[i])) << i;
        EXPECT_LE(std::hypot(s.force[wheel::forth], s.force[wheel::across]), 5 * load);
      }
      w.b.velocity = w.b.omega = Vec3d::Zero();
      const double push = -magic_step(w, 0).force[0];
      if (deep > 1.2 * R) {
        w.b.position[2] -= R;
        EXPECT_EQ(-magic_step(w, 0).force[0], push);
      }
    }
  }
}

/// The vertical spring stores what it takes to press it in, past the rim and the hub.
TEST(MagicTyre, StoresWhatPressesItIn) {
  const TyreProperties tyre = tyre_of("car_205_60R15_61.tir");
  Wheel w = magic_wheel(tyre);
  const ElementData& e = w.element;
  w.b.rotation = Mat3d::Identity();
  w.b.velocity = w.b.omega = Vec3d::Zero();
  const double none = 0, h = 1e-6;
  const auto stored = [&](double deep, double& force) {
    w.b.position = {0, 0, tyre.unloaded_radius - deep};
    ElementState<double> s = w.at(0);
    const LawContext<double> context{w.model, e, 0, &none, w.before.data(), 0};
    forces::magic_tyre_law<double>(context, s);
    force = -s.force[0];
    ElementEnergy energy;
    forces::magic_tyre_energy(context, s, energy);
    return energy.stored;
  };
  for (const double deep : {-0.01, 0.005, 0.02, 0.06, 0.12, 0.2, 0.4}) {
    double force = 0, other = 0;
    stored(deep, force);
    EXPECT_NEAR(force, (stored(deep + h, other) - stored(deep - h, other)) / (2 * h), 1e-3 + 1e-6 * force)
        << deep;
  }
}

}  // namespace
}  // namespace mimbre::test::wheel_test
