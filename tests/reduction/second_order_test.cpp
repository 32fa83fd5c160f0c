#include "reduction/stiffening/second_order.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fe/meshes.h"
#include "math/once/decompositions.h"
#include "math/rotation.h"
#include "support/models.h"
#include "support/run.h"

namespace mimbre::second_order_test {
namespace {

using Eigen::Vector3d;

constexpr double length = 2.5;

/// A cantilever in any direction with a static mode across its tip, and one along it where asked.
ReducedBody cantilever(const Eigen::Matrix3d& axes, fe::Stiffening stiffening, bool axial = false,
                       bool published = false) {
  fe::Mesh mesh =
      test::with_nodes({Vector3d(0.3, -0.2, 0.5), Vector3d(0.3, -0.2, 0.5) + length * axes.col(0)});
  test::add_bar(mesh, 0, 1, 4, test::rectangle(0.05, 0.03), axes.col(1));
  fe::ReductionOptions options;
  options.clamped_nodes = {0};
  options.boundary.push_back({1, false, axes.col(1), "across"});
  if (axial) options.boundary.push_back({1, false, axes.col(0), "along"});
  options.stiffening = stiffening;
  options.published_force = published;
  return fe::reduce(mesh, options, {{"tip", 1, Eigen::Matrix3d::Identity()}});
}

Eigen::Matrix3d turned() { return rotation_exp<double>(Vector3d(0.7, -1.1, 0.4)); }

// v = (3 s² L − s³)/(2 L³) at unit tip displacement: ∫ v'² ds = 6/(5 L).
TEST(Foreshortening, ShortensACantileverAsItsDeflectionSays) {
  const Eigen::Matrix3d axes = turned();
  const ReducedBody body = cantilever(axes, fe::Stiffening::foreshortening);
  ASSERT_TRUE(body.second_order);
  ASSERT_EQ(body.second_order->products.size(), 1u);
  const double y = 1 / body.user_from_modal(0, 0);  // unit tip displacement
  const Vector3d tip = body.second_order->frame_shapes[0].col(1) * (y * y);
  EXPECT_LT((tip + 0.6 / length * axes.col(0)).norm(), 1e-12);
  EXPECT_LT((body.second_order->frame_shapes[0].col(0) * y - axes.col(1)).norm(), 1e-9);
}

// The mass centre moves back by ∫∫ of the same: ½ ∫ (L − s) v'² ds / L, and S holds mass times that.
TEST(Foreshortening, MovesTheCentreOfMass) {
  const Eigen::Matrix3d axes = turned();
  const ReducedBody body = cantilever(axes, fe::Stiffening::foreshortening);
  const double y = 1 / body.user_from_modal(0, 0);
  const int n = 2000;
  double expected = 0;
  for (int k = 0; k < n; ++k) {
    const double x = (k + 0.5) / n, slope = (3 * x - 1.5 * x * x) / length;
    expected -= 0.5 * (1 - x) * slope * slope * length / n;
  }
  const Vector3d moved = body.second_order->S.col(1) * (y * y / body.mass);
  EXPECT_LT((moved - expected * axes.col(0)).norm(), 1e-6 * std::abs(expected));
  // In what the extended mass matrix says of it, too.
  const double mass = body.second_order->mass_matrix(1, 1) * std::pow(y, 4);
  EXPECT_GT(mass, 0);
  EXPECT_LT(mass, body.mass * 0.36 / (length * length));  // as if all of it moved as the tip does
}

TEST(Foreshortening, RefusesLoops) {
  fe::Mesh mesh = test::with_nodes({Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(1, 1, 0)});
  const Vector3d up(0, 0, 1);
  test::add_bar(mesh, 0, 1, 1, test::rectangle(0.05, 0.03), up);
  test::add_bar(mesh, 1, 2, 1, test::rectangle(0.05, 0.03), up);
  test::add_bar(mesh, 2, 0, 1, test::rectangle(0.05, 0.03), up);
  fe::ReductionOptions options;
  options.clamped_nodes = {0};
  options.dynamic_modes = 2;
  options.stiffening = fe::Stiffening::foreshortening;
  EXPECT_THROW(fe::reduce(mesh, options, {}), std::invalid_argument);
}

// ½ ∫EA u'v'² = ½ EA/L · 6/(5 L) and ⅛ ∫EA v'⁴ for unit displacements along and across.
TEST(NonlinearStiffness, HasTheEnergyOfStretchedSlopes) {
  const Eigen::Matrix3d axes = turned();
  const ReducedBody body = cantilever(axes, fe::Stiffening::nonlinear_stiffness_2, true);
  const Eigen::VectorXd y = mimbre::solve(body.user_from_modal, Eigen::Vector2d(1, 1));
  const auto& second = *body.second_order;
  Eigen::VectorXd eta(2 + second.products.size());
  eta.head(2) = y;
  for (std::size_t p = 0; p < second.products.size(); ++p)
    eta[2 + static_cast<Eigen::Index>(p)] = y[second.products[p][0]] * y[second.products[p][1]];
  const double EA = test::steel().young * 0.05 * 0.03;
  const double linear = 0.5 * y.dot(body.stiffness * y), all = 0.5 * eta.dot(second.stiffness * eta);
  double fourth = 0;
  const int n = 2000;
  for (int k = 0; k < n; ++k) {
    const double x = (k + 0.5) / n, slope = (3 * x - 1.5 * x * x) / length;
    fourth += 0.125 * EA * std::pow(slope, 4) * length / n;
  }
  const double expected = 0.5 * EA / length * 6 / (5 * length) + fourth;
  EXPECT_NEAR(all - linear, expected, 1e-6 * expected);
}

TEST(NonlinearStiffness, PublishedForceLeavesTheAxialModesOut) {
  const ReducedBody body = cantilever(turned(), fe::Stiffening::nonlinear_stiffness_1, true, true);
  const Eigen::Index products = static_cast<Eigen::Index>(body.second_order->products.size());
  EXPECT_GT(body.second_order->stiffness.topRightCorner(2, products).cwiseAbs().maxCoeff(), 0);
  EXPECT_EQ(body.second_order->stiffness.bottomLeftCorner(products, 2).cwiseAbs().maxCoeff(), 0);
}

/// A beam on a turning hub that falls from straight and swings by a fifth of its length keeps its energy, up
/// to what the step leaves: in both formulations, and the better the shorter the step.
TEST(Foreshortening, KeepsTheEnergyOfASwingingBeam) {
  const std::string text = R"(
gravity: [0, 0, -9.81]
materials: {soft: {young: 2e8, poisson: 0.3, density: 1000}}
sections: {bar: {area: 4e-4, Iy: 2e-8, Iz: 2e-8, J: 4e-8}}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: soft
      section: bar
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {beam: {from: root, to: tip, elements: 6}}
      clamped: [root]
      dynamic_modes: 4
      stiffening: foreshortening
joints:
  hub: {type: revolute, between: [ground, beam], at: [0, 0, 0], axis: [0, 0, 1], velocity: 3}
simulation: {step: 0.01, end: 1}
)";
  for (const auto formulation :
       {spec::Simulation::Formulation::relative, spec::Simulation::Formulation::natural}) {
    double before = 0;
    for (const double step : {0.004, 0.002, 0.001}) {
      RunOptions options;
      options.step = step;
      options.formulation = formulation;
      options.integrator = spec::Simulation::Integrator::newmark;
      Simulation simulation(test::model_of(text), options);
      double drift = 0, elastic = 0, kinetic = 0;
      ResultsRow row;
      while (simulation.time() < 0.8) {
        const StepReport report = simulation.step();
        ASSERT_TRUE(report.ok()) << simulation.explain(report);
        drift = std::max(drift, std::abs(simulation.energy().numerical));
        elastic = std::max(elastic, simulation.energy().elastic);
        kinetic = std::max(kinetic, simulation.energy().kinetic);
      }
      EXPECT_GT(elastic, 0.1 * kinetic);  // it does bend
      EXPECT_LT(drift, 2e-3 * kinetic);
      if (before > 0) {
        EXPECT_GT(before / drift, 3) << step;
      }
      before = drift;
    }
  }
}

}  // namespace
}  // namespace mimbre::second_order_test
