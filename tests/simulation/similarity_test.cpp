#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mimbre/simulation.h"
#include "support/models.h"

/// Similar mechanisms move alike and take the same iterations, whatever their size, mass and step.
namespace mimbre::test::similarity_test {
namespace {

using Formulation = spec::Simulation::Formulation;

/// A four-bar mechanism of lengths L, masses M and gravity 9.81 L, so that time is the same for all.
std::string four_bar_of_size(double length, double mass) {
  return fmt::format(R"(
parameters: {{L: {:.17g}, M: {:.17g}}}
gravity: [0, 0, -9.81*L]
bodies:
  c: {{mass: 0.5*M, com: [0, 0, 0.1*L], inertia: [0.002*M*L^2, 0.002*M*L^2, 0.0001*M*L^2]}}
  k: {{mass: M, com: [0.3*L, 0, 0.35*L], inertia: [0.02*M*L^2, 0.02*M*L^2, 0.0005*M*L^2]}}
  r: {{mass: M, com: [0.6*L, 0, 0.25*L], inertia: [0.02*M*L^2, 0.02*M*L^2, 0.0005*M*L^2]}}
joints:
  a: {{type: revolute, between: [ground, c], at: [0, 0, 0], axis: [0, 1, 0], velocity: 3}}
  b: {{type: revolute, between: [c, k], at: [0, 0, 0.2*L], axis: [0, 1, 0]}}
  d: {{type: revolute, between: [ground, r], at: [0.6*L, 0, 0], axis: [0, 1, 0]}}
  e: {{type: revolute, between: [k, r], at: [0.6*L, 0, 0.5*L], axis: [0, 1, 0]}}
outputs: [{{name: a, joint: a}}]
)",
                     length, mass);
}

struct Course {
  double angle = 0;
  long iterations = 0;
  std::size_t warnings = 0;
};

Course course(double length, double mass, Formulation formulation,
              spec::Simulation::Formalism formalism = spec::Simulation::Formalism::index3, int steps = 300) {
  RunOptions options;
  options.step = 0.01;
  options.formulation = formulation;
  options.formalism = formalism;
  Simulation s(model_of(four_bar_of_size(length, mass)), options);
  Course c;
  for (int k = 0; k < steps; ++k) {
    const StepReport report = s.step();
    if (!report.ok()) {
      ADD_FAILURE() << s.explain(report);
      break;
    }
    c.iterations += report.iterations;
  }
  ResultsRow row;
  s.sample(row);
  c.angle = row.channels[0];
  c.warnings = s.warnings().size();
  return c;
}

TEST(Similarity, OfLengthsAndMasses) {
  for (const Formulation formulation : {Formulation::relative, Formulation::natural}) {
    const Course unit = course(1, 1, formulation);
    for (const double length : {1e-6, 1e-3, 0.1, 1e3, 1e6})
      for (const double mass : {1e-9, 1.0, 1e9}) {
        const Course c = course(length, mass, formulation);
        EXPECT_NEAR(c.angle, unit.angle, 1e-6) << length << " m, " << mass << " kg";
        EXPECT_EQ(c.iterations, unit.iterations) << length << " m, " << mass << " kg";
        EXPECT_EQ(c.warnings, unit.warnings) << length << " m, " << mass << " kg";
      }
  }
}

/// The formalisms that others are compared with keep to the mechanism's own units, too.
TEST(Similarity, OfEveryFormalism) {
  using Formalism = spec::Simulation::Formalism;
  for (const Formalism formalism : {Formalism::index1, Formalism::baumgarte, Formalism::penalty,
                                    Formalism::index1_augmented, Formalism::independent})
    for (const Formulation formulation : {Formulation::relative, Formulation::natural}) {
      if (formalism == Formalism::index1 && formulation == Formulation::natural) continue;  // drifts: below
      const Course unit = course(1, 1, formulation, formalism, 100);
      for (const double length : {1e-3, 1e3})
        for (const double mass : {1e-3, 1e6}) {
          const Course c = course(length, mass, formulation, formalism, 100);
          EXPECT_NEAR(c.angle, unit.angle, 1e-7) << length << " m, " << mass << " kg";
          EXPECT_EQ(c.iterations, unit.iterations) << length << " m, " << mass << " kg";
        }
    }
}

/// Loops that come apart are noticed by the share of the mechanism's size, not by a length.
TEST(Similarity, OfTheDriftThatIsRefused) {
  for (const Formulation formulation : {Formulation::relative, Formulation::natural}) {
    double unit = 0;
    for (const double length : {1.0, 1e-3, 1e3}) {
      RunOptions options;
      options.step = 0.02;
      options.formulation = formulation;
      options.formalism = spec::Simulation::Formalism::index1;
      Simulation s(model_of(four_bar_of_size(length, 1)), options);
      StepReport report;
      for (int k = 0; k < 20000 && report.ok(); ++k) report = s.step();
      EXPECT_EQ(report.code, StepReport::Code::drifted) << length << " m";
      if (length == 1) unit = s.time();
      EXPECT_NEAR(s.time(), unit, 1e-9) << length << " m";
    }
  }
}

/// Where the round-off of positions is more than the tolerance of accelerations.
TEST(Similarity, SmallStepsConverge) {
  for (const char* file : {"iltis/vehicle.yaml", "bricard/mechanism.yaml", "double-four-bar/mechanism.yaml"})
    for (const double step : {1e-5, 1e-6, 1e-7})
      for (const Formulation formulation : {Formulation::relative, Formulation::natural}) {
        RunOptions options;
        options.step = step;
        options.formulation = formulation;
        Simulation s(example(file), options);
        for (int k = 0; k < 40; ++k) {
          const StepReport report = s.step();
          ASSERT_TRUE(report.ok()) << file << ": " << s.explain(report);
        }
      }
}

/// The heavy symmetric top of the Lie-group literature: 15 kg, 150 rad/s; errors fall by four with every
/// halving.
TEST(Similarity, ErrorsOfTheFastTopFallWithTheSquareOfTheStep) {
  const auto model = model_of(R"(
gravity: [0, 0, -9.81]
bodies:
  top: {mass: 15, com: [0, 1, 0], inertia: [0.234375, 0.46875, 0.234375], frame: {at: [0, 1, 0]}}
joints:
  point: {type: spherical, between: [ground, top], at: [0, 0, 0], velocity: [0, 150, -4.61538]}
outputs:
  - {name: x, position: top, component: x}
  - {name: y, position: top, component: y}
  - {name: z, position: top, component: z}
)");
  const auto end = [&](double step, double tolerance) {
    RunOptions options;
    options.step = step;
    if (tolerance > 0) options.tolerance = tolerance;
    Simulation s(model, options);
    for (int k = static_cast<int>(std::lround(0.5 / step)); k > 0; --k) EXPECT_TRUE(s.step().ok());
    ResultsRow row;
    s.sample(row);
    return Eigen::Vector3d(row.channels.head<3>());
  };
  const Eigen::Vector3d exact = end(1e-3 / 64, 1e-12);
  double before = (end(5e-4, 0) - exact).norm();
  for (const double step : {2.5e-4, 1.25e-4, 6.25e-5}) {
    const double error = (end(step, 0) - exact).norm();
    EXPECT_GT(before / error, 3.5) << step;
    EXPECT_LT(before / error, 4.6) << step;
    before = error;
  }
}

}  // namespace
}  // namespace mimbre::test::similarity_test
