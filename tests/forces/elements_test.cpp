#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <stdexcept>

#include "forces/measure.h"
#include "forces/table.h"
#include "math/restitution.h"
#include "mimbre/model_file.h"
#include "mimbre/statics.h"
#include "support/models.h"
#include "support/simulate.h"

/// Force elements: bushings, laws of the user, springs on cut joints, tangents and powers of all laws.
namespace mimbre::elements_test {
namespace {

using namespace test;

class Elements : public testing::TestWithParam<Formulation> {};

constexpr const char* bushing_model = R"y(
gravity: [0, 0, 0]
bodies: {{block: {{mass: 2, com: [0, 0, 0], inertia: [0.5, 0.8, 1.1]}}}}
bushings:
  mount:
    between: [ground, block]
    at: [0, 0, 0]
    stiffness: [800, 1800, 3200, 50, 180, 500]
    {}
joints:
  free: {{type: floating, between: [ground, block], velocity: {}}}
outputs:
  - {{name: x, position: block, component: x}}
  - {{name: y, position: block, component: y}}
  - {{name: z, position: block, component: z}}
simulation: {{step: 0.001, end: 1}}
)y";

/// Free vibration in each of six directions: ω = √(k/m).
TEST_P(Elements, ABushingSwingsInSixDirections) {
  const std::array<double, 6> stiffness{800, 1800, 3200, 50, 180, 500}, mass{2, 2, 2, 0.5, 0.8, 1.1};
  for (std::size_t k = 0; k < 6; ++k) {
    const double omega = std::sqrt(stiffness[k] / mass[k]), amplitude = 1e-3;
    std::array<double, 6> velocity{};
    velocity[k] = amplitude * omega;
    const std::string text = fmt::format(fmt::runtime(bushing_model), "",
                                         fmt::format("[{}, {}, {}, {}, {}, {}]", velocity[0], velocity[1],
                                                     velocity[2], velocity[3], velocity[4], velocity[5]));
    Simulation simulation = simulation_of(model_of(text), GetParam(), 2e-4);
    const std::string measure =
        std::string("bushing.mount.measure.") + std::array{"x", "y", "z", "rx", "ry", "rz"}[k];
    const double period = 2 * std::numbers::pi / omega;
    while (simulation.time() < period) {
      ASSERT_TRUE(simulation.step().ok());
      ASSERT_NEAR(channel(simulation, measure), amplitude * std::sin(omega * simulation.time()),
                  1e-3 * amplitude)
          << k << " at " << simulation.time();
    }
    EXPECT_NEAR(simulation.energy().numerical, 0, 1e-4 * simulation.energy().kinetic + 1e-12);
  }
}

/// Dynamic stiffness k + k₁ iωτ/(1 + iωτ) with its loss angle, from the work and the force over a period.
TEST_P(Elements, MaxwellBranchesHaveTheirDynamicStiffness) {
  const double k0 = 1000, k1 = 600, tau = 0.02, amplitude = 1e-3;
  for (const double omega : {5.0, 20.0, 50.0, 120.0, 400.0}) {
    const std::string text = fmt::format(R"y(
gravity: [0, 0, 0]
bodies: {{block: {{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}}}
joints:
  guide: {{type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0], drive: {{position: "{}*sin({}*t)"}}}}
bushings:
  mount:
    between: [ground, block]
    at: [0, 0, 0]
    stiffness: [{}, 0, 0, 0, 0, 0]
    maxwell: [{{stiffness: [{}, 0, 0, 0, 0, 0], relaxation: {}}}]
simulation: {{step: 0.001, end: 1}}
)y",
                                         amplitude, omega, k0, k1, tau);
    const int per_period = 200;
    const double period = 2 * std::numbers::pi / omega, h = period / per_period;
    Simulation simulation = simulation_of(model_of(text), GetParam(), h);
    const int settling = static_cast<int>(std::ceil(12 * tau / period)) * per_period;
    for (int k = 0; k < settling; ++k) ASSERT_TRUE(simulation.step().ok());
    std::complex<double> sum = 0;
    for (int k = 0; k < per_period; ++k) {
      const double t = simulation.time();
      sum += -channel(simulation, "bushing.mount.force.x") * std::exp(std::complex<double>(0, -omega * t));
      ASSERT_TRUE(simulation.step().ok());
    }
    // x = A sin ωt = A Im e^{iωt}: the force is Im(A K e^{iωt}).
    const std::complex<double> measured = sum * (2.0 / per_period) * std::complex<double>(0, 1) / amplitude,
                               i(0, 1), exact = k0 + k1 * i * omega * tau / (1.0 + i * omega * tau);
    EXPECT_NEAR(std::abs(measured), std::abs(exact), 1e-3 * std::abs(exact)) << omega;
    EXPECT_NEAR(std::arg(measured), std::arg(exact), 1e-3 * std::arg(exact)) << omega;
  }
}

/// A four-bar with a spring on its last joint, whichever joint is cut.
TEST_P(Elements, SpringsActOnCutJointsAsOnThoseOfTheTree) {
  const auto text = [](const char* cut_first, const char* cut_last) {
    return fmt::format(R"y(
bodies:
  crank: {{mass: 1, com: [0, 0, 0.2], inertia: [0.02, 0.02, 0.02]}}
  coupler: {{mass: 2, com: [0.5, 0, 0.4], inertia: [0.1, 0.1, 0.1]}}
  rocker: {{mass: 1, com: [1, 0, 0.2], inertia: [0.02, 0.02, 0.02]}}
joints:
  a: {{type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 1, 0]{}}}
  b: {{type: revolute, between: [crank, coupler], at: [0, 0, 0.4], axis: [0, 1, 0]}}
  c: {{type: revolute, between: [coupler, rocker], at: [1, 0, 0.5], axis: [0, 1, 0]}}
  d: {{type: revolute, between: [ground, rocker], at: [1, 0, 0], axis: [0, 1, 0]{}, spring: {{stiffness: 30, damping: 0.3, zero: 0.2}}}}
actuators:
  motor: {{joint: d, torque: "2*sin(20*t)"}}
outputs:
  - {{name: z, position: rocker, component: z}}
  - {{name: x, velocity: coupler, component: x}}
  - {{name: fx, joint_force: d, component: fx}}
  - {{name: my, joint_force: d, component: my}}
simulation: {{step: 0.001, end: 1}}
)y",
                       cut_first, cut_last);
  };
  Simulation tree = simulation_of(model_of(text(", cut: always", "")), GetParam()),
             cut = simulation_of(model_of(text("", ", cut: always")), GetParam());
  for (int k = 0; k < 500; ++k) {
    ASSERT_TRUE(tree.step().ok());
    ASSERT_TRUE(cut.step().ok());
    for (const char* name : {"z", "x", "fx", "my"}) {
      const double expected = channel(tree, name);
      ASSERT_NEAR(channel(cut, name), expected, 2e-5 * (1 + std::abs(expected))) << name << " at " << k;
    }
    ASSERT_NEAR(cut.energy().dissipated, tree.energy().dissipated, 1e-6);
    ASSERT_NEAR(cut.energy().springs, tree.energy().springs, 1e-5);
    ASSERT_NEAR(cut.energy().load_work, tree.energy().load_work, 1e-5);
  }
}

constexpr const char* slider = R"y(
bodies: {mass: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {guide: {type: prismatic, between: [ground, mass], at: [0, 0, 0], axis: [0, 0, 1]}}
frames: {anchor: {body: ground, at: [0, 0, 1]}}
outputs: [{name: z, joint: guide}]
simulation: {step: 0.001, end: 1}
)y";

int frame_named(const spec::Model& model, const std::string& name) {
  for (std::size_t k = 0; k < model.frames.size(); ++k)
    if (model.frames[k].name == name) return static_cast<int>(k);
  return -1;
}

/// A spring and damper written by the user does what the built-in one does, to the last bit; one with a state
/// of its own remembers.
TEST_P(Elements, AUsersLawDoesWhatABuiltInOneDoes) {
  spec::Model model = parse_model("mimbre: 1\n" + std::string(slider), "slider.yaml", ".");
  const int a = frame_named(model, "anchor"), b = frame_named(model, "mass");
  ASSERT_GE(a, 0);
  ASSERT_GE(b, 0);
  spec::Model built = model;
  spec::Spring spring;
  spring.name = "s";
  spring.frame_a = a;
  spring.frame_b = b;
  spring.elastic = Function::linear(500, 1);
  spring.damping = Function::linear(3);
  built.springs.push_back(spring);
  auto law = std::make_shared<spec::UserLaw>();
  law->elastic = true;
  law->evaluate = [](spec::LawCall& call) {
    call.force[0] = 500 * (call.x[0] - 1) + 3 * call.v[0];
    call.stiffness[0] = 500;
    call.damping[0] = 3;
    call.stored = 250 * (call.x[0] - 1) * (call.x[0] - 1);
    call.dissipating[0] = 3 * call.v[0];
  };
  spec::Element element;
  element.name = "s";
  element.law = "user";
  element.frame_a = a;
  element.frame_b = b;
  element.user = law;
  model.elements.push_back(element);
  Simulation one = simulation_of(Model::compile(built), GetParam()),
             other = simulation_of(Model::compile(model), GetParam());
  for (int k = 0; k < 300; ++k) {
    ASSERT_TRUE(one.step().ok());
    ASSERT_TRUE(other.step().ok());
    ASSERT_EQ(channel(one, "z"), channel(other, "z")) << k;
  }
  EXPECT_NEAR(one.energy().dissipated, other.energy().dissipated, 1e-12);
  EXPECT_NEAR(one.energy().springs, other.energy().springs, 1e-12);
}

/// On a slow and a fast gas: the mass swings about where weight and gas balance, with ω² = −∂F/∂x/m.
TEST_P(Elements, AGasSpringCarriesAMass) {
  const double area = 5e-4, pressure = 4e5, ambient = 101325, n = 1.4, column = 0.25;
  const double force = area * (pressure - ambient), mass = force / 9.81;
  Simulation simulation = simulation_of(model_of(fmt::format(R"y(
bodies: {{mass: {{mass: {}, com: [0, 0, 0], inertia: [1, 1, 1]}}}}
joints: {{guide: {{type: prismatic, between: [ground, mass], at: [0, 0, 0.5], axis: [0, 0, 1], velocity: 1e-3}}}}
gas_springs:
  strut: {{between: [ground, mass], at: [[0, 0, 0], [0, 0, 0.5]], pressure: {}, area: 5 cm^2, length: 50 cm, gas_length: {}, exponent: {}}}
outputs: [{{name: z, joint: guide}}]
simulation: {{step: 0.001, end: 1}}
)y",
                                                             mass, pressure, column, n)),
                                        GetParam());
  const double omega = std::sqrt(n * pressure * area / column / mass);
  while (simulation.time() < 2) {
    ASSERT_TRUE(simulation.step().ok());
    ASSERT_NEAR(channel(simulation, "z"), 1e-3 / omega * std::sin(omega * simulation.time()),
                2e-3 * 1e-3 / omega);
  }
  EXPECT_NEAR(simulation.energy().numerical, 0, 1e-9 * mass);
}

/// A weight that hangs in a bushing at rest stays where its springs hold it: what relaxes has relaxed.
TEST_P(Elements, InAnEquilibriumBranchesHaveRelaxed) {
  Simulation simulation = simulation_of(model_of(R"y(
bodies: {block: {mass: 3, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}}
bushings:
  mount:
    between: [ground, block]
    at: [0, 0, 0]
    stiffness: [1e4, 1e4, 5e3, 50, 50, 50]
    damping: [10, 10, 10, 0.1, 0.1, 0.1]
    maxwell: [{stiffness: [2e4, 2e4, 2e4, 10, 10, 10], relaxation: 0.1}]
initial: equilibrium
outputs: [{name: z, position: block, component: z}]
simulation: {step: 0.005, end: 1}
)y"),
                                        GetParam());
  for (int k = 0; k < 100; ++k) {
    ASSERT_NEAR(channel(simulation, "z"), -3 * 9.81 / 5e3, 1e-8) << k;
    ASSERT_TRUE(simulation.step().ok());
  }
}

/// A law that is sampled is asked once a step, with what is measured at its start, and remembers.
TEST_P(Elements, ASampledLawIsAskedOnceAStep) {
  spec::Model model = parse_model("mimbre: 1\n" + std::string(slider), "slider.yaml", ".");
  model.gravity.setZero();
  auto calls = std::make_shared<int>(0);
  auto law = std::make_shared<spec::UserLaw>();
  law->sampled = true;
  law->states = {0};
  law->evaluate = [calls](spec::LawCall& call) {
    ++*calls;
    call.force[0] = -2.0 - call.states[0];  // pushes on, more with each step
    call.next[0] = call.states[0] + 1;
  };
  spec::Element element;
  element.name = "s";
  element.law = "user";
  element.on = spec::Element::On::coordinate;
  element.joint = 0;
  element.user = law;
  model.elements.push_back(element);
  Simulation simulation = simulation_of(Model::compile(model), GetParam());
  const int before = *calls;
  for (int k = 0; k < 10; ++k) {
    ASSERT_TRUE(simulation.step().ok());
    EXPECT_EQ(channel(simulation, "user.s.force"), 2.0 + k);
  }
  EXPECT_EQ(*calls - before, 10);
}

/// In an equilibrium such a law exerts nothing, and it is named.
TEST(SampledLaws, AreNamedByAnEquilibriumThatTheyDoNotActIn) {
  spec::Model model = parse_model("mimbre: 1\n" + std::string(slider), "slider.yaml", ".");
  auto law = std::make_shared<spec::UserLaw>();
  law->sampled = true;
  law->evaluate = [](spec::LawCall& call) { call.force[0] = 5; };
  spec::Element element;
  element.name = "push";
  element.law = "user";
  element.on = spec::Element::On::coordinate;
  element.joint = 0;
  element.user = law;
  model.elements.push_back(element);
  model.gravity.setZero();
  model.simulation.start_at_equilibrium = true;
  const auto compiled = Model::compile(model);
  const auto named = testing::Contains(testing::HasSubstr("'push' exerts no force in an equilibrium"));
  EXPECT_THAT(static_equilibrium(compiled).warnings, named);
  EXPECT_THAT(Simulation(compiled, {}).warnings(), named);
}

/// What a law that is sampled throws leaves the step, which is not made; the next one is as if nothing had
/// been.
TEST_P(Elements, WhatASampledLawThrowsLeavesTheStateAsItWas) {
  spec::Model model = parse_model("mimbre: 1\n" + std::string(slider), "slider.yaml", ".");
  auto broken = std::make_shared<bool>(false);
  auto law = std::make_shared<spec::UserLaw>();
  law->sampled = true;
  law->evaluate = [broken](spec::LawCall& call) {
    call.force[0] = 40 * call.v[0];
    if (*broken) throw std::runtime_error("stuck");
  };
  spec::Element element;
  element.name = "s";
  element.law = "user";
  element.on = spec::Element::On::coordinate;
  element.joint = 0;
  element.user = law;
  model.elements.push_back(element);
  const auto compiled = Model::compile(model);
  Simulation one = simulation_of(compiled, GetParam()), other = simulation_of(compiled, GetParam());
  for (int k = 0; k < 20; ++k) {
    *broken = true;
    EXPECT_THROW(one.step(), std::runtime_error);
    *broken = false;
    ASSERT_TRUE(one.step().ok());
    ASSERT_TRUE(other.step().ok());
    ASSERT_EQ(one.time(), other.time());
    ASSERT_EQ(channel(one, "z"), channel(other, "z")) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(BothFormulations, Elements,
                         testing::Values(Formulation::relative, Formulation::natural));

/// Of every law: ∂force/∂x and ∂force/∂v by differences, and what a closed circle in x gives back.
TEST(ForceLaws, TangentsAreThoseOfTheForces) {
  Compiled m;
  m.signals.slots = 2;
  std::vector<double> signals{0.3, 1.7};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int round = 0; round < 200; ++round) {
    for (const std::string law : {"spring", "tyre", "actuator", "bushing", "friction", "stop",
                                  "torsion_spring", "cable", "motor", "drag", "hydraulic_damper"}) {
      ElementData e;
      e.law = find_law(law);
      e.measure = law == "bushing" ? Measure::relative
                  : law == "drag"  ? Measure::velocity
                                   : Measure::distance;
      e.count = measure_size(e.measure);
      m.functions = {Function::polynomial({any(random), 3, any(random), 1}).data(),
                     Function::polynomial({0, 2, 0, 1}).data()};
      m.numbers = {50, 0.3};
      m.formulas = {{Expression("sin(l)*v + u*l^2", {"l", "v", "u"}), {1}}};
      m.arguments = {1};
      e.functions = 0;
      if (law == "spring") e.formula = 0;
      if (law == "bushing") {
        for (int k = 0; k < 5; ++k)
          for (int j = 0; j < 2; ++j) m.functions.push_back(m.functions[static_cast<std::size_t>(j)]);
        m.numbers.assign(72 + 37, 0);
        for (int block = 0; block < 3; ++block) {
          Eigen::Matrix<double, 6, 6> a =
              Eigen::Matrix<double, 6, 6>::NullaryExpr([&] { return any(random); });
          a = (a * a.transpose()).eval();
          for (int k = 0; k < 36; ++k) m.numbers[static_cast<std::size_t>(36 * block + k)] = a(k / 6, k % 6);
        }
        m.numbers.back() = 0.02;
        e.state_count = 12;
      }
      if (law == "friction") {
        m.numbers = {0.3, 1.5, 0.4, 0.2, 1e-3, 0, 0};
        if (round % 2 == 0) m.numbers = {0.3, 1.5, 0, 0.2, 0, 0.3, 2e-3};
        e.state_count = 4;
      }
      if (law == "stop") {
        m.numbers = {-0.2, 0.3, 50, 1.7, 0.1, 0.5, restitution_damping(0.5), 0.01};
        e.state_count = 1;
      }
      if (law == "hydraulic_damper") {
        m.numbers = {2, round % 2 == 0 ? 0.0 : 5.0, 1, 1, 1, 300};
        e.state_count = 2;
      }
      if (law == "cable") {
        m.numbers = {40, 3, 0.2, 0, 0.2};
        e.state_count = 3;
      }
      if (law == "motor") {
        m.numbers = {-2,  0,   0.7, 1.3, round % 3 == 0 ? 0.5 : 1e300, round % 3 == 1 ? 0.6 : 1e300,
                     0.1, 0.8, 1};
        if (round % 2 == 0) e.functions = -1;
      }
      // The tangent is symmetric, and that of the force where all coefficients are the same.
      if (law == "drag") m.numbers = {2, 1.2, 0.7, 0.7, 0.7};
      const auto n = static_cast<std::size_t>(e.count);
      std::vector<double> storage(static_cast<std::size_t>(element_storage(e)), 0), states(12, 0);
      for (double& s : states) s = any(random);
      const LawContext<double> context{m, e, 0.3, signals.data(), states.data(), 0.01};
      const forces::LawRow<double>& row = forces::rows<double>[static_cast<std::size_t>(e.law)];
      std::vector<double> x(n), v(n);
      for (double& s : x) s = any(random);
      for (double& s : v) s = any(random);
      const auto at = [&](const std::vector<double>& at_x, const std::vector<double>& at_v) {
        ElementState<double> s = element_state(e, storage.data());
        std::copy(at_x.begin(), at_x.end(), s.x);
        std::copy(at_v.begin(), at_v.end(), s.v);
        row.law(context, s);
        return s;
      };
      for (std::size_t c = 0; c < n; ++c)
        for (const bool rate : {false, true}) {
          const double h = 1e-6;
          std::vector<double> up = rate ? v : x, down = up;
          up[c] += h;
          down[c] -= h;
          const auto forces_of = [&](const std::vector<double>& y) {
            const ElementState<double> s = rate ? at(x, y) : at(y, v);
            return std::vector<double>(s.force, s.force + n);
          };
          const std::vector<double> above = forces_of(up), below = forces_of(down);
          const ElementState<double> s = at(x, v);
          for (std::size_t r = 0; r < n; ++r) {
            const double tangent = rate ? s.damping[r * n + c] : s.stiffness[r * n + c];
            EXPECT_NEAR(tangent, (above[r] - below[r]) / (2 * h), 1e-7 * (1 + std::abs(tangent)))
                << law_info(e.law).name << (rate ? " rate " : " ") << r << c;
          }
        }
    }
  }
}

/// Whatever is done to a bushing with branches, it gives back no more than it got.
TEST(ForceLaws, BushingsWithBranchesNeverFeedEnergyIn) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1, 1);
  Compiled m;
  ElementData e;
  e.law = find_law("bushing");
  e.measure = Measure::relative;
  e.count = 6;
  e.state_count = 12;
  m.numbers.assign(72 + 37, 0);
  Eigen::Matrix<double, 6, 6> a = Eigen::Matrix<double, 6, 6>::NullaryExpr([&] { return any(random); });
  a = (a * a.transpose()).eval();
  for (int k = 0; k < 36; ++k) m.numbers[static_cast<std::size_t>(72 + k)] = a(k / 6, k % 6);
  m.numbers.back() = 0.02;
  std::vector<double> storage(static_cast<std::size_t>(element_storage(e)), 0), states(12, 0), signals{0};
  const forces::LawRow<double>& row = forces::rows<double>[static_cast<std::size_t>(e.law)];
  for (int step = 0; step < 2000; ++step) {
    const double h = 0.02 * std::pow(10.0, 2 * any(random));
    const LawContext<double> context{m, e, 0, signals.data(), states.data(), h};
    ElementState<double> s = element_state(e, storage.data());
    const std::vector<double> before(s.x, s.x + 6);
    double stored_before = 0;
    {
      ElementEnergy energy;
      ElementState<double> old = s;
      std::vector<double> held = states;
      old.states = held.data();
      const LawContext<double> rest{m, e, 0, signals.data(), states.data(), 0};
      row.energy(rest, old, energy);
      stored_before = energy.stored;
    }
    for (int k = 0; k < 6; ++k) s.x[k] = any(random);
    row.law(context, s);
    ElementEnergy energy;
    row.energy(context, s, energy);
    EXPECT_GE(energy.lost, -1e-15);
    // The work of the force over the step, by many small parts of the same path, is what is stored and lost.
    double work = 0;
    const int parts = 2000;
    std::vector<double> inner = states;
    ElementData part = e;
    std::vector<double> small(storage.size(), 0);
    std::array<double, 6> last{};
    for (int p = 0; p <= parts && step % 200 == 0; ++p) {
      ElementState<double> t = element_state(part, small.data());
      for (int k = 0; k < 6; ++k)
        t.x[k] =
            before[static_cast<std::size_t>(k)] + (s.x[k] - before[static_cast<std::size_t>(k)]) * p / parts;
      row.law({m, part, 0, signals.data(), inner.data(), p == 0 ? 0 : h / parts}, t);
      for (int k = 0; k < 6; ++k) {
        if (p > 0)
          work += 0.5 * (t.force[k] + last[static_cast<std::size_t>(k)]) *
                  (s.x[k] - before[static_cast<std::size_t>(k)]) / parts;
        last[static_cast<std::size_t>(k)] = t.force[k];
      }
      std::copy(t.states, t.states + 12, inner.begin());
    }
    if (step % 200 == 0) {
      EXPECT_NEAR(work, energy.stored - stored_before + energy.lost,
                  1e-4 * (energy.stored + energy.lost + 1e-9));
    }
    std::copy(s.states, s.states + 12, states.begin());
  }
}

/// The rates of what is measured are the derivatives of what is measured.
TEST(Measures, RatesAreDerivatives) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  const auto vector = [&] { return Vec3d(any(random), any(random), any(random)); };
  Compiled m;
  for (int round = 0; round < 300; ++round) {
    for (const Measure measure_kind :
         {Measure::distance, Measure::coordinate, Measure::axis, Measure::relative}) {
      ElementData e;
      e.measure = measure_kind;
      e.count = measure_size(measure_kind);
      e.joint = round % 2 == 0 ? spec::JointType::revolute : spec::JointType::prismatic;
      e.direction = vector().normalized();
      e.about = round % 2 == 0;
      e.turns = -1;
      e.rotation = rotation_exp<double>(vector());
      Motion<double> a, b;
      a.position = vector();
      a.rotation = rotation_exp<double>(vector());
      a.velocity = vector();
      a.omega = vector();
      if (measure_kind == Measure::coordinate || (measure_kind == Measure::axis && e.about)) {
        // As the joint, or an axis that both share, lets it move.
        const Vec3d axis = measure_kind == Measure::coordinate ? Vec3d(Vec3d::UnitZ()) : e.direction;
        const Mat3d rest = measure_kind == Measure::coordinate ? Mat3d(Mat3d::Identity()) : e.rotation;
        const bool turns = measure_kind == Measure::axis || e.joint == spec::JointType::revolute;
        const double q = any(random), qd = any(random);
        b.rotation =
            a.rotation * rotation_exp<double>(Vec3d(turns ? Vec3d(q * axis) : Vec3d(Vec3d::Zero()))) * rest;
        b.omega = a.omega + (turns ? Vec3d(a.rotation * (qd * axis)) : Vec3d(Vec3d::Zero()));
        const Vec3d d = turns ? Vec3d(Vec3d::Zero()) : Vec3d(a.rotation * (q * axis));
        b.position = a.position + d;
        b.velocity =
            a.velocity + a.omega.cross(d) + (turns ? Vec3d(Vec3d::Zero()) : Vec3d(a.rotation * (qd * axis)));
      } else {
        b.position = vector();
        b.rotation = rotation_exp<double>(vector());
        b.velocity = vector();
        b.omega = vector();
      }
      std::vector<double> storage(static_cast<std::size_t>(element_storage(e)), 0), signals{0}, states{0};
      const auto at = [&](double t, std::vector<double>& out) {
        Motion<double> p = a, q = b;
        p.position += t * a.velocity;
        p.rotation = rotation_exp<double>(Vec3d(t * a.omega)) * a.rotation;
        q.position += t * b.velocity;
        q.rotation = rotation_exp<double>(Vec3d(t * b.omega)) * b.rotation;
        ElementState<double> s = element_state(e, storage.data());
        measure(m, e, &p, q, Vec3d(Vec3d::Zero()), signals.data(), states.data(), s);
        out.assign(s.x, s.x + e.count);
        return s;
      };
      std::vector<double> up, down, here;
      const double h = 1e-5;
      at(h, up);
      at(-h, down);
      const ElementState<double> s = at(0, here);
      const Vec3d d = b.position - a.position, u = b.velocity - a.velocity - a.omega.cross(d),
                  w = b.omega - a.omega;
      for (int k = 0; k < e.count; ++k) {
        const auto i = static_cast<std::size_t>(k);
        if (measure_kind == Measure::relative && Vec3d(here[3], here[4], here[5]).norm() > 3) continue;
        EXPECT_NEAR(s.v[k], (up[i] - down[i]) / (2 * h), 1e-7) << static_cast<int>(measure_kind) << k;
        const Vec3d angular = has_moment(measure_kind) ? s.angular_of(k) : Vec3d(Vec3d::Zero());
        EXPECT_NEAR(s.v[k], s.linear_of(k).dot(u) + angular.dot(w), 1e-12);
      }
    }
  }
}

}  // namespace
}  // namespace mimbre::elements_test
