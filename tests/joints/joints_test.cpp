#include <gtest/gtest.h>

#include <Eigen/Core>
#include <ostream>

#include "joints/joint_kind.h"
#include "joints/table.h"
#include "math/once/decompositions.h"
#include "support/probe.h"

/// Every row of the joint table goes through the same checks.
namespace mimbre {
void PrintTo(const JointInfo& info, std::ostream* out) { *out << info.name; }
}  // namespace mimbre

namespace mimbre::test::joints_test {
namespace {

class Joints : public testing::TestWithParam<const JointInfo*> {
 protected:
  using Coordinates = Eigen::Matrix<double, 7, 1>;
  using Rates = Eigen::Matrix<double, 6, 1>;
  JointInfo info = *GetParam();
  Random random{static_cast<unsigned>(GetParam()->type) + 40};

  Coordinates coordinates() {
    Coordinates q = random.values(7, 1.2);
    if (info.quaternion >= 0) q.segment<4>(info.quaternion) = quaternion_exp<double>(random.vector(1.5));
    return q;
  }
  Rates rates() { return random.values(6, 1.5); }
  JointMotion<double> motion(const Coordinates& q, const Rates& v = Rates::Zero()) const {
    JointMotion<double> m;
    joint_motion<double>(info.type, q.data(), v.data(), m);
    return m;
  }
  Coordinates moved(const Coordinates& q, const Rates& x) const {
    Coordinates out = q;
    const int plain = info.quaternion < 0 ? info.velocities : info.rotation;
    out.head(plain) += x.head(plain);
    if (info.quaternion >= 0)
      out.segment<4>(info.quaternion) = quaternion_product<double>(
          q.segment<4>(info.quaternion), quaternion_exp<double>(x.segment<3>(info.rotation)));
    return out;
  }
  /// Rotation vector of the small rotation from one matrix to the other, in the outer axes.
  static Vec3d turn(const Mat3d& from, const Mat3d& to) {
    return quaternion_log<double>(quaternion_of(to * from.transpose()));
  }
};

TEST_P(Joints, TableIsInOrderAndConsistent) {
  EXPECT_EQ(all_joints()[static_cast<std::size_t>(info.type)]->name, info.name);
  EXPECT_EQ(joint_info(info.type).type, info.type);
  EXPECT_EQ(info.velocities + info.equations, 6);
  EXPECT_EQ(info.positions, info.velocities + (info.quaternion >= 0 ? 1 : 0));
}

TEST_P(Joints, FramesCoincideAtZero) {
  Coordinates q = Coordinates::Zero();
  if (info.quaternion >= 0) q[info.quaternion] = 1;
  EXPECT_EQ(motion(q).rotation, Mat3d::Identity().eval());
  EXPECT_EQ(motion(q).displacement, Vec3d::Zero().eval());
}

TEST_P(Joints, ColumnsAreTheDerivativeOfThePose) {
  const double h = 1e-5;
  for (int repeat = 0; repeat < 10; ++repeat) {
    const Coordinates q = coordinates();
    const JointMotion<double> m = motion(q);
    EXPECT_LT((m.rotation * m.rotation.transpose() - Mat3d::Identity()).norm(), 1e-14);
    EXPECT_NEAR(m.rotation.determinant(), 1, 1e-14);
    for (int k = 0; k < 6; ++k) {
      const bool used = k < info.velocities;
      const Rates step = used ? Rates(h * Rates::Unit(k)) : Rates(Rates::Zero());
      const JointMotion<double> plus = motion(moved(q, step)), minus = motion(moved(q, -step));
      EXPECT_LT((m.angular.col(k) - turn(minus.rotation, plus.rotation) / (2 * h)).norm(), 1e-9) << k;
      EXPECT_LT((m.linear.col(k) - (plus.displacement - minus.displacement) / (2 * h)).norm(), 1e-9) << k;
      if (!used) continue;
      const bool is_length = !is_angle(info.type, k);
      EXPECT_TRUE((is_length ? m.angular : m.linear).col(k).isZero(0)) << k;
      if (info.fixed_axis(k) >= 0) {
        EXPECT_EQ((is_length ? m.linear : m.angular).col(k), Vec3d::Unit(info.fixed_axis(k))) << k;
      }
    }
  }
}

/// Σ ċol v: the derivative of columns · v with v held.
TEST_P(Joints, BiasIsTheDerivativeOfTheVelocity) {
  const double h = 1e-5;
  for (int repeat = 0; repeat < 10; ++repeat) {
    const Coordinates q = coordinates();
    Rates v = rates();
    v.tail(6 - info.velocities).setZero();
    const JointMotion<double> m = motion(q, v), plus = motion(moved(q, h * v)),
                              minus = motion(moved(q, -h * v));
    EXPECT_LT((m.angular_bias - (plus.angular - minus.angular) * v / (2 * h)).norm(), 1e-9);
    EXPECT_LT(((plus.linear - minus.linear) * v / (2 * h)).norm(), 1e-9);
    EXPECT_EQ(info.biased, !m.angular_bias.isZero(0));
  }
}

/// Angles within half a turn; quaternions of either sign mean the same.
TEST_P(Joints, CoordinatesFollowFromThePose) {
  for (int repeat = 0; repeat < 20; ++repeat) {
    Coordinates q = coordinates();
    q.head(info.quaternion < 0 ? 7 : info.quaternion) *= 2.6;
    const JointMotion<double> m = motion(q);
    Coordinates found = Coordinates::Zero();
    joint_coordinates<double>(info.type, m.rotation, m.displacement, found.data());
    if (info.quaternion >= 0) {
      auto turned = found.segment<4>(info.quaternion);
      if (turned.dot(q.segment<4>(info.quaternion)) < 0) turned = -turned;
    }
    EXPECT_LT((found - q).head(info.positions).norm(), 1e-14) << found.transpose() << ", " << q.transpose();
  }
}

/// Those that close something: all but the last, which leaves all motions free.
class ClosingJoints : public Joints {};

/// Two bodies: one floats, the other hangs on it by the joint and, twice over, by the same joint cut.
struct Pair {
  spec::Model model;
  int joint = 1;

  explicit Pair(spec::JointType type, Random& random, bool reversed, bool with_loop) {
    for (const char* name : {"first", "second"}) {
      spec::Body b;
      b.name = name;
      b.mass = 1.5;
      b.com = random.vector(0.3);
      b.inertia = Vec3d(0.2, 0.25, 0.3).asDiagonal();
      model.bodies.push_back(b);
    }
    const auto frame = [&](int body, const spec::Pose& pose) {
      model.frames.push_back({"frame" + std::to_string(model.frames.size()), {}, body, pose, -1});
    };
    frame(spec::ground, random.pose(1));
    frame(0, random.pose(1));
    const spec::Pose a = random.pose(1), b = random.pose(1);
    frame(0, a);
    frame(1, b);
    frame(0, a);
    frame(1, b);
    spec::Joint free, joint_between, loop;
    free.name = "free";
    free.type = spec::JointType::floating;
    free.frame_a = 0;
    free.frame_b = 1;
    joint_between.name = "joint";
    joint_between.type = type;
    joint_between.cut = spec::Joint::Cut::never;
    joint_between.frame_a = 2;
    joint_between.frame_b = 3;
    loop = joint_between;
    loop.name = "loop";
    loop.cut = spec::Joint::Cut::always;
    loop.frame_a = 4;
    loop.frame_b = 5;
    model.joints = {free, joint_between};
    if (reversed) {
      // The tree grows from the second body, so that the joint is listed from child to parent.
      model.frames[1].body = 1;
    }
    if (with_loop) model.joints.push_back(loop);
  }
};

TEST_P(ClosingJoints, LoopClosuresVanishForEveryCoordinate) {
  for (const bool reversed : {false, true}) {
    const Pair pair(info.type, random, reversed, true);
    const auto model = Model::compile(pair.model);
    Probe p(model->compiled());
    ASSERT_EQ(p.equations, info.equations);
    EXPECT_EQ(p.m.bodies[1].reversed, reversed);
    for (int repeat = 0; repeat < 5; ++repeat) {
      const VectorXd q = random_position(p.system, random, 1.0), v = random.values(p.n, 2),
                     a = random.values(p.n, 2);
      EXPECT_LT(p.phi(q).cwiseAbs().maxCoeff(), 1e-14);
      EXPECT_LT(p.phi_dot(q, v).cwiseAbs().maxCoeff(), 1e-13);
      EXPECT_LT(p.phi_ddot(q, v, a).cwiseAbs().maxCoeff(), 1e-12);
    }
  }
}

/// With the joint itself replaced by a free one, the loop closure equations leave as many motions as the
/// joint has.
TEST_P(ClosingJoints, LoopClosuresAreIndependent) {
  Pair pair(info.type, random, false, true);
  pair.model.joints[1].type = spec::JointType::floating;
  const auto model = Model::compile(pair.model);
  Probe p(model->compiled());
  for (int repeat = 0; repeat < 5; ++repeat) {
    // A position that the joint allows.
    VectorXd q = random_position(p.system, random, 0.7);
    Coordinates allowed = coordinates();
    allowed.head(3) *= 0.5;
    const JointMotion<double> at = motion(allowed);
    q.segment<3>(p.m.bodies[1].q) = at.displacement;
    q.segment<4>(p.m.bodies[1].q + 3) = quaternion_of(at.rotation);
    EXPECT_LT(p.phi(q).cwiseAbs().maxCoeff(), 1e-14);
    const MatrixXd J = p.jacobian(q).middleCols(p.m.bodies[1].v, 6);
    EXPECT_EQ(order_columns(J, 1e-6).rank, info.equations);
    // The joint's own motions, in the floating joint's coordinates, are what the equations leave free.
    MatrixXd motions(6, info.velocities);
    for (int k = 0; k < info.velocities; ++k)
      motions.col(k) << at.linear.col(k), at.rotation.transpose() * at.angular.col(k);
    EXPECT_LT(relative_difference(J * motions, MatrixXd::Zero(info.equations, info.velocities)), 1e-13);
  }
}

/// Listed from child to parent, the joint still describes frame b relative to frame a.
TEST_P(Joints, ReversedJointGivesTheSameRelativeMotion) {
  const Pair pair(info.type, random, true, false);
  const auto model = Model::compile(pair.model);
  Probe p(model->compiled());
  ASSERT_TRUE(p.m.bodies[1].reversed);
  for (int repeat = 0; repeat < 5; ++repeat) {
    const VectorXd q = random_position(p.system, random, 0.9), v = random.values(p.n, 1.5),
                   a = random.values(p.n, 1.5);
    p.kinematics(q, v, a);
    const auto at = [&](int frame) {
      return relative::output_motion(p.system, p.m.frame_of_spec[static_cast<std::size_t>(frame)], q.data(),
                                     v.data(), a.data());
    };
    const auto A = at(2), B = at(3);
    Coordinates own = Coordinates::Zero();
    Rates own_rate = Rates::Zero(), own_second = Rates::Zero();
    own.head(info.positions) = q.segment(p.m.bodies[1].q, info.positions);
    own_rate.head(info.velocities) = v.segment(p.m.bodies[1].v, info.velocities);
    own_second.head(info.velocities) = a.segment(p.m.bodies[1].v, info.velocities);
    const JointMotion<double> m = motion(own, own_rate);
    const Mat3d& R = A.rotation;
    EXPECT_LT((R.transpose() * B.rotation - m.rotation).norm(), 1e-13);
    const Vec3d d = B.position - A.position;
    EXPECT_LT((R.transpose() * d - m.displacement).norm(), 1e-13);
    const Vec3d slide = B.velocity - A.velocity - A.omega.cross(d);
    EXPECT_LT((R.transpose() * slide - m.linear * own_rate).norm(), 1e-12);
    EXPECT_LT((R.transpose() * (B.omega - A.omega) - m.angular * own_rate).norm(), 1e-12);
    const Vec3d second =
        B.acceleration - A.acceleration - A.alpha.cross(d) - A.omega.cross(A.omega.cross(d) + 2 * slide);
    EXPECT_LT((R.transpose() * second - m.linear * own_second).norm(), 1e-12);
    const Vec3d turning = B.alpha - A.alpha - A.omega.cross(B.omega - A.omega);
    EXPECT_LT((R.transpose() * turning - m.angular * own_second - m.angular_bias).norm(), 1e-12);
  }
}

std::string name_of(const testing::TestParamInfo<const JointInfo*>& row) {
  return std::string(row.param->name);
}
std::vector<const JointInfo*> closing() {
  std::vector<const JointInfo*> all;
  for (const JointInfo* info : all_joints())
    if (info->equations > 0) all.push_back(info);
  return all;
}
INSTANTIATE_TEST_SUITE_P(List, Joints, testing::ValuesIn(all_joints().begin(), all_joints().end()), name_of);
INSTANTIATE_TEST_SUITE_P(List, ClosingJoints, testing::ValuesIn(closing()), name_of);

}  // namespace
}  // namespace mimbre::test::joints_test
