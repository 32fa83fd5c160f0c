#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include "mimbre/campbell.h"
#include "mimbre/modes.h"
#include "support/models.h"

/// Modes of motions with periodic coefficients: a rotor with blades that lag, on a hub that moves in its
/// plane (Coleman, Feingold, NACA Report 1351, 1958), against equations written by hand.
namespace mimbre::test::floquet_test {
namespace {

using Complex = std::complex<double>;
using Eigen::MatrixXd;
using Eigen::VectorXcd;

struct Rotor {
  int blades = 4;
  double speed = 12;  ///< Ω, rad/s
  double mass_x = 60, mass_y = 40, hub = 20, blade = 5, arm = 1.5, inertia = 4, offset = 0.3;
  double stiffness_x = 2e4, stiffness_y = 1.2e4, damping_x = 90, damping_y = 60;
  double lag_stiffness = 40, lag_damping = 6;
  bool driven = true;  ///< else it turns freely
  std::string more_bodies, more_joints;

  double static_moment() const { return blade * arm; }
  double about_hinge() const { return inertia + blade * arm * arm; }
  double moving_y() const { return mass_y + hub + blades * blade; }
  double moving_x() const { return mass_x + moving_y(); }
  double lag() const { return lag_stiffness + offset * static_moment() * speed * speed; }

  std::string text() const {
    std::string bodies = fmt::format(
        "gravity: [0, 0, 0]\nbodies:\n  sx: {{mass: {}, com: [0, 0, 0], inertia: [1, 1, 1]}}\n"
        "  sy: {{mass: {}, com: [0, 0, 0], inertia: [1, 1, 1]}}\n"
        "  hub: {{mass: {}, com: [0, 0, 0], inertia: [1, 1, 1]}}\n",
        mass_x, mass_y, hub);
    std::string joints = fmt::format(
        "joints:\n"
        "  x: {{type: prismatic, between: [ground, sx], at: [0, 0, 0], axis: [1, 0, 0], spring: {{stiffness: "
        "{}, "
        "damping: {}}}}}\n"
        "  y: {{type: prismatic, between: [sx, sy], at: [0, 0, 0], axis: [0, 1, 0], spring: {{stiffness: {}, "
        "damping: {}}}}}\n"
        "  turn: {{type: revolute, between: [sy, hub], at: [0, 0, 0], axis: [0, 0, 1], {}}}\n",
        stiffness_x, damping_x, stiffness_y, damping_y,
        driven ? fmt::format("drive: {{speed: {}}}", speed) : fmt::format("velocity: {}", speed));
    for (int k = 0; k < blades; ++k) {
      const double psi = 2 * std::numbers::pi * k / blades, c = std::cos(psi), s = std::sin(psi);
      bodies += fmt::format("  b{}: {{mass: {}, com: [{:.17g}, {:.17g}, 0], inertia: [{}, {}, {}]}}\n", k,
                            blade, (offset + arm) * c, (offset + arm) * s, inertia, inertia, inertia);
      joints += fmt::format(
          "  l{0}: {{type: revolute, between: [hub, b{0}], at: [{1:.17g}, {2:.17g}, 0], axis: [0, 0, 1], "
          "spring: "
          "{{stiffness: {3}, damping: {4}}}}}\n",
          k, offset * c, offset * s, lag_stiffness, lag_damping);
    }
    return bodies + more_bodies + joints + more_joints;
  }
};

LinearisedModes modes_of(const std::string& text) {
  ModesOptions options;
  options.linear.point.at = LinearPoint::At::steady;
  return find_modes(model_of(text), options);
}

/// Eigenvalues of M q̈ + C q̇ + K q = 0.
VectorXcd second_order(const MatrixXd& M, const MatrixXd& C, const MatrixXd& K) {
  const Eigen::Index n = M.rows();
  MatrixXd A = MatrixXd::Zero(2 * n, 2 * n);
  A.topRightCorner(n, n).setIdentity();
  A.bottomLeftCorner(n, n) = -M.inverse() * K;
  A.bottomRightCorner(n, n) = -M.inverse() * C;
  return A.eigenvalues();
}

/// Of x, y and α, β, the lags' sums by cosine and sine of the blades' angles (times 2/N): constant
/// coefficients. All blades together, and for even numbers alternating ones, lag alone.
std::vector<Complex> coleman(const Rotor& r) {
  MatrixXd M = MatrixXd::Zero(4, 4), C = M, K = M;
  const double S = r.static_moment(), I = r.about_hinge(), W = r.speed, c = r.lag_damping, k = r.lag(),
               n = r.blades;
  M(0, 0) = r.moving_x(), C(0, 0) = r.damping_x, K(0, 0) = r.stiffness_x, M(0, 3) = -S * n / 2;
  M(1, 1) = r.moving_y(), C(1, 1) = r.damping_y, K(1, 1) = r.stiffness_y, M(1, 2) = S * n / 2;
  M(2, 2) = M(3, 3) = I, C(2, 2) = C(3, 3) = c, K(2, 2) = K(3, 3) = k - I * W * W;
  C(2, 3) = 2 * W * I, C(3, 2) = -2 * W * I, K(2, 3) = c * W, K(3, 2) = -c * W;
  M(2, 1) = S, M(3, 0) = -S;
  std::vector<Complex> out;
  for (const Complex& value : second_order(M, C, K)) out.push_back(value);
  const MatrixXd one = MatrixXd::Constant(1, 1, I);
  for (int alone = 0; alone < r.blades - 2; ++alone)
    for (const Complex& value : second_order(one, one * (c / I), one * (k / I))) out.push_back(value);
  return out;
}

std::string notes_of(const LinearisedModes& found) {
  std::string notes;
  for (const std::string& note : found.model.notes) notes += note + "\n";
  return notes;
}

/// λ + i h Ω for some whole h is among the given ones, and each of these is found once.
void expect_exponents(const LinearisedModes& found, std::vector<Complex> expected, double speed,
                      double tolerance) {
  std::vector<Complex> all;
  for (const Mode& mode : found.modes) {
    all.push_back(mode.value);
    if (mode.kind == Mode::Kind::oscillating && std::abs(mode.multiplier.imag()) > 1e-9)
      all.push_back(std::conj(mode.value));
  }
  ASSERT_EQ(all.size(), expected.size());
  for (const Complex& value : all) {
    const auto off = [&](const Complex& e) {
      const double turns = (value.imag() - e.imag()) / speed;
      return std::abs(value - e - Complex(0, speed * std::round(turns)));
    };
    const auto nearest =
        std::min_element(expected.begin(), expected.end(),
                         [&](const Complex& a, const Complex& b) { return off(a) < off(b); });
    EXPECT_LE(off(*nearest), tolerance * std::abs(*nearest)) << value << " " << *nearest;
    expected.erase(nearest);
  }
}

/// Exponents of a round hub, in the blades' axes: λ with waves ζ_k = Re(η e^{λt − iψ_k}) of blades at ψ_k,
/// which for Im λ > 0 travel forward, and for Im λ < 0 backward with the frequency −Im λ: (I λ² + c λ + k)(M
/// p² + C p + K) = n S² p⁴/2 with p = λ + i Ω.
std::vector<Complex> waves_on_a_round_hub(const Rotor& r) {
  const Complex iW(0, r.speed);
  const double I = r.about_hinge(), S = r.static_moment(), M = r.moving_y();
  // By M q̈ + C q̇ + K q = 0 of η and Z with complex coefficients, time derivatives in the blades' axes.
  Eigen::Matrix4cd A = Eigen::Matrix4cd::Zero();
  Eigen::Matrix2cd mass, damping, stiffness;
  // Of z: p² = λ² + 2iΩλ − Ω².
  const Complex i(0, 1), two = 2. * iW, square = iW * iW;
  mass << I, -i * S, 0.5 * i * S * double(r.blades), M;
  damping << r.lag_damping, -i * S * two, 0.5 * i * S * double(r.blades) * two, M * two + r.damping_y;
  stiffness << r.lag(), -i * S * square, 0.5 * i * S * double(r.blades) * square,
      M * square + r.damping_y * iW + r.stiffness_y;
  A.topRightCorner(2, 2).setIdentity();
  A.bottomLeftCorner(2, 2) = -mass.inverse() * stiffness;
  A.bottomRightCorner(2, 2) = -mass.inverse() * damping;
  const Eigen::Vector4cd values = A.eigenvalues();
  return {values.data(), values.data() + 4};
}

/// Forward and backward waves of the blades against the sign of Im λ above, for both senses of rotation; all
/// blades together and neighbours against each other lag alone.
TEST(Floquet, NamesTheWavesOfBlades) {
  for (const int blades : {3, 4, 5, 6})
    for (const double speed : {12.0, -12.0}) {
      SCOPED_TRACE(fmt::format("{} blades, {} rad/s", blades, speed));
      Rotor r;
      r.blades = blades;
      r.mass_x = 1e-6;
      r.stiffness_y = r.stiffness_x;
      r.damping_y = r.damping_x;
      r.speed = speed;
      const LinearisedModes found = modes_of(r.text());
      Rotor mirrored = r;
      mirrored.speed = std::abs(speed);
      const std::vector<Complex> expected = waves_on_a_round_hub(mirrored);
      const double alone = std::sqrt(r.lag() / r.about_hinge());
      int forward = 0, backward = 0, collective = 0, others = 0;
      for (const Mode& mode : found.modes) {
        if (mode.blades.empty() || mode.blades[0].share < 0.99) continue;
        const std::string& wave = mode.blades[0].name;
        EXPECT_THAT(mode.text, testing::HasSubstr("blades " + wave));
        const auto off = [&](const Complex& value) {
          const Complex own = wave == "forward" ? mode.value : std::conj(mode.value);
          const double turns = (own.imag() - value.imag()) / r.speed;
          return std::abs(own - value - Complex(0, r.speed * std::round(turns)));
        };
        if (wave == "forward" || wave == "backward") {
          ++(wave == "forward" ? forward : backward);
          double least = 1e9;
          for (const Complex& value : expected)
            if ((value.imag() > 0) == (wave == "forward")) least = std::min(least, off(value));
          EXPECT_LT(least, 1e-6) << wave << " " << mode.value;
        } else {
          ++(wave == "collective" ? collective : others);
          EXPECT_NEAR(std::abs(mode.value), alone, 1e-6 * alone) << wave;
        }
      }
      EXPECT_GE(forward, 1);
      EXPECT_GE(backward, 1);
      EXPECT_EQ(collective, 1);
      EXPECT_EQ(others, blades - 3);
    }
}

TEST(Floquet, BladesThatLagOnAHubThatMoves) {
  for (const int blades : {3, 4, 5}) {
    Rotor r;
    r.blades = blades;
    const LinearisedModes found = modes_of(r.text());
    EXPECT_NEAR(found.period, 2 * std::numbers::pi / r.speed, 1e-12);
    EXPECT_TRUE(found.model.warnings.empty());
    expect_exponents(found, coleman(r), r.speed, 1e-7);
  }
}

/// Ground resonance: where the blades' slow lag in fixed axes, Ω − ω, meets the hub's frequency, the motion
/// grows, as in Coleman's equations, and is damped away elsewhere.
TEST(Floquet, GroundResonanceGrowsWhereItShould) {
  int growing = 0, damped = 0;
  for (double speed = 8; speed <= 30; speed += 2) {
    Rotor r;
    r.damping_x = r.damping_y = 10;
    r.lag_damping = 0.5;
    r.speed = speed;
    double most = -1;
    for (const Complex& value : coleman(r)) most = std::max(most, value.real());
    double found = -1;
    for (const Mode& mode : modes_of(r.text()).modes) {
      found = std::max(found, mode.value.real());
      EXPECT_EQ(mode.grows, mode.value.real() > 1e-6);
    }
    EXPECT_NEAR(found, most, 1e-7 * (1 + std::abs(most))) << speed;
    ++(most > 0 ? growing : damped);
  }
  EXPECT_GE(growing, 2);
  EXPECT_GE(damped, 2);
}

/// Frequencies of the hub are seen as they are: those without blades, nearly, where blades are light.
TEST(Floquet, FrequenciesAreThoseThatTheMotionHasOnAverage) {
  Rotor r;
  r.blade = 0.01, r.inertia = 0.01, r.lag_stiffness = 0.6, r.lag_damping = 0.003;
  const LinearisedModes found = modes_of(r.text());
  for (const double expected :
       {std::sqrt(r.stiffness_x / r.moving_x()), std::sqrt(r.stiffness_y / r.moving_y())})
    EXPECT_TRUE(std::any_of(found.modes.begin(), found.modes.end(), [&](const Mode& m) {
      return std::abs(m.value.imag() - expected) < 2e-3 * expected;
    })) << expected;
  // Blades lag with their own frequency in their own axes.
  const double lag = std::sqrt(r.lag() / r.about_hinge());
  EXPECT_EQ(std::count_if(found.modes.begin(), found.modes.end(),
                          [&](const Mode& m) { return std::abs(m.value.imag() - lag) < 0.02 * lag; }),
            4);
}

/// Two blades on a hub with different springs have periodic coefficients in all axes. The transition by hand:
/// M(t) q̈ + C(t) q̇ + K(t) q = 0 by classical Runge–Kutta steps.
TEST(Floquet, TwoBladesByHand) {
  Rotor r;
  r.blades = 2;
  const double S = r.static_moment(), I = r.about_hinge(), W = r.speed;
  // d²/dt² (ζ sin ψ) = ζ̈ sin ψ + 2 Ω ζ̇ cos ψ − Ω² ζ sin ψ.
  const auto rate = [&](double t, const Eigen::MatrixXd& x) {
    MatrixXd M = MatrixXd::Zero(4, 4), C = M, K = M;
    M(0, 0) = r.moving_x(), C(0, 0) = r.damping_x, K(0, 0) = r.stiffness_x;
    M(1, 1) = r.moving_y(), C(1, 1) = r.damping_y, K(1, 1) = r.stiffness_y;
    for (int k = 0; k < 2; ++k) {
      const double psi = W * t + std::numbers::pi * k, s = std::sin(psi), c = std::cos(psi);
      const int b = 2 + k;
      M(0, b) = -S * s, C(0, b) = -2 * S * W * c, K(0, b) = S * W * W * s;
      M(1, b) = S * c, C(1, b) = -2 * S * W * s, K(1, b) = -S * W * W * c;
      M(b, b) = I, C(b, b) = r.lag_damping, K(b, b) = r.lag();
      M(b, 0) = -S * s, M(b, 1) = S * c;
    }
    MatrixXd out(8, x.cols());
    out.topRows(4) = x.bottomRows(4);
    out.bottomRows(4) = -M.partialPivLu().solve(K * x.topRows(4) + C * x.bottomRows(4));
    return out;
  };
  const int steps = 4000;
  const double h = 2 * std::numbers::pi / W / steps;
  MatrixXd x = MatrixXd::Identity(8, 8);
  for (int k = 0; k < steps; ++k) {
    const double t = k * h;
    const MatrixXd a = rate(t, x), b = rate(t + h / 2, x + h / 2 * a), c = rate(t + h / 2, x + h / 2 * b),
                   d = rate(t + h, x + h * c);
    x += h / 6 * (a + 2 * b + 2 * c + d);
  }
  std::vector<Complex> expected;
  for (const Complex& multiplier : VectorXcd(x.eigenvalues()))
    expected.push_back(std::log(multiplier) / (h * steps));
  const LinearisedModes found = modes_of(r.text());
  expect_exponents(found, expected, W, 1e-7);
  const VectorXcd multipliers = x.eigenvalues();
  for (const Mode& mode : found.modes)
    EXPECT_TRUE(std::any_of(multipliers.begin(), multipliers.end(), [&](const Complex& m) {
      return std::abs(m - mode.multiplier) < 1e-7;
    })) << mode.multiplier;
}

/// Backward it is the same, mirrored.
TEST(Floquet, TurningBackward) {
  Rotor r;
  r.speed = -12;
  expect_exponents(modes_of(r.text()), coleman(r), 12, 1e-7);
}

/// A hub that turns freely: a rigid motion, and blades together move it, (J + N I₀) φ̈ + N I₁ ζ̈ = 0.
TEST(Floquet, TurningFreely) {
  Rotor r;
  r.driven = false;
  const double I = r.about_hinge(), es = r.offset * r.static_moment(), one = I + es,
               all = 1 + r.blades * (I + r.blade * r.offset * r.offset + 2 * es);
  std::vector<Complex> expected = coleman(r);
  expected.resize(expected.size() - 2);  // the blades together, as on a hub that is driven
  const double effective = I - r.blades * one * one / all;
  const MatrixXd unit = MatrixXd::Constant(1, 1, 1);
  for (const Complex& value : second_order(effective * unit, r.lag_damping * unit, r.lag() * unit))
    expected.push_back(value);
  LinearisedModes found = modes_of(r.text());
  ASSERT_EQ(std::count_if(found.modes.begin(), found.modes.end(),
                          [](const Mode& m) { return m.kind == Mode::Kind::rigid; }),
            1);
  EXPECT_EQ(found.modes[0].multiplier, 1.);
  EXPECT_GT(found.modes[0].coordinates.at(0).share, 0.99);
  found.modes.erase(found.modes.begin());
  expect_exponents(found, expected, r.speed, 1e-6);
}

/// Beside a round wheel at one and a half times the speed all is back after two turns.
TEST(Floquet, TwoSpeedsHaveACommonPeriod) {
  Rotor r;
  r.more_bodies = "  wheel: {mass: 0.001, com: [0, 0, 0], inertia: [1, 1, 1]}\n";
  r.more_joints =
      "  second: {type: revolute, between: [sy, wheel], at: [0, 0, 0], axis: [0, 0, 1], drive: {speed: "
      "18}}\n";
  const LinearisedModes found = modes_of(r.text());
  EXPECT_NEAR(found.period, 2 * std::numbers::pi / 6, 1e-9);
  r.mass_y += 0.001;
  expect_exponents(found, coleman(r), 6, 1e-7);
  r.more_joints.replace(r.more_joints.find("18"), 2, "17.3");
  r.mass_y -= 0.001;
  EXPECT_THAT(notes_of(modes_of(r.text())), testing::HasSubstr("no common period"));
}

/// Beside the rotor, something that swings twice a turn: it is back after a turn, and not rigid.
TEST(Floquet, WhatIsBackAfterAPeriodIsNotRigid) {
  Rotor r;
  r.more_bodies = "  swing: {mass: 1, com: [0, 5, 0], inertia: [1, 1, 1]}\n";
  r.more_joints = fmt::format(
      "  swing: {{type: prismatic, between: [ground, swing], at: [0, 5, 0], axis: [1, 0, 0], spring: "
      "{{stiffness: "
      "{}}}}}\n",
      4 * r.speed * r.speed);
  bool any = false;
  for (const Mode& mode : modes_of(r.text()).modes) {
    EXPECT_NE(mode.kind, Mode::Kind::rigid);
    any = any || std::abs(mode.value - Complex(0, 2 * r.speed)) < 1e-5 * r.speed;
  }
  EXPECT_TRUE(any);
}

/// What decays within a turn leaves nothing that could be seen after it.
TEST(Floquet, MultipliersLostInRoundOffAreNotGiven) {
  Rotor r;
  r.damping_x = 8e3;
  const LinearisedModes found = modes_of(r.text());
  EXPECT_EQ(found.period, 0);
  EXPECT_THAT(notes_of(found), testing::HasSubstr("digits"));
}

/// Over the speed exponents go on without jumps by multiples of it, and begin to grow where Coleman's do.
TEST(Floquet, ModesAreFollowedOverTheSpeed) {
  const auto rotor = [](double speed) {
    Rotor r;
    r.speed = speed;
    return r;
  };
  const std::vector<double> values{10, 11.5, 13, 14.5, 16};
  CampbellOptions options;
  options.parameter = "speed";
  const CampbellDiagram found =
      campbell([&](double speed) { return modes_of(rotor(speed).text()); }, values, options);
  ASSERT_EQ(found.branches.size(), 6u);
  for (const ModeBranch& branch : found.branches) {
    for (std::size_t k = 0; k < values.size(); ++k) {
      const Complex value = branch.values[k];
      double off = 1e300;
      for (const Complex& e : coleman(rotor(values[k]))) {
        const double turns = std::round((value.imag() - e.imag()) / values[k]);
        off = std::min(off, std::abs(value - e - Complex(0, turns * values[k])));
      }
      EXPECT_LE(off, 1e-6 * std::abs(value));
      if (k == 0) continue;
      EXPECT_LT(std::abs(value.imag() - branch.values[k - 1].imag()), 2.5);
    }
  }
  double low = 10, high = 16;
  for (int round = 0; round < 40; ++round) {
    const double middle = (low + high) / 2;
    double most = -1;
    for (const Complex& value : coleman(rotor(middle))) most = std::max(most, value.real());
    (most > 0 ? high : low) = middle;
  }
  ASSERT_EQ(found.onsets.size(), 1u);
  EXPECT_NEAR(found.onsets[0].value, low, 0.01);
}

/// Without damping ground resonance begins and ceases at once, where two motions meet: by Coleman's
/// equations, whatever the values are.
TEST(Floquet, GroundResonanceCeasesWhereItShould) {
  const auto rotor = [](double speed) {
    Rotor r;
    r.blades = 3;
    r.speed = speed;
    r.stiffness_y = r.stiffness_x;
    r.mass_y = 100;
    r.mass_x = 0.01;
    r.damping_x = r.damping_y = r.lag_damping = 0;
    return r;
  };
  const auto grows = [&](double speed) {
    double most = -1;
    for (const Complex& value : coleman(rotor(speed))) most = std::max(most, value.real());
    return most > 1e-4;
  };
  double inside = 8;
  while (!grows(inside)) inside += 0.1;
  double last = inside;
  while (grows(last)) last += 0.1;
  double low = inside, high = last;
  for (int round = 0; round < 40; ++round) {
    const double middle = (low + high) / 2;
    (grows(middle) ? low : high) = middle;
  }
  CampbellOptions options;
  options.rad_per_second = 0;
  const CampbellDiagram found = campbell([&](double speed) { return modes_of(rotor(speed).text()); },
                                         {0.5 * (inside + low), low + 1.7}, options);
  ASSERT_EQ(found.onsets.size(), 1u);
  EXPECT_NEAR(found.onsets[0].value, low, 1e-6 * low);
  EXPECT_FALSE(found.onsets[0].grows);
}

/// Turned about a level axis the blades fall and rise: no steady motion all the way round.
TEST(Floquet, NamesWhyThereAreNoMultipliers) {
  std::string text = Rotor().text();
  text.replace(text.find("gravity: [0, 0, 0]"), 18, "gravity: [0, -1, 0]");
  const LinearisedModes found = modes_of(text);
  EXPECT_EQ(found.period, 0);
  EXPECT_THAT(notes_of(found), testing::HasSubstr("not steady"));
  EXPECT_FALSE(found.model.warnings.empty());
}

}  // namespace
}  // namespace mimbre::test::floquet_test
