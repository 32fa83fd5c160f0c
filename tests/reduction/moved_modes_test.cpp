#include "reduction/moved_modes.h"

#include <gtest/gtest.h>

#include "support/random_mechanism.h"

/// Modes with rigid motions added, against sums over point masses.
namespace mimbre::test::moved_modes_test {
namespace {

constexpr int points = 6, modes = 2;

struct Points {
  double mass[points];
  Vec3d place[points];
  Eigen::Matrix<double, 3, modes> shapes[points];
};

/// Their integrals, and a frame and a node at each.
ReducedBody body_of(const Points& p) {
  ReducedBody b;
  b.modes = modes;
  b.S = Eigen::Matrix3Xd::Zero(3, modes);
  for (int i = 0; i < 3; ++i) {
    b.S_position[i] = Eigen::Matrix3Xd::Zero(3, modes);
    for (int j = 0; j < 3; ++j) b.S_modes[i][j] = Eigen::MatrixXd::Zero(modes, modes);
  }
  b.mass_matrix = Eigen::MatrixXd::Zero(modes, modes);
  b.nodes.resize(3, points);
  b.node_shapes.resize(3 * points, modes);
  for (int k = 0; k < points; ++k) {
    const auto& X = p.shapes[k];
    b.mass += p.mass[k];
    b.first_moment += p.mass[k] * p.place[k];
    b.second_moment += p.mass[k] * p.place[k] * p.place[k].transpose();
    b.S += p.mass[k] * X;
    b.mass_matrix += p.mass[k] * X.transpose() * X;
    for (int i = 0; i < 3; ++i) {
      b.S_position[i] += p.mass[k] * p.place[k][i] * X;
      for (int j = 0; j < 3; ++j) b.S_modes[i][j] += p.mass[k] * X.row(i).transpose() * X.row(j);
    }
    b.nodes.col(k) = p.place[k];
    b.node_shapes.middleRows<3>(3 * k) = X;
    BodyFrame frame;
    frame.position = p.place[k];
    frame.X = X;
    frame.X_theta = Eigen::Matrix3Xd::Zero(3, modes);
    b.frames.push_back(frame);
  }
  return b;
}

TEST(MovedModes, HaveTheIntegralsOfTheMovedPoints) {
  Random random(7);
  Points p;
  for (int k = 0; k < points; ++k) {
    p.mass[k] = random.number(0.2, 1);
    p.place[k] = random.vector(0.5);
    for (int l = 0; l < modes; ++l) p.shapes[k].col(l) = random.vector(0.4);
  }
  Eigen::MatrixXd motion(6, modes);
  for (int l = 0; l < modes; ++l) motion.col(l) << random.vector(0.7), random.vector(0.9);
  const ReducedBody moved = with_moved_modes(body_of(p), motion);
  for (int k = 0; k < points; ++k)
    for (int l = 0; l < modes; ++l) {
      const Vec3d turn = motion.col(l).tail<3>();
      p.shapes[k].col(l) += motion.col(l).head<3>() + turn.cross(p.place[k]);
    }
  const ReducedBody expected = body_of(p);
  EXPECT_TRUE(moved.S.isApprox(expected.S, 1e-13));
  EXPECT_TRUE(moved.mass_matrix.isApprox(expected.mass_matrix, 1e-13));
  EXPECT_TRUE(moved.node_shapes.isApprox(expected.node_shapes, 1e-13));
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(moved.S_position[i].isApprox(expected.S_position[i], 1e-13));
    for (int j = 0; j < 3; ++j) EXPECT_TRUE(moved.S_modes[i][j].isApprox(expected.S_modes[i][j], 1e-12));
  }
  for (int k = 0; k < points; ++k) {
    EXPECT_TRUE(moved.frames[k].X.isApprox(expected.frames[k].X, 1e-13));
    EXPECT_TRUE(moved.frames[k].X_theta.isApprox(motion.bottomRows(3), 1e-13));
  }
}

}  // namespace
}  // namespace mimbre::test::moved_modes_test
