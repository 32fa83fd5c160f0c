#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "compile/compiled.h"
#include "mimbre/simulation.h"
#include "support/models.h"
#include "support/random_mechanism.h"
#include "support/simulate.h"

/// Lengths, masses and times of a mechanism come from what moves and is held: neither round-off, nor a point
/// that is far away, nor a heavy neighbour, nor the unit system changes how a motion is computed.
namespace mimbre::test::scales_test {
namespace {

using testing::HasSubstr;

constexpr Formulation formulations[] = {Formulation::relative, Formulation::natural};

/// A free body whose frame is off its centre of mass, about which it turns; `more` acts on it.
std::string spinning_body(const std::string& more) {
  return R"(
gravity: [0, 0, 0]
bodies:
  b: {mass: 2.766682846517084, com: [0, 0, 0], inertia: [0.0445, 0.0349, 0.06],
      frame: {at: [-0.1870651080844703, -0.34387054172810294, -0.14970755975522798]}}
joints:
  j: {type: floating, between: [ground, b], at: [0, 0, 0],
      velocity: [0, 0, 0, -0.533735348335933, 1.6721302988164963, 1.8018759648670046]}
outputs:
  - {name: wx, angular_velocity: b, component: x}
)" + more;
}

/// ω of that body after 0.2 s by Euler's equations with axes that turn along, Runge and Kutta's rule; from
/// body axes to the ground's with the rotation.
double exact_wx() {
  const Eigen::Vector3d J(0.0445, 0.0349, 0.06);
  Eigen::Vector3d w(-0.533735348335933, 1.6721302988164963, 1.8018759648670046);
  Eigen::Matrix3d A = Eigen::Matrix3d::Identity();
  const auto rate = [&](const Eigen::Vector3d& x) {
    return Eigen::Vector3d(-x.cross(J.cwiseProduct(x)).cwiseQuotient(J));
  };
  const auto turning = [](const Eigen::Matrix3d& R, const Eigen::Vector3d& x) {
    Eigen::Matrix3d cross;
    cross << 0, -x[2], x[1], x[2], 0, -x[0], -x[1], x[0], 0;
    return Eigen::Matrix3d(R * cross);
  };
  const int steps = 2000;
  const double h = 0.2 / steps;
  for (int k = 0; k < steps; ++k) {
    const Eigen::Vector3d k1 = rate(w), w2 = w + h / 2 * k1, k2 = rate(w2), w3 = w + h / 2 * k2,
                          k3 = rate(w3), w4 = w + h * k3, k4 = rate(w4);
    const Eigen::Matrix3d a1 = turning(A, w), a2 = turning(A + h / 2 * a1, w2),
                          a3 = turning(A + h / 2 * a2, w3), a4 = turning(A + h * a3, w4);
    w += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    A += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return (A * w)[0];
}

double wx(const std::string& more, Formulation formulation) {
  Simulation s = simulation_of(spinning_body(more), formulation, 0.001);
  run_to(s, 0.2);
  return channel(s, "wx");
}

TEST(Scales, RoundOffIsNoLength) {
  const double exact = exact_wx();
  EXPECT_NEAR(exact, -0.832, 1e-3);
  const std::string floor = R"(
surfaces: {f: {type: half_space, at: [0, 0, -100], z: [0, 0, 1]}}
contacts:
  c: {spheres: {on: b, at: [0, 0, 0], radius: 0.1}, surfaces: [f], stiffness: 8070, restitution: 0.4}
)";
  const std::string spring = R"(
springs: {s: {between: [ground, b], at: [[0, 0, 1], [0, 0, 0]], elastic: {stiffness: 0, zero: 1}}}
)";
  for (const Formulation formulation : formulations)
    for (const std::string& more : {std::string(), floor, spring})
      EXPECT_NEAR(wx(more, formulation), exact, 1e-5) << more;
}

TEST(Scales, APointFarAwayIsNoLength) {
  const double exact = exact_wx();
  for (const Formulation formulation : formulations) {
    EXPECT_NEAR(wx("loads: {l: {on: b, at: [10000, 0, 0], force: [0, 0, 0]}}\n", formulation), exact, 1e-5);
    EXPECT_NEAR(wx("springs: {s: {between: [ground, b], at: [[10000, 0, 1], [10000, 0, 0]], "
                   "elastic: {stiffness: 0, zero: 1}}}\n",
                   formulation),
                exact, 1e-5);
  }
}

double length_of(const std::string& text) { return model_of(text)->compiled().length_scale; }

/// A pendulum's length is from its centre of mass to its joint, which nothing but its body sees.
TEST(Scales, TheJointThatCarriesABodyHoldsIt) {
  const std::string bodies = R"(
gravity: [0, 0, -9.81]
bodies:
  ball: {mass: 1, com: [0, 0, -1], inertia: [1e-4, 1e-4, 1e-4]}
joints:
)";
  const std::string touching = R"(
surfaces: {floor: {type: half_space, at: [0, 0, -2]}}
contacts: {c: {spheres: {on: ball, at: [0, 0, -1], radius: 0.02}, surfaces: [floor], stiffness: 1e5}}
)";
  const std::string pivot =
                        "  j: {type: revolute, between: [ground, ball], at: [0, 0, 0], axis: [0, 1, 0]}\n",
                    reversed =
                        "  j: {type: revolute, between: [ball, ground], at: [0, 0, 0], axis: [0, 1, 0]}\n",
                    pin = "  j: {type: spherical, between: [ground, ball], at: [0, 0, 0]}\n";
  for (const std::string& joint : {pivot, reversed, pin}) {
    EXPECT_NEAR(length_of(bodies + joint), 1, 1e-12) << joint;
    EXPECT_NEAR(length_of(bodies + joint + touching), 1, 1e-12) << joint;
  }
  // Where a guide or a plane is given along itself does not count; how far the body is from it does.
  for (const double along : {0.0, 7.0, -1e5}) {
    EXPECT_NEAR(
        length_of(bodies + fmt::format("  j: {{type: prismatic, between: [ground, ball], at: [{}, 0, -0.7], "
                                       "axis: [1, 0, 0]}}\n",
                                       along)),
        0.3, 1e-9);
    EXPECT_NEAR(
        length_of(bodies + fmt::format("  j: {{type: planar, between: [ground, ball], at: [{}, 0.2, {}], "
                                       "axis: [0, 1, 0]}}\n",
                                       along, 2 * along)),
        0.2, 1e-9);
  }
  // One that leaves everything free holds nothing.
  EXPECT_NEAR(length_of(bodies + "  j: {type: floating, between: [ground, ball], at: [0, 0, 0]}\n"),
              std::sqrt(1.5e-4), 1e-9);
}

/// Where rigid bodies are said to be one does not count: 'k' is a part of the ground, and 'tip' of the ball.
TEST(Scales, TheFixedJointOfARigidBodyMayBeAnywhere) {
  const auto text = [](double place) {
    return fmt::format(R"(
bodies:
  ball: {{mass: 1, com: [0, 0, -1], inertia: [1e-4, 1e-4, 1e-4]}}
  k: {{mass: 1, com: [2, 0, 0], inertia: [1e-2, 1e-2, 1e-2]}}
  tip: {{mass: 1, com: [0, 0, -1.1], inertia: [1e-2, 1e-2, 1e-2]}}
joints:
  j: {{type: revolute, between: [ground, ball], at: [0, 0, 0], axis: [0, 1, 0]}}
  f: {{type: fixed, between: [k, ground], at: [{0}, 0, 0]}}
  g: {{type: fixed, between: [ball, tip], at: [0, {0}, -1]}}
)",
                       place);
  };
  const double at_home = length_of(text(0));
  EXPECT_GT(at_home, 0.1);
  EXPECT_LT(at_home, 1);
  EXPECT_NEAR(length_of(text(1000)), at_home, 1e-12);
}

std::string numbers(const Eigen::Vector3d& v) {
  return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v[0], v[1], v[2]);
}

/// One to three bodies that fly, swing or turn, with frames, contacts and springs anywhere.
std::string random_bodies(unsigned seed, int& bodies) {
  Random random(seed);
  std::string body, joint, surface, contact, spring, output;
  bodies = 1 + random.index(3);
  for (int k = 0; k < bodies; ++k) {
    const Eigen::Vector3d centre =
        Eigen::Vector3d(1.5 * k, 0, 0) + (random.chance(0.5) ? random.vector(0.3) : Vec3d(Vec3d::Zero()));
    const auto place = [&] {
      return Eigen::Vector3d(centre + (random.chance(0.6) ? Vec3d(Vec3d::Zero()) : random.vector(0.3)));
    };
    const Eigen::Vector3d inertia(random.number(0.03, 0.055), random.number(0.03, 0.055),
                                  random.number(0.03, 0.055));
    body += fmt::format("  b{}: {{mass: {:.17g}, com: {}, inertia: {}", k, random.number(0.5, 3),
                        numbers(centre), numbers(inertia));
    if (random.chance(0.7))
      body +=
          fmt::format(", frame: {{at: {}}}", numbers(centre + random.vector(random.chance(0.1) ? 50 : 0.5)));
    body += "}\n";
    const int type = random.index(4);
    joint += fmt::format("  j{}: {{type: {}, between: [ground, b{}], at: {}, ", k,
                         type < 2    ? "floating"
                         : type == 2 ? "spherical"
                                     : "revolute",
                         k, numbers(place()));
    const Eigen::Vector3d spin = random.vector(2), way = random.vector(0.5);
    if (type < 2)
      joint += fmt::format("velocity: [{:.17g}, {:.17g}, {:.17g}, {:.17g}, {:.17g}, {:.17g}]}}\n", way[0],
                           way[1], way[2], spin[0], spin[1], spin[2]);
    else if (type == 2)
      joint += fmt::format("velocity: {}}}\n", numbers(spin));
    else
      joint += fmt::format("axis: {}, velocity: {:.17g}}}\n", numbers(spin.normalized()), way[0]);
    if (random.chance(0.5)) {
      surface += fmt::format("  s{}: {{type: half_space, at: [0, 0, {}], z: [0, 0, 1]}}\n", k,
                             random.chance(0.5) ? -100 : -0.6);
      contact += fmt::format(
          "  c{0}: {{spheres: {{on: b{0}, at: {1}, radius: 0.1}}, surfaces: [s{0}], stiffness: {2:.17g}, "
          "restitution: 0.5}}\n",
          k, numbers(place()), random.number(5e3, 1e4));
    }
    if (random.chance(0.5))
      spring += fmt::format(
          "  f{0}: {{between: [ground, b{0}], at: [{1}, {2}], elastic: {{stiffness: {3:.17g}, "
          "zero: 1}}}}\n",
          k, numbers(centre + Eigen::Vector3d(0, 0, random.number(0.7, 1.5))), numbers(place()),
          random.number(5, 50));
    output += fmt::format(
        "  - {{name: wx{0}, angular_velocity: b{0}, component: x}}\n"
        "  - {{name: wz{0}, angular_velocity: b{0}, component: z}}\n"
        "  - {{name: x{0}, position: b{0}, at: {1}, component: x}}\n",
        k, numbers(centre));
  }
  const auto section = [](const char* name, const std::string& of) {
    return of.empty() ? std::string() : std::string(name) + ":\n" + of;
  };
  return fmt::format("gravity: [0, 0, {}]\n", random.chance(0.5) ? 0.0 : -9.81) + section("bodies", body) +
         section("joints", joint) + section("surfaces", surface) + section("contacts", contact) +
         section("springs", spring) + section("outputs", output);
}

Eigen::VectorXd end_of(const std::string& text, int outputs, Formulation formulation, double step) {
  Simulation s = simulation_of(text, formulation, step);
  run_to(s, 0.2);
  ResultsRow row;
  s.sample(row);
  return row.channels.head(outputs);
}

/// Both sets of coordinates agree within the error of the step, by what half of it changes.
TEST(Scales, RandomBodiesMoveAlikeInBothFormulations) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    int bodies = 0;
    const std::string text = random_bodies(seed, bodies);
    Eigen::VectorXd end[2][2];
    for (int f = 0; f < 2; ++f)
      for (int k = 0; k < 2; ++k)
        end[f][k] = end_of(text, 3 * bodies, formulations[f], k == 0 ? 0.002 : 0.001);
    if (testing::Test::HasFatalFailure()) FAIL() << "seed " << seed << '\n' << text;
    const double apart = (end[0][1] - end[1][1]).cwiseAbs().maxCoeff();
    double error = 0;
    for (int f = 0; f < 2; ++f) error = std::max(error, (end[f][0] - end[f][1]).cwiseAbs().maxCoeff());
    EXPECT_LE(apart, 2 * error + 1e-6) << "seed " << seed << '\n' << text;
  }
}

/// A ball of a millimetre beside a body of ten tons falls as any ball does, and keeps its spin.
TEST(Scales, ASmallBodyBesideAHeavyOne) {
  const std::string text = R"(
gravity: [0, 0, -9.81]
bodies:
  big: {mass: 1e4, com: [0, 0, 1], inertia: [5e3, 5e3, 5e3]}
  ball: {mass: 0.01, com: [3, 0, 0.1], inertia: [1e-9, 1e-9, 1e-9]}
joints:
  a: {type: floating, between: [ground, big], at: [0, 0, 1]}
  b: {type: floating, between: [ground, ball], at: [3, 0, 0.1], velocity: [0, 0, 0, 1, 2, 3]}
surfaces: {f: {type: half_space, at: [0, 0, 0], z: [0, 0, 1]}}
contacts:
  c: {spheres: [{on: ball, at: [3, 0, 0.1], radius: 0.0005}], surfaces: [f], stiffness: 1000, restitution: 0.3}
outputs:
  - {name: z, position: ball, at: [3, 0, 0.1], component: z}
  - {name: wy, angular_velocity: ball, component: y}
)";
  for (const Formulation formulation : formulations) {
    Simulation s = simulation_of(text, formulation, 0.001);
    run_to(s, 0.1);
    EXPECT_NEAR(channel(s, "z"), 0.1 - 0.5 * 9.81 * 0.01, 1e-7);
    EXPECT_NEAR(channel(s, "wy"), 2, 1e-4);
  }
}

/// A body without mass between two joints that turn about one axis: springs decide how it turns. With a
/// little inertia, the limit of which it is, the arm moves the same.
TEST(Scales, AMasslessBodyThatSpringsHold) {
  const auto arm = [](const std::string& small) {
    return R"(
bodies:
  a1: )" + small +
           R"(
  arm: {mass: 2, com: [0, 0.2, 0], inertia: [0.02, 0.001, 0.02]}
joints:
  x: {type: cylindrical, between: [ground, a1], at: [0, 0, 0], axis: [1, 0, 0],
      spring: [{coordinate: 0, stiffness: 10, damping: 1}, {coordinate: 1, stiffness: 1e6, damping: 100}]}
  y: {type: planar, between: [a1, arm], at: [0, 0, 0], axis: [1, 0, 0],
      spring: [{coordinate: 0, stiffness: 1e6, damping: 1000}, {coordinate: 1, stiffness: 1e6, damping: 1000},
               {coordinate: 2, stiffness: 100}]}
outputs: [{name: z, position: arm, at: [0, 0.4, 0], component: z}]
)";
  };
  const std::string massless = arm("{mass: 0, com: [0, 0, 0], inertia: [0, 0, 0]}"),
                    light = arm("{mass: 1e-4, com: [0, 0, 0], inertia: [1e-6, 1e-6, 1e-6]}");
  double z[2];
  for (int f = 0; f < 2; ++f) {
    Simulation s = simulation_of(massless, formulations[f], 0.0005),
               t = simulation_of(light, formulations[f], 0.0005);
    run_to(s, 1);
    run_to(t, 1);
    z[f] = channel(s, "z");
    EXPECT_LT(z[f], -0.05);
    EXPECT_NEAR(z[f], channel(t, "z"), 1e-4);
  }
  EXPECT_NEAR(z[0], z[1], 1e-5);
}

/// Where nothing holds it the body or the joint is named.
TEST(Scales, AMotionWithoutInertiaIsNamed) {
  const std::string text = R"(
bodies:
  between: {mass: 0, com: [0, 0, 0], inertia: [0, 0, 0]}
  arm: {mass: 2, com: [0, 0.2, 0], inertia: [0.02, 0.001, 0.02]}
joints:
  first: {type: revolute, between: [ground, between], at: [0, 0, 0], axis: [1, 0, 0]}
  second: {type: revolute, between: [between, arm], at: [0, 0, 0], axis: [1, 0, 0]}
)";
  for (const Formulation formulation : formulations) try {
      Simulation s = simulation_of(text, formulation, 0.001);
      ADD_FAILURE() << "no error";
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), HasSubstr("'between'"));
      EXPECT_THAT(e.what(), HasSubstr("accelerations at the start are not determined"));
    }
}

/// A chain of links of a metre about parallel axes, hanging, its first joint turning at 0.5 rad/s.
std::string chain_of(const std::vector<double>& masses) {
  std::string bodies = "bodies:\n", joints = "joints:\n";
  for (std::size_t k = 0; k < masses.size(); ++k) {
    const double J = masses[k] / 12;
    bodies += fmt::format("  l{}: {{mass: {}, com: [0, 0, {}], inertia: [{}, {}, {}]}}\n", k, masses[k],
                          -(static_cast<double>(k) + 0.5), J, J, 0.1 * J);
    joints += fmt::format(
        "  j{0}: {{type: revolute, between: [{1}, l{0}], at: [0, 0, -{0}], axis: [0, 1, 0]{2}}}\n", k,
        k == 0 ? "ground" : fmt::format("l{}", k - 1), k == 0 ? ", velocity: 0.5" : "");
  }
  return fmt::format("gravity: [0, 0, -9.81]\n{}{}outputs: [{{name: x, position: l{}, component: x}}]\n",
                     bodies, joints, masses.size() - 1);
}

/// Where the last link of such a chain is at the time t when the others have no mass: these are one straight
/// line then, of the length l, and it is a double pendulum of Lagrange's equations in both angles, integrated
/// by Runge and Kutta's rule.
double exact_end(double l, double t) {
  constexpr double c = 0.5, J = 1.0 / 12, g = 9.81;
  using State = Eigen::Vector4d;  // angles of the line and the link, their rates
  const auto rate = [&](const State& y) {
    const double apart = y[0] - y[1], coupling = l * c * std::cos(apart), turning = l * c * std::sin(apart);
    Eigen::Matrix2d mass;
    mass << l * l, coupling, coupling, c * c + J;
    const Eigen::Vector2d force(-g * l * std::sin(y[0]) - turning * y[3] * y[3],
                                -g * c * std::sin(y[1]) + turning * y[2] * y[2]);
    State made;
    made << y[2], y[3], mass.inverse() * force;
    return made;
  };
  const int steps = 1000;
  const double h = t / steps;
  State y(0, 0, 0.5, 0.5);
  for (int k = 0; k < steps; ++k) {
    const State k1 = rate(y), k2 = rate(y + h / 2 * k1), k3 = rate(y + h / 2 * k2), k4 = rate(y + h * k3);
    y += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return -l * std::sin(y[0]) - c * std::sin(y[1]);
}

/// Where the last link of such a chain is at the time t: Lagrange's equations in the angles θ of the links
/// against the vertical,
///   Σ_j c_ij (cos(θ_i − θ_j) θ̈_j + sin(θ_i − θ_j) θ̇_j²) = −g w_i sin θ_i
/// with w_i half the link's mass and all below it, c_ii a third of it and all below, c_ij = w of the lower
/// one, by Runge and Kutta's rule. The matrix is scaled by its diagonal, so that light links count.
double exact_end_of(const std::vector<double>& masses, double t) {
  const auto n = static_cast<Eigen::Index>(masses.size());
  Eigen::VectorXd weight(n), inertia(n);
  double below = 0;
  for (Eigen::Index k = n; k-- > 0;) {
    const double mass = masses[static_cast<std::size_t>(k)];
    weight[k] = mass / 2 + below;
    inertia[k] = mass / 3 + below;
    below += mass;
  }
  const Eigen::VectorXd scale = inertia.cwiseSqrt().cwiseInverse();
  const auto rate = [&](const Eigen::VectorXd& y) {
    const auto angle = y.head(n), speed = y.tail(n);
    Eigen::MatrixXd matrix(n, n);
    Eigen::VectorXd force(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      force[i] = -9.81 * weight[i] * std::sin(angle[i]);
      for (Eigen::Index j = 0; j < n; ++j) {
        const double c = i == j ? inertia[i] : weight[std::max(i, j)], apart = angle[i] - angle[j];
        matrix(i, j) = scale[i] * c * std::cos(apart) * scale[j];
        force[i] -= c * std::sin(apart) * speed[j] * speed[j];
      }
    }
    Eigen::VectorXd made(2 * n);
    made << speed, scale.cwiseProduct(matrix.llt().solve(scale.cwiseProduct(force)));
    return made;
  };
  const int steps = 500;
  const double h = t / steps;
  Eigen::VectorXd y(2 * n);
  y << Eigen::VectorXd::Zero(n), Eigen::VectorXd::Constant(n, 0.5);
  for (int k = 0; k < steps; ++k) {
    const Eigen::VectorXd k1 = rate(y), k2 = rate(y + h / 2 * k1), k3 = rate(y + h / 2 * k2),
                          k4 = rate(y + h * k3);
    y += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  double x = 0.5 * std::sin(y[n - 1]);
  for (Eigen::Index k = 0; k < n; ++k) x -= std::sin(y[k]);
  return x;
}

/// Light links that hold a heavy one swing fast between their joints; a step that follows that moves the
/// heavy one right, up to the ratio of masses at which a number has no digits left for the light ones.
TEST(Scales, AHeavyBodyOnALightChainIsAPendulum) {
  struct Run {
    double ratio, step;
    int steps;
  };
  // √(m L/(M g)) is 3e-5 s, 3e-7 s and 1e-7 s.
  for (const Run& run : {Run{1e3, 1e-3, 500}, Run{1e5, 1e-3, 500}, Run{1e8, 3e-5, 1000}, Run{1e12, 3e-7, 500},
                         Run{1e13, 1e-7, 500}})
    for (const Formulation formulation : formulations) {
      SCOPED_TRACE(run.ratio);
      Simulation s = simulation_of(chain_of({1e-3, 1e-3, 1e-3, 1e-3 * run.ratio}), formulation, run.step);
      for (int k = 0; k < run.steps; ++k) {
        const StepReport report = s.step();
        ASSERT_TRUE(report.ok()) << s.explain(report);
      }
      const double exact = exact_end(3, s.time());
      EXPECT_NEAR(channel(s, "x"), exact, (1e-6 + 0.5 / run.ratio) * std::abs(exact));
    }
}

/// Chains that a step of 5 ms does not follow, or no step, are refused: the message names the bodies, and the
/// step that would do. Those that run are right: one whose links get heavier is the pendulum of its last, and
/// one whose links get lighter, by 15 orders, moves as theory says.
TEST(Scales, MassesFarApartAreNamed) {
  std::vector<double> growing, shrinking;
  for (int k = -7; k <= 8; ++k)
    growing.push_back(std::pow(10.0, k)), shrinking.push_back(std::pow(10.0, 1 - k));
  int shrinking_ones = 0;
  for (const std::vector<double>& masses : {std::vector<double>{1e-3, 1e-3, 1e-3, 1e3},
                                            {1e-3, 1e-3, 1e-3, 1e6},
                                            {1e-3, 1e-3, 1e-3, 1e9},
                                            {1e-3, 1e-3, 1e-3, 1e12},
                                            growing,
                                            shrinking})
    for (const Formulation formulation : formulations) try {
        Simulation s = simulation_of(chain_of(masses), formulation, 0.005);
        StepReport report;
        for (int k = 0; k < 100 && report.ok(); ++k) report = s.step();
        if (!report.ok()) {
          EXPECT_THAT(s.explain(report), HasSubstr("is joined to"));
          EXPECT_THAT(s.explain(report), HasSubstr("steps of about"));
        } else if (masses == shrinking) {
          EXPECT_NEAR(channel(s, "x"), exact_end_of(masses, s.time()), 2e-5);
          ++shrinking_ones;
        } else {
          ASSERT_EQ(masses.size(), 4u);
          EXPECT_NEAR(channel(s, "x"), exact_end(3, s.time()), 1e-4);
        }
      } catch (const InputError& e) {
        EXPECT_THAT(e.what(), HasSubstr("joint 'j"));
      }
  EXPECT_EQ(shrinking_ones, 2);
}

/// A four-bar mechanism with springs and a damper that starts in its equilibrium under a load, in units of
/// length L, mass M and time T.
std::string in_units(double L, double M, double T, bool equilibrium) {
  return fmt::format(R"(
parameters: {{L: {:.17g}, M: {:.17g}, T: {:.17g}}}
gravity: [0, 0, -9.81*L/T^2]
initial: {}
bodies:
  c: {{mass: 0.5*M, com: [0, 0, 0.1*L], inertia: [0.002*M*L^2, 0.002*M*L^2, 0.0001*M*L^2]}}
  k: {{mass: M, com: [0.3*L, 0, 0.35*L], inertia: [0.02*M*L^2, 0.02*M*L^2, 0.0005*M*L^2]}}
  r: {{mass: M, com: [0.6*L, 0, 0.25*L], inertia: [0.02*M*L^2, 0.02*M*L^2, 0.0005*M*L^2]}}
joints:
  a: {{type: revolute, between: [ground, c], at: [0, 0, 0], axis: [0, 1, 0]{}}}
  b: {{type: revolute, between: [c, k], at: [0, 0, 0.2*L], axis: [0, 1, 0]}}
  d: {{type: revolute, between: [ground, r], at: [0.6*L, 0, 0], axis: [0, 1, 0],
       spring: {{stiffness: 40*M*L^2/T^2, damping: 0.1*M*L^2/T}}}}
  e: {{type: revolute, between: [k, r], at: [0.6*L, 0, 0.5*L], axis: [0, 1, 0]}}
springs:
  s: {{between: [ground, k], at: [[0.3*L, 0, 1.5*L], [0.3*L, 0, 0.4*L]],
       elastic: {{stiffness: 20*M/T^2, zero: L}}}}
outputs: [{{name: a, joint: a}}]
)",
                     L, M, T, equilibrium ? "equilibrium" : "assembled",
                     equilibrium ? "" : ", velocity: 3/T");
}

TEST(Scales, UnitsDoNotMatter) {
  for (const bool equilibrium : {false, true})
    for (const Formulation formulation : formulations) {
      double unit = 0;
      long unit_iterations = 0;
      for (const auto& [L, M, T] :
           {std::array{1.0, 1.0, 1.0}, std::array{1e-9, 1e-6, 1.0}, std::array{1e9, 1e9, 1.0},
            std::array{1e-9, 1e9, 1e-3}, std::array{1e9, 1e-6, 1e3}, std::array{1e3, 1e3, 60.0}}) {
        Simulation s = simulation_of(in_units(L, M, T, equilibrium), formulation, 0.01 * T);
        long iterations = 0;
        for (int k = 0; k < 100; ++k) {
          const StepReport report = s.step();
          ASSERT_TRUE(report.ok()) << s.explain(report) << " (" << L << " m, " << M << " kg, " << T << " s)";
          iterations += report.iterations;
        }
        const double a = channel(s, "a");
        if (L == 1) unit = a, unit_iterations = iterations;
        EXPECT_NEAR(a, unit, 1e-6) << L << " m, " << M << " kg, " << T << " s";
        // A step that starts in balance ends by round-off.
        if (!equilibrium) {
          EXPECT_EQ(iterations, unit_iterations) << L << " m, " << M << " kg, " << T << " s";
        }
      }
    }
}

}  // namespace
}  // namespace mimbre::test::scales_test
