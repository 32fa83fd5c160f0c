#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "dynamics/natural/system.h"
#include "dynamics/relative/system.h"
#include "integrate/initial.h"
#include "mimbre/reduced_body.h"
#include "simulation/step/energy.h"
#include "support/random_mechanism.h"

/// Terms of flexible bodies' inertia that a model neglects, against sums over point masses, and between the
/// formulations.
namespace mimbre::test::neglected_inertia_test {
namespace {

constexpr int points = 7, modes = 3;

/// Point masses that move with modes.
struct Points {
  explicit Points(Random& random) {
    for (int k = 0; k < points; ++k) {
      mass[k] = random.number(0.2, 1);
      place[k] = random.vector(0.5);
      for (int l = 0; l < modes; ++l) shapes[k].col(l) = random.vector(0.4);
    }
  }
  std::shared_ptr<ReducedBody> body() const {
    auto b = std::make_shared<ReducedBody>();
    b->name = "points";
    b->modes = modes;
    b->S = Eigen::Matrix3Xd::Zero(3, modes);
    for (int i = 0; i < 3; ++i) {
      b->S_position[i] = Eigen::Matrix3Xd::Zero(3, modes);
      for (int j = 0; j < 3; ++j) b->S_modes[i][j] = MatrixXd::Zero(modes, modes);
    }
    b->mass_matrix = b->stiffness = b->damping = MatrixXd::Zero(modes, modes);
    b->stiffness.diagonal() << 30, 50, 80;
    for (int k = 0; k < points; ++k) {
      const auto& X = shapes[k];
      b->mass += mass[k];
      b->first_moment += mass[k] * place[k];
      b->second_moment += mass[k] * place[k] * place[k].transpose();
      b->S += mass[k] * X;
      b->mass_matrix += mass[k] * X.transpose() * X;
      for (int i = 0; i < 3; ++i) {
        b->S_position[i] += mass[k] * place[k][i] * X;
        for (int j = 0; j < 3; ++j) b->S_modes[i][j] += mass[k] * X.row(i).transpose() * X.row(j);
      }
    }
    b->user_from_modal = MatrixXd::Identity(modes, modes);
    b->mode_names = {"first", "second", "third"};
    b->node_shapes.setZero(0, modes);
    return b;
  }

  double mass[points];
  Vec3d place[points];
  Eigen::Matrix<double, 3, modes> shapes[points];
};

/// A force and a moment on the body's frame, body axes, and forces on its modes.
struct Forces {
  Vec3d force = Vec3d::Zero(), moment = Vec3d::Zero();
  VectorXd modal = VectorXd::Zero(modes);
};

struct Motions {
  Vec3d a, omega, alpha;  ///< body axes
  VectorXd y, yd, ydd;
};

/// What a term stands for.
Forces term_of(InertiaTerm term, const Points& p, const Motions& m) {
  Forces out;
  for (int k = 0; k < points; ++k) {
    const auto& X = p.shapes[k];
    const Vec3d r = p.place[k], u = X * m.y, ud = X * m.yd, udd = X * m.ydd;
    const auto on_frame = [&](const Vec3d& force, const Vec3d& at) {
      out.force += p.mass[k] * force;
      out.moment += p.mass[k] * at.cross(force);
    };
    const auto on_modes = [&](const Vec3d& force) { out.modal += p.mass[k] * X.transpose() * force; };
    const auto inertia = [&](const Mat3d& J) {
      out.moment += p.mass[k] * (J * m.alpha + m.omega.cross(J * m.omega));
    };
    const Vec3d &w = m.omega, coriolis = 2 * w.cross(ud);
    switch (term) {
      case InertiaTerm::first_moment:
        out.force += p.mass[k] * (m.alpha.cross(u) + w.cross(w.cross(u)));
        out.moment += p.mass[k] * u.cross(m.a);
        break;
      case InertiaTerm::second_moment_linear:
        inertia(2 * r.dot(u) * Mat3d::Identity() - r * u.transpose() - u * r.transpose());
        break;
      case InertiaTerm::second_moment_quadratic:
        inertia(u.squaredNorm() * Mat3d::Identity() - u * u.transpose());
        break;
      case InertiaTerm::rotation_coupling:
        out.moment += p.mass[k] * (r + u).cross(udd);
        on_modes(m.alpha.cross(r + u));
        break;
      case InertiaTerm::rotation_coupling_deformed:
        out.moment += p.mass[k] * u.cross(udd);
        on_modes(m.alpha.cross(u));
        break;
      case InertiaTerm::centrifugal:
        on_modes(w.cross(w.cross(r + u)));
        break;
      case InertiaTerm::centrifugal_deformed:
        on_modes(w.cross(w.cross(u)));
        break;
      case InertiaTerm::coriolis_modes:
        on_modes(coriolis);
        break;
      case InertiaTerm::coriolis_body:
        on_frame(coriolis, r + u);
        break;
      case InertiaTerm::coriolis_body_deformed:
        out.moment += p.mass[k] * u.cross(coriolis);
        break;
    }
  }
  return out;
}

std::shared_ptr<const Model> flying(const Points& p, InertiaTerms neglected, bool elastodynamic = false) {
  spec::Model model;
  model.gravity.setZero();
  spec::Body body;
  body.name = "body";
  body.flexible = p.body();
  body.neglected = neglected;
  body.elastodynamic = elastodynamic;
  model.bodies.push_back(body);
  spec::Frame ground, own;
  ground.name = "start";
  own.name = "body";
  own.body = 0;
  model.frames = {ground, own};
  spec::Joint joint;
  joint.name = "free";
  joint.type = spec::JointType::floating;
  joint.frame_a = 0;
  joint.frame_b = 1;
  model.joints.push_back(joint);
  return Model::compile(model);
}

/// Forces that a motion needs, and the motion of the body's frame.
std::pair<Forces, Motions> needed(const Model& model, unsigned seed) {
  const Compiled& m = model.compiled();
  relative::RelativeSystem system(m);
  Random random(seed);
  VectorXd q = random_position(system, random, 0.7);
  q.segment(m.bodies[0].q + m.bodies[0].joint_positions, modes) = random.values(modes, 0.5);
  const VectorXd v = random.values(m.velocities, 2), a = random.values(m.velocities, 3);
  VectorXd r(m.velocities);
  system.begin_step(q.data());
  system.residual(0, q.data(), v.data(), a.data(), nullptr, 0, r.data());
  const BodyData& b = m.bodies[0];
  const Motion<double>& motion = system.workspace().bodies[0];
  const Mat3d A = motion.rotation;
  const auto& wrench = system.workspace().transmitted[0];
  Forces f;
  f.force = A.transpose() * wrench.force;
  f.moment = A.transpose() * (wrench.moment - motion.position.cross(wrench.force));
  f.modal = r.segment(b.v + b.joint_velocities, modes);
  return {f,
          {A.transpose() * motion.acceleration, A.transpose() * motion.omega, A.transpose() * motion.alpha,
           q.segment(b.q + b.joint_positions, modes), v.segment(b.v + b.joint_velocities, modes),
           a.segment(b.v + b.joint_velocities, modes)}};
}

TEST(NeglectedInertia, EachTermIsWhatPointMassesSay) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const Points p(random);
    const auto [all, motion] = needed(*flying(p, {}), seed);
    for (int k = 0; k < inertia_term_count; ++k) {
      InertiaTerms one;
      one.add(static_cast<InertiaTerm>(k));
      const Forces without = needed(*flying(p, one), seed).first,
                   expected = term_of(static_cast<InertiaTerm>(k), p, motion);
      const char* name = inertia_terms[static_cast<std::size_t>(k)].name;
      const double scale = all.force.norm() + all.moment.norm() + all.modal.norm();
      EXPECT_LT((all.force - without.force - expected.force).norm(), 1e-12 * scale) << name;
      EXPECT_LT((all.moment - without.moment - expected.moment).norm(), 1e-12 * scale) << name;
      EXPECT_LT((all.modal - without.modal - expected.modal).norm(), 1e-12 * scale) << name;
      EXPECT_GT(expected.force.norm() + expected.moment.norm() + expected.modal.norm(), 1e-4 * scale)
          << name << " does nothing here";
    }
  }
}

/// Several at once are their sum, but for what one contains of another.
TEST(NeglectedInertia, TermsAdd) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    Random random(seed);
    const Points p(random);
    InertiaTerms some;
    for (int k = 0; k < inertia_term_count; ++k)
      if (random.chance(0.5)) some.add(static_cast<InertiaTerm>(k));
    const auto [all, motion] = needed(*flying(p, {}), seed);
    const Forces without = needed(*flying(p, some), seed).first;
    Forces sum;
    for (int k = 0; k < inertia_term_count; ++k) {
      const auto term = static_cast<InertiaTerm>(k);
      const bool contained =
          k > 0 && some.has(static_cast<InertiaTerm>(k - 1)) &&
          (term == InertiaTerm::rotation_coupling_deformed || term == InertiaTerm::centrifugal_deformed ||
           term == InertiaTerm::coriolis_body_deformed);
      if (!some.has(term) || contained) continue;
      const Forces one = term_of(term, p, motion);
      sum.force += one.force;
      sum.moment += one.moment;
      sum.modal += one.modal;
    }
    const double scale = all.force.norm() + all.moment.norm() + all.modal.norm();
    EXPECT_LT((all.force - without.force - sum.force).norm(), 1e-12 * scale) << seed;
    EXPECT_LT((all.moment - without.moment - sum.moment).norm(), 1e-12 * scale) << seed;
    EXPECT_LT((all.modal - without.modal - sum.modal).norm(), 1e-12 * scale) << seed;
  }
}

/// What bends a body by linear elastodynamics, and the forces that it hands on: those of a rigid body.
TEST(NeglectedInertia, ElastodynamicsHandsNothingOn) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const Points p(random);
    const auto [found, m] = needed(*flying(p, {}, true), seed);
    Forces expected;
    for (int k = 0; k < points; ++k) {
      const Vec3d r = p.place[k], acceleration = m.a + m.alpha.cross(r) + m.omega.cross(m.omega.cross(r));
      expected.force += p.mass[k] * acceleration;
      expected.moment += p.mass[k] * r.cross(acceleration);
      expected.modal += p.mass[k] * p.shapes[k].transpose() * (acceleration + p.shapes[k] * m.ydd);
    }
    expected.modal += p.body()->stiffness * m.y;
    const double scale = expected.force.norm() + expected.modal.norm();
    EXPECT_LT((found.force - expected.force).norm(), 1e-12 * scale);
    EXPECT_LT((found.moment - expected.moment).norm(), 1e-12 * scale);
    EXPECT_LT((found.modal - expected.modal).norm(), 1e-12 * scale);
  }
}

/// A mechanism with flexible bodies that each neglect some of the terms.
RandomMechanism mechanism(unsigned seed) {
  RandomOptions options;
  options.bodies = 3 + static_cast<int>(seed % 4);
  options.loops = static_cast<int>(seed % 3);
  options.flexible_share = 0.7;
  options.springs = options.damping = options.loads = true;
  RandomMechanism made = random_mechanism(seed, options);
  spec::Model model = made.model->spec();
  Random random(seed + 1000);
  for (spec::Body& body : model.bodies)
    for (int k = 0; k < inertia_term_count; ++k)
      if (body.flexible && random.chance(0.4)) body.neglected.add(static_cast<InertiaTerm>(k));
  return {Model::compile(model), made.q};
}

TEST(NeglectedInertia, TheMatrixIsThatOfTheResidual) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const RandomMechanism made = mechanism(seed);
    const Compiled& m = made.compiled();
    relative::RelativeSystem system(m);
    Random random(seed);
    const VectorXd q = random_position(system, random, 0.3), v = random.values(m.velocities, 0.5),
                   a = random.values(m.velocities, 1), none = VectorXd::Zero(m.velocities),
                   multipliers = VectorXd::Zero(m.equations);
    VectorXd with(m.velocities), without(m.velocities);
    system.begin_step(q.data());
    system.residual(0, q.data(), v.data(), none.data(), multipliers.data(), 0, without.data());
    system.residual(0, q.data(), v.data(), a.data(), multipliers.data(), 0, with.data());
    MatrixXd M(m.velocities, m.velocities);
    system.dense_matrix(q.data(), {}, M.data());
    EXPECT_LT((M * a - (with - without)).norm(), 1e-11 * (with - without).norm()) << seed;
  }
}

TEST(NeglectedInertia, BothFormulationsNeglectTheSame) {
  int compared = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const RandomMechanism made = mechanism(seed);
    const Compiled& m = made.compiled();
    relative::RelativeSystem relative(m);
    natural::NaturalSystem natural(m);
    Random random(seed + 77);
    State s;
    s.q = made.q;
    s.v = random.values(m.velocities, 1.0);
    for (const BodyData& b : m.bodies) s.v.segment(b.v + b.joint_velocities, b.modes) *= 0.1;
    const VectorXd free = VectorXd::Ones(m.velocities);
    const double gap =
        std::max(close_positions(relative, 0, free, s.q), close_velocities(relative, 0, s.q, free, s.v));
    if (gap > 1e-10 || !solve_accelerations(relative, s)) continue;
    relative.kinematics(0, s.q.data(), s.v.data(), s.a.data());
    State n = natural.from_relative(s, relative.workspace().bodies, relative.workspace().origin);
    const VectorXd expected = n.a;
    ASSERT_TRUE(solve_accelerations(natural, n)) << seed;
    EXPECT_LT((n.a - expected).cwiseAbs().maxCoeff(), 1e-9 * std::max(1.0, expected.cwiseAbs().maxCoeff()))
        << seed;
    ++compared;
  }
  EXPECT_GE(compared, 40);
}

/// ½ vᵀ M v, with the matrix that the terms leave.
TEST(NeglectedInertia, KineticEnergyIsThatOfTheMatrix) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const RandomMechanism made = mechanism(seed);
    const Compiled& m = made.compiled();
    relative::RelativeSystem system(m);
    Random random(seed);
    const VectorXd q = random_position(system, random, 0.3), v = random.values(m.velocities, 1),
                   none = VectorXd::Zero(m.equations);
    VectorXd r(m.velocities);
    system.begin_step(q.data());
    // By velocities as accelerations.
    system.residual(0, q.data(), v.data(), v.data(), none.data(), 0, r.data());
    MatrixXd M(m.velocities, m.velocities);
    system.dense_matrix(q.data(), {}, M.data());
    const double energy = 0.5 * v.dot(M * v);
    EXPECT_NEAR(kinetic_energy(m, system.workspace(), q.data(), v.data()), energy, 1e-11 * energy) << seed;
  }
}

}  // namespace
}  // namespace mimbre::test::neglected_inertia_test
