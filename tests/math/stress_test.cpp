#include "math/stress.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace mimbre::test::stress_test {
namespace {

Vector6 components(const Eigen::Matrix3d& t) {
  Vector6 s;
  s << t(0, 0), t(1, 1), t(2, 2), t(0, 1), t(1, 2), t(2, 0);
  return s;
}

const Eigen::Matrix3d turn =
    Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();

TEST(Stress, InvariantsOfUniaxialShearAndPressureDoNotDependOnTheAxes) {
  Eigen::Matrix3d pull = Eigen::Matrix3d::Zero(), shear = pull;
  pull(0, 0) = 5;
  shear(0, 1) = shear(1, 0) = 3;
  const Eigen::Matrix3d pressure = -7 * Eigen::Matrix3d::Identity();
  for (const Eigen::Matrix3d& R : {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), turn}) {
    EXPECT_NEAR(von_mises(components(R * pull * R.transpose())), 5, 1e-12);
    EXPECT_NEAR(von_mises(components(R * shear * R.transpose())), 3 * std::sqrt(3.0), 1e-12);
    EXPECT_NEAR(von_mises(components(R * pressure * R.transpose())), 0, 1e-12);
    const Vector6 both = components(R * (shear + pressure) * R.transpose());
    EXPECT_NEAR(stress_component(both, max_principal_component), -4, 1e-12);
    EXPECT_NEAR(stress_component(both, max_principal_component + 1), -10, 1e-12);
  }
}

TEST(Stress, GaugeShowsTheElongationAlongIt) {
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F += 1e-7 * (Eigen::Matrix3d() << 3, 1, -2, 0.5, -1, 4, 2, 1, 0.7).finished();
  const Eigen::Matrix3d tensor = 0.5 * (F + F.transpose()) - Eigen::Matrix3d::Identity();
  Vector6 strain = components(tensor);
  strain.tail<3>() *= 2;
  const Eigen::Vector3d n = turn.col(1);
  EXPECT_NEAR(elongation(strain, n), (F * n).norm() - 1, 1e-12);
  EXPECT_LT((tensor_strain(strain) - components(tensor)).norm(), 1e-20);
}

}  // namespace
}  // namespace mimbre::test::stress_test
