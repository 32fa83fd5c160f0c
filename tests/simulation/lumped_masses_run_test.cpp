#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "mimbre/diagnostics.h"
#include "mimbre/modes.h"
#include "support/models.h"
#include "support/simulate.h"

/// Bodies of bars with `mass_matrix: lumped` in mechanisms.
namespace mimbre::test::lumped_masses_run_test {
namespace {

constexpr double diameter = 0.02, density = 7850, young = 2.1e11, length = 1.5;
const double area = std::numbers::pi / 4 * diameter * diameter, weight = density * area * 9.81;

std::string bar(int elements, const std::string& flexible, const std::string& more) {
  return fmt::format(R"y(
materials: {{steel: {{young: {}, poisson: 0.3, density: {}}}}}
sections: {{rod: {{type: round, diameter: {}}}}}
bodies:
  beam:
    frame: {{at: [0, 0, 0]}}
    flexible:
      material: steel
      section: rod
      nodes: {{root: [0, 0, 0], tip: [{}, 0, 0]}}
      bars: {{span: {{from: root, to: tip, elements: {}, y: [0, 1, 0]}}}}
      clamped: [root]
      {}
{}
)y",
                     young, density, diameter, length, elements, flexible, more);
}

const std::string lumped_modes = "mass_matrix: lumped\n      dynamic_modes: 4\n      stiffness_damping: 1e-3",
                  lumped_elements = "mass_matrix: lumped\n      beam: corotational",
                  consistent_elements = "beam: corotational";

class LumpedMassesInRuns : public testing::TestWithParam<Formulation> {};
INSTANTIATE_TEST_SUITE_P(BothFormulations, LumpedMassesInRuns,
                         testing::Values(Formulation::relative, Formulation::natural));

std::string sections_at(const std::vector<double>& places) {
  std::string text = "outputs:\n";
  for (const double x : places)
    for (const char* component : {"N", "Vz", "My"})
      text += fmt::format("  - {{name: {} {}, section_force: beam, at: [{}, 0, 0], component: {}}}\n",
                          component, x, x, component);
  return text;
}

/// Sums over the nodes of what is linear along a bar are exact: shear, moment and tension at the nodes.
TEST_P(LumpedMassesInRuns, HaveTheSectionForcesOfTheWeight) {
  Simulation s = simulation_of(
      bar(10, lumped_modes,
          sections_at({0, 0.45, 0.9}) +
              "initial: equilibrium\njoints: {wall: {type: fixed, between: [ground, beam.root]}}"),
      GetParam(), 1e-3);
  for (const double x : {0.0, 0.45, 0.9}) {
    const double rest = length - x;
    EXPECT_NEAR(channel(s, fmt::format("Vz {}", x)), -weight * rest, 1e-6 * weight) << x;
    EXPECT_NEAR(channel(s, fmt::format("My {}", x)), 0.5 * weight * rest * rest, 1e-6 * weight) << x;
  }
}

TEST_P(LumpedMassesInRuns, HaveTheTensionOfATurningBar) {
  const double speed = 40;
  Simulation s = simulation_of(
      bar(10, lumped_modes,
          sections_at({0, 0.75, 1.2}) +
              fmt::format(
                  "gravity: [0, 0, 0]\njoints: {{hub: {{type: revolute, between: [ground, beam.root], "
                  "axis: [0, 0, 1], drive: {{speed: {}}}}}}}",
                  speed)),
      GetParam(), 1e-4);
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(s.step().ok());
  const double whole = 0.5 * density * area * speed * speed * length * length;
  for (const double x : {0.0, 0.75, 1.2})
    EXPECT_NEAR(channel(s, fmt::format("N {}", x)), whole * (1 - x * x / (length * length)), 1e-5 * whole);
}

const std::string swing =
    "outputs:\n  - {name: z, position: beam.tip, component: z}\n"
    "joints: {hinge: {type: revolute, between: [ground, beam.root], axis: [0, 1, 0]}}\n"
    "gravity: [0, 0, -9.81]\n";

/// Heights of the tip of a pendulum that falls from the horizontal.
std::vector<double> heights(const std::string& text, Formulation formulation) {
  Simulation s = simulation_of(text, formulation, 2e-3);
  std::vector<double> values;
  for (int k = 0; k < 250; ++k) {
    const StepReport report = s.step();
    EXPECT_TRUE(report.ok()) << s.explain(report);
    values.push_back(channel(s, "z"));
  }
  return values;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, std::abs(a[k] - b[k]));
  return most;
}

/// To the same motion as consistent masses, with order 2 of the elements' length: the inertia about the hinge
/// is larger by that order.
TEST_P(LumpedMassesInRuns, OfCorotationalElementsConvergeWithOrderTwo) {
  const auto error = [&](int n) {
    return largest_difference(heights(bar(n, lumped_elements, swing), GetParam()),
                              heights(bar(n, consistent_elements, swing), GetParam()));
  };
  const double coarse = error(4), fine = error(8);
  EXPECT_GT(fine, 1e-4);
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.2);
}

/// One energy: by integrals and by projection, and in either formulation, whose steps differ as they do with
/// consistent masses.
TEST(LumpedMassesInRuns, AreTheSameByEveryWay) {
  const auto between_formulations = [](const std::string& text) {
    return largest_difference(heights(text, Formulation::relative), heights(text, Formulation::natural));
  };
  EXPECT_LT(between_formulations(bar(6, lumped_elements, swing)),
            1.2 * between_formulations(bar(6, consistent_elements, swing)));
  const std::string modes = bar(6, lumped_modes, swing), end = "simulation: {inertia: projection}\n";
  EXPECT_LT(
      largest_difference(heights(modes, Formulation::relative), heights(modes + end, Formulation::relative)),
      1e-6);
}

/// Bending of the clamped bar, by corotational elements: too low, with order 2.
TEST(LumpedMassesInRuns, OfACantileverHaveFrequenciesFromBelow) {
  const std::string clamp =
      "gravity: [0, 0, 0]\njoints: {clamp: {type: fixed, between: [ground, beam.root]}}\n";
  const double exact = std::pow(1.87510406871196 / length, 2) *
                       std::sqrt(young * std::numbers::pi / 64 * std::pow(diameter, 4) / (density * area)) /
                       (2 * std::numbers::pi);
  const auto lowest = [&](int n) {
    double least = 1e300;
    for (const Mode& m : find_modes(model_of(bar(n, lumped_elements, clamp))).modes)
      if (m.frequency > 0) least = std::min(least, m.frequency);
    return least;
  };
  const double coarse = lowest(4), fine = lowest(8);
  EXPECT_LT(fine, exact);
  EXPECT_NEAR(std::log2((exact - coarse) / (exact - fine)), 2, 0.15);
}

/// The same reduction is not shared with a body that differs in the mass matrix alone.
TEST(LumpedMassesInRuns, BelongToOneBody) {
  const auto second_moment = [](const std::string& mass_matrix) {
    const auto model = model_of(bar(4, mass_matrix + "\n      dynamic_modes: 1",
                                    "joints: {wall: {type: fixed, between: [ground, beam.root]}}\n"));
    return model->spec().bodies[0].flexible->second_moment(0, 0);
  };
  const double exact = density * area * std::pow(length, 3) / 3,
               larger = density * area * std::pow(length, 3) / 12 * (2 + 24.0 / 78) / 16;
  EXPECT_NEAR(second_moment("mass_matrix: consistent"), exact, 1e-4 * exact);
  EXPECT_NEAR(second_moment("mass_matrix: lumped"), exact + larger, 1e-4 * exact);
}

TEST(LumpedMassesInRuns, AreRefusedByBeamsWithMassesOfTheirOwn) {
  const auto message = [](const std::string& flexible) -> std::string {
    try {
      model_of(bar(4, "mass_matrix: lumped\n      " + flexible,
                   "joints: {wall: {type: fixed, between: [ground, beam.root]}}\n"));
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(message("planar: [0, 0, 1]\n      beam: ancf"),
              testing::HasSubstr("cannot be lumped by absolute nodal coordinates"));
  EXPECT_THAT(message("beam: segments"), testing::HasSubstr("cannot be lumped in segments"));
}

}  // namespace
}  // namespace mimbre::test::lumped_masses_run_test
