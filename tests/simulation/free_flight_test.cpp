#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "dynamics/natural/system.h"
#include "dynamics/relative/momentum.h"
#include "dynamics/relative/system.h"
#include "mimbre/diagnostics.h"
#include "mimbre/simulation.h"
#include "support/models.h"
#include "support/random_mechanism.h"

/// What flies freely keeps its momentum, its angular momentum and the path of its centre of mass, in both
/// formulations and whatever the rule; with the integrator `conserve` also its energy.
namespace mimbre::test::free_flight_test {
namespace {

using Formulation = spec::Simulation::Formulation;
using Integrator = spec::Simulation::Integrator;

struct Way {
  Formulation formulation;
  Integrator integrator;
};
constexpr std::array<Way, 4> ways{{{Formulation::relative, Integrator::generalized_alpha},
                                   {Formulation::natural, Integrator::generalized_alpha},
                                   {Formulation::relative, Integrator::conserve},
                                   {Formulation::natural, Integrator::conserve}}};

RunOptions options(const Way& way, double step) {
  RunOptions o;
  o.step = step;
  o.formulation = way.formulation;
  o.integrator = way.integrator;
  return o;
}

std::string name(const Way& way) {
  return std::string(way.formulation == Formulation::relative ? "relative" : "natural") +
         (way.integrator == Integrator::conserve ? ", conserve" : ", default");
}

void advance(Simulation& simulation, double until) {
  while (simulation.time() < until - 0.5 * simulation.step_size()) ASSERT_TRUE(simulation.step().ok());
}

struct Totals {
  double mass = 0;
  Vec3d centre = Vec3d::Zero(), linear = Vec3d::Zero(), angular = Vec3d::Zero();
};

/// Momenta by inverse dynamics: what the root's floating joint, along global axes at the ground, would have
/// to exert if the velocities were accelerations; and for the centre of mass, if the whole were accelerated.
/// Not by the formulas under test.
class Balance {
 public:
  explicit Balance(const Model& model)
      : model_(weightless(model)), system_(model_->compiled()), natural_(model_->compiled()) {}

  Totals of(const Simulation& simulation) {
    const Compiled& m = model_->compiled();
    const BodyData& root = m.bodies.front();
    const int n = m.velocities;
    const State s = relative_state(simulation);
    const VectorXd zero = VectorXd::Zero(n), none = VectorXd::Zero(m.equations);
    system_.begin_step(s.q.data());
    const auto force = [&](const VectorXd& acceleration) {
      VectorXd r(n);
      system_.residual(s.time, s.q.data(), zero.data(), acceleration.data(), none.data(), 0, r.data());
      return VectorXd(r.segment(root.v, 6));
    };
    const VectorXd still = force(zero), p = force(s.v) - still;
    const Mat3d turn = rotation_matrix<double>(s.q.segment<4>(root.q + 3));
    Totals t;
    t.linear = p.head<3>();
    Mat3d moments;  // columns m d × e_k, d from the joint to the centre
    for (int k = 0; k < 3; ++k) {
      const VectorXd f = force(VectorXd::Unit(n, root.v + k)) - still;
      t.mass = f[k];
      moments.col(k) = turn * f.tail<3>();
    }
    const Vec3d d = Vec3d(moments(2, 1), moments(0, 2), moments(1, 0)) / t.mass;
    t.centre = s.q.segment<3>(root.q) + d;
    t.angular = turn * p.tail<3>() - d.cross(t.linear);
    return t;
  }

 private:
  static std::shared_ptr<const Model> weightless(const Model& model) {
    spec::Model s = model.spec();
    s.gravity.setZero();
    return Model::compile(s);
  }
  State relative_state(const Simulation& simulation) {
    const Simulation::Snapshot c = simulation.save();
    State s;
    s.time = c.time;
    s.q = c.q;
    s.v = c.v;
    s.a = c.a;
    s.multipliers = c.multipliers;
    if (simulation.method().formulation == Formulation::relative) return s;
    State out;
    const Compiled& m = model_->compiled();
    out.q.setZero(m.positions);
    out.v.setZero(m.velocities);
    out.a.setZero(m.velocities);
    out.multipliers.setZero(m.equations);
    natural_.to_relative(s, out);
    return out;
  }

  std::shared_ptr<const Model> model_;
  relative::RelativeSystem system_;
  natural::NaturalSystem natural_;
};

void expect_laws(Balance& balance, const Simulation& simulation, const Totals& start, double duration,
                 const std::string& what) {
  const Vec3d g = simulation.model().spec().gravity;
  const Totals now = balance.of(simulation);
  const double p = start.mass * (1 + g.norm() * duration);
  EXPECT_LT((now.linear - start.linear - start.mass * duration * g).norm(), 1e-10 * p) << what;
  EXPECT_LT((now.angular - start.angular).norm(), 1e-10 * p) << what;
  const Vec3d path = start.centre + duration * (start.linear / start.mass + 0.5 * duration * g);
  EXPECT_LT((now.centre - path).norm(), 1e-9 * (1 + duration)) << what;
}

// --- Random mechanisms ------------------------------------------------------------------------------------

/// All that a random mechanism ties to the ground is tied to a body that flies.
spec::Model flying(const spec::Model& model) {
  spec::Model m = model;
  const int carrier = static_cast<int>(m.bodies.size());
  for (spec::Frame& f : m.frames)
    if (f.body < 0) f.body = carrier;
  spec::Body body;
  body.name = "carrier";
  body.mass = 2;
  body.com = {0.1, -0.2, 0.05};
  body.inertia = Vec3d(0.3, 0.4, 0.5).asDiagonal();
  m.bodies.push_back(body);
  spec::Joint joint;
  joint.name = "fly";
  joint.type = spec::JointType::floating;
  joint.cut = spec::Joint::Cut::never;
  for (const int at : {spec::ground, carrier}) {
    spec::Frame f;
    f.name = at == carrier ? "carried" : "from";
    f.body = at;
    m.frames.push_back(f);
  }
  joint.frame_a = static_cast<int>(m.frames.size()) - 2;
  joint.frame_b = static_cast<int>(m.frames.size()) - 1;
  for (const double x : {0.3, -0.2, 0.4, 1.0, 0.5, 2.0}) joint.initial_velocity.push_back(x);
  m.joints.push_back(joint);
  m.simulation.tolerance = 1e-6;
  return m;
}

TEST(FreeFlight, RandomMechanismsKeepTheirMomentum) {
  int flown = 0, loops = 0, flexible = 0;
  for (unsigned seed = 0; seed < 16; ++seed) {
    RandomOptions o;
    o.bodies = 2 + static_cast<int>(seed % 3);
    o.loops = static_cast<int>(seed % 2);
    o.flexible_share = seed % 3 == 0 ? 0 : 0.5;
    o.springs = true;
    o.damping = seed % 4 == 1;
    o.drives = seed % 4 == 2;
    o.floating = false;
    const auto model = Model::compile(flying(random_mechanism(seed, o).model->spec()));
    bool made = true;
    for (const Way& way : ways) {
      std::unique_ptr<Simulation> simulation;
      try {
        simulation = std::make_unique<Simulation>(model, options(way, 0.002));
      } catch (const InputError&) {
        made = false;  // loops that do not close from here
        break;
      }
      Balance balance(*model);
      const Totals start = balance.of(*simulation);
      for (int k = 0; k < 100 && made; ++k) made = simulation->step().ok();
      if (!made) break;
      expect_laws(balance, *simulation, start, simulation->time(), name(way) + " " + std::to_string(seed));
    }
    if (!made) continue;
    ++flown;
    loops += static_cast<int>(model->compiled().loops.size());
    flexible += model->elastic_coordinates() > 0;
  }
  EXPECT_GE(flown, 8);
  EXPECT_GE(loops, 2);
  EXPECT_GE(flexible, 4);
}

/// What centrifugal forces take from the energy of rotation, against differences of it at constant momentum.
TEST(FreeFlight, PowerOfTheChangeOfShape) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    RandomOptions o;
    o.bodies = 4;
    o.flexible_share = 0.5;
    o.floating = false;
    const RandomMechanism mechanism = random_mechanism(seed, o);
    const Compiled& m = mechanism.compiled();
    relative::RelativeSystem system(m);
    system.begin_step(mechanism.q.data());
    std::vector<int> bodies;
    for (std::size_t k = 0; k < m.bodies.size(); ++k) bodies.push_back(static_cast<int>(k));
    Random random(seed + 5);
    const VectorXd v = random_increment(m, random, 0.5), rest = VectorXd::Zero(m.velocities);
    const auto at = [&](double t) {
      VectorXd q(m.positions);
      system.retract(mechanism.q.data(), VectorXd(t * v).data(), q.data());
      system.kinematics(0, q.data(), v.data(), rest.data());
      return relative::momentum<double>(m, system.workspace(), bodies, q.data(), v.data());
    };
    const relative::Momentum now = at(0);
    const Vec3d other(0.3, -0.2, 0.5);
    const auto rotation = [&](double t, const Vec3d& angular) {
      return 0.5 * angular.dot(relative::mean_spin(at(t).inertia, angular));
    };
    const double h = 1e-5;
    const double own = (rotation(h, now.angular) - rotation(-h, now.angular)) / (2 * h);
    EXPECT_NEAR(relative::centrifugal_power(now, now.angular), own, 1e-6 * (1 + std::abs(own))) << seed;
    // As seen by who turns with what is added to the motion to give it `other`.
    const Vec3d added = relative::mean_spin<double>(now.inertia, other - now.angular);
    const double with_added = (rotation(h, rotation_exp<double>(Vec3d(-h * added)) * other) -
                               rotation(-h, rotation_exp<double>(Vec3d(h * added)) * other)) /
                              (2 * h);
    EXPECT_NEAR(relative::centrifugal_power(now, other), with_added, 1e-6 * (1 + std::abs(with_added)))
        << seed;
  }
}

// --- One body ---------------------------------------------------------------------------------------------

std::string tumbling(const std::string& between = "[ground, b]") {
  return R"(
gravity: [0, 0, -1.5]
bodies:
  b: {mass: 5, com: [0.2, -0.1, 0.3], inertia: [1, 2, 3]}
joints:
  fly: {type: floating, between: )" +
         between + R"(, at: [0, 0, 0], velocity: [1, 0.3, -0.2, 1, 0.5, 2]}
simulation: {step: 0.01, end: 10, tolerance: 1e-9}
)";
}

/// Attitude by Euler's equations, q̇ = ½ q ω, in steps that leave nothing of their error.
Eigen::Quaterniond attitude(const Vec3d& inertia, const Vec3d& omega, double until) {
  using Vec7 = Eigen::Matrix<double, 7, 1>;
  Vec7 x;
  x << 1, 0, 0, 0, omega;
  const auto rate = [&](const Vec7& y) {
    const Eigen::Quaterniond q(y[0], y[1], y[2], y[3]);
    const Vec3d w = y.tail<3>();
    const Eigen::Quaterniond qd = q * Eigen::Quaterniond(0, w[0], w[1], w[2]);
    const Vec3d l = inertia.cwiseProduct(w);
    Vec7 out;
    out << 0.5 * qd.w(), 0.5 * qd.vec(), l.cross(w).cwiseQuotient(inertia);
    return out;
  };
  const int steps = 20000;
  const double h = until / steps;
  for (int k = 0; k < steps; ++k) {
    const Vec7 a = rate(x), b = rate(x + 0.5 * h * a), c = rate(x + 0.5 * h * b), d = rate(x + h * c);
    x += h / 6 * (a + 2 * b + 2 * c + d);
  }
  return Eigen::Quaterniond(x[0], x[1], x[2], x[3]).normalized();
}

/// The body's own turn: the joint's quaternion, inverted where the body carries frame a.
Eigen::Quaterniond turn_of(const Simulation& s) {
  const Simulation::Snapshot c = s.save();
  const Eigen::Index at = s.method().formulation == Formulation::relative ? 3 : c.v.size() + 3;
  return {c.q[at], c.q[at + 1], c.q[at + 2], c.q[at + 3]};
}

TEST(FreeFlight, TumblingBodyFollowsEulersEquationsToSecondOrder) {
  const auto model = model_of(tumbling());
  const Eigen::Quaterniond exact = attitude({1, 2, 3}, {1, 0.5, 2}, 5);
  for (const Way& way : ways) {
    std::array<double, 2> error{};
    for (int k = 0; k < 2; ++k) {
      Simulation s(model, options(way, 0.01 / (1 + k)));
      const double energy = s.energy().total();
      advance(s, 5);
      error[static_cast<std::size_t>(k)] = turn_of(s).angularDistance(exact);
      EXPECT_NEAR(s.energy().total(), energy, 1e-10) << name(way);
    }
    EXPECT_LT(error[1], 1e-3) << name(way);
    EXPECT_NEAR(error[0] / error[1], 4, 0.5) << name(way);
  }
}

TEST(FreeFlight, TheSameWhicheverWayTheJointIsWritten) {
  // Frame a on the body: coordinates are those of the ground as the body sees it.
  const auto model = model_of(R"(
gravity: [0.3, 0, -1.5]
bodies:
  b: {mass: 5, com: [0.2, -0.1, 0.3], inertia: [1, 2, 3]}
  c: {mass: 1, com: [1, 0, 0], inertia: [0.1, 0.2, 0.15]}
joints:
  fly: {type: floating, between: [b, ground], at: [0.1, 0, 0], velocity: [1, 0.3, -0.2, 1, 0.5, 2]}
  pin: {type: revolute, between: [b, c], at: [0.5, 0, 0], axis: [0, 1, 0], velocity: 3}
frames:
  far: {body: c, at: [1, 0.2, 0]}
outputs:
  - {name: x, position: far, component: x}
  - {name: y, position: far, component: y}
  - {name: z, position: far, component: z}
simulation: {step: 0.01, end: 10, tolerance: 1e-9}
)");
  for (const Integrator integrator : {Integrator::generalized_alpha, Integrator::conserve}) {
    std::array<std::array<Vec3d, 2>, 2> at;
    for (std::size_t way = 0; way < 2; ++way)
      for (std::size_t k = 0; k < 2; ++k) {
        Simulation s(model, options({way == 0 ? Formulation::relative : Formulation::natural, integrator},
                                    0.004 / (1 + static_cast<double>(k))));
        const double energy = s.energy().total();
        advance(s, 2);
        ResultsRow row;
        s.sample(row);
        at[way][k] = {row.channels[0], row.channels[1], row.channels[2]};
        if (integrator == Integrator::conserve) {
          EXPECT_NEAR(s.energy().total(), energy, 1e-9);
        }
      }
    const double coarse = (at[0][0] - at[1][0]).norm(), fine = (at[0][1] - at[1][1]).norm();
    EXPECT_LT(fine, 1e-3);
    EXPECT_GT(coarse / fine, 3);
  }
}

// --- Flexible ---------------------------------------------------------------------------------------------

std::string dumb_bell(double damping) {
  return R"(
gravity: [0, 0, 0]
materials: {m: {young: 2e11, poisson: 0.3, density: 7800}}
sections: {r: {type: round, diameter: 0.02}}
bodies:
  bar:
    frame: {at: [0, 0, 0]}
    flexible:
      material: m
      section: r
      nodes: {a: [0, 0, 0], c: [1, 0, 0]}
      bars: {bar: {from: a, to: c, elements: 4}}
      clamped: [a]
      static_modes: [{node: c, all: true}]
      dynamic_modes: 2
      stiffness_damping: )" +
         std::to_string(damping) + R"(
  A: {mass: 1, com: [0, 0, 0], inertia: [2e-3, 3e-3, 4e-3]}
  C: {mass: 1, com: [1, 0, 0], inertia: [2e-3, 4e-3, 3e-3]}
joints:
  fly: {type: floating, between: [ground, A], at: [0, 0, 0], velocity: [0.1, 0.2, 0, 0.5, 0.7, 1]}
  wa: {type: bracket, between: [A, bar], at: [0, 0, 0]}
  wc: {type: bracket, between: [bar, C], at: [1, 0, 0]}
loads:
  kick: {on: C, at: [1, 0, 0], force: [0, 3, 1.5], scale: "t < 0.1 ? 1 : 0"}
simulation: {step: 0.01, end: 100}
)";
}

TEST(FreeFlight, FlexibleDumbBellKeepsItsMomentumForLong) {
  const auto model = model_of(dumb_bell(0));
  for (const Way& way : ways) {
    Simulation s(model, options(way, 0.01));
    advance(s, 0.2);
    Balance balance(*model);
    const Totals start = balance.of(s);
    const double energy = s.energy().total();
    double least = energy, most = energy;
    for (int k = 1; k <= 20; ++k) {
      advance(s, 0.2 + 2 * k);
      least = std::min(least, s.energy().total());
      most = std::max(most, s.energy().total());
    }
    expect_laws(balance, s, start, s.time() - 0.2, name(way));
    if (way.integrator == Integrator::conserve) {
      EXPECT_LT(most - least, 1e-7 * energy) << name(way);
    } else {
      // Vibration is damped by design, and nothing else.
      EXPECT_LT(most, energy * (1 + 1e-6)) << name(way);
    }
  }
}

/// Bars round two corners, in free flight: a shape that returns takes nothing from the rotation. What the
/// default damps are the vibrations at the start, and of natural coordinates, in which bodies turn by their
/// unit vectors, a little more.
TEST(FreeFlight, BentFrameKeepsItsEnergyWithoutTrend) {
  const auto model = model_of(R"(
gravity: [0, 0, 0]
materials: {m: {young: 2.1e11, poisson: 0.3, density: 7850}}
sections: {r: {type: round, diameter: 0.02}}
bodies:
  bar:
    frame: {at: [0, 0, 0]}
    flexible:
      material: m
      section: r
      nodes: {a: [0, 0, 0], b: [1, 0, 0], c: [1, 0.7, 0], d: [1, 0.7, 0.5]}
      bars:
        ab: {from: a, to: b, elements: 4}
        bc: {from: b, to: c, elements: 4}
        cd: {from: c, to: d, elements: 4}
      clamped: [a]
      static_modes: [{node: d, all: true}]
      dynamic_modes: 4
      stiffening: linear
joints:
  fly: {type: floating, between: [ground, bar], at: [0, 0, 0], velocity: [0.1, 0.2, 0, 0.5, 0.7, 3]}
simulation: {step: 0.01, end: 1000}
)");
  for (const Way& way : ways) {
    Simulation s(model, options(way, 0.01));
    advance(s, 20);
    Balance balance(*model);
    const Totals start = balance.of(s);
    const double energy = s.energy().total();
    double elastic = 0;
    for (int k = 0; k < 20; ++k) {
      advance(s, 23 + 3 * k);
      elastic = std::max(elastic, s.energy().elastic);
    }
    expect_laws(balance, s, start, s.time() - 20, name(way));
    const double drift = (s.energy().total() - energy) / energy / (s.time() - 20);  // 1/s
    const bool conserves = way.integrator == Integrator::conserve;
    EXPECT_LT(std::abs(drift), conserves                                  ? 1e-12
                               : way.formulation == Formulation::relative ? 1e-9
                                                                          : 1.5e-7)
        << name(way);
    // What the rotation bends it by, and no more: fast modes take up no energy.
    EXPECT_LT(elastic, 1.8e-3) << name(way);
  }
}

/// A thruster that turns with the body, and one that does not: their work and the energy balance.
TEST(Conserve, KeepsTheBalanceWithTheWorkOfLoads) {
  for (const char* const load : {"force: [0, 0.02, 0.01]", "force: [0, 0.02, 0.01], follower: true"}) {
    std::string text = dumb_bell(0);
    const std::string kick = "force: [0, 3, 1.5], scale: \"t < 0.1 ? 1 : 0\"";
    text.replace(text.find(kick), kick.size(), load);
    const auto model = model_of(text);
    for (const Formulation formulation : {Formulation::relative, Formulation::natural}) {
      Simulation s(model, options({formulation, Integrator::conserve}, 0.01));
      double off = 0;  // of what a step leaves for the next, once the start's vibrations are gone
      for (int k = 0; k < 1500; ++k) {
        ASSERT_TRUE(s.step().ok());
        if (s.time() > 1) off = std::max(off, std::abs(s.energy().numerical));
      }
      EXPECT_GT(std::abs(s.energy().load_work), 1e-4) << load;
      EXPECT_LT(off, 1e-8 * s.energy().total()) << load;
    }
  }
}

// --- Energy of what is not free ---------------------------------------------------------------------------

TEST(Conserve, FourBarKeepsItsEnergyAndConverges) {
  spec::Model tight = model_of(four_bar_text({{"crank", ", velocity: 4"}}))->spec();
  tight.simulation.tolerance = 1e-9;
  const auto model = Model::compile(tight);
  for (const Formulation formulation : {Formulation::relative, Formulation::natural}) {
    std::array<VectorXd, 3> at;
    for (int k = 0; k < 3; ++k) {
      Simulation s(model, options({formulation, Integrator::conserve}, 0.004 / (1 << k)));
      const double energy = s.energy().total();
      double off = 0;
      while (s.time() < 0.8 - 1e-9) {
        ASSERT_TRUE(s.step().ok());
        off = std::max(off, std::abs(s.energy().total() - energy));
      }
      EXPECT_LT(off, 1e-3 * std::abs(s.energy().kinetic + 1)) << "beyond what a turning point leaves";
      at[static_cast<std::size_t>(k)] = s.save().q;
    }
    EXPECT_NEAR((at[0] - at[1]).norm() / (at[1] - at[2]).norm(), 4, 0.6)
        << (at[0] - at[1]).norm() << " then " << (at[1] - at[2]).norm();
  }
}

TEST(Conserve, SaysWhereDrivesLeaveNothingToCorrect) {
  const auto driven = model_of(four_bar_text({{"crank", ", drive: {position: \"2*t\"}"}}));
  const auto said = [](const std::shared_ptr<const Model>& model, Integrator integrator) {
    const Simulation s(model, options({Formulation::relative, integrator}, 0.01));
    for (const std::string& text : s.warnings())
      if (text.find("drives prescribe velocities, so that nothing is left") != std::string::npos) return true;
    return false;
  };
  EXPECT_TRUE(said(driven, Integrator::conserve));
  EXPECT_FALSE(said(driven, Integrator::generalized_alpha));
  EXPECT_FALSE(said(model_of(four_bar_text()), Integrator::conserve));
}

TEST(Conserve, DampersKeepTheirWork) {
  // A pendulum with a damper in its joint: only what the numerics did is taken back.
  const auto model = model_of(R"(
bodies:
  b: {mass: 2, com: [1, 0, 0], inertia: [0.1, 0.1, 0.1]}
joints:
  pin: {type: revolute, between: [ground, b], at: [0, 0, 0], axis: [0, 1, 0], spring: {stiffness: 0, damping: 0.8}}
simulation: {step: 0.01, end: 10, tolerance: 1e-9}
)");
  // Its own equation: J φ̈ = −c φ̇ + m g l cos φ, φ about y from the x axis down.
  const double J = 2.1;
  double phi = 0, rate = 0;
  const double h = 1e-5;
  for (int k = 0; k < 300000; ++k) {  // midpoint rule
    const auto acceleration = [&](double x, double v) { return (-0.8 * v + 2 * 9.81 * std::cos(x)) / J; };
    const double a = acceleration(phi, rate);
    const double x = phi + 0.5 * h * rate, v = rate + 0.5 * h * a;
    phi += h * v;
    rate += h * acceleration(x, v);
  }
  std::array<double, 2> error{};
  for (int k = 0; k < 2; ++k) {
    Simulation s(model, options({Formulation::relative, Integrator::conserve}, 0.01 / (1 + k)));
    advance(s, 3);
    error[static_cast<std::size_t>(k)] = std::abs(s.save().q[0] - phi);
    const EnergyBalance& e = s.energy();
    EXPECT_GT(e.dissipated, 5);
    EXPECT_LT(std::abs(e.numerical), 1e-4 * e.dissipated);
  }
  EXPECT_LT(error[1], 1e-3);
  EXPECT_GT(error[0] / error[1], 3);
}

TEST(FreeFlight, GoesOnFromASnapshotWithTheSameBits) {
  const auto model = model_of(dumb_bell(1e-5));
  for (const Way& way : ways) {
    Simulation one(model, options(way, 0.01)), two(model, options(way, 0.01));
    for (int k = 0; k < 30; ++k) ASSERT_TRUE(one.step().ok());
    two.restore(one.save());
    for (int k = 0; k < 30; ++k) {
      ASSERT_TRUE(one.step().ok());
      ASSERT_TRUE(two.step().ok());
    }
    EXPECT_TRUE(one.save().q == two.save().q) << name(way);
    EXPECT_TRUE(one.save().v == two.save().v) << name(way);
  }
}

}  // namespace
}  // namespace mimbre::test::free_flight_test
