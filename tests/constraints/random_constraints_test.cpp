#include <gtest/gtest.h>

#include "dynamics/natural/system.h"
#include "integrate/initial.h"
#include "math/once/decompositions.h"
#include "math/turn.h"
#include "spec/constraint_kind.h"
#include "support/random_mechanism.h"

/// Constraints of every kind between bodies of random mechanisms: both formulations, and finite differences.
namespace mimbre {
/// Found by its namespace.
static void PrintTo(const ConstraintInfo* kind, std::ostream* out) { *out << kind->name; }
}  // namespace mimbre
namespace mimbre::test::random_constraints_test {
namespace {

/// Coordinates that may be coupled.
int scalar_coordinates(spec::JointType type) {
  const JointInfo& info = joint_info(type);
  return info.quaternion < 0 ? info.velocities : info.rotation;
}

/// Of up to three joints, in the tree or cut.
void couple(spec::Constraint& c, const spec::Model& model, Random& random) {
  for (int k = 0; k < 12 && c.terms.size() < 3; ++k) {
    const int joint = random.index(static_cast<int>(model.joints.size()));
    const int count = scalar_coordinates(model.joints[static_cast<std::size_t>(joint)].type);
    const bool known =
        std::any_of(c.terms.begin(), c.terms.end(), [&](const auto& term) { return term.joint == joint; });
    if (count > 0 && !known) c.terms.push_back({joint, random.index(count), random.number(0.5, 2)});
  }
  c.numbers = {random.number(-0.1, 0.1)};
}

/// A gentle grid under a wheel's place, and a frame of the ground.
void put_on_road(spec::Constraint& c, spec::Model& model, const Vec3d& wheel, Random& random) {
  spec::Road road;
  road.name = "road";
  road.over = spec::Road::Over::grid;
  road.spacing = {0.5, 0.4};
  road.origin = wheel.head<2>() - 5 * road.spacing;
  road.heights = (wheel[2] - c.numbers[0]) * Eigen::MatrixXd::Ones(11, 11);
  for (double& z : road.heights.reshaped()) z += random.number(-0.02, 0.02);
  c.road = static_cast<int>(model.roads.size());
  model.roads.push_back(std::move(road));
  spec::Frame ground;
  ground.name = "road";
  ground.pose = {random.vector(1), turn_by(random.vector(2))};
  c.frame_a = static_cast<int>(model.frames.size());
  model.frames.push_back(std::move(ground));
}

/// Frames at two of the bodies' own frames, the curve through points around the second.
void join(const ConstraintInfo& info, spec::Constraint& c, spec::Model& model, Random& random) {
  const auto frame_on = [&](int body) {
    std::vector<int> frames;
    for (std::size_t k = 0; k < model.frames.size(); ++k)
      if (model.frames[k].body == body) frames.push_back(static_cast<int>(k));
    return frames[static_cast<std::size_t>(random.index(static_cast<int>(frames.size())))];
  };
  const int bodies = static_cast<int>(model.bodies.size());
  const int a = random.index(bodies), b = (a + 1 + random.index(bodies - 1)) % bodies;
  c.frame_a = frame_on(a);
  c.frame_b = frame_on(b);
  const auto pose = [&](int frame) {
    const spec::Frame& f = model.frames[static_cast<std::size_t>(frame)];
    return after(model.bodies[static_cast<std::size_t>(f.body)].pose, f.pose);
  };
  const spec::Pose apart = after(inverse(pose(c.frame_a)), pose(c.frame_b));
  const double number = random.number(0.1, 0.5), longer = apart.position.norm() + 0.1;
  c.numbers.assign(info.numbers.size(), info.complete ? longer : number);
  if (info.on_road) return put_on_road(c, model, pose(c.frame_b).position, random);
  c.closed = random.chance(0.5);
  for (int k = 0; k < 7; ++k) {
    const double angle = 0.9 * k;
    c.points.push_back(apart.position + random.vector(0.05) +
                       0.6 * Vec3d(std::cos(angle) - 1, std::sin(angle), 0.3 * std::sin(2 * angle)));
  }
}

/// A random mechanism with a constraint more, in motion; not `possible` where it cannot move so.
struct Constrained {
  Constrained(const ConstraintInfo& kind, unsigned seed)
      : model(make(kind, seed)), m(model->compiled()), relative(m), natural(m) {
    if (m.constraints.empty()) return;
    Random random(seed + 900);
    relative.enter(m.signals.start.data(), m.states.data(), 0);
    natural.enter(m.signals.start.data(), m.states.data(), 0);
    s.q = position;
    s.v = random_increment(m, random, 1);
    s.a.setZero(m.velocities);
    s.multipliers.setZero(m.equations);
    const VectorXd free = VectorXd::Ones(m.velocities);
    if (!(close_positions(relative, 0, free, s.q) < 1e-11)) return;
    if (!(close_velocities(relative, 0, s.q, free, s.v) < 1e-11)) return;
    relative.begin_step(s.q.data());
    if (!solve_accelerations(relative, s)) return;
    relative.kinematics(0, s.q.data(), s.v.data(), s.a.data());
    // Redundant or nearly so: accelerations are not determined sharply.
    const MatrixXd jacobian = dense_jacobian(relative, 0, s.q);
    const MatrixXd square = jacobian * jacobian.transpose();
    const double least = symmetric_eigenvalues(square)[0];
    sharp = least > 0.01;
    if (!(least > 4e-4) || !(s.a.cwiseAbs().maxCoeff() < 1e4)) return;
    relative.kinematics(0, s.q.data(), s.v.data(), s.a.data());
    possible = true;
  }

  std::shared_ptr<const Model> make(const ConstraintInfo& kind, unsigned seed) {
    Random random(seed + 300);
    RandomOptions o;
    o.bodies = 3 + static_cast<int>(seed % 3);
    o.loops = kind.of_coordinates ? static_cast<int>(seed % 3) : 0;
    o.flexible_share = seed % 2 == 0 ? 0 : 0.4;
    o.springs = o.damping = o.loads = true;
    const RandomMechanism mechanism = random_mechanism(seed, o);
    position = mechanism.q;
    rigid = o.flexible_share == 0;
    spec::Model changed = mechanism.model->spec();
    spec::Constraint c;
    c.name = "constraint";
    c.type = kind.name;
    if (kind.of_coordinates)
      couple(c, changed, random);
    else
      join(kind, c, changed, random);
    if (!kind.of_coordinates || !c.terms.empty()) changed.constraints.push_back(c);
    return Model::compile(std::move(changed));
  }

  VectorXd phi(const VectorXd& q) {
    const VectorXd zero = VectorXd::Zero(m.velocities);
    relative.kinematics(0, q.data(), zero.data(), zero.data());
    return without_rates(Eigen::Map<const VectorXd>(relative.phi(), m.equations));
  }
  /// Equations of velocities alone have no value by positions.
  VectorXd without_rates(VectorXd x) const {
    for (const ConstraintData& c : m.constraints)
      for (int r = 0; r < c.count; ++r)
        if (c.is_rate(r)) x[c.first_equation + r] = 0;
    return x;
  }
  bool all_positions() const {
    for (const ConstraintData& c : m.constraints)
      if (c.rates != 0) return false;
    return true;
  }
  /// Φ̇ where it moves with v + h a from the position after that time.
  VectorXd rates_after(const VectorXd& a, double h) {
    VectorXd q(m.positions);
    const VectorXd x = h * s.v + 0.5 * h * h * a, v = s.v + h * a;
    relative.retract(s.q.data(), x.data(), q.data());
    relative.kinematics(0, q.data(), v.data(), a.data());
    return Eigen::Map<const VectorXd>(relative.phi_dot(), m.equations);
  }
  VectorXd phi_after(const VectorXd& x) {
    VectorXd q(m.positions);
    relative.retract(s.q.data(), x.data(), q.data());
    return phi(q);
  }

  VectorXd position;  ///< in which the loops are closed
  bool rigid = true;
  std::shared_ptr<const Model> model;
  const Compiled& m;
  relative::RelativeSystem relative;
  natural::NaturalSystem natural;
  State s;
  bool possible = false, sharp = false;  ///< sharp: multipliers are determined well
};

class RandomConstraints : public testing::TestWithParam<const ConstraintInfo*> {};

double largest(const VectorXd& x) { return x.size() == 0 ? 0 : x.cwiseAbs().maxCoeff(); }

TEST_P(RandomConstraints, AccelerateAlikeInBothFormulations) {
  int compared = 0;
  for (unsigned seed = 1; seed <= 400 && compared < 50; ++seed) {
    Constrained c(*GetParam(), seed);
    if (!c.possible) continue;
    State n = c.natural.from_relative(c.s, c.relative.workspace().bodies, c.relative.workspace().origin);
    c.natural.kinematics(0, n.q.data(), n.v.data(), n.a.data());
    const int e = c.natural.equations();
    const double scale = std::max(1.0, largest(n.a));
    EXPECT_LT(largest(Eigen::Map<const VectorXd>(c.natural.phi(), e)), 1e-10) << seed;
    EXPECT_LT(largest(Eigen::Map<const VectorXd>(c.natural.phi_dot(), e)), 1e-10) << seed;
    EXPECT_LT(largest(Eigen::Map<const VectorXd>(c.natural.phi_ddot(), e)), 1e-9 * scale) << seed;
    const VectorXd expected = n.a;
    ASSERT_TRUE(solve_accelerations(c.natural, n)) << seed;
    EXPECT_LT(largest(n.a - expected), 1e-9 * scale) << seed;
    // And what the constraint bears.
    const int first = c.m.constraints[0].first_equation, count = c.m.constraints[0].count;
    const VectorXd one = c.s.multipliers.segment(first, count),
                   other = n.multipliers.segment(c.natural.layout().constraints[0].first_equation, count);
    if (c.sharp && c.rigid) {
      EXPECT_LT(largest(one - other), 1e-6 * std::max(1.0, largest(one))) << seed;
    }
    ++compared;
  }
  EXPECT_GE(compared, 50);
}

/// On the constraints, where what the kinds leave out vanishes.
TEST_P(RandomConstraints, HaveTheDerivativesOfFiniteDifferences) {
  int compared = 0;
  for (unsigned seed = 1; seed <= 120 && compared < 25; ++seed) {
    Constrained c(*GetParam(), seed);
    if (!c.possible) continue;
    c.relative.kinematics(0, c.s.q.data(), c.s.v.data(), c.s.a.data());
    EXPECT_LT(largest(Eigen::Map<const VectorXd>(c.relative.phi_ddot(), c.m.equations)),
              1e-9 * std::max(1.0, largest(c.s.a)));
    // Accelerations that violate them too: the terms of ω̇ and u̇.
    Random random(seed);
    const VectorXd other = random_increment(c.m, random, 3);
    c.relative.kinematics(0, c.s.q.data(), c.s.v.data(), other.data());
    const VectorXd second = Eigen::Map<const VectorXd>(c.relative.phi_ddot(), c.m.equations);
    const auto with_other = [&](double h) { return c.phi_after(VectorXd(h * c.s.v + 0.5 * h * h * other)); };
    // Fourth order in h.
    const double h = 2e-3;
    const VectorXd zero = with_other(0);
    const VectorXd coarse = (with_other(2 * h) - 2 * zero + with_other(-2 * h)) / (4 * h * h),
                   fine = (with_other(h) - 2 * zero + with_other(-h)) / (h * h);
    const VectorXd difference = (4 * fine - coarse) / 3;
    EXPECT_LT(largest(c.without_rates(second) - difference), 2e-5 * std::max(1.0, largest(difference)))
        << seed;
    // Of velocities alone by the change of their rates, whose even part in h is that of turns that do not
    // commute.
    const auto slope_of_rates = [&](double step) {
      return VectorXd((c.rates_after(other, step) - c.rates_after(other, -step)) / (2 * step));
    };
    const VectorXd of_rates = (4 * slope_of_rates(h) - slope_of_rates(2 * h)) / 3;
    if (!c.all_positions()) {
      EXPECT_LT(largest(second - of_rates), 2e-5 * std::max(1.0, largest(of_rates))) << seed;
    }
    // Jacobian.
    const VectorXd x = random_increment(c.m, random, 1);
    const MatrixXd jacobian = dense_jacobian(c.relative, 0, c.s.q);
    const double d = 1e-5;
    const VectorXd slope = (c.phi_after(d * x) - c.phi_after(-d * x)) / (2 * d);
    EXPECT_LT(largest(c.without_rates(jacobian * x) - slope), 1e-8 * std::max(1.0, largest(slope))) << seed;
    // Rates at any velocity are the Jacobian's.
    c.relative.kinematics(0, c.s.q.data(), x.data(), c.s.a.data());
    EXPECT_LT(largest(jacobian * x - Eigen::Map<const VectorXd>(c.relative.phi_dot(), c.m.equations)),
              1e-11 * std::max(1.0, largest(slope)))
        << seed;
    ++compared;
  }
  EXPECT_GE(compared, 20);
}

/// They move the common point, but nothing else: of a model that lies elsewhere the constraint is the same.
TEST_P(RandomConstraints, DoNotDependOnWhereTheCommonPointIs) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Constrained c(*GetParam(), seed);
    if (!c.possible) continue;
    VectorXd here(c.m.velocities), there = here;
    const VectorXd multipliers = VectorXd::Ones(c.m.equations);
    c.relative.residual(0, c.s.q.data(), c.s.v.data(), c.s.a.data(), multipliers.data(), 0, here.data());
    c.relative.workspace().origin += Vec3d(3, -2, 5);
    c.relative.residual(0, c.s.q.data(), c.s.v.data(), c.s.a.data(), multipliers.data(), 0, there.data());
    EXPECT_LT(largest(here - there), 1e-10 * std::max(1.0, largest(here))) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, RandomConstraints,
                         testing::ValuesIn(all_constraints().begin(), all_constraints().end()),
                         [](const auto& kind) { return std::string(kind.param->name); });

}  // namespace
}  // namespace mimbre::test::random_constraints_test
