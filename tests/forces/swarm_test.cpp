#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "dynamics/natural/system.h"
#include "mimbre/diagnostics.h"
#include "simulation/start/start.h"
#include "simulation/step/mechanism.h"
#include "support/dense.h"
#include "support/models.h"
#include "support/simulate.h"

/// Spheres of which only those near each other are looked at, against the same ones pair by pair.
namespace mimbre::test::swarm_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

struct Options {
  int side = 3, layers = 3;
  bool swarm = true, box = true, among = true;
  double gravity = -9.81, restitution = 0.3, pitch = 0.0215, step = 2e-4;
  std::string more{};
};

/// Balls of 10 g and 1 cm, a little off a lattice, in a box.
std::string balls(const Options& o) {
  std::string bodies, joints, spheres;
  for (int k = 0; k < o.layers; ++k)
    for (int j = 0; j < o.side; ++j)
      for (int i = 0; i < o.side; ++i) {
        const std::string name = fmt::format("b{}{}{}", i, j, k);
        const double off = 4e-4;
        bodies +=
            fmt::format("  {}: {{mass: 0.01, com: [{:.9f}, {:.9f}, {:.9f}], inertia: [4e-7, 4e-7, 4e-7]}}\n",
                        name, o.pitch * (i + 0.6) + off * std::sin(13 * i + 78 * j + 37 * k),
                        o.pitch * (j + 0.6) + off * std::sin(91 * i + 17 * j + 53 * k), o.pitch * (k + 0.6));
        joints += fmt::format(
            "  f{0}: {{type: floating, between: [ground, {0}], velocity: [{1}, 0, 0, 0]}}\n", name,
            o.gravity == 0 ? fmt::format("{:.4f}, {:.4f}, {:.4f}", 0.5 * std::sin(5 * i + 3 * j + k),
                                         0.5 * std::sin(i + 7 * j + 2 * k), 0.5 * std::sin(i + j + 9 * k))
                           : std::string("0, 0, 0"));
        spheres += fmt::format("      - {{on: {}, radius: 0.01}}\n", name);
      }
  const double side = o.pitch * (o.side + 0.2);
  return fmt::format(R"y(
gravity: [0, 0, {}]
bodies:
{}joints:
{}surfaces:
  floor: {{type: half_space}}
  left: {{type: half_space, z: [1, 0, 0]}}
  right: {{type: half_space, at: [{side}, 0, 0], z: [-1, 0, 0]}}
  front: {{type: half_space, z: [0, 1, 0]}}
  back: {{type: half_space, at: [0, {side}, 0], z: [0, -1, 0]}}
contacts:
  balls:
    spheres:
{}    {}
    {}
    stiffness: 2e4
    restitution: {}
    friction: 0.3
{}
outputs:
  - {{name: px, linear_momentum: all, component: x}}
  - {{name: py, linear_momentum: all, component: y}}
  - {{name: pz, linear_momentum: all, component: z}}
  - {{name: lx, angular_momentum: all, component: x, about: [0, 0, 0]}}
  - {{name: ly, angular_momentum: all, component: y, about: [0, 0, 0]}}
  - {{name: lz, angular_momentum: all, component: z, about: [0, 0, 0]}}
  - {{name: height, centre_of_mass: all, component: z}}
simulation: {{step: {}, end: 1, substeps: 1}}
)y",
                     o.gravity, bodies, joints, spheres,
                     o.box ? "surfaces: [floor, left, right, front, back]" : "",
                     fmt::format("among: {}{}", o.among, o.swarm ? "\n    swarm: true" : ""), o.restitution,
                     o.more, o.step, fmt::arg("side", side));
}

Simulation with_energies(const std::string& text, Formulation formulation) {
  RunOptions options;
  options.formulation = formulation;
  options.energies = true;
  return Simulation(model_of(text), options);
}

/// The largest entry between the unknowns of two balls; each has as many.
double coupled(const Eigen::MatrixXd& matrix) {
  const Eigen::Index size = matrix.rows() / 8;
  double largest = 0;
  for (Eigen::Index k = 0; k < 8; ++k)
    for (Eigen::Index l = 0; l < k; ++l)
      largest = std::max(largest, matrix.block(k * size, l * size, size, size).cwiseAbs().maxCoeff());
  return largest;
}

class Swarm : public testing::TestWithParam<Formulation> {};

/// What each body feels of the other stands beside the matrix; together they are that of all pairs.
TEST_P(Swarm, ItsMatrixIsThatOfAllPairs) {
  for (const char* more : {"", "    rolling: 1e-3\n    spinning: 1e-3\n"}) {
    const Options close{.side = 2, .layers = 2, .pitch = 0.0198, .more = more};
    Options pairs = close;
    pairs.swarm = false;
    RunOptions options;
    options.formulation = GetParam();
    Eigen::MatrixXd made[2];
    Eigen::VectorXd solved[2], right;
    int k = 0;
    for (const Options& o : {close, pairs}) {
      const auto model = model_of(balls(o));
      Mechanism mechanism(model->compiled(), resolve_method(model->compiled().spec().simulation, options));
      start(mechanism, resolve_method(model->compiled().spec().simulation, options), {}, false);
      System& system = mechanism.system;
      const State& s = mechanism.state;
      const int n = system.velocities();
      mechanism.enter(2e-4);
      Eigen::VectorXd r(n);
      system.residual(0, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
      const MatrixWeights weights{1e-4, 1e-8, 1e9};
      made[k].resize(n, n);
      system.dense_matrix(s.q.data(), weights, made[k].data());
      if (right.size() == 0) right = Eigen::VectorXd::LinSpaced(n, -1, 1).cwiseAbs2() * 0.7;
      solved[k] = right;
      ASSERT_TRUE(system.factor(s.q.data(), weights).ok());
      system.solve(solved[k].data());
      ++k;
    }
    // The pairs are in it: without them no two balls are coupled.
    ASSERT_GT(coupled(made[1]), 0);
    EXPECT_LT((made[0] - made[1]).cwiseAbs().maxCoeff(), 1e-10 * made[1].cwiseAbs().maxCoeff());
    EXPECT_LT((solved[0] - solved[1]).norm(), 1e-5 * solved[1].norm());
    EXPECT_LT((made[0] - made[0].transpose()).cwiseAbs().maxCoeff(), 1e-10 * made[1].cwiseAbs().maxCoeff());
  }
}

/// π √(0.01 kg/(2 · 2e4 N/m)) = 1.571 ms.
TEST_P(Swarm, IsWarnedOfStepsThatItsImpactsAreTooShortFor) {
  const auto said = [](const Options& o) {
    const Simulation s = with_energies(balls(o), GetParam());
    const std::vector<std::string> all = s.warnings();
    return all.empty() ? std::string() : all.front();
  };
  EXPECT_THAT(said({.step = 5e-4}),
              AllOf(HasSubstr("contact 'balls': an impact of its lightest spheres takes 0.00157 s"),
                    HasSubstr("the step 0.0005 s"), HasSubstr("take steps of 0.00016 s")));
  EXPECT_EQ(said({.step = 3.9e-4}), "");
  EXPECT_EQ(said({.swarm = false, .step = 5e-4}), "");
  EXPECT_EQ(said({.step = 5e-4, .more = "    exponent: 1.5"}), "");  // its impacts depend on their speed
}

TEST_P(Swarm, MovesAsAllPairsDo) {
  Options o;
  Simulation swarm = with_energies(balls(o), GetParam());
  o.swarm = false;
  Simulation pairs = with_energies(balls(o), GetParam());
  for (const double end : {0.02, 0.04, 0.06, 0.3}) {
    run_to(swarm, end);
    run_to(pairs, end);
    // Later impacts take small differences apart.
    const double tolerance = end < 0.1 ? 1e-6 : 1e-3;
    EXPECT_NEAR(channel(swarm, "height"), channel(pairs, "height"), tolerance * 0.03) << end;
    EXPECT_NEAR(swarm.energy().total(), pairs.energy().total(), tolerance * 0.05) << end;
    if (end < 0.1) {
      EXPECT_EQ(channel(swarm, "contact.balls.count"), channel(pairs, "contact.balls.count")) << end;
      EXPECT_NEAR(channel(swarm, "contact.balls.normal"), channel(pairs, "contact.balls.normal"), 1e-2)
          << end;
    }
  }
}

/// Of two balls that collide off-centre, and a light one far away, each of the latter on an arm of its body.
TEST_P(Swarm, SettlesAsAllPairsDo) {
  const auto collide = [](bool swarm) {
    Simulation s = simulation_of(fmt::format(R"y(
gravity: [0, 0, 0]
bodies:
  a: {{mass: 1, com: [0, 0, 0], inertia: [0.001, 0.001, 0.001]}}
  b: {{mass: 1, com: [0.105, 0, 0.02], inertia: [0.001, 0.001, 0.001]}}
  c: {{mass: 0.1, com: [5, 0, 0], inertia: [1e-4, 1e-4, 1e-4]}}
joints: {{ja: {{type: floating, between: [ground, a], at: [0, 0, 0], velocity: [1, 0, 0, 0, 5, 3]}}}}
contacts:
  balls:
    spheres: [{{on: a, radius: 0.05}}, {{on: b, radius: 0.05}}, {{on: c, at: [5, 0, 0.05], radius: 0.002}}]
    among: true
    swarm: {}
    stiffness: 1e5
    restitution: 0.6
    friction: 0.4
outputs: [{{name: vy, velocity: b, component: y}}, {{name: vz, velocity: b, component: z}},
  {{name: wy, angular_velocity: b, component: y}}, {{name: wz, angular_velocity: b, component: z}}]
simulation: {{step: 2e-5, end: 0.02, substeps: 1}}
)y",
                                             swarm),
                                 GetParam());
    run_to(s, 0.02);
    return std::array{channel(s, "vy"), channel(s, "vz"), channel(s, "wy"), channel(s, "wz")};
  };
  const auto one = collide(true), other = collide(false);
  for (std::size_t k = 0; k < one.size(); ++k) {
    EXPECT_GT(std::abs(other[k]), 1e-4) << k;
    EXPECT_NEAR(one[k], other[k], 1e-7 * std::abs(other[k])) << k;
  }
}

/// Without anything else momentum stays and energy is never made, whoever meets whom.
TEST_P(Swarm, MomentumStaysAndEnergyIsNotMade) {
  Simulation s = with_energies(balls({.side = 4, .layers = 4, .box = false, .gravity = 0}), GetParam());
  double before[6];
  const char* names[] = {"px", "py", "pz", "lx", "ly", "lz"};
  for (int k = 0; k < 6; ++k) before[k] = channel(s, names[k]);
  const double energy = s.energy().total();
  int met = 0;
  for (int k = 0; k < 250; ++k) {
    ASSERT_TRUE(s.step().ok());
    met = std::max(met, static_cast<int>(channel(s, "contact.balls.count")));
    EXPECT_LT(s.energy().total(), energy * (1 + 1e-3));
  }
  EXPECT_GT(met, 5);
  EXPECT_LT(s.energy().total(), 0.95 * energy);
  for (int k = 0; k < 6; ++k)
    EXPECT_NEAR(channel(s, names[k]), before[k], (k < 3 ? 1e-8 : 1e-5) * 0.64 * 0.5) << names[k];
}

TEST_P(Swarm, ItsPairsAreInTheState) {
  const std::string model = balls({});
  Simulation a = with_energies(model, GetParam()), b = with_energies(model, GetParam());
  run_to(a, 0.05);
  b.restore(Simulation::Snapshot::from_bytes(a.save().bytes()));
  ResultsRow one, other;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(a.step().ok());
    ASSERT_TRUE(b.step().ok());
    a.sample(one);
    b.sample(other);
    ASSERT_EQ(one.time, other.time);
    ASSERT_TRUE(one.channels == other.channels) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(Both, Swarm, testing::Values(Formulation::relative, Formulation::natural));

TEST(SwarmErrors, NameWhatIsWrong) {
  const auto said = [](const Options& o) {
    try {
      model_of(balls(o));
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(said({}), "accepted");
  EXPECT_THAT(said({.among = false}), HasSubstr("among: true, too"));
  try {
    simulation_of("initial: equilibrium\n" + balls({}), Formulation::relative);
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("no equilibrium can be looked for"), HasSubstr("--save-state"),
                                    HasSubstr("leave out 'swarm: true'")));
  }
  EXPECT_THAT(said({.side = 9, .layers = 3, .swarm = false}), HasSubstr("let them be a swarm"));
}

}  // namespace
}  // namespace mimbre::test::swarm_test
