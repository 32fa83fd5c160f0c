#include "mimbre/campbell.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>

#include "support/random_mechanism.h"

/// Modes followed over a parameter.
namespace mimbre::test::campbell_test {
namespace {

/// The modes of ẍ + K x = 0, in the order of their frequencies.
LinearisedModes modes_of(const MatrixXd& K) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(K);
  const Eigen::Index n = K.rows();
  LinearisedModes out;
  for (Eigen::Index k = 0; k < n; ++k) {
    const std::complex<double> lambda(0, std::sqrt(solver.eigenvalues()[k]));
    const Eigen::VectorXcd phi = solver.eigenvectors().col(k).cast<std::complex<double>>();
    Mode mode;
    mode.value = lambda;
    mode.motion = phi;
    mode.shape.resize(2 * n);
    mode.shape << phi, lambda * phi;
    mode.left.resize(2 * n);
    mode.left << 0.5 * phi, 0.5 / std::conj(lambda) * phi;
    mode.text = "mode " + std::to_string(k + 1);
    out.modes.push_back(mode);
  }
  return out;
}

std::vector<double> from_zero_to_one(int count) {
  std::vector<double> values;
  for (int k = 0; k < count; ++k) values.push_back(k / (count - 1.0));
  return values;
}

/// K = Q diag(a + b p) Qᵀ: every pair of modes that crosses does so with shapes that stay. Each branch is a
/// line.
TEST(Campbell, FollowsModesThroughCrossings) {
  int crossings = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    constexpr int n = 9;
    const MatrixXd Q = Eigen::HouseholderQR<MatrixXd>(random.values(n * n, 1).reshaped(n, n)).householderQ();
    const VectorXd a = random.values(n, 1).array() + 3, b = random.values(n, 1.8);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < i; ++j) crossings += (a[i] - a[j]) * (a[i] + b[i] - a[j] - b[j]) < 0 ? 1 : 0;
    const CampbellDiagram d =
        campbell([&](double p) { return modes_of(Q * (a + b * p).asDiagonal() * Q.transpose()); },
                 from_zero_to_one(11));
    ASSERT_EQ(d.branches.size(), static_cast<std::size_t>(n));
    EXPECT_TRUE(d.warnings.empty());
    for (const ModeBranch& branch : d.branches) {
      const auto square = [&](std::size_t k) { return std::norm(branch.values[k]); };
      for (std::size_t k = 0; k < d.values.size(); ++k)
        EXPECT_NEAR(square(k), square(0) + (square(10) - square(0)) * d.values[k], 1e-9);
    }
  }
  EXPECT_GT(crossings, 400);
}

/// A family of two parameters, K = Q diag(a + b p + c p') Qᵀ along random lines through it: more than 1000
/// crossings, each branch a line as it is by continuation in tiny steps.
TEST(Campbell, KeepsNamesThroughAThousandCrossingsOfAFamilyOfTwoParameters) {
  int crossings = 0, lines = 0;
  for (unsigned seed = 1; crossings < 1000; ++seed, ++lines) {
    Random random(7000 + seed);
    constexpr int n = 12;
    const MatrixXd Q = Eigen::HouseholderQR<MatrixXd>(random.values(n * n, 1).reshaped(n, n)).householderQ();
    const VectorXd a = random.values(n, 1).array() + 4, b = random.values(n, 1.5), c = random.values(n, 1.5);
    const double from = random.number(-0.5, 0.5), to = random.number(-0.5, 0.5);
    const auto square = [&](double p, int k) { return a[k] + b[k] * p + c[k] * (from + (to - from) * p); };
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < i; ++j)
        crossings += (square(0, i) - square(0, j)) * (square(1, i) - square(1, j)) < 0 ? 1 : 0;
    const CampbellDiagram d = campbell(
        [&](double p) {
          VectorXd squares(n);
          for (int k = 0; k < n; ++k) squares[k] = square(p, k);
          return modes_of(Q * squares.asDiagonal() * Q.transpose());
        },
        from_zero_to_one(6));
    ASSERT_EQ(d.branches.size(), static_cast<std::size_t>(n));
    EXPECT_TRUE(d.warnings.empty());
    for (const ModeBranch& branch : d.branches) {
      const double first = std::norm(branch.values.front()), last = std::norm(branch.values.back());
      bool known = false;
      for (int k = 0; k < n; ++k)
        known = known || (std::abs(square(0, k) - first) < 1e-9 && std::abs(square(1, k) - last) < 1e-9);
      EXPECT_TRUE(known) << seed;
    }
  }
}

/// Two modes that come near and part again, weakly coupled, exchange their shapes and never meet: as a family
/// of one parameter moves in tiny steps, the lower one stays the lower one.
TEST(Campbell, FollowsModesThroughVeerings) {
  for (const double coupling : {1e-1, 1e-2, 1e-3, 1e-4}) {
    const CampbellDiagram d = campbell(
        [&](double p) {
          MatrixXd K(2, 2);
          K << 1 + p, coupling, coupling, 2 - p;
          return modes_of(K);
        },
        from_zero_to_one(4));
    ASSERT_EQ(d.branches.size(), 2u);
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_LT(d.branches[0].values[k].imag(), d.branches[1].values[k].imag()) << coupling;
  }
}

/// A round body: both its modes are equal at p = 0, and part as gyroscopic terms do.
TEST(Campbell, PartsEqualModes) {
  const CampbellDiagram d = campbell(
      [](double p) {
        MatrixXd K(3, 3);
        K << 4 + p, p, 0, p, 4 + p, 0, 0, 0, 9;
        return modes_of(K);
      },
      from_zero_to_one(5));
  ASSERT_EQ(d.branches.size(), 3u);
  for (const ModeBranch& branch : d.branches) {
    const double first = std::norm(branch.values[0]), last = std::norm(branch.values[4]);
    for (std::size_t k = 0; k < 5; ++k)
      EXPECT_NEAR(std::norm(branch.values[k]), first + (last - first) * d.values[k], 1e-9);
  }
}

/// ω = 3 − Ω/2 and ω = 3 + Ω/2 have the speed at 2 and at 6.
TEST(Campbell, FindsCriticalSpeeds) {
  CampbellOptions options;
  options.parameter = "speed";
  const CampbellDiagram d = campbell(
      [](double p) {
        MatrixXd K = MatrixXd::Zero(2, 2);
        K.diagonal() << std::pow(3 - p / 2, 2), std::pow(3 + p / 2, 2);
        return modes_of(K);
      },
      {0.1, 1.5, 3, 4, 5, 5.9}, options);
  ASSERT_EQ(d.criticals.size(), 1u);
  EXPECT_NEAR(d.criticals[0].value, 2, 1e-6);
  EXPECT_NEAR(d.criticals[0].frequency, 2, 1e-6);
}

TEST(Campbell, FindsWhereAModeBeginsToGrow) {
  const CampbellDiagram d = campbell(
      [](double p) {
        LinearisedModes found = modes_of(MatrixXd::Identity(1, 1) * 4);
        found.modes[0].value = {p - 0.3, 2};
        return found;
      },
      from_zero_to_one(4));
  ASSERT_EQ(d.onsets.size(), 1u);
  EXPECT_TRUE(d.onsets[0].grows);
  EXPECT_NEAR(d.onsets[0].value, 0.3, 1e-6);
}

/// ẍ + K x = 0 with K = [1 p; −p 2], as of forces that follow: λ² = −3/2 ± √(1/4 − p²), so that two modes
/// meet at p = 1/2, where nothing is damped, and one of them grows from there on.
TEST(Campbell, FindsWhereModesGrowThatAreNotDamped) {
  const CampbellDiagram d = campbell(
      [](double p) {
        LinearisedModes found = modes_of(MatrixXd::Identity(2, 2));
        for (int k = 0; k < 2; ++k) {
          Mode& mode = found.modes[static_cast<std::size_t>(k)];
          const std::complex<double> square =
              -1.5 + (k == 0 ? 1. : -1.) * std::sqrt(std::complex<double>(0.25 - p * p));
          std::complex<double> lambda = std::sqrt(square);
          if (lambda.imag() < 0) lambda = -lambda;
          mode.value = lambda;
          Eigen::Vector2cd x(p, -1. - square), w(-p, -1. - square);
          if (p == 0) x = w = k == 0 ? Eigen::Vector2cd(1, 0) : Eigen::Vector2cd(0, 1);
          mode.motion = x;
          mode.shape << x, lambda * x;
          const std::complex<double> product = 2. * lambda * (w.transpose() * x)(0, 0);
          mode.left << (lambda * w / product).conjugate(), (w / product).conjugate();
        }
        return found;
      },
      from_zero_to_one(4));
  ASSERT_EQ(d.onsets.size(), 1u);
  EXPECT_TRUE(d.onsets[0].grows);
  EXPECT_NEAR(d.onsets[0].value, 0.5, 1e-6);
  EXPECT_NEAR(d.onsets[0].frequency, std::sqrt(1.5), 0.1);
}

}  // namespace
}  // namespace mimbre::test::campbell_test
