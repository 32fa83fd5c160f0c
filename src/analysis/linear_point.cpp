#include "analysis/linear_point.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "analysis/linear_description.h"
#include "analysis/modal_scales.h"
#include "analysis/trim_point.h"
#include "dynamics/relative/forces.h"
#include "integrate/initial.h"
#include "math/once/decompositions.h"
#include "mimbre/diagnostics.h"
#include "mimbre/simulation.h"
#include "simulation/describe/explain.h"
#include "simulation/describe/names.h"
#include "simulation/observe/channels.h"
#include "simulation/start/assembly.h"
#include "simulation/step/signal_state.h"

namespace mimbre::linear {

using Eigen::MatrixXd;
using Eigen::VectorXd;

void commit(const Compiled& m, relative::RelativeSystem& system, State& s) {
  system.enter_rest(s.u.data(), s.z.data());
  system.begin_step(s.q.data());
  system.kinematics(s.time, s.q.data(), s.v.data(), s.a.data());
  VectorXd generalised(m.velocities);
  relative::forces(m, system.workspace(), s.time, s.q.data(), s.v.data(), s.a.data(), generalised.data());
  commit_signals(m, system, s);
  system.enter_rest(s.u.data(), s.z.data());
}

namespace {

/// Of the scales: by how much dependent coordinates may move by one that is independent.
constexpr double most_by_independent = 1e4;
constexpr double singular = 1e-6;  ///< of the scales of equations that repeat others, off the point

struct PointState {
  State state;
  std::string words;
  std::optional<Trim> trim;
};

/// Whether drives and other equations of time let the mechanism rest at q.
bool can_rest(relative::RelativeSystem& system, const State& s) {
  if (system.equations() == 0) return true;
  const VectorXd zero = VectorXd::Zero(system.velocities());
  system.kinematics(s.time, s.q.data(), zero.data(), zero.data());
  return system.scales().of_equations(system.phi_dot()) <= still * pace_of(system, s.v);
}

std::string driven_name(relative::RelativeSystem& system, const State& s) {
  const VectorXd zero = VectorXd::Zero(system.velocities());
  system.kinematics(s.time, s.q.data(), zero.data(), zero.data());
  int worst = 0;
  for (int k = 1; k < system.equations(); ++k)
    if (std::abs(system.phi_dot()[k]) > std::abs(system.phi_dot()[worst])) worst = k;
  return equation_name(system.model(), nullptr, worst);
}

/// What is left of r and Φ̈ without relative accelerations, along the independent motions, and the tangent.
struct Unsteady {
  VectorXd force;    ///< f × 1
  MatrixXd tangent;  ///< of force by y
  MatrixXd motions;  ///< N
};
Unsteady unsteady(const Compiled& m, const relative::RelativeSystem& system, const State& s) {
  LinearCore core(m, s, pace_of(system, s.v));
  Derivatives d;
  core.find_mass(d);
  const Independent independent(d.jacobian, system.scales());
  const VectorXd particular = independent.particular(-d.phi_second).col(0);
  const MatrixXd& N = independent.motions();
  const VectorXd multipliers = independent.multipliers(VectorXd(-d.residual - d.mass * particular));
  core.find_derivatives(particular, multipliers, d);
  const MatrixXd rate = independent.particular(-d.rate_q * N);
  const MatrixXd second = independent.particular(-(d.second_q * N + d.second_v * rate));
  Unsteady u;
  u.motions = N;
  u.force = N.transpose() * (d.residual + d.mass * particular);
  u.tangent = N.transpose() * (d.residual_q * N + d.residual_v * rate + d.mass * second);
  return u;
}

/// Newton's method for positions without relative accelerations at the velocities of the start. Directions in
/// which nothing changes stay as they are.
bool find_steady(const Compiled& m, relative::RelativeSystem& system, State& s) {
  const VectorXd ready = Eigen::Map<const VectorXd>(system.scales().coordinates.data(), system.velocities());
  const VectorXd wanted = s.v;
  for (int round = 0; round < 60; ++round) {
    commit(m, system, s);
    const Unsteady u = unsteady(m, system, s);
    if (u.motions.cols() == 0) return true;
    if (!u.force.allFinite() || !u.tangent.allFinite()) return false;
    // Along the scales, so that neutral directions show.
    VectorXd scale(u.motions.cols());
    for (Eigen::Index k = 0; k < scale.size(); ++k)
      scale[k] = 1 / system.scales().of_coordinates(u.motions.col(k).eval().data());
    const MatrixXd tangent = scale.asDiagonal() * u.tangent * scale.asDiagonal();
    const VectorXd force = scale.asDiagonal() * u.force;
    if (tangent.cwiseAbs().maxCoeff() == 0) return true;
    VectorXd step = -u.motions * (scale.asDiagonal() * shortest_solution(tangent, force, 1e-10));
    const double length = system.scales().of_coordinates(step.data());
    if (length > 0.3) step *= 0.3 / length;
    system.retract(s.q.data(), step.data(), s.q.data());
    if (m.equations > 0) {
      close_positions(system, s.time, ready, s.q);
      s.v = wanted;
      close_velocities(system, s.time, s.q, ready, s.v);
    }
    if (length < 1e-12) {
      commit(m, system, s);
      return true;
    }
  }
  return false;
}

State start_state(const Compiled& m, relative::RelativeSystem& system, const LinearOptions& options) {
  State s = assembled_state(m, system, options.run.inputs);
  if (m.spec().simulation.start_at_equilibrium) start_at_equilibrium(system, s);
  return s;
}

/// The state of a run: of the same model with its delays.
PointState state_at_time(std::shared_ptr<const Model> model, const Compiled& m,
                         const LinearOptions& options) {
  RunOptions run = options.run;
  run.formulation = spec::Simulation::Formulation::relative;
  run.energies = run.validity = run.warnings = false;
  const double end = options.point.time;
  if (!(end >= 0) || !std::isfinite(end))
    throw InputError(Mark{}, fmt::format("a time of {} s: a finite time from 0 on is needed", end));
  Simulation simulation(std::move(model), run);
  const double h = simulation.step_size();
  while (simulation.time() < end - 1e-9 * h && !simulation.stopped()) {
    const StepReport report =
        end - simulation.time() < h * (1 + 1e-9) ? simulation.step_to(end) : simulation.step();
    if (!report.ok())
      throw std::runtime_error(fmt::format("the run to {} s failed: {}", end, simulation.explain(report)));
  }
  const Simulation::Snapshot from = simulation.save();
  PointState out;
  State& s = out.state;
  s.time = from.time;
  s.q = from.q;
  s.v = from.v;
  s.a = VectorXd::Zero(m.velocities);
  s.algorithmic = s.a;
  s.multipliers = VectorXd::Zero(m.equations);
  s.z = from.z;
  s.u = from.u;
  out.words = fmt::format("t = {:.6g} s", s.time);
  return out;
}

PointState state_of(const Compiled& m, relative::RelativeSystem& system, const LinearOptions& options) {
  using At = LinearPoint::At;
  const At at = options.point.at;
  PointState out{start_state(m, system, options), "start", {}};
  State& s = out.state;
  if (at == At::start) return out;
  if (at == At::trim) {
    out.trim = find_trim(m, system, s, options.run.inputs, options.trim, options.trim_near.get());
    s = out.trim->state;
    out.words = fmt::format("steady driving at {:.6g} m/s", out.trim->speed);
    if (const double across = out.trim->yaw_rate * out.trim->speed; std::abs(across) > 1e-9)
      out.words += fmt::format(", {:.6g} m/s² to the {}", std::abs(across), across > 0 ? "left" : "right");
    return out;
  }
  if (at == At::equilibrium || at == At::automatic) {
    if (can_rest(system, s)) {
      // What the search puts straight, such as carcasses, it has to see.
      State found = s;
      system.enter_rest(found.u.data(), found.z.data());
      std::optional<StaticsStatus> status;
      try {
        status = equilibrium(nullptr, system, found);
      } catch (const InputError&) {
        if (at == At::equilibrium) throw;
      }
      if (status && status->converged) {
        found.v.setZero();
        found.a.setZero();
        return {found, "equilibrium", {}};
      }
      system.enter_rest(s.u.data(), s.z.data());
      if (at == At::equilibrium) throw std::runtime_error(explain_imbalance(m, nullptr, *status));
    } else if (at == At::equilibrium) {
      throw std::runtime_error(fmt::format(
          "there is no equilibrium at rest: {} moves. Use the point 'steady'", driven_name(system, s)));
    }
  }
  const bool moves = system.scales().of_coordinates(s.v.data()) > 0 || !can_rest(system, s);
  if (at == At::automatic && !moves) {
    system.enter_rest(s.u.data(), s.z.data());
    return out;
  }
  State steady = s;
  if (find_steady(m, system, steady)) return {steady, "steady motion", {}};
  if (at == At::steady)
    throw std::runtime_error(
        "no steady motion was found near the start: no positions in which the velocities of the start stay. "
        "Give "
        "initial velocities that can last, or use the point 'start' or a time");
  system.enter_rest(s.u.data(), s.z.data());
  return out;
}

/// Such a body does not act on the mechanism that moves it, so that there is no symmetric mass.
void refuse_elastodynamic_bodies(const Compiled& m) {
  for (const BodyData& b : m.bodies) {
    if (!b.elastodynamic) continue;
    const spec::Body& body = m.spec().bodies[static_cast<std::size_t>(b.spec)];
    throw InputError(body.mark, fmt::format("body '{}' bends by elastodynamics, which linear analyses do not "
                                            "cover; use flexibility: floating_frame for them",
                                            body.name));
  }
}

[[noreturn]] void refuse_massless(const Compiled& m, int coordinate) {
  if (const std::string stiffened = explain_lost_mass(m, nullptr, coordinate); !stiffened.empty())
    throw std::runtime_error("the equations of motion are not solvable for the accelerations: " + stiffened);
  throw std::runtime_error(
      fmt::format("{} moves no mass, so that the equations of motion are not solvable for its "
                  "acceleration; give what it moves a mass or an inertia",
                  coordinate_name(m, nullptr, coordinate)));
}

/// Throws where equations that repeat others at the point do not do so beside it: the mechanism can move
/// there in ways that do not last.
void refuse_singular(const Compiled& m, const System& system, LinearCore& core,
                     const Independent& independent) {
  const MatrixXd redundant = independent.redundant();
  const MatrixXd& N = independent.motions();
  if (redundant.cols() == 0 || N.cols() == 0) return;
  const Scales& scales = system.scales();
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    VectorXd y(N.cols());
    for (Eigen::Index k = 0; k < y.size(); ++k)
      y[k] = 2 * uniform_at(seed + 1, static_cast<std::uint64_t>(k)) - 1;
    VectorXd x = N * y;
    const double size = scales.of_coordinates(x.data());
    if (!(size > 0)) continue;
    x /= size;
    const VectorXd curved = core.curvature(x);
    const VectorXd off = redundant.transpose() * curved;
    Eigen::Index worst = 0;
    for (Eigen::Index k = 0; k < off.size(); ++k) {
      // By the scales of the equations that it combines.
      double weight = 0;
      for (Eigen::Index e = 0; e < redundant.rows(); ++e)
        weight += std::abs(redundant(e, k)) * scales.equations[static_cast<std::size_t>(e)];
      if (!(std::abs(off[k]) > singular * weight)) continue;
      redundant.col(k).cwiseAbs().maxCoeff(&worst);
      throw std::runtime_error(fmt::format(
          "the point is a singular position: there {} repeats other constraints, and beside it "
          "it does not, so that the mechanism can move in more ways than it keeps. Linearise beside "
          "that position",
          equation_name(m, nullptr, static_cast<int>(worst))));
    }
  }
}

/// Leaves out inputs, rates of inputs above all, that move nothing.
void drop_idle_inputs(Linearised& out) {
  const int states = out.reduced.states;
  std::vector<int> kept;
  const Reduced& r = out.reduced;
  const Eigen::Index first = r.A.cols();
  for (int k = 0; k < r.inputs; ++k) {
    const Parameter& p = out.parameters[static_cast<std::size_t>(states + k)];
    const bool moves = !r.B.col(k).isZero(0) || !r.position.col(first + k).isZero(0) ||
                       !r.velocity.col(first + k).isZero(0) || !r.acceleration.col(first + k).isZero(0);
    if (p.kind == Parameter::Kind::input || moves) kept.push_back(k);
  }
  std::vector<int> columns;
  for (Eigen::Index k = 0; k < first; ++k) columns.push_back(static_cast<int>(k));
  std::vector<Parameter> parameters(out.parameters.begin(), out.parameters.begin() + states);
  for (const int k : kept) {
    columns.push_back(static_cast<int>(first) + k);
    parameters.push_back(out.parameters[static_cast<std::size_t>(states + k)]);
  }
  out.parameters = std::move(parameters);
  out.reduced.B = MatrixXd(r.B(Eigen::all, kept));
  for (MatrixXd* x :
       {&out.reduced.position, &out.reduced.velocity, &out.reduced.acceleration, &out.reduced.multipliers})
    *x = MatrixXd((*x)(Eigen::all, columns));
  out.reduced.inputs = static_cast<int>(kept.size());
}

/// States of elements whose rates go by the velocities alone, at rest, are functions of the positions: the
/// bend of what sticks. They add stiffness and no state.
void fold_bristles(Linearised& out) {
  Reduced& r = out.reduced;
  const int f = r.coordinates;
  if (f != r.speeds || out.state.v.size() == 0 || out.state.v.cwiseAbs().maxCoeff() > 0) return;
  std::vector<int> folded;
  const Eigen::Index n = r.A.cols();
  for (int k = 0; k < r.states; ++k) {
    if (out.parameters[static_cast<std::size_t>(k)].kind != Parameter::Kind::element_state) continue;
    const Eigen::RowVectorXd row = r.A.row(2 * f + k);
    const double size = row.segment(f, f).cwiseAbs().maxCoeff(), none = 1e-9 * size;
    const auto small = [&](const auto& part) {
      return part.size() == 0 || part.cwiseAbs().maxCoeff() <= none;
    };
    if (size > 0 && small(row.head(f)) && small(row.tail(r.states)) && small(r.B.row(2 * f + k)))
      folded.push_back(k);
  }
  if (folded.empty()) return;
  // z = R y, with R the rate's row: each matrix by z adds to that by y.
  std::vector<int> kept;
  for (Eigen::Index c = 0; c < n; ++c)
    if (std::find(folded.begin(), folded.end(), static_cast<int>(c) - 2 * f) == folded.end() || c < 2 * f)
      kept.push_back(static_cast<int>(c));
  const MatrixXd rows = r.A.middleRows(2 * f, r.states)(folded, Eigen::seqN(f, f));
  const auto fold = [&](MatrixXd& x) {
    for (std::size_t k = 0; k < folded.size(); ++k)
      x.leftCols(f) += x.col(2 * f + folded[k]) * rows.row(static_cast<Eigen::Index>(k));
    std::vector<int> columns = kept;
    for (Eigen::Index c = n; c < x.cols(); ++c) columns.push_back(static_cast<int>(c));
    x = MatrixXd(x(Eigen::all, columns));
  };
  const MatrixXd before = r.A.block(f, 0, f, f);
  for (MatrixXd* x : {&r.A, &r.position, &r.velocity, &r.acceleration, &r.multipliers}) fold(*x);
  r.stiffness -= r.mass * (r.A.block(f, 0, f, f) - before);
  r.A = MatrixXd(r.A(kept, Eigen::all));
  r.B = MatrixXd(r.B(kept, Eigen::all));
  std::vector<Parameter> parameters;
  for (std::size_t k = 0; k < out.parameters.size(); ++k)
    if (std::find(folded.begin(), folded.end(), static_cast<int>(k)) == folded.end())
      parameters.push_back(out.parameters[k]);
  out.parameters = std::move(parameters);
  r.states -= static_cast<int>(folded.size());
  VectorXd rates(r.states);
  int at = 0;
  for (Eigen::Index k = 0; k < out.state_rates.size(); ++k)
    if (std::find(folded.begin(), folded.end(), static_cast<int>(k)) == folded.end())
      rates[at++] = out.state_rates[k];
  out.state_rates = rates;
}

/// Whether the others follow from these coordinates as well as from the best ones.
bool are_independent(const MatrixXd& jacobian, const Scales& scales, bool positions,
                     const std::vector<int>& chosen) {
  const Independent best(jacobian, scales, positions);
  if (best.coordinates().size() != chosen.size()) return false;
  if (best.coordinates() == chosen) return true;
  const Independent asked(jacobian, scales, positions, chosen);
  const VectorXd units = Eigen::Map<const VectorXd>(scales.coordinates.data(), jacobian.cols());
  const MatrixXd motions =
      units.cwiseInverse().asDiagonal() * asked.motions() * VectorXd(units(chosen)).asDiagonal();
  return motions.allFinite() && motions.cwiseAbs().maxCoeff() <= most_by_independent;
}

}  // namespace

void linearise_state(const Compiled& m, const relative::RelativeSystem& system, Linearised& out,
                     bool where_good) {
  State& s = out.state;
  const Scales scales = modal_scales(m, system.scales());
  LinearCore core(m, s, pace_of(system, s.v));
  core.find_mass(out.derivatives);
  const std::vector<char>& is_rate = system.scales().is_rate;
  const bool rolls = std::find(is_rate.begin(), is_rate.end(), 1) != is_rate.end();
  // Those of another point may be given.
  if (where_good && !out.moving.empty() &&
      !(are_independent(out.derivatives.jacobian, scales, false, out.moving) &&
        (!rolls || are_independent(out.derivatives.jacobian, scales, true, out.independent)))) {
    out.moving.clear();
    out.independent.clear();
  }
  const Independent independent(out.derivatives.jacobian, scales, false, out.moving);
  refuse_singular(m, system, core, independent);
  int massless = -1;
  if (!consistent_accelerations(out.derivatives, independent, scales, s.a, s.multipliers, massless))
    refuse_massless(m, massless);
  core.find_derivatives(s.a, s.multipliers, out.derivatives);
  const LinearCore::Rates rates = core.rates();
  const Independent positions(out.derivatives.jacobian, scales, rolls, out.independent);
  out.reduced = reduce(out.derivatives, rates, positions, independent, scales, massless);
  if (massless >= 0) refuse_massless(m, massless);
  out.independent = positions.coordinates();
  out.moving = independent.coordinates();
  out.elements = core.elements();
  out.parameters = core.parameters();
  out.state_rates = rates.value;
  out.names.redundant = m.equations - independent.rank();
}

Linearised linearised_later(const Compiled& m, const relative::RelativeSystem& system, const Linearised& at,
                            double time) {
  Linearised next;
  next.state = at.state;
  const VectorXd x = time * at.state.v;
  system.retract(at.state.q.data(), x.data(), next.state.q.data());
  next.state.time += time;
  next.independent = at.independent;
  next.moving = at.moving;
  linearise_state(m, system, next);
  fold_bristles(next);
  return next;
}

Linearised locate(std::shared_ptr<const Model> model, const LinearOptions& options) {
  if (options.delay_order < 1 || options.delay_order > 8)
    throw InputError(Mark{},
                     fmt::format("an order of delays of {}: 1 to 8 are possible", options.delay_order));
  Linearised out;
  out.model = without_delays(model, options.delay_order, out.names.notes);
  const Compiled& m = out.model->compiled();
  refuse_elastodynamic_bodies(m);
  relative::RelativeSystem system(m);
  PointState point;
  if (options.point.at == LinearPoint::At::time) {
    point = state_at_time(model, m, options);
    if (out.model != model) {
      // What is held lies elsewhere without delays.
      State s;
      std::map<std::string, double> inputs;
      for (std::size_t k = 0; k < m.spec().inputs.size(); ++k)
        inputs[m.spec().inputs[k].name] =
            held_input_value(model->compiled(), static_cast<int>(k), point.state);
      start_signals(m, inputs, s);
      point.state.u = s.u;
      out.names.warnings.emplace_back("states of blocks begin anew at the point, as delays were replaced");
    }
  } else {
    point = state_of(m, system, options);
  }
  out.state = point.state;
  out.independent = options.independent.positions;
  out.moving = options.independent.velocities;
  out.names.point = point.words;
  if (point.trim) {
    out.trimmed = true;
    out.yaw_rate = point.trim->yaw_rate;
    out.up = point.trim->up;
    out.steady_accelerations = point.trim->accelerations;
    out.names.driving = std::make_shared<const DrivingState>(DrivingState{
        out.state.q, out.state.v, out.state.z, point.trim->inputs, point.trim->speed, point.trim->yaw_rate});
  }
  commit(m, system, out.state);
  return out;
}

Linearised linearise_located(Linearised out) {
  const Compiled& m = out.model->compiled();
  relative::RelativeSystem system(m);
  commit(m, system, out.state);
  linearise_state(m, system, out, true);
  out.names.independent = {out.independent, out.moving};
  drop_idle_inputs(out);
  fold_bristles(out);
  describe(m, system, out);
  return out;
}

Linearised linearise_at(std::shared_ptr<const Model> model, const LinearOptions& options) {
  return linearise_located(locate(std::move(model), options));
}

}  // namespace mimbre::linear
