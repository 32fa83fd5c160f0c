#include "simulation/step/energy.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mimbre/simulation.h"
#include "support/models.h"

namespace mimbre::test::energy_test {
namespace {

struct Balance {
  double largest_numerical = 0;  ///< in size, over the run
  double largest_kinetic = 0;
  EnergyBalance end{};
};

Balance balance(const std::shared_ptr<const Model>& model, double step, double duration) {
  RunOptions options;
  options.step = step;
  options.integrator = spec::Simulation::Integrator::newmark;
  options.xi = 0;
  Simulation s(model, options);
  Balance b;
  const int steps = static_cast<int>(std::lround(duration / step));
  for (int k = 0; k < steps; ++k) {
    const StepReport report = s.step();
    if (!report.ok()) {
      ADD_FAILURE() << s.explain(report);
      break;
    }
    b.end = s.energy();
    b.largest_numerical = std::max(b.largest_numerical, std::abs(b.end.numerical));
    b.largest_kinetic = std::max(b.largest_kinetic, b.end.kinetic);
  }
  return b;
}

TEST(Energy, BalanceOfARigidFourBarImprovesWithTheSquareOfTheStep) {
  const auto model = model_of(four_bar_text({{"crank", ", velocity: 6"}}));
  const Balance coarse = balance(model, 0.004, 1), fine = balance(model, 0.002, 1);
  EXPECT_LT(fine.largest_numerical, 2e-3 * fine.largest_kinetic);
  EXPECT_GT(coarse.largest_numerical / fine.largest_numerical, 3);
  EXPECT_EQ(fine.end.drive_work, 0);
  EXPECT_EQ(fine.end.dissipated, 0);
}

/// Springs, dampers, drives and loads, all with smooth laws.
TEST(Energy, WorksAndDissipationBalance) {
  const auto model =
      model_of(four_bar_text({{"crank", R"yaml(, drive: {position: "0.5*sin(4*t)"})yaml"},
                              {"rocker", ", spring: {stiffness: 3, damping: 0.4, zero: 0.1}"}}) +
               R"yaml(
springs:
  strut:
    between: [ground, rocker]
    at: [[1, 0, 0.6], [0.6, 0, 0.5]]
    elastic: {stiffness: 200, zero: 0.4}
    damping: {coefficient: 15}
  law:
    between: [ground, coupler]
    at: [[0.3, 0, 0.8], [0.3, 0, 0.35]]
    force: "20*(l - 0.4) + 3*v*l + sin(5*t)"
loads:
  push: {on: rocker, at: [0.6, 0, 0.3], force: [2, 0, 1], moment: [0, 0.5, 0], scale: "cos(3*t)", follower: true}
  pull: {on: coupler, at: [0.3, 0, 0.4], force: [0, 0, -3]}
)yaml");
  const Balance coarse = balance(model, 0.004, 1), fine = balance(model, 0.002, 1);
  EXPECT_GT(fine.end.dissipated, 0.05);
  EXPECT_GT(std::abs(fine.end.drive_work), 0.05);
  EXPECT_GT(std::abs(fine.end.load_work), 0.01);
  EXPECT_LT(fine.largest_numerical, 2e-3 * fine.largest_kinetic);
  EXPECT_GT(coarse.largest_numerical / fine.largest_numerical, 3);
}

/// While the wheel stays on the road.
TEST(Energy, BalanceOfTheSuspension) {
  for (const char* kind : {"rigid", "flexible"}) {
    const auto model = example("iltis/suspension.yaml",
                               {{"arms", kind}, {"links", kind}, {"rods", kind}, {"elements", "4"}});
    const Balance coarse = balance(model, 0.002, 0.5), fine = balance(model, 0.001, 0.5);
    EXPECT_GT(fine.end.dissipated, 0);
    EXPECT_LT(fine.largest_numerical, 0.02 * fine.largest_kinetic) << kind;
    EXPECT_GT(coarse.largest_numerical / fine.largest_numerical, 2.5) << kind;
  }
}

/// A wheel that rests on its tyre while the road lifts it: the road's work is what the tyre and the weight
/// gained.
TEST(Energy, RoadDoesWork) {
  const auto model = model_of(R"(
gravity: [0, 0, -9.81]
bodies:
  wheel: {mass: 10, com: [0, 0, 0], inertia: [1, 1, 1]}
joints:
  column: {type: prismatic, between: [ground, wheel], at: [0, 0, 0], axis: [0, 0, 1]}
roads:
  lift: {over: time, points: [[0, 0], [1, 0.1]]}
tyres:
  tyre: {on: wheel, road: lift, stiffness: 5000, radius: 0.01962}
)");
  const Balance fine = balance(model, 0.001, 1);
  EXPECT_GT(fine.end.road_work, 5);
  EXPECT_LT(fine.largest_numerical, 1e-3 * fine.end.road_work);
}

}  // namespace
}  // namespace mimbre::test::energy_test
