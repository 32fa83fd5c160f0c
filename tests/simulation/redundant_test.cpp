#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "mimbre/simulation.h"
#include "support/models.h"

/// Mechanisms with more equations than independent ones, in every formulation, against motions known
/// otherwise.
namespace mimbre::redundant_test {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;
using Formulation = spec::Simulation::Formulation;

constexpr double g = 9.81;

class Redundant : public testing::TestWithParam<Formulation> {
 protected:
  RunOptions options(double step) const {
    RunOptions o;
    o.step = step;
    o.formulation = GetParam();
    return o;
  }
  RunOptions trapezoidal(double step) const {
    RunOptions o = options(step);
    o.integrator = spec::Simulation::Integrator::newmark;
    o.xi = 0;
    return o;
  }
};

INSTANTIATE_TEST_SUITE_P(Formulations, Redundant,
                         testing::Values(Formulation::relative, Formulation::natural),
                         [](const auto& formulation) {
                           return formulation.param == Formulation::relative ? "relative" : "natural";
                         });

/// Steps to `end`; `see` is called with the time and the model's outputs after every step.
template <class See>
void follow(Simulation& simulation, double end, See&& see) {
  ResultsRow row;
  const int steps = static_cast<int>(std::round(end / simulation.step_size()));
  for (int k = 0; k < steps; ++k) {
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.ok()) << simulation.explain(report);
    ASSERT_LE(report.position_violation, 1e-8);
    ASSERT_LE(report.velocity_violation, 1e-6);
    simulation.sample(row);
    see(simulation.time(), row.channels);
  }
}

/// The ring of six hinges in closed form: every other angle is theta, those between them are phi (the
/// threefold-symmetric ring with twists of 90 degrees; Chen, You, Tarnai 2005).
namespace bricard {

double phi(double theta) { return -std::asin(std::sin(theta) / (1 + std::sin(theta))); }

/// Ends of the rods, from the ground's P0 to its P5.
std::array<Vector3d, 6> points(double theta) {
  const std::array<Vector3d, 5> axes{Vector3d::UnitY(), Vector3d::UnitZ(), Vector3d::UnitX(),
                                     Vector3d::UnitY(), Vector3d::UnitZ()};
  const std::array<Vector3d, 5> rods{Vector3d::UnitX(), -Vector3d::UnitY(), Vector3d::UnitZ(),
                                     -Vector3d::UnitX(), Vector3d::UnitY()};
  std::array<Vector3d, 6> p{Vector3d::Zero()};
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  for (std::size_t k = 0; k < 5; ++k) {
    turned = turned * Eigen::AngleAxisd(k % 2 == 0 ? theta : phi(theta), axes[k]).toRotationMatrix();
    p[k + 1] = p[k] + turned * rods[k];
  }
  return p;
}

double potential(double theta) {
  const auto p = points(theta);
  double energy = 0;
  for (std::size_t k = 0; k < 5; ++k) energy += g * (p[k].y() + p[k + 1].y()) / 2;
  return energy;
}

/// Kinetic energy is half of this times the square of theta's rate: rods that are thin.
double inertia(double theta) {
  const double h = 1e-5;
  const auto before = points(theta - h), after = points(theta + h);
  double sum = 0;
  for (std::size_t k = 0; k < 5; ++k) {
    const Vector3d a = (after[k] - before[k]) / (2 * h), b = (after[k + 1] - before[k + 1]) / (2 * h);
    sum += (a.dot(a) + a.dot(b) + b.dot(b)) / 3;
  }
  return sum;
}

/// Of a motion that starts at rest at zero: half the square of the rate is (V(0) − V) / I.
double acceleration(double theta) {
  const auto half_square = [](double x) { return (potential(0) - potential(x)) / inertia(x); };
  const double h = 1e-3;
  return (8 * (half_square(theta + h) - half_square(theta - h)) -
          (half_square(theta + 2 * h) - half_square(theta - 2 * h))) /
         (12 * h);
}

/// theta at the time, by the classical Runge–Kutta method.
double theta_at(double end) {
  const int steps = 400;
  const double h = end / steps;
  double x = 0, v = 0;
  for (int k = 0; k < steps; ++k) {
    const double a1 = acceleration(x), a2 = acceleration(x + h / 2 * v),
                 a3 = acceleration(x + h / 2 * (v + h / 2 * a1)), v2 = v + h / 2 * a1, v3 = v + h / 2 * a2,
                 v4 = v + h * a3, a4 = acceleration(x + h * v3);
    x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return x;
}

}  // namespace bricard

TEST_P(Redundant, BricardMovesAsItsClosedForm) {
  Simulation s(test::example("bricard/mechanism.yaml"), options(0.01));
  double largest = 0;
  follow(s, 10, [&](double, const Eigen::VectorXd& out) {
    const double theta = out[3];
    largest = std::max(largest, theta);
    EXPECT_NEAR(out[4], bricard::phi(theta), 1e-7);
    EXPECT_LE((out.head<3>() - bricard::points(theta)[3]).norm(), 1e-7) << theta;
  });
  EXPECT_NEAR(largest, pi, 0.01);  // it falls through to the mirrored position
}

TEST_P(Redundant, BricardKeepsItsEnergy) {
  for (const bool damped : {false, true}) {
    Simulation s(test::example("bricard/mechanism.yaml"), damped ? options(0.01) : trapezoidal(0.01));
    const double start = s.energy().kinetic + s.energy().gravitational;
    double drift = 0;
    follow(s, 10, [&](double, const Eigen::VectorXd&) {
      drift = std::max(drift, std::abs(s.energy().kinetic + s.energy().gravitational - start));
    });
    EXPECT_LE(drift, 5e-3) << (damped ? "generalised-alpha" : "trapezoidal");
    EXPECT_TRUE(s.warnings().empty());
  }
}

TEST_P(Redundant, BricardArrivesInTime) {
  const double expected = bricard::theta_at(2);
  std::array<double, 2> error{};
  for (std::size_t k = 0; k < 2; ++k) {
    Simulation s(test::example("bricard/mechanism.yaml"), trapezoidal(k == 0 ? 0.01 : 0.005));
    follow(s, 2, [&](double, const Eigen::VectorXd& out) { error[k] = out[3] - expected; });
  }
  EXPECT_NEAR(error[1], 0, 1e-4);
  EXPECT_NEAR(error[0] / error[1], 4, 0.2);
}

TEST_P(Redundant, BricardHasOneDegreeOfFreedom) {
  const auto model = test::example("bricard/mechanism.yaml");
  EXPECT_EQ(model->coordinates(), 5);
  EXPECT_EQ(model->constraints(), 5);
  Simulation s(model, options(0.01));
  EXPECT_EQ(s.degrees_of_freedom(), 1);
}

/// The example with something changed.
std::shared_ptr<const Model> changed_bricard(const std::string& from, const std::string& to) {
  std::string text = test::example("bricard/mechanism.yaml")->spec().text;
  text.replace(text.find(from), from.size(), to);
  return Model::compile(parse_model(text, "changed.yaml", "."));
}

TEST_P(Redundant, BricardClosesFromAPositionThatIsOff) {
  Simulation s(changed_bricard("velocity: swing", "position: 0.4, velocity: 1"), options(0.01));
  ResultsRow row;
  s.sample(row);
  EXPECT_NEAR(row.channels[3], 0.4, 1e-12);
  EXPECT_LE((row.channels.head<3>() - bricard::points(0.4)[3]).norm(), 1e-7);
  EXPECT_NEAR(s.energy().kinetic, bricard::inertia(0.4) / 2, 1e-6);
  follow(s, 1, [](double, const Eigen::VectorXd&) {});
}

TEST_P(Redundant, BricardFindsItsEquilibrium) {
  const auto model = changed_bricard("simulation:\n", "initial: equilibrium\nsimulation:\n");
  Simulation s(model, options(0.01));
  ResultsRow row;
  s.sample(row);
  EXPECT_NEAR(row.channels[3], pi / 2, 1e-7);
  EXPECT_NEAR(row.channels[4], -pi / 6, 1e-7);
  EXPECT_LE((row.channels.head<3>() - Vector3d(0, -std::sqrt(3), 0)).norm(), 1e-7);
  follow(s, 1, [](double, const Eigen::VectorXd& out) { EXPECT_NEAR(out[3], pi / 2, 1e-6); });
}

/// A platform on three parallel cranks in a plane: any two would do. It swings like a pendulum.
TEST_P(Redundant, ThreeParallelCranksAreAPendulum) {
  const double crank = 0.5, platform = 2, length = 0.3, start = 0.2;
  std::string bodies, joints;
  for (int k = 0; k < 3; ++k) {
    bodies += "  crank" + std::to_string(k) + ": {mass: 0.5, com: [" + std::to_string(k) +
              ", 0, -0.15], inertia: [0.00375, 0.00375, 0.001]}\n";
    joints += "  foot" + std::to_string(k) + ": {type: revolute, between: [ground, crank" +
              std::to_string(k) + "], at: [" + std::to_string(k) + ", 0, 0], axis: [0, 1, 0]" +
              (k == 0 ? ", position: 0.2}\n" : "}\n");
    joints += "  top" + std::to_string(k) + ": {type: revolute, between: [crank" + std::to_string(k) +
              ", platform], at: [" + std::to_string(k) + ", 0, -0.3], axis: [0, 1, 0]}\n";
  }
  const auto model = test::model_of("bodies:\n" + bodies +
                                    "  platform: {mass: 2, com: [1, 0, -0.3], inertia: [0.1, 0.1, 0.1]}\n"
                                    "joints:\n" +
                                    joints + "outputs:\n  - {name: angle, joint: foot0}\n");
  Simulation s(model, options(0.001));
  EXPECT_EQ(s.degrees_of_freedom(), 1);
  // I θ̈ = −k sin θ, whose rate at the lowest point follows from the energy.
  const double inertia = (3 * crank * (length * length / 4) + 3 * 0.00375) + platform * length * length;
  const double weight = (3 * crank / 2 + platform) * length * g;
  double last = start, before = start;
  int passages = 0;
  follow(s, 1, [&](double, const Eigen::VectorXd& out) {
    if (last * before < 0) {  // passing the lowest point
      ++passages;
      EXPECT_NEAR(std::abs(out[0] - before) / 0.002, std::sqrt(2 * weight / inertia * (1 - std::cos(start))),
                  1e-4);
    }
    before = last;
    last = out[0];
  });
  EXPECT_GE(passages, 1);
  EXPECT_LE(std::abs(s.energy().numerical), 1e-6);
}

}  // namespace
}  // namespace mimbre::redundant_test
