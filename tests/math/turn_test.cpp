#include "math/turn.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "math/rotation.h"
#include "support/random_mechanism.h"

namespace mimbre::turn_test {
namespace {

using test::Random;

TEST(Turn, IsThatOfEigenWithinRoundOff) {
  Random random(3);
  for (int k = 0; k < 1000; ++k) {
    const Eigen::Vector3d axis = random.vector(1).normalized();
    const double angle = random.number(-20, 20);
    const Eigen::Matrix3d expected = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    EXPECT_LT((turn_about(axis, angle) - expected).cwiseAbs().maxCoeff(), 1e-15);
    const Eigen::Vector3d vector = angle * axis;
    EXPECT_LT((turn_by(vector) - rotation_exp<double>(vector)).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(Turn, OfNothingIsTheIdentity) {
  EXPECT_EQ(turn_by(Eigen::Vector3d::Zero()), Eigen::Matrix3d::Identity());
  const Eigen::Vector3d tiny(1e-200, -2e-200, 0);
  EXPECT_LT((turn_by(tiny) - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-199);
}

TEST(Turn, BetweenTwoDirectionsIsTheLeast) {
  Random random(4);
  for (int k = 0; k < 1000; ++k) {
    const Eigen::Vector3d from = random.vector(3), to = random.vector(2);
    const Eigen::Matrix3d turn = turn_between(from, to);
    // Of directions that are nearly opposite, round-off decides about which axis.
    const double apart = (from.normalized() + to.normalized()).norm();
    EXPECT_LT((turn * from.normalized() - to.normalized()).norm(), 2e-15 * (1 + 1 / apart));
    EXPECT_LT((turn * from.cross(to) - from.cross(to)).norm(), 1e-14);
    EXPECT_LT((turn.transpose() * turn - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-14);
    const Eigen::Matrix3d back = turn_between(from, -2 * from);
    EXPECT_LT((back * from + from).norm(), 1e-14);
    EXPECT_NEAR(back.determinant(), 1, 1e-14);
  }
}

}  // namespace
}  // namespace mimbre::turn_test
