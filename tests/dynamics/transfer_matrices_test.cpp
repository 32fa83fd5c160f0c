#include "dynamics/relative/transfer_matrices.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/dense.h"
#include "support/models.h"
#include "support/probe.h"
#include "support/random_mechanism.h"

/// Riccati's sweep along the bodies: with the sparse matrix of the same mechanisms as the measure.
namespace mimbre::test::transfer_matrices_test {
namespace {

RandomOptions all_forces() {
  RandomOptions o;
  o.springs = o.damping = o.loads = true;
  return o;
}

/// The largest residual of the solution by transfer matrices with the whole matrix, by the sizes of its
/// terms.
double error_of_solution(const RandomMechanism& mechanism, unsigned seed, const MatrixWeights& weights) {
  const Compiled& m = mechanism.compiled();
  relative::RelativeSystem system(m);
  Random random(seed);
  const VectorXd q = random_position(system, random, 0.5);
  const int n = system.velocities();
  const VectorXd v = random.values(n, 1), a = random.values(n, 1), none = VectorXd::Zero(system.equations());
  VectorXd r(n);
  system.begin_step(q.data());
  const auto evaluate = [&] { system.residual(0, q.data(), v.data(), a.data(), none.data(), 0, r.data()); };
  evaluate();
  MatrixXd A(n, n);
  system.dense_matrix(q.data(), weights, A.data());
  evaluate();
  relative::Workspace<double>& w = system.workspace();
  relative::motion_subspaces<double>(m, w, q.data());
  relative::TransferMatrices<double> transfer(m);
  EXPECT_EQ(transfer.factor(m, w, q.data(), weights, system.penalty(), relative::NoMarks{}), -1) << seed;
  const VectorXd b = random.values(n, 1);
  VectorXd x = b;
  transfer.solve(m, w, x.data());
  return (A * x - b).cwiseAbs().maxCoeff() / (A.cwiseAbs() * x.cwiseAbs()).maxCoeff();
}

/// Trees of rigid and flexible bodies with springs and dampers between any of them, tyres and drives.
TEST(TransferMatrices, SolveWithTheMatrixOfATree) {
  int across = 0, branches = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    RandomOptions options = all_forces();
    options.bodies = 2 + static_cast<int>(seed % 9);
    options.flexible_share = seed % 3 * 0.5;
    options.tyres = seed % 2 == 0;
    options.drives = seed % 5 == 0;
    const RandomMechanism mechanism = random_mechanism(seed, options);
    const relative::TransferPlan plan(mechanism.compiled());
    for (const relative::CoupledRows& r : plan.rows) {
      across += r.unknown >= 0;
      bool ends_on_path = false;
      for (const PathEntry& e : r.path->entries) ends_on_path = ends_on_path || e.body == r.node;
      branches += r.unknown >= 0 && !ends_on_path;
    }
    EXPECT_LE(error_of_solution(mechanism, seed, {0.02, 3e-3, 1e4}), 1e-12) << seed;
  }
  EXPECT_GE(across, 100);
  EXPECT_GE(branches, 20);
}

/// Loops are forces of their equations between bodies, with the penalty of a step as their stiffness.
TEST(TransferMatrices, SolveWithTheMatrixOfLoops) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    RandomOptions options = all_forces();
    options.bodies = 3 + static_cast<int>(seed % 7);
    options.loops = 1 + static_cast<int>(seed % 3);
    options.flexible_share = seed % 2 * 0.5;
    EXPECT_LE(error_of_solution(random_mechanism(seed, options), seed, {0.02, 3e-3, 1e4}), 1e-10) << seed;
  }
}

/// Multiplications of a factorisation and a solution, by the sizes of the blocks.
double operations(const relative::TransferPlan& plan) {
  double sum = 0;
  for (const relative::TransferNode& node : plan.nodes) {
    const double n = node.unknowns, size = node.size, above = node.parent < 0 ? 0 : 6;
    sum += n * n * n / 3 + 2 * n * n * size + n * size * size + 2 * n * size + above * above * n +
           static_cast<double>(node.passes.size() * node.passes.size());
  }
  return sum;
}

/// A chain of revolute joints, with springs over three of them, on the ground.
std::string chain_with_springs(int links) {
  std::string bodies = "bodies:\n", joints = "joints:\n", springs = "springs:\n";
  for (int k = 0; k < links; ++k) {
    bodies += fmt::format("  b{}: {{mass: 1, com: [{}, 0, 0], inertia: [1, 1, 1]}}\n", k, k + 0.5);
    joints += fmt::format("  j{}: {{type: revolute, between: [{}, b{}], at: [{}, 0, 0], axis: [0, 1, 0]}}\n",
                          k, k == 0 ? "ground" : fmt::format("b{}", k - 1), k, k);
    if (k >= 3)
      springs += fmt::format(
          "  s{0}: {{between: [b{1}, b{0}], at: [[{1}, 0, 1], [{0}, 0, 1]], elastic: {{stiffness: 1}}}}\n", k,
          k - 3);
  }
  return bodies + joints + springs;
}

/// No state vector grows with the chain, so that each further link costs the same.
TEST(TransferMatrices, CostTheSameForEachLinkOfAChain) {
  double cost[3];
  for (const int k : {0, 1, 2}) {
    const auto model = model_of(chain_with_springs(50 << k));
    const relative::TransferPlan plan(model->compiled());
    int longest = 0;
    for (const relative::TransferNode& node : plan.nodes) longest = std::max(longest, node.size);
    EXPECT_EQ(longest, 6 + 2);  // a spring passes two of the joints between its bodies, and ends at the third
    cost[k] = operations(plan);
  }
  EXPECT_NEAR(cost[2] - cost[1], 2 * (cost[1] - cost[0]), 1e-9 * cost[0]);
}

/// W = L σ Lᵀ of tangents that are positive, negative, both, of lower rank and none.
TEST(TransferMatrices, FindSignedRootsOfTangents) {
  Random random(7);
  for (int n = 1; n <= 6; ++n)
    for (int round = 0; round < 20; ++round) {
      const int rank = round % (n + 1);
      MatrixXd W = MatrixXd::Zero(n, n);
      for (int k = 0; k < rank; ++k) {
        const VectorXd column = random.values(n, 1e3);
        W += (round % 3 == 0 && k == 0 ? -1 : 1) * column * column.transpose();
      }
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> left = W, root(n, n);
      VectorXd signs(n);
      relative::signed_root(n, left.data(), root.data(), signs.data());
      const MatrixXd product = root * signs.asDiagonal() * root.transpose();
      EXPECT_LE((product - W).cwiseAbs().maxCoeff(), 1e-9 * (1 + W.cwiseAbs().maxCoeff()))
          << n << ' ' << round;
    }
}

}  // namespace
}  // namespace mimbre::test::transfer_matrices_test
