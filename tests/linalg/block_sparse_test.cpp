#include "linalg/block_sparse.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>

#include "linalg/block_factor_impl.h"
#include "math/dual.h"
#include "math/once/decompositions.h"
#include "math/pack.h"

namespace mimbre::linalg::block_sparse_test {
namespace {

using Random = std::mt19937;

double uniform(Random& random) { return std::uniform_real_distribution<double>(-1, 1)(random); }

int below(Random& random, int n) { return std::uniform_int_distribution<int>(0, n - 1)(random); }

/// Symmetric, zero where the pattern says so. The diagonal dominates; with `indefinite` its signs vary, which
/// keeps every pivot away from zero in any order.
Eigen::MatrixXd random_matrix(const BlockPattern& pattern, bool indefinite, Random& random) {
  const BlockSymbolic symbolic(pattern);
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(symbolic.size(), symbolic.size());
  for (int i = 0; i < symbolic.blocks(); ++i)
    for (int j = 0; j <= i; ++j)
      if (symbolic.coupled(i, j))
        for (int r = symbolic.start(i); r < symbolic.start(i + 1); ++r)
          for (int c = symbolic.start(j); c < symbolic.start(j + 1); ++c) a(r, c) = a(c, r) = uniform(random);
  for (int k = 0; k < a.rows(); ++k) {
    a(k, k) = 1 + a.row(k).cwiseAbs().sum();
    if (indefinite && below(random, 2) == 0) a(k, k) = -a(k, k);
  }
  return a;
}

/// Writes through place(i, j) with i, j in the order in which `pattern` names them.
void assemble(const BlockSymbolic& symbolic, const BlockPattern& pattern, const Eigen::MatrixXd& a,
              double* values) {
  const auto write = [&](int i, int j) {
    const BlockPlace place = symbolic.place(i, j);
    for (int r = 0; r < pattern.sizes[i]; ++r)
      for (int c = 0; c < pattern.sizes[j]; ++c)
        values[place.offset + r * place.row_stride + c * place.col_stride] =
            a(symbolic.start(i) + r, symbolic.start(j) + c);
  };
  for (int i = 0; i < symbolic.blocks(); ++i) write(i, i);
  for (const auto& [i, j] : pattern.couplings) write(i, j);
}

Eigen::VectorXd solved(const BlockPattern& pattern, const Eigen::MatrixXd& a, Eigen::VectorXd x) {
  const BlockSymbolic symbolic(pattern);
  BlockFactor<double> factor(symbolic);
  factor.set_zero();
  assemble(symbolic, pattern, a, factor.values());
  EXPECT_TRUE(factor.factor().ok());
  factor.solve(x.data());
  return x;
}

BlockPattern tree_with_loops(int blocks, int loops, int least, int most, Random& random) {
  BlockPattern pattern;
  for (int i = 0; i < blocks; ++i) {
    pattern.sizes.push_back(least + below(random, most - least + 1));
    if (i == 0) continue;
    const int parent = below(random, i);
    if (below(random, 2) == 0)
      pattern.couplings.emplace_back(i, parent);
    else
      pattern.couplings.emplace_back(parent, i);
  }
  for (int i = 0; i < loops; ++i)
    pattern.couplings.emplace_back(below(random, blocks), below(random, blocks));
  return pattern;
}

BlockPattern vehicle(int arm, int axle, int link, int rod) {
  BlockPattern pattern{{6}, {}};
  for (int corner = 0; corner < 4; ++corner) {
    const int a = 4 * corner + 1;
    pattern.sizes.insert(pattern.sizes.end(), {arm, axle, link, rod});
    for (auto [i, j] : {std::pair(0, a),
                        {0, a + 1},
                        {0, a + 2},
                        {0, a + 3},
                        {a, a + 1},
                        {a, a + 2},
                        {a, a + 3},
                        {a + 1, a + 2},
                        {a + 1, a + 3}})
      pattern.couplings.emplace_back(i, j);
  }
  return pattern;
}

std::vector<BlockPattern> patterns() {
  Random random(1);
  std::vector<BlockPattern> all{
      {{}, {}},
      {{0}, {}},
      {{1}, {}},
      {{37}, {}},
      {{3, 5, 2}, {}},                                                   // disconnected
      {{4, 0, 3, 0}, {{0, 1}, {1, 2}, {3, 2}, {2, 0}, {0, 2}}},          // empty blocks, a repeated coupling
      {{6, 5, 4, 3}, {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}},  // dense
      {{2, 3, 4, 5, 6, 7}, {{0, 1}, {2, 1}, {3, 4}, {4, 5}, {5, 3}}},    // a forest with a loop
      vehicle(5, 3, 7, 8),
      vehicle(1, 3, 1, 2),
  };
  for (int n = 0; n < 60; ++n) all.push_back(tree_with_loops(2 + below(random, 25), n % 12, 0, 9, random));
  for (int n = 0; n < 20; ++n) all.push_back(tree_with_loops(2 + below(random, 40), 2 * n, 1, 1, random));
  for (int n = 0; n < 10; ++n) all.push_back(tree_with_loops(6, n, 10, 40, random));
  return all;
}

TEST(BlockSparse, SolvesLikeADenseFactorisation) {
  Random random(2);
  for (const BlockPattern& pattern : patterns()) {
    for (bool indefinite : {false, true}) {
      const Eigen::MatrixXd a = random_matrix(pattern, indefinite, random);
      if (a.rows() == 0) {
        EXPECT_EQ(solved(pattern, a, Eigen::VectorXd()).size(), 0);
        continue;
      }
      const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(a.rows(), [&] { return uniform(random); });
      const Eigen::VectorXd x = solved(pattern, a, b);
      const double scale = a.cwiseAbs().rowwise().sum().maxCoeff() * x.cwiseAbs().maxCoeff();
      EXPECT_LE((a * x - b).cwiseAbs().maxCoeff(), 1e-14 * scale);
      const Eigen::VectorXd expected = PivotedCholesky(a).solve(b);
      EXPECT_LE((x - expected).norm(), 1e-12 * expected.norm());
    }
  }
}

TEST(BlockSparse, MultipliesLikeADenseMatrix) {
  Random random(3);
  for (const BlockPattern& pattern : patterns()) {
    const Eigen::MatrixXd a = random_matrix(pattern, true, random);
    const BlockSymbolic symbolic(pattern);
    BlockFactor<double> factor(symbolic);
    factor.set_zero();
    assemble(symbolic, pattern, a, factor.values());
    const Eigen::VectorXd x = Eigen::VectorXd::NullaryExpr(a.rows(), [&] { return uniform(random); });
    Eigen::VectorXd y(a.rows());
    multiply(symbolic, factor.values(), x.data(), y.data());
    EXPECT_LE((y - a * x).norm(), 1e-14 * (1 + a.norm() * x.norm()));
  }
}

TEST(BlockSparse, PlacesOfTransposedBlocksAreTheSame) {
  for (const BlockPattern& pattern : patterns()) {
    const BlockSymbolic symbolic(pattern);
    std::set<std::ptrdiff_t> used;
    for (int i = 0; i < symbolic.blocks(); ++i) {
      for (int j = 0; j <= i; ++j) {
        EXPECT_EQ(symbolic.coupled(i, j), symbolic.coupled(j, i));
        if (!symbolic.coupled(i, j)) {
          EXPECT_THROW(symbolic.place(i, j), std::invalid_argument);
          continue;
        }
        const BlockPlace place = symbolic.place(i, j), transposed = symbolic.place(j, i);
        EXPECT_EQ(place.offset, transposed.offset);
        if (i != j) {
          EXPECT_EQ(place.row_stride, transposed.col_stride);
          EXPECT_EQ(place.col_stride, transposed.row_stride);
        }
        // Inside the array, and nothing twice.
        for (int r = 0; r < pattern.sizes[i]; ++r) {
          for (int c = 0; c < pattern.sizes[j]; ++c) {
            const std::ptrdiff_t at = place.offset + r * place.row_stride + c * place.col_stride;
            EXPECT_GE(at, 0);
            EXPECT_LT(at, symbolic.value_count());
            EXPECT_TRUE(used.insert(at).second);
          }
        }
      }
    }
  }
}

TEST(BlockSparse, ReadsOnlyTheLowerTriangleOfDiagonalBlocks) {
  Random random(4);
  for (const BlockPattern& pattern : patterns()) {
    const Eigen::MatrixXd a = random_matrix(pattern, false, random);
    Eigen::MatrixXd spoilt = a;
    const BlockSymbolic symbolic(pattern);
    for (int i = 0; i < symbolic.blocks(); ++i)
      for (int r = symbolic.start(i); r < symbolic.start(i + 1); ++r)
        for (int c = r + 1; c < symbolic.start(i + 1); ++c)
          spoilt(r, c) = std::numeric_limits<double>::quiet_NaN();
    const Eigen::VectorXd b = Eigen::VectorXd::Ones(a.rows());
    EXPECT_EQ(solved(pattern, spoilt, b), solved(pattern, a, b));
  }
}

TEST(BlockSparse, GivesTheSameBitsAgain) {
  Random random(5);
  const BlockPattern pattern = vehicle(5, 3, 7, 8);
  const Eigen::MatrixXd a = random_matrix(pattern, false, random);
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(a.rows());
  const Eigen::VectorXd expected = solved(pattern, a, b);

  const BlockSymbolic symbolic(pattern);
  BlockFactor<double> factor(symbolic);
  for (int n = 0; n < 3; ++n) {
    factor.set_zero();
    assemble(symbolic, pattern, a, factor.values());
    ASSERT_TRUE(factor.factor().ok());
    for (int again = 0; again < 2; ++again) {
      Eigen::VectorXd x = b;
      factor.solve(x.data());
      EXPECT_EQ(std::memcmp(x.data(), expected.data(), sizeof(double) * x.size()), 0);
    }
  }
}

TEST(BlockSparse, RecoversAfterAFailure) {
  const BlockPattern pattern{{3, 2}, {{0, 1}}};
  Random random(6);
  const Eigen::MatrixXd a = random_matrix(pattern, false, random);
  const BlockSymbolic symbolic(pattern);
  BlockFactor<double> factor(symbolic);
  factor.set_zero();
  assemble(symbolic, pattern, a * std::numeric_limits<double>::quiet_NaN(), factor.values());
  EXPECT_FALSE(factor.factor().ok());
  factor.set_zero();
  assemble(symbolic, pattern, a, factor.values());
  EXPECT_TRUE(factor.factor().ok());
  Eigen::VectorXd x = a * Eigen::VectorXd::Ones(5);
  factor.solve(x.data());
  EXPECT_LE((x - Eigen::VectorXd::Ones(5)).norm(), 1e-13);
}

TEST(BlockSparse, SolutionDoesNotDependOnTheNumbering) {
  Random random(7);
  for (const BlockPattern& pattern : patterns()) {
    const Eigen::MatrixXd a = random_matrix(pattern, true, random);
    const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(a.rows(), [&] { return uniform(random); });
    const Eigen::VectorXd x = solved(pattern, a, b);

    const int count = static_cast<int>(pattern.sizes.size());
    std::vector<int> renamed(count);  // old block → new block
    std::iota(renamed.begin(), renamed.end(), 0);
    std::shuffle(renamed.begin(), renamed.end(), random);
    BlockPattern other{std::vector<int>(count), {}};
    for (int i = 0; i < count; ++i) other.sizes[renamed[i]] = pattern.sizes[i];
    for (const auto& [i, j] : pattern.couplings) other.couplings.emplace_back(renamed[i], renamed[j]);
    const BlockSymbolic from(pattern), to(other);
    Eigen::PermutationMatrix<Eigen::Dynamic> p(a.rows());
    for (int i = 0; i < count; ++i)
      for (int k = 0; k < pattern.sizes[i]; ++k) p.indices()[from.start(i) + k] = to.start(renamed[i]) + k;

    const Eigen::VectorXd y = solved(other, p * a * p.transpose(), p * b);
    EXPECT_LE((p.transpose() * y - x).norm(), 1e-13 * (1 + x.norm()));
  }
}

/// The outcome where everything but one diagonal entry is the identity.
FactorStatus status_with_diagonal(const BlockPattern& pattern, int unknown, double value) {
  const BlockSymbolic symbolic(pattern);
  Eigen::MatrixXd a = Eigen::MatrixXd::Identity(symbolic.size(), symbolic.size());
  a(unknown, unknown) = value;
  BlockFactor<double> factor(symbolic);
  factor.set_zero();
  assemble(symbolic, pattern, a, factor.values());
  return factor.factor();
}

TEST(BlockSparse, NamesTheUnknownWhosePivotIsUnusable) {
  for (const BlockPattern& pattern :
       {vehicle(5, 3, 7, 8), vehicle(1, 3, 1, 2), BlockPattern{{0, 9, 4}, {{1, 2}}}}) {
    for (int unknown = 0; unknown < BlockSymbolic(pattern).size(); ++unknown) {
      EXPECT_EQ(status_with_diagonal(pattern, unknown, 0).unknown, unknown);
      for (double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
        EXPECT_EQ(status_with_diagonal(pattern, unknown, bad).unknown, unknown);
      EXPECT_TRUE(status_with_diagonal(pattern, unknown, -1).ok());
    }
  }
}

TEST(BlockSparse, NoticesASingularMatrixDuringElimination) {
  // Two equal unknowns: whichever goes first, the pivot of the other vanishes exactly.
  const BlockPattern pattern{{1, 1, 2}, {{0, 1}, {1, 2}}};
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(4, 4);
  a << 2, 2, 0, 0,  //
      2, 2, 0, 0,   //
      0, 0, 4, 1,   //
      0, 0, 1, 4;
  const BlockSymbolic symbolic(pattern);
  BlockFactor<double> factor(symbolic);
  factor.set_zero();
  assemble(symbolic, pattern, a, factor.values());
  const FactorStatus status = factor.factor();
  EXPECT_FALSE(status.ok());
  EXPECT_TRUE(status.unknown == 0 || status.unknown == 1);
}

TEST(BlockSparse, NoticesNaNAnywhere) {
  Random random(8);
  const BlockPattern pattern = vehicle(5, 3, 7, 8);
  const Eigen::MatrixXd a = random_matrix(pattern, false, random);
  const BlockSymbolic symbolic(pattern);
  for (int r = 0; r < a.rows(); ++r) {
    for (int c = 0; c <= r; ++c) {
      if (a(r, c) == 0) continue;
      Eigen::MatrixXd bad = a;
      bad(r, c) = bad(c, r) = std::numeric_limits<double>::quiet_NaN();
      BlockFactor<double> factor(symbolic);
      factor.set_zero();
      assemble(symbolic, pattern, bad, factor.values());
      EXPECT_FALSE(factor.factor().ok()) << r << ' ' << c;
    }
  }
}

/// Four matrices at once; a lane that cannot be divided by spoils no other.
TEST(BlockSparse, LanesAreMatricesOfTheirOwn) {
  Random random(12);
  for (const BlockPattern& pattern : patterns()) {
    const BlockSymbolic symbolic(pattern);
    const int n = symbolic.size();
    if (n == 0) continue;
    BlockFactor<Pack<4>> factor(symbolic);
    factor.set_zero();
    std::array<Eigen::MatrixXd, 4> a;
    std::vector<Pack<4>> x(static_cast<std::size_t>(n));
    std::array<Eigen::VectorXd, 4> expected;
    const int bad = below(random, 5), unknown = below(random, n);
    for (int i = 0; i < 4; ++i) {
      const auto lane = static_cast<std::size_t>(i);
      a[lane] = random_matrix(pattern, i % 2 == 1, random);
      expected[lane] = Eigen::VectorXd::NullaryExpr(n, [&] { return uniform(random); });
      for (int k = 0; k < n; ++k) x[static_cast<std::size_t>(k)][i] = expected[lane][k];
      expected[lane] = solved(pattern, a[lane], expected[lane]);
      if (i == bad) {
        a[lane].row(unknown).setZero();
        a[lane].col(unknown).setZero();
      }
      std::vector<double> values(static_cast<std::size_t>(symbolic.value_count()), 0.0);
      assemble(symbolic, pattern, a[lane], values.data());
      for (std::size_t k = 0; k < values.size(); ++k) factor.values()[k][i] = values[k];
    }
    const FactorStatus status = factor.factor();
    EXPECT_EQ(status.unknown, bad < 4 ? unknown : -1);
    factor.solve(x.data());
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < n && i != bad; ++k)
        EXPECT_NEAR(x[static_cast<std::size_t>(k)][i], expected[static_cast<std::size_t>(i)][k], 1e-12);
    if (bad < 4) {
      EXPECT_TRUE(std::isnan(x[static_cast<std::size_t>(unknown)][bad]));
    }
  }
}

/// A x = b: A x' = b' − A' x.
TEST(BlockSparse, SolutionsOfDualNumbersHaveTheirDerivative) {
  Random random(13);
  for (const BlockPattern& pattern : patterns()) {
    const BlockSymbolic symbolic(pattern);
    const int n = symbolic.size();
    BlockFactor<Dual> factor(symbolic);
    factor.set_zero();
    const Eigen::MatrixXd a = random_matrix(pattern, true, random), by = random_matrix(pattern, true, random);
    std::vector<double> values(static_cast<std::size_t>(symbolic.value_count()), 0.0), rates = values;
    assemble(symbolic, pattern, a, values.data());
    assemble(symbolic, pattern, by, rates.data());
    for (std::size_t k = 0; k < values.size(); ++k) factor.values()[k] = Dual(values[k], rates[k]);
    const auto any = [&] { return uniform(random); };
    const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(n, any), b1 = Eigen::VectorXd::NullaryExpr(n, any);
    std::vector<Dual> x;
    for (int k = 0; k < n; ++k) x.push_back(Dual(b[k], b1[k]));
    EXPECT_TRUE(factor.factor().ok());
    factor.solve(x.data());
    const Eigen::VectorXd solution = solved(pattern, a, b),
                          derivative = solved(pattern, a, b1 - by * solution);
    for (int k = 0; k < n; ++k) {
      EXPECT_NEAR(x[static_cast<std::size_t>(k)].value, solution[k], 1e-12);
      EXPECT_NEAR(x[static_cast<std::size_t>(k)].derivative, derivative[k], 1e-11);
    }
  }
}

TEST(BlockSparse, StoresNoMoreThanTheStructureNeeds) {
  const auto chain = [](int blocks) {
    BlockPattern pattern{std::vector<int>(blocks, 3), {}};
    for (int i = 1; i < blocks; ++i) pattern.couplings.emplace_back(i - 1, i);
    return BlockSymbolic(pattern).value_count();
  };
  EXPECT_LE(chain(400), 2.1 * chain(200));
  EXPECT_LE(chain(1000), 1000 * 60);

  // A star is eliminated from its leaves: no fill between them.
  BlockPattern star{std::vector<int>(200, 4), {}};
  for (int i = 1; i < 200; ++i) star.couplings.emplace_back(0, i);
  EXPECT_LE(BlockSymbolic(star).value_count(), 200 * 4 * 24);

  EXPECT_LE(BlockSymbolic(vehicle(5, 3, 7, 8)).value_count(), 98 * 40);
}

TEST(BlockSparse, EliminatesLeavesFirst) {
  const BlockPattern chain{{1, 1, 1, 1}, {{0, 1}, {1, 2}, {2, 3}}};
  EXPECT_EQ(BlockSymbolic(chain).unknowns(), (Array<int>{3, 2, 1, 0}));
  // Too large to be merged: the leaves of a star precede its centre.
  const BlockPattern star{{30, 40, 40, 40}, {{0, 1}, {0, 2}, {0, 3}}};
  const Array<int> order = BlockSymbolic(star).unknowns();
  EXPECT_GE(order.front(), 30);
  EXPECT_EQ(order.back(), 29);
}

TEST(BlockSparse, RefusesBadPatterns) {
  EXPECT_THROW(BlockSymbolic({{3, -1}, {}}), std::invalid_argument);
  EXPECT_THROW(BlockSymbolic({{3, 1}, {{0, 2}}}), std::invalid_argument);
  EXPECT_THROW(BlockSymbolic({{3, 1}, {{-1, 0}}}), std::invalid_argument);
}

}  // namespace
}  // namespace mimbre::linalg::block_sparse_test
