#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "mimbre/modes.h"
#include "mimbre/statics.h"
#include "support/models.h"

/// Chains that hang: equilibria of up to a thousand links, far from where they are drawn.
namespace mimbre::test::chain_statics_test {
namespace {

constexpr double length = 1.2, span = 1, mass = 1, gravity = 9.81;

enum class Drawn { vee, tent, line };

/// n rods of a chain between (0, 0, 0) and (1, 0, 0), or at one end (line), drawn straight in two halves.
std::string chain(int n, Drawn drawn, const std::string& more = {}) {
  const double h = std::sqrt(length * length - span * span) / 2 * (drawn == Drawn::tent ? 1 : -1),
               l = length / n;
  const auto x = [&](int k) { return drawn == Drawn::line ? k * l : span * k / n; };
  const auto z = [&](int k) {
    const double t = static_cast<double>(k) / n;
    return drawn == Drawn::line ? 0.0 : h * 2 * std::min(t, 1 - t);
  };
  std::string text = "gravity: [0, 0, -9.81]\nbodies:\n";
  for (int k = 0; k < n; ++k) {
    const double m = mass / n, i = m * l * l / 12;
    text += fmt::format(
        "  b{}: {{mass: {:.17g}, com: [{:.17g}, 0, {:.17g}], inertia: [{:.17g}, {:.17g}, {:.17g}]}}\n", k, m,
        (x(k) + x(k + 1)) / 2, (z(k) + z(k + 1)) / 2, i, i, i);
  }
  text += "joints:\n";
  const int last = drawn == Drawn::line ? n - 1 : n;
  for (int k = 0; k <= last; ++k)
    text += fmt::format(
        "  j{}: {{type: revolute, between: [{}, {}], at: [{:.17g}, 0, {:.17g}], axis: [0, 1, 0]}}\n", k,
        k == 0 ? "ground" : fmt::format("b{}", k - 1), k == n ? "ground" : fmt::format("b{}", k), x(k), z(k));
  text += fmt::format(
      "outputs:\n  - {{name: lowest, position: b{}, component: z}}\n  - {{name: fx, joint_force: j0, "
      "component: fx}}\n  "
      "- {{name: fz, joint_force: j0, component: fz}}\n",
      drawn == Drawn::line ? n - 1 : n / 2);
  return text + more;
}

double value_of(const StaticResult& r, const std::string& channel) {
  for (std::size_t k = 0; k < r.channels.size(); ++k)
    if (r.channels[k].name == channel) return r.values[static_cast<Eigen::Index>(k)];
  ADD_FAILURE() << "no channel " << channel;
  return std::nan("");
}

/// Rods in equilibrium: the tangent of rod k is what its middle carries of the weight, over the horizontal
/// force H, for which the span is right.
struct RodChain {
  double force = 0, lowest_middle = 0;
};
RodChain exact(int n) {
  const double l = length / n, w = mass * gravity / n;
  const auto slope = [&](int k, double H) { return (n / 2.0 - k - 0.5) * w / H; };
  double low = 1e-3, high = 1e3;
  for (int i = 0; i < 200; ++i) {
    const double H = std::sqrt(low * high);
    double x = 0;
    for (int k = 0; k < n; ++k) x += l / std::hypot(1, slope(k, H));
    (x < span ? low : high) = H;
  }
  RodChain out{low, 0};
  for (int k = 0; k <= n / 2; ++k) {
    const double s = slope(k, low), dz = -l * s / std::hypot(1, s);
    out.lowest_middle += k == n / 2 ? dz / 2 : dz;
  }
  return out;
}

class HangingChains : public ::testing::TestWithParam<int> {};

TEST_P(HangingChains, BetweenTwoPointsAsRodsInEquilibrium) {
  const int n = GetParam();
  for (const Drawn drawn : {Drawn::vee, Drawn::tent}) {
    const StaticResult r = static_equilibrium(model_of(chain(n, drawn)));
    const RodChain rods = exact(n);
    EXPECT_TRUE(r.sparse || n <= 150);
    EXPECT_NEAR(value_of(r, "fx"), -rods.force, 1e-7 * rods.force);
    EXPECT_NEAR(value_of(r, "fz"), mass * gravity / 2, 1e-7 * mass * gravity);
    EXPECT_NEAR(value_of(r, "lowest"), rods.lowest_middle, 1e-8);
    EXPECT_TRUE(r.stable);
  }
}

TEST_P(HangingChains, AtOneEndStraightDown) {
  const int n = GetParam();
  const StaticResult r = static_equilibrium(model_of(chain(n, Drawn::line)));
  EXPECT_NEAR(value_of(r, "lowest"), -length * (n - 0.5) / n, 1e-9);
  EXPECT_NEAR(value_of(r, "fz"), mass * gravity, 1e-7 * mass * gravity);
  EXPECT_TRUE(r.stable);
}

INSTANTIATE_TEST_SUITE_P(Links, HangingChains, ::testing::Values(10, 100, 1000));

/// A thousand rods are a catenary: length 2 a sinh(1/2a), sag a (cosh(1/2a) − 1), H = a times the weight per
/// length.
TEST(Catenary, OfAThousandLinks) {
  double low = 0.1, high = 10;
  for (int i = 0; i < 200; ++i) {
    const double a = (low + high) / 2;
    (2 * a * std::sinh(span / 2 / a) > length ? low : high) = a;
  }
  const double a = low;
  for (const auto formulation :
       {spec::Simulation::Formulation::relative, spec::Simulation::Formulation::natural}) {
    RunOptions options;
    options.formulation = formulation;
    const StaticResult r = static_equilibrium(model_of(chain(1000, Drawn::vee)), options);
    EXPECT_NEAR(value_of(r, "fx"), -a * mass * gravity / length, 2e-6 * mass * gravity);
    EXPECT_NEAR(value_of(r, "lowest"), -a * (std::cosh(span / 2 / a) - 1), 2e-6);
    EXPECT_LT(r.cpu_seconds, 20);
  }
}

/// A strip that its weight bends by a seventh of its length, stiff against stretch: a few of Newton's steps,
/// however fine it is divided.
TEST(ChainStatics, SlenderBeamsAreFoundByFewSteps) {
  const auto hang = [](int elements) {
    return static_equilibrium(model_of(fmt::format(R"(
gravity: [0, 0, -9.81]
materials: {{s: {{young: 2.1e11, poisson: 0.3, density: 7850}}}}
sections: {{r: {{type: rectangle, width: 0.02, height: 0.002}}}}
bodies:
  beam:
    frame: {{at: [0, 0, 0]}}
    flexible: {{material: s, section: r, nodes: {{a: [0, 0, 0], b: [1, 0, 0]}}, clamped: [a], beam: corotational,
               bars: {{all: {{from: a, to: b, elements: {}}}}}}}
joints: {{f: {{type: fixed, between: [ground, beam], at: [0, 0, 0]}}}}
outputs: [{{name: z, position: beam.b, component: z}}]
)",
                                                   elements)));
  };
  const StaticResult coarse = hang(15), fine = hang(80);
  EXPECT_TRUE(fine.sparse);
  EXPECT_LT(fine.iterations, 20);
  EXPECT_TRUE(fine.stable);
  EXPECT_LT(value_of(fine, "z"), -0.09);
  EXPECT_NEAR(value_of(fine, "z"), value_of(coarse, "z"), 1e-4);
}

/// Rods that stand one on another, held by springs that are too weak: straight is an unstable equilibrium.
/// Natural coordinates take the sparse search, relative ones the dense one; both find the same growth.
TEST(Rods, StandUnstably) {
  const int n = 60;
  const double l = 1.0 / n, inertia = l * l / n / 12;
  std::string text = "gravity: [0, 0, -9.81]\nbodies:\n";
  for (int k = 0; k < n; ++k)
    text += fmt::format(
        "  b{0}: {{mass: {1:.17g}, com: [0, 0, {2:.17g}], inertia: [{3:.17g}, {3:.17g}, {3:.17g}]}}\n", k,
        1.0 / n, (k + 0.5) * l, inertia);
  text += "joints:\n";
  for (int k = 0; k < n; ++k)
    text += fmt::format(
        "  j{}: {{type: revolute, between: [{}, b{}], at: [0, 0, {:.17g}], axis: [0, 1, 0], spring: "
        "{{stiffness: "
        "{}}}}}\n",
        k, k == 0 ? "ground" : fmt::format("b{}", k - 1), k, k * l, n);
  text += "outputs:\n  - {name: top, position: b0, component: z}\n";
  ModesOptions at_start;
  at_start.linear.point.at = LinearPoint::At::start;
  const LinearisedModes modes = find_modes(model_of(text), at_start);
  double growth = 0;
  for (const Mode& mode : modes.modes) growth = std::max(growth, mode.value.real());
  RunOptions options;
  options.formulation = spec::Simulation::Formulation::natural;
  const StaticResult r = static_equilibrium(model_of(text), options);
  EXPECT_TRUE(r.sparse);
  EXPECT_FALSE(r.stable);
  ASSERT_EQ(r.warnings.size(), 1u);
  EXPECT_NE(r.warnings[0].find(fmt::format("by e in {:.3g} s", 1 / growth)), std::string::npos)
      << r.warnings[0];
}

/// A moment that rolls a strip of 16 rods and springs up into 32 turns: the direct search gives up on the
/// way, and the moment is applied in steps. Every spring has the same moment, so that all angles are known.
TEST(ChainStatics, LoadStepsRollAStripUp) {
  constexpr int n = 16;
  constexpr double moment = -200, l = 1.0 / n;
  std::string text = "gravity: [0, 0, 0]\nbodies:\n", joints = "joints:\n", springs = "torsion_springs:\n";
  for (int k = 0; k < n; ++k) {
    text += fmt::format("  b{}: {{mass: 0.01, com: [{}, 0, 0], inertia: [1e-5, 1e-5, 1e-5]}}\n", k,
                        (k + 0.5) * l);
    joints += fmt::format("  j{}: {{type: revolute, between: [{}, b{}], at: [{}, 0, 0], axis: [0, 1, 0]}}\n",
                          k, k == 0 ? "ground" : fmt::format("b{}", k - 1), k, k * l);
    springs += fmt::format("  s{0}: {{coordinates: [{{joint: j{0}}}], stiffness: {1}}}\n", k, n);
  }
  const StaticResult r = static_equilibrium(
      model_of(text + joints + springs +
               fmt::format("loads:\n  end: {{on: b{0}, at: [1, 0, 0], moment: [0, {1}, 0], follower: true}}\n"
                           "outputs:\n  - {{name: x, position: b{0}, component: x}}\n"
                           "  - {{name: z, position: b{0}, component: z}}\n",
                           n - 1, moment)));
  EXPECT_GT(r.load_steps, 0);
  double x = 0, z = 0;
  for (int k = 0; k < n; ++k) {
    const double angle = (k + 1) * moment * l, part = k < n - 1 ? l : 0.5 * l;
    x += part * std::cos(angle);
    z -= part * std::sin(angle);
  }
  EXPECT_NEAR(value_of(r, "x"), x, 1e-8);
  EXPECT_NEAR(value_of(r, "z"), z, 1e-8);
}

}  // namespace
}  // namespace mimbre::test::chain_statics_test
