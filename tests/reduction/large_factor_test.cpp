#include "reduction/factor/large_factor.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <thread>
#include <vector>

namespace mimbre::fe::large_factor_test {
namespace {

using Eigen::MatrixXd;
using Eigen::SparseMatrix;

/// Springs between neighbours on a grid in space, `ground` to the ground: positive definite where it is above
/// 0.
SparseMatrix<double> grid(int side, double ground) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto index = [&](int x, int y, int z) { return x + side * (y + side * z); };
  const auto spring = [&](int a, int b) {
    entries.emplace_back(a, a, 1.0);
    entries.emplace_back(b, b, 1.0);
    entries.emplace_back(std::max(a, b), std::min(a, b), -1.0);
  };
  for (int x = 0; x < side; ++x)
    for (int y = 0; y < side; ++y)
      for (int z = 0; z < side; ++z) {
        const int own = index(x, y, z);
        entries.emplace_back(own, own, ground);
        if (x > 0) spring(own, index(x - 1, y, z));
        if (y > 0) spring(own, index(x, y - 1, z));
        if (z > 0) spring(own, index(x, y, z - 1));
      }
  const int n = side * side * side;
  SparseMatrix<double> lower(n, n);
  lower.setFromTriplets(entries.begin(), entries.end());
  return lower;
}

MatrixXd loads(Eigen::Index rows) {
  return MatrixXd::NullaryExpr(rows, 3, [](Eigen::Index r, Eigen::Index c) {
    return std::sin(0.7 * static_cast<double>(r) + static_cast<double>(c));
  });
}

double residual(const SparseMatrix<double>& lower, const MatrixXd& x, const MatrixXd& b) {
  return (lower.selfadjointView<Eigen::Lower>() * x - b).norm() / b.norm();
}

TEST(LargeFactor, SolvesAsADenseFactorisationDoes) {
  const SparseMatrix<double> lower = grid(8, 0.1);
  const MatrixXd b = loads(lower.rows());
  const LargeFactor factor(lower, "not definite");
  const MatrixXd full = MatrixXd(lower).selfadjointView<Eigen::Lower>();
  EXPECT_LT((factor.solve(b) - full.ldlt().solve(b)).norm(), 1e-11 * b.norm());
  EXPECT_EQ(factor.solve(MatrixXd(lower.rows(), 0)).cols(), 0);
}

TEST(LargeFactor, LargeGridsAreSolvedToRoundOff) {
  const SparseMatrix<double> lower = grid(28, 0.1);  // above the size where the order is another
  const MatrixXd b = loads(lower.rows());
  EXPECT_LT(residual(lower, LargeFactor(lower, "not definite").solve(b), b), 1e-13);
}

TEST(LargeFactor, RefusesWhatIsNotPositiveDefinite) {
  for (const double ground : {-0.01, -0.5, -100.0}) {
    try {
      const LargeFactor factor(grid(8, ground), "the reason");
      FAIL() << "factors of an indefinite matrix, " << ground;
    } catch (const std::invalid_argument& error) {
      EXPECT_STREQ(error.what(), "the reason");
    }
  }
  for (const int row : {0, 100, 511}) {
    SparseMatrix<double> empty_row = grid(8, 0.1);
    empty_row.prune([&](Eigen::Index r, Eigen::Index c, double) { return r != row && c != row; });
    EXPECT_THROW(LargeFactor(empty_row, ""), std::invalid_argument) << row;
    EXPECT_THROW(LargeFactor(empty_row, "", Definiteness::any), std::invalid_argument) << row;
  }
}

TEST(LargeFactor, AnyDefinitenessSolvesWhatIsIndefinite) {
  for (const double ground : {0.1, -0.5, -100.0}) {
    const SparseMatrix<double> lower = grid(8, ground);
    const MatrixXd b = loads(lower.rows());
    const LargeFactor factor(lower, "no factors", Definiteness::any);
    EXPECT_LT(residual(lower, factor.solve(b), b), 1e-10) << ground;
  }
}

TEST(LargeFactor, ThreadsDoNotDisturbEachOther) {
  const SparseMatrix<double> lower = grid(10, 0.1);
  const MatrixXd b = loads(lower.rows());
  const MatrixXd alone = LargeFactor(lower, "not definite").solve(b);
  std::vector<MatrixXd> found(4);
  std::vector<std::thread> threads;
  for (MatrixXd& x : found)
    threads.emplace_back([&] {
      for (int k = 0; k < 5; ++k) x = LargeFactor(lower, "not definite").solve(b);
    });
  for (std::thread& thread : threads) thread.join();
  for (const MatrixXd& x : found) EXPECT_LT((x - alone).norm(), 1e-12 * alone.norm());
}

}  // namespace
}  // namespace mimbre::fe::large_factor_test
