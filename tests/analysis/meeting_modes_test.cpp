#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "mimbre/campbell.h"
#include "mimbre/trim.h"
#include "support/models.h"
#include "support/random_mechanism.h"

/// Real modes that meet and part, and rigid motions, over a parameter.
namespace mimbre::test::meeting_modes_test {
namespace {

using Complex = std::complex<double>;

/// The modes of ẋ = A x, in the order of |λ|.
LinearisedModes modes_of(const MatrixXd& A) {
  const Eigen::EigenSolver<MatrixXd> solver(A);
  const Eigen::MatrixXcd left = solver.eigenvectors().inverse();
  LinearisedModes out;
  for (Eigen::Index k = 0; k < A.rows(); ++k) {
    const Complex value = solver.eigenvalues()[k];
    if (value.imag() < 0) continue;
    Mode mode;
    mode.value = mode.fixed = value;
    mode.kind = value.imag() > 0 ? Mode::Kind::oscillating : Mode::Kind::real;
    mode.shape = mode.motion = solver.eigenvectors().col(k);
    mode.left = left.row(k).adjoint();
    mode.text = fmt::format("{:.4g} {:.4g}", value.real(), value.imag());
    out.modes.push_back(mode);
  }
  std::sort(out.modes.begin(), out.modes.end(),
            [](const Mode& a, const Mode& b) { return std::abs(a.value) < std::abs(b.value); });
  out.zeros = 0;
  return out;
}

std::vector<double> range(double from, double to, int count) {
  std::vector<double> out;
  for (int k = 0; k < count; ++k) out.push_back(from + (to - from) * k / (count - 1));
  return out;
}

CampbellDiagram over(const std::function<MatrixXd(double)>& family, const std::vector<double>& values) {
  CampbellOptions options;
  options.parameter = "p";
  options.rad_per_second = 0;
  return campbell([&](double p) { return modes_of(family(p)); }, values, options);
}

void expect_unbroken(const CampbellDiagram& d, std::size_t count) {
  EXPECT_TRUE(d.warnings.empty()) << d.warnings.front();
  ASSERT_EQ(d.branches.size(), count);
  for (const ModeBranch& b : d.branches)
    for (const Complex& value : b.values) EXPECT_TRUE(std::isfinite(value.real())) << b.name;
}

/// ẍ + 2 D ẋ + x = 0: λ = −D ± √(D² − 1) are a pair up to D = 1.
TEST(MeetingModes, OfAnOscillatorOverItsDamping) {
  const auto family = [](double p) {
    const double damping = std::abs(p);
    MatrixXd A(2, 2);
    A << 0, 1, -1, -2 * damping;
    return A;
  };
  for (const bool parts : {false, true}) {
    const std::vector<double> values = parts ? range(0.3, 1.9, 7) : range(-1.9, -0.3, 7);
    const CampbellDiagram d = over(family, values);
    expect_unbroken(d, 2);
    ASSERT_EQ(d.meetings.size(), 1u);
    EXPECT_EQ(d.meetings[0].parts, parts);
    EXPECT_NEAR(std::abs(d.meetings[0].value), 1, 2e-5);
    EXPECT_NEAR(d.meetings[0].real, -1, 1e-3);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double damping = std::abs(values[k]);
      const Complex root = std::sqrt(Complex(damping * damping - 1));
      for (const Complex expected : {-damping + root, -damping - root}) {
        const bool found = std::abs(d.branches[0].values[k] - expected) < 1e-12 ||
                           std::abs(d.branches[1].values[k] - expected) < 1e-12;
        EXPECT_TRUE(found) << damping;
      }
      // The one with the conjugate names the other one.
      for (std::size_t b = 0; b < 2; ++b)
        EXPECT_EQ(d.branches[b].half_of[k],
                  d.branches[b].values[k].imag() < 0 ? static_cast<int>(1 - b) : -1);
    }
  }
}

/// (λ + a)² = (p − 0.3) (p − 0.7) in random coordinates, among pairs and real modes that have nothing to do
/// with it: meets at 0.3 and parts at 0.7, in both of two such planes.
TEST(MeetingModes, AmongOthersAndTwice) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    Random random(seed);
    constexpr int n = 10;
    const MatrixXd T = MatrixXd::Identity(n, n) + 0.5 * random.values(n * n, 1).reshaped(n, n);
    const VectorXd a = random.values(2, 1).array() + 3, b = random.values(4, 1).array() - 8;
    const double shift = random.number(0.02, 0.15);
    const auto at = [&](double p) { return (p - 0.3) * (p - 0.7); };
    const auto family = [&](double p) {
      MatrixXd A = MatrixXd::Zero(n, n);
      A.block<2, 2>(0, 0) << -a[0], 1, at(p), -a[0];
      A.block<2, 2>(2, 2) << -a[1], 1, 2 * at(p - shift), -a[1];
      A.block<2, 2>(4, 4) << -1, 5 + p, -5 - p, -1;
      A.block<2, 2>(6, 6) << -2, 6 - p, -6 + p, -2;
      A(8, 8) = -10 - p;
      A(9, 9) = b[0] - p;
      return MatrixXd(T * A * T.inverse());
    };
    const std::vector<double> values = range(0, 1, 6);
    const CampbellDiagram d = over(family, values);
    expect_unbroken(d, 8);
    ASSERT_EQ(d.meetings.size(), 4u) << seed;
    const std::vector<double> expected{0.3, 0.3 + shift, 0.7, 0.7 + shift};
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_NEAR(d.meetings[k].value, expected[k], 2e-5) << seed;
      EXPECT_EQ(d.meetings[k].parts, k >= 2);
    }
    // Each pair parts into the two branches that met.
    EXPECT_EQ(d.meetings[0].first, d.meetings[2].first);
    EXPECT_EQ(d.meetings[0].second, d.meetings[2].second);
    const auto values_of = [&](int branch) { return d.branches[static_cast<std::size_t>(branch)].values; };
    for (std::size_t k = 0; k < values.size(); ++k)
      for (const bool slow : {true, false}) {
        const Complex root = std::sqrt(Complex(at(values[k]))), lambda = -a[0] + (slow ? root : -root);
        EXPECT_LT(std::min(std::abs(values_of(d.meetings[0].first)[k] - lambda),
                           std::abs(values_of(d.meetings[0].second)[k] - lambda)),
                  1e-6)
            << seed;
      }
  }
}

/// The benchmark bicycle (Meijaard, Papadopoulos, Ruina, Schwab, Proc. R. Soc. A 463, 2007): M q̈ + v C₁ q̇ +
/// (g K₀ + v² K₂) q = 0. Two modes that grow become the weave at 0.684283 m/s, which ceases to grow at
/// 4.292383 m/s; the capsize begins to at 6.024262 m/s.
TEST(MeetingModes, OfTheBenchmarkBicycle) {
  Eigen::Matrix2d M, C, K0, K2;
  M << 80.81722, 2.31941332208709, 2.31941332208709, 0.29784188199686;
  C << 0, 33.86641391492494, -0.85035641456978, 1.68540397397560;
  K0 << -80.95, -2.59951685249872, -2.59951685249872, -0.80329488458618;
  K2 << 0, 76.59734589573222, 0, 2.65431523794604;
  const auto family = [&](double v) {
    MatrixXd A = MatrixXd::Zero(4, 4);
    A.topRightCorner(2, 2).setIdentity();
    A.bottomLeftCorner(2, 2) = -M.inverse() * (9.81 * K0 + v * v * K2);
    A.bottomRightCorner(2, 2) = -v * M.inverse() * C;
    return A;
  };
  for (const int count : {6, 11, 31}) {
    const CampbellDiagram d = over(family, range(0, 10, count));
    expect_unbroken(d, 4);
    ASSERT_EQ(d.meetings.size(), 1u);
    EXPECT_FALSE(d.meetings[0].parts);
    EXPECT_NEAR(d.meetings[0].value, 0.684283078889246, 1e-5);
    ASSERT_EQ(d.onsets.size(), 2u);
    EXPECT_FALSE(d.onsets[0].grows);
    EXPECT_NEAR(d.onsets[0].value, 4.292382536341110, 1e-5);
    EXPECT_TRUE(d.onsets[1].grows);
    EXPECT_NEAR(d.onsets[1].value, 6.024262015388370, 1e-5);
  }
}

/// Equal real eigenvalues do not meet, though round-off makes pairs of them.
TEST(MeetingModes, AreNotEqualOnes) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    constexpr int n = 6;
    const MatrixXd T = MatrixXd::Identity(n, n) + 0.5 * random.values(n * n, 1).reshaped(n, n);
    const CampbellDiagram d = over(
        [&](double p) {
          VectorXd values(n);
          values << -100, -100, -100, -100, -3 - p, -7 + p;
          return MatrixXd(T * values.asDiagonal() * T.inverse());
        },
        range(0, 1, 5));
    expect_unbroken(d, n);
    EXPECT_TRUE(d.meetings.empty()) << seed;
  }
}

/// A free body with a mass on a spring, whose place is the parameter: the rigid motions change with it, stay
/// six, and the mass has ω² = k (1/m₁ + 1/m₂ + d²/I) with the distance d from its line to the centre of mass.
TEST(MeetingModes, RigidMotionsStayAGroup) {
  const auto model = [](double d) {
    ModesOptions options;
    options.linear.point.at = LinearPoint::At::start;
    return find_modes(
        model_of(
            fmt::format("gravity: [0, 0, 0]\nbodies:\n"
                        "  hull: {{mass: 3, com: [0, 0, 0], inertia: [2, 2, 2]}}\n"
                        "  mass: {{mass: 0.5, com: [{0:.17g}, 0, 0], inertia: [1e-9, 1e-9, 1e-9]}}\njoints:\n"
                        "  free: {{type: floating, between: [ground, hull], at: [0, 0, 0]}}\n"
                        "  slide: {{type: prismatic, between: [hull, mass], at: [{0:.17g}, 0, 0], "
                        "axis: [0, 0, 1], spring: {{stiffness: 40}}}}\n",
                        d)),
        options);
  };
  CampbellOptions options;
  options.rad_per_second = 0;
  const std::vector<double> values = range(0.1, 3, 5);
  const CampbellDiagram d = campbell(model, values, options);
  expect_unbroken(d, 7);
  int rigid = 0;
  for (const ModeBranch& b : d.branches) {
    if (b.values[0] == 0.) {
      ++rigid;
      for (const Complex& value : b.values) EXPECT_EQ(value, 0.) << b.name;
      continue;
    }
    for (std::size_t k = 0; k < values.size(); ++k)
      EXPECT_NEAR(b.values[k].imag(), std::sqrt(40 * (1 / 3. + 2 + values[k] * values[k] / 2)), 1e-6);
  }
  EXPECT_EQ(rigid, 6);
}

std::shared_ptr<const Model> iltis() {
  return example("iltis/steady.yaml", {{"arms", "rigid"}, {"links", "rigid"}, {"rods", "rigid"}});
}

/// λ with Im ≥ 0 that are not zero, of the car at each speed.
std::function<LinearisedModes(double)> iltis_modes(NeighbouringModes& modes,
                                                   const std::shared_ptr<const Model>& car) {
  return [&modes, car](double speed) {
    ModesOptions options;
    options.linear.point.at = LinearPoint::At::trim;
    options.linear.trim.speed = speed;
    options.linear.trim.find = {"throttle"};
    return modes.find(speed, car, options);
  };
}

/// The Iltis over its speed: all modes are there throughout. Where its throttle no longer lets the speed
/// decay, below 5.4 m/s, that mode is a drift.
TEST(MeetingModes, OfADrivenCarAreUnbroken) {
  NeighbouringModes neighbours;
  CampbellOptions options;
  options.rad_per_second = 0;
  options.parameter = "speed";
  const std::vector<double> speeds = range(5, 40, 15);
  const CampbellDiagram d = campbell(iltis_modes(neighbours, iltis()), speeds, options);
  expect_unbroken(d, 24);
  EXPECT_LE(d.evaluations, 40);
  // Yaw and sideslip are a pair that parts.
  ASSERT_EQ(d.meetings.size(), 1u);
  EXPECT_TRUE(d.meetings[0].parts);
  int rigid = 0, slow = 0;
  for (const ModeBranch& b : d.branches) {
    const bool all = std::all_of(b.values.begin(), b.values.end(), [](Complex x) { return x == 0.; });
    rigid += all ? 1 : 0;
    if (all || b.values[0] != 0.) continue;
    ++slow;
    EXPECT_THAT(b.name, testing::HasSubstr("along x"));
    // A constant power P: m v̇ = P/v.
    for (std::size_t k = 1; k + 1 < speeds.size(); ++k)
      EXPECT_NEAR(b.values[k].real() * speeds[k], b.values[k + 1].real() * speeds[k + 1], 1e-4);
  }
  EXPECT_EQ(rigid, 6);
  EXPECT_EQ(slow, 1);
  // The place where it parts, by the discriminant on both sides.
  const auto apart = [&](double speed) {
    const std::vector<Mode> modes = iltis_modes(neighbours, iltis())(speed).modes;
    return std::count_if(modes.begin(), modes.end(),
                         [](const Mode& m) { return m.kind == Mode::Kind::real; });
  };
  const double place = d.meetings[0].value;
  EXPECT_EQ(apart(place * (1 - 1e-4)) + 2, apart(place * (1 + 1e-4)));
}

/// From 14 to 19 m/s in one step and in tiny ones: there each λ goes on to the one that is nearest to where
/// it was going.
TEST(MeetingModes, OfADrivenCarAreThoseOfTinySteps) {
  NeighbouringModes neighbours;
  const auto modes = iltis_modes(neighbours, iltis());
  CampbellOptions options;
  options.rad_per_second = 0;
  const std::vector<double> ends{14, 19};
  const CampbellDiagram d = campbell(modes, ends, options);
  expect_unbroken(d, 24);
  const auto values_at = [&](double speed) {
    std::vector<Complex> out;
    for (const Mode& m : modes(speed).modes)
      if (m.kind != Mode::Kind::rigid) out.push_back(m.value);
    return out;
  };
  std::vector<Complex> now, before;
  for (const ModeBranch& b : d.branches)
    if (b.values[0] != 0.) now.push_back(b.values[0]);
  constexpr int steps = 25;
  const auto nearest = [](const std::vector<Complex>& of, Complex to) {
    return *std::min_element(of.begin(), of.end(),
                             [&](Complex x, Complex y) { return std::abs(x - to) < std::abs(y - to); });
  };
  // Where it comes from: by a step of a thousandth.
  const std::vector<Complex> slightly = values_at(ends[0] + 1e-3 * (ends[1] - ends[0]) / steps);
  for (const Complex& value : now) before.push_back(value - 1e3 * (nearest(slightly, value) - value));
  for (int k = 1; k <= steps; ++k) {
    const std::vector<Complex> next = values_at(ends[0] + (ends[1] - ends[0]) * k / steps);
    ASSERT_EQ(next.size(), now.size());
    std::vector<Complex> matched;
    for (std::size_t b = 0; b < now.size(); ++b) {
      matched.push_back(nearest(next, 2. * now[b] - before[b]));
    }
    before = now;
    now = matched;
  }
  std::size_t at = 0;
  for (const ModeBranch& b : d.branches)
    if (b.values[0] != 0.) {
      EXPECT_LT(std::abs(b.values[1] - now[at++]), 1e-6) << b.name;
    }
  for (std::size_t i = 0; i < now.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT(std::abs(now[i] - now[j]), 1e-3);
}

/// A block that is damped critically has one eigenvalue twice, which round-off may make a pair.
TEST(EqualRealEigenvalues, AreTwoModes) {
  for (const double rate : {1.6, 3.3, 3.7, 4.9}) {
    const double mass = 0.7;
    const LinearisedModes found = find_modes(model_of(fmt::format(R"y(
gravity: [0, 0, 0]
bodies: {{block: {{mass: {}, com: [0, 0, 0], inertia: [1, 1, 1]}}}}
joints:
  slide: {{type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0],
          spring: {{stiffness: {:.17g}, damping: {:.17g}}}}}
)y",
                                                                  mass, mass * rate * rate, 2 * mass * rate)),
                                             ModesOptions());
    ASSERT_EQ(found.modes.size(), 2u) << rate;
    for (const Mode& mode : found.modes) {
      EXPECT_EQ(mode.kind, Mode::Kind::real);
      EXPECT_EQ(mode.value.imag(), 0);
      EXPECT_NEAR(mode.value.real(), -rate, 1e-6 * rate);
      EXPECT_TRUE(mode.shape.allFinite());
    }
  }
}

}  // namespace
}  // namespace mimbre::test::meeting_modes_test
