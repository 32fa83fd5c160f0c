#include "mimbre/linearise.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "analysis/linear_point.h"
#include "integrate/initial.h"
#include "mimbre/model_file.h"
#include "mimbre/modes.h"
#include "simulation/start/assembly.h"
#include "support/models.h"
#include "support/random_mechanism.h"
#include "support/simulate.h"

/// Linear models and modes against closed forms and against differences of the nonlinear equations.
namespace mimbre::test::linearise_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

LinearOptions at_start() {
  LinearOptions options;
  options.point.at = LinearPoint::At::start;
  return options;
}

LinearisedModes modes_of(const std::string& text, LinearPoint point = {}) {
  ModesOptions options;
  options.linear.point = point;
  return find_modes(model_of(text), options);
}

TEST(Modes, OfAPendulum) {
  const LinearisedModes found = modes_of(R"yaml(
gravity: [0, 0, -9.81]
bodies: {bob: {mass: 2, com: [0, 0, -0.7], inertia: [0.03, 0.02, 0.01]}}
joints: {pin: {type: revolute, between: [ground, bob], at: [0, 0, 0], axis: [0, 1, 0]}}
)yaml");
  EXPECT_EQ(found.model.point, "equilibrium");
  ASSERT_EQ(found.modes.size(), 1u);
  const double omega = std::sqrt(2 * 9.81 * 0.7 / (0.02 + 2 * 0.49));
  EXPECT_NEAR(found.modes[0].value.imag(), omega, 1e-9 * omega);
  EXPECT_NEAR(found.modes[0].value.real(), 0, 1e-9 * omega);
  EXPECT_EQ(found.modes[0].kind, Mode::Kind::oscillating);
  EXPECT_THAT(found.modes[0].text, testing::HasSubstr("'pin' 100 %"));
}

/// Upside down it falls with e^{ωt}.
TEST(Modes, OfAPendulumThatStandsOnItsHead) {
  const LinearisedModes found = modes_of(R"yaml(
bodies: {bob: {mass: 2, com: [0, 0, 0.7], inertia: [0.03, 0.02, 0.01]}}
joints: {pin: {type: revolute, between: [ground, bob], at: [0, 0, 0], axis: [0, 1, 0]}}
)yaml",
                                         {LinearPoint::At::start});
  ASSERT_EQ(found.modes.size(), 2u);
  const double omega = std::sqrt(2 * 9.81 * 0.7 / (0.02 + 2 * 0.49));
  for (const Mode& m : found.modes) {
    EXPECT_EQ(m.kind, Mode::Kind::real);
    EXPECT_NEAR(std::abs(m.value.real()), omega, 1e-9 * omega);
    EXPECT_EQ(m.grows, m.value.real() > 0);
  }
}

/// A chain of equal masses and springs between walls: ω_k = 2 √(k/m) sin(k π/(2 (n + 1))).
TEST(Modes, OfAChainOfMasses) {
  std::string bodies, joints, springs;
  constexpr int n = 6;
  for (int k = 1; k <= n; ++k) {
    bodies += "  b" + std::to_string(k) + ": {mass: 3, com: [" + std::to_string(k) +
              ", 0, 0], inertia: [1, 1, 1]}\n";
    joints += "  j" + std::to_string(k) + ": {type: prismatic, between: [ground, b" + std::to_string(k) +
              "], at: [" + std::to_string(k) + ", 0, 0], axis: [1, 0, 0]}\n";
    springs += "  s" + std::to_string(k) + ": {between: [" +
               (k == 1 ? "ground" : "b" + std::to_string(k - 1)) + ", b" + std::to_string(k) + "], at: [[" +
               std::to_string(k - 1) + ", 0, 0], [" + std::to_string(k) +
               ", 0, 0]], elastic: {stiffness: 700, zero: 1}}\n";
  }
  springs +=
      "  last: {between: [b6, ground], at: [[6, 0, 0], [7, 0, 0]], elastic: {stiffness: 700, zero: 1}}\n";
  const LinearisedModes found =
      modes_of("bodies:\n" + bodies + "joints:\n" + joints + "springs:\n" + springs);
  ASSERT_EQ(found.modes.size(), static_cast<std::size_t>(n));
  for (int k = 1; k <= n; ++k) {
    const double omega = 2 * std::sqrt(700. / 3) * std::sin(k * std::numbers::pi / (2 * (n + 1)));
    EXPECT_NEAR(std::abs(found.modes[static_cast<std::size_t>(k - 1)].value), omega, 1e-9 * omega);
  }
}

/// A damped oscillator: λ² + 2 D ω λ + ω² = 0, and its matrices.
TEST(Linearise, ADampedOscillatorWithAForce) {
  const LinearModel m = linearise(model_of(R"yaml(
gravity: [0, 0, 0]
bodies: {cart: {mass: 4, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {rail: {type: prismatic, between: [ground, cart], at: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 100, damping: 8}}}
inputs: {push: {start: 0, unit: N}}
actuators: {motor: {joint: rail, force: 3*push}}
outputs:
  - {name: x, joint: rail}
  - {name: a, joint_acceleration: rail}
)yaml"));
  MatrixXd A(2, 2), B(2, 1), C(2, 2), D(2, 1);
  A << 0, 1, -25, -2;
  B << 0, 0.75;
  C << 1, 0, -25, -2;
  D << 0, 0.75;
  EXPECT_LT((m.A - A).norm(), 1e-12);
  EXPECT_LT((m.B - B).norm(), 1e-12);
  EXPECT_LT((m.C - C).norm(), 1e-9);
  EXPECT_LT((m.D - D).norm(), 1e-9);
  EXPECT_NEAR(m.mass(0, 0), 4, 1e-12);
  EXPECT_NEAR(m.damping(0, 0), 8, 1e-12);
  EXPECT_NEAR(m.stiffness(0, 0), 100, 1e-12);
  EXPECT_EQ(m.states[0].name, "rail");
  EXPECT_EQ(m.inputs[0].name, "push");
  const std::complex<double> i(0, 1), s = i * 3.0;
  EXPECT_LT(std::abs(frequency_response(m, 3)(0, 0) - 3.0 / (4.0 * s * s + 8.0 * s + 100.0)), 1e-12);
}

/// A free symmetric body that spins about its axis: seen from it the axis circles with (C − A)/A Ω; six
/// motions are free.
TEST(Modes, OfAFreeSymmetricTop) {
  const LinearisedModes found = modes_of(R"yaml(
gravity: [0, 0, 0]
bodies: {top: {mass: 2, com: [0, 0, 0], inertia: [0.3, 0.3, 0.5]}}
joints: {free: {type: floating, between: [ground, top], at: [0, 0, 0], velocity: [0, 0, 0, 0, 0, 30]}}
)yaml",
                                         {LinearPoint::At::steady});
  EXPECT_EQ(found.model.point, "steady motion");
  std::vector<double> turning;
  for (const Mode& m : found.modes)
    if (m.kind == Mode::Kind::oscillating) turning.push_back(m.value.imag());
  // The body's own rate: where the axis has been turned, and stays, it circles as seen from the body.
  std::sort(turning.begin(), turning.end());
  ASSERT_EQ(turning.size(), 2u);
  EXPECT_NEAR(turning[0], 20, 1e-9 * 20);
  EXPECT_NEAR(turning[1], 30, 1e-9 * 30);
}

/// A Maxwell branch: ẋ = v, ė = v − e/τ, m v̇ = −k x − k₁ e.
TEST(Linearise, ABushingWithABranch) {
  const LinearModel m = linearise(model_of(R"yaml(
gravity: [0, 0, 0]
bodies: {cart: {mass: 4, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {rail: {type: prismatic, between: [ground, cart], at: [0, 0, 0], axis: [1, 0, 0]}}
bushings:
  rubber: {between: [ground, cart], at: [0, 0, 0], stiffness: [100, 0, 0, 0, 0, 0], damping: [0, 0, 0, 0, 0, 0], maxwell: [{stiffness: [60, 0, 0, 0, 0, 0], relaxation: 0.02}]}
)yaml"));
  MatrixXd known(3, 3);
  known << 0, 1, 0, -25, 0, -15, 0, 1, -50;
  const Eigen::VectorXcd expected = known.eigenvalues();
  const Eigen::VectorXcd found = m.A.eigenvalues();
  for (const std::complex<double>& value : expected) {
    double nearest = 1e300;
    for (const std::complex<double>& other : found) nearest = std::min(nearest, std::abs(value - other));
    EXPECT_LT(nearest, 1e-8 * std::abs(value));
  }
}

/// Friction that sticks adds its bristles' stiffness and no state.
TEST(Linearise, FrictionThatSticksIsASpring) {
  const LinearModel m = linearise(model_of(R"yaml(
gravity: [0, 0, 0]
bodies: {cart: {mass: 4, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {rail: {type: prismatic, between: [ground, cart], at: [0, 0, 0], axis: [1, 0, 0]}}
frictions: {rub: {joint: rail, force: 10, sticking: 0.001, settling: 0.01}}
)yaml"));
  ASSERT_EQ(m.A.rows(), 2);
  EXPECT_NEAR(m.stiffness(0, 0), 10 / 0.001, 1e-5);
  EXPECT_NEAR(m.damping(0, 0), 10 / 0.001 * 0.01, 1e-7);
}

/// A controller with a delay: its loop has the roots of the characteristic equation with Padé's function.
TEST(Linearise, ADelayIsPadesFunction) {
  const LinearModel m = linearise(model_of(R"yaml(
gravity: [0, 0, 0]
bodies: {cart: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {rail: {type: prismatic, between: [ground, cart], at: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 4, damping: 1}}}
signals:
  place: {joint: rail}
  late: {delay: place, time: 0.1}
actuators: {motor: {joint: rail, force: -2*late}}
)yaml"));
  ASSERT_EQ(m.A.rows(), 6);
  ASSERT_EQ(m.notes.size(), 1u);
  // s² + s + 4 + 2 e^{−0.1 s} = 0, by Newton's method.
  std::complex<double> s(0, 2.4);
  for (int k = 0; k < 50; ++k) {
    const std::complex<double> e = std::exp(-0.1 * s);
    s -= (s * s + s + 4.0 + 2.0 * e) / (2.0 * s + 1.0 - 0.2 * e);
  }
  double nearest = 1e300;
  const Eigen::VectorXcd values = m.A.eigenvalues();
  for (const std::complex<double>& value : values) nearest = std::min(nearest, std::abs(value - s));
  EXPECT_LT(nearest, 1e-6);
}

/// Friswell, Penny, Garvey, Lees, Dynamics of Rotating Machines (2010): a shaft of 1.5 m and 50 mm with two
/// discs on bearings of 1 MN/m. Here the shaft stands still and the discs turn on it: their gyroscopic
/// moments are the same, those of the shaft itself, 2 % of them, are left out.
std::string rotor(double rpm) {
  const auto disc = [](double diameter, double place) {
    const double mass = 7810 * std::numbers::pi / 4 * (diameter * diameter - 0.0025) * 0.07,
                 r = (diameter * diameter + 0.0025) / 4, polar = mass * r / 2,
                 across = polar / 2 + mass * 0.0049 / 12;
    const auto text = [](double value) { return std::to_string(value); };
    return "{mass: " + text(mass) + ", com: [" + text(place) + ", 0, 0], inertia: [" + text(polar) + ", " +
           text(across) + ", " + text(across) + "]}";
  };
  return R"yaml(
gravity: [0, 0, 0]
materials: {steel: {young: 2.11e11, poisson: 0.299261, density: 7810}}
sections: {round: {type: round, diameter: 0.05}}
bodies:
  one: )yaml" +
         disc(0.28, 0.5) + "\n  two: " + disc(0.35, 1) + R"yaml(
  shaft:
    frame: {at: [0, 0, 0]}
    flexible:
      material: steel
      section: round
      beam_theory: timoshenko
      nodes: {left: [0, 0, 0], a: [0.5, 0, 0], b: [1, 0, 0], right: [1.5, 0, 0]}
      bars: {i: {from: left, to: a, elements: 4}, j: {from: a, to: b, elements: 4}, k: {from: b, to: right, elements: 4}}
      clamped: [left]
      static_modes:
        - {node: a, along: [0, 1, 0]}
        - {node: a, along: [0, 0, 1]}
        - {node: a, about: [0, 1, 0]}
        - {node: a, about: [0, 0, 1]}
        - {node: b, along: [0, 1, 0]}
        - {node: b, along: [0, 0, 1]}
        - {node: b, about: [0, 1, 0]}
        - {node: b, about: [0, 0, 1]}
        - {node: right, along: [0, 1, 0]}
        - {node: right, along: [0, 0, 1]}
      dynamic_modes: 8
joints:
  free: {type: floating, between: [ground, shaft], at: [0, 0, 0], velocity: [0, 0, 0, 0, 0, 0]}
  one: {type: revolute, between: [shaft, one], at: [0.5, 0, 0], axis: [1, 0, 0], drive: {speed: )yaml" +
         std::to_string(rpm * std::numbers::pi / 30) + R"yaml(}}
  two: {type: revolute, between: [shaft, two], at: [1, 0, 0], axis: [1, 0, 0], drive: {speed: )yaml" +
         std::to_string(rpm * std::numbers::pi / 30) + R"yaml(}}
bushings:
  left: {between: [ground, shaft], at: [0, 0, 0], stiffness: [1e6, 1e6, 1e6, 1e5, 0, 0], damping: [0, 0, 0, 0, 0, 0]}
  right: {between: [ground, shaft], at: [1.5, 0, 0], stiffness: [0, 1e6, 1e6, 0, 0, 0], damping: [0, 0, 0, 0, 0, 0]}
)yaml";
}
TEST(Modes, OfFriswellsRotor) {
  const std::vector<std::pair<double, std::vector<double>>> table{
      {0, {86.66, 86.66, 274.31, 274.31, 716.78}}, {4000, {85.39, 87.80, 251.78, 294.71, 600.18}}};
  for (const auto& [rpm, published] : table) {
    const LinearisedModes found = modes_of(rotor(rpm));
    EXPECT_TRUE(found.model.warnings.empty()) << found.model.warnings.front();
    std::vector<double> bending;
    for (const Mode& m : found.modes)
      if (m.kind == Mode::Kind::oscillating && m.text.find("along x") == std::string::npos &&
          m.text.find("about x") == std::string::npos)
        bending.push_back(m.value.imag());
    ASSERT_GE(bending.size(), published.size());
    for (std::size_t k = 0; k < published.size(); ++k)
      EXPECT_NEAR(bending[k], published[k], 3e-3 * published[k]) << rpm << " rpm, mode " << k + 1;
  }
}

/// Accelerations of a moved state in both formulations, by differences, are those of the linear model.
void expect_differences(const RandomMechanism& mechanism, unsigned seed, int& unlike) {
  LinearOptions options;
  options.point.at = LinearPoint::At::start;
  const linear::Linearised at = linear::linearise_at(mechanism.model, options);
  const Compiled& m = at.model->compiled();
  const linear::Reduced& r = at.reduced;
  if (r.coordinates == 0) return;
  relative::RelativeSystem system(m);
  natural::NaturalSystem natural(m);
  Random random(seed);
  const VectorXd x = random.values(2 * r.coordinates, 1);
  const VectorXd dq = r.position.leftCols(x.size()) * x, dv = r.velocity.leftCols(x.size()) * x,
                 da = r.acceleration.leftCols(x.size()) * x;
  const VectorXd ready = Eigen::Map<const VectorXd>(system.scales().coordinates.data(), m.velocities);
  const auto moved = [&](double by, bool of_natural) {
    State s = at.state;
    const VectorXd increment = by * dq;
    system.enter(s.u.data(), s.z.data(), 0);
    system.begin_step(at.state.q.data());
    system.retract(at.state.q.data(), increment.data(), s.q.data());
    s.v += by * dv;
    close_positions(system, s.time, ready, s.q);
    close_velocities(system, s.time, s.q, ready, s.v);
    if (!of_natural) {
      EXPECT_TRUE(solve_accelerations(system, s));
      return s.a;
    }
    State n = natural_state(natural, system, s);
    natural.enter(s.u.data(), s.z.data(), 0);
    EXPECT_TRUE(solve_accelerations(natural, n));
    natural.to_relative(n, s);
    return s.a;
  };
  const auto scaled = [&](const VectorXd& a) { return system.scales().of_coordinates(a.data()); };
  for (const bool of_natural : {false, true}) {
    // Where natural coordinates start with other accelerations there is nothing to compare.
    if (of_natural && scaled(moved(0, true) - at.state.a) > 1e-6 * scaled(at.state.a)) {
      ++unlike;
      continue;
    }
    const double h = 2e-5;
    const auto difference = [&](double by) {
      return VectorXd((moved(by, of_natural) - moved(-by, of_natural)) / (2 * by));
    };
    const VectorXd wide = difference(h), narrow = difference(h / 2), found = narrow + (narrow - wide) / 3;
    EXPECT_LT(scaled(found - da), 2e-6 * std::max(scaled(da), scaled(at.state.a)))
        << (of_natural ? "natural" : "relative");
  }
}

class LinearRandom : public testing::TestWithParam<int> {};
TEST_P(LinearRandom, AgreesWithDifferencesOfBothFormulations) {
  int unlike = 0;
  for (unsigned k = 0; k < 20; ++k) {
    const unsigned seed = 20u * static_cast<unsigned>(GetParam()) + k + 1;
    SCOPED_TRACE(seed);
    RandomOptions options;
    options.springs = options.damping = options.loads = true;
    options.loops = static_cast<int>(seed % 3);
    options.flexible_share = seed % 2 == 0 ? 0 : 0.4;
    expect_differences(random_mechanism(seed, options), seed, unlike);
  }
  EXPECT_LE(unlike, 1);
}
INSTANTIATE_TEST_SUITE_P(Seeds, LinearRandom, testing::Range(0, 5));

/// A of natural coordinates, by extrapolated differences of their accelerations, is A of relative ones,
/// by exact derivatives: in units of the mechanism they differ by less than 1e-8 of the largest eigenvalue.
void expect_same_matrix(const RandomMechanism& mechanism, int& compared, int& redundant, int& unlike) {
  LinearOptions options;
  options.point.at = LinearPoint::At::start;
  linear::Linearised at;
  try {
    at = linear::linearise_at(mechanism.model, options);
  } catch (const std::runtime_error&) {
    return;  // a singular position
  }
  const Compiled& m = at.model->compiled();
  const linear::Reduced& r = at.reduced;
  const Eigen::Index f = r.coordinates;
  if (f == 0 || r.states > 0) return;
  relative::RelativeSystem system(m);
  natural::NaturalSystem natural(m);
  const VectorXd ready = Eigen::Map<const VectorXd>(system.scales().coordinates.data(), m.velocities);
  const auto acceleration = [&](Eigen::Index column, double by) {
    State s = at.state;
    const VectorXd increment = by * r.position.col(column);
    system.enter(s.u.data(), s.z.data(), 0);
    system.begin_step(at.state.q.data());
    system.retract(at.state.q.data(), increment.data(), s.q.data());
    s.v += by * r.velocity.col(column);
    close_positions(system, s.time, ready, s.q);
    close_velocities(system, s.time, s.q, ready, s.v);
    State n = natural_state(natural, system, s);
    natural.enter(s.u.data(), s.z.data(), 0);
    EXPECT_TRUE(solve_accelerations(natural, n));
    natural.to_relative(n, s);
    return VectorXd(s.a(at.independent));
  };
  // Where natural coordinates start with other accelerations there is nothing to compare.
  if (const VectorXd off = acceleration(0, 0) - at.state.a(at.independent);
      off.cwiseAbs().maxCoeff() > 1e-9 * std::max(1., at.state.a.cwiseAbs().maxCoeff())) {
    ++unlike;
    return;
  }
  VectorXd scale(f);
  for (Eigen::Index k = 0; k < f; ++k) scale[k] = ready[at.independent[static_cast<std::size_t>(k)]];
  const double pace = r.A.eigenvalues().cwiseAbs().maxCoeff();
  double worst = 0;
  for (Eigen::Index column = 0; column < 2 * f; ++column) {
    const VectorXd x = column < f ? r.position.col(column) : r.velocity.col(column);
    const double size = system.scales().of_coordinates(x.data()),
                 step = 4e-3 / size * (column < f ? 1 : pace);
    // Ridders' tableau: of all its extrapolations the one whose neighbours agree best.
    std::vector<VectorXd> row;
    VectorXd found;
    double uncertain = std::numeric_limits<double>::infinity();
    for (int level = 0; level < 8; ++level) {
      const double h = std::ldexp(step, -level);
      std::vector<VectorXd> next{(acceleration(column, h) - acceleration(column, -h)) / (2 * h)};
      for (std::size_t k = 1; k <= static_cast<std::size_t>(level); ++k) {
        next.push_back(next[k - 1] + (next[k - 1] - row[k - 1]) / (std::pow(4., k) - 1));
        const double apart = std::max((next[k] - next[k - 1]).cwiseQuotient(scale).cwiseAbs().maxCoeff(),
                                      (next[k] - row[k - 1]).cwiseQuotient(scale).cwiseAbs().maxCoeff());
        if (apart >= uncertain) continue;
        uncertain = apart;
        found = next[k];
      }
      row = std::move(next);
    }
    // Columns of velocities by the pace, as A has them in units of the mechanism.
    const VectorXd off = (found - r.A.block(f, column, f, 1)).cwiseQuotient(scale) * scale[column % f];
    worst = std::max(worst, off.cwiseAbs().maxCoeff() / (column < f ? pace * pace : pace));
  }
  EXPECT_LT(worst, 1e-8);
  ++compared;
  redundant += at.names.redundant > 0 ? 1 : 0;
}

class BothFormulations : public testing::TestWithParam<int> {};
TEST_P(BothFormulations, HaveTheSameLinearModel) {
  int compared = 0, redundant = 0, unlike = 0;
  for (unsigned k = 0; k < 25; ++k) {
    const unsigned seed = 1000 + 25u * static_cast<unsigned>(GetParam()) + k;
    SCOPED_TRACE(seed);
    RandomOptions options;
    options.springs = options.damping = true;
    options.loops = static_cast<int>(seed % 4);
    options.flexible_share = seed % 2 == 0 ? 0 : 0.3;
    expect_same_matrix(random_mechanism(seed, options), compared, redundant, unlike);
  }
  RecordProperty("compared", compared);
  RecordProperty("redundant", redundant);
  RecordProperty("unlike", unlike);
  EXPECT_LE(unlike, 2);
  EXPECT_GT(compared, 15);
}
INSTANTIATE_TEST_SUITE_P(Seeds, BothFormulations, testing::Range(0, 8));

/// A motor turns the first of two links. The nonlinear model after a step of its torque by ε, less its rest,
/// is the linear model's answer and an error of order two and more: twice the step, at least almost four
/// times the error (the mechanism hangs askew, so that there are quadratic terms).
TEST(Linearise, AShortRunIsThatOfTheLinearModel) {
  const auto model = model_of(R"yaml(
bodies:
  one: {mass: 2, com: [0.25, 0, 0], inertia: [0.01, 0.04, 0.04]}
  two: {mass: 1, com: [0.7, 0, 0], inertia: [0.01, 0.02, 0.02]}
joints:
  a: {type: revolute, between: [ground, one], at: [0, 0, 0], axis: [0, 1, 0], spring: {stiffness: 30, damping: 0.3}}
  b: {type: revolute, between: [one, two], at: [0.5, 0, 0], axis: [0, 1, 0], spring: {stiffness: 20, damping: 0.1}}
inputs: {torque: {start: 0, unit: N m}}
actuators: {motor: {joint: a, torque: torque}}
outputs:
  - {name: a, joint: a}
  - {name: x, position: two, at: [0.9, 0, 0], component: x}
  - {name: f, joint_force: b, component: fz}
initial: equilibrium
)yaml");
  const LinearModel linear = linearise(model);
  EXPECT_EQ(linear.point, "equilibrium");
  constexpr double end = 0.2;
  // x(t) = A⁻¹ (e^{At} − 1) B ε.
  const Eigen::EigenSolver<MatrixXd> pairs(linear.A);
  const Eigen::MatrixXcd V = pairs.eigenvectors();
  const Eigen::VectorXcd grown =
      ((pairs.eigenvalues() * end).array().exp() - 1).matrix().cwiseQuotient(pairs.eigenvalues());
  const VectorXd x =
      (V * grown.asDiagonal() * V.inverse() * linear.B.col(0).cast<std::complex<double>>()).real();
  const VectorXd slope = linear.C * x + linear.D.col(0);
  const auto error = [&](double eps) {
    RunOptions options;
    options.step = 2e-4;
    options.tolerance = 1e-12;
    options.rho = 1;
    Simulation run(model, options);
    run.set_input(0, eps);
    run_to(run, end);
    VectorXd off(3);
    const char* names[] = {"a", "x", "f"};
    for (int k = 0; k < 3; ++k)
      off[k] = channel(run, names[k]) - linear.output_values[static_cast<std::size_t>(k)] - eps * slope[k];
    return off;
  };
  const VectorXd wide = error(0.4), narrow = error(0.2), least = error(0.1);
  for (int k = 0; k < 3; ++k) {
    EXPECT_LT(std::abs(least[k]), 0.1 * 0.1 * std::abs(slope[k])) << k;
    EXPECT_GT(std::abs(wide[k] / narrow[k]), 3.2) << k;
    EXPECT_GT(std::abs(narrow[k] / least[k]), 3.2) << k;
  }
}

/// A pendulum on a base that a formula of an input and the time turns, θ(u, t): φ̈ = −k sin(θ + φ) − θ̈ gives,
/// for u, its rate and its second derivative, B = (−k cos θ θᵤ − θᵤₜₜ, −2 θᵤₜ, −θᵤ).
TEST(Linearise, ADriveThatFollowsAFormulaOfAnInput) {
  const auto B = [](const std::string& drive) {
    const LinearModel m = linearise(model_of(fmt::format(R"yaml(
bodies:
  base: {{mass: 1, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}}
  bob: {{mass: 2, com: [0, 0, -0.7], inertia: [0.03, 0.02, 0.01]}}
inputs: {{u: {{start: 0.2}}}}
joints:
  turn: {{type: revolute, between: [ground, base], at: [0, 0, 0], axis: [0, 1, 0], drive: {{position: "{}"}}}}
  pin: {{type: revolute, between: [base, bob], at: [0, 0, 0], axis: [0, 1, 0]}}
)yaml",
                                                         drive)),
                                    at_start());
    EXPECT_EQ(m.B.cols(), 3);
    return Eigen::Vector3d(m.B.row(1));
  };
  const double k = 2 * 9.81 * 0.7 / (2 * 0.7 * 0.7 + 0.02), u = 0.2;
  const auto expect = [&](const std::string& drive, const Eigen::Vector3d& expected, double tolerance) {
    EXPECT_LE((B(drive) - expected).norm(), tolerance * expected.norm()) << drive << ": " << B(drive);
  };
  expect("u", {-k * std::cos(u), 0, -1}, 1e-12);
  expect("u + u^2/2", {-k * std::cos(u + u * u / 2) * (1 + u), 0, -(1 + u)}, 1e-12);
  expect("sin(3*u)*exp(2*t)",
         {(-k * std::cos(std::sin(3 * u)) - 4) * 3 * std::cos(3 * u), -4 * 3 * std::cos(3 * u),
          -3 * std::cos(3 * u)},
         1e-12);
  for (const double K : {100., 3000.})  // θᵤₜₜ = −4 cos(K u) at t = 0 with θ = sin(K u + 2 t)/K
    expect(fmt::format("sin({0}*u + 2*t)/{0}", K),
           {-k * std::cos(std::sin(K * u) / K) * std::cos(K * u) + 4 * std::cos(K * u), 4 * std::sin(K * u),
            -std::cos(K * u)},
           1e-11);
}

TEST(Linearise, SaysHowFarThePointIsFromAnEquilibrium) {
  const LinearModel m = linearise(model_of(R"yaml(
bodies: {bob: {mass: 2, com: [0.7, 0, 0], inertia: [0.03, 0.02, 0.01]}}
joints: {pin: {type: revolute, between: [ground, bob], at: [0, 0, 0], axis: [0, 1, 0]}}
)yaml"),
                                  at_start());
  ASSERT_EQ(m.warnings.size(), 1u);
  EXPECT_THAT(m.warnings[0], testing::HasSubstr("no equilibrium: 'pin' accelerates by"));
  EXPECT_NEAR(m.acceleration, 2 * 9.81 * 0.7 / 1.0, 1e-9);
}

/// One of two forces that hold each other, a little larger than the other, moves the body.
TEST(Linearise, SaysWhereForcesNearlyBalance) {
  for (const double more : {0., 1e-6}) {
    const LinearModel m = linearise(model_of(fmt::format(R"yaml(
gravity: [0, 0, 0]
bodies: {{block: {{mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}}}
joints: {{slide: {{type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0]}}}}
loads:
  push: {{on: block, at: [0, 0, 0], force: [3, 0, 0]}}
  pull: {{on: block, at: [0, 0, 0], force: [{}, 0, 0]}}
)yaml",
                                                         -3 - more)),
                                    at_start());
    EXPECT_EQ(m.warnings.size(), more > 0 ? 1u : 0u);
  }
}

TEST(Linearise, RefusesWhatHasNoMass) {
  try {
    linearise(model_of(R"yaml(
bodies:
  arm: {mass: 0, com: [0, 0, 0], inertia: [0, 0, 0]}
joints: {pin: {type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 1, 0], spring: {stiffness: 3}}}
)yaml"),
              at_start());
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("joint 'pin' moves no mass"));
  }
}

/// A four-bar whose bars all lie on one line can go on in two ways.
TEST(Linearise, RefusesASingularPosition) {
  try {
    linearise(model_of(R"yaml(
gravity: [0, 0, 0]
bodies:
  a: {mass: 1, com: [0.5, 0, 0], inertia: [0.1, 0.1, 0.1]}
  b: {mass: 1, com: [1, 0, 0], inertia: [0.1, 0.1, 0.1]}
  c: {mass: 1, com: [1.5, 0, 0], inertia: [0.1, 0.1, 0.1]}
joints:
  j1: {type: revolute, between: [ground, a], at: [0, 0, 0], axis: [0, 1, 0]}
  j2: {type: revolute, between: [a, b], at: [1, 0, 0], axis: [0, 1, 0]}
  j3: {type: revolute, between: [b, c], at: [3, 0, 0], axis: [0, 1, 0]}
  j4: {type: revolute, between: [c, ground], at: [2, 0, 0], axis: [0, 1, 0]}
)yaml"),
              at_start());
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("singular position"));
  }
}

/// A bar that hangs in a law of the user's, with neither gravity nor tangents given: ẍ = −(k x + d v)/J. Laws
/// that steps call at their start count as if they were called all the time.
TEST(Linearise, TakesDifferencesOfUsersLaws) {
  for (const bool sampled : {false, true}) {
    spec::Model model = parse_model(R"yaml(mimbre: 1
gravity: [0, 0, 0]
bodies: {bar: {mass: 1, com: [0.5, 0, 0], inertia: [0.001, 0.1, 0.1]}}
joints: {pin: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0], position: 0.3}}
)yaml",
                                    "law.yaml", ".");
    auto law = std::make_shared<spec::UserLaw>();
    law->sampled = sampled;
    law->evaluate = [](spec::LawCall& call) {
      const double x = call.x[0], v = call.v[0];
      call.force[0] = 50 * x + 400 * x * x * x + 0.5 * v + 20;
    };
    spec::Element element;
    element.name = "own";
    element.law = "user";
    element.on = spec::Element::On::coordinate;
    element.joint = 0;
    element.user = law;
    model.elements.push_back(element);
    const LinearModel found = linearise(Model::compile(std::move(model)), at_start());
    const double inertia = 0.1 + 0.25, stiffness = 50 + 3 * 400 * 0.09;
    ASSERT_EQ(found.A.rows(), 2) << sampled;
    MatrixXd A(2, 2);
    A << 0, 1, -stiffness / inertia, -0.5 / inertia;
    EXPECT_LT((found.A - A).norm(), 1e-8 * A.norm()) << sampled << found.A;
    // The torque moves it: this is no equilibrium, which it says, and how the law was taken.
    EXPECT_THAT(found.warnings, testing::ElementsAre(testing::HasSubstr("no equilibrium")));
    EXPECT_NEAR(found.acceleration, (50 * 0.3 + 400 * 0.027 + 20) / inertia, 1e-9);
    ASSERT_EQ(found.notes.size(), 1u) << sampled;
    EXPECT_THAT(found.notes[0], testing::HasSubstr("'own' is a law of the user"));
    EXPECT_EQ(found.notes[0].find("at every instant") != std::string::npos, sampled);
  }
}

/// A straight column under a load at its end that follows it is in equilibrium, but for round-off; there is
/// no gravity to compare that with. Before it has bent under a load across it, however small, it is in none.
TEST(Linearise, TakesRoundOffForNoMotion) {
  for (const double across : {0., 1e-6}) {
    const LinearModel found = linearise(model_of(fmt::format(R"yaml(
gravity: [0, 0, 0]
materials: {{s: {{young: 1.2e7, poisson: 0.3, density: 1000}}}}
sections: {{q: {{type: rectangle, width: 0.02, height: 0.01}}}}
bodies:
  beam:
    frame: {{at: [0, 0, 0]}}
    flexible:
      material: s
      section: q
      nodes: {{root: [0, 0, 0], tip: [1, 0, 0]}}
      bars: {{all: {{from: root, to: tip, elements: 20}}}}
      clamped: [root]
      beam: corotational
joints: {{base: {{type: fixed, between: [ground, beam], at: [0, 0, 0]}}}}
loads:
  push: {{on: beam.tip, force: [-0.3, 0, 0], follower: true}}
  side: {{on: beam.tip, force: [0, {}, 0]}}
)yaml",
                                                             across)),
                                        across > 0 ? at_start() : LinearOptions());
    const bool warned = std::any_of(found.warnings.begin(), found.warnings.end(), [](const std::string& w) {
      return w.find("no equilibrium") != std::string::npos;
    });
    EXPECT_EQ(warned, across > 0);
  }
}

}  // namespace
}  // namespace mimbre::test::linearise_test
