#include <cmath>
#include <numbers>

#include "examples/example.h"

/// examples/crank-train against the kinematics of the slider-crank and the balance of power.
namespace mimbre::examples_test::crank_train_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double radius = 0.045, length = 0.144, bore = 0.084, compression = 9.5, piston = 0.45;
constexpr double width = 0.012, height = 0.024, rod = 7850 * width * height * length;
constexpr double area = pi / 4 * bore * bore, speed = 100 * pi;

/// Of the wrist above the shaft, m, at the crank's angle from the top.
double wrist(double angle) {
  return radius * std::cos(angle) + std::sqrt(length * length - std::pow(radius * std::sin(angle), 2));
}

/// In the cylinder over the ambient one, Pa; a cycle begins with the intake.
double pressure(double angle) {
  const double stroke = std::remainder(angle - 2 * pi, 4 * pi);
  if (std::abs(stroke) >= pi) return 0;
  const double clearance = 2 * radius / (compression - 1);
  const double squeezed = (2 * radius + clearance) / (clearance + radius + length - wrist(angle));
  const double burnt = stroke < -0.25 ? 0 : 1 - std::exp(-6.9 * std::pow(std::min(stroke + 0.25, 1.0), 3));
  const double kept = stroke < 2.6 ? 1 : 0.5 + 0.5 * std::cos(pi * (stroke - 2.6) / (pi - 2.6));
  return 1e5 * kept * (std::pow(squeezed, 1.35) * (1 + 2.2 * burnt) - 1);
}

double slope(double (*of)(double), double angle) { return (of(angle + 1e-5) - of(angle - 1e-5)) / 2e-5; }

/// Kinetic energy at the constant speed, and potential energy, of piston and rod.
double kinetic(double angle) {
  const double tilt_rate =
      -radius * std::cos(angle) / std::sqrt(length * length - std::pow(radius * std::sin(angle), 2));
  const double along = slope(wrist, angle), x = 0.5 * radius * std::cos(angle);
  const double z = 0.5 * (-radius * std::sin(angle) + along);
  const double inertia = rod * (length * length + height * height) / 12;
  return 0.5 * speed * speed *
         (piston * along * along + rod * (x * x + z * z) + inertia * tilt_rate * tilt_rate);
}
double potential(double angle) {
  return 9.81 * (piston * wrist(angle) + rod * 0.5 * (radius * std::cos(angle) + wrist(angle)));
}

class CrankTrain : public ExampleTest {};

TEST_F(CrankTrain, TheDriveHoldsWhatGasAndInertiaAskFor) {
  const Table run = run_example("crank-train", {"--set", "rod=rigid"});
  double worst = 0, largest = 0;
  for (Eigen::Index row = 10; row < run["t"].size(); ++row) {
    const double angle = run["crank.angle"][row];
    EXPECT_NEAR(run["piston.z"][row], wrist(angle), 1e-9);
    const double torque =
        slope(kinetic, angle) + slope(potential, angle) + area * pressure(angle) * slope(wrist, angle);
    worst = std::max(worst, std::abs(run["main.torque"][row] - torque));
    largest = std::max(largest, std::abs(torque));
  }
  EXPECT_NEAR(largest, 392, 5);
  EXPECT_LT(worst, 1e-3 * largest);
}

/// Whatever the masses and the rod do in between: the mean torque is the area of the indicator diagram over
/// two turns.
TEST_F(CrankTrain, TheMeanTorqueIsThatOfTheIndicatorDiagram) {
  double work = 0;
  const int parts = 20000;
  for (int i = 0; i < parts; ++i) {
    const double angle = 4 * pi * (i + 0.5) / parts;
    work -= area * pressure(angle) * slope(wrist, angle) * 4 * pi / parts;
  }
  EXPECT_NEAR(work, 374, 1) << "examples/crank-train/README.md says so";
  const Table run = run_example("crank-train");
  const Eigen::ArrayXd cycle = run["main.torque"].tail(400);
  EXPECT_NEAR(-cycle.mean(), work / (4 * pi), 0.003 * work / (4 * pi));
}

/// m r ω² (cos θ + λ cos 2θ) of what goes up and down, m r ω² of what goes round.
TEST_F(CrankTrain, InertiaForcesHaveTheirOrders) {
  const Table run = run_example("crank-train", {"--set", "rod=rigid", "--set", "ignition=false"});
  const Eigen::Index turn = 200;
  const Eigen::ArrayXd angle = run["crank.angle"].tail(turn), up = run["main.fz"].tail(turn);
  const auto order = [&](int n) { return 2 * (up * (n * angle).cos()).mean(); };
  const double lambda = radius / length, scale = radius * speed * speed;
  const double reciprocating = piston + rod / 2, rotating = rod / 2;
  EXPECT_NEAR(order(1), -(reciprocating + rotating) * scale, 1e-3 * scale);
  // λ + λ³/4 + 15 λ⁵/128 of the rod's slant, λ of the first approximation.
  const double second = lambda + std::pow(lambda, 3) / 4 + 15 * std::pow(lambda, 5) / 128;
  EXPECT_NEAR(order(2), -reciprocating * second * scale, 1e-3 * scale);
}

/// F l/(E A) of the force that the gas leaves for the rod: piston and half of the rod are held back by their
/// inertia.
TEST_F(CrankTrain, TheRodIsSqueezedByWhatTheGasLeavesForIt) {
  const Table run = run_example("crank-train").from(0.04);
  double squeezed = 0;
  for (Eigen::Index row = 0; row < run["t"].size(); ++row) {
    const double angle = run["crank.angle"][row];
    const double away = speed * speed * (wrist(angle + 1e-4) - 2 * wrist(angle) + wrist(angle - 1e-4)) / 1e-8;
    const double force = area * pressure(angle) + (piston + rod / 2) * away;
    const double slant = std::sqrt(1 - std::pow(radius / length * std::sin(angle), 2));
    squeezed = std::min(squeezed, -force / slant * length / (2.1e11 * width * height));
  }
  EXPECT_NEAR(run["rod.stretch"].minCoeff(), squeezed, -0.03 * squeezed);
}

}  // namespace
}  // namespace mimbre::examples_test::crank_train_test
