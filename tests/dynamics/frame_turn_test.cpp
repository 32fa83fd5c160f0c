#include "dynamics/frame_turn.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "dynamics/relative/matrix.h"

namespace mimbre::test::frame_turn_test {
namespace {

using Vector8 = Eigen::Matrix<double, 8, 1>;

/// Whose θ are the first three of eight amplitudes.
FrameData frame(FrameTurn turn) {
  FrameData f;
  f.turn = turn;
  f.turns = true;
  f.along = Vec3d(0.6, 0.8, 0);
  f.normal = Vec3d::UnitZ();
  f.X_theta = Rows::Zero(3, 8);
  for (int k = 0; k < 3; ++k) f.X_theta(k, k) = 1;
  return f;
}

/// A section on the last six, in a line that lies askew.
FrameData section() {
  FrameData f = frame(FrameTurn::section);
  const Mat3d Q = rotation_exp<double>(Vec3d(0.4, -0.9, 0.3));
  f.along = Q.col(0);
  f.normal = Q.col(2);
  f.directions = {2, 3, 4, 5, 6, 7};
  return f;
}

Vec3d axial(const Mat3d& m) { return 0.5 * Vec3d(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1)); }

/// R is a rotation, ω = axial(Ṙ Rᵀ) and α = ω̇ against differences along random paths, whose amplitudes are up
/// to `reach` and stay away from where a slope is zero; a moment's work on them is that on ω.
void follows_its_motion(const FrameData& f, double reach) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int round = 0; round < 20; ++round) {
    Vector8 a, b, c;
    for (Vector8* p : {&a, &b, &c}) {
      for (double& x : *p) x = u(random);
      if (f.turn == FrameTurn::slope) (*p)[2] = 0;  // in its plane
    }
    a *= reach;
    const auto motion = [&](double t, Mat3d& R, Vec3d& omega) {
      const Vector8 y = a + t * b + 0.5 * t * t * c, yd = b + t * c;
      Vec3d alpha;
      turn_motion<double>(f, y.data(), yd.data(), c.data(), R, omega, alpha);
      return alpha;
    };
    Mat3d R, plus, minus;
    Vec3d omega, omega_plus, omega_minus;
    const double h = 1e-5;
    const Vec3d alpha = motion(0, R, omega);
    motion(h, plus, omega_plus);
    motion(-h, minus, omega_minus);
    EXPECT_LT((R.transpose() * R - Mat3d::Identity()).norm(), 1e-13);
    EXPECT_NEAR(R.determinant(), 1, 1e-13);
    EXPECT_LT((R - turn_rotation<double>(f, a.data())).norm(), 1e-14);
    const double speed = std::max(1.0, omega.norm()), change = std::max(1.0, alpha.norm());
    EXPECT_LT((axial((plus - minus) / (2 * h) * R.transpose()) - omega).norm(), 1e-8 * speed * speed * speed);
    EXPECT_LT(((omega_plus - omega_minus) / (2 * h) - alpha).norm(), 1e-8 * change * speed * speed);
    const Vec3d moment(u(random), u(random), u(random));
    Vector8 out = Vector8::Zero();
    add_moment<double>(f, a.data(), moment, out.data());
    EXPECT_NEAR(out.dot(b), moment.dot(omega), 1e-13 * speed);
    const Mat3d A = rotation_exp<double>(moment);
    std::array<double, 24> rows{};
    relative::turn_rows<double>(f, a.data(), A, 8, rows.data());
    const Eigen::Map<const Eigen::Matrix<double, 3, 8, Eigen::RowMajor>> turns(rows.data());
    EXPECT_LT((turns * b - A * omega).norm(), 1e-13 * speed);
  }
}

TEST(FrameTurn, ExponentialMap) { follows_its_motion(frame(FrameTurn::exponential), 0.8); }
TEST(FrameTurn, ThreeSuccessiveRotations) { follows_its_motion(frame(FrameTurn::successive), 0.8); }
TEST(FrameTurn, SlopeOfAPlanarBeam) { follows_its_motion(frame(FrameTurn::slope), 0.3); }
TEST(FrameTurn, DirectionOfACable) { follows_its_motion(frame(FrameTurn::direction), 0.5); }
TEST(FrameTurn, SectionOfAThickBeam) { follows_its_motion(section(), 0.4); }

Vector8 amplitudes(const Vec3d& theta) {
  Vector8 y = Vector8::Zero();
  y.head<3>() = theta;
  return y;
}

/// By the shortest way: about the axis at right angles to both directions.
TEST(FrameTurn, DirectionTurnsByTheShortestWay) {
  const FrameData f = frame(FrameTurn::direction);
  const Vec3d axis = f.along.cross(Vec3d(0.3, 0.9, -0.2)).normalized();
  for (const double angle : {0., 0.3, 1.5, 3.}) {
    const Mat3d expected = rotation_exp<double>(Vec3d(angle * axis));
    const Vector8 y = amplitudes(1.3 * expected * f.along - f.along);
    EXPECT_LT((turn_rotation<double>(f, y.data()) - expected).norm(), 1e-13);
  }
}

/// Directions that turn as a rigid body turn the frame with them.
TEST(FrameTurn, SectionThatOnlyTurns) {
  const FrameData f = section();
  Mat3d Q;
  Q << f.along, f.normal.cross(f.along), f.normal;
  const Mat3d turn = rotation_exp<double>(Vec3d(1.2, 2.0, -0.7)), inside = Q.transpose() * turn * Q;
  Vector8 y;
  y << 5, 6, inside.col(1) - Vec3d::UnitY(), inside.col(2) - Vec3d::UnitZ();
  EXPECT_LT((turn_rotation<double>(f, y.data()) - turn).norm(), 1e-13);
}

TEST(FrameTurn, SlopeTurnsPastHalfATurn) {
  FrameData f = frame(FrameTurn::slope);
  f.along = Vec3d::UnitX();
  const double angle = 4;
  const Vec3d slope(1.2 * std::cos(angle), 1.2 * std::sin(angle), 0);
  const Mat3d expected = rotation_exp<double>(Vec3d(0, 0, angle));
  EXPECT_LT((turn_rotation<double>(f, amplitudes(slope - f.along).data()) - expected).norm(), 1e-14);
}

/// All agree to the first order.
TEST(FrameTurn, InfinitesimalIsTheFirstOrderOfTheOthers) {
  const Vec3d theta = 1e-4 * Vec3d(0.3, -0.7, 0.5);
  const Vector8 y = amplitudes(theta);
  const Mat3d first = turn_rotation<double>(frame(FrameTurn::infinitesimal), y.data());
  for (const FrameTurn turn : {FrameTurn::exponential, FrameTurn::successive}) {
    const Mat3d R = turn_rotation<double>(frame(turn), y.data());
    EXPECT_LT((R - first).norm(), 2 * theta.squaredNorm());
    EXPECT_GT((R - first).norm(), 0.1 * theta.squaredNorm());
  }
}

}  // namespace
}  // namespace mimbre::test::frame_turn_test
