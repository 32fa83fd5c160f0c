#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

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

/// 5000 coordinates: 20 modes.
TEST(SparseModes, OfFiveThousandCoordinates) {
  const LinearisedModes found = modes_of(row(834, 0), ModesSolver::automatic, 20);
  EXPECT_TRUE(found.sparse);
  ASSERT_EQ(found.modes.size(), 20u);
  for (std::size_t k = 1; k < found.modes.size(); ++k)
    EXPECT_GE(std::abs(found.modes[k].value), std::abs(found.modes[k - 1].value) * (1 - 1e-12));
}

TEST(SparseModes, NamesWhatItCannotDo) {
  const std::string text =
      "bodies: {a: {mass: 1, com: [0.5, 0, 0], inertia: [0.1, 0.1, 0.1]}}\n"
      "joints: {j: {type: revolute, between: [ground, a], axis: [0, 1, 0], spring: {stiffness: 50}}}\n"
      "frictions: {f: {joint: j, torque: 1}}\n";
  EXPECT_THROW(modes_of(text, ModesSolver::sparse, 3), std::runtime_error);
}

}  // namespace
}  // namespace mimbre::test::sparse_modes_test
