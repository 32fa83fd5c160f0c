#include "integrate/partition.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "support/random_mechanism.h"

namespace mimbre::test::partition_test {
namespace {

MatrixXd random_matrix(Random& random, int rows, int columns) {
  const VectorXd x = random.values(rows * columns, 1);
  return Eigen::Map<const MatrixXd>(x.data(), rows, columns);
}

TEST(Partition, SolvesEquationsWithRedundantOnes) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    Random random(seed);
    const int n = 4 + random.index(8), rank = 1 + random.index(3), m = rank + random.index(4);
    const MatrixXd J = random_matrix(random, m, rank) * random_matrix(random, rank, n);
    Partition partition(n, m);
    ASSERT_TRUE(partition.choose(J, VectorXd::Ones(m), VectorXd::Ones(n)));
    ASSERT_EQ(partition.rank(), rank);
    ASSERT_TRUE(partition.factor(J));

    const VectorXd b = J * random.values(n, 1), g = J.transpose() * random.values(m, 1);
    VectorXd x(n), y(m);
    partition.particular(b.data(), x.data());
    EXPECT_LT((J * x - b).norm(), 1e-9);
    partition.multipliers(g.data(), y.data());
    EXPECT_LT((J.transpose() * y - g).norm(), 1e-9);
    MatrixXd R;
    partition.null_space(R);
    ASSERT_EQ(R.cols(), n - rank);
    EXPECT_LT((J * R).norm(), 1e-9);
    for (int j = 0; j < n - rank; ++j) {
      EXPECT_EQ(R(partition.independent(j), j), 1);
      EXPECT_EQ(x[partition.independent(j)], 0);
    }
  }
}

/// An equation that holds nothing is round-off of what its coefficients are the differences of, one beside
/// others as well as alone.
TEST(Partition, RoundOffIsNoEquation) {
  MatrixXd J(3, 2);
  J << 1, 2, 3e-17, -1e-17, 0.5, 1e-17;
  for (const int rank : {2, 0}) {
    const MatrixXd jacobian = rank > 0 ? J : MatrixXd(1e-17 * J);
    Partition partition(2, 3);
    ASSERT_TRUE(partition.choose(jacobian, VectorXd::Ones(3), VectorXd::Ones(2)));
    EXPECT_EQ(partition.rank(), rank);
  }
}

TEST(Partition, CoordinatesOfLargeWeightBecomeDependent) {
  const MatrixXd J = MatrixXd::Ones(1, 3);
  Partition partition(3, 1);
  ASSERT_TRUE(partition.choose(J, VectorXd::Ones(1), Eigen::Vector3d(1, 5, 2)));
  EXPECT_EQ(partition.dependent(0), 1);
}

/// Two bars in line: the determinant of the dependents changes sign where they are stretched out.
TEST(Partition, NoticesASingularPositionThatWasPassed) {
  const auto jacobian = [](double angle) {
    MatrixXd J(2, 3);
    J << 1, std::cos(angle), 0.1 * std::sin(angle), 0, std::sin(angle), 0.1 * std::sin(angle);
    return J;
  };
  Partition partition(3, 2);
  const VectorXd rows = VectorXd::Ones(2), columns = VectorXd::Ones(3);
  ASSERT_TRUE(partition.choose(jacobian(0.05), rows, columns));
  EXPECT_TRUE(partition.factor(jacobian(0.03)));
  EXPECT_FALSE(partition.factor(jacobian(0.0)));
  EXPECT_EQ(partition.weakest(), 1);
  EXPECT_FALSE(partition.factor(jacobian(-0.02)));
  EXPECT_TRUE(partition.factor(jacobian(0.05)));
  // And in a choice: two pivots at first, one left now.
  EXPECT_FALSE(partition.choose(jacobian(0.0), rows, columns));
}

TEST(Partition, FirstChoiceAtASingularPositionShowsWhenItIsLeft) {
  MatrixXd J = MatrixXd::Identity(2, 3);
  J(1, 1) = 0;
  Partition partition(3, 2);
  const VectorXd rows = VectorXd::Ones(2), columns = VectorXd::Ones(3);
  ASSERT_TRUE(partition.choose(J, rows, columns));
  EXPECT_EQ(partition.rank(), 1);
  J(1, 1) = 0.5;
  EXPECT_FALSE(partition.choose(J, rows, columns));
  EXPECT_EQ(partition.weakest(), 1);
}

}  // namespace
}  // namespace mimbre::test::partition_test
