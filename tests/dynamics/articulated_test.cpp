#include "dynamics/relative/articulated.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "mimbre/simulation.h"
#include "support/dense.h"
#include "support/models.h"
#include "support/probe.h"
#include "support/random_mechanism.h"
#include "support/simulate.h"

/// The matrix of trees by bodies: with the sparse matrix, of the same mechanisms, as the measure.
namespace mimbre::test::articulated_test {
namespace {

RandomOptions smooth_tree() {
  RandomOptions o;
  o.springs = o.damping = o.loads = true;
  return o;
}

/// A mechanism somewhere, moving.
struct Moving {
  Moving(const RandomMechanism& of, unsigned seed)
      : mechanism(of), m(mechanism.compiled()), system(m), random(seed) {
    q = random_position(system, random, 0.5);
    n = system.velocities();
    v = random.values(n, 1);
    a = random.values(n, 1);
    r.resize(n);
    multipliers = VectorXd::Zero(system.equations());
    system.begin_step(q.data());
  }
  void evaluate() { system.residual(0, q.data(), v.data(), a.data(), multipliers.data(), 0, r.data()); }
  MatrixXd dense(const MatrixWeights& weights) {
    evaluate();
    MatrixXd A(n, n);
    system.dense_matrix(q.data(), weights, A.data());
    return A;
  }
  RandomMechanism mechanism;
  const Compiled& m;
  relative::RelativeSystem system;
  Random random;
  VectorXd q, v, a, r, multipliers;
  int n = 0;
};

/// The linear solution by bodies is that with the whole mass matrix, of trees with rigid and flexible bodies.
TEST(ArticulatedBodies, SolveWithTheMassMatrix) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    RandomOptions options = smooth_tree();
    options.bodies = 2 + static_cast<int>(seed % 9);
    options.flexible_share = seed % 3 * 0.5;
    Moving at(random_mechanism(seed, options), seed);
    const MatrixXd M = at.dense({0, 0, 0});
    at.evaluate();
    ASSERT_TRUE(at.system.factor_inertia(at.q.data(), 0).ok()) << seed;
    const VectorXd b = at.random.values(at.n, 1);
    VectorXd x = b;
    at.system.solve(x.data());
    EXPECT_LE((M * x - b).cwiseAbs().maxCoeff(), 1e-9 * (M.cwiseAbs() * x.cwiseAbs()).maxCoeff()) << seed;
  }
}

/// With tangents of modes, of springs and dampers on joints and to the ground, of tyres, and of drives.
TEST(ArticulatedBodies, SolveWithTheMatrixOfAStep) {
  int whole = 0, to_ground = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    RandomOptions options = smooth_tree();
    options.bodies = 2 + static_cast<int>(seed % 3);
    options.flexible_share = seed % 3 * 0.5;
    options.tyres = seed % 2 == 0;
    options.drives = seed % 5 == 0;
    const RandomMechanism mechanism = random_mechanism(seed, options);
    if (!splits_by_bodies(mechanism.compiled())) continue;
    ++whole;
    Moving at(mechanism, seed);
    for (const ElementData& e : at.m.elements)
      if (const auto on = acts_on_body(e, at.m); on && on->carried) ++to_ground;
    const MatrixWeights weights{0.02, 3e-3, 1e4};
    const MatrixXd A = at.dense(weights);
    at.evaluate();
    relative::ArticulatedBodies<double> bodies(at.m);
    relative::Workspace<double>& w = at.system.workspace();
    relative::motion_subspaces<double>(at.m, w, at.q.data());
    MatrixXd by_bodies(at.n, at.n);
    bodies.dense_matrix(at.m, w, at.q.data(), weights, at.system.penalty(), relative::NoMarks{},
                        by_bodies.data());
    EXPECT_LE((by_bodies - A).cwiseAbs().maxCoeff(), 1e-11 * A.cwiseAbs().maxCoeff()) << seed;
    ASSERT_EQ(bodies.factor(at.m, w, at.q.data(), weights, at.system.penalty(), relative::NoMarks{}), -1);
    const VectorXd b = at.random.values(at.n, 1);
    VectorXd x = b;
    bodies.solve(at.m, w, x.data());
    EXPECT_LE((A * x - b).cwiseAbs().maxCoeff(), 1e-9 * (A.cwiseAbs() * x.cwiseAbs()).maxCoeff()) << seed;
  }
  EXPECT_GE(whole, 50);
  EXPECT_GE(to_ground, 20);
}

/// A chain that hangs between a motor and a spring to the ground, with friction of the joints by dampers.
std::string hanging_chain(int links) {
  std::string bodies = "bodies:\n", joints = "joints:\n";
  for (int k = 0; k < links; ++k) {
    bodies += fmt::format("  link_{}: {{mass: 1, com: [{}, 0, 0], inertia: [0.001, 0.01, 0.01]}}\n", k,
                          0.2 * k + 0.1);
    joints += fmt::format(
        "  joint_{}: {{type: revolute, between: [{}, link_{}], at: [{}, 0, 0], "
        "axis: [0, {}, {}]{}}}\n",
        k, k == 0 ? "ground" : fmt::format("link_{}", k - 1), k, 0.2 * k, k % 2, 1 - k % 2,
        k == 3 ? ", spring: {stiffness: 2, damping: 0.3}" : "");
  }
  return bodies + joints +
         fmt::format(
             "springs:\n  end: {{between: [ground, link_{}], at: [[{}, 0, 2], [{}, 0, 0]], "
             "elastic: {{stiffness: 300, zero: 1.5}}, damping: 5}}\n"
             "simulation: {{step: 0.002}}\n",
             links - 1, 0.2 * links, 0.2 * links);
}

/// Long chains have no sparse matrix; they move as in natural coordinates, which have nothing of this.
TEST(ArticulatedBodies, MoveLongChains) {
  const auto model = model_of(hanging_chain(90));
  ASSERT_TRUE(is_eliminated_by_bodies(model->compiled()));
  EXPECT_EQ(model->compiled().symbolic.size(), 0);
  ASSERT_FALSE(is_eliminated_by_bodies(model_of(hanging_chain(20))->compiled()));
  const auto end = [&](spec::Simulation::Formulation formulation, double step) {
    RunOptions options;
    options.formulation = formulation;
    options.step = step;
    Simulation s(model, options);
    run_to(s, 0.2);
    return s.pose(s.body("link_89")).position;
  };
  using enum spec::Simulation::Formulation;
  const Vec3d coarse = end(relative, 0.002), fine = end(relative, 0.001), other = end(natural, 0.001);
  EXPECT_GT((fine - Vec3d(17.8, 0, 0)).norm(), 0.1);
  EXPECT_LT((fine - other).norm(), 2 * (fine - coarse).norm() + 1e-9);
  EXPECT_LT((fine - coarse).norm(), 1e-3);
}

/// A chain that falls on a slope, with impacts, friction, and springs and dampers on its joints. With a
/// spring of no force across, which couples bodies apart, it has the sparse matrix.
TEST(ArticulatedBodies, LetALongChainFallOnASlope) {
  constexpr int links = 80;
  std::string bodies = "bodies:\n", joints = "joints:\n", contacts = "contacts:\n";
  for (int k = 0; k < links; ++k) {
    const double begin = 0.1 * k, middle = begin + 0.05;
    bodies += fmt::format("  b{}: {{mass: 0.2, com: [{}, 0, 0], inertia: [1e-5, 2e-4, 2e-4]}}\n", k, middle);
    joints += k == 0 ? "  j0: {type: floating, between: [ground, b0], at: [0, 0, 0]}\n"
                     : fmt::format(
                           "  j{0}: {{type: revolute, between: [b{1}, b{0}], at: [{2}, 0, 0], "
                           "axis: [0, {3}, {4}], spring: {{stiffness: 0.1, damping: 0.01}}}}\n",
                           k, k - 1, begin, k % 2, 1 - k % 2);
    if (k % 4 == 0)
      contacts += fmt::format(
          "  c{0}: {{spheres: {{on: b{0}, at: [{1}, 0, 0], radius: 0.02}}, surfaces: floor, "
          "stiffness: 2e4, restitution: 0.3, friction: 0.4}}\n",
          k, middle);
  }
  const std::string chain = bodies + joints +
                            "surfaces: {floor: {type: half_space, at: [0, 0, -0.05], z: [0, 0.05, 1]}}\n" +
                            contacts + "simulation: {step: 1e-3}\n";
  const std::string across =
      "springs: {none: {between: [b0, b40], at: [[0, 0, 0], [4, 0, 0]], elastic: {stiffness: 1e-12}}}\n";
  const auto by_bodies = model_of(chain), sparse = model_of(chain + across);
  ASSERT_TRUE(is_eliminated_by_bodies(by_bodies->compiled()));
  ASSERT_FALSE(is_eliminated_by_bodies(sparse->compiled()));
  Simulation a(by_bodies), b(sparse);
  run_to(a, 0.2);
  run_to(b, 0.2);
  EXPECT_GT(a.energy().dissipated, 1);
  EXPECT_NEAR(a.energy().dissipated, b.energy().dissipated, 1e-7);
  for (const char* body : {"b0", "b41", "b79"})
    EXPECT_LT((a.pose(a.body(body)).position - b.pose(b.body(body)).position).norm(), 1e-8) << body;
}

/// With the matrix that it has kept.
TEST(ArticulatedBodies, GoOnFromASavedStateToTheSameBits) {
  const auto model = model_of(hanging_chain(90));
  Simulation a(model), b(model);
  run_to(a, 0.1);
  run_to(b, 0.03);
  b.restore(Simulation::Snapshot::from_bytes(a.save().bytes()));
  run_to(a, 0.2);
  run_to(b, 0.2);
  EXPECT_TRUE(a.save().bytes() == b.save().bytes());
}

/// Of what does not split: the sparse matrix stays.
TEST(ArticulatedBodies, AreNotTakenWhereForcesCoupleBodiesApart) {
  const std::string chain = hanging_chain(90);
  const std::string across =
      "springs:\n  across: {between: [link_10, link_50], at: [[2, 0, 0], [10, 0, 1]], elastic: {stiffness: "
      "1}}\n";
  const std::string coupled = chain.substr(0, chain.find("springs:")) + across;
  const auto model = model_of(coupled);
  EXPECT_FALSE(splits_by_bodies(model->compiled()));
  EXPECT_EQ(model->compiled().symbolic.size(), model->compiled().velocities);
}

}  // namespace
}  // namespace mimbre::test::articulated_test
