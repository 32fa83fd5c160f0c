#include "analysis/linear_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/linear_turning.h"
#include "compile/element_name.h"
#include "joints/joint_kind.h"
#include "math/once/decompositions.h"
#include "simulation/observe/channels.h"
#include "simulation/watch/validity.h"

namespace mimbre::linear {

using Eigen::VectorXd;

namespace {

// Shares of the mechanism's scales.
constexpr double balanced = 1e-6;  ///< of accelerations: none
/// Of the accelerations that displacements by the mechanism's size bring about: round-off of what balances.
constexpr double nothing_moves = 1e-13;
/// Of what the largest force would accelerate by itself: what is left of forces that balance.
constexpr double cancelled = 1e-8;
constexpr double constant = 1e-7;  ///< of coefficients: they do not vary

std::string with_number(const std::string& name, int count, int k) {
  return count > 1 ? fmt::format("{}.{}", name, k) : name;
}

LinearName state_label(const Compiled& m, const std::vector<LinearElement>& elements, const Parameter& p) {
  using Kind = Parameter::Kind;
  if (p.kind == Kind::element_state) {
    const LinearElement& e = elements[static_cast<std::size_t>(p.item)];
    return {with_number(
                fmt::format("state of {}", element_name(m, m.elements[static_cast<std::size_t>(e.element)])),
                static_cast<int>(e.states.size()), p.index),
            ""};
  }
  if (p.kind == Kind::block_state)
    return {with_number(
                fmt::format("state of signal '{}'", m.spec().blocks[static_cast<std::size_t>(p.item)].name),
                m.signals.blocks[static_cast<std::size_t>(p.item)].states, p.index),
            ""};
  const int slot = m.signals.integrals[static_cast<std::size_t>(p.item)].slot;
  for (std::size_t j = 0; j < m.signals.slot_of_drive.size(); ++j)
    for (const int other : m.signals.slot_of_drive[j])
      if (other == slot)
        return {fmt::format("angle or way of the drive of joint '{}'", m.spec().joints[j].name), ""};
  return {fmt::format("integral {}", p.item + 1), ""};
}

LinearName input_label(const Compiled& m, const Parameter& p) {
  const spec::Input& input = m.spec().inputs[static_cast<std::size_t>(p.item)];
  if (p.kind == Parameter::Kind::input) return {input.name, input.unit};
  return p.kind == Parameter::Kind::input_rate ? LinearName{"d/dt " + input.name, input.unit + "/s"}
                                               : LinearName{"d²/dt² " + input.name, input.unit + "/s²"};
}

/// By how much A differs a little further along the motion, of its largest entry: 0 where the mechanism moves
/// through no other shapes. In each of several axes.
std::vector<double> variation(const Compiled& m, const relative::RelativeSystem& system, const Linearised& at,
                              const std::vector<TurnedAxes>& choices) {
  std::vector<double> out(choices.size(), 1);
  const double speed = system.scales().of_coordinates(at.state.v.data());
  const double dt = 0.37 / speed;
  Linearised next;
  try {
    next = linearised_later(m, system, at, dt);
  } catch (const std::runtime_error&) {
    return out;
  }
  if (next.reduced.A.rows() != at.reduced.A.rows()) return out;
  const double size = at.reduced.A.cwiseAbs().maxCoeff();
  if (!(size > 0)) return std::vector<double>(choices.size(), 0);
  for (std::size_t k = 0; k < choices.size(); ++k) out[k] = change_in_axes(choices[k], at, dt, next) / size;
  return out;
}

void name_variables(const Compiled& m, Linearised& out) {
  LinearModel& names = out.names;
  names.title = m.spec().title;
  names.time = out.state.time;
  names.coordinates = out.reduced.coordinates;
  names.speeds = out.reduced.speeds;
  for (const int k : out.independent) names.states.push_back(coordinate_label(m, k));
  for (const int k : out.moving) {
    const LinearName label = coordinate_label(m, k);
    names.states.push_back({"d/dt " + label.name, label.unit + "/s"});
  }
  for (int k = 0; k < out.reduced.states; ++k)
    names.states.push_back(state_label(m, out.elements, out.parameters[static_cast<std::size_t>(k)]));
  for (int k = 0; k < out.reduced.inputs; ++k) {
    const Parameter& p = out.parameters[static_cast<std::size_t>(out.reduced.states + k)];
    names.inputs.push_back(input_label(m, p));
    names.input_values.push_back(p.kind == Parameter::Kind::input ? held_input_value(m, p.item, out.state)
                                                                  : 0);
  }
}

/// How much a coordinate accelerates where another is displaced by the mechanism's size, 1/s².
double stiffness_at(int coordinate, const Scales& scales, const Linearised& out) {
  double most = 0;
  for (std::size_t k = 0; k < out.independent.size(); ++k)
    most = std::max(most, std::abs(out.reduced.acceleration(coordinate, static_cast<Eigen::Index>(k))) *
                              scales.coordinates[static_cast<std::size_t>(out.independent[k])]);
  return most / scales.coordinates[static_cast<std::size_t>(coordinate)];
}

/// Calls each(element, its ends, its state) of all whose force acts, after a residual.
template <class Each>
void for_forces(const Compiled& m, relative::Workspace<double>& w, Each&& each) {
  for (const ElementData& e : m.elements) {
    const ElementEnds ends = ends_of(m, e, w.signals.states + e.states);
    if (e.measure == Measure::sum || (e.body < 0 && ends.frame_b < 0)) continue;
    each(e, ends, element_state(e, w.elements.data()));
  }
}

/// The rate of what a component of a force works along, after kinematics.
double rate_along(const relative::Workspace<double>& w, const ElementData& e, const ElementEnds& ends,
                  const ElementState<double>& s, int k) {
  const Motion<double>& b = w.frames[ends.frame_b];
  Vec3d velocity = b.velocity, spin = b.omega;
  if (ends.frame_a >= 0) {
    const Motion<double>& a = w.frames[ends.frame_a];
    velocity -= a.velocity + a.omega.cross(b.position - a.position);
    spin -= a.omega;
  }
  return s.linear_of(k).dot(velocity) + (has_moment(e.measure) ? s.angular_of(k).dot(spin) : 0);
}

/// The largest acceleration, 1/s², that one force element would bring about by itself: where forces balance
/// they are at play, though nothing accelerates.
double acceleration_by_forces(const Compiled& m, relative::RelativeSystem& system, const Linearised& at) {
  const State& s = at.state;
  const int speeds = at.reduced.speeds;
  if (speeds == 0) return 0;
  const MatrixXd motions = at.reduced.velocity.middleCols(at.reduced.coordinates, speeds);
  const VectorXd still = VectorXd::Zero(m.velocities);
  VectorXd r(m.velocities);
  system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  auto& w = system.workspace();
  int components = 0;
  for_forces(m, w, [&](const ElementData& e, const ElementEnds&, const ElementState<double>&) {
    components += e.body >= 0 ? 1 : e.count;
  });
  MatrixXd works(speeds, components);
  for (int j = 0; j < speeds; ++j) {
    const VectorXd v = motions.col(j);
    system.kinematics(s.time, s.q.data(), v.data(), still.data());
    int column = 0;
    for_forces(m, w, [&](const ElementData& e, const ElementEnds& ends, const ElementState<double>& state) {
      if (e.body >= 0) {
        works(j, column++) = state.force[0] * v[e.v];
        return;
      }
      for (int k = 0; k < state.count; ++k)
        works(j, column++) = state.force[k] * rate_along(w, e, ends, state, k);
    });
  }
  const MatrixXd accelerations = motions * solve(at.reduced.mass, works);
  double most = 0;
  for (Eigen::Index k = 0; k < accelerations.cols(); ++k)
    most = std::max(most, system.scales().of_coordinates(accelerations.col(k).data()));
  return most;
}

/// What moves fastest, and how far the motion is from a steady one.
void name_fastest(const Compiled& m, relative::RelativeSystem& system, Linearised& out) {
  const Scales& scales = system.scales();
  LinearModel& names = out.names;
  const State& s = out.state;
  int where = -1;
  names.speed = scales.of_coordinates(s.v.data(), &where);
  if (where >= 0) names.fastest = coordinate_label(m, where).name;
  where = -1;
  VectorXd unsteady = s.a;
  if (out.trimmed) unsteady -= out.steady_accelerations;
  const double most = scales.of_coordinates(unsteady.data(), &where), rate = names.speed;
  const double play = std::max({scales.accelerations(s.a.data()), rate * rate});
  names.unsteady = play > 0 ? most / play : 0;
  if (where >= 0 && most <= nothing_moves * stiffness_at(where, scales, out)) names.unsteady = 0;
  if (names.unsteady > balanced && most <= cancelled * acceleration_by_forces(m, system, out))
    names.unsteady = 0;
  if (where >= 0) {
    names.accelerated = coordinate_label(m, where).name;
    names.acceleration = std::abs(unsteady[where]);
  }
}

/// Axes of steady driving. On a plane nothing depends on where the mechanism is and where it heads.
void turn_with_the_circle(const Compiled& m, const Scales& scales, Linearised& out) {
  Turning turning;
  turning.speed = std::abs(out.yaw_rate);
  turning.axis = out.yaw_rate < 0 ? Vec3d(-out.up) : out.up;
  if (!(turning.speed * m.length_scale > still * scales.of_coordinates(out.state.v.data()))) return;
  out.axes = axes_that_turn(m, turning);
  out.names.notes.push_back(fmt::format(
      "the mechanism drives around a circle with {:.6g} rad/s: A is that of the instant; modes are "
      "those in axes that turn with it, where A is constant on a level road",
      out.yaw_rate));
}

/// Whether a stiffness acts along coordinates of these vectors.
bool holds(const Linearised& at, const TurnedAxes& axes) {
  const MatrixXd& K = at.reduced.stiffness;
  if (K.size() == 0 || K.rows() != K.cols()) return false;
  const double none = 1e-9 * K.cwiseAbs().maxCoeff();
  for (const TurnedVector& x : axes)
    for (std::size_t k = 0; k < at.independent.size(); ++k) {
      const int off = at.independent[k] - x.first;
      if (off >= 0 && off < 3 && K.col(static_cast<Eigen::Index>(k)).cwiseAbs().maxCoeff() > none)
        return true;
    }
  return false;
}

/// Axes of any other steady motion in which the coefficients are constant, or the warning that there are
/// none.
void find_constant_axes(const Compiled& m, relative::RelativeSystem& system, Linearised& out) {
  LinearModel& names = out.names;
  const State& s = out.state;
  system.kinematics(s.time, s.q.data(), s.v.data(), s.a.data());
  const Turning turning = find_turning(m, system);
  const std::vector<TurnedAxes> choices{{}, axes_that_turn(m, turning), axes_before_joints(m, s.v)};
  const std::vector<double> varies = variation(m, system, out, choices);
  // Of coordinates some may turn and some may not: where something holds those, axes that turn come before.
  auto best = std::find_if(varies.begin(), varies.end(), [](double by) { return by <= constant; });
  if (best == varies.begin() && varies[1] <= constant && holds(out, choices[1])) ++best;
  names.varies = varies.front();
  if (best == varies.end()) {
    if (names.varies > constant)
      names.warnings.push_back(fmt::format(
          "{}, by {:.2g} of the largest after 0.37 rad or as much of its size: eigenvalues of one "
          "instant do not decide what happens over a period",
          varying, names.varies));
    else
      names.varies = 0;
    return;
  }
  names.varies = 0;
  out.axes = choices[static_cast<std::size_t>(best - varies.begin())];
  const bool turns = best - varies.begin() < 2 && turning.speed > 0;
  if (turns) {
    out.turning = turning.speed;
    out.turning_axis = turning.axis;
    out.turning_place = turning.place;
  }
  if (!out.axes.empty())
    names.notes.push_back(
        turns ? fmt::format("the mechanism turns as a whole with {:.6g} rad/s: A is that of the instant; "
                            "modes are those in axes that turn with it, where A is constant",
                            turning.speed)
              : "A is that of the instant, in axes of bodies that turn; modes are those in axes that do not "
                "turn with them, where A is constant");
}

/// Blocks that still move, elements whose derivatives or states are not exact, and sampled signals.
void name_what_is_approximate(const Compiled& m, double pace, Linearised& out) {
  LinearModel& names = out.names;
  for (Eigen::Index k = 0; k < out.state_rates.size(); ++k)
    if (out.parameters[static_cast<std::size_t>(k)].kind == Parameter::Kind::block_state &&
        std::abs(out.state_rates[k]) > 1e-6 * pace)
      names.warnings.push_back(fmt::format(
          "the {} still moves, by {:.3g} per s",
          names.states[static_cast<std::size_t>(out.reduced.first_state() + k)].name, out.state_rates[k]));
  for (const LinearElement& e : out.elements) {
    const ElementData& data = m.elements[static_cast<std::size_t>(e.element)];
    const std::string name = element_name(m, data);
    if (e.by_differences)
      names.notes.push_back(fmt::format("{} is a law of the user: its derivatives are differences{}", name,
                                        data.sampled ? ", as if it were called at every instant" : ""));
    if (!e.settled)
      names.warnings.push_back(fmt::format("{}: its states have no rates that converge with the step", name));
  }
  const auto held = [&](const std::string& name, double every) {
    if (every > 0)
      names.notes.push_back(fmt::format(
          "the signal '{}' is sampled every {} s: it is held, as between two instants", name, every));
  };
  for (const spec::Block& b : m.spec().blocks) held(b.name, b.every);
  for (const spec::Signal& b : m.spec().signals)
    if (b.block < 0) held(b.name, b.every);
}

/// What linear flexible bodies neglect at the point, as in a run: stiffening by rotation above all.
void check_validity(const Compiled& m, relative::RelativeSystem& system, Linearised& out) {
  ValidityMonitor monitor(m);
  if (monitor.empty()) return;
  const State& s = out.state;
  VectorXd r(m.velocities);
  monitor.start(s, s);
  // Amplitudes of round-off have no shape.
  double deflection = 0;
  for (const BodyData& b : m.bodies)
    for (int k = 0; k < b.modes; ++k)
      deflection =
          std::max(deflection,
                   std::abs(s.q[b.q + b.joint_positions + k]) /
                       system.scales().coordinates[static_cast<std::size_t>(b.v + b.joint_velocities + k)]);
  if (deflection > 1e-6) monitor.watch_instant(s);
  system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  monitor.watch_loads(system.workspace(), s.time);
  for (std::string& warning : monitor.warnings()) out.names.warnings.push_back(std::move(warning));
}

}  // namespace

double pace_of(const System& system, const VectorXd& v) {
  const Scales& scales = system.scales();
  const double pace = std::max(scales.rate(v.data()), scales.of_coordinates(v.data()));
  return pace > 0 ? pace : 1;
}

double work_of_forces(const Compiled& m, relative::RelativeSystem& system, const State& s) {
  const VectorXd still = VectorXd::Zero(m.velocities), none = VectorXd::Zero(m.equations);
  VectorXd r(m.velocities);
  system.residual(s.time, s.q.data(), still.data(), still.data(), none.data(), 0, r.data());
  double most = 0;
  for_forces(m, system.workspace(),
             [&](const ElementData& e, const ElementEnds&, const ElementState<double>& state) {
               if (e.body >= 0) {
                 const double scale = system.scales().coordinates[static_cast<std::size_t>(e.v)];
                 most = std::max(most, std::abs(state.force[0]) * scale);
                 return;
               }
               for (int k = 0; k < state.count; ++k) {
                 const double arm = state.linear_of(k).norm() * m.length_scale +
                                    (has_moment(e.measure) ? state.angular_of(k).norm() : 0);
                 most = std::max(most, std::abs(state.force[k]) * arm);
               }
             });
  return most;
}

LinearName coordinate_label(const Compiled& m, int coordinate) {
  for (const BodyData& b : m.bodies) {
    const int k = coordinate - b.v;
    if (k < 0 || k >= b.size()) continue;
    if (k >= b.joint_velocities)
      return {fmt::format("{}.mode{}", m.spec().bodies[static_cast<std::size_t>(b.spec)].name,
                          k - b.joint_velocities + 1),
              m.flexible[b.flexible].identity_mass ? "m kg^0.5" : "1"};
    return {with_number(m.spec().joints[static_cast<std::size_t>(b.joint_spec)].name, b.joint_velocities, k),
            is_angle(b.joint, k) ? "rad" : "m"};
  }
  return {"?", ""};
}

void describe(const Compiled& m, relative::RelativeSystem& system, Linearised& out) {
  const Scales& scales = system.scales();
  LinearModel& names = out.names;
  name_variables(m, out);
  name_fastest(m, system, out);
  const double pace = pace_of(system, out.state.v);
  const bool rests = names.speed <= still * pace, steady = names.unsteady <= balanced;
  if (!steady)
    names.warnings.push_back(
        fmt::format("the point is {}: '{}' accelerates by {:.3g}, {:.2g} of the accelerations at play",
                    rests ? "no equilibrium" : "no steady motion", names.accelerated, names.acceleration,
                    names.unsteady));
  else if (out.trimmed)
    turn_with_the_circle(m, scales, out);
  else if (!rests)
    find_constant_axes(m, system, out);
  name_what_is_approximate(m, pace, out);
  check_validity(m, system, out);
}

}  // namespace mimbre::linear
