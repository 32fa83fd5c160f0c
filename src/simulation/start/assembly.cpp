#include "simulation/start/assembly.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "dynamics/modal_scale.h"
#include "dynamics/natural/column_groups.h"
#include "dynamics/relative/forces.h"
#include "dynamics/turns.h"
#include "forces/measure_wheel.h"
#include "integrate/initial.h"
#include "integrate/sparse_statics.h"
#include "joints/joint_kind.h"
#include "mimbre/diagnostics.h"
#include "simulation/describe/explain.h"
#include "simulation/step/signal_state.h"

namespace mimbre {
namespace {

constexpr double close_enough = 1e-8;  ///< of the equations' scales
constexpr double alike = 1e-8;         ///< of the length scale, of how carcasses bend
/// Of the largest bend: a change that small, and that is no smaller than this much of the one before, is that
/// of a road which is no plane, under a car that comes down a slope.
constexpr double little_of_bend = 0.01, hardly_smaller = 0.9;
constexpr int most_rounds = 30;
/// Coordinates up to which dense matrices are tried first, and up to which these are fast.
constexpr int most_dense_unknowns = 150, few_unknowns = 60;
constexpr int many_steps = 400, few_steps = 60;
constexpr double most_wound = 1e5;  ///< rad, from the drawn position to the given one
/// How readily the softest mode moves against joints, and the stiffest ones at least against that.
constexpr double readiest_mode = 1e-2, stiffest_mode = 1e-4;

/// How carcasses bend, m, and the largest change of that in the last round.
struct Bends {
  std::vector<double> values;
  double change = std::numeric_limits<double>::infinity();
};

int argmax(const Eigen::VectorXd& x) {
  int where = 0;
  x.cwiseAbs().maxCoeff(&where);
  return where;
}

/// The coordinate with the largest entry by the scales, of a vector along velocities.
int largest_by_scale(const System& system, const Eigen::VectorXd& x) {
  int where = -1;
  system.scales().of_coordinates(x.data(), &where);
  return where;
}

/// The sparse search in natural coordinates. Coordinates in the status are those of `observer`, but for those
/// of a search in the natural formulation, `of_natural`.
StaticsStatus find_sparse(natural::NaturalSystem& natural, relative::RelativeSystem& observer, State& s,
                          bool of_natural) {
  State n = natural_state(natural, observer, s);
  n.u = s.u;
  n.z = s.z;
  natural.enter(n.u.data(), n.z.data(), 0);
  const linalg::ColumnColours colours(natural.velocities(), natural::column_groups(natural.layout()));
  Eigen::VectorXd growing;
  StaticsStatus status = find_sparse_equilibrium(natural, colours, n, &growing);
  if (growing.size() > 0 && !of_natural) {
    State moving = n, as_relative = s;
    moving.v = growing;
    natural.to_relative(moving, as_relative);
    status.growing = largest_by_scale(observer, as_relative.v);
  }
  natural.to_relative(n, s);
  s.z = n.z;
  natural.enter(s.u.data(), s.z.data(), 0);
  observer.begin_step(s.q.data());
  find_multipliers(observer, s, 1e-9);
  if (!status.converged && !of_natural) {
    Eigen::VectorXd r(observer.velocities());
    observer.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
    const Eigen::VectorXd work =
        r.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(observer.scales().coordinates.data(), r.size()));
    if (work.size() > 0) status.residual = std::abs(r[status.coordinate = argmax(work)]);
  }
  return status;
}

StaticsStatus find_dense(natural::NaturalSystem* natural, relative::RelativeSystem& observer, State& s,
                         int most_steps) {
  if (!natural) return find_equilibrium(observer, s, most_steps);
  State n = natural_state(*natural, observer, s);
  n.u = s.u;
  n.z = s.z;
  const StaticsStatus status = find_equilibrium(*natural, n, most_steps);
  natural->to_relative(n, s);
  s.z = n.z;
  natural->enter(s.u.data(), s.z.data(), 0);
  observer.begin_step(s.q.data());
  find_multipliers(observer, s, 1e-9);
  return status;
}

/// Small mechanisms by dense matrices, large ones by sparse ones; the latter also where the former find
/// nothing (soon, where they are slow).
StaticsStatus find_from_here(natural::NaturalSystem* natural, relative::RelativeSystem& observer, State& s) {
  const State start = s;
  const Compiled& m = observer.model();
  const int size = natural ? natural->velocities() : observer.velocities();
  // Natural coordinates, in which the sparse search works, have no bodies that bend by elastodynamics.
  if (std::any_of(m.bodies.begin(), m.bodies.end(), [](const BodyData& b) { return b.elastodynamic; }))
    return find_dense(natural, observer, s, many_steps);
  StaticsStatus dense;
  if (size <= most_dense_unknowns) {
    dense = find_dense(natural, observer, s, size <= few_unknowns ? many_steps : few_steps);
    if (dense.converged) return dense;
  }
  const State there = s;
  std::optional<natural::NaturalSystem> own;
  if (!natural) {
    try {
      own.emplace(observer.model());
    } catch (const InputError&) {
      s = start;
      return find_dense(natural, observer, s, many_steps);
    }
  }
  s = start;
  StaticsStatus sparse = find_sparse(natural ? *natural : *own, observer, s, natural != nullptr);
  sparse.iterations += dense.iterations;
  if (sparse.converged || size > most_dense_unknowns) return sparse;
  s = start;
  if (size > few_unknowns) return find_dense(natural, observer, s, many_steps);
  s = there;
  return dense;
}

/// Puts the footprints of wheels that stand in an equilibrium to where these are, so that their carcasses are
/// straight again; false, and nothing, where they bend as they did before, `bends`.
bool let_wheels_go(relative::RelativeSystem& observer, State& s, Bends& bends) {
  const Compiled& m = observer.model();
  observer.begin_step(s.q.data());
  observer.kinematics(s.time, s.q.data(), s.v.data(), s.a.data());
  Eigen::VectorXd generalised(m.velocities);
  relative::forces(m, observer.workspace(), s.time, s.q.data(), s.v.data(), s.a.data(), generalised.data());
  const auto each = [&](const auto& f) {
    for (const ElementData& e : m.elements)
      if (e.measure == Measure::wheel && s.z[e.states + wheel::stood] > 0)
        f(e, element_state(e, observer.workspace().elements.data()).states);
  };
  std::vector<double> now;
  each([&](const ElementData&, const double* states) {
    now.insert(now.end(), {states[wheel::bend], states[wheel::bend + 1]});
  });
  bends.values.resize(now.size(), 0.0);
  double largest = 0, change = 0;
  for (std::size_t k = 0; k < now.size(); ++k) {
    largest = std::max(largest, std::abs(now[k]));
    change = std::max(change, std::abs(now[k] - bends.values[k]));
  }
  if (change <= alike * m.length_scale ||
      (change <= little_of_bend * largest && change >= hardly_smaller * bends.change))
    return false;
  bends = {std::move(now), change};
  each([&](const ElementData& e, const double* states) {
    double* const z = s.z.data() + e.states;
    std::copy_n(states, e.state_count, z);
    z[wheel::bend] = z[wheel::bend + 1] = 0;
  });
  return true;
}

/// Energy of a mode at its scale, J.
double elastic_energy(const Compiled& m, const BodyData& b, int mode) {
  const double amplitude = modal_scale(m, b, mode);
  return 0.5 * m.flexible[b.flexible].stiffness(mode, mode) * amplitude * amplitude;
}

/// How readily coordinates move to close loops: by their scales, so that a length of the mechanism's size
/// counts as much as a radian in any unit. Modes follow far behind, the stiffer the less, so that what they
/// have to close they close with hardly more than the least elastic energy.
Eigen::VectorXd readiness(const relative::RelativeSystem& system) {
  const Compiled& m = system.model();
  Eigen::VectorXd ready =
      Eigen::Map<const Eigen::VectorXd>(system.scales().coordinates.data(), system.velocities());
  double softest = std::numeric_limits<double>::infinity();
  for (const BodyData& b : m.bodies)
    for (int k = 0; k < b.modes; ++k)
      if (const double energy = elastic_energy(m, b, k); energy > 0) softest = std::min(softest, energy);
  for (const BodyData& b : m.bodies)
    for (int k = 0; k < b.modes; ++k) {
      const double energy = elastic_energy(m, b, k), stiff = energy > softest ? energy / softest : 1;
      ready[b.v + b.joint_velocities + k] *= readiest_mode * std::max(1 / std::sqrt(stiff), stiffest_mode);
    }
  for (const BodyData& b : m.bodies)
    if (m.spec().joints[b.joint_spec].elastic) ready.segment(b.v, b.joint_velocities) *= readiest_mode;
  return ready;
}

/// Coordinates of the body that deform something elastic: first, count.
std::pair<int, int> elastic_coordinates(const Compiled& m, const BodyData& b) {
  const bool joint = m.spec().joints[b.joint_spec].elastic;
  return {joint ? b.v : b.v + b.joint_velocities, (joint ? b.joint_velocities : 0) + b.modes};
}

/// Sets what the user gave of a joint's positions and velocities; weights 0 mark given ones.
void set_given(const Compiled& m, SignalValues<double>& signals, State& s, Eigen::VectorXd& position_weight,
               Eigen::VectorXd& velocity_weight) {
  for (const BodyData& b : m.bodies) {
    const spec::Joint& joint = m.spec().joints[b.joint_spec];
    const JointInfo& info = joint_info(joint.type);
    // What is elastic starts straight and at rest unless the loops need it.
    const auto [elastic, count] = elastic_coordinates(m, b);
    position_weight.segment(elastic, count).setZero();
    velocity_weight.segment(elastic, count).setZero();
    if (info.quaternion >= 0) s.q[b.q + info.quaternion] = 1;
    Vec3d turn = Vec3d::Zero();
    const auto begin = [&](const std::vector<std::optional<double>>& values, bool is_fixed) {
      for (int k = 0; k < static_cast<int>(values.size()); ++k) {
        if (!values[k]) continue;
        if (is_fixed) position_weight[b.v + k] = 0;
        const bool rotation = info.quaternion >= 0 && k >= info.rotation;
        (rotation ? turn[k - info.rotation] : s.q[b.q + k]) = *values[k];
      }
    };
    begin(joint.near, false);
    begin(joint.initial_position, true);
    if (info.quaternion >= 0) s.q.segment<4>(b.q + info.quaternion) = quaternion_exp<double>(turn);
    for (int k = 0; k < static_cast<int>(joint.initial_velocity.size()); ++k) {
      if (!joint.initial_velocity[k]) continue;
      velocity_weight[b.v + k] = 0;
      s.v[b.v + k] = *joint.initial_velocity[k];
    }
  }
  fix_signals(m.signals, 0, signals);
  for (const DriveData& d : m.drives) {
    s.q[d.q] = signals.value[d.slot];
    s.v[d.v] = signals.rate[d.slot];
  }
}

/// Winds up what counts turns on the way from the drawn position to the given one, all joints together.
void wind_up(const Compiled& m, relative::RelativeSystem& system, State& s) {
  if (std::none_of(m.constraints.begin(), m.constraints.end(), counts_turns)) return;
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(m.velocities);
  Eigen::VectorXd drawn = Eigen::VectorXd::Zero(m.positions), way = rest, q = drawn;
  for (const BodyData& b : m.bodies) {
    const JointInfo& info = joint_info(b.joint);
    const int values = info.quaternion < 0 ? b.joint_velocities : info.rotation;
    way.segment(b.v, values) = s.q.segment(b.q, values);
    if (info.quaternion < 0) continue;
    drawn[b.q + info.quaternion] = 1;
    way.segment<3>(b.v + info.rotation) = quaternion_log<double>(s.q.segment<4>(b.q + info.quaternion));
  }
  double most = 0;  // rad, that one of them may be turned by
  for (const ConstraintData& c : m.constraints) {
    double turn = 0;
    if (counts_turns(c))
      for (const PathEntry& e : c.path.entries) {
        const BodyData& b = m.bodies[e.body];
        for (int k = 0; k < b.joint_velocities; ++k)
          if (is_angle(b.joint, k)) turn += std::abs(way[b.v + k]);
      }
    most = std::max(most, turn);
  }
  const int parts = static_cast<int>(std::ceil(std::min(most, most_wound)));
  for (int k = 1; k <= parts; ++k) {
    const Eigen::VectorXd x = (static_cast<double>(k) / parts) * way;
    system.retract(drawn.data(), x.data(), q.data());
    system.kinematics(0, q.data(), rest.data(), rest.data());
    keep_counted_turns(m, system.workspace().constraint_states.data(), s.z.data());
  }
}

}  // namespace

State given_state(const Compiled& m, relative::RelativeSystem& system,
                  const std::map<std::string, double>& inputs, Eigen::VectorXd& position_weight,
                  Eigen::VectorXd& velocity_weight) {
  State s;
  start_signals(m, inputs, s);
  system.enter(s.u.data(), s.z.data(), 0);
  s.q.setZero(m.positions);
  s.v.setZero(m.velocities);
  s.a.setZero(m.velocities);
  s.algorithmic.setZero(m.velocities);
  s.multipliers.setZero(m.equations);
  position_weight = velocity_weight = readiness(system);
  set_given(m, system.workspace().signals, s, position_weight, velocity_weight);
  return s;
}

State assembled_state(const Compiled& m, relative::RelativeSystem& system,
                      const std::map<std::string, double>& inputs) {
  Eigen::VectorXd position_weight, velocity_weight;
  State s = given_state(m, system, inputs, position_weight, velocity_weight);
  // What it was given lies where the state is now.
  system.enter(s.u.data(), s.z.data(), 0);
  system.begin_step(s.q.data());

  static constexpr std::string_view closing = "cannot be closed";
  // The equation that is furthest off by its scale.
  const auto where = [&](const double* violation, std::string_view what, std::string_view unit,
                         std::string_view angle_unit) {
    const std::vector<double>& scale = system.scales().equations;
    int worst = 0;
    const auto share = [&](int k) { return std::abs(violation[k]) / scale[static_cast<std::size_t>(k)]; };
    for (int k = 1; k < m.equations; ++k)
      if (!(share(k) <= share(worst))) worst = k;
    const double gap = std::abs(violation[worst]);
    const auto has = [&](const EquationRows& rows) {
      return worst >= rows.first_equation && worst < rows.first_equation + rows.count;
    };
    for (const LoopData& l : m.loops)
      if (has(l)) {
        const spec::Joint& j = m.spec().joints[l.joint_spec];
        const bool angle = l.closure[worst - l.first_equation].kind == LoopClosure::Kind::angle;
        return InputError(
            j.mark, fmt::format("the loop through joint '{}' {}: {:.3g} {} is left; check the points "
                                "and axes of the joints in the loop and the initial values that are given",
                                j.name, what, gap, angle ? angle_unit : unit));
      }
    for (const ConstraintData& c : m.constraints)
      if (has(c)) {
        const spec::Constraint& of = m.spec().constraints[c.spec];
        return InputError(
            of.mark,
            fmt::format(
                "constraint '{}' {}: {:.3g} {} is left; check what it joins, what else holds that, and "
                "the initial values that are given",
                of.name, what == closing ? "cannot be fulfilled" : what, gap,
                c.is_length(worst - c.first_equation) ? unit : angle_unit));
      }
    bool angle = false;
    for (const DriveData& d : m.drives)
      if (d.equation == worst) angle = is_angle(m.bodies[d.body].joint, d.local);
    return InputError({}, fmt::format("a driven joint contradicts the initial values: {:.3g} {} is left", gap,
                                      angle ? angle_unit : unit));
  };
  const auto let_bend = [&](Eigen::VectorXd& weight) {
    const Eigen::VectorXd all = readiness(system);
    for (const BodyData& b : m.bodies) {
      const auto [first, count] = elastic_coordinates(m, b);
      weight.segment(first, count) = all.segment(first, count);
    }
  };
  wind_up(m, system, s);
  const auto close = [&] {
    return close_positions(system, 0, position_weight, s.q, 0, 1e-13, [&] {
      keep_counted_turns(m, system.workspace().constraint_states.data(), s.z.data());
    });
  };
  double gap = close();
  if (gap > close_enough) {
    let_bend(position_weight);
    gap = close();
  }
  if (!(gap <= close_enough)) throw where(system.phi(), closing, "m", "rad");
  gap = close_velocities(system, 0, s.q, velocity_weight, s.v);
  if (gap > close_enough) {
    let_bend(velocity_weight);
    gap = close_velocities(system, 0, s.q, velocity_weight, s.v);
  }
  if (!(gap <= close_enough))
    throw where(system.phi_dot(), "contradicts the initial velocities", "m/s", "rad/s");
  // What elements remember counts from here on, in an equilibrium that is sought too.
  system.kinematics(s.time, s.q.data(), s.v.data(), s.a.data());
  Eigen::VectorXd generalised(m.velocities);
  relative::forces(m, system.workspace(), s.time, s.q.data(), s.v.data(), s.a.data(), generalised.data());
  commit_signals(m, system, s);
  system.enter(s.u.data(), s.z.data(), 0);
  return s;
}

std::unique_ptr<natural::NaturalSystem> make_natural(const Compiled& m, const Method& method) {
  if (method.formulation != spec::Simulation::Formulation::natural) return nullptr;
  return std::make_unique<natural::NaturalSystem>(m, method.inertia);
}

State natural_state(const natural::NaturalSystem& natural, relative::RelativeSystem& observer,
                    const State& s) {
  observer.begin_step(s.q.data());
  observer.kinematics(s.time, s.q.data(), s.v.data(), s.a.data());
  return natural.from_relative(s, observer.workspace().bodies, observer.workspace().origin);
}

/// Friction holds a wheel that stands wherever it came from, and so there are many equilibria. Sought is the
/// one whose carcasses store least: where footprints are put to where the wheels are, over and over, what
/// they hold against each other (a suspension that has come down pushes them apart) is gone; what is left
/// carries the weight along a slope, by which it comes down a little each time.
StaticsStatus equilibrium(natural::NaturalSystem* natural, relative::RelativeSystem& observer, State& s) {
  const Compiled& m = observer.model();
  for (const spec::Contact& contact : m.spec().contacts)
    if (contact.swarm)
      throw InputError(
          contact.mark,
          fmt::format("contact '{}' is a swarm, whose pairs are found as it moves: no equilibrium "
                      "can be looked for. Let it come to rest from the assembled position, "
                      "`mimbre run MODEL --until 1 --save-state rest.state`, and go on from there with "
                      "`--resume rest.state --until 2`; or, of few spheres, leave out 'swarm: true'",
                      contact.name));
  StaticsStatus status = find_from_here(natural, observer, s);
  Bends bends;
  for (int round = 0; round < most_rounds && status.converged; ++round) {
    const State found = s;
    if (!let_wheels_go(observer, s, bends)) break;
    const StaticsStatus next = find_from_here(natural, observer, s);
    if (next.converged) {
      status = next;
      continue;
    }
    s = found;
    break;
  }
  return status;
}

std::string start_at_equilibrium(relative::RelativeSystem& system, State& s) {
  const Compiled& m = system.model();
  const Eigen::VectorXd velocities = s.v;
  const StaticsStatus status = equilibrium(nullptr, system, s);
  if (!status.converged)
    throw InputError({m.spec().file, 0, 0},
                     fmt::format("`initial: equilibrium`: {}; start from the assembled position instead",
                                 explain_imbalance(m, nullptr, status)));
  s.v = velocities;
  const double gap = close_velocities(system, 0, s.q, readiness(system), s.v);
  if (!(gap < close_enough))
    throw InputError({m.spec().file, 0, 0}, "the initial velocities contradict the constraints");
  return explain_instability(m, nullptr, status);
}

}  // namespace mimbre
