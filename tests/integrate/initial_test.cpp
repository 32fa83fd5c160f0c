#include "integrate/initial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "math/once/decompositions.h"
#include "mimbre/simulation.h"
#include "support/models.h"
#include "support/probe.h"

namespace mimbre::test::initial_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string error_of(const std::string& text) {
  const auto model = model_of(text);
  try {
    Simulation simulation(model);
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

/// The four-bar's crank and rocker angles θ, ψ: squared distance of the pins less the coupler's, zero when
/// closed.
double gap(double crank, double rocker) {
  const double x = 0.6 + 0.5 * std::sin(rocker) - 0.2 * std::sin(crank),
               z = 0.5 * std::cos(rocker) - 0.2 * std::cos(crank);
  return x * x + z * z - 0.45;
}

/// ψ near zero for θ.
double rocker_angle(double crank) {
  double low = -0.5, high = 0.7;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (gap(crank, middle) < 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

struct Angles {
  double crank, crank_pin, rocker, crank_rate, rocker_rate;
};

Angles start(const std::string& text) {
  const auto model = model_of(text);
  const Simulation::Snapshot s = Simulation(model).save();
  Angles a{};
  for (const BodyData& b : model->compiled().bodies) {
    const std::string& joint = model->spec().joints[static_cast<std::size_t>(b.joint_spec)].name;
    if (joint == "crank") a.crank = s.q[b.q], a.crank_rate = s.v[b.v];
    if (joint == "rocker") a.rocker = s.q[b.q], a.rocker_rate = s.v[b.v];
    if (joint == "crank_pin") a.crank_pin = s.q[b.q];
  }
  return a;
}

void expect_closed(const Angles& a, double crank, double crank_rate) {
  EXPECT_NEAR(a.crank, crank, 1e-9);
  EXPECT_NEAR(a.rocker, rocker_angle(crank), 1e-9);
  const double h = 1e-5;
  EXPECT_NEAR(a.crank_rate, crank_rate, 1e-9);
  EXPECT_NEAR(a.rocker_rate, crank_rate * (rocker_angle(crank + h) - rocker_angle(crank - h)) / (2 * h),
              1e-7);
}

TEST(Initial, WhatIsNotGivenIsFound) {
  expect_closed(start(four_bar_text()), 0, 0);
  expect_closed(start(four_bar_text({{"crank", ", position: 0.4, velocity: 3"}})), 0.4, 3);
  expect_closed(start(four_bar_text({{"crank", ", velocity: 3"}})), 0, 3);
}

TEST(Initial, GivenAtTheOtherEndOfTheLoop) {
  const double rocker = rocker_angle(0.3), h = 1e-5,
               slope = (rocker_angle(0.3 + h) - rocker_angle(0.3 - h)) / (2 * h);
  const Angles a = start(four_bar_text(
      {{"rocker", ", position: " + std::to_string(rocker) + ", velocity: " + std::to_string(2 * slope)}}));
  EXPECT_NEAR(a.crank, 0.3, 1e-4);  // to_string keeps six digits
  EXPECT_NEAR(a.crank_rate, 2, 1e-3);
  EXPECT_NEAR(gap(a.crank, a.rocker), 0, 1e-9);
}

TEST(Initial, DrivesGivePositionAndVelocity) {
  expect_closed(start(four_bar_text({{"crank", R"(, drive: {position: "0.2 + 1.5*t"})"}})), 0.2, 1.5);
}

/// Rates that nothing asks for stay zero: the mechanism starts to move as if its bars were rigid.
TEST(Initial, FlexibleBodiesStartWithoutVibrating) {
  const auto model = example("double-four-bar/mechanism.yaml", {{"flexible_bars", "5"}});
  const Simulation::Snapshot s = Simulation(model).save();
  for (const BodyData& b : model->compiled().bodies) {
    EXPECT_LT(s.v.segment(b.v + b.joint_velocities, b.modes).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_NEAR(std::abs(s.v[b.v]),
                model->spec().joints[static_cast<std::size_t>(b.joint_spec)].name == "C4" ? 0 : 1, 1e-9);
  }
}

TEST(Initial, VelocitiesThatContradictEachOther) {
  EXPECT_THAT(error_of(four_bar_text({{"crank", ", velocity: 1"}, {"rocker", ", velocity: 0"}})),
              AllOf(HasSubstr("test.yaml:"), HasSubstr("'rocker_pin'"), HasSubstr("velocities")));
  EXPECT_THAT(error_of(four_bar_text({{"crank", ", drive: {position: t}"}, {"rocker", ", velocity: 0"}})),
              AllOf(HasSubstr("'rocker_pin'"), HasSubstr("velocities")));
}

TEST(Initial, PositionsThatContradictEachOther) {
  EXPECT_THAT(error_of(four_bar_text({{"crank", ", position: 0.4"}, {"rocker", ", position: 0.4"}})),
              AllOf(HasSubstr("test.yaml:"), HasSubstr("'rocker_pin'"), HasSubstr("cannot be closed")));
}

TEST(Initial, LoopsThatDoNotReach) {
  // The rocker lies towards the crank: the coupler is far too long.
  EXPECT_THAT(error_of(four_bar_text({{"rocker", ", position: -1.5"}})),
              AllOf(HasSubstr("test.yaml:"), HasSubstr("'rocker_pin'"), HasSubstr("cannot be closed")));
}

TEST(Initial, QuaternionJointsTakeRotationVectors) {
  const auto model = model_of(R"(
bodies:
  a: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
joints:
  ball: {type: spherical, between: [ground, a], at: [0, 0, 0], position: [0.3, -0.5, 0.9], velocity: [1, 2, 3]}
)");
  const Simulation::Snapshot s = Simulation(model).save();
  EXPECT_LT((rotation_matrix<double>(s.q) - rotation_exp<double>(Vec3d(0.3, -0.5, 0.9))).norm(), 1e-14);
  EXPECT_LT((s.v - Vec3d(1, 2, 3)).norm(), 1e-15);
}

TEST(Initial, PositionsCloseWithTheLeastChange) {
  int compared = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    RandomOptions options;
    options.loops = 1 + static_cast<int>(seed % 2);
    const RandomMechanism r = random_mechanism(seed, options);
    Probe p(r.compiled());
    Random random(seed);
    VectorXd q = p.moved(r.q, random_increment(p.m, random, 0.01));
    if (p.equations == 0 || p.phi(q).cwiseAbs().maxCoeff() < 1e-9) continue;
    ASSERT_LT(close_positions(p.system, 0, VectorXd::Ones(p.n), q), 1e-10) << seed;
    EXPECT_LT(p.phi(q).cwiseAbs().maxCoeff(), 1e-10);
    VectorXd v = random_increment(p.m, random, 1);
    const VectorXd wanted = v;
    ASSERT_LT(close_velocities(p.system, 0, q, VectorXd::Ones(p.n), v), 1e-9) << seed;
    EXPECT_LT(p.phi_dot(q, v).cwiseAbs().maxCoeff(), 1e-9);
    // The change has no part along motions that the constraints leave free.
    const MatrixXd J = p.jacobian(q);
    const MatrixXd kernel = null_space(J, 1e-12);
    EXPECT_LT((kernel.transpose() * (v - wanted)).norm(), 1e-6 * std::max(1.0, (v - wanted).norm())) << seed;
    ++compared;
  }
  EXPECT_GE(compared, 10);
}

}  // namespace
}  // namespace mimbre::test::initial_test
