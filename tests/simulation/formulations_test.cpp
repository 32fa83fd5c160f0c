#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "dynamics/natural/system.h"
#include "integrate/index3.h"
#include "integrate/initial.h"
#include "mimbre/simulation.h"
#include "mimbre/slow_formulation.h"
#include "mimbre/statics.h"
#include "support/models.h"
#include "support/random_mechanism.h"

/// Relative and natural coordinates are two roads to the same motion: trajectories, equilibria, reactions.
namespace mimbre::test::formulations_test {
namespace {

using Formulation = spec::Simulation::Formulation;
constexpr std::array<Formulation, 2> formulations{Formulation::relative, Formulation::natural};

RunOptions in(Formulation formulation) {
  RunOptions o;
  o.formulation = formulation;
  return o;
}

RunOptions trapezoidal(Formulation formulation, double step) {
  RunOptions o = in(formulation);
  o.step = step;
  o.integrator = spec::Simulation::Integrator::newmark;
  o.xi = 0;
  return o;
}

/// Newton's iterations to the end, so that what is left is the rule's own error.
std::shared_ptr<const Model> with_tight_tolerance(const std::shared_ptr<const Model>& model) {
  spec::Model m = model->spec();
  m.simulation.tolerance = 1e-8;
  return Model::compile(m);
}

/// Differences between the formulations at steps h, h/2, h/4.
struct Differences {
  double at[3] = {0, 0, 0};
};

/// They vanish with the square of the step; smaller ones than `least` are round-off and tolerances.
void expect_second_order(const Differences& d, double least, double largest, const std::string& what) {
  EXPECT_LT(d.at[2], largest) << what;
  for (int k = 0; k < 2; ++k) {
    if (d.at[k + 1] < least) continue;
    EXPECT_GT(d.at[k] / d.at[k + 1], 3) << what << ", " << d.at[k] << " to " << d.at[k + 1];
    EXPECT_LT(d.at[k] / d.at[k + 1], 5) << what << ", " << d.at[k] << " to " << d.at[k + 1];
  }
}

// --- Random mechanisms ------------------------------------------------------------------------------------

/// A random mechanism that moves consistently; not `possible` where its drives contradict its loops.
struct Start {
  explicit Start(unsigned seed) : mechanism(random_mechanism(seed, options(seed))), m(mechanism.compiled()) {
    Random random(seed + 500);
    relative::RelativeSystem system(m);
    s.q = mechanism.q;
    s.v = random.values(m.velocities, 1.0);
    for (const BodyData& b : m.bodies) {  // vibrations that these steps follow
      s.q.segment(b.q + b.joint_positions, b.modes) *= 0.1;
      s.v.segment(b.v + b.joint_velocities, b.modes) *= 0.1;
    }
    s.a.setZero(m.velocities);
    s.multipliers.setZero(m.equations);
    const VectorXd free = VectorXd::Ones(m.velocities);
    possible = close_positions(system, 0, free, s.q) < 1e-10 &&
               close_velocities(system, 0, s.q, free, s.v) < 1e-10 && solve_accelerations(system, s);
  }

  static RandomOptions options(unsigned seed) {
    RandomOptions o;
    o.bodies = 2 + static_cast<int>(seed % 4);
    o.loops = static_cast<int>(seed % 3);
    o.flexible_share = seed % 2 == 0 ? 0 : 0.5;
    o.springs = o.damping = o.loads = true;
    o.tyres = seed % 4 == 0;  // light flexible bodies on them move faster than these steps follow
    o.drives = seed % 4 == 3;
    return o;
  }

  RandomMechanism mechanism;
  const Compiled& m;
  State s;
  bool possible = false;
};

/// Positions in relative coordinates after each of `samples` intervals.
MatrixXd trajectory(const Start& start, Formulation formulation, double step, double interval, int samples) {
  const Compiled& m = start.m;
  relative::RelativeSystem relative(m);
  natural::NaturalSystem natural(m);
  const bool is_natural = formulation == Formulation::natural;
  State s = start.s, seen = start.s;
  if (is_natural) {
    relative.begin_step(s.q.data());
    relative.kinematics(0, s.q.data(), s.v.data(), s.a.data());
    s = natural.from_relative(s, relative.workspace().bodies, relative.workspace().origin);
  }
  System& system = is_natural ? static_cast<System&>(natural) : relative;
  EXPECT_TRUE(solve_accelerations(system, s));
  IntegratorOptions options;
  options.step = step;
  options.tolerance = 1e-7;
  options.max_iterations = 60;
  IndexThree integrator(system, options);
  MatrixXd positions = MatrixXd::Constant(m.positions, samples, NAN);
  const int every = static_cast<int>(std::lround(interval / step));
  for (int k = 0; k < every * samples; ++k) {
    if (integrator.step(s).code != StepCode::ok) return positions;
    if ((k + 1) % every != 0) continue;
    if (is_natural)
      natural.to_relative(s, seen);
    else
      seen = s;
    for (const BodyData& b : m.bodies) {  // quaternions of either sign mean the same
      const int quaternion = joint_info(b.joint).quaternion;
      if (quaternion < 0) continue;
      auto turn = seen.q.segment<4>(b.q + quaternion);
      if (turn.dot(start.s.q.segment<4>(b.q + quaternion)) < 0) turn = -turn;
    }
    positions.col(k / every) = seen.q;
  }
  return positions;
}

TEST(Formulations, RandomMechanismsMoveAlike) {
  int compared = 0;
  for (unsigned seed = 1; seed <= 80; ++seed) {
    const Start start(seed);
    if (!start.possible) continue;
    Differences d;
    for (int k = 0; k < 3; ++k) {
      const double step = 5e-4 / (1 << k);
      d.at[k] = (trajectory(start, Formulation::relative, step, 0.005, 10) -
                 trajectory(start, Formulation::natural, step, 0.005, 10))
                    .norm();
    }
    expect_second_order(d, 1e-7, 1e-3, "mechanism " + std::to_string(seed));
    ++compared;
  }
  EXPECT_GE(compared, 50);
}

// --- Examples ---------------------------------------------------------------------------------------------

/// Poses and modal amplitudes of all bodies after each of `samples` intervals.
std::vector<ResultsRow> rows(const std::shared_ptr<const Model>& model, RunOptions options, double step,
                             double interval, int samples) {
  options.step = step;
  options.substeps = 1;
  Simulation s(model, options);
  std::vector<ResultsRow> rows(static_cast<std::size_t>(samples));
  for (ResultsRow& row : rows) {
    for (long k = std::lround(interval / step); k > 0; --k) {
      const StepReport report = s.step();
      EXPECT_TRUE(report.ok()) << s.explain(report);
    }
    s.sample(row);
  }
  return rows;
}

double difference(const ResultsRow& a, const ResultsRow& b) {
  double sum = a.modes.size() > 0 ? (a.modes - b.modes).squaredNorm() : 0;
  for (Eigen::Index k = 0; k < a.poses.cols(); ++k) {
    const double sign = a.poses.col(k).tail<4>().dot(b.poses.col(k).tail<4>()) < 0 ? -1 : 1;
    sum += (a.poses.col(k).head<3>() - b.poses.col(k).head<3>()).squaredNorm() +
           (a.poses.col(k).tail<4>() - sign * b.poses.col(k).tail<4>()).squaredNorm();
  }
  return std::sqrt(sum);
}

/// The largest angular speed between two instants, rad/s.
double fastest_turn(const ResultsRow& a, const ResultsRow& b) {
  double fastest = 0;
  for (Eigen::Index k = 0; k < a.poses.cols(); ++k) {
    const double cosine = std::abs(a.poses.col(k).tail<4>().dot(b.poses.col(k).tail<4>()));
    fastest = std::max(fastest, 2 * std::acos(std::min(cosine, 1.0)) / (b.time - a.time));
  }
  return fastest;
}

TEST(Formulations, ExamplesMoveAlike) {
  int examples = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(std::string(MIMBRE_SOURCE_DIR) + "/examples")) {
    if (entry.path().extension() != ".yaml") continue;
    // Complete models have a simulation section, templates that others include have none.
    std::ifstream file(entry.path());
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    if (text.find("\nsimulation:") == std::string::npos) continue;
    const auto model = with_tight_tolerance(Model::compile(load_model(entry.path().string())));
    Differences d;
    double fastest = 0;
    for (int k = 0; k < 3; ++k) {
      // Fast machines have steps of their own.
      const double step = std::min(1e-3, 8 * model->spec().simulation.step) / (1 << k);
      const auto a = rows(model, in(Formulation::relative), step, 0.02, 10),
                 b = rows(model, in(Formulation::natural), step, 0.02, 10);
      for (std::size_t i = 0; i < a.size(); ++i) d.at[k] = std::hypot(d.at[k], difference(a[i], b[i]));
      for (std::size_t i = 1; i < a.size(); ++i) fastest = std::max(fastest, fastest_turn(a[i - 1], a[i]));
    }
    // What turns by 60 rad/s, as wheels do, is apart in its angle.
    expect_second_order(d, 1e-7, 1e-4 * std::max(1.0, fastest / 5),
                        entry.path().parent_path().filename() / entry.path().filename());
    ++examples;
  }
  EXPECT_GE(examples, 9);
}

TEST(Formulations, AnglesCountTurns) {
  const auto model = model_of(R"(
bodies:
  crank: {mass: 1, com: [0.1, 0, 0], inertia: [0.01, 0.02, 0.02]}
  arm: {mass: 1, com: [0.4, 0, 0], inertia: [0.01, 0.02, 0.02]}
joints:
  crank: {type: revolute, between: [crank, ground], at: [0, 0, 0], axis: [0, 1, 0], drive: {position: "25*t"}}
  arm: {type: cylindrical, between: [crank, arm], at: [0.3, 0, 0], axis: [0, 1, 0], velocity: [-60, 0.5]}
outputs:
  - {name: crank, joint: crank}
  - {name: arm, joint: arm, component: 0}
)");
  double arm[2];
  for (const Formulation formulation : formulations) {
    Simulation s(model, trapezoidal(formulation, 0.001));
    for (int k = 0; k < 2000; ++k) ASSERT_TRUE(s.step().ok());
    ResultsRow row;
    s.sample(row);
    EXPECT_NEAR(row.channels[0], 50, 1e-7);
    arm[formulation == Formulation::natural] = row.channels[1];
  }
  EXPECT_LT(arm[0], -60);  // ten turns and more
  EXPECT_NEAR(arm[1], arm[0], 0.05);
}

/// The model somewhere else. Roads over the distance would have to be moved too.
std::shared_ptr<const Model> shifted(const std::shared_ptr<const Model>& model, const Vec3d& shift) {
  spec::Model m = model->spec();
  for (spec::Frame& f : m.frames)
    if (f.body < 0) f.pose.position += shift;
  for (spec::Body& b : m.bodies) b.pose.position += shift;
  return Model::compile(m);
}

TEST(Formulations, PlaceDoesNotMatterToNaturalCoordinates) {
  const Vec3d far(1e5, -7e4, 300);
  for (const char* file : {"slider-crank/slider-crank.yaml", "pendulum/flexible.yaml",
                           "tutorial/four-bar.yaml", "bricard/mechanism.yaml"}) {
    const auto model = with_tight_tolerance(example(file)), moved = shifted(model, far);
    const auto a = rows(model, in(Formulation::natural), 0.005, 0.05, 10);
    auto b = rows(moved, in(Formulation::natural), 0.005, 0.05, 10);
    for (std::size_t k = 0; k < a.size(); ++k) {
      b[k].poses.topRows<3>().colwise() -= far;
      EXPECT_LT(difference(a[k], b[k]), 1e-9) << file;
    }
  }
}

// --- Energy, constraints, bits ----------------------------------------------------------------------------

/// Nothing moves: nothing to solve for.
TEST(Formulations, BodiesThatCannotMoveStay) {
  const auto model = model_of(R"(
bodies:
  a: {mass: 2, com: [0.1, 0.2, 0.3], inertia: [0.1, 0.2, 0.2]}
  b: {mass: 2, com: [1, 0.2, 0.3], inertia: [0.1, 0.2, 0.2]}
joints:
  a: {type: fixed, between: [ground, a], at: [0, 0, 0]}
  b: {type: fixed, between: [a, b], at: [1, 0, 0]}
  again: {type: fixed, between: [ground, b], at: [0, 1, 0], cut: always}
)");
  for (const Formulation formulation : formulations) {
    Simulation s(model, in(formulation));
    EXPECT_EQ(s.coordinates(), 0);
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(s.step().ok());
  }
}

struct Balance {
  double numerical = 0, kinetic = 0;  ///< largest of the run, in size
};

Balance balance(const std::shared_ptr<const Model>& model, double step, double duration) {
  Simulation s(model, trapezoidal(Formulation::natural, step));
  Balance b;
  for (long k = std::lround(duration / step); k > 0; --k) {
    const StepReport report = s.step();
    EXPECT_TRUE(report.ok()) << s.explain(report);
    EXPECT_LE(report.position_violation, 1e-8);
    EXPECT_LE(report.velocity_violation, 1e-6);
    b.numerical = std::max(b.numerical, std::abs(s.energy().numerical));
    b.kinetic = std::max(b.kinetic, s.energy().kinetic);
  }
  return b;
}

TEST(Formulations, NaturalCoordinatesKeepEnergyAndConstraints) {
  const std::shared_ptr<const Model> models[] = {
      model_of(four_bar_text({{"crank", ", velocity: 6"}})), example("pendulum/flexible.yaml"),
      example("bricard/mechanism.yaml"), example("iltis/suspension.yaml", {{"elements", "4"}})};
  for (const auto& model : models) {
    const Balance coarse = balance(model, 0.004, 0.5), fine = balance(model, 0.002, 0.5);
    EXPECT_LT(fine.numerical, 0.02 * fine.kinetic) << model->spec().title;
    EXPECT_GT(coarse.numerical / fine.numerical, 2.5) << model->spec().title;
  }
}

void expect_same(const Simulation::Snapshot& a, const Simulation::Snapshot& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_TRUE(a.q == b.q && a.v == b.v && a.a == b.a && a.algorithmic == b.algorithmic &&
              a.multipliers == b.multipliers);
}

/// Also over impacts, whose steps are repeated in parts.
TEST(Formulations, NaturalCoordinatesGiveTheSameBits) {
  const auto model = example("iltis/suspension.yaml", {{"elements", "4"}});
  int parts = 1;
  const auto advance = [&](Simulation& s, int steps) {
    for (int k = 0; k < steps; ++k) {
      const StepReport report = s.step();
      ASSERT_TRUE(report.ok()) << s.explain(report);
      parts = std::max(parts, report.substeps);
    }
  };
  Simulation a(model, in(Formulation::natural)), b(model, in(Formulation::natural));
  advance(a, 195);
  advance(b, 195);
  expect_same(a.save(), b.save());
  const Simulation::Snapshot before = a.save();
  advance(a, 40);
  EXPECT_GT(parts, 1);
  const Simulation::Snapshot end = a.save();
  a.restore(before);
  advance(a, 40);
  expect_same(a.save(), end);
  Simulation other(model, in(Formulation::natural));
  advance(other, 7);
  other.restore(before);
  ResultsRow row;
  for (int k = 0; k < 40; ++k) {
    advance(other, 1);
    other.sample(row);
  }
  expect_same(other.save(), end);
}

// --- Statics and reactions --------------------------------------------------------------------------------

TEST(Formulations, FindTheSameEquilibrium) {
  for (const char* file : {"iltis/vehicle.yaml", "iltis/suspension.yaml", "pendulum/flexible.yaml"}) {
    const auto model = example(file);
    const StaticResult a = static_equilibrium(model, in(Formulation::relative)),
                       b = static_equilibrium(model, in(Formulation::natural));
    ASSERT_EQ(a.values.size(), b.values.size());
    for (int k = 0; k < a.output_count; ++k) {
      const auto& name = a.channels[static_cast<std::size_t>(k)].name;
      // Nothing holds the car's heading on the level road but the way to the equilibrium.
      const double tolerance = name == "chassis.yaw" ? 1e-6 : 1e-9 * std::max(1.0, std::abs(a.values[k]));
      EXPECT_NEAR(a.values[k], b.values[k], tolerance) << file << " " << name;
    }
  }
}

/// Reactions of all joints now and after some steps that are short enough for the motions to be the same.
void expect_same_reactions(const std::string& text, const std::vector<std::string>& joints) {
  std::string outputs = "outputs:\n";
  for (const std::string& joint : joints)
    for (const char* component : {"fx", "fy", "fz", "mx", "my", "mz"})
      outputs += "  - {name: " + joint + "." + component + ", joint_force: " + joint +
                 ", component: " + component + "}\n";
  const auto model = with_tight_tolerance(model_of(text + outputs));
  const auto a = rows(model, in(Formulation::relative), 1e-4, 0.01, 2),
             b = rows(model, in(Formulation::natural), 1e-4, 0.01, 2);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto n = static_cast<Eigen::Index>(6 * joints.size());
    const double size = a[i].channels.head(n).cwiseAbs().maxCoeff();
    EXPECT_GT(size, 1);
    for (Eigen::Index k = 0; k < n; ++k)
      EXPECT_NEAR(a[i].channels[k], b[i].channels[k], 1e-6 * size) << joints[static_cast<std::size_t>(k / 6)];
  }
}

TEST(Formulations, AgreeOnTheReactionsOfAFlexibleChain) {
  std::string text = R"(
materials:
  soft: {young: 7e9, poisson: 0.3, density: 2700}
sections:
  bar: {type: rectangle, width: 0.02, height: 0.03}
bodies:
)";
  for (int k = 0; k < 3; ++k) {
    const std::string from = "[" + std::to_string(k) + ", 0, 0]",
                      to = "[" + std::to_string(k + 1) + ", 0, 0]";
    text += "  link" + std::to_string(k) + ":\n    frame: {at: " + from +
            "}\n    flexible:\n      material: soft\n      section: bar\n      nodes: {in: " + from +
            ", out: " + to +
            "}\n      bars:\n        bar: {from: in, to: out, elements: 4}\n      clamped: [in]\n"
            "      static_modes:\n        - {node: out, along: [0, 0, 1], name: z}\n"
            "        - {node: out, along: [0, 1, 0], name: y}\n      dynamic_modes: 1\n";
  }
  text += R"(
joints:
  first: {type: revolute, between: [ground, link0], at: [0, 0, 0], axis: [0, 1, 0], velocity: 1}
  second: {type: universal, between: [link0, link1], at: [1, 0, 0], axis: [0, 1, 0], axis2: [0, 0, 1]}
  third: {type: revolute, between: [link1, link2], at: [2, 0, 0], axis: [0, 0, 1], velocity: -2}
)";
  expect_same_reactions(text, {"first", "second", "third"});
}

/// A loop without redundant equations.
TEST(Formulations, AgreeOnTheReactionsOfALoop) {
  expect_same_reactions(R"(
bodies:
  crank: {mass: 0.5, com: [0, 0, 0.1], inertia: [0.002, 0.002, 0.0001]}
  coupler: {mass: 0.8, com: [0.3, 0, 0.35], inertia: [0.01, 0.05, 0.04]}
  rocker: {mass: 1, com: [0.6, 0.1, 0.25], inertia: [0.02, 0.02, 0.0005]}
joints:
  crank: {type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 1, 0], velocity: 5}
  crank_pin: {type: universal, between: [crank, coupler], at: [0, 0, 0.2], axis: [0, 1, 0], axis2: [0, 0, 1]}
  rocker: {type: revolute, between: [ground, rocker], at: [0.6, 0, 0], axis: [0, 1, 0]}
  rocker_pin: {type: spherical, between: [coupler, rocker], at: [0.6, 0, 0.5]}
)",
                        {"crank", "crank_pin", "rocker", "rocker_pin"});
}

// --- Structures of points and vectors ---------------------------------------------------------------------

/// A rod between two bodies whose joint points are combinations of points on other bodies: its length is its
/// own affair, although the other two bodies hold all the points.
TEST(Formulations, ARodBetweenCrowdedBodiesKeepsItsLength) {
  std::string bodies = "bodies:\n", joints = "joints:\n";
  const auto body = [&](const std::string& name) {
    bodies += "  " + name + ": {mass: 1, com: [0.1, 0.2, 0.3], inertia: [0.1, 0.1, 0.1]}\n";
  };
  const auto ball = [&](const std::string& name, const std::string& on, const std::string& with,
                        const std::string& at, const char* cut = "never") {
    joints += "  " + name + ": {type: spherical, between: [" + on + ", " + with + "], at: " + at +
              ", cut: " + cut + "}\n";
  };
  body("base");
  joints += "  base: {type: floating, between: [ground, base], at: [0, 0, 0]}\n";
  const char* corners[] = {"[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]", "[-0.1, 0, 0]"};
  for (int k = 0; k < 4; ++k) {
    body("ball" + std::to_string(k));
    ball("corner" + std::to_string(k), "base", "ball" + std::to_string(k), corners[k]);
  }
  body("arm");
  ball("arm", "base", "arm", "[0.7, 0.1, 0.3]");
  const char* tips[] = {"[1.6, 0, 0]", "[0.6, 1, 0]", "[0.6, 0, 1]"};
  for (int k = 0; k < 3; ++k) {
    body("tip" + std::to_string(k));
    ball("end" + std::to_string(k), "arm", "tip" + std::to_string(k), tips[k]);
  }
  body("rod");
  ball("near", "base", "rod", "[0.2, 0.9, 0.1]");
  ball("far", "arm", "rod", "[1.2, 0.9, 0.3]", "always");
  const auto model = model_of(bodies + joints);
  Simulation a(model, in(Formulation::relative)), b(model, in(Formulation::natural));
  EXPECT_EQ(a.degrees_of_freedom(), 30);
  EXPECT_EQ(b.degrees_of_freedom(), 30);
}

/// Bodies of the same mechanism with everything that sharing can meet: joint points that coincide, exactly or
/// up to round-off, a body between ground and ground, massless pieces, several joints on one axis, a joint
/// within one body.
TEST(Formulations, UnusualStructuresMoveAlike) {
  const auto model = with_tight_tolerance(model_of(R"(
bodies:
  still: {mass: 1, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}
  hub: {mass: 2, com: [0.02, 0, 0.1], inertia: [0.05, 0.06, 0.07]}
  cross: {mass: 0, com: [0.3, 0, 0], inertia: [0, 0, 0]}
  door: {mass: 1.5, com: [0.5, 0.2, 0.1], inertia: [0.03, 0.04, 0.05]}
  speck: {mass: 1e-3, com: [0.3, 0, 0.001], inertia: [1e-6, 2e-6, 2e-6]}
  twin: {mass: 0.7, com: [0.3, 0.1, 0.1], inertia: [0.02, 0.02, 0.03]}
  slide: {mass: 0.4, com: [0, 0.3, 0], inertia: [0.01, 0.01, 0.01]}
  wheel: {mass: 0.4, com: [0, 0.5, 0], inertia: [0.01, 0.02, 0.01]}
joints:
  welded: {type: fixed, between: [ground, still], at: [0, 0, 0]}
  base: {type: revolute, between: [hub, still], at: [0, 0, 0], axis: [0, 0.6, 0.8], velocity: 2}
  bearing: {type: revolute, between: [ground, hub], at: [0, 0.3, 0.4], axis: [0, 0.6, 0.8], cut: always}
  fork: {type: revolute, between: [hub, cross], at: [0.3, 0, 0], axis: [0, 1, 0]}
  pin: {type: revolute, between: [door, cross], at: [0.3, 0, 0], axis: [0, 0, 1], velocity: 3}
  same: {type: spherical, between: [hub, twin], at: [0.3, 0, 0], velocity: [0, 1, 0]}
  grain: {type: universal, between: [twin, speck], at: [0.30000000000000004, 1e-16, 0], axis: [0, 1, 0], axis2: [0, 0, 1]}
  rail: {type: prismatic, between: [hub, slide], at: [0, 0.3, 0], axis: [0, 1, 0], spring: {stiffness: 50, damping: 1}}
  axle: {type: cylindrical, between: [wheel, slide], at: [0, 0.5, 0], axis: [0, 1, 0], velocity: [9, 0.1]}
)"));
  for (const Formulation formulation : formulations) {
    Simulation s(model, in(formulation));
    // The second bearing takes nothing away.
    EXPECT_EQ(s.degrees_of_freedom(), 11) << (formulation == Formulation::natural ? "natural" : "relative");
  }
  Differences d;
  for (int k = 0; k < 3; ++k) {
    const double step = 1e-3 / (1 << k);
    const auto a = rows(model, in(Formulation::relative), step, 0.02, 10),
               b = rows(model, in(Formulation::natural), step, 0.02, 10);
    for (std::size_t i = 0; i < a.size(); ++i) d.at[k] = std::hypot(d.at[k], difference(a[i], b[i]));
  }
  expect_second_order(d, 1e-7, 1e-3, "unusual structures");
}

/// Long chains do not wear out: every link shares its points with the next.
TEST(Formulations, ALongChainMovesAlike) {
  std::string bodies = "bodies:\n", joints = "joints:\n", before = "ground";
  for (int k = 0; k < 60; ++k) {
    const std::string name = "link" + std::to_string(k), x = std::to_string(0.1 * k);
    bodies += "  " + name + ": {mass: 0.1, com: [" + std::to_string(0.1 * k + 0.05) +
              ", 0, 0], inertia: [1e-5, 1e-4, 1e-4]}\n";
    const char* kinds[] = {"revolute, axis: [0, 1, 0]", "fixed", "revolute, axis: [0, 0, 1]",
                           "universal, axis: [0, 1, 0], axis2: [0, 0, 1]"};
    joints += "  j" + std::to_string(k) + ": {type: " + kinds[k % 4] + ", between: [" + before + ", " + name +
              "], at: [" + x + ", 0, 0]}\n";
    before = name;
  }
  const auto model = with_tight_tolerance(model_of(bodies + joints));
  Differences d;
  for (int k = 0; k < 3; ++k) {
    const double step = 2e-3 / (1 << k);
    const auto a = rows(model, in(Formulation::relative), step, 0.02, 5),
               b = rows(model, in(Formulation::natural), step, 0.02, 5);
    for (std::size_t i = 0; i < a.size(); ++i) d.at[k] = std::hypot(d.at[k], difference(a[i], b[i]));
  }
  expect_second_order(d, 1e-7, 1e-2, "chain");
}

/// A chain of flexible bars, each hinged to the one before.
std::string chain_of_bars(int bars) {
  std::string bodies =
      "materials: {m: {young: 2e11, poisson: 0.3, density: 7800}}\nsections: {r: {type: round, diameter: "
      "0.02}}\nbodies:\n";
  std::string joints = "joints:\n";
  for (int k = 0; k < bars; ++k) {
    const std::string i = std::to_string(k), j = std::to_string(k + 1);
    bodies += "  b" + i + ": {frame: {at: [" + i +
              ", 0, 0]}, flexible: {material: m, section: r, nodes: {a: [" + i + ", 0, 0], c: [" + j +
              ", 0, 0]}, bars: {bar: {from: a, to: c, elements: 2}}, clamped: [a], static_modes: [{node: c, "
              "all: true}], dynamic_modes: 2}}\n";
    joints += "  j" + i + ": {type: revolute, between: [" +
              (k == 0 ? "ground, b0], at: [0, 0, 0]" : "b" + std::to_string(k - 1) + ".c, b" + i + ".a]") +
              ", axis: [0, 1, 0]}\n";
  }
  return bodies + joints;
}

/// Where relative coordinates are far slower the run says so: not of a chain alone, but of one whose ends a
/// spring couples.
TEST(Formulations, TheSlowOneIsAdvisedAgainst) {
  const auto advice_on = [](const std::string& text, Formulation formulation) {
    return explain_slow_formulation(Simulation(model_of(text), in(formulation)));
  };
  EXPECT_EQ(advice_on(chain_of_bars(80), Formulation::relative), "");
  const auto advice = [&](int bars, Formulation formulation) {
    const std::string last = std::to_string(bars - 1), end = std::to_string(bars);
    return advice_on(chain_of_bars(bars) + "springs: {long: {between: [b0, b" + last +
                         "], at: [[1, 0, 0], [" + end + ", 0, 0]], elastic: {stiffness: 1}}}\n",
                     formulation);
  };
  EXPECT_EQ(advice(30, Formulation::relative), "");
  EXPECT_THAT(advice(80, Formulation::relative),
              testing::HasSubstr("; --formalism transfer_matrices or --formulation natural"));
  EXPECT_EQ(advice(80, Formulation::natural), "");
}

// --- Singular positions -----------------------------------------------------------------------------------

TEST(Formulations, DoubleFourBarInNaturalCoordinates) {
  const double exact = -15.08355716;  // of rigid bars, see the integrator's tests
  for (int flexible = 0; flexible <= 5; ++flexible) {
    const auto model =
        example("double-four-bar/mechanism.yaml", {{"flexible_bars", std::to_string(flexible)}});
    for (const bool damped : {false, true}) {
      RunOptions options = trapezoidal(Formulation::natural, 0.01);
      if (damped) options.integrator = spec::Simulation::Integrator::generalized_alpha;
      if (damped) options.xi.reset();
      Simulation s(model, options);
      double fed = 0;
      for (int k = 0; k < 500; ++k) {
        const StepReport report = s.step();
        ASSERT_TRUE(report.ok()) << flexible << " " << s.explain(report);
        EXPECT_LE(report.position_violation, 1e-8);
        EXPECT_LE(report.velocity_violation, 1e-6);
        fed = std::max(fed, std::abs(s.energy().numerical));
      }
      ResultsRow row;
      s.sample(row);
      // Of the second order of the step, with larger factors than in relative coordinates.
      EXPECT_NEAR(row.channels[0], exact, damped ? 0.12 : 0.05) << flexible;
      EXPECT_LT(fed, damped ? 0.3 : 0.2) << flexible;  // of 90 J
    }
  }
}

}  // namespace
}  // namespace mimbre::test::formulations_test
