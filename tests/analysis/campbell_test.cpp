#include "mimbre/campbell.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <string>
#include <vector>

#include "support/models.h"
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
  EXPECT_NEAR(d.onsets[0].frequency, std::sqrt(1.5), 1e-4);
}

/// A pendulum that a spring holds upright falls where k < m g l, wherever the values are: at that of the
/// onset the mode has no frequency, and at halves that fall on it.
TEST(Campbell, FindsWhereAPendulumStandsUpright) {
  const auto model = [](double k) {
    ModesOptions options;
    options.linear.point.at = LinearPoint::At::start;
    return find_modes(
        model_of(fmt::format(
            "gravity: [0, 0, -9.81]\nbodies:\n  p: {{mass: 1, com: [0, 0, 1], inertia: [0.01, 0.01, 0.01]}}\n"
            "joints:\n  j: {{type: revolute, between: [ground, p], at: [0, 0, 0], axis: [0, 1, 0], "
            "spring: {{stiffness: {:.17g}, damping: 0.5}}}}\n",
            k)),
        options);
  };
  CampbellOptions options;
  options.rad_per_second = 0;
  for (const std::vector<double>& values : std::vector<std::vector<double>>{
           {5, 9, 13}, {8.81, 10.81}, {8.81, 9.81, 10.81}, {9.31, 9.51, 9.81, 10.31}, {9.81, 10, 11}}) {
    const CampbellDiagram d = campbell(model, values, options);
    if (values[0] == 9.81) {
      EXPECT_TRUE(d.onsets.empty());
      continue;
    }
    ASSERT_EQ(d.onsets.size(), 1u) << values[0] << ' ' << values.size();
    EXPECT_FALSE(d.onsets[0].grows);
    EXPECT_NEAR(d.onsets[0].value, 9.81, 1e-5);
  }
}

/// The ground sees two frequencies of each mode of a rotor that is not round. All are listed as in the axes
/// that turn with it: for the translation (k − m Ω² − m λ²)² … = 0, λ = ±i (√(k/m) ± Ω) where the centre of
/// mass has no part in the tilting.
TEST(Campbell, ListsRotorsThatAreNotRoundInTheirOwnAxes) {
  const auto model = [](double w) {
    ModesOptions options;
    options.linear.point.at = LinearPoint::At::steady;
    return find_modes(
        model_of(fmt::format(
            "gravity: [0, 0, 0]\nbodies:\n  rotor: {{mass: 10, com: [0, 0, 0], inertia: [0.1, 0.2, 0.26]}}\n"
            "joints:\n  free: {{type: floating, between: [ground, rotor], at: [0, 0, 0], velocity: [0, 0, 0, "
            "{:.17g}, 0, 0]}}\nbushings:\n"
            "  left: {{between: [ground, rotor], at: [-0.2, 0, 0], stiffness: [9e7, 1e5, 1e5, 0, 0, 0]}}\n"
            "  right: {{between: [ground, rotor], at: [0.2, 0, 0], stiffness: [0, 1e5, 1e5, 0, 0, 0]}}\n",
            w)),
        options);
  };
  const std::vector<double> values{20, 40, 60, 80};
  const CampbellDiagram d = campbell(model, values, {});
  EXPECT_TRUE(d.criticals.empty());
  EXPECT_THAT(d.warnings, testing::Contains(testing::HasSubstr("not round")));
  const double natural = std::sqrt(2e4);
  for (std::size_t k = 0; k < values.size(); ++k)
    for (const double expected : {natural - values[k], natural + values[k]}) {
      double nearest = 1e9;
      for (const ModeBranch& b : d.branches)
        nearest = std::min(nearest, std::abs(b.values[k].imag() - expected));
      EXPECT_LT(nearest, 1e-5 * expected) << values[k];
    }
}

/// Two modes that cross on straight lines: the place is found by these, not by halves (16 of which it would
/// take to come as near).
TEST(Campbell, FindsCrossingsWithFewEvaluations) {
  const CampbellDiagram d = campbell(
      [](double p) {
        MatrixXd K = MatrixXd::Zero(2, 2);
        K.diagonal() << std::pow(2 + p, 2), std::pow(2.7 - p, 2);
        return modes_of(K);
      },
      {0, 1});
  EXPECT_NEAR(d.branches[0].values[1].imag(), 3, 1e-12);
  EXPECT_LE(d.evaluations, 9);
}

/// Re λ = h − (p − c)² grows within √h of c, between values at which nothing grows; or nowhere.
TEST(Campbell, FindsGrowthBetweenTheValues) {
  for (const double middle : {0.4, 0.5, 0.61})
    for (const double height : {-1e-3, 1e-3, 4e-3}) {
      const CampbellDiagram d = campbell(
          [&](double p) {
            LinearisedModes found = modes_of(MatrixXd::Identity(1, 1) * 4);
            found.modes[0].value = {height - (p - middle) * (p - middle), 2 + p};
            return found;
          },
          from_zero_to_one(4));
      ASSERT_EQ(d.onsets.size(), height > 0 ? 2u : 0u) << middle << " " << height;
      for (std::size_t k = 0; k < d.onsets.size(); ++k) {
        const double expected = middle + (k == 0 ? -1 : 1) * std::sqrt(height);
        EXPECT_EQ(d.onsets[k].grows, k == 0);
        EXPECT_NEAR(d.onsets[k].value, expected, 1e-6);
        EXPECT_NEAR(d.onsets[k].frequency, 2 + expected, 1e-5);
      }
    }
}

/// ẍ + (10 + a) x + y = 0, ÿ + (10 − a) y − x = 0: λ² = −10 ± √(a² − 1) grows where |a| < 1, at once with
/// ω = √10 at both ends, and at |a| > √101 without turning back. Wherever the values are, at a = ±1 too,
/// where both modes are one.
TEST(Campbell, FindsWhereAModeCeasesToGrow) {
  const auto model = [](double a) {
    ModesOptions options;
    return find_modes(
        model_of(fmt::format(
            "gravity: [0, 0, 0]\nbodies:\n  m1: {{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}\n"
            "  m2: {{mass: 1, com: [1, 0, 0], inertia: [1, 1, 1]}}\njoints:\n"
            "  x: {{type: prismatic, between: [ground, m1], at: [0, 0, 0], axis: [0, 0, 1]}}\n"
            "  y: {{type: prismatic, between: [ground, m2], at: [1, 0, 0], axis: [0, 0, 1]}}\n"
            "outputs: [{{name: px, joint: x}}, {{name: py, joint: y}}]\nactuators:\n"
            "  fx: {{joint: x, force: \"-{}*px - 1*py\"}}\n  fy: {{joint: y, force: \"-{}*py + 1*px\"}}\n",
            10 + a, 10 - a)),
        options);
  };
  CampbellOptions options;
  options.rad_per_second = 0;
  for (const std::vector<double>& values : std::vector<std::vector<double>>{
           {0, 4, 9}, {0.1, 2.55, 5}, {-3, -1, 1, 3}, {-7, 1, 9}, {-3, 0.3, 3}}) {
    const CampbellDiagram d = campbell(model, values, options);
    const bool begins = values[0] < -1;
    ASSERT_EQ(d.onsets.size(), begins ? 2u : 1u) << values[0];
    if (begins) {
      EXPECT_NEAR(d.onsets[0].value, -1, 1e-6);
    }
    EXPECT_EQ(d.onsets[0].grows, begins);
    EXPECT_FALSE(d.onsets.back().grows);
    EXPECT_NEAR(d.onsets.back().value, 1, 1e-6);
    for (const CampbellDiagram::Onset& onset : d.onsets) EXPECT_NEAR(onset.frequency, std::sqrt(10), 1e-4);
  }
}

/// A rigid rotor that turns as a whole in two round bearings: with z = x + i y of its centre and its
/// inclination, M z̈ + (C − i Ω G) ż + K z = 0, M = diag(m, Id), G = diag(0, Ip).
struct RigidRotor {
  double mass, across, about, first, second, stiff_first, stiff_second, damped;

  LinearisedModes modes(double speed, int most = 0) const {
    ModesOptions options;
    options.linear.point.at = LinearPoint::At::steady;
    options.most = most;
    const auto bushing = [&](const char* name, double at, double stiffness, double along) {
      return fmt::format(
          "  {0}: {{between: [ground, rotor], at: [{1:.17g}, 0, 0], stiffness: [{3:.17g}, {2:.17g}, "
          "{2:.17g}, 0, "
          "0, 0], damping: [0, {4:.17g}, {4:.17g}, 0, 0, 0]}}\n",
          name, at, stiffness, along, damped * stiffness);
    };
    return find_modes(
        model_of(
            fmt::format("gravity: [0, 0, 0]\nbodies:\n  rotor: {{mass: {:.17g}, com: [0, 0, 0], inertia: "
                        "[{:.17g}, {:.17g}, {:.17g}]}}\njoints:\n  free: {{type: floating, between: [ground, "
                        "rotor], at: [0, 0, 0], velocity: [0, 0, 0, {:.17g}, 0, 0]}}\nbushings:\n",
                        mass, about, across, across, speed) +
            bushing("left", first, stiff_first, 9e7) + bushing("right", second, stiff_second, 0)),
        options);
  }
  Eigen::Matrix2d stiffness() const {
    Eigen::Matrix2d K;
    K(0, 0) = stiff_first + stiff_second;
    K(0, 1) = K(1, 0) = stiff_first * first + stiff_second * second;
    K(1, 1) = stiff_first * first * first + stiff_second * second * second;
    return K;
  }
  /// Where nothing is damped: det(K − Ω² diag(m, Id ∓ Ip)) = 0 for whirl forward and backward.
  std::vector<double> criticals(double last) const {
    std::vector<double> out;
    for (const double sense : {1., -1.}) {
      const Eigen::Vector2d inverse(1 / mass, 1 / (across - sense * about));
      const Eigen::Matrix2d A = inverse.asDiagonal() * stiffness();
      for (const std::complex<double>& square : A.eigenvalues())
        if (square.real() > 0 && std::sqrt(square.real()) < last) out.push_back(std::sqrt(square.real()));
    }
    std::sort(out.begin(), out.end());
    return out;
  }
  /// Im λ of what is nearest to it at the speed.
  double nearest(double speed, double imaginary) const {
    Eigen::Matrix4cd A = Eigen::Matrix4cd::Zero();
    const std::complex<double> i(0, 1);
    const Eigen::Vector2d inverse(1 / mass, 1 / across);
    A.topRightCorner(2, 2).setIdentity();
    const Eigen::Matrix2d by_mass = inverse.asDiagonal() * stiffness();
    A.bottomLeftCorner(2, 2) = -by_mass.cast<std::complex<double>>();
    A.bottomRightCorner(2, 2) = -damped * by_mass.cast<std::complex<double>>();
    A(3, 3) += i * speed * about / across;
    const Eigen::ComplexEigenSolver<Eigen::Matrix4cd> solver(A);
    double best = 1e300;
    for (const std::complex<double>& value : solver.eigenvalues())
      if (std::abs(std::abs(value.imag()) - imaginary) < std::abs(best - imaginary))
        best = std::abs(value.imag());
    return best;
  }
};

RigidRotor random_rotor(Random& random, double damped) {
  const double across = random.number(0.1, 0.3);
  return {random.number(5, 15),
          across,
          across * random.number(0.2, 1.6),
          random.number(-0.3, -0.1),
          random.number(0.1, 0.3),
          random.number(5e4, 2e5),
          random.number(5e4, 2e5),
          damped};
}

std::vector<double> evenly(double first, double last, int count) {
  std::vector<double> values;
  for (int k = 0; k < count; ++k) values.push_back(first + (last - first) * k / (count - 1));
  return values;
}

/// All criticals, whatever the values are, also if one of them is critical: in axes that turn the mode stands
/// still there.
TEST(Campbell, CriticalSpeedsOfRotorsThatTurnAsAWhole) {
  int forward = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Random random(100 + seed);
    const RigidRotor rotor = random_rotor(random, 0);
    const double last = 420;
    const std::vector<double> expected = rotor.criticals(last);
    forward += static_cast<int>(expected.size());
    std::vector<std::vector<double>> grids;
    for (const int count : {3, 5, 12, 31}) grids.push_back(evenly(0, last, count));
    grids.push_back(evenly(0, last, 4));
    for (const double critical : expected) grids.back().push_back(critical);
    std::sort(grids.back().begin(), grids.back().end());
    for (const std::vector<double>& values : grids) {
      const CampbellDiagram d = campbell([&](double speed) { return rotor.modes(speed); }, values);
      ASSERT_EQ(d.criticals.size(), expected.size()) << seed << " " << values.size();
      for (std::size_t k = 0; k < expected.size(); ++k) {
        EXPECT_NEAR(d.criticals[k].value, expected[k], 1e-7 * expected[k]) << seed << " " << values.size();
        EXPECT_NEAR(d.criticals[k].frequency, expected[k], 1e-7 * expected[k]);
      }
      EXPECT_TRUE(d.onsets.empty());
    }
  }
  EXPECT_GT(forward, 30);
}

/// With damping at rest λ has the frequency of the speed by equations of complex coordinates.
TEST(Campbell, CriticalSpeedsOfDampedRotors) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Random random(200 + seed);
    const RigidRotor rotor = random_rotor(random, random.number(1e-5, 4e-4));
    std::vector<double> first;
    for (const int count : {5, 14}) {
      const CampbellDiagram d =
          campbell([&](double speed) { return rotor.modes(speed); }, evenly(0, 420, count));
      ASSERT_GE(d.criticals.size(), 2u);
      std::vector<double> found;
      for (const CampbellDiagram::Critical& c : d.criticals) {
        found.push_back(c.value);
        EXPECT_NEAR(rotor.nearest(c.value, c.value), c.value, 1e-7 * c.value) << seed;
      }
      if (first.empty()) first = found;
      ASSERT_EQ(found.size(), first.size());
      for (std::size_t k = 0; k < found.size(); ++k) EXPECT_NEAR(found[k], first[k], 1e-7 * first[k]);
    }
  }
}

/// The lowest modes of what turns are those of the lowest frequencies from the ground, in their order.
TEST(Campbell, TheLowestModesAreThoseThatTheGroundSees) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Random random(300 + seed);
    const RigidRotor rotor = random_rotor(random, 0);
    for (const double speed : {90., 230., 410.}) {
      const LinearisedModes all = rotor.modes(speed);
      std::vector<double> frequencies;
      for (const Mode& mode : all.modes) frequencies.push_back(std::abs(mode.seen()));
      EXPECT_TRUE(std::is_sorted(frequencies.begin(), frequencies.end()));
      for (const Mode& mode : all.modes)
        if (std::abs(mode.seen()) > 1 && std::abs(mode.whirl) > 0.9) {
          EXPECT_NEAR(rotor.nearest(speed, mode.seen().imag()), mode.seen().imag(), 1e-7 * speed);
        }
      const LinearisedModes few = rotor.modes(speed, 3);
      ASSERT_EQ(few.modes.size(), 3u);
      for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(few.modes[k].value, all.modes[k].value);
    }
  }
}

}  // namespace
}  // namespace mimbre::test::campbell_test
