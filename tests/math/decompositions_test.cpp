#include "math/once/decompositions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include "math/once/general_eigen.h"
#include "support/dense.h"

namespace mimbre::decompositions_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::relative_difference;

/// Entries that follow no pattern, in [-1, 1].
MatrixXd some(int rows, int columns, double seed = 1) {
  MatrixXd A(rows, columns);
  for (int c = 0; c < columns; ++c)
    for (int r = 0; r < rows; ++r) A(r, c) = std::sin(seed + 12.9898 * r + 78.233 * c + r * c);
  return A;
}
MatrixXd definite(int size, double seed = 1) {
  const MatrixXd A = some(size, size, seed);
  return A * A.transpose() + MatrixXd::Identity(size, size);
}

TEST(Decompositions, EigenPairsAreThoseOfTheMatrix) {
  const MatrixXd A = some(7, 7) + some(7, 7).transpose();
  const EigenPairs pairs = symmetric_eigen(A);
  ASSERT_TRUE(pairs.ok);
  EXPECT_LT(relative_difference(A * pairs.vectors, pairs.vectors * pairs.values.asDiagonal()), 1e-13);
  EXPECT_LT(relative_difference(pairs.vectors.transpose() * pairs.vectors, MatrixXd::Identity(7, 7)), 1e-13);
  for (int k = 1; k < 7; ++k) EXPECT_LT(pairs.values[k - 1], pairs.values[k]);
  EXPECT_LT(relative_difference(symmetric_eigenvalues(A), pairs.values), 1e-13);
  EXPECT_NEAR(pairs.values.sum(), A.trace(), 1e-12);
}

TEST(Decompositions, GeneralizedEigenPairsAreThoseOfBothMatrices) {
  const MatrixXd K = some(6, 6) + some(6, 6).transpose(), M = definite(6, 2);
  const EigenPairs pairs = symmetric_eigen(K, M);
  ASSERT_TRUE(pairs.ok);
  EXPECT_LT(relative_difference(K * pairs.vectors, M * pairs.vectors * pairs.values.asDiagonal()), 1e-12);
  EXPECT_LT(relative_difference(pairs.vectors.transpose() * M * pairs.vectors, MatrixXd::Identity(6, 6)),
            1e-12);
  EXPECT_LT(relative_difference(symmetric_eigenvalues(K, M), pairs.values), 1e-12);
}

TEST(Decompositions, OfASymmetricMatrixTheLowerTriangleIsRead) {
  MatrixXd A = definite(5);
  const VectorXd expected = symmetric_eigenvalues(A);
  A.triangularView<Eigen::StrictlyUpper>().setConstant(NAN);
  EXPECT_LT(relative_difference(symmetric_eigenvalues(A), expected), 1e-13);
}

TEST(Decompositions, SmallMatricesHaveTheSameEigenvalues) {
  const Eigen::Matrix3d three = definite(3);
  const Eigen::Matrix4d four = definite(4);
  const Eigen::Matrix<double, 6, 6> six = definite(6);
  EXPECT_LT(relative_difference(eigenvalues3(three), symmetric_eigenvalues(three)), 1e-13);
  EXPECT_LT(relative_difference(eigenvalues4(four), symmetric_eigenvalues(four)), 1e-13);
  EXPECT_LT(relative_difference(eigenvalues6(six), symmetric_eigenvalues(six)), 1e-13);
}

TEST(Decompositions, SmallMatricesMayBeOfAnySignsAndEqualEigenvalues) {
  const auto check = [](const VectorXd& expected, double scale) {
    for (const MatrixXd& like : {definite(6), MatrixXd(MatrixXd::Identity(6, 6))}) {
      const MatrixXd axes = symmetric_eigen(like).vectors;
      const Eigen::Matrix<double, 6, 6> A = scale * (axes * expected.asDiagonal() * axes.transpose());
      const VectorXd found = eigenvalues6(A);
      EXPECT_LT((found - scale * expected).cwiseAbs().maxCoeff(),
                1e-14 * scale * (1 + expected.cwiseAbs().maxCoeff()))
          << found.transpose();
    }
  };
  for (const double scale : {1e-150, 1.0, 1e150}) {
    check((VectorXd(6) << -3, -2, 0, 0, 1e-9, 5).finished(), scale);
    check((VectorXd(6) << 2, 2, 2, 2, 2, 7).finished(), scale);
    check((VectorXd(6) << -1, -1, -1, 1, 1, 1).finished(), scale);
    check(VectorXd::Zero(6), scale);
  }
  Eigen::Matrix3d bad = Eigen::Matrix3d::Identity();
  bad(1, 0) = NAN;
  EXPECT_FALSE(eigenvalues3(bad).allFinite());
}

TEST(Decompositions, NothingHasNoEigenvalues) {
  EXPECT_EQ(symmetric_eigen(MatrixXd(0, 0)).values.size(), 0);
  EXPECT_EQ(symmetric_eigen(MatrixXd(0, 0), MatrixXd(0, 0)).values.size(), 0);
  EXPECT_EQ(symmetric_eigenvalues(MatrixXd(0, 0)).size(), 0);
}

TEST(Decompositions, CholeskysFactorIsLower) {
  const MatrixXd A = definite(6), b = some(6, 2, 3);
  const Cholesky factor(A);
  ASSERT_TRUE(factor.ok());
  const MatrixXd L = factor.lower();
  EXPECT_LT(relative_difference(L * L.transpose(), A), 1e-13);
  EXPECT_EQ(MatrixXd(L.triangularView<Eigen::StrictlyUpper>()).norm(), 0);
  EXPECT_LT(relative_difference(A * factor.solve(b), b), 1e-12);
  EXPECT_LT(relative_difference(L * factor.solve_lower(b), b), 1e-12);
  EXPECT_LT(relative_difference(L.transpose() * factor.solve_upper(b), b), 1e-12);
}

TEST(Decompositions, DefiniteMatricesAreToldFromOthers) {
  MatrixXd A = definite(4);
  EXPECT_TRUE(is_positive_definite(A));
  A(2, 2) = -1;
  EXPECT_FALSE(is_positive_definite(A));
  EXPECT_FALSE(Cholesky(-definite(4)).ok());
}

TEST(Decompositions, PivotedCholeskySolvesDefiniteMatricesOfEitherSign) {
  for (const double sign : {1.0, -1.0}) {
    const MatrixXd A = sign * definite(6), b = some(6, 1, 3);
    PivotedCholesky factor(A);
    EXPECT_LT(relative_difference(A * factor.solve(b), b), 1e-12);
    VectorXd x = b;
    factor.solve_in_place(x);
    EXPECT_LT(relative_difference(x, factor.solve(b)), 1e-14);
    EXPECT_EQ(factor.least_pivot() > 0, sign > 0);
    const MatrixXd other = definite(6, 5);
    factor.compute(other);
    EXPECT_LT(relative_difference(other * factor.solve(b), b), 1e-12);
  }
}

TEST(Decompositions, TheSingularCoordinateIsNamed) {
  VectorXd work(4);
  const MatrixXd regular = definite(4);
  EXPECT_EQ(PivotedCholesky(regular).singular_at(regular, 1e-12, work), -1);
  MatrixXd A = definite(4);
  A.row(2).setZero();
  A.col(2).setZero();
  A(2, 2) = 1e-20;
  // Nothing of its entry in the diagonal is lost: it is small, but not singular.
  EXPECT_EQ(PivotedCholesky(A).singular_at(A, 1e-12, work), -1);
  A(2, 2) = 0;
  EXPECT_EQ(PivotedCholesky(A).singular_at(A, 1e-12, work), 2);
}

TEST(Decompositions, SolutionsAndInverses) {
  const MatrixXd A = some(6, 6) + 2 * MatrixXd::Identity(6, 6), b = some(6, 3, 4);
  EXPECT_LT(relative_difference(A * solve(A, b), b), 1e-12);
  EXPECT_LT(relative_difference(A * inverse(A), MatrixXd::Identity(6, 6)), 1e-12);
  const auto regular = inverse_if_regular(A);
  ASSERT_TRUE(regular.has_value());
  EXPECT_LT(relative_difference(*regular, inverse(A)), 1e-12);
  MatrixXd singular = A;
  singular.col(3) = A.col(0) - A.col(1);
  EXPECT_FALSE(inverse_if_regular(singular).has_value());
  EXPECT_FALSE(solve(MatrixXd::Zero(3, 3), some(3, 1)).allFinite());
}

TEST(Decompositions, LeastSquaresLeaveWhatIsAtRightAngles) {
  const MatrixXd A = some(8, 3), b = some(8, 2, 4);
  EXPECT_LT((A.transpose() * (A * least_squares(A, b) - b)).norm(), 1e-12);
  EXPECT_LT(relative_difference(shortest_solution(A, b), least_squares(A, b)), 1e-12);
}

/// Of a matrix of rank 2: the shortest solution is in the space of the rows.
TEST(Decompositions, TheShortestSolutionHasNoPartInTheNullSpace) {
  const MatrixXd A = some(5, 2) * some(2, 4, 3), b = some(5, 1, 4), N = null_space(A, 1e-10);
  ASSERT_EQ(N.cols(), 2);
  EXPECT_LT((A * N).norm(), 1e-13);
  EXPECT_LT(relative_difference(N.transpose() * N, MatrixXd::Identity(2, 2)), 1e-13);
  const MatrixXd x = shortest_solution(A, b, 1e-10);
  EXPECT_LT((A.transpose() * (A * x - b)).norm(), 1e-12);
  EXPECT_LT((N.transpose() * x).norm(), 1e-12);
  EXPECT_GT(x.norm(), 1e-3);
  const MatrixXd P = pseudo_inverse(A, 1e-10);
  EXPECT_LT(relative_difference(P * b, x), 1e-11);
  EXPECT_LT(relative_difference(A * P * A, A), 1e-11);
  EXPECT_LT(relative_difference(P * A, (P * A).transpose()), 1e-11);
  EXPECT_LT(relative_difference(A * P, (A * P).transpose()), 1e-11);
}

/// Eigenvalues that rows and columns show are exact, whatever lies beside them, in any order: positions that
/// act on nothing (0, 1, 2), with a rate that decays slowly (5), before and behind a core of 1e7 1/s (3, 4,
/// 6).
TEST(Decompositions, EigenvaluesThatTheMatrixShowsAreExact) {
  MatrixXd A = MatrixXd::Zero(8, 8);
  A.row(0) << 0, 20, 0, 0.3, -0.2, 0, 7e4, 1e5;
  A.row(1) << 0, 0, 0, 1, 0.5, 0, -3e3, 2e5;
  A.row(2) << 0, 0, 0, 0, 0, 1, 0, 4e5;
  A.row(3) << 0, 0, 0, 0, 1e7, 0, 2e6, 3e6;
  A.row(4) << 0, 0, 0, -1e7, -1e3, 0, 1e5, 5e6;
  A.row(5) << 0, 0, 0, 1e6, -3e5, -0.006, 2e7, 6e6;
  A.row(6) << 0, 0, 0, 3e5, 2e6, 0, -1e7, 7e6;
  A(7, 7) = 0.125;
  ComplexPairs pairs = general_eigen(A);
  ASSERT_TRUE(pairs.ok);
  for (const auto& [value, times] : {std::pair{0., 3}, {-0.006, 1}, {0.125, 1}})
    EXPECT_EQ(std::count(pairs.values.begin(), pairs.values.end(), std::complex<double>(value)), times)
        << value;
  const Eigen::MatrixXcd left = A * pairs.vectors, right = pairs.vectors * pairs.values.asDiagonal();
  for (Eigen::Index k = 0; k < 8; ++k)
    EXPECT_LT((left.col(k) - right.col(k)).norm(), 1e-15 * A.norm()) << pairs.values[k];
}

TEST(Decompositions, LeftVectorsAreTheInverseOfTheVectors) {
  for (int n = 1; n <= 20; ++n) {
    MatrixXd A(n, n);
    for (int k = 0; k < n * n; ++k) A(k) = std::sin(7.0 * k * k + n);
    const ComplexPairs pairs = general_eigen(A);
    ASSERT_TRUE(pairs.ok);
    const Eigen::MatrixXcd product = left_vectors(pairs) * pairs.vectors;
    EXPECT_LT((product - Eigen::MatrixXcd::Identity(n, n)).norm(), 1e-10) << n;
  }
}

/// Equal real eigenvalues come out as pairs with tiny imaginary parts, whose vectors are real.
TEST(Decompositions, LeftVectorsOfEqualEigenvaluesAreFinite) {
  int pairs_seen = 0;
  for (int seed = 1; seed <= 300; ++seed) {
    MatrixXd V(8, 8);
    for (int k = 0; k < 64; ++k) V(k) = std::sin(7.0 * k * k + 0.3 * seed);
    VectorXd values(8);
    values << -3, -3, -3, -3, 1, 2, -5, 7;
    const ComplexPairs pairs = general_eigen(V * values.asDiagonal() * inverse(V));
    ASSERT_TRUE(pairs.ok);
    pairs_seen += pairs.values.imag().cwiseAbs().maxCoeff() > 0 ? 1 : 0;
    EXPECT_TRUE(left_vectors(pairs).allFinite()) << seed;
  }
  EXPECT_GT(pairs_seen, 50);
}

TEST(Decompositions, ColumnsAreOrderedByWhatTheyAdd) {
  MatrixXd A = MatrixXd::Zero(4, 4);
  A(0, 0) = 2;
  A(1, 1) = 5;
  A(2, 2) = 3;
  A(1, 3) = 4;  // adds nothing to column 1
  const ColumnOrder order = order_columns(A, 1e-12);
  EXPECT_EQ(order.rank, 3);
  EXPECT_EQ(order.order, (std::vector<int>{1, 2, 0, 3}));
  EXPECT_NEAR(order.largest, 5, 1e-14);
  EXPECT_EQ(order_columns(MatrixXd(0, 0)).rank, 0);
}

/// Its size is in the order of sums of long products, so it is not that of the processor at hand.
TEST(Decompositions, TheFirstCacheIsTheSameOnEveryMachine) { EXPECT_EQ(Eigen::l1CacheSize(), 32 * 1024); }

}  // namespace
}  // namespace mimbre::decompositions_test
