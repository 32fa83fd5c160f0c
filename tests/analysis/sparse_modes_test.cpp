#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "mimbre/campbell.h"
#include "mimbre/modes.h"
#include "support/models.h"

/// The lowest modes of large mechanisms: closed forms, and the dense solver.
namespace mimbre::test::sparse_modes_test {
namespace {

/// A row of n bodies on bushings between two walls: six coordinates each, damped, joined to the next.
std::string row(int n, double damping) {
  std::string text = "gravity: [0, 0, -9.81]\nbodies:\n";
  for (int k = 0; k < n; ++k)
    text += fmt::format("  b{}: {{mass: {}, com: [{}, 0, 0], inertia: [0.02, 0.03, 0.04]}}\n", k,
                        1 + 0.1 * (k % 3), k);
  text += "joints:\n";
  for (int k = 0; k < n; ++k) text += fmt::format("  f{0}: {{type: floating, between: [ground, b{0}]}}\n", k);
  text += "bushings:\n";
  for (int k = 0; k <= n; ++k)
    text += fmt::format(
        "  m{}: {{between: [{}, {}], at: [{}, 0, 0], stiffness: [1e5, 4e4, 7e4, 300, 200, 500], damping: "
        "[{}, {}, {}, "
        "{}, {}, {}]}}\n",
        k, k == 0 ? "ground" : fmt::format("b{}", k - 1), k == n ? "ground" : fmt::format("b{}", k), k - 0.5,
        100 * damping, 40 * damping, 70 * damping, 0.3 * damping, 0.2 * damping, 0.5 * damping);
  return text;
}

/// n rods that hang one from the other.
std::string chain(int n) {
  const double l = 1.0 / n, m = 1.0 / n;
  std::string text = "gravity: [0, 0, -9.81]\nbodies:\n";
  for (int k = 0; k < n; ++k)
    text += fmt::format(
        "  b{0}: {{mass: {1:.17g}, com: [0, 0, {2:.17g}], inertia: [{3:.17g}, {3:.17g}, {3:.17g}]}}\n", k, m,
        -(k + 0.5) * l, m * l * l / 12);
  text += "joints:\n";
  for (int k = 0; k < n; ++k)
    text +=
        fmt::format("  j{}: {{type: revolute, between: [{}, b{}], at: [0, 0, {:.17g}], axis: [0, 1, 0]}}\n",
                    k, k == 0 ? "ground" : fmt::format("b{}", k - 1), k, -k * l);
  return text;
}

LinearisedModes modes_of(const std::string& text, ModesSolver solver, int most) {
  ModesOptions options;
  options.most = most;
  options.solver = solver;
  return find_modes(model_of(text), options);
}

void expect_same(const std::string& text, int most, double tolerance) {
  const LinearisedModes dense = modes_of(text, ModesSolver::dense, most),
                        sparse = modes_of(text, ModesSolver::sparse, most);
  EXPECT_TRUE(sparse.sparse);
  ASSERT_GE(sparse.modes.size(), dense.modes.size());
  for (std::size_t k = 0; k < dense.modes.size(); ++k) {
    const Mode &a = dense.modes[k], &b = sparse.modes[k];
    EXPECT_EQ(a.kind, b.kind) << k;
    EXPECT_NEAR(std::abs(a.value - b.value), 0, tolerance * std::abs(a.value))
        << k << ' ' << a.value << ' ' << b.value;
  }
}

/// Where many coordinates share a mode their number says more than the first of them.
TEST(SparseModes, SayHowManyShareThem) {
  const LinearisedModes found = modes_of(row(67, 0), ModesSolver::dense, 1);
  ASSERT_EQ(found.modes.size(), 1u);
  EXPECT_THAT(found.modes[0].text, testing::ContainsRegex("others with [0-9.]+ %"));
}

TEST(SparseModes, SayWhereNothingCanMove) {
  try {
    modes_of(R"(
bodies: {a: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {j: {type: fixed, between: [ground, a], at: [0, 0, 0]}}
)",
             ModesSolver::sparse, 4);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("nothing can move"));
  }
}

/// Without gravity what is left of forces that balance is compared with these.
TEST(SparseModes, TakeForcesThatBalanceForAnEquilibrium) {
  const std::string held = R"(
gravity: [0, 0, 0]
bodies: {a: {mass: 1, com: [0, 0, 0], inertia: [0.01, 0.02, 0.03]}}
joints: {r: {type: revolute, between: [ground, a], at: [0, 0, 0], axis: [0, 0, 1]}}
)",
                    moment = "loads: {l: {on: a, at: [0, 0, 0], moment: [0, 0, 2]}}\n",
                    bushing =
                        "bushings: {b: {between: [ground, a], at: [0, 0, 0], stiffness: [1, 1, 1, 1, 1, "
                        "2]}}\n",
                    torque = "actuators: {m: {joint: r, torque: 2}}\n";
  std::string spring = held;
  spring.replace(spring.rfind("}}"), 1, ", spring: {stiffness: 2}}");
  for (const std::string& text : {spring + moment, spring + torque, held + bushing + moment}) {
    SCOPED_TRACE(text);
    EXPECT_TRUE(modes_of(text, ModesSolver::dense, 3).model.warnings.empty());
    expect_same(text, 3, 1e-9);
  }
}

/// Asked for more modes than there are motions they are those of the motions, though equations bring
/// directions without inertia.
TEST(SparseModes, AreNoMoreThanTheMotions) {
  const std::string held = R"(
gravity: [0, 0, -9.81]
bodies:
  a: {mass: 0.9, com: [-0.6, 0.4, -0.4], inertia: [0.02, 0.04, 0.03]}
  b: {mass: 0.5, com: [-0.5, 0.8, -0.3], inertia: [0.01, 0.009, 0.006]}
joints:
  floor: {type: planar, between: [ground, a], at: [-0.4, 0.5, -0.3], axis: [0.64, -0.6, 0.48]}
  slide: {type: prismatic, between: [a, b], at: [-0.4, 0.7, -0.5], axis: [-0.2, 0.95, 0.2],
          spring: {stiffness: 200, damping: 4}}
constraints:
  close: {type: perpendicular, between: [ground, b], axis: [0.4, -0.9, -0.07], axis2: [0.52, 0.17, 0.84]}
bushings:
  on_a: {between: [ground, a], at: [-0.6, 0.4, -0.4], stiffness: [480, 740, 800, 27, 29, 10],
         damping: [1, 1, 1, 0.05, 0.05, 0.05]}
  on_b: {between: [ground, b], at: [-0.5, 0.8, -0.3], stiffness: [620, 690, 420, 24, 12, 22],
         damping: [1, 1, 1, 0.05, 0.05, 0.05]}
)";
  const LinearisedModes dense = modes_of(held, ModesSolver::dense, 0);
  for (const int most : {2, 3, 5, 12, 100}) {
    const LinearisedModes sparse = modes_of(held, ModesSolver::sparse, most);
    ASSERT_EQ(sparse.modes.size(), std::min<std::size_t>(static_cast<std::size_t>(most), dense.modes.size()));
    for (std::size_t k = 0; k < sparse.modes.size(); ++k)
      EXPECT_NEAR(std::abs(sparse.modes[k].value - dense.modes[k].value), 0,
                  1e-8 * std::abs(dense.modes[k].value));
  }
}

TEST(SparseModes, AreThoseOfTheDenseSolver) {
  expect_same(row(67, 0), 20, 1e-8);  // 402 coordinates
  expect_same(row(67, 1), 20, 1e-8);
  expect_same(row(10, 40), 12, 1e-8);  // real ones among them
  expect_same(chain(60), 20, 1e-8);
}

/// With what each mode consists of, and how it moves.
TEST(SparseModes, ConsistOfTheSame) {
  const LinearisedModes dense = modes_of(row(8, 0.5), ModesSolver::dense, 6),
                        sparse = modes_of(row(8, 0.5), ModesSolver::sparse, 6);
  for (std::size_t k = 0; k < dense.modes.size(); ++k) {
    EXPECT_EQ(dense.modes[k].text, sparse.modes[k].text);
    EXPECT_LE((dense.modes[k].motion - sparse.modes[k].motion).norm(), 1e-6 * dense.modes[k].motion.norm())
        << k;
    EXPECT_NEAR(dense.modes[k].gravity, sparse.modes[k].gravity, 1e-6);
  }
}

/// A hanging chain: the zeros of the Bessel function J0, ω = j/2 √(g/L).
TEST(SparseModes, OfAHangingChain) {
  const LinearisedModes found = modes_of(chain(1000), ModesSolver::automatic, 3);
  EXPECT_TRUE(found.sparse);
  const double zeros[] = {2.404825557695773, 5.520078110286311, 8.653727912911013};
  ASSERT_EQ(found.modes.size(), 3u);
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(found.modes[static_cast<std::size_t>(k)].value.imag(), zeros[k] / 2 * std::sqrt(9.81),
                2e-5 * zeros[k]);
}

/// Bodies in a plane of four equal directions have equal eigenvalues: a block finds both.
TEST(SparseModes, FindEqualEigenvalues) {
  std::string text = "gravity: [0, 0, 0]\nbodies:\n";
  const int n = 40;
  for (int k = 0; k < n; ++k)
    text += fmt::format("  b{}: {{mass: 1, com: [{}, 0, 0], inertia: [0.02, 0.03, 0.03]}}\n", k, k);
  text += "joints:\n";
  for (int k = 0; k < n; ++k) text += fmt::format("  f{0}: {{type: floating, between: [ground, b{0}]}}\n", k);
  text += "bushings:\n";
  for (int k = 0; k < n; ++k)
    text += fmt::format(
        "  m{0}: {{between: [{1}, b{0}], at: [{2}, 0, 0], stiffness: [1e5, 4e4, 4e4, 300, 200, 200]}}\n", k,
        k == 0 ? "ground" : fmt::format("b{}", k - 1), k - 0.5);
  const LinearisedModes found = modes_of(text, ModesSolver::sparse, 10);
  ASSERT_EQ(found.modes.size(), 10u);
  for (const int k : {0, 2}) {
    const double one = found.modes[static_cast<std::size_t>(k)].value.imag(),
                 two = found.modes[static_cast<std::size_t>(k) + 1].value.imag();
    EXPECT_NEAR(one, two, 1e-8 * one);
  }
  expect_same(text, 10, 1e-8);
}

/// Bodies of one kind on equal springs, in groups.
std::string alike(const std::vector<double>& stiffness, int copies, double damping = 0) {
  std::string bodies = "gravity: [0, 0, 0]\nbodies:\n", joints = "joints:\n";
  int n = 0;
  for (const double k : stiffness)
    for (int copy = 0; copy < copies; ++copy, ++n) {
      bodies += fmt::format("  b{}: {{mass: 2, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}}\n", n);
      joints += fmt::format(
          "  j{0}: {{type: prismatic, between: [ground, b{0}], at: [{0}, 0, 0], axis: [0, 0, 1], spring: "
          "{{stiffness: {1}, damping: {2}}}}}\n",
          n, k, damping);
    }
  return bodies + joints;
}

/// ω = √(k/m), ten times each: more than a block has columns.
TEST(SparseModes, FindManyEqualEigenvalues) {
  for (const int most : {3, 12, 29, 30}) {
    const LinearisedModes found = modes_of(alike({200, 800, 1800}, 10), ModesSolver::sparse, most);
    ASSERT_EQ(std::ssize(found.modes), most);
    for (int k = 0; k < most; ++k) {
      const double omega = 10 * (1 + k / 10);
      EXPECT_NEAR(std::abs(found.modes[static_cast<std::size_t>(k)].value.imag()), omega, 1e-8 * omega) << k;
    }
  }
}

/// What is slow because it is soft, or because it is damped strongly, is not a rigid motion.
TEST(SparseModes, SlowOnesAreNotRigid) {
  std::string text = alike({1e4, 2e4, 3e4, 4e4, 5e4, 6e4}, 1);
  text +=
      "  soft: {type: prismatic, between: [ground, s], at: [0, 1, 0], axis: [0, 0, 1], spring: {stiffness: "
      "1e-6}}\n"
      "  slow: {type: prismatic, between: [ground, d], at: [0, 2, 0], axis: [0, 0, 1], spring: {stiffness: "
      "1, "
      "damping: 1e5}}\n"
      "  loose: {type: prismatic, between: [ground, r], at: [0, 3, 0], axis: [0, 0, 1]}\n";
  text.insert(text.find("joints:"),
              "  s: {mass: 1, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}\n  d: {mass: 1, com: [0, 0, 0], "
              "inertia: [0.1, 0.1, 0.1]}\n"
              "  r: {mass: 1, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}\n");
  const LinearisedModes found = modes_of(text, ModesSolver::sparse, 5);
  ASSERT_EQ(found.modes.size(), 5u);
  EXPECT_EQ(found.modes[0].kind, Mode::Kind::rigid);
  EXPECT_EQ(found.modes[1].kind, Mode::Kind::real);
  EXPECT_NEAR(found.modes[1].value.real(), -1e-5, 1e-9);
  EXPECT_EQ(found.modes[2].kind, Mode::Kind::oscillating);
  EXPECT_NEAR(found.modes[2].value.imag(), 1e-3, 1e-8);
  EXPECT_NEAR(found.modes[3].value.imag(), std::sqrt(1e4 / 2), 1e-6);
  EXPECT_NEAR(found.modes[4].value.imag(), std::sqrt(2e4 / 2), 1e-6);
}

/// A closed loop of one freedom has one mode, however many are asked for.
/// Six rigid motions of a free corotational beam, however finely it is divided, then ω = (β L)² √(EI/ρA)/L²,
/// β L = 4.73004 and 7.85320 of a free beam, about both axes (sides of 20 and 10 mm).
TEST(SparseModes, OfAFreeBeam) {
  for (const int elements : {10, 30, 100}) {
    ModesOptions options;
    options.linear.point.at = LinearPoint::At::start;
    options.most = 9;
    options.solver = ModesSolver::sparse;
    const LinearisedModes found = find_modes(model_of(fmt::format(R"yaml(
gravity: [0, 0, 0]
materials: {{s: {{young: 2.1e11, poisson: 0.3, density: 7850}}}}
sections: {{r: {{type: rectangle, width: 0.02, height: 0.01}}}}
bodies:
  beam:
    frame: {{at: [0, 0, 0]}}
    flexible: {{material: s, section: r, nodes: {{a: [0, 0, 0], b: [1, 0, 0]}}, bars: {{all: {{from: a, to: b, elements: {}}}}}, clamped: [a], beam: corotational}}
)yaml",
                                                                  elements)),
                                             options);
    ASSERT_EQ(found.modes.size(), 9u) << elements;
    const double pace = std::sqrt(2.1e11 / 7850 / 12);
    const std::array<double, 3> bending{0.01 * 4.73004 * 4.73004 * pace, 0.02 * 4.73004 * 4.73004 * pace,
                                        0.01 * 7.85320 * 7.85320 * pace};
    for (std::size_t k = 0; k < 9; ++k) {
      if (k < 6) {
        EXPECT_EQ(found.modes[k].kind, Mode::Kind::rigid) << elements << ' ' << k;
        EXPECT_EQ(found.modes[k].value, 0.) << elements << ' ' << k;
      } else {
        const double published = bending[k - 6];
        EXPECT_NEAR(found.modes[k].value.imag(), published, 2e-2 * published) << elements << ' ' << k;
      }
    }
  }
}

TEST(SparseModes, OfFewerThanAreAskedFor) {
  const std::string text = R"yaml(
gravity: [0, 0, -9.81]
bodies:
  left: {mass: 1, com: [0, 0, -0.5], inertia: [0.1, 0.1, 0.1]}
  bar: {mass: 2, com: [1, 0, -1], inertia: [0.1, 0.4, 0.4]}
  right: {mass: 1, com: [2, 0, -0.5], inertia: [0.1, 0.1, 0.1]}
joints:
  a: {type: revolute, between: [ground, left], at: [0, 0, 0], axis: [0, 1, 0]}
  b: {type: revolute, between: [left, bar], at: [0, 0, -1], axis: [0, 1, 0]}
  c: {type: revolute, between: [bar, right], at: [2, 0, -1], axis: [0, 1, 0]}
  d: {type: revolute, between: [right, ground], at: [2, 0, 0], axis: [0, 1, 0]}
)yaml";
  // A swing of parallel ropes: I = 2 (0.1 + 0.25) + 2, k = g (2·0.5 + 2).
  const double omega = std::sqrt(9.81 * 3 / 2.7);
  for (const int most : {1, 14, 20}) {
    const LinearisedModes found = modes_of(text, ModesSolver::sparse, most);
    ASSERT_EQ(found.modes.size(), 1u) << most;
    EXPECT_NEAR(found.modes[0].value.imag(), omega, 1e-7 * omega);
  }
}

/// Three free bodies have eighteen rigid motions.
TEST(SparseModes, OfNothingButRigidMotions) {
  std::string text = "gravity: [0, 0, 0]\nbodies:\n";
  for (int k = 0; k < 3; ++k)
    text += fmt::format("  b{}: {{mass: 1, com: [0, 0, 0], inertia: [0.1, 0.2, 0.25]}}\n", k);
  text += "joints:\n";
  for (int k = 0; k < 3; ++k)
    text += fmt::format("  f{0}: {{type: floating, between: [ground, b{0}], at: [{0}, 0, 0]}}\n", k);
  for (const auto& [most, expected] : {std::pair{14, 14u}, {18, 18u}, {30, 18u}}) {
    const LinearisedModes found = modes_of(text, ModesSolver::sparse, most);
    ASSERT_EQ(found.modes.size(), expected);
    for (const Mode& mode : found.modes) EXPECT_EQ(mode.kind, Mode::Kind::rigid);
  }
}

/// A chain that stands on its end falls: growth e^{t j/2 √(g/L)} of each mode, slowest first.
TEST(SparseModes, OfAChainThatStandsOnItsEnd) {
  std::string text = chain(300);
  text.replace(text.find("-9.81"), 5, "9.81");
  const LinearisedModes found = modes_of(text, ModesSolver::sparse, 4);
  const double zeros[] = {2.404825557695773, 5.520078110286311};
  ASSERT_EQ(found.modes.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    const double rate = zeros[k / 2] / 2 * std::sqrt(9.81);
    EXPECT_EQ(found.modes[k].kind, Mode::Kind::real);
    EXPECT_NEAR(std::abs(found.modes[k].value.real()), rate, 1e-4 * rate);
    EXPECT_EQ(found.modes[k].grows, found.modes[k].value.real() > 0);
  }
}

/// Rigid motions come first: a chain of bodies on springs that floats freely.
TEST(SparseModes, RigidMotionsComeFirst) {
  std::string text = "gravity: [0, 0, 0]\nbodies:\n";
  const int n = 30;
  for (int k = 0; k < n; ++k)
    text += fmt::format("  b{}: {{mass: 1, com: [{}, 0, 0], inertia: [0.02, 0.03, 0.04]}}\n", k, k);
  text += "joints:\n";
  for (int k = 0; k < n; ++k) text += fmt::format("  f{0}: {{type: floating, between: [ground, b{0}]}}\n", k);
  text += "bushings:\n";
  for (int k = 1; k < n; ++k)
    text += fmt::format(
        "  m{0}: {{between: [b{1}, b{0}], at: [{2}, 0, 0], stiffness: [1e5, 4e4, 3e4, 300, 200, 250]}}\n", k,
        k - 1, k - 0.5);
  const LinearisedModes found = modes_of(text, ModesSolver::sparse, 12);
  ASSERT_EQ(found.modes.size(), 12u);
  for (int k = 0; k < 12; ++k)
    EXPECT_EQ(found.modes[static_cast<std::size_t>(k)].kind == Mode::Kind::rigid, k < 6) << k;
  expect_same(text, 12, 1e-8);
}

/// 5000 coordinates, 20 modes: those of all bodies with the same mass are cosines and sines of a row of
/// springs, ω² = 4k/m sin²(jπ/2(n + 1)) for each direction.
TEST(SparseModes, OfFiveThousandCoordinates) {
  const int n = 834;
  std::string text = "gravity: [0, 0, 0]\nbodies:\n";
  for (int k = 0; k < n; ++k)
    text += fmt::format("  b{}: {{mass: 2, com: [0, 0, 0], inertia: [0.02, 0.03, 0.04]}}\n", k);
  text += "joints:\n";
  for (int k = 0; k < n; ++k) text += fmt::format("  f{0}: {{type: floating, between: [ground, b{0}]}}\n", k);
  text += "bushings:\n";
  // All at one place: forces have no arms. Turning is stiff.
  for (int k = 0; k <= n; ++k)
    text += fmt::format(
        "  m{}: {{between: [{}, {}], at: [0, 0, 0], stiffness: [1e5, 4e4, 7e4, 3e3, 4e3, 5e3]}}\n", k,
        k == 0 ? "ground" : fmt::format("b{}", k - 1), k == n ? "ground" : fmt::format("b{}", k));
  const LinearisedModes found = modes_of(text, ModesSolver::automatic, 20);
  EXPECT_TRUE(found.sparse);
  std::vector<double> expected;
  for (const double square : {1e5 / 2, 4e4 / 2, 7e4 / 2, 3e3 / 0.02, 4e3 / 0.03, 5e3 / 0.04})
    for (int j = 1; j <= 20; ++j)
      expected.push_back(2 * std::sqrt(square) * std::sin(j * std::numbers::pi / (2 * (n + 1))));
  std::sort(expected.begin(), expected.end());
  ASSERT_EQ(found.modes.size(), 20u);
  for (std::size_t k = 0; k < 20; ++k)
    EXPECT_NEAR(found.modes[k].value.imag(), expected[k], 1e-8 * expected[k]) << k;
}

TEST(SparseModes, NamesWhatItCannotDo) {
  const std::string text =
      "bodies: {a: {mass: 1, com: [0.5, 0, 0], inertia: [0.1, 0.1, 0.1]}}\n"
      "joints: {j: {type: revolute, between: [ground, a], at: [0, 0, 0], axis: [0, 1, 0], spring: "
      "{stiffness: 50}}}\n"
      "frictions: {f: {joint: j, torque: 1}}\n";
  const auto message = [&](int most) -> std::string {
    try {
      modes_of(text, ModesSolver::sparse, most);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message(3), testing::HasSubstr("force elements with states"));
  EXPECT_THAT(message(0), testing::HasSubstr("--most"));
}

/// Right and left vectors, whose products are those of modes of one pencil; not symmetric where a force
/// follows the body that it acts on.
TEST(SparseModes, HaveLeftVectors) {
  for (const std::string& text :
       {row(8, 0), row(8, 5), chain(30),
        row(8, 0.5) + "loads:\n  f: {on: b3, at: [3, 0, 0.1], force: [900, 500, 0], follower: true}\n"}) {
    const LinearisedModes found = modes_of(text, ModesSolver::sparse, 8);
    for (const Mode& a : found.modes)
      for (const Mode& b : found.modes) EXPECT_NEAR(std::abs(a.left.dot(b.shape)), &a == &b ? 1 : 0, 1e-7);
  }
}

/// The lowest modes over a stiffness, of which some cross and leave the lowest ones: the same branches as by
/// all modes of dense matrices, and each one analytic where that is known.
TEST(SparseModes, AreFollowedOverAParameter) {
  const auto by = [](double lateral, ModesSolver solver) {
    // Two rows of bodies beside each other, of which one becomes stiffer.
    std::string text = "gravity: [0, 0, 0]\nbodies:\n", joints = "joints:\n", springs = "bushings:\n";
    for (int r = 0; r < 2; ++r)
      for (int k = 0; k < 20; ++k) {
        const std::string name = fmt::format("b{}_{}", r, k);
        text += fmt::format("  {}: {{mass: 1, com: [{}, {}, 0], inertia: [0.02, 0.03, 0.04]}}\n", name, k, r);
        joints += fmt::format(
            "  j{0}: {{type: prismatic, between: [ground, {0}], at: [{1}, {2}, 0], axis: [1, 0, 0]}}\n", name,
            k, r);
        springs += fmt::format(
            "  m{}: {{between: [{}, {}], at: [{}, {}, 0], stiffness: [{}, 1e3, 1e3, 9, 9, 9]}}\n", name,
            k == 0 ? "ground" : fmt::format("b{}_{}", r, k - 1), name, k - 0.5, r, r == 0 ? 1000 : lateral);
      }
    return modes_of(text + joints + springs, solver, with_neighbours(4));
  };
  EXPECT_EQ(one_solver(by, 100, 4000, ModesSolver::automatic), ModesSolver::dense);  // it is small
  CampbellOptions options;
  options.parameter = "stiffness";
  options.rad_per_second = 0;
  options.most = 4;
  const std::vector<double> values = {100, 400, 900, 1700, 3000, 4000};
  const auto diagram = [&](ModesSolver solver) {
    return campbell([&](double value) { return by(value, solver); }, values, options);
  };
  const CampbellDiagram sparse = diagram(ModesSolver::sparse), dense = diagram(ModesSolver::dense);
  EXPECT_TRUE(sparse.warnings.empty());
  ASSERT_EQ(sparse.branches.size(), dense.branches.size());
  // Along 20 bodies that are fixed at one end: ω = 2 √(k/m) sin((2 i − 1) π/82).
  int constant = 0, rising = 0;
  for (const ModeBranch& branch : sparse.branches) {
    bool fixed = false, rises = false;
    for (int i = 1; i <= 8; ++i) {
      const double c = 2 * std::sin((2 * i - 1) * std::numbers::pi / 82);
      bool is_fixed = true, is_rising = true;
      for (std::size_t k = 0; k < values.size(); ++k) {
        const double w = branch.values[k].imag();
        if (std::isnan(w)) continue;
        is_fixed = is_fixed && std::abs(w - c * std::sqrt(1000)) < 1e-7 * w;
        is_rising = is_rising && std::abs(w - c * std::sqrt(values[k])) < 1e-7 * w;
      }
      fixed = fixed || is_fixed;
      rises = rises || is_rising;
    }
    EXPECT_TRUE(fixed || rises) << branch.name;
    constant += fixed ? 1 : 0;
    rising += rises ? 1 : 0;
  }
  EXPECT_GE(constant, 3);
  EXPECT_GE(rising, 3);
}

}  // namespace
}  // namespace mimbre::test::sparse_modes_test
