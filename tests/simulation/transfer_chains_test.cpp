#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>

#include "mimbre/diagnostics.h"
#include "mimbre/simulation.h"
#include "support/models.h"
#include "support/random_mechanism.h"
#include "support/simulate.h"

/// Steps by Riccati's transfer matrices against those of index3, which solves the same equations by another
/// way.
namespace mimbre::test::transfer_chains_test {
namespace {

using Formalism = spec::Simulation::Formalism;
using testing::HasSubstr;

Simulation simulation(const std::shared_ptr<const Model>& model, Formalism formalism, double step,
                      std::optional<spec::Simulation::Integrator> integrator = {}) {
  RunOptions options;
  options.formalism = formalism;
  options.step = step;
  options.tolerance = 1e-11;
  options.integrator = integrator;
  return Simulation(model, options);
}

/// The largest distance of a body's place from that by index3, after so many steps, m.
double distance_from_index3(const std::shared_ptr<const Model>& model, double step, int steps) {
  Simulation a = simulation(model, Formalism::transfer_matrices, step),
             b = simulation(model, Formalism::index3, step);
  double most = 0;
  for (int k = 0; k < steps; ++k) {
    const StepReport of_a = a.step(), of_b = b.step();
    EXPECT_EQ(of_a.ok(), of_b.ok()) << a.explain(of_a) << b.explain(of_b);
    if (!of_a.ok() || !of_b.ok()) break;
  }
  for (const spec::Body& body : model->spec().bodies) {
    const auto place = [&](Simulation& s) { return s.pose(s.body(body.name)); };
    most = std::max({most, (place(a).position - place(b).position).norm(),
                     (place(a).rotation - place(b).rotation).norm()});
  }
  return most;
}

/// Trees of rigid and flexible bodies on all types of joints, on the ground and floating, with springs and
/// dampers between bodies and on joints, tyres and loads.
TEST(TransferChains, MoveRandomTreesAsIndexThree) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    RandomOptions options;
    options.bodies = 2 + static_cast<int>(seed % 7);
    options.flexible_share = seed % 3 * 0.5;
    options.springs = options.damping = options.loads = true;
    options.tyres = seed % 5 == 0;
    EXPECT_LE(distance_from_index3(random_mechanism(seed, options).model, 1e-3, 60), 1e-10) << seed;
  }
}

/// A chain along x of rigid links and, every third, a flexible bar, on revolute joints in turn about y and z,
/// ball joints and sliders, with springs in the joints and across three of them.
std::string chain(int links, bool floating) {
  std::string bodies = "bodies:\n", joints = "joints:\n", springs = "springs:\n";
  for (int k = 0; k < links; ++k) {
    const double at = 0.25 * k;  // exact, as nodes are found by their places
    bodies +=
        k % 3 == 2
            ? fmt::format(
                  "  link_{0}:\n    frame: {{at: [{1}, 0, 0]}}\n    flexible: {{material: soft, section: "
                  "strip, nodes: {{a: [{1}, 0, 0], b: [{2}, 0, 0]}}, bars: {{bar: {{from: a, to: b, "
                  "elements: 2}}}}, clamped: [a], dynamic_modes: 3}}\n",
                  k, at, at + 0.25)
            : fmt::format("  link_{}: {{mass: 0.1, com: [{}, 0, 0.01], inertia: [1e-4, 4e-4, 4e-4]}}\n", k,
                          at + 0.125);
    std::string joint =
        fmt::format("revolute, axis: [0, {}, {}], spring: {{stiffness: 3, damping: 0.02}}", k % 2, 1 - k % 2);
    if (k % 4 == 2) joint = "spherical";
    if (k % 7 == 5) joint = "prismatic, axis: [0.8, 0, 0.6], spring: {stiffness: 400, damping: 2}";
    if (k == 0 && floating) joint = "floating, velocity: [0.5, 0, 0.2, 0, 1, 0]";
    joints += fmt::format("  joint_{}: {{type: {}, between: [{}, link_{}], at: [{}, 0, 0]}}\n", k, joint,
                          k == 0 ? "ground" : fmt::format("link_{}", k - 1), k, at);
    if (k >= 4 && k % 3 == 1)
      springs += fmt::format(
          "  across_{0}: {{between: [link_{1}, link_{0}], at: [[{2}, 0, 0.1], [{3}, 0, 0.1]], "
          "elastic: {{stiffness: 60, zero: 0.7}}, damping: 0.5}}\n",
          k, k - 3, at - 0.7, at + 0.05);
  }
  springs += fmt::format(
      "  end: {{between: [ground, link_{}], at: [[{}, 0, 2], [{}, 0, 0]], elastic: {{stiffness: 30, zero: "
      "1.8}}, "
      "damping: 0.5}}\n",
      links - 1, 0.25 * links, 0.25 * links);
  return "materials: {soft: {young: 2e10, poisson: 0.3, density: 1500}}\n"
         "sections: {strip: {area: 6e-5, Iy: 2e-10, Iz: 5e-10, J: 4e-10}}\n" +
         bodies + joints + springs;
}

TEST(TransferChains, MoveChainsAsIndexThree) {
  for (const bool floating : {false, true})
    for (const int links : {5, 20, 61})
      EXPECT_LE(distance_from_index3(model_of(chain(links, floating)), 1e-3, 100), 1e-10 * links)
          << links << floating;
}

/// Loops and constraints of every kind, elements on several bodies at once, flexible bodies and a tyre.
TEST(TransferChains, MoveLoopsAsIndexThree) {
  const std::pair<const char*, std::shared_ptr<const Model>> models[] = {
      {"slider-crank", example("slider-crank/slider-crank.yaml")},
      {"suspension", example("iltis/suspension.yaml")},
      {"vehicle", example("iltis/vehicle.yaml")},
      {"four-bars", example("double-four-bar/mechanism.yaml")},
      {"geared four-bar", geared_four_bar()},
      {"controlled four-bar", controlled_four_bar()},
      {"constraints", every_constraint()}};
  for (const auto& [name, model] : models) {
    ASSERT_GT(model->compiled().equations, 0);
    EXPECT_LE(distance_from_index3(model, 1e-3, 100), 1e-7) << name;
  }
}

/// Forces of constraints and accelerations have all digits, whatever the penalty.
TEST(TransferChains, FindForcesOfConstraintsAsIndexThree) {
  const std::pair<const char*, std::shared_ptr<const Model>> models[] = {
      {"delta robot", example("delta-robot/model.yaml")},
      {"Stewart platform", example("stewart-platform/model.yaml")},
      {"suspension", example("iltis/suspension.yaml")},
      {"constraints", every_constraint()}};
  for (const auto& [name, model] : models) {
    const auto end = [&](Formalism formalism, double penalty) {
      RunOptions options;
      options.formalism = formalism;
      options.step = 1e-3;
      options.tolerance = 1e-11;
      spec::Model with = model->spec();
      with.simulation.penalty = penalty;
      Simulation simulation(Model::compile(std::move(with)), options);
      for (int k = 0; k < 50; ++k) EXPECT_TRUE(simulation.step().ok()) << name;
      return simulation.save();
    };
    const Simulation::Snapshot exact = end(Formalism::index3, 1e7);
    for (const double penalty : {1e4, 1e7, 1e9}) {
      const Simulation::Snapshot found = end(Formalism::transfer_matrices, penalty);
      EXPECT_LE((found.multipliers - exact.multipliers).norm(), 1e-6 * exact.multipliers.norm())
          << name << ' ' << penalty;
      EXPECT_LE((found.a - exact.a).norm(), 1e-6 * exact.a.norm()) << name << ' ' << penalty;
    }
  }
}

/// A drive of a joint is an equation of its own coordinate.
TEST(TransferChains, FollowDrives) {
  std::string text = chain(20, false);
  const std::string spring = "spring: {stiffness: 3, damping: 0.02}";
  text.replace(text.find(spring, text.find("joint_1:")), spring.size(),
               "drive: {position: \"0.3*sin(5*t)\"}");
  const auto model = model_of(text);
  ASSERT_EQ(model->compiled().drives.size(), 1u);
  EXPECT_LE(distance_from_index3(model, 1e-3, 100), 1e-10);
}

/// A chain between two points: its last joint is cut, and its forces pass all others.
TEST(TransferChains, HoldAChainAtBothEnds) {
  std::string text = chain(24, false);
  text.insert(text.find("springs:"),
              "  last: {type: spherical, between: [ground, link_23], at: [6, 0, 0], cut: always}\n");
  const auto model = model_of(text);
  ASSERT_EQ(model->compiled().equations, 3);
  EXPECT_LE(distance_from_index3(model, 1e-3, 100), 1e-7);
}

/// Without dampers the trapezoidal rule keeps the energy to the second order of its step.
TEST(TransferChains, KeepTheEnergy) {
  std::string text = chain(12, false);
  for (const auto& [damped, undamped] : {std::pair(", damping: 0.02}", "}"), std::pair(", damping: 2}", "}"),
                                         std::pair(", damping: 0.5}", "}")})
    for (auto at = text.find(damped); at != std::string::npos; at = text.find(damped))
      text.replace(at, std::string(damped).size(), undamped);
  const auto model = model_of(text);
  double left[2], at_play = 0;
  for (const int k : {0, 1}) {
    Simulation s = simulation(model, Formalism::transfer_matrices, 5e-4 / (1 << k),
                              spec::Simulation::Integrator::newmark);
    run_to(s, 0.4);
    left[k] = std::abs(s.energy().numerical);
    at_play = s.energy().kinetic;
  }
  EXPECT_GT(at_play, 0.1);
  EXPECT_LT(left[1], 1e-3 * at_play);
  EXPECT_LT(left[1], 0.35 * left[0]);
}

std::string refusal(const std::function<void()>& make) {
  try {
    make();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(TransferChains, AreRefusedByName) {
  EXPECT_THAT(refusal([] {
                RunOptions options;
                options.formalism = Formalism::transfer_matrices;
                options.formulation = Formulation::natural;
                Simulation s(model_of(chain(3, false)), options);
              }),
              HasSubstr("natural coordinates have no joint coordinates"));
  EXPECT_THAT(
      refusal([] {
        simulation(example("../bench/swarm.yaml", {{"layers", "1"}}), Formalism::transfer_matrices, 1e-3);
      }),
      HasSubstr("formalism transfer_matrices: contact '"));
  EXPECT_THAT(refusal([] {
                std::string text = chain(3, false);
                text.insert(text.find("    flexible:"), "    flexibility: elastodynamics\n");
                simulation(model_of(text), Formalism::transfer_matrices, 1e-3);
              }),
              HasSubstr("bends by elastodynamics, which needs formalism: index3"));
  EXPECT_THAT(refusal([] {
                simulation(model_of(chain(3, false)), Formalism::transfer_matrices, 1e-3,
                           spec::Simulation::Integrator::rk4);
              }),
              HasSubstr("explicit and has no formalism"));
}

}  // namespace
}  // namespace mimbre::test::transfer_chains_test
