#include "linalg/constrained_solver.h"

#include <gtest/gtest.h>

#include <random>

#include "linalg/colouring.h"
#include "math/once/decompositions.h"

namespace mimbre::linalg::constrained_solver_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// H and J of random entries; the last row of J repeats the others, so that there is one multiplier too many.
struct Sample {
  MatrixXd H, J;
};
Sample sample(int n, int m, double skew, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-1, 1);
  Sample s{MatrixXd::Zero(n, n), MatrixXd::Zero(m, n)};
  for (int r = 0; r < n; ++r) {
    s.H(r, r) = 3 + value(random);
    if (r > 0) s.H(r, r - 1) = s.H(r - 1, r) = value(random);
    if (r > 0) s.H(r, r - 1) += skew * value(random);
  }
  for (int r = 0; r + 1 < m; ++r)
    for (int k = 0; k < 3; ++k) s.J(r, (3 * r + k) % n) = value(random);
  for (int r = 0; r + 1 < m; ++r) s.J.row(m - 1) += 0.3 * s.J.row(r);
  return s;
}

TEST(ConstrainedSolver, SolvesTheEquationsThoughRowsAreRedundant) {
  for (unsigned seed = 0; seed < 20; ++seed)
    for (const double skew : {0.0, 0.5, 5.0}) {
      const int n = 24, m = 6;
      const Sample s = sample(n, m, skew, seed);
      ConstrainedSolver solver;
      solver.set(s.H.sparseView(), s.J.sparseView());
      const VectorXd f = VectorXd::LinSpaced(n, -1, 2), g = s.J * VectorXd::LinSpaced(n, 0.5, -0.7);
      VectorXd x, mu;
      ASSERT_TRUE(solver.solve(f, g, x, mu));
      EXPECT_LE((s.H * x + s.J.transpose() * mu - f).norm(), 1e-11 * f.norm()) << seed << ' ' << skew;
      EXPECT_LE((s.J * x - g).norm(), 1e-11) << seed << ' ' << skew;
    }
}

/// Motions with J x = 0 along which H is negative, against the projection on a null space.
TEST(ConstrainedSolver, CountsNegativeMotions) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const int n = 24, m = 6;
    Sample s = sample(n, m, 0, seed);
    s.H.diagonal().array() -= 3;
    ConstrainedSolver solver;
    solver.set(s.H.sparseView(), s.J.sparseView());
    const MatrixXd N = null_space(s.J, 1e-9);
    const VectorXd values = symmetric_eigenvalues(MatrixXd(N.transpose() * s.H * N));
    EXPECT_EQ(solver.negative(), (values.array() < 0).count()) << seed;
  }
}

TEST(ColumnColours, FindAMatrixFromFewProducts) {
  const int n = 200;
  std::vector<std::vector<int>> groups;
  MatrixXd A = MatrixXd::Zero(n, n);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> value(-1, 1);
  for (int k = 0; k + 2 < n; k += 2) {
    groups.push_back({k, k + 1, k + 2});
    for (const int r : groups.back())
      for (const int c : groups.back()) A(r, c) += value(random);
  }
  const ColumnColours colours(n, groups);
  EXPECT_LE(colours.colours(), 9);
  int products = 0;
  const SparseMatrix found = colours.assemble([&](const VectorXd& x, VectorXd& y) {
    y = A * x;
    ++products;
  });
  EXPECT_EQ(products, colours.colours());
  EXPECT_EQ((MatrixXd(found) - A).norm(), 0);
}

}  // namespace
}  // namespace mimbre::linalg::constrained_solver_test
