#include "dynamics/frame_turn.h"

#include <gtest/gtest.h>

#include <random>

namespace mimbre::test::frame_turn_test {
namespace {

struct Path {
  Vec3d a, b, c;
  Vec3d at(double t) const { return a + t * b + 0.5 * t * t * c; }
};

Path random_path(std::mt19937& random, bool planar) {
  std::uniform_real_distribution<double> u(-1, 1);
  const auto any = [&] { return Vec3d(u(random), u(random), planar ? 0 : u(random)); };
  return {(planar ? 0.3 : 0.8) * any(), any(), any()};  // the slope stays away from zero
}

Vec3d axial(const Mat3d& m) { return 0.5 * Vec3d(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1)); }

/// R is a rotation, ω = axial(Ṙ Rᵀ), α = ω̇ and J θ̇ = ω against differences along random paths.
void follows_its_motion(FrameTurn turn) {
  std::mt19937 random(7);
  FrameData f;
  f.turn = turn;
  f.along = Vec3d(0.6, 0.8, 0);
  f.normal = Vec3d::UnitZ();
  for (int round = 0; round < 20; ++round) {
    const Path p = random_path(random, turn == FrameTurn::slope);
    const auto motion = [&](double t, Mat3d& R, Vec3d& omega) {
      Vec3d alpha;
      turn_motion<double>(f, p.at(t), p.b + t * p.c, p.c, R, omega, alpha);
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
    EXPECT_LT((R - turn_rotation<double>(f, p.a)).norm(), 1e-14);
    EXPECT_LT((axial((plus - minus) / (2 * h) * R.transpose()) - omega).norm(), 1e-8);
    EXPECT_LT(((omega_plus - omega_minus) / (2 * h) - alpha).norm(), 1e-8 * std::max(1.0, alpha.norm()));
    EXPECT_LT((turn_jacobian<double>(f, p.a) * p.b - omega).norm(), 1e-14);
  }
}

TEST(FrameTurn, ExponentialMap) { follows_its_motion(FrameTurn::exponential); }
TEST(FrameTurn, ThreeSuccessiveRotations) { follows_its_motion(FrameTurn::successive); }
TEST(FrameTurn, SlopeOfAPlanarBeam) { follows_its_motion(FrameTurn::slope); }

TEST(FrameTurn, DirectionOfACable) { follows_its_motion(FrameTurn::direction); }

/// By the shortest way: about the axis at right angles to both directions.
TEST(FrameTurn, DirectionTurnsByTheShortestWay) {
  FrameData f;
  f.turn = FrameTurn::direction;
  f.along = Vec3d(0.6, 0, 0.8);
  const Vec3d axis = f.along.cross(Vec3d(0.3, 0.9, -0.2)).normalized();
  for (const double angle : {0., 0.3, 1.5, 3.}) {
    const Mat3d expected = rotation_exp<double>(Vec3d(angle * axis));
    EXPECT_LT((turn_rotation<double>(f, Vec3d(1.3 * expected * f.along - f.along)) - expected).norm(), 1e-13);
  }
}

/// A section on the last six of eight amplitudes, in a line that lies askew.
FrameData section() {
  FrameData f;
  f.turn = FrameTurn::section;
  f.turns = true;
  const Mat3d Q = rotation_exp<double>(Vec3d(0.4, -0.9, 0.3));
  f.along = Q.col(0);
  f.normal = Q.col(2);
  f.directions = {2, 3, 4, 5, 6, 7};
  return f;
}

TEST(FrameTurn, SectionOfAThickBeam) {
  const FrameData f = section();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-0.5, 0.5);
  using Vector8 = Eigen::Matrix<double, 8, 1>;
  for (int round = 0; round < 20; ++round) {
    Vector8 path[3];
    for (Vector8& p : path)
      for (double& x : p) x = u(random);
    const auto motion = [&](double t, Mat3d& R, Vec3d& omega) {
      const Vector8 y = path[0] + t * path[1] + 0.5 * t * t * path[2], yd = path[1] + t * path[2];
      Vec3d alpha;
      turn_motion<double>(f, y.data(), yd.data(), path[2].data(), R, omega, alpha);
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
    EXPECT_LT((axial((plus - minus) / (2 * h) * R.transpose()) - omega).norm(), 1e-7 * (1 + omega.norm()));
    EXPECT_LT(((omega_plus - omega_minus) / (2 * h) - alpha).norm(), 1e-7 * (1 + alpha.norm()));
    // A moment's work is its power with ω.
    const Vec3d moment(u(random), u(random), u(random));
    Vector8 out = Vector8::Zero();
    add_moment<double>(f, path[0].data(), moment, out.data());
    EXPECT_NEAR(out.dot(path[1]), moment.dot(omega), 1e-13 * (1 + omega.norm()));
    EXPECT_LT((section_turns(f, path[0].data()) * path[1].tail<6>() - omega).norm(),
              1e-13 * (1 + omega.norm()));
  }
}

/// Directions that turn as a rigid body turn the frame with them.
TEST(FrameTurn, SectionThatOnlyTurns) {
  const FrameData f = section();
  Mat3d Q;
  Q << f.along, f.normal.cross(f.along), f.normal;
  const Mat3d turn = rotation_exp<double>(Vec3d(1.2, 2.0, -0.7)), inside = Q.transpose() * turn * Q;
  Eigen::Matrix<double, 8, 1> y;
  y << 5, 6, inside.col(1) - Vec3d::UnitY(), inside.col(2) - Vec3d::UnitZ();
  EXPECT_LT((turn_rotation<double>(f, y.data()) - turn).norm(), 1e-13);
}

TEST(FrameTurn, SlopeTurnsPastHalfATurn) {
  FrameData f;
  f.turn = FrameTurn::slope;
  f.along = Vec3d::UnitX();
  f.normal = Vec3d::UnitZ();
  const double angle = 4;
  const Vec3d slope(1.2 * std::cos(angle), 1.2 * std::sin(angle), 0);
  const Mat3d expected = rotation_exp<double>(Vec3d(0, 0, angle));
  EXPECT_LT((turn_rotation<double>(f, slope - f.along) - expected).norm(), 1e-14);
}

/// All agree to the first order.
TEST(FrameTurn, InfinitesimalIsTheFirstOrderOfTheOthers) {
  const Vec3d theta = 1e-4 * Vec3d(0.3, -0.7, 0.5);
  FrameData f;
  f.turn = FrameTurn::infinitesimal;
  const Mat3d first = turn_rotation<double>(f, theta);
  for (const FrameTurn turn : {FrameTurn::exponential, FrameTurn::successive}) {
    f.turn = turn;
    EXPECT_LT((turn_rotation<double>(f, theta) - first).norm(), 2 * theta.squaredNorm());
    EXPECT_GT((turn_rotation<double>(f, theta) - first).norm(), 0.1 * theta.squaredNorm());
  }
}

}  // namespace
}  // namespace mimbre::test::frame_turn_test
