#include "integrate/radau/radau.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "support/models.h"
#include "support/random_mechanism.h"
#include "support/run.h"
#include "support/simulate.h"
#include "support/smooth_mechanisms.h"

/// Radau IIA: its coefficients, its order, stiff and flexible mechanisms.
namespace mimbre::test::radau_test {
namespace {

using Rule = spec::Simulation::Integrator;

/// Σ A_ij c_j^(k−1) = c_i^k/k, and T⁻¹ A⁻¹ T as it is said to be.
TEST(RadauMethod, HasItsCoefficients) {
  Eigen::Matrix3d A, T, T_inverse;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      A(i, j) = radau::A[i][j];
      T(i, j) = radau::T[i][j];
      T_inverse(i, j) = radau::T_inverse[i][j];
    }
  for (int i = 0; i < 3; ++i)
    for (int k = 1; k <= 3; ++k) {
      double sum = 0;
      for (int j = 0; j < 3; ++j) sum += A(i, j) * std::pow(radau::c[j], k - 1);
      EXPECT_NEAR(sum, std::pow(radau::c[i], k) / k, 1e-15);
    }
  for (int k = 1; k <= 5; ++k) {  // the quadrature of the last row: of order 5
    double sum = 0;
    for (int j = 0; j < 3; ++j) sum += A(2, j) * std::pow(radau::c[j], k - 1);
    EXPECT_NEAR(sum, 1. / k, 1e-15);
  }
  EXPECT_LE((T * T_inverse - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  Eigen::Matrix3d expected;
  const auto [a, b] = std::pair(radau::alpha_beta.re, radau::alpha_beta.im);
  expected << radau::gamma, 0, 0, 0, a, -b, 0, b, a;
  EXPECT_LE((T_inverse * A.inverse() * T - expected).norm(), 1e-13);
  // The weights of the error take back the slope at the start.
  EXPECT_NEAR(radau::error[0] * radau::c[0] + radau::error[1] * radau::c[1] + radau::error[2], -1, 1e-14);
}

/// The factorised matrices against dense ones, of a flexible mechanism with loops in both formulations.
TEST(RadauMatrices, SolveTheRealAndTheComplexSystem) {
  RandomOptions options;
  options.springs = options.damping = true;
  options.loops = 1;
  const RandomMechanism mechanism = random_mechanism(3, options);
  const Compiled& model = mechanism.model->compiled();
  relative::RelativeSystem system(model);
  const State s = initial_state(mechanism.model);
  const int n = system.velocities();
  const double h = 0.01, penalty = 1e3;
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(n), none = Eigen::VectorXd::Zero(system.equations());
  Eigen::VectorXd r(n);
  system.begin_step(s.q.data());
  system.residual(0, s.q.data(), s.v.data(), zero.data(), none.data(), 0, r.data());
  const auto dense = [&](double damping, double stiffness) {
    Eigen::MatrixXd matrix(n, n);
    system.dense_matrix(s.q.data(), {damping, stiffness, penalty}, matrix.data());
    return matrix;
  };
  const Eigen::MatrixXd M = dense(0, 0), C = dense(1, 0) - M, K = dense(0, 1) - M;
  RadauMatrices matrices(system, penalty);
  ASSERT_TRUE(matrices.factor(s.q.data(), h).ok());
  const Eigen::VectorXd re = Eigen::VectorXd::LinSpaced(n, -1, 2), im = Eigen::VectorXd::LinSpaced(n, 3, 1);
  Eigen::VectorXd x = re;
  matrices.solve(x.data());
  const double g = h / radau::gamma;
  EXPECT_LE(((M + g * C + g * g * K) * x - re).norm(), 1e-8 * re.norm());
  std::vector<linalg::Complex> z(static_cast<std::size_t>(n));
  for (int k = 0; k < n; ++k) z[static_cast<std::size_t>(k)] = {re[k], im[k]};
  matrices.solve(z.data());
  const std::complex<double> e = h / std::complex<double>(radau::alpha_beta.re, radau::alpha_beta.im);
  Eigen::VectorXcd y(n), b(n);
  for (int k = 0; k < n; ++k) {
    y[k] = {z[static_cast<std::size_t>(k)].re, z[static_cast<std::size_t>(k)].im};
    b[k] = {re[k], im[k]};
  }
  const Eigen::MatrixXcd W = M.cast<std::complex<double>>() + e * C + e * e * K;
  EXPECT_LE((W * y - b).norm(), 1e-8 * b.norm());
}

class RadauOrder : public testing::TestWithParam<std::tuple<SmoothMechanism, Formulation>> {};

TEST_P(RadauOrder, IsFive) {
  const auto& [problem, formulation] = GetParam();
  const auto model = model_of(problem.text);
  VectorXd runs[3];
  for (int k = 0; k < 3; ++k) {
    RunOptions options = options_of(Rule::radau, problem.end / (problem.steps_of_radau << k));
    options.formulation = formulation;
    options.tolerance = 1e-8;
    runs[k] = run_with(model, options, problem.end);
  }
  EXPECT_NEAR(order(runs[0], runs[1], runs[2]), 5.1, 0.6);
}

/// The error of a run follows the accuracy, whatever the step, and leads to where dopri853 does.
TEST_P(RadauOrder, ErrorsFollowTheAccuracy) {
  const auto& [problem, formulation] = GetParam();
  const auto model = model_of(problem.text);
  const auto run_of = [&](Rule rule, double accuracy, double step) {
    RunOptions options = options_of(rule, step, accuracy);
    options.formulation = formulation;
    Simulation simulation(model, options);
    run_to(simulation, problem.end);
    const spec::Pose pose = simulation.pose(Simulation::Body{0});
    VectorXd seen(12);
    seen << pose.position, pose.rotation.reshaped();
    return seen;
  };
  const VectorXd exact = run_of(Rule::dopri853, 1e-13, problem.end / 10);
  double last = 1;
  for (const double accuracy : {1e-4, 1e-6, 1e-8, 1e-10}) {
    const double error = (run_of(Rule::radau, accuracy, problem.end) - exact).norm();
    EXPECT_LE(error, 100 * accuracy) << accuracy;
    EXPECT_LE(error, last) << accuracy;
    last = error + 1e-13;
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, RadauOrder,
                         testing::Combine(testing::ValuesIn(smooth_mechanisms()),
                                          testing::Values(Formulation::relative, Formulation::natural)),
                         [](const auto& row) {
                           return std::string(std::get<0>(row.param).name) +
                                  (std::get<1>(row.param) == Formulation::relative ? "_relative"
                                                                                   : "_natural");
                         });

/// The same motion as by dopri853 of random trees and loops with springs, dampers and drives.
TEST(Radau, MovesRandomMechanismsAsTheExplicitRuleDoes) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    RandomOptions options;
    options.springs = options.damping = options.loads = true;
    options.loops = static_cast<int>(seed % 3);
    options.flexible_share = 0;
    options.drives = options.loops == 0;
    const RandomMechanism mechanism = random_mechanism(seed, options);
    const double end = 0.1;
    const VectorXd exact = run_with(mechanism.model, options_of(Rule::dopri853, 1e-2, 1e-12), end);
    const VectorXd implicitly = run_with(mechanism.model, options_of(Rule::radau, 1e-2, 1e-9), end);
    EXPECT_LE((implicitly - exact).norm(), 1e-7 * exact.norm()) << seed;
  }
}

const char* const stiff_oscillator = R"(
gravity: [0, 0, 0]
bodies:
  mass: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}
joints:
  slide: {type: prismatic, between: [ground, mass], at: [0, 0, 0], axis: [1, 0, 0], position: 0.1, spring: {stiffness: 2e6, damping: 4e5}}
)";

/// A mass that a damper lets creep back, ẍ + 2e5 ẋ + 1e6 x = 0: explicit rules need steps of 3e-5 s. Radau
/// takes it with steps of 0.1 s.
TEST(Radau, TakesLongStepsThroughStiffMotion) {
  const auto model = model_of(stiff_oscillator);
  const double d = 2e5, w2 = 1e6, root = std::sqrt(d * d / 4 - w2);
  const double slow = -w2 / (d / 2 + root), fast = -d / 2 - root;
  const double exact = 0.1 * (fast * std::exp(slow * 1.0)) / (fast - slow);
  for (const double accuracy : {1e-5, 1e-8}) {
    Simulation simulation(model, options_of(Rule::radau, 0.1, accuracy));
    int factorisations = 0;
    while (simulation.time() < 0.9999) {
      const StepReport report = simulation.step();
      ASSERT_TRUE(report.ok());
      factorisations += report.factorisations;
    }
    EXPECT_NEAR(simulation.save().q[0], exact, 10 * accuracy);
    EXPECT_LE(factorisations, accuracy < 1e-6 ? 800 : 200);
  }
}

/// L-stable: what is much faster than the step is gone after one.
TEST(Radau, DampsWhatIsFasterThanTheStep) {
  const auto model = model_of(R"(
gravity: [0, 0, 0]
bodies:
  mass: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}
joints:
  slide: {type: prismatic, between: [ground, mass], at: [0, 0, 0], axis: [1, 0, 0], position: 0.1, spring: {stiffness: 2e12}}
)");
  Simulation simulation(model, options_of(Rule::radau, 0.1));
  ASSERT_TRUE(simulation.step().ok());
  EXPECT_LE(std::abs(simulation.save().q[0]), 1e-4);
}

/// A conservative mechanism keeps its energy to the accuracy.
TEST(Radau, EnergyDriftFollowsTheAccuracy) {
  const auto model = model_of(smooth_mechanisms()[1].text);
  const auto drift = [&](double accuracy) {
    RunOptions options = options_of(Rule::radau, 0.5, accuracy);
    options.energies = true;
    Simulation simulation(model, options);
    run_to(simulation, 20);
    return std::abs(simulation.energy().numerical) / 30;  // J, of about 30 J at play
  };
  EXPECT_LE(drift(1e-7), 1e-5);
  EXPECT_LE(drift(1e-9), 1e-7);
}

TEST(Radau, GoesOnFromASavedStateToTheSameBits) {
  const auto model = model_of(smooth_mechanisms()[5].text);
  for (const RunOptions& options : {options_of(Rule::radau, 0.01), options_of(Rule::radau, 0.05, 1e-9)}) {
    Simulation first(model, options), second(model, options);
    for (int k = 0; k < 5; ++k) ASSERT_TRUE(first.step().ok());
    second.restore(first.save());
    for (int k = 0; k < 5; ++k) {
      ASSERT_TRUE(first.step().ok());
      ASSERT_TRUE(second.step().ok());
    }
    EXPECT_EQ(first.save().q, second.save().q);
    EXPECT_EQ(first.save().v, second.save().v);
    EXPECT_EQ(first.save().memory, second.save().memory);
  }
}

/// A ball that falls on a plane, and bounces with half its speed.
TEST(Radau, RestartsAtImpacts) {
  const auto model = model_of(R"(
bodies:
  ball: {mass: 1, com: [0, 0, 0], inertia: [0.01, 0.01, 0.01]}
joints:
  free: {type: floating, between: [ground, ball], position: [0, 0, 1.1, 0, 0, 0]}
surfaces: {floor: {type: half_space}}
contacts:
  bounce: {spheres: {on: ball, radius: 0.1}, surfaces: [floor], stiffness: 1e7, restitution: 0.5}
)");
  const double impact = std::sqrt(2 * 1 / 9.81), end = impact + impact / 2;  // at the top of the bounce
  Simulation simulation(model, options_of(Rule::radau, 0.01, 1e-8));
  while (simulation.time() < end - 0.011) ASSERT_TRUE(simulation.step().ok());
  ASSERT_TRUE(simulation.step_to(end).ok());
  EXPECT_NEAR(simulation.save().q[2] - 0.1, 0.25, 0.01);
}

/// Runs of a beam that bends and of the flexible vehicle over its stairs approach those of the default rule
/// with smaller steps.
TEST(Radau, AgreesWithFineRunsOfTheDefaultOnFlexibleBodies) {
  const auto model = example("pendulum/flexible.yaml");
  const auto by_default = [&](double step) {
    RunOptions options;
    options.step = step;
    options.rho = 0.9;
    options.tolerance = 1e-9;
    return run_with(model, options, 0.2);
  };
  const VectorXd coarse = by_default(1e-4), fine = by_default(5e-5), exact = fine + (fine - coarse) / 3;
  const VectorXd found = run_with(model, options_of(Rule::radau, 0.01, 1e-9), 0.2);
  EXPECT_LE((found - exact).norm(), 0.05 * (fine - exact).norm() + 1e-7 * exact.norm());
}

TEST(Radau, RefusesWhatDoesNotFit) {
  const auto model = model_of(stiff_oscillator);
  const auto refused = [&](const RunOptions& options) {
    try {
      Simulation simulation(model, options);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  RunOptions options = options_of(Rule::radau, 1e-3);
  options.formalism = spec::Simulation::Formalism::penalty;
  EXPECT_THAT(refused(options), testing::HasSubstr("radau has no formalism"));
  options = options_of(Rule::radau, 1e-3, 1e-6);
  options.fixed_cost = true;
  EXPECT_THAT(refused(options), testing::HasSubstr("has an accuracy to keep"));
}

}  // namespace
}  // namespace mimbre::test::radau_test
