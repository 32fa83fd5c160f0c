#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "dynamics/relative/assembly.h"
#include "dynamics/relative/evaluation.h"
#include "dynamics/relative/retract.h"
#include "dynamics/relative/workspace_impl.h"
#include "linalg/block_factor_impl.h"
#include "signals/blocks/table.h"
#include "support/models.h"
#include "support/random_mechanism.h"
#include "tyre_files/tyre_data.h"

/// The kernels of a step over packs of lanes, where each lane has to be the step of a number, and over dual
/// numbers, whose derivatives have to be those of what the kernels compute.
namespace mimbre::test::scalar_core_test {
namespace {

using Lanes = Pack<4>;

/// Everything that a Newton step depends on.
template <class T>
struct Given {
  std::vector<T> q, v, a, multipliers, held, states, numbers;

  /// Calls f with each array of this and of others.
  template <class F, class... Others>
  void each(const F& f, Others&... others) {
    f(q, others.q...);
    f(v, others.v...);
    f(a, others.a...);
    f(multipliers, others.multipliers...);
    f(held, others.held...);
    f(states, others.states...);
    f(numbers, others.numbers...);
  }
};

/// What it gives.
template <class T>
struct Made {
  std::vector<T> residual, phi, elements, signals, matrix, increment, moved, composed;

  template <class F>
  void each(const F& f) const {
    f("residual", residual);
    f("equations", phi);
    f("elements", elements);
    f("signals", signals);
    f("matrix", matrix);
    f("increment", increment);
    f("positions", moved);
    f("composed increment", composed);
  }
};

constexpr double now = 0.013, step = 0.01, penalty_factor = 1e6;

/// One Newton step by the rule of index 3, as RelativeSystem makes it.
template <class T>
Made<T> newton_step(const Compiled& m, const Given<T>& g) {
  std::vector<double> penalty(static_cast<std::size_t>(m.equations));
  for_rows(m, [&](const EquationRows& e) {
    for (int r = 0; r < e.count; ++r)
      penalty[static_cast<std::size_t>(e.first_equation + r)] = m.mass_scale * e.scale[r];
  });
  for (const DriveData& d : m.drives) penalty[static_cast<std::size_t>(d.equation)] = m.mass_scale * d.scale;
  const double h2 = step * step / 4;
  const MatrixWeights weights{step / 2, h2, penalty_factor * h2};

  const auto n = static_cast<std::size_t>(m.velocities);
  relative::Workspace<T> w(m);
  w.signals.enter(g.held.data(), g.states.data(), step);
  w.signals.numbers = g.numbers.data();
  linalg::BlockFactor<T> factor(m.symbolic);
  Made<T> made;
  std::vector<T> mu(static_cast<std::size_t>(m.equations));
  made.residual.resize(n);
  relative::set_origin<T>(m, w, g.q.data());
  relative::evaluate<T>(m, w, penalty.data(), now, g.q.data(), g.v.data(), g.a.data(), g.multipliers.data(),
                        penalty_factor, mu.data(), made.residual.data());
  factor.set_zero();
  relative::assemble<T>(m, w, g.q.data(), weights, penalty.data(), factor.values(), relative::NoMarks{});
  made.matrix.resize(n * n);
  linalg::to_dense(m.symbolic, factor.values(), made.matrix.data());
  made.phi.assign(w.phi.begin(), w.phi.end());
  made.elements.assign(w.elements.begin(), w.elements.end());
  made.signals = w.signals.value;
  EXPECT_TRUE(factor.factor().ok());
  for (const T& r : made.residual) made.increment.push_back(-h2 * r);
  factor.solve(made.increment.data());
  made.moved.resize(g.q.size());
  relative::retract<T>(m, g.q.data(), made.increment.data(), made.moved.data());
  made.composed = made.increment;
  relative::compose<T>(m, made.composed.data(), g.v.data());
  return made;
}

/// What is held of blocks: places that count things or tell times, with the values of a step to now.
std::vector<std::pair<std::size_t, double>> times_of_blocks(const Compiled& m) {
  std::vector<std::pair<std::size_t, double>> all;
  const auto put = [&](int at, double value) { all.emplace_back(static_cast<std::size_t>(at), value); };
  if (m.signals.clock >= 0) {
    put(m.signals.clock, now - step);
    put(m.signals.clock + 1, 0);
  }
  for (const SignalsData::Block& b : m.signals.blocks) {
    put(b.held, 1);
    if (b.type != find_block("delay")) continue;
    // Four points, the last of them at the start of the step.
    const int states = b.held + 1 + b.inputs;
    put(states + blocks::delay::count, 4);
    put(states + blocks::delay::newest, 3);
    for (int k = 0; k < 4; ++k) put(states + blocks::delay::first_point + 2 * k, now - step * (4 - k));
  }
  return all;
}

/// A state off the assembled one, with other inputs, states and numbers of laws than the model's.
Given<double> given(const Compiled& m, Random& random, double size) {
  const auto values = [&](int count, double most) {
    const VectorXd x = random.values(count, most);
    return std::vector<double>(x.begin(), x.end());
  };
  Given<double> g;
  const VectorXd start = assembled_position(m), x = random_increment(m, random, size),
                 rates = random_increment(m, random, 1), second = random_increment(m, random, 3);
  g.q.resize(static_cast<std::size_t>(m.positions));
  relative::retract<double>(m, start.data(), x.data(), g.q.data());
  g.v.assign(rates.begin(), rates.end());
  g.a.assign(second.begin(), second.end());
  g.multipliers = values(m.equations, 5);
  g.held.assign(m.signals.start.begin(), m.signals.start.end());
  for (double& u : g.held) u += random.number(-0.2, 0.2);
  for (const SignalsData::HeldInput& h : m.signals.held)
    if (h.linear) {
      // From one instant to another around now.
      g.held[static_cast<std::size_t>(h.held) + 1] = now - random.number(0.001, 0.01);
      g.held[static_cast<std::size_t>(h.held) + 3] = now + random.number(0.001, 0.01);
    }
  for (const auto& [at, value] : times_of_blocks(m)) g.held[at] = value;
  g.states.assign(m.states.begin(), m.states.end());
  for (double& z : g.states) z += random.number(-0.1, 0.1);
  g.numbers.assign(m.numbers.begin(), m.numbers.end());
  for (double& p : g.numbers) p *= random.number(0.9, 1.1);
  return g;
}

/// The compiler may contract products and sums of numbers and of lanes in different places, so that they
/// differ by round-off: of what is solved for, by as much as the matrix makes of that.
void expect_lanes_are_steps(const Compiled& m, unsigned seed, double size) {
  Random random(seed);
  std::vector<Given<double>> each;
  for (int i = 0; i < 4; ++i) each.push_back(given(m, random, i == 2 ? 0.01 * size : size));
  Given<Lanes> lanes;
  lanes.each(
      [](std::vector<Lanes>& all, auto& a, auto& b, auto& c, auto& d) {
        for (std::size_t k = 0; k < a.size(); ++k) {
          Lanes x;
          x[0] = a[k], x[1] = b[k], x[2] = c[k], x[3] = d[k];
          all.push_back(x);
        }
      },
      each[0], each[1], each[2], each[3]);
  const Made<Lanes> of = newton_step(m, lanes);
  std::vector<double> scales;
  of.each([&](const char*, const std::vector<Lanes>& x) {
    double most = 0;
    for (const Lanes& value : x)
      for (const double lane : value.lane)
        if (std::isfinite(lane)) most = std::max(most, std::abs(lane));
    scales.push_back(most);
  });
  for (int i = 0; i < 4; ++i) {
    const Made<double> one = newton_step(m, each[static_cast<std::size_t>(i)]);
    std::vector<const std::vector<double>*> expected;
    one.each([&](const char*, const std::vector<double>& x) { expected.push_back(&x); });
    std::size_t next = 0;
    of.each([&](const char* name, const std::vector<Lanes>& found) {
      const double scale = scales[next];
      const std::vector<double>& x = *expected[next++];
      ASSERT_EQ(found.size(), x.size());
      const std::string what = name;
      const bool solved = what == "increment" || what == "positions" || what == "composed increment";
      const double tolerance = (solved ? 1e-9 : 1e-13) * scale;
      double most = 0;
      for (std::size_t k = 0; k < x.size(); ++k) {
        if (std::isnan(x[k]) && std::isnan(found[k][i])) continue;  // never written
        const double off = std::abs(found[k][i] - x[k]);
        most = std::isnan(off) ? off : std::max(most, off);
        if (std::isnan(most)) break;
      }
      EXPECT_LE(most, tolerance) << what << ", lane " << i;
    });
  }
}

/// Along a line through the states, the inputs or the numbers of laws.
enum class By { state, input, number };

/// `widths`: of the differences. Over the place where all of a footprint begins to slide, and its tangents
/// jump, wide ones reach, and narrow ones have round-off: what is computed has to have the derivative that
/// differences of one of the widths say.
void expect_derivatives(const Compiled& m, unsigned seed, double size, By by,
                        const std::vector<double>& widths = {4e-4}) {
  Random random(seed);
  Given<double> at = given(m, random, size), along;
  const auto direction = [&](std::size_t count, bool moves, double most) {
    const VectorXd x = random.values(static_cast<int>(count), moves ? most : 0);
    return std::vector<double>(x.begin(), x.end());
  };
  const VectorXd increment = random_increment(m, random, by == By::state ? 1 : 0);
  along.v = direction(at.v.size(), by == By::state, 1);
  along.a = direction(at.a.size(), by == By::state, 1);
  along.multipliers = direction(at.multipliers.size(), by == By::state, 1);
  along.states = direction(at.states.size(), by == By::state, 1);
  along.held = direction(at.held.size(), by == By::input, 1);
  along.numbers = direction(at.numbers.size(), by == By::number, 1);
  for (std::size_t k = 0; k < along.numbers.size(); ++k) along.numbers[k] *= 0.1 * at.numbers[k];
  // What inputs are held from and to is in fractions of a step.
  for (const SignalsData::HeldInput& h : m.signals.held)
    if (h.linear)
      along.held[static_cast<std::size_t>(h.held) + 1] = along.held[static_cast<std::size_t>(h.held) + 3] = 0;
  for (const auto& [place, value] : times_of_blocks(m)) along.held[place] = 0;

  const auto moved = [&](double s) {
    Given<double> g = at;
    const auto add = [s](std::vector<double>& x, const std::vector<double>& d) {
      for (std::size_t k = 0; k < d.size(); ++k) x[k] += s * d[k];
    };
    g.each(add, along);
    const VectorXd x = s * increment;
    relative::retract<double>(m, at.q.data(), x.data(), g.q.data());
    return newton_step(m, g);
  };
  Given<Dual> dual;
  dual.each(
      [](std::vector<Dual>& all, auto& x, auto& d) {
        for (std::size_t k = 0; k < x.size(); ++k) all.push_back(Dual(x[k], k < d.size() ? d[k] : 0));
      },
      at, along);
  std::vector<Dual> x;
  for (const double d : increment) x.push_back(Dual(0, d));
  relative::retract<Dual>(m, dual.q.data(), x.data(), dual.q.data());
  const Made<Dual> found = newton_step(m, dual);

  // Romberg's extrapolation of central differences.
  constexpr int levels = 3;
  std::vector<Made<double>> up, down;
  for (const double widest : widths)
    for (int l = 0; l < levels; ++l) {
      up.push_back(moved(widest / (1 << l)));
      down.push_back(moved(-widest / (1 << l)));
    }
  std::size_t part = 0;
  found.each([&](const char* name, const std::vector<Dual>& of) {
    const auto values = [&](const Made<double>& made) {
      const std::vector<double>* result = nullptr;
      std::size_t at_part = 0;
      made.each([&](const char*, const std::vector<double>& value) {
        if (at_part++ == part) result = &value;
      });
      return *result;
    };
    double scale = 0, most = 0;
    for (std::size_t k = 0; k < of.size(); ++k) {
      if (std::isnan(of[k].value)) continue;
      const auto difference = [&](std::size_t width) {
        std::array<double, levels> table;
        for (std::size_t l = 0; l < levels; ++l) {
          const std::size_t j = width * levels + l;
          table[l] = (values(up[j])[k] - values(down[j])[k]) / (2 * widths[width] / (1 << l));
        }
        for (int order = 1; order < levels; ++order)
          for (int l = levels - 1; l >= order; --l) {
            const auto j = static_cast<std::size_t>(l);
            table[j] += (table[j] - table[j - 1]) / ((1 << 2 * order) - 1);
          }
        return table.back();
      };
      double nearest = difference(0);
      for (std::size_t width = 1; width < widths.size(); ++width)
        if (const double next = difference(width);
            std::abs(of[k].derivative - next) < std::abs(of[k].derivative - nearest))
          nearest = next;
      scale = std::max({scale, std::abs(nearest), std::abs(of[k].value)});
      const double off = std::abs(of[k].derivative - nearest);
      most = std::isnan(off) || std::isnan(most) ? std::numeric_limits<double>::quiet_NaN()
                                                 : std::max(most, off);
    }
    const std::string what = name;
    const bool solved = what == "increment" || what == "positions" || what == "composed increment";
    EXPECT_LE(most, (solved ? 1e-7 : 1e-9) * scale) << name;
    ++part;
  });
}

struct Mechanism {
  const char* name;
  std::function<std::shared_ptr<const Model>()> model;
  double size;          ///< of increments away from the assembled position
  double width = 4e-4;  ///< of differences by the state

  friend void PrintTo(const Mechanism& mechanism, std::ostream* out) { *out << mechanism.name; }
};

std::shared_ptr<const Model> random_model(unsigned seed, const std::function<void(RandomOptions&)>& set) {
  RandomOptions options;
  options.springs = options.damping = options.loads = true;
  set(options);
  return random_mechanism(seed, options).model;
}

/// A four-bar with inputs of both kinds, controllers, blocks, actuators, a bushing with a branch, a drive
/// that follows an input, a spring whose law takes one.
std::shared_ptr<const Model> driven_four_bar() {
  std::string text = four_bar_text({{"rocker", ", cut: always, spring: {stiffness: 4, damping: 0.2}"}});
  text.insert(text.find("joints:"), "  fan: {mass: 0.1, com: [0.6, 0, 0.3], inertia: [1e-4, 1e-4, 1e-4]}\n");
  return model_of(text + R"yaml(
  fan: {type: revolute, between: [rocker, fan], at: [0.6, 0, 0.3], axis: [0, 1, 0], drive: {speed: "3*gust"}}
inputs:
  wanted: {start: 0.2, range: [-1, 1]}
  wind: {start: 1, hold: linear}
signals:
  error: wanted - angle
  lift: {value: "2*height", every: 0.015}
  angle: {joint: crank}
  rate: {joint_velocity: crank}
  rock: {joint: rocker}
  height: {position: coupler, component: z}
  gust: {transfer_function: wind, numerator: [1], denominator: [2e-4, 0.02, 1]}
  servo: {pid: angle, setpoint: wanted, kp: 20, ki: 30, kd: 0.5, filter: 0.004, upper: 40, lower: -40}
  held: {pid: rock, setpoint: wanted, kp: 20, ki: 300, upper: 0.1, lower: -0.1}
  two: {state_space: [rock, rate], A: [[0, 1], [-40, -3]], B: [[1, 0], [2, 1]], C: [[1, 0], [3, 1]], D: [[0, 1], [0, 0]], outputs: [a, b]}
  slow: {rate_limit: "3*angle", rising: 2}
  late: {delay: rock, time: 0.013}
  later: {delay: rock, time: 0.004}
  relay: {hysteresis: rock, rises_at: 0.1, falls_at: -0.1}
  curve: {table: 3*rock, points: [[-1, 2], [0, 1], [1, 3], [2, 0]], interpolation: cubic}
  map: {table: [angle, rate], x: [-1, 0, 1], y: [-2, 0.5, 3], values: [[1, 2, 0], [3, 1, 2], [0, 4, 1]]}
  around: {transfer_function: "rock - 3*around", numerator: [2], denominator: [0.1, 1]}
actuators:
  motor: {joint: crank, torque: "20*error*(1 + error*wind) - 2*rate"}
  brake: {joint: rocker, torque: "-0.5*rock + late + later*curve + 0.3*relay + 0.1*around"}
  second: {joint: crank, torque: "servo + held + two.a*0.1 + 0.2*two.b + slow + map"}
  piston: {between: [ground, coupler], at: [[0.3, 0, 0.9], [0.3, 0, 0.35]], force: "lift + wind"}
  twist: {between: [ground, rocker], at: [1, 0, 0], about: [0, 1, 0], torque: "0.1*sin(9*t)"}
bushings:
  mount:
    between: [crank, coupler]
    at: [0.1, 0, 0.3]
    stiffness: [40, 40, 60, 1, 1, 1]
    damping: [1, 1, 1, 0.1, 0.1, 0.1]
    maxwell: [{stiffness: [50, 30, 20, 1, 1, 1], relaxation: 0.03}]
frictions: {rub: {joint: crank, torque: "2 + wind", static_ratio: 1.4, stribeck: 0.3, sticking: 0.3}}
stops: {end: {joint: crank, lower: -0.05, upper: 0.05, stiffness: 300, exponent: 1.5, depth: 0.1, restitution: 0.5}}
gas_springs:
  strut: {between: [ground, rocker], at: [[1, 0, 0.9], [0.8, 0, 0.3]], pressure: 2e4, area: 1e-3, length: 0.6, exponent: 1.3, gas_length: 0.4, damping: 2}
springs:
  tuned: {between: [ground, rocker], at: [[1, 0, 0.4], [0.6, 0, 0.3]], elastic: "30*(l - 0.3)", damping: "0.1*v*wind"}
)yaml");
}

/// Wheels that lean, steer, slip and brake on roads of all kinds.
std::shared_ptr<const Model> wheels_on_roads() {
  return model_of(R"yaml(
bodies:
  a: {mass: 20, com: [0, 0, 0.31], inertia: [0.5, 0.9, 0.5]}
  b: {mass: 20, com: [0.97, 0.4, 0.32], inertia: [0.5, 0.9, 0.5]}
  c: {mass: 20, com: [3, 0, 0.29], inertia: [0.5, 0.9, 0.5]}
  d: {mass: 20, com: [0.3, 1.2, 0.3], inertia: [0.5, 0.9, 0.5]}
  e: {mass: 20, com: [0.5, -0.8, 0.3], inertia: [0.5, 0.9, 0.5]}
joints:
  a: {type: floating, between: [ground, a], at: [0, 0, 0.31], velocity: [10, 0.3, 0, 0.1, 33, 0.2]}
  b: {type: floating, between: [ground, b], at: [0.97, 0.4, 0.32], velocity: [10, -0.5, 0, 0.1, 30, 0.2]}
  c: {type: floating, between: [ground, c], at: [3, 0, 0.29], velocity: [1, 0, 0, 0, 3, 0]}
  d: {type: floating, between: [ground, d], at: [0.3, 1.2, 0.3], velocity: [12, 0.4, 0, 0.1, 37, 0.2]}
  e: {type: floating, between: [ground, e], at: [0.5, -0.8, 0.3], velocity: [11, 0.6, 0, 0.1, 36, 0.2]}
roads:
  hills: {over: grid, origin: [-2, -2], spacing: [1, 1], heights: [[0, 0, 0, 0, 0.1], [0, 0.1, 0, 0.05, 0], [0, 0, 0.03, 0, 0], [0.1, 0, 0.02, 0, 0.1]]}
  step: {over: distance, points: [[0, 0], [1, 0], [1, 0.02], [2, 0.03]], patches: [{x: [0.8, 1.2], friction: 0.5}]}
  rig: {over: time, points: [[0, 0], [1, 0.1]]}
tyres:
  a: {on: a, road: hills, model: brush, stiffness: 2e4, damping: 30, radius: 0.33, longitudinal_stiffness: 6e3, cornering_stiffness: 4e3, friction: 0.9, longitudinal_relaxation: 0.3, lateral_relaxation: 0.5, half_length: 0.08, load: 400, rolling_resistance: 0.02}
  b: {on: b, road: step, axis: [0.1, 1, 0.05], model: magic_formula, file: )yaml" +
                  tyre_path("car_205_60R15_61.tir") + R"yaml(}
  d: {on: d, road: hills, axis: [0, 1, -0.04], model: magic_formula, file: )yaml" +
                  tyre_path("car_52.tir") + R"yaml(}
  e: {on: e, road: hills, model: tmeasy, stiffness: 2e4, damping: 30, radius: 0.33, longitudinal_stiffness: 9e3, longitudinal_peak: 420, longitudinal_peak_slip: 0.1, longitudinal_sliding: 380, longitudinal_sliding_slip: 0.5, cornering_stiffness: 7e3, lateral_peak: 400, lateral_peak_slip: 0.15, lateral_sliding: 370, lateral_sliding_slip: 0.6, longitudinal_peak_growth: 1.7, lateral_peak_growth: 1.6, longitudinal_relaxation: 0.3, lateral_relaxation: 0.5, half_length: 0.08, load: 400, rolling_resistance: 0.02}
  c: {on: c, road: rig, model: brush, stiffness: 2e4, radius: 0.33, longitudinal_stiffness: 6e3, cornering_stiffness: 4e3, friction: 0.9, longitudinal_relaxation: 0.3, lateral_relaxation: 0.5, half_length: 0.08}
)yaml");
}

/// Wheels that roll without slip on a road over a grid, upright, leaning, a disc and a ball.
std::shared_ptr<const Model> wheels_that_roll() {
  return model_of(R"yaml(
bodies:
  a: {mass: 20, com: [0.1, 0.1, 0.33], inertia: [0.5, 0.9, 0.5]}
  b: {mass: 20, com: [1.2, 0.4, 0.3], inertia: [0.5, 0.9, 0.5]}
  c: {mass: 20, com: [2.2, 0.3, 0.3], inertia: [0.7, 0.7, 0.7]}
joints:
  a: {type: floating, between: [ground, a], at: [0.1, 0.1, 0.33]}
  b: {type: floating, between: [ground, b], at: [1.2, 0.4, 0.3]}
  c: {type: floating, between: [ground, c], at: [2.2, 0.3, 0.3]}
roads:
  hills: {over: grid, origin: [-2, -2], spacing: [1, 1], heights: [[0, 0, 0, 0, 0.1, 0], [0, 0.1, 0, 0.05, 0, 0.1], [0, 0, 0.03, 0, 0, 0], [0.1, 0, 0.02, 0, 0.1, 0], [0, 0, 0.1, 0, 0, 0.1]]}
constraints:
  a_rim: {type: rolling_on_road, on: a, road: hills, at: [0.1, 0.1, 0.33], axis: [0, 1, 0.1], radius: 0.33, crown: 0.1}
  b_rim: {type: rolling_on_road, on: b, road: hills, at: [1.2, 0.4, 0.3], axis: [0.3, 1, 0.4], radius: 0.3}
  c_rim: {type: rolling_on_road, on: c, road: hills, at: [2.2, 0.3, 0.3], axis: [0, 1, 0], radius: 0.3, crown: 0.3}
)yaml");
}

class ScalarCore : public testing::TestWithParam<Mechanism> {};

TEST_P(ScalarCore, LanesAreStepsOfNumbers) {
  const std::shared_ptr<const Model> model = GetParam().model();
  for (unsigned seed = 1; seed <= 3; ++seed) expect_lanes_are_steps(model->compiled(), seed, GetParam().size);
}

TEST_P(ScalarCore, DerivativesByTheState) {
  const std::shared_ptr<const Model> model = GetParam().model();
  for (unsigned seed = 1; seed <= 3; ++seed)
    expect_derivatives(model->compiled(), seed, GetParam().size, By::state, {GetParam().width});
}

TEST_P(ScalarCore, DerivativesByInputsAndNumbers) {
  const std::shared_ptr<const Model> model = GetParam().model();
  for (const By by : {By::input, By::number})
    for (unsigned seed = 1; seed <= 3; ++seed)
      expect_derivatives(model->compiled(), seed, GetParam().size, by);
}

INSTANTIATE_TEST_SUITE_P(
    Mechanisms, ScalarCore,
    testing::Values(
        Mechanism{"driven_four_bar", driven_four_bar, 0.2},
        Mechanism{"geared_four_bar", geared_four_bar, 0.2},
        Mechanism{"every_constraint", every_constraint, 0.1},
        Mechanism{"wheels_that_roll", wheels_that_roll, 0.02}, Mechanism{"die_and_ball", die_and_ball, 0.005},
        Mechanism{"car", [] { return example("iltis/vehicle.yaml"); }, 0.02},
        Mechanism{"tree", [] { return random_model(3, [](RandomOptions& o) { o.flexible_share = 0; }); },
                  0.5},
        Mechanism{"loops",
                  [] {
                    return random_model(5, [](RandomOptions& o) {
                      o.flexible_share = 0;
                      o.loops = 3;
                      o.drives = true;
                    });
                  },
                  0.5},
        Mechanism{"flexible_bodies",
                  [] {
                    return random_model(7, [](RandomOptions& o) {
                      o.flexible_share = 0.8;
                      o.loops = 1;
                      o.tyres = true;
                    });
                  },
                  0.3},
        Mechanism{"foreshortening",
                  [] {
                    return random_model(8, [](RandomOptions& o) {
                      o.flexible_share = 1;
                      o.stiffening = fe::Stiffening::foreshortening;
                    });
                  },
                  0.2},
        Mechanism{"nonlinear_stiffness",
                  [] {
                    return random_model(9, [](RandomOptions& o) {
                      o.flexible_share = 1;
                      o.stiffening = fe::Stiffening::nonlinear_stiffness_2;
                    });
                  },
                  0.2},
        Mechanism{"absolute_nodal_coordinates",
                  [] {
                    return example("spin-up-beam/beam-2d.yaml", {{"method", "ancf"}});
                  },
                  0.001},
        // Its stresses change by more than what bends it over a wider difference.
        Mechanism{
            "thick_absolute_nodal_coordinates",
            [] {
              return example("spin-up-beam/beam-3d.yaml", {{"method", "ancf_thick"}, {"elements", "3"}});
            },
            1e-5, 5e-6},
        Mechanism{
            "cable_of_absolute_nodal_coordinates",
            [] {
              return example("spin-up-beam/beam-3d.yaml", {{"method", "ancf_cable"}, {"elements", "4"}});
            },
            0.001}),
    [](const auto& mechanism) { return mechanism.param.name; });

/// A law that users write for numbers: of lanes one after the other; of dual numbers its force has the
/// derivative that its tangents say.
std::shared_ptr<const Model> four_bar_with_users_law() {
  spec::Model model = driven_four_bar()->spec();
  auto law = std::make_shared<spec::UserLaw>();
  law->states = {0.3};
  law->evaluate = [](spec::LawCall& call) {
    const double x = call.x[0], v = call.v[0];
    call.force[0] = 50 * x * x + 2 * v + 3 * call.states[0] * call.signals[0];
    call.stiffness[0] = 100 * x;
    call.damping[0] = 2;
    call.next[0] = call.states[0] + call.step * x;
  };
  spec::Element element;
  element.name = "own";
  element.law = "user";
  element.user = law;
  element.frame_a = model.springs.front().frame_a;
  element.frame_b = model.springs.front().frame_b;
  element.arguments = {{spec::Source::Kind::input, 0}};
  model.elements.push_back(element);
  return Model::compile(std::move(model));
}

TEST(ScalarCoreOfWheels, LanesAreStepsOfNumbers) {
  for (unsigned seed = 1; seed <= 3; ++seed)
    expect_lanes_are_steps(wheels_on_roads()->compiled(), seed, 0.005);
}

TEST(ScalarCoreOfWheels, DerivativesByTheState) {
  const std::shared_ptr<const Model> model = wheels_on_roads();
  for (unsigned seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(seed);
    expect_derivatives(model->compiled(), seed, 0.005, By::state, {4e-4, 4e-5, 4e-6});
  }
}

TEST(ScalarCoreOfWheels, DerivativesByNumbers) {
  for (unsigned seed = 1; seed <= 3; ++seed)
    expect_derivatives(wheels_on_roads()->compiled(), seed, 0.005, By::number);
}

TEST(ScalarCoreOfUsersLaws, LanesAreStepsOfNumbers) {
  const std::shared_ptr<const Model> model = four_bar_with_users_law();
  for (unsigned seed = 1; seed <= 3; ++seed) expect_lanes_are_steps(model->compiled(), seed, 0.2);
}

TEST(ScalarCoreOfUsersLaws, ForceHasTheDerivativeOfItsTangents) {
  const std::shared_ptr<const Model> model = four_bar_with_users_law();
  const Compiled& m = model->compiled();
  const ElementData& e = m.elements.back();
  std::vector<double> storage(static_cast<std::size_t>(m.element_storage));
  std::vector<Dual> dual(storage.size());
  ElementState<Dual> s = element_state(e, dual.data());
  std::vector<Dual> signals(static_cast<std::size_t>(m.signals.slots), Dual(0.7)),
      states(static_cast<std::size_t>(e.state_count), Dual(0.3));
  s.x[0] = Dual(0.4, 2);
  s.v[0] = Dual(-0.1, 5);
  const std::vector<Dual> numbers(m.numbers.begin(), m.numbers.end());
  forces::user_law(LawContext<Dual>{m, e, 0.0, signals.data(), states.data(), 0.01, numbers.data()}, s);
  EXPECT_NEAR(s.force[0].value, 50 * 0.16 - 0.2 + 3 * 0.3 * 0.7, 1e-14);
  EXPECT_NEAR(s.force[0].derivative, 100 * 0.4 * 2 + 2 * 5, 1e-14);
  // How it varies with a signal the law does not say.
  signals[static_cast<std::size_t>(m.arguments[static_cast<std::size_t>(e.arguments)])].derivative = 1;
  forces::user_law(LawContext<Dual>{m, e, 0.0, signals.data(), states.data(), 0.01, numbers.data()}, s);
  EXPECT_TRUE(std::isnan(s.force[0].derivative));
}

}  // namespace
}  // namespace mimbre::test::scalar_core_test
