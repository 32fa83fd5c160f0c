#include "linalg/once/sparse_qr.h"

#include <gtest/gtest.h>

#include <random>

#include "math/once/decompositions.h"

namespace mimbre::linalg::sparse_qr_test {
namespace {

/// Sparse columns of `rows`, some of them combinations of two others.
SparseMatrix sample(int rows, int independent, int dependent, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-1, 1);
  std::uniform_int_distribution<int> row(0, rows - 1), column(0, independent - 1);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(rows, independent + dependent);
  for (int c = 0; c < independent; ++c) {
    A(c % rows, c) = 2;
    for (int k = 0; k < 3; ++k) A(row(random), c) += value(random);
  }
  for (int c = independent; c < A.cols(); ++c)
    A.col(c) = value(random) * A.col(column(random)) + value(random) * A.col(column(random));
  return A.sparseView();
}

TEST(SparseQr, AgreesWithDenseDecompositions) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const int rows = 30, independent = 12, dependent = 1 + static_cast<int>(seed) % 7;
    const SparseMatrix A = sample(rows, independent, dependent, seed);
    const SparseQr qr(A, 1e-9);
    EXPECT_EQ(qr.rank(), independent) << seed;
    ASSERT_EQ(qr.dependent().size(), static_cast<std::size_t>(dependent));
    const Eigen::VectorXd shares = Eigen::VectorXd::LinSpaced(dependent, 0.5, 1.5);
    const Eigen::VectorXd x = qr.null_vector(shares);
    EXPECT_LE((A * x).norm(), 1e-10 * x.norm());
    for (int k = 0; k < dependent; ++k) EXPECT_EQ(x[qr.dependent()[static_cast<std::size_t>(k)]], shares[k]);
    // Equations that do not contradict each other.
    const Eigen::VectorXd b = A.transpose() * Eigen::VectorXd::LinSpaced(rows, -1, 2);
    const Eigen::MatrixXd dense = Eigen::MatrixXd(A).transpose();
    EXPECT_LE((qr.shortest(b) - shortest_solution(dense, b, 1e-9)).norm(), 1e-9) << seed;
  }
}

/// Columns and ranks of no rule, against a dense decomposition.
TEST(SparseQr, FindsTheRankOfRandomMatrices) {
  std::mt19937 random(7);
  for (unsigned seed = 0; seed < 300; ++seed) {
    const int rows = 5 + static_cast<int>(random() % 40), independent = 1 + static_cast<int>(random() % rows);
    const SparseMatrix A = sample(rows, independent, static_cast<int>(random() % 20), seed);
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> dense(A);
    dense.setThreshold(1e-9);
    const SparseQr qr(A, 1e-9);
    EXPECT_EQ(qr.rank(), dense.rank()) << seed;
    const auto dependent = static_cast<Eigen::Index>(qr.dependent().size());
    EXPECT_EQ(qr.rank() + dependent, A.cols());
    const Eigen::VectorXd x = qr.null_vector(Eigen::VectorXd::LinSpaced(dependent, 0.5, 1.5));
    EXPECT_LE((A * x).norm(), 1e-8 * x.norm()) << seed;
  }
}

/// The loops of a ladder: each has two equations of its own, and three that repeat what others state. In a
/// time that grows with their number, or this would take minutes.
TEST(SparseQr, OfALongLadder) {
  const int loops = 10000;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> value(-1, 1);
  std::vector<Eigen::Triplet<double>> entries;
  for (int loop = 0; loop < loops; ++loop)
    for (int equation = 0; equation < 5; ++equation)
      for (int k = 0; k < 3; ++k)
        entries.emplace_back(2 * loop + k, 5 * loop + equation, (equation < 2 ? 1 : 1e-17) * value(random));
  SparseMatrix A(2 * loops + 1, 5 * loops);
  A.setFromTriplets(entries.begin(), entries.end());
  const SparseQr qr(A, 1e-9);
  EXPECT_EQ(qr.rank(), 2 * loops);
  EXPECT_EQ(qr.dependent().size(), 3U * loops);
}

/// More equations than coordinates, and none at all.
TEST(SparseQr, OfAnyShape) {
  const SparseMatrix wide = SparseMatrix(sample(30, 12, 3, 1).transpose());
  const SparseQr qr(wide, 1e-9);
  EXPECT_EQ(qr.rank(), 12);
  const Eigen::VectorXd b = wide.transpose() * Eigen::VectorXd::LinSpaced(wide.rows(), -1, 2);
  EXPECT_LE((wide.transpose() * qr.shortest(b) - b).norm(), 1e-9);
  EXPECT_EQ(SparseQr(SparseMatrix(5, 3), 1e-9).rank(), 0);
}

}  // namespace
}  // namespace mimbre::linalg::sparse_qr_test
