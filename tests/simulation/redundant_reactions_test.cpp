#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "compile/compiled.h"
#include "mimbre/simulation.h"
#include "support/models.h"

/// Reactions that rigid bodies do not determine: the smallest ones, in every formulation, whichever joint is
/// cut, and never large because something is off by round-off.
namespace mimbre::test::redundant_reactions_test {
namespace {

using Formulation = spec::Simulation::Formulation;
constexpr double g = 9.81;

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", x);
  return text;
}

/// A door of 2 kg on two hinges along y, 0.3 m apart, the second one off by `off` in x; its centre of mass
/// half a metre aside and at `middle` along the axis. Lengths in units of `unit` metres.
std::string door(double off, double middle, const std::string& cut = "", double unit = 1) {
  const auto m = [&](double x) { return number(x * unit); };
  const std::string inertia = number(0.2 * unit * unit);
  return "gravity: [0, 0, " + number(-g * unit) + "]\nbodies:\n  c: {mass: 2, com: [" + m(0.5) + ", " +
         m(middle) + ", 0], inertia: [" + inertia + ", " + inertia + ", " + number(0.1 * unit * unit) +
         "]}\njoints:\n" + "  a: {type: revolute, between: [ground, c], at: [0, 0, 0], axis: [0, 1, 0]" +
         (cut == "a" ? ", cut: always" : "") + "}\n" + "  b: {type: revolute, between: [ground, c], at: [" +
         m(off) + ", " + m(0.3) + ", 0], axis: [0, 1, 0]" + (cut == "b" ? ", cut: always" : "") + "}\n" +
         "outputs:\n"
         "  - {name: az, joint_force: a, component: fz}\n  - {name: amx, joint_force: a, component: mx}\n"
         "  - {name: bz, joint_force: b, component: fz}\n  - {name: bmx, joint_force: b, component: mx}\n"
         "  - {name: ax, joint_force: a, component: fx}\n  - {name: amz, joint_force: a, component: mz}\n"
         "  - {name: bx, joint_force: b, component: fx}\n  - {name: bmz, joint_force: b, component: mz}\n";
}

std::vector<Eigen::VectorXd> outputs(const std::shared_ptr<const Model>& model, Formulation formulation,
                                     int steps, double step = 0.01) {
  RunOptions options;
  options.step = step;
  options.formulation = formulation;
  Simulation s(model, options);
  std::vector<Eigen::VectorXd> rows;
  ResultsRow row;
  for (int k = 0;; ++k) {
    s.sample(row);
    rows.push_back(row.channels.head(s.output_count()));
    if (k == steps) return rows;
    const StepReport report = s.step();
    if (!report.ok()) {
      ADD_FAILURE() << s.explain(report);
      return rows;
    }
  }
}

class RedundantReactions : public testing::TestWithParam<Formulation> {};
INSTANTIATE_TEST_SUITE_P(Formulations, RedundantReactions,
                         testing::Values(Formulation::relative, Formulation::natural),
                         [](const auto& formulation) {
                           return formulation.param == Formulation::relative ? "relative" : "natural";
                         });

TEST_P(RedundantReactions, HingesShareTheLoad) {
  const auto model = model_of(door(0, 0.15));
  for (const Eigen::VectorXd& r : outputs(model, GetParam(), 50)) {
    const double scale = std::hypot(r[0], r[4]);
    EXPECT_NEAR(r[0], r[2], 1e-6 * scale);
    EXPECT_NEAR(r[4], r[6], 1e-6 * scale);
    for (const int moment : {1, 3, 5, 7}) EXPECT_NEAR(r[moment], 0, 1e-6 * scale);
  }
}

/// By Lagrange's multipliers: fa + fb = F and ma + mb + d fb = M (about a's place) with the least
/// fa² + fb² + (ma² + mb²) / L².
TEST_P(RedundantReactions, AreTheSmallest) {
  for (const char* const cut : {"a", "b"})
    for (const double unit : {1.0, 1e-3, 1e3}) {
      const auto model = model_of(door(0, 0.05, cut, unit));
      const double L = model->compiled().length_scale, d = 0.3 * unit;
      for (const Eigen::VectorXd& r : outputs(model, GetParam(), 30)) {
        const double F = r[0] + r[2], M = r[1] + r[3] + d * r[2];
        // fa = p, fb = p + d q, ma = mb = L² q.
        const double q = (M - d * F / 2) / (2 * L * L + d * d / 2), p = (F - d * q) / 2;
        const double size = std::abs(F);
        EXPECT_NEAR(r[0], p, 1e-6 * size) << cut << unit;
        EXPECT_NEAR(r[2], p + d * q, 1e-6 * size) << cut << unit;
        EXPECT_NEAR(r[1], L * L * q, 1e-6 * size * L) << cut << unit;
        EXPECT_NEAR(r[3], L * L * q, 1e-6 * size * L) << cut << unit;
      }
    }
}

TEST_P(RedundantReactions, DoNotDependOnRoundOff) {
  const auto exact = outputs(model_of(door(0, 0)), GetParam(), 100);
  for (const double off : {1e-15, 1e-13, 1e-12, 1e-10}) {
    const auto almost = outputs(model_of(door(off, 0)), GetParam(), 100);
    ASSERT_EQ(almost.size(), exact.size());
    for (std::size_t k = 0; k < exact.size(); ++k)
      EXPECT_LE((almost[k] - exact[k]).cwiseAbs().maxCoeff(), 1e-3) << off << " at " << k;
  }
}

/// The parallelogram lies flat: there forces along it are determined by nothing but what bodies need.
TEST_P(RedundantReactions, StayFiniteWhereALinkageLiesFlat) {
  std::string text = "bodies:\n";
  const char* const names[] = {"c", "k", "r"};
  for (int k = 0; k < 3; ++k)
    text += std::string("  ") + names[k] + ": {mass: 1, com: [" + number(0.5 + k) +
            ", 0, 0], inertia: [0.1, 0.1, 0.1]}\n";
  text +=
      "joints:\n"
      "  a: {type: revolute, between: [ground, c], at: [0, 0, 0], axis: [0, 1, 0], velocity: 1}\n"
      "  b: {type: revolute, between: [c, k], at: [1, 0, 0], axis: [0, 1, 0]}\n"
      "  d: {type: revolute, between: [ground, r], at: [2, 0, 0], axis: [0, 1, 0]}\n"
      "  e: {type: revolute, between: [k, r], at: [3, 0, 0], axis: [0, 1, 0]}\n"
      "outputs:\n  - {name: ax, joint_force: a, component: fx}\n"
      "  - {name: dx, joint_force: d, component: fx}\n";
  for (const Eigen::VectorXd& r : outputs(model_of(text), GetParam(), 20))
    EXPECT_LE(r.cwiseAbs().maxCoeff(), 300);
}

/// A parallelogram that turns evenly, without gravity, from 0.1 rad through where it lies flat: its cranks'
/// forces are finite on both sides, and there undetermined.
TEST_P(RedundantReactions, StayFiniteWhereALinkagePassesFlat) {
  const double x = std::cos(0.1), z = std::sin(0.1);
  const auto body = [&](const char* name, double at_x, double at_z) {
    return std::string("  ") + name + ": {mass: 1, com: [" + number(at_x) + ", 0, " + number(at_z) +
           "], inertia: [0.1, 0.1, 0.1]}\n";
  };
  const auto pin = [&](const char* name, const char* between, double at_x, double at_z) {
    return std::string("  ") + name + ": {type: revolute, between: [" + between + "], at: [" + number(at_x) +
           ", 0, " + number(at_z) + "], axis: [0, 1, 0]" + (*name == 'a' ? ", velocity: 1" : "") + "}\n";
  };
  const std::string text = "gravity: [0, 0, 0]\nbodies:\n" + body("c", 0.5 * x, 0.5 * z) +
                           body("k", x + 1, z) + body("r", 2 + 0.5 * x, 0.5 * z) + "joints:\n" +
                           pin("a", "ground, c", 0, 0) + pin("b", "c, k", x, z) +
                           pin("d", "ground, r", 2, 0) + pin("e", "k, r", 2 + x, z) +
                           "outputs:\n  - {name: ax, joint_force: a, component: fx}\n"
                           "  - {name: dx, joint_force: d, component: fx}\n  - {name: angle, joint: a}\n";
  const auto rows = outputs(model_of(text), GetParam(), 20);
  ASSERT_EQ(rows.size(), 21U);
  EXPECT_NEAR(rows.back()[2], 0.2, 1e-5);
  for (const Eigen::VectorXd& r : rows) {
    // Of both cranks and half of the coupler each, ω = 1 rad/s.
    EXPECT_NEAR(r[0] + r[1], -2 * std::cos(r[2] - 0.1), 1e-2);
    EXPECT_LE(std::abs(r[0] - r[1]), 0.2) << r[2];
  }
}

TEST(Redundancy, NamesTheJoints) {
  const auto redundancy = [](const std::string& text) { return Simulation(model_of(text)).redundancy(); };
  using Names = std::vector<std::string>;
  const Redundancy hinges = redundancy(door(0, 0));
  EXPECT_EQ(hinges.equations, 5);
  EXPECT_EQ(hinges.nearly, 0);
  EXPECT_EQ(hinges.joints, (Names{"a", "b"}));
  EXPECT_TRUE(hinges.nearly_joints.empty());
  const Redundancy off = redundancy(door(1e-8, 0));
  EXPECT_EQ(off.equations, 4);
  EXPECT_EQ(off.nearly, 1);
  EXPECT_EQ(off.nearly_joints, (Names{"a", "b"}));
  const Redundancy planar = redundancy(four_bar_text());
  EXPECT_EQ(planar.equations, 3);
  EXPECT_EQ(planar.joints.size(), 4U);
}

/// A spatial mechanism beside a redundant one is not concerned.
TEST(Redundancy, LeavesOthersAlone) {
  std::string text = door(0, 0);
  const std::string more =
      "  p: {mass: 1, com: [2, 0, 0], inertia: [0.1, 0.1, 0.1]}\n"
      "  q: {mass: 1, com: [3, 0, 0], inertia: [0.1, 0.1, 0.1]}\n";
  text.insert(text.find("joints:"), more);
  text.insert(text.find("outputs:"),
              "  e: {type: revolute, between: [ground, p], at: [2, 0, 0], axis: [0, 1, 0]}\n"
              "  f: {type: spherical, between: [p, q], at: [2.5, 0, 1]}\n"
              "  h: {type: spherical, between: [q, ground], at: [3.5, 1, 0.5]}\n");
  const Redundancy r = Simulation(model_of(text)).redundancy();
  EXPECT_EQ(r.joints, (std::vector<std::string>{"a", "b"}));
}

/// What is determined is not touched: the crank's drive torque and the reactions of a spatial linkage balance
/// the bodies, as before.
TEST_P(RedundantReactions, OfADriveIsItsTorque) {
  // A door on two hinges whose first one is driven: only the drive holds it against gravity.
  std::string text = door(0, 0.1);
  const std::string from = "axis: [0, 1, 0]}\n  b:";
  text.replace(text.find(from), from.size(), "axis: [0, 1, 0], drive: {position: \"0.2*sin(3*t)\"}}\n  b:");
  text += "  - {name: torque, joint_force: a, component: my}\n  - {name: angle, joint: a}\n";
  const auto rows = outputs(model_of(text), GetParam(), 40);
  for (std::size_t k = 1; k < rows.size(); ++k) {
    const double t = 0.01 * static_cast<double>(k), angle = 0.2 * std::sin(3 * t);
    const double inertia = 0.2 + 2 * 0.25, acceleration = -1.8 * std::sin(3 * t);
    EXPECT_NEAR(rows[k][9], angle, 1e-8);
    EXPECT_NEAR(rows[k][8], inertia * acceleration - 2 * g * 0.5 * std::cos(angle), 0.02);
  }
}

/// Two bars nearly in a line between two walls, with a weight where they meet: what they bear, P / (2 sin
/// angle), is large and meant, since nothing goes through the straight position.
TEST(FlatTruss, BearsWhatItsAngleAsks) {
  constexpr double rise = 1e-3, mass = 2;
  const std::string at = number(rise);
  const auto model = model_of(R"(
gravity: [0, 0, -9.81]
bodies:
  a: {mass: 1, com: [0.5, 0, )" +
                              number(rise / 2) +
                              R"(], inertia: [0.1, 0.1, 0.1]}
  b: {mass: 1, com: [1.5, 0, )" +
                              number(rise / 2) +
                              R"(], inertia: [0.1, 0.1, 0.1]}
joints:
  left: {type: revolute, between: [ground, a], at: [0, 0, 0], axis: [0, 1, 0]}
  top: {type: revolute, between: [a, b], at: [1, 0, )" +
                              at + R"(], axis: [0, 1, 0]}
  right: {type: revolute, between: [ground, b], at: [2, 0, 0], axis: [0, 1, 0]}
outputs:
  - {name: fx, joint_force: left, component: fx}
)");
  // A quarter of the weight rests on each wall's end, the other half on the joint between the bars.
  const double expected = mass / 2 * g / (2 * rise);
  for (const Formulation f : {Formulation::relative, Formulation::natural})
    for (const Eigen::VectorXd& row : outputs(model, f, 3))
      EXPECT_NEAR(std::abs(row[0]), expected, 1e-4 * expected);
}

}  // namespace
}  // namespace mimbre::test::redundant_reactions_test
