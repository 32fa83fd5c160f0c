#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <sstream>

#include "mimbre/simulation.h"
#include "support/models.h"

/// Kane's spin-up beam against converged histories of another code's nonlinear beams (40 elements, 0.5 ms).
namespace mimbre::test::spin_up_test {
namespace {

using Settings = std::map<std::string, std::string>;

/// Rows of a CSV file: time, then the tip's displacements.
std::vector<std::vector<double>> history(const std::string& name) {
  std::ifstream file(std::string(MIMBRE_SOURCE_DIR) + "/tests/data/" + name + ".csv");
  std::vector<std::vector<double>> rows;
  std::string line, cell;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    rows.emplace_back();
    while (std::getline(cells, cell, ',')) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

struct Deviation {
  std::vector<double> mean;  ///< mm, of the absolute values of each component
};

Deviation follow(const std::string& dimension, const Settings& settings,
                 spec::Simulation::Formulation formulation = spec::Simulation::Formulation::relative) {
  const auto model = example("spin-up-beam/beam-" + dimension + ".yaml", settings);
  RunOptions options;
  options.formulation = formulation;
  options.integrator = spec::Simulation::Integrator::newmark;  // the trapezoidal rule, as published
  Simulation simulation(model, options);
  const auto rows = history("spin-up-" + dimension);
  EXPECT_EQ(rows.size(), 201u);
  Deviation result;
  result.mean.assign(static_cast<std::size_t>(simulation.output_count()), 0.0);
  ResultsRow sample;
  for (const auto& row : rows) {
    while (simulation.time() < row.at(0) - 1e-6) {
      const StepReport report = simulation.step();
      if (!report.ok()) {
        ADD_FAILURE() << simulation.explain(report);
        return result;
      }
    }
    simulation.sample(sample);
    for (std::size_t k = 0; k < result.mean.size(); ++k)
      result.mean[k] += 1e3 * std::abs(sample.channels[static_cast<Eigen::Index>(k)] - row.at(k + 1)) /
                        static_cast<double>(rows.size());
  }
  std::cout << "  " << dimension;
  for (const auto& [name, value] : settings) std::cout << ' ' << name << '=' << value;
  std::cout << std::fixed << std::setprecision(3) << ": mean deviation, mm:";
  for (const double d : result.mean) std::cout << ' ' << d;
  std::cout << '\n';
  return result;
}

Settings pieces(int count) {
  return {{"method", "substructuring"}, {"substructures", std::to_string(count)}};
}

/// The published deviations (Lugrís 2008, table 4.2; mm), of the same model but with fewer modes in the
/// pieces.
struct Published {
  int count;
  std::array<double, 3> deviation;
};
const std::array published{Published{3, {3.734, 47.681, 38.458}}, Published{5, {1.337, 13.128, 11.682}},
                           Published{10, {0.502, 3.193, 2.329}}, Published{20, {0.320, 1.481, 0.742}}};

TEST(SpinUpBeam, SubstructuresInThePlane) {
  std::vector<double> before;
  for (const int count : {5, 10, 20}) {
    const auto now = follow("2d", pieces(count)).mean;
    // The pieces' error falls with the square of their length.
    for (std::size_t k = 0; k < before.size(); ++k)
      EXPECT_NEAR(before[k] / now[k], 4, 0.6) << count << ' ' << k;
    before = now;
  }
  EXPECT_LT(before[0], 0.03);
  EXPECT_LT(before[1], 1.0);
}

TEST(SpinUpBeam, SubstructuresUnderGravity) {
  std::vector<double> before;
  for (const Published& p : published) {
    const auto now = follow("3d", pieces(p.count)).mean;
    // Nearer to the converged history than the published runs to theirs, but for the difference of the
    // models.
    for (std::size_t k = 0; k < 3; ++k) EXPECT_LT(now[k], 1.4 * p.deviation[k]) << p.count << ' ' << k;
    for (std::size_t k = 0; k < 3 && p.count > 5; ++k)
      EXPECT_NEAR(before[k] / now[k], 4, 0.6) << p.count << ' ' << k;
    before = now;
  }
}

/// The error of the pieces, not of the formulation, is what is left in both.
TEST(SpinUpBeam, SubstructuresInNaturalCoordinates) {
  using Formulation = spec::Simulation::Formulation;
  for (const char* dimension : {"2d", "3d"}) {
    const auto relative = follow(dimension, pieces(5)).mean,
               natural = follow(dimension, pieces(5), Formulation::natural).mean;
    for (std::size_t k = 0; k < relative.size(); ++k)
      EXPECT_NEAR(natural[k], relative[k], 0.03 * relative[k]);
  }
}

/// Few pieces do when each knows that bending shortens it.
TEST(SpinUpBeam, ForeshortenedSubstructures) {
  Settings settings = pieces(3);
  settings["method"] = "foreshortened_substructures";
  const auto in_plane = follow("2d", settings).mean, under_gravity = follow("3d", settings).mean;
  for (const double d : in_plane) EXPECT_LT(d, 0.15);
  for (const double d : under_gravity) EXPECT_LT(d, 0.6);
}

/// The stress of rotation without an axial mode: as good as the published first nonlinear stiffness with two
/// across the beam (5.576 and 3.907 mm under gravity). Along it the tip does not come nearer.
TEST(SpinUpBeam, GeometricStiffness) {
  const Settings settings{{"method", "geometric_stiffness"}};
  using Formulation = spec::Simulation::Formulation;
  const auto in_plane = follow("2d", settings).mean, under_gravity = follow("3d", settings).mean,
             natural = follow("3d", settings, Formulation::natural).mean;
  EXPECT_LT(in_plane[1], 3.5);
  EXPECT_LT(under_gravity[1], 5.576);
  EXPECT_LT(under_gravity[2], 3.907);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(natural[k], under_gravity[k], 0.25);
}

/// Ten elements without modes to choose; public codes' nonlinear beams deviate by 0.01 to 0.18, 0.24 to 2.7
/// and 0.08 to 1.2 mm.
TEST(SpinUpBeam, NonlinearBeams) {
  const auto corotational = follow("3d", {{"method", "nonlinear_beam"}}).mean;
  EXPECT_LT(corotational[0], 0.005);
  EXPECT_LT(corotational[1], 0.1);
  EXPECT_LT(corotational[2], 0.05);
  const auto ancf = follow("2d", {{"method", "ancf"}}).mean;
  EXPECT_LT(ancf[0], 0.001);
  EXPECT_LT(ancf[1], 0.02);
  for (const char* kind : {"ancf_cable", "ancf_thick"}) {
    const auto in_space = follow("3d", {{"method", kind}, {"elements", "6"}}).mean;
    EXPECT_LT(in_space[0], 0.005) << kind;
    EXPECT_LT(in_space[1], 0.1) << kind;
    EXPECT_LT(in_space[2], 0.05) << kind;
  }
}

/// Rotations that are none stretch the chain of pieces: an order of magnitude in the axial direction, as
/// published (3.061 mm).
TEST(SpinUpBeam, InfinitesimalRotationsLoseTheAxialDirection) {
  Settings settings = pieces(20);
  const double right = follow("3d", settings).mean[0];
  settings["boundary_rotation"] = "successive";
  EXPECT_NEAR(follow("3d", settings).mean[0], right, 0.01);
  settings["boundary_rotation"] = "infinitesimal";
  const double wrong = follow("3d", settings).mean[0];
  EXPECT_GT(wrong, 20 * right);
  EXPECT_NEAR(wrong, 3.061, 0.5);
}

/// The static tip of the nonlinear beam, from the converged run.
TEST(SpinUpBeam, HangsAsTheNonlinearBeam) {
  const auto model = example("spin-up-beam/beam-3d.yaml", pieces(20));
  Simulation simulation(model);
  ResultsRow row;
  simulation.sample(row);
  EXPECT_NEAR(row.channels[0], -0.062246, 2e-4);
  EXPECT_NEAR(row.channels[1], 0, 1e-9);
  EXPECT_NEAR(row.channels[2], -1.041926, 1e-4);
}

/// Elastic forces that are linear in one frame know nothing of tension: the beam bends without bound, and the
/// run says so.
TEST(SpinUpBeam, OneLinearBodyFails) {
  const auto model = example("spin-up-beam/beam-2d.yaml", {{"method", "linear"}});
  Simulation simulation(model);
  StepReport report;
  while (simulation.time() < 15 && report.ok()) report = simulation.step();
  EXPECT_FALSE(report.ok());
}

}  // namespace
}  // namespace mimbre::test::spin_up_test
