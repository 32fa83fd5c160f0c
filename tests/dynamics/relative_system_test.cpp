#include "dynamics/relative/system.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <array>

#include <Eigen/Core>

#include "integrate/initial.h"
#include "math/once/decompositions.h"
#include "simulation/step/energy.h"
#include "spec/force_law.h"
#include "support/models.h"
#include "support/probe.h"

/// Random mechanisms of rigid and flexible bodies, with every joint type forward, reversed and cut.
namespace mimbre::test::relative_system_test {
namespace {

class RelativeSystem : public testing::TestWithParam<unsigned> {
 protected:
  unsigned seed() const { return GetParam(); }
  Random random{GetParam() + 500};

  RandomMechanism mechanism(RandomOptions options = {}) {
    options.bodies = 2 + static_cast<int>(seed() % 5);
    options.flexible_share = 0.25 * (seed() % 4);
    return random_mechanism(seed(), options);
  }
  RandomMechanism closed(RandomOptions options = {}) {
    options.loops = 1 + static_cast<int>(seed() % 3);
    options.drives = seed() % 2 == 0;
    return mechanism(options);
  }
};

TEST_P(RelativeSystem, LoopsMadeClosedAreClosed) {
  const RandomMechanism r = closed();
  Probe p(r.compiled());
  ASSERT_GT(p.equations, 0);
  EXPECT_LT(p.phi(r.q).cwiseAbs().maxCoeff(), 1e-13);
}

TEST_P(RelativeSystem, JacobianIsTheDerivativeOfTheEquations) {
  const RandomMechanism r = closed();
  Probe p(r.compiled());
  const VectorXd q = p.moved(r.q, random_increment(p.m, random, 0.5));
  const MatrixXd J = p.jacobian(q);
  EXPECT_LT(relative_difference(J, p.gradient(q, [&](const VectorXd& x) { return p.phi(x); })), 1e-9);

  VectorXd out = VectorXd::Constant(p.n, 0.25);
  const VectorXd y = random.values(p.equations, 1);
  p.system.add_jacobian_transposed(y.data(), -2, out.data());
  EXPECT_LT(relative_difference(out, VectorXd::Constant(p.n, 0.25) - 2 * J.transpose() * y), 1e-13);
}

TEST_P(RelativeSystem, RatesOfTheEquations) {
  const RandomMechanism r = closed();
  Probe p(r.compiled());
  const VectorXd q = p.moved(r.q, random_increment(p.m, random, 0.5)), v = random_increment(p.m, random, 2),
                 a = random_increment(p.m, random, 3);
  const double t = 0.3;
  const VectorXd phi_dot = p.phi_dot(q, v, t), phi_ddot = p.phi_ddot(q, v, a, t);
  EXPECT_LT(
      relative_difference(
          phi_dot,
          p.rate(q, v, a, [&](const VectorXd& x, const VectorXd&, double s) { return p.phi(x, t + s); })),
      1e-9);
  EXPECT_LT(relative_difference(phi_ddot, p.rate(q, v, a,
                                                 [&](const VectorXd& x, const VectorXd& u, double s) {
                                                   return p.phi_dot(x, u, t + s);
                                                 })),
            1e-9);
  // At rest only drives move.
  VectorXd moving = VectorXd::Zero(p.equations);
  for (const DriveData& d : p.m.drives) {
    const spec::Joint& joint = p.m.spec().joints[static_cast<std::size_t>(d.joint_spec)];
    const auto drive = std::find_if(joint.drives.begin(), joint.drives.end(),
                                    [&](const spec::Drive& x) { return x.coordinate == d.local; });
    moving[d.equation] =
        drive->of == spec::Drive::Of::position ? -drive->law.derivative(t) : -drive->law.value(t);
  }
  EXPECT_LT(relative_difference(phi_dot, p.jacobian(q) * v + moving), 1e-12);
}

TEST_P(RelativeSystem, MultipliersActThroughTheTransposedJacobian) {
  const RandomMechanism r = closed();
  Probe p(r.compiled());
  const VectorXd q = p.moved(r.q, random_increment(p.m, random, 0.5)), v = random_increment(p.m, random, 2),
                 lambda = random.values(p.equations, 3);
  const MatrixXd J = p.jacobian(q);
  const VectorXd without = p.residual(q, v, p.zero);
  EXPECT_LT(relative_difference(p.residual(q, v, p.zero, 0, lambda) - without, J.transpose() * lambda),
            1e-10);
  // factor·αΦ on top.
  VectorXd with_penalty(p.n);
  p.system.residual(0, q.data(), v.data(), p.zero.data(), lambda.data(), 7, with_penalty.data());
  const VectorXd alpha = Eigen::Map<const VectorXd>(p.system.penalty(), p.equations);
  EXPECT_GT(alpha.minCoeff(), 0);
  EXPECT_LT(relative_difference(with_penalty - without,
                                J.transpose() * (lambda + 7 * VectorXd(alpha.cwiseProduct(p.phi(q))))),
            1e-10);
}

TEST_P(RelativeSystem, MassMatrixIsThatOfTheResidualAndOfTheBodies) {
  const RandomMechanism r = mechanism();
  Probe p(r.compiled());
  p.system.begin_step(r.q.data());
  const VectorXd v = random_increment(p.m, random, 2);
  const VectorXd without = p.residual(r.q, v, p.zero);
  MatrixXd from_residual(p.n, p.n);
  for (int k = 0; k < p.n; ++k) from_residual.col(k) = p.residual(r.q, v, p.unit(k)) - without;
  const MatrixXd assembled = p.matrix(r.q, v, {0, 0, 0}), projected = p.projected_mass(r.q);
  EXPECT_LT(relative_difference(assembled, projected), 1e-12);
  EXPECT_LT(relative_difference(from_residual, projected), 1e-10);
}

TEST_P(RelativeSystem, KineticEnergyIsThatOfTheMassMatrix) {
  const RandomMechanism r = mechanism();
  Probe p(r.compiled());
  const VectorXd v = random_increment(p.m, random, 2);
  const MatrixXd M = p.matrix(r.q, v, {0, 0, 0});
  p.kinematics(r.q, v, p.zero);
  const double energy = kinetic_energy(p.m, p.system.workspace(), r.q.data(), v.data());
  EXPECT_NEAR(energy, 0.5 * v.dot(M * v), 1e-12 * std::max(1.0, energy));
  EXPECT_NEAR(energy, p.kinetic(r.q, v), 1e-12 * std::max(1.0, energy));
}

/// d/dt ∂T/∂v − ∂T/∂z for every coordinate; rotations of quaternion joints by Boltzmann and Hamel's
/// equations, where ω × ∂T/∂ω comes in because increments about moving axes do not commute.
TEST_P(RelativeSystem, InertiaForcesAreLagranges) {
  RandomOptions options;
  options.gravity = false;
  const RandomMechanism r = mechanism(options);
  Probe p(r.compiled());
  const VectorXd v = random_increment(p.m, random, 2), a = random_increment(p.m, random, 3);
  const VectorXd inertia = p.residual(r.q, v, a) - p.residual(r.q, p.zero, p.zero);
  VectorXd lagrange =
      p.rate(r.q, v, a, [&](const VectorXd& q, const VectorXd& u, double) { return p.momentum(q, u); });
  lagrange -= p.gradient(
                   r.q, [&](const VectorXd& q) { return VectorXd::Constant(1, p.kinetic(q, v)); }, 1e-4)
                  .transpose();
  const VectorXd momentum = p.momentum(r.q, v);
  for (const BodyData& b : p.m.bodies) {
    const JointInfo& info = joint_info(b.joint);
    if (info.quaternion < 0) continue;
    const int k = b.v + info.rotation;
    lagrange.segment<3>(k) += Vec3d(v.segment<3>(k)).cross(Vec3d(momentum.segment<3>(k)));
  }
  EXPECT_LT(relative_difference(inertia, lagrange), 2e-8);
}

TEST_P(RelativeSystem, ForcesAtRestAreTheGradientOfThePotential) {
  RandomOptions options;
  options.springs = options.tyres = true;
  const RandomMechanism r = mechanism(options);
  Probe p(r.compiled());
  const VectorXd gradient =
      p.gradient(
           r.q, [&](const VectorXd& q) { return VectorXd::Constant(1, p.potential(q)); }, 1e-4)
          .transpose();
  EXPECT_LT(relative_difference(p.residual(r.q, p.zero, p.zero), gradient), 1e-9);
}

TEST_P(RelativeSystem, PowerBalance) {
  RandomOptions options;
  options.springs = options.damping = options.tyres = options.loads = true;
  const RandomMechanism r = mechanism(options);
  Probe p(r.compiled());
  const VectorXd v = random_increment(p.m, random, 2), a = random_increment(p.m, random, 3);
  const double t = 0.7;
  const VectorXd residual = p.residual(r.q, v, a, t);
  const double stored = p.rate(r.q, v, a, [&](const VectorXd& q, const VectorXd& u, double) {
    return VectorXd::Constant(1, p.kinetic(q, u) + p.potential(q));
  })[0];
  // Dissipated by modal damping, springs and joints; done by loads.
  double dissipated = 0, done = 0;
  for (int i = 0; i < static_cast<int>(p.m.bodies.size()); ++i) {
    const auto& flexible =
        p.m.spec().bodies[static_cast<std::size_t>(p.m.bodies[static_cast<std::size_t>(i)].spec)].flexible;
    if (flexible) dissipated += p.modes(i, v, true).dot(flexible->damping * p.modes(i, v, true));
  }
  for (const ElementData& e : p.m.elements) {
    if (e.law != find_law("spring")) continue;
    const FunctionData& damping = p.m.functions[static_cast<std::size_t>(e.functions) + 1];
    if (e.measure == Measure::coordinate) {
      dissipated += damping.value(v[e.v]) * v[e.v];
      continue;
    }
    const auto length = [&](const VectorXd& q, const VectorXd&, double) {
      p.kinematics(q, p.zero, p.zero);
      return VectorXd::Constant(1, p.spring_length(e));
    };
    const double rate = p.rate(r.q, v, a, length)[0];
    const spec::Law& law = p.m.spec().springs[static_cast<std::size_t>(e.spec)].general;
    const double general = law.formula.value(std::array{length(r.q, v, 0)[0], rate, t}.data());
    dissipated += (damping.value(rate) + general) * rate;
  }
  p.kinematics(r.q, v, a, t);
  for (const spec::Load& l : p.m.spec().loads) {
    const auto frame_index = static_cast<std::size_t>(p.m.frame_of_spec[static_cast<std::size_t>(l.frame)]);
    const auto& frame = p.system.workspace().frames[frame_index];
    const Mat3d turn = l.follower ? frame.rotation : Mat3d(Mat3d::Identity());
    done += l.scale.value(t) * ((turn * l.force).dot(frame.velocity) + (turn * l.moment).dot(frame.omega));
  }
  EXPECT_NEAR(v.dot(residual), stored + dissipated - done,
              1e-8 * std::max(1.0, v.cwiseAbs().dot(residual.cwiseAbs())));
}

/// Velocity and acceleration of frames, deformed ones among them, are the derivatives of their poses.
TEST_P(RelativeSystem, MotionOfFramesIsTheDerivativeOfTheirPose) {
  const RandomMechanism r = closed();
  Probe p(r.compiled());
  const VectorXd v = random_increment(p.m, random, 2), a = random_increment(p.m, random, 3);
  const int frames = static_cast<int>(p.m.frames.size());
  const auto all = [&](const VectorXd& q, const VectorXd& u, const VectorXd& w, auto&& f) {
    p.kinematics(q, u, w);
    VectorXd out(3 * frames);
    for (int k = 0; k < frames; ++k)
      out.segment<3>(3 * k) = f(relative::output_motion(p.system, k, q.data(), u.data(), w.data()), k);
    return out;
  };
  using BodyMotion = Motion<double>;
  const auto velocity = all(r.q, v, a, [](const BodyMotion& x, int) { return x.velocity; });
  const auto acceleration =
      all(r.q, v, a, [&](const BodyMotion& x, int) { return Vec3d(x.acceleration + p.m.gravity); });
  const auto omega = all(r.q, v, a, [](const BodyMotion& x, int) { return x.omega; });
  const auto alpha = all(r.q, v, a, [](const BodyMotion& x, int) { return x.alpha; });
  const auto rate_of = [&](auto&& f) {
    return p.rate(r.q, v, a,
                  [&](const VectorXd& q, const VectorXd& u, double) { return all(q, u, p.zero, f); });
  };
  EXPECT_LT(relative_difference(velocity, rate_of([](const BodyMotion& x, int) { return x.position; })),
            1e-9);
  EXPECT_LT(relative_difference(acceleration, rate_of([](const BodyMotion& x, int) { return x.velocity; })),
            1e-9);
  EXPECT_LT(relative_difference(alpha, rate_of([](const BodyMotion& x, int) { return x.omega; })), 1e-9);
  for (int axis = 0; axis < 3; ++axis) {
    const auto turned =
        all(r.q, v, a, [&](const BodyMotion& x, int) { return Vec3d(x.omega.cross(x.rotation.col(axis))); });
    EXPECT_LT(relative_difference(
                  turned, rate_of([&](const BodyMotion& x, int) { return Vec3d(x.rotation.col(axis)); })),
              1e-9);
  }
  EXPECT_TRUE(omega.allFinite());
}

TEST_P(RelativeSystem, TangentsOfForces) {
  RandomOptions options;
  options.springs = options.damping = options.tyres = true;
  const RandomMechanism r = mechanism(options);
  Probe p(r.compiled());
  const VectorXd v = random_increment(p.m, random, 1);
  const MatrixXd M = p.matrix(r.q, v, {0, 0, 0});
  const MatrixXd K = p.matrix(r.q, v, {0, 1, 0}) - M, C = p.matrix(r.q, v, {1, 0, 0}) - M;
  MatrixXd stiffness = MatrixXd::Zero(p.n, p.n), damping = stiffness;
  for (const BodyData& b : p.m.bodies) {
    if (b.modes == 0) continue;
    const ReducedBody& f = *p.m.spec().bodies[static_cast<std::size_t>(b.spec)].flexible;
    const int k = b.v + b.joint_velocities;
    stiffness.block(k, k, b.modes, b.modes) += f.stiffness;
    damping.block(k, k, b.modes, b.modes) += f.damping;
  }
  for (const ElementData& e : p.m.elements) {
    const auto functions = p.m.functions.begin() + e.functions;
    if (e.measure == Measure::coordinate) {
      stiffness(e.v, e.v) += functions[0].derivative(r.q[e.q]);
      damping(e.v, e.v) += functions[1].derivative(v[e.v]);
    } else if (e.measure == Measure::distance) {
      const auto length = [&](const VectorXd& q) {
        p.kinematics(q, p.zero, p.zero);
        return VectorXd::Constant(1, p.spring_length(e));
      };
      const Eigen::RowVectorXd J = p.gradient(r.q, length);
      const double l = length(r.q)[0], rate = J.dot(v), h = 1e-5;
      const spec::Law& law = p.m.spec().springs[static_cast<std::size_t>(e.spec)].general;
      const auto tension = [&](double x, double u) {
        return functions[0].value(x) + functions[1].value(u) +
               law.formula.value(std::array{x, u, 0.0}.data());
      };
      stiffness += (tension(l + h, rate) - tension(l - h, rate)) / (2 * h) * J.transpose() * J;
      damping += (tension(l, rate + h) - tension(l, rate - h)) / (2 * h) * J.transpose() * J;
    } else if (e.measure == Measure::height) {
      const spec::Tyre& t = p.m.spec().tyres[static_cast<std::size_t>(e.spec)];
      const auto height = [&](const VectorXd& q) {
        p.kinematics(q, p.zero, p.zero);
        return VectorXd::Constant(
            1, p.system.workspace().frames[static_cast<std::size_t>(e.frame_b)].position[2]);
      };
      const Eigen::RowVectorXd J = p.gradient(r.q, height);
      if (height(r.q)[0] - 0.1 < t.radius) stiffness += t.stiffness * J.transpose() * J;
    }
  }
  EXPECT_LT(relative_difference(K, stiffness), 1e-8);
  EXPECT_LT(relative_difference(C, damping), 1e-8);
}

TEST_P(RelativeSystem, PenaltyAndWeightsEnterAsDocumented) {
  RandomOptions options;
  options.springs = options.damping = true;
  const RandomMechanism r = closed(options);
  Probe p(r.compiled());
  const VectorXd v = random_increment(p.m, random, 1);
  const MatrixXd M = p.matrix(r.q, v, {0, 0, 0}), K = p.matrix(r.q, v, {0, 1, 0}) - M,
                 C = p.matrix(r.q, v, {1, 0, 0}) - M, J = p.jacobian(r.q);
  const VectorXd alpha = Eigen::Map<const VectorXd>(p.system.penalty(), p.equations);
  const MatrixXd expected = M + 0.3 * C + 0.02 * K + 50 * J.transpose() * alpha.asDiagonal() * J;
  EXPECT_LT(relative_difference(p.matrix(r.q, v, {0.3, 0.02, 50}), expected), 1e-12);

  p.residual(r.q, v, p.zero);
  const MatrixWeights weights{0, 0.02, 50};
  const MatrixXd A = expected - 0.3 * C;
  // Springs may be soft in the large, so that the tangent need not be definite; the factor copes where it is
  // regular.
  ASSERT_TRUE(p.system.factor(r.q.data(), weights).ok());
  const VectorXd b = random.values(p.n, 1);
  VectorXd x = b;
  p.system.solve(x.data());
  EXPECT_LT(relative_difference(A * x, b), 1e-7 * std::max(1.0, x.cwiseAbs().maxCoeff()));
}

/// Other weights change all tangents and, of rigid bodies, nothing else.
TEST_P(RelativeSystem, ExchangedTangentsAreThoseOfANewMatrix) {
  RandomOptions options;
  options.bodies = 2 + static_cast<int>(seed() % 5);
  options.flexible_share = 0;
  options.loops = static_cast<int>(seed() % 3);
  options.tyres = true;
  const RandomMechanism r = random_mechanism(seed(), options);
  Probe p(r.compiled());
  for (const ElementData& e : p.m.elements) ASSERT_TRUE(e.marked);
  const VectorXd v = random_increment(p.m, random, 1), b = random.values(p.n, 1);
  p.residual(r.q, v, p.zero);
  const auto solved = [&](bool exchanged, const MatrixWeights& weights) {
    EXPECT_TRUE(
        (exchanged ? p.system.factor_tangents(r.q.data(), weights) : p.system.factor(r.q.data(), weights))
            .ok());
    VectorXd x = b;
    p.system.solve(x.data());
    return x;
  };
  const MatrixWeights one{0.1, 0.001, 50}, other{0.02, 0.003, 50};
  const VectorXd first = solved(false, one), second = solved(false, other);
  solved(false, one);
  EXPECT_LT(relative_difference(solved(true, other), second), 1e-8);
  EXPECT_FALSE(p.system.tangent_changed(r.q.data(), other));
  EXPECT_LT(relative_difference(solved(true, one), first), 1e-8);
}

/// A contact that moves along before it opens leaves nothing in the matrix.
TEST(ExchangedTangents, OfAContactThatOpensAreGone) {
  const auto model = model_of(R"(
bodies: {top: {mass: 2, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}}
joints: {free: {type: floating, between: [ground, top], at: [0, 0, 0]}}
surfaces: {floor: {type: half_space}}
contacts: {tip: {spheres: {on: top, at: [0.2, 0, 0], radius: 0.1}, surfaces: floor, stiffness: 1e7, restitution: 0.5, friction: 0.4}}
)");
  Probe p(model->compiled());
  const MatrixWeights weights{0.01, 1e-4, 0};
  const VectorXd b = VectorXd::LinSpaced(p.n, -1, 1.5);
  // Height and turn about the vertical.
  const auto evaluate = [&](double height, double turn) {
    VectorXd q = assembled_position(p.m);
    q[2] = height;
    q[3] = std::cos(turn / 2);
    q[6] = std::sin(turn / 2);
    p.residual(q, p.zero, p.zero);
    return q;
  };
  const auto solved = [&](bool exchanged, const VectorXd& q) {
    EXPECT_TRUE(
        (exchanged ? p.system.factor_tangents(q.data(), weights) : p.system.factor(q.data(), weights)).ok());
    VectorXd x = b;
    p.system.solve(x.data());
    return x;
  };
  const VectorXd touching = solved(false, evaluate(0.099, 0));
  EXPECT_GT(relative_difference(solved(true, evaluate(0.097, 0.4)), touching), 1e-6);
  const VectorXd q = evaluate(0.15, 0.4), exchanged = solved(true, q), anew = solved(false, q);
  EXPECT_LT(relative_difference(exchanged, anew), 1e-8);
  EXPECT_GT(relative_difference(touching, anew), 0.1);
  // One that closes comes in by where bodies were when the matrix was assembled.
  solved(false, evaluate(0.10005, 0.4));
  const VectorXd again = evaluate(0.0999, 0.4), closed = solved(true, again);
  EXPECT_LT(relative_difference(closed, solved(false, again)), 1e-2);
  EXPECT_GT(relative_difference(closed, anew), 0.1);
}

TEST_P(RelativeSystem, SolutionAgreesWithADenseOne) {
  const RandomMechanism r = closed();
  Probe p(r.compiled());
  const MatrixWeights weights{0, 0.01, 20};
  const MatrixXd A = p.matrix(r.q, p.zero, weights);
  const Cholesky dense(A);
  ASSERT_TRUE(dense.ok());
  ASSERT_TRUE(p.system.factor(r.q.data(), weights).ok());
  const VectorXd b = random.values(p.n, 1);
  VectorXd x = b;
  p.system.solve(x.data());
  EXPECT_LT(relative_difference(x, dense.solve(b)), 1e-8);
}

TEST_P(RelativeSystem, NothingDependsOnTheCommonPoint) {
  RandomOptions options;
  options.springs = options.damping = options.tyres = options.loads = true;
  const RandomMechanism r = closed(options);
  Probe p(r.compiled());
  const VectorXd v = random_increment(p.m, random, 2), a = random_increment(p.m, random, 3),
                 lambda = random.values(p.equations, 3);
  const VectorXd residual = p.residual(r.q, v, a, 0.2, lambda), phi = p.phi(r.q);
  const MatrixXd A = p.matrix(r.q, v, {0.1, 0.1, 10}), J = p.jacobian(r.q);
  relative::move_origin<double>(p.m, p.system.workspace(), random.vector(5));
  EXPECT_LT(relative_difference(p.residual(r.q, v, a, 0.2, lambda), residual), 1e-10);
  EXPECT_LT(relative_difference(p.phi(r.q), phi), 1e-12);
  EXPECT_LT(relative_difference(p.matrix(r.q, v, {0.1, 0.1, 10}), A), 1e-10);
  EXPECT_LT(relative_difference(p.jacobian(r.q), J), 1e-12);
}

/// Accelerations of the coordinates are the same wherever and however the whole model stands.
TEST_P(RelativeSystem, MovingTheWholeModelChangesNothing) {
  RandomOptions options;
  options.springs = options.damping = options.loads = true;
  options.loops = static_cast<int>(seed() % 3);
  const RandomMechanism r = mechanism(options);
  Probe here(r.compiled());
  State s{0, r.q, random_increment(here.m, random, 2), here.zero, here.zero, here.none, {}, {}};
  here.system.begin_step(s.q.data());
  ASSERT_TRUE(solve_accelerations(here.system, s));

  spec::Model moved = r.compiled().spec();
  const spec::Pose pose{{1e5, -2e4, 300}, random.rotation()};
  moved.gravity = pose.rotation * moved.gravity;
  for (spec::Body& b : moved.bodies) b.pose = after(pose, b.pose);
  for (spec::Frame& f : moved.frames)
    if (f.body < 0) f.pose = after(pose, f.pose);
  for (spec::Load& l : moved.loads)
    if (!l.follower) {
      l.force = pose.rotation * l.force;
      l.moment = pose.rotation * l.moment;
    }
  const auto model = Model::compile(moved);
  Probe there(model->compiled());
  State u{0, r.q, s.v, there.zero, there.zero, there.none, {}, {}};
  there.system.begin_step(u.q.data());
  ASSERT_TRUE(solve_accelerations(there.system, u));
  EXPECT_LT(relative_difference(s.a, u.a), 1e-7);
}

TEST_P(RelativeSystem, AccelerationsFulfilTheEquationsOfMotion) {
  RandomOptions options;
  options.loads = true;
  const RandomMechanism r = closed(options);
  Probe p(r.compiled());
  State s{0, r.q, random_increment(p.m, random, 1), p.zero, p.zero, p.none, {}, {}};
  const double gap = close_velocities(p.system, 0, s.q, VectorXd::Ones(p.n), s.v);
  // Drives may contradict the loops; forces balance then as well.
  if (seed() % 2 != 0) {
    ASSERT_LT(gap, 1e-9);
  }
  ASSERT_TRUE(solve_accelerations(p.system, s));
  const double scale = std::max(1.0, s.a.cwiseAbs().maxCoeff());
  EXPECT_LT(p.residual(s.q, s.v, s.a, 0, s.multipliers).cwiseAbs().maxCoeff(), 1e-6 * scale);
  if (gap < 1e-9) {
    EXPECT_LT(p.phi_ddot(s.q, s.v, s.a).cwiseAbs().maxCoeff(), 1e-6 * scale);
  }
}

/// With every array overwritten by NaN, the next evaluation gives the same bits: it reads nothing that is
/// left over.
TEST_P(RelativeSystem, NothingStaleIsRead) {
  RandomOptions options;
  options.springs = options.damping = options.tyres = options.loads = true;
  const RandomMechanism r = closed(options);
  Probe p(r.compiled());
  const VectorXd v = random_increment(p.m, random, 2), a = random_increment(p.m, random, 3),
                 lambda = random.values(p.equations, 3), b = random.values(p.n, 1);
  const auto evaluate = [&] {
    p.system.workspace() = relative::Workspace<double>(p.m);
    VectorXd all(3 * p.n + p.equations);
    all.head(p.n) = p.residual(r.q, v, a, 0.2, lambda);
    EXPECT_TRUE(p.system.factor(r.q.data(), {0.1, 0.01, 10}).ok());
    all.segment(p.n, p.n) = b;
    p.system.solve(all.data() + p.n);
    all.segment(2 * p.n, p.n).setZero();
    p.system.add_jacobian_transposed(lambda.data(), 1, all.data() + 2 * p.n);
    p.system.jacobian_times(b.data(), all.data() + 3 * p.n);
    return all;
  };
  const VectorXd first = evaluate();
  EXPECT_TRUE(first.allFinite());
  // Another state in between.
  p.system.workspace() = relative::Workspace<double>(p.m);
  p.residual(assembled_position(p.m), p.zero, p.zero);
  const VectorXd again = evaluate();
  EXPECT_EQ((first - again).cwiseAbs().maxCoeff(), 0);
}

TEST_P(RelativeSystem, IncrementsCompose) {
  const RandomMechanism r = mechanism();
  Probe p(r.compiled());
  const VectorXd x = random_increment(p.m, random, 0.7), d = random_increment(p.m, random, 0.4);
  VectorXd both = x;
  p.system.compose(both.data(), d.data());
  const VectorXd stepwise = p.moved(p.moved(r.q, x), d), at_once = p.moved(r.q, both);
  // A quaternion and its negative are one rotation: compare the bodies.
  p.kinematics(stepwise, p.zero, p.zero);
  const auto bodies = p.system.workspace().bodies;
  p.kinematics(at_once, p.zero, p.zero);
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    EXPECT_LT(relative_difference(bodies[k].rotation, p.system.workspace().bodies[k].rotation), 1e-12);
    EXPECT_LT(relative_difference(bodies[k].position, p.system.workspace().bodies[k].position), 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, RelativeSystem, testing::Range(0u, 40u));

TEST(RelativeSystem, TangentOfAStraightSpringIsTheDerivativeOfTheForce) {
  // A mass that slides along the spring's own direction: no turning of the spring, so no other stiffness.
  spec::Model m;
  m.gravity.setZero();
  spec::Body body;
  body.name = "mass";
  body.mass = 2;
  m.bodies.push_back(body);
  m.frames = {{"a", {}, spec::ground, {}, -1},
              {"b", {}, 0, {}, -1},
              {"s", {}, spec::ground, {{0, 0, -1}, Mat3d::Identity()}, -1}};
  spec::Joint joint;
  joint.name = "slide";
  joint.type = spec::JointType::prismatic;
  joint.frame_a = 0;
  joint.frame_b = 1;
  m.joints.push_back(joint);
  spec::Spring spring;
  spring.name = "spring";
  spring.frame_a = 2;
  spring.frame_b = 1;
  spring.elastic = Function::polynomial({0, 3, 0, 11});
  spring.damping = Function::polynomial({0, 2, 5});
  m.springs.push_back(spring);
  const auto model = Model::compile(m);
  Probe p(model->compiled());
  const VectorXd q = VectorXd::Constant(1, 0.4), v = VectorXd::Constant(1, 0.3);
  const double h = 1e-6;
  const auto force = [&](double x, double u) {
    return p.residual(VectorXd::Constant(1, x), VectorXd::Constant(1, u), p.zero)[0];
  };
  EXPECT_NEAR(force(0.4, 0.3), 3 * 1.4 + 11 * std::pow(1.4, 3) + 2 * 0.3 + 5 * 0.09, 1e-12);
  EXPECT_NEAR(p.matrix(q, v, {0, 1, 0})(0, 0) - 2, (force(0.4 + h, 0.3) - force(0.4 - h, 0.3)) / (2 * h),
              1e-6);
  EXPECT_NEAR(p.matrix(q, v, {1, 0, 0})(0, 0) - 2, (force(0.4, 0.3 + h) - force(0.4, 0.3 - h)) / (2 * h),
              1e-6);
}

}  // namespace
}  // namespace mimbre::test::relative_system_test
