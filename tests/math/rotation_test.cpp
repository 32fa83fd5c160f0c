#include "math/rotation.h"

#include <gtest/gtest.h>

#include <numbers>

#include "support/random_mechanism.h"

namespace mimbre::test::rotation_test {
namespace {

/// The closed forms in extended precision, which still has all of double's digits where double's own cancel.
RotationSeries<long double> closed_forms(long double x) {
  const long double phi = std::sqrt(x), s = std::sin(phi), c = std::cos(phi);
  RotationSeries<long double> r;
  r.sinc = s / phi;
  r.a = (1 - c) / x;
  r.b = (phi - s) / (x * phi);
  r.a1 = (r.sinc - 2 * r.a) / x;
  r.b1 = (r.a - 3 * r.b) / x;
  return r;
}

void expect_relative(double value, long double exact, double tolerance, double x) {
  EXPECT_NEAR(value / static_cast<double>(exact), 1, tolerance) << "at φ² = " << x;
}

TEST(RotationSeries, AgreesWithClosedFormsOnBothSidesOfTheSwitch) {
  for (const double phi : {0.05, 0.1, 0.2, 0.25, 0.28, 0.2999, 0.3001, 0.32, 0.5, 1.0, 2.0, 3.1, 6.0}) {
    const double x = phi * phi;
    const RotationSeries<double> r = rotation_series<double>(x);
    const RotationSeries<long double> e = closed_forms(x);
    expect_relative(r.sinc, e.sinc, 1e-14, x);
    expect_relative(r.a, e.a, 1e-13, x);
    expect_relative(r.b, e.b, 1e-12, x);
    expect_relative(r.a1, e.a1, 1e-10, x);
    expect_relative(r.b1, e.b1, 1e-10, x);
  }
}

TEST(RotationSeries, LimitsAtZero) {
  const RotationSeries<double> r = rotation_series<double>(0);
  EXPECT_EQ(r.sinc, 1);
  EXPECT_EQ(r.a, 0.5);
  EXPECT_EQ(r.b, 1. / 6);
  EXPECT_EQ(r.a1, -1. / 12);
  EXPECT_EQ(r.b1, -1. / 60);
}

/// a1 = (da/dφ)/φ, b1 = (db/dφ)/φ.
TEST(RotationSeries, LastTwoAreDerivatives) {
  const double h = 1e-5;
  for (const double phi : {0.01, 0.1, 0.29, 0.31, 1.0, 2.5}) {
    const auto at = [&](double x) { return rotation_series<double>(x * x); };
    const RotationSeries<double> r = at(phi), p = at(phi + h), m = at(phi - h);
    EXPECT_NEAR(r.a1, (p.a - m.a) / (2 * h * phi), 1e-8 / phi);
    EXPECT_NEAR(r.b1, (p.b - m.b) / (2 * h * phi), 1e-8 / phi);
  }
}

TEST(Rotation, ExponentialIsTheRotationAboutTheAxis) {
  Random random(1);
  for (const double angle : {0.0, 1e-9, 1e-3, 0.29, 0.31, 1.0, 3.0, 5.0}) {
    const Vec3d axis = random.vector(1).normalized();
    const Mat3d expected = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    EXPECT_LT((rotation_exp<double>(angle * axis) - expected).norm(), 1e-14);
    EXPECT_LT((rotation_matrix<double>(quaternion_exp<double>(angle * axis)) - expected).norm(), 1e-14);
    EXPECT_NEAR(quaternion_exp<double>(angle * axis).norm(), 1, 1e-15);
  }
}

TEST(Rotation, SkewIsTheCrossProduct) {
  Random random(2);
  const Vec3d a = random.vector(1), b = random.vector(1);
  EXPECT_LT((skew<double>(a) * b - a.cross(b)).norm(), 1e-15);
}

TEST(Rotation, LogarithmInvertsTheExponentialUpToHalfATurn) {
  Random random(3);
  for (const double angle : {0.0, 1e-12, 1e-10, 1e-8, 1e-4, 0.3, 1.0, 3.0, std::numbers::pi - 1e-7}) {
    const Vec3d theta = angle * random.vector(1).normalized();
    const Quat<double> q = quaternion_exp<double>(theta);
    EXPECT_LT((quaternion_log<double>(q) - theta).norm(), 1e-14 + 1e-15 * angle);
    EXPECT_LT((quaternion_log<double>(-q) - theta).norm(), 1e-14 + 1e-15 * angle);  // the same rotation
  }
  // Beyond half a turn the short way round.
  const Vec3d axis = random.vector(1).normalized();
  EXPECT_LT(
      (quaternion_log<double>(quaternion_exp<double>(4 * axis)) - (4 - 2 * std::numbers::pi) * axis).norm(),
      1e-14);
}

TEST(Rotation, LeftJacobianIsTheDerivativeOfTheExponential) {
  Random random(4);
  const double h = 1e-5;
  for (const double angle : {0.0, 0.01, 0.2999, 0.3001, 1.0, 2.5}) {
    const Vec3d theta = angle * random.vector(1).normalized(), rate = random.vector(1);
    const Mat3d R = rotation_exp<double>(theta);
    const Mat3d derivative =
        (rotation_exp<double>(theta + h * rate) - rotation_exp<double>(theta - h * rate)) / (2 * h);
    EXPECT_LT((derivative - skew<double>(left_jacobian<double>(theta) * rate) * R).norm(), 1e-9);
  }
}

TEST(Rotation, QuaternionProductIsTheProductOfRotations) {
  Random random(5);
  for (int k = 0; k < 20; ++k) {
    const Quat<double> p = quaternion_of(random.rotation()), q = quaternion_of(random.rotation());
    const Mat3d expected = rotation_matrix<double>(p) * rotation_matrix<double>(q);
    EXPECT_LT((rotation_matrix<double>(quaternion_product<double>(p, q)) - expected).norm(), 1e-14);
  }
  EXPECT_EQ(quaternion_product<double>({0, 1, 0, 0}, {0, 0, 1, 0}), Quat<double>(0, 0, 0, 1));  // i j = k
}

TEST(Rotation, QuaternionOfAMatrix) {
  Random random(6);
  for (int k = 0; k < 20; ++k) {
    const Mat3d R = random.rotation();
    EXPECT_LT((rotation_matrix<double>(quaternion_of(R)) - R).norm(), 1e-14);
  }
}

}  // namespace
}  // namespace mimbre::test::rotation_test
