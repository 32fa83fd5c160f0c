#include "dynamics/natural/system.h"

#include <gtest/gtest.h>

#include "integrate/initial.h"
#include "support/models.h"
#include "support/random_mechanism.h"

namespace mimbre::natural_system_test {
namespace {

using test::MatrixXd;
using test::Random;
using test::RandomMechanism;
using test::RandomOptions;
using test::VectorXd;

/// A random mechanism with everything in it, moving consistently; both formulations in the same state.
struct Both {
  Both(unsigned seed, double flexible_share)
      : mechanism(test::random_mechanism(seed, options(seed, flexible_share))),
        m(mechanism.compiled()),
        relative(m),
        natural(m) {
    Random random(seed + 77);
    s.q = mechanism.q;
    s.v = random.values(m.velocities, 1.0);
    for (const BodyData& b : m.bodies) s.v.segment(b.v + b.joint_velocities, b.modes) *= 0.1;
    const VectorXd free = VectorXd::Ones(m.velocities);
    gap = std::max(close_positions(relative, 0, free, s.q), close_velocities(relative, 0, s.q, free, s.v));
    solved = solve_accelerations(relative, s);
    relative.kinematics(0, s.q.data(), s.v.data(), s.a.data());
    n = natural.from_relative(s, relative.workspace().bodies, relative.workspace().origin);
  }

  static RandomOptions options(unsigned seed, double flexible_share) {
    RandomOptions o;
    o.bodies = 3 + static_cast<int>(seed % 4);
    o.loops = static_cast<int>(seed % 3);
    o.flexible_share = flexible_share;
    o.springs = o.damping = o.tyres = o.loads = true;
    o.drives = seed % 4 == 3;
    return o;
  }

  VectorXd residual(const VectorXd& q, const VectorXd& v, const VectorXd& a) {
    const VectorXd none = VectorXd::Zero(natural.equations());
    VectorXd r(natural.velocities());
    natural.residual(0, q.data(), v.data(), a.data(), none.data(), 0, r.data());
    return r;
  }

  RandomMechanism mechanism;
  const Compiled& m;
  relative::RelativeSystem relative;
  natural::NaturalSystem natural;
  State s, n;
  double gap = 0;
  bool solved = false;
};

VectorXd copied(const double* x, int n) { return Eigen::Map<const VectorXd>(x, n); }

double largest(const VectorXd& x) { return x.size() == 0 ? 0 : x.cwiseAbs().maxCoeff(); }

class NaturalSystem : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(RigidAndFlexible, NaturalSystem, ::testing::Values(0.0, 0.5));

TEST_P(NaturalSystem, FindsTheAccelerationsOfTheRelativeFormulation) {
  int compared = 0;
  for (unsigned seed = 1; seed <= 45; ++seed) {
    Both b(seed, GetParam());
    if (b.gap > 1e-10) continue;  // drives that contradict the loops
    ASSERT_TRUE(b.solved) << seed;
    const VectorXd expected = b.n.a;
    ASSERT_TRUE(solve_accelerations(b.natural, b.n)) << seed;
    EXPECT_LT(largest(b.n.a - expected), 1e-9 * std::max(1.0, largest(expected))) << seed;
    ++compared;
  }
  EXPECT_GE(compared, 30);
}

TEST_P(NaturalSystem, FulfilsItsEquationsWhereTheRelativeFormulationDoes) {
  int compared = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Both b(seed, GetParam());
    if (b.gap > 1e-10 || b.natural.equations() == 0) continue;
    b.natural.kinematics(0, b.n.q.data(), b.n.v.data(), b.n.a.data());
    const int e = b.natural.equations();
    const double scale = std::max(1.0, largest(b.n.a));
    EXPECT_LT(largest(copied(b.natural.phi(), e)), 1e-12) << seed;
    EXPECT_LT(largest(copied(b.natural.phi_dot(), e)), 1e-12) << seed;
    EXPECT_LT(largest(copied(b.natural.phi_ddot(), e)), 1e-12 * scale) << seed;
    ++compared;
  }
  EXPECT_GE(compared, 25);
}

TEST_P(NaturalSystem, GivesTheStateInRelativeCoordinatesBack) {
  int compared = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Both b(seed, GetParam());
    if (b.gap > 1e-10) continue;
    State back = b.s;
    back.q.setZero();
    back.v.setZero();
    back.a.setZero();
    b.natural.to_relative(b.n, back);
    // Quaternions of either sign mean the same.
    for (const BodyData& body : b.m.bodies) {
      const JointInfo& info = joint_info(body.joint);
      if (info.quaternion < 0) continue;
      auto turn = back.q.segment<4>(body.q + info.quaternion);
      if (turn.dot(b.s.q.segment<4>(body.q + info.quaternion)) < 0) turn = -turn;
    }
    EXPECT_LT(largest(back.q - b.s.q), 1e-12) << seed;
    EXPECT_LT(largest(back.v - b.s.v), 1e-12) << seed;
    EXPECT_LT(largest(back.a - b.s.a), 1e-11 * std::max(1.0, largest(b.s.a))) << seed;
    ++compared;
  }
  EXPECT_GE(compared, 25);
}

TEST_P(NaturalSystem, JacobianIsTheDerivativeOfTheEquations) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Both b(seed, GetParam());
    const int n = b.natural.velocities(), e = b.natural.equations();
    const int others = b.natural.layout().first_drive;
    const MatrixXd J = dense_jacobian(b.natural, 0, b.n.q);
    const VectorXd zero = VectorXd::Zero(n);
    const auto phi = [&](int k, double x) {
      VectorXd q(b.n.q.size());
      const VectorXd step = x * VectorXd::Unit(n, k);
      b.natural.retract(b.n.q.data(), step.data(), q.data());
      b.natural.kinematics(0, q.data(), zero.data(), zero.data());
      return copied(b.natural.phi(), e);
    };
    const double h = 1e-4;
    for (int k = 0; k < n; ++k) {
      const VectorXd d = (8 * (phi(k, h) - phi(k, -h)) - (phi(k, 2 * h) - phi(k, -2 * h))) / (12 * h);
      EXPECT_LT(largest((d - J.col(k)).head(others)), 1e-8 * std::max(1.0, J.col(k).cwiseAbs().maxCoeff()))
          << seed << ", column " << k;
    }
    // Joint coordinates are functions of rigid motions only: drives are compared along one of those.
    b.natural.kinematics(0, b.n.q.data(), zero.data(), zero.data());
    const VectorXd at_rest = copied(b.natural.phi_dot(), e);
    b.natural.kinematics(0, b.n.q.data(), b.n.v.data(), zero.data());
    EXPECT_LT(largest(copied(b.natural.phi_dot(), e) - at_rest - J * b.n.v),
              1e-12 * std::max(1.0, largest(b.n.v)))
        << seed;
    // The two products are of one matrix.
    VectorXd y = Random(seed).values(e, 1), product = zero;
    b.natural.add_jacobian_transposed(y.data(), 2.0, product.data());
    EXPECT_LT(largest(product - 2 * J.transpose() * y), 1e-12 * std::max(1.0, largest(product))) << seed;
  }
}

TEST_P(NaturalSystem, MatrixIsTheDerivativeOfTheResidual) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Both b(seed, GetParam());
    const int n = b.natural.velocities();
    const VectorXd zero = VectorXd::Zero(n);
    MatrixXd mass(n, n), damping(n, n);
    const VectorXd r = b.residual(b.n.q, zero, zero);
    b.natural.dense_matrix(b.n.q.data(), {0, 0, 0}, mass.data());
    b.natural.dense_matrix(b.n.q.data(), {1, 0, 0}, damping.data());
    damping -= mass;
    for (int k = 0; k < n; ++k) {
      const VectorXd column = b.residual(b.n.q, zero, VectorXd::Unit(n, k)) - r;
      EXPECT_LT(largest(column - mass.col(k)), 1e-11 * (1 + largest(column) + largest(r))) << seed;
      // At rest the velocity-dependent inertia forces have no derivative.
      const double h = 1e-5;
      const VectorXd c = (b.residual(b.n.q, h * VectorXd::Unit(n, k), zero) -
                          b.residual(b.n.q, -h * VectorXd::Unit(n, k), zero)) /
                         (2 * h);
      EXPECT_LT(largest(c - damping.col(k)), 1e-5 * (1 + largest(c) + largest(r))) << seed << ", " << k;
    }
  }
}

TEST(NaturalLayout, SharesPointsAndVectors) {
  // Each of the five bars: a point and a unit vector at right angles to bar and axis; axes are the ground's.
  const auto bars = test::example("double-four-bar/mechanism.yaml");
  EXPECT_EQ(natural::NaturalSystem(bars->compiled()).velocities(), 24);
  // Chassis 12; of each corner the arm's ball joint and a vector, the same of the upper link, the rod's ball
  // joint and two vectors, a vector of the stub axle.
  const auto car =
      test::example("iltis/vehicle.yaml", {{"arms", "rigid"}, {"links", "rigid"}, {"rods", "rigid"}});
  EXPECT_EQ(natural::NaturalSystem(car->compiled()).velocities(), 12 + 4 * 24);
}

}  // namespace
}  // namespace mimbre::natural_system_test
