#include "mimbre/inverse_dynamics.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/driven_motion.h"
#include "analysis/observed_rows.h"
#include "integrate/initial.h"
#include "joints/joint_kind.h"
#include "math/once/decompositions.h"
#include "mimbre/diagnostics.h"
#include "mimbre/simulation.h"
#include "simulation/describe/names.h"
#include "simulation/observe/smallest_reactions.h"
#include "simulation/start/assembly.h"
#include "simulation/start/redundancy.h"
#include "simulation/step/signal_state.h"

namespace mimbre {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Options = InverseDynamicsOptions;

constexpr double dependent_motions = 1e-9;  ///< of motions, by their scales
constexpr double unbalanced = 1e-7;  ///< of the forces at play, that no force which is looked for balances
constexpr double balanced_forces = 1e-11;    ///< likewise in a quasi-static balance
constexpr double tangent_difference = 1e-6;  ///< of motions by their scales, for its tangent
constexpr int most_balance_rounds = 60;
constexpr int most_parts_of_way = 100000, most_halvings_of_way = 20;
constexpr double slow_balance = 0.3;  ///< ratio of residuals from which on its tangent is made anew

[[noreturn]] void fail(double time, const std::string& text) {
  throw std::runtime_error(fmt::format("inverse dynamics at t = {:.6g} s: {}", time, text));
}

/// The model with drives of the motion, and with drives that only exert forces where such are looked for.
struct Driven {
  std::shared_ptr<const Model> model;
  std::vector<JointCoordinate> prescribed, forces;
};

/// Drives that only exert forces: they start with the position and the rate that the mechanism has there, and
/// what they prescribe afterwards is not looked at.
void drive_along(spec::Model& spec, const std::vector<JointCoordinate>& coordinates, const Options& options) {
  if (coordinates.empty()) return;
  const auto joint = [&](const JointCoordinate& of) -> spec::Joint& {
    return spec.joints[static_cast<std::size_t>(of.joint)];
  };
  for (const JointCoordinate& of : coordinates)
    if (joint(of).cut == spec::Joint::Cut::automatic) joint(of).cut = spec::Joint::Cut::never;
  const auto model = Model::compile(spec);
  const Compiled& m = model->compiled();
  relative::RelativeSystem system(m);
  const State start = assembled_state(m, system, options.inputs);
  for (const JointCoordinate& of : coordinates)
    for (const BodyData& b : m.bodies) {
      if (b.joint_spec != of.joint) continue;
      spec::Drive drive;
      drive.coordinate = of.coordinate;
      drive.law = Function::polynomial({start.q[b.q + of.coordinate], start.v[b.v + of.coordinate]});
      joint(of).drives.push_back(std::move(drive));
      for (auto* given : {&joint(of).initial_position, &joint(of).initial_velocity})
        if (static_cast<int>(given->size()) > of.coordinate)
          (*given)[static_cast<std::size_t>(of.coordinate)].reset();
    }
}

Driven driven_model(const Model& model, const PrescribedMotion* motion, const Options& options) {
  Driven out;
  spec::Model spec = motion ? with_motion(model.spec(), *motion, options.smooth) : model.spec();
  for (int j = 0; j < static_cast<int>(spec.joints.size()); ++j)
    for (const spec::Drive& drive : spec.joints[static_cast<std::size_t>(j)].drives)
      out.prescribed.push_back({j, drive.coordinate});
  if (out.prescribed.empty())
    throw InputError({spec.file, 0, 0},
                     "nothing prescribes a motion: give joints a drive, or a table of their coordinates over "
                     "time");
  out.forces = options.forces.empty() ? out.prescribed : options.forces;
  std::vector<JointCoordinate> free;  ///< of forces, which nothing prescribes
  for (const JointCoordinate& of : out.forces) {
    if (of.joint < 0 || of.joint >= static_cast<int>(spec.joints.size()))
      throw InputError(Mark{},
                       fmt::format("forces are looked for at joint {}, which there is not", of.joint));
    if (std::count(out.forces.begin(), out.forces.end(), of) > 1)
      throw InputError(Mark{},
                       fmt::format("the force of '{}' is looked for twice", coordinate_text(spec, of)));
    if (std::find(out.prescribed.begin(), out.prescribed.end(), of) != out.prescribed.end()) continue;
    const spec::Joint& joint = spec.joints[static_cast<std::size_t>(of.joint)];
    const JointInfo& info = joint_info(joint.type);
    if (of.coordinate < 0 || of.coordinate >= (info.quaternion < 0 ? info.velocities : info.rotation))
      throw InputError(joint.mark,
                       fmt::format("joint '{}' has no scalar coordinate {}", joint.name, of.coordinate));
    free.push_back(of);
  }
  drive_along(spec, free, options);
  out.model = Model::compile(std::move(spec));
  return out;
}

class InverseProblem {
 public:
  InverseProblem(const Driven& driven, const Options& options)
      : driven_(driven),
        options_(options),
        m_(driven.model->compiled()),
        system_(m_),
        motion_(system_, leads()),
        rows_(m_, true),
        smallest_(m_) {
    for (const JointCoordinate& of : driven.forces) drives_.push_back(&drive(of));
  }

  /// At these instants, of a motion that begins at `begin`, s.
  InverseDynamics solve(const std::vector<double>& times, double begin);

 private:
  const DriveData& drive(const JointCoordinate& of) const {
    for (const DriveData& d : m_.drives)
      if (d.joint_spec == of.joint && d.local == of.coordinate) return d;
    throw InputError(Mark{}, fmt::format("joint '{}' is cut, so that no drive can act there; set cut: never",
                                         m_.spec().joints[static_cast<std::size_t>(of.joint)].name));
  }
  std::vector<char> leads() const {
    std::vector<char> all(static_cast<std::size_t>(m_.equations), 1);
    for (const DriveData& d : m_.drives)
      if (std::find(driven_.prescribed.begin(), driven_.prescribed.end(),
                    JointCoordinate{d.joint_spec, d.local}) == driven_.prescribed.end())
        all[static_cast<std::size_t>(d.equation)] = 0;
    return all;
  }
  void place(State& s);
  VectorXd forces(const State& s);
  void balance(State& s);
  void find_forces(State& s, InverseDynamics& out, Eigen::Index instant);
  RunOptions run_options(double end) const;
  void follow_dynamically(Simulation& simulation, const std::vector<double>& times, InverseDynamics& out);
  void forget(State& s);
  void judge(InverseDynamics& out) const;
  /// Events, and what is evaluated at instants: both happen in runs alone.
  bool acts_at_instants() const {
    return !m_.spec().events.empty() || !m_.signals.sampled.empty() ||
           std::any_of(m_.elements.begin(), m_.elements.end(),
                       [](const ElementData& e) { return e.sampled; });
  }
  void observe(State& s, InverseDynamics& out, Eigen::Index instant);
  MatrixXd free_motions(const State& s) {
    const MatrixXd jacobian = motion_.jacobian(s);
    if (jacobian.size() == 0 || jacobian.cwiseAbs().maxCoeff() < dependent_motions)
      return MatrixXd::Identity(m_.velocities, m_.velocities);
    return null_space(jacobian, dependent_motions);
  }

  const Driven& driven_;
  const Options& options_;
  const Compiled& m_;
  relative::RelativeSystem system_;
  DrivenMotion motion_;
  ObservedRows rows_;
  SmallestReactions smallest_;
  std::vector<const DriveData*> drives_;  ///< of the forces
  MatrixXd tangent_;                      ///< of the quasi-static balance
  bool reduces_ = false;                  ///< reactions of redundant joints
  // Of all instants, as work along the scales.
  double at_play_ = 0, missing_ = 0, missing_time_ = 0;
  std::string missing_text_;
};

void InverseProblem::place(State& s) {
  if (motion_.close(s)) return;
  fail(s.time,
       fmt::format("the motion cannot be made: {:.3g} of the mechanism's size is left between parts "
                   "that belong together. A drive goes beyond what the others let it reach, or drives "
                   "contradict each other; `mimbre kinematics` finds the limit",
                   motion_.violation()));
}

/// M a − Q as work along the scales of the coordinates.
VectorXd InverseProblem::forces(const State& s) {
  const VectorXd none = VectorXd::Zero(m_.equations);
  VectorXd r(m_.velocities);
  system_.residual(s.time, s.q.data(), s.v.data(), s.a.data(), none.data(), 0, r.data());
  if (!r.allFinite()) fail(s.time, "a force is not a number");
  return motion_.scale().cwiseProduct(r);
}

/// Moves what is free to where its forces balance, at the velocities and accelerations of the motion.
void InverseProblem::balance(State& s) {
  double before = 0;
  for (int round = 0; round < most_balance_rounds; ++round) {
    const MatrixXd N = free_motions(s);
    const VectorXd all = forces(s), r = N.transpose() * all;
    const double norm = r.norm();
    if (norm <= balanced_forces * all.norm()) return;
    if (tangent_.rows() != N.cols() || (round > 0 && norm > slow_balance * before)) {
      // By the same motions N, so that the tangent holds until they turn.
      tangent_.resize(N.cols(), N.cols());
      for (Eigen::Index k = 0; k < N.cols(); ++k) {
        VectorXd sides[2];
        for (int side = 0; side < 2; ++side) {
          State moved = s;
          const VectorXd x =
              (side == 0 ? tangent_difference : -tangent_difference) * motion_.scale().cwiseProduct(N.col(k));
          system_.retract(s.q.data(), x.data(), moved.q.data());
          place(moved);
          sides[side] = N.transpose() * forces(moved);
        }
        tangent_.col(k) = (sides[0] - sides[1]) / (2 * tangent_difference);
      }
      forces(s);
    }
    before = norm;
    const PivotedCholesky check(tangent_.transpose() * tangent_);
    if (!(check.least_pivot() > 1e-24 * tangent_.squaredNorm()))
      fail(s.time,
           "something moves that neither a drive nor a spring holds, so that there is no quasi-static "
           "balance; prescribe it too, or take flexible: dynamic");
    VectorXd x = -N * mimbre::solve(tangent_, r);
    const double length = x.cwiseAbs().maxCoeff();
    if (!(length < 1e6)) break;
    if (length > 0.3) x *= 0.3 / length;
    x = x.cwiseProduct(motion_.scale()).eval();
    system_.retract(s.q.data(), x.data(), s.q.data());
    place(s);
    if (length < 1e-14) return;
  }
  fail(s.time, "the quasi-static balance of what is free was not found; take flexible: dynamic");
}

/// Forces u along the coordinates that are looked for and multipliers of all else, so that
/// M a − Q + Φᵀ λ = 0: u by the motions that loops and constraints leave, the smallest that balance them.
void InverseProblem::find_forces(State& s, InverseDynamics& out, Eigen::Index instant) {
  const VectorXd r = forces(s);
  MatrixXd jacobian = motion_.whole_jacobian(s);
  // Their scales are those of coordinates too: rows are unit vectors.
  MatrixXd acting(static_cast<Eigen::Index>(drives_.size()), m_.velocities);
  for (std::size_t k = 0; k < drives_.size(); ++k)
    acting.row(static_cast<Eigen::Index>(k)) = jacobian.row(drives_[k]->equation);
  for (const DriveData& d : m_.drives) jacobian.row(d.equation).setZero();
  const bool bound = jacobian.size() > 0 && jacobian.cwiseAbs().maxCoeff() > dependent_motions;
  const MatrixXd N = bound ? null_space(jacobian, dependent_motions)
                           : MatrixXd(MatrixXd::Identity(m_.velocities, m_.velocities));
  const MatrixXd B = (acting * N).transpose();
  const VectorXd need = -(N.transpose() * r);
  VectorXd u = VectorXd::Zero(acting.rows());
  if (B.size() > 0 && B.cwiseAbs().maxCoeff() > dependent_motions)
    u = shortest_solution(B, need, dependent_motions);
  const double play = std::max(r.norm(), u.norm());
  const VectorXd left = N * (need - B * u);
  at_play_ = std::max(at_play_, play);
  if (const double lacking = left.norm(); lacking > missing_) {
    missing_ = lacking;
    missing_time_ = s.time;
    Eigen::Index where = 0;
    left.cwiseAbs().maxCoeff(&where);
    missing_text_ = fmt::format("{:.4g} {} are missing in {}", left[where] / motion_.scale()[where],
                                "N or N m", coordinate_name(m_, nullptr, static_cast<int>(where)));
  }
  if (instant == 0) {
    const ColumnOrder order = order_columns(B, dependent_motions);
    out.redundant = static_cast<int>(B.cols()) - order.rank;
  }
  s.multipliers.setZero(m_.equations);
  if (bound) {
    const VectorXd rest = -(r + acting.transpose() * u);
    s.multipliers = shortest_solution(jacobian.transpose(), rest, dependent_motions);
  }
  const auto& scale = system_.scales().equations;
  for (std::size_t k = 0; k < drives_.size(); ++k)
    s.multipliers[drives_[k]->equation] = u[static_cast<Eigen::Index>(k)];
  for (int k = 0; k < m_.equations; ++k) s.multipliers[k] /= scale[static_cast<std::size_t>(k)];
}

/// Judged by the forces of the whole motion: at an instant at which nothing acts round-off is all there is.
void InverseProblem::judge(InverseDynamics& out) const {
  if (at_play_ > 0) out.residual = missing_ / at_play_;
  if (missing_ <= unbalanced * at_play_ || driven_.forces.empty()) return;
  std::vector<std::string> names;
  for (const JointCoordinate& of : driven_.forces) names.push_back(coordinate_text(m_.spec(), of));
  fail(missing_time_,
       fmt::format("forces along '{}' cannot make this motion: {}", fmt::join(names, "', '"), missing_text_));
}

void InverseProblem::observe(State& s, InverseDynamics& out, Eigen::Index instant) {
  find_forces(s, out, instant);
  VectorXd r(m_.velocities);
  const auto evaluate = [&] {
    system_.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  };
  evaluate();
  if (reduces_) {
    const VectorXd found = s.multipliers;
    if (smallest_.find(system_, s, s.multipliers)) {
      // Forces that are looked for stay as they are.
      bool same = true;
      for (const DriveData* d : drives_)
        same = same && std::abs(s.multipliers[d->equation] - found[d->equation]) <=
                           1e-9 * found.cwiseAbs().maxCoeff();
      if (!same) s.multipliers = found;
      evaluate();
    }
  }
  out.time[instant] = s.time;
  for (std::size_t k = 0; k < drives_.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    const DriveData& d = *drives_[k];
    out.position(instant, column) = s.q[d.q];
    out.velocity(instant, column) = s.v[d.v];
    out.acceleration(instant, column) = s.a[d.v];
    out.force(instant, column) = -s.multipliers[d.equation];
  }
  out.rows.push_back(rows_.row(system_, s));
}

/// Lets laws of force elements remember what they do at a start with this motion: friction slides from there
/// on. Turns stay.
void InverseProblem::forget(State& s) {
  if (s.z.size() == 0) return;
  for (const ElementData& e : m_.elements) {
    const int own = e.states + e.own_states;
    std::copy_n(m_.states.data() + own, e.state_count - e.own_states, s.z.data() + own);
  }
  system_.enter(s.u.data(), s.z.data(), 0);
  forces(s);
  for (const ElementData& e : m_.elements)
    std::copy_n(element_state(e, system_.workspace().elements.data()).states, e.state_count,
                s.z.data() + e.states);
  system_.enter(s.u.data(), s.z.data(), 0);
}

RunOptions InverseProblem::run_options(double end) const {
  RunOptions run;
  run.formulation = spec::Simulation::Formulation::relative;
  run.inputs = options_.inputs;
  if (options_.step > 0) run.step = options_.step;
  run.end = std::max(end, 1e-9);
  run.energies = run.validity = run.warnings = false;
  return run;
}

/// By a run of the model with its drives.
void InverseProblem::follow_dynamically(Simulation& simulation, const std::vector<double>& times,
                                        InverseDynamics& out) {
  for (std::size_t k = 0; k < times.size(); ++k) {
    while (simulation.time() < times[k] - 1e-12 * times.back()) {
      const double next = simulation.time() + simulation.step_size();
      const StepReport report =
          next < times[k] - 1e-9 * simulation.step_size() ? simulation.step() : simulation.step_to(times[k]);
      if (!report.ok()) fail(simulation.time(), simulation.explain(report));
    }
    const Simulation::Snapshot now = simulation.save();
    State s;
    s.time = now.time;
    s.q = now.q;
    s.v = now.v;
    s.a = now.a;
    s.z = now.z;
    s.u = now.u;
    system_.enter(s.u.data(), s.z.data(), 0);
    system_.begin_step(s.q.data());
    // A step balances what is free to its tolerance; accelerations that balance it are near its own.
    if (State exact = s; solve_accelerations(system_, exact)) s.a = exact.a;
    observe(s, out, static_cast<Eigen::Index>(k));
  }
}

InverseDynamics InverseProblem::solve(const std::vector<double>& times, double begin) {
  InverseDynamics out;
  out.coordinates = driven_.forces;
  for (const JointCoordinate& of : driven_.forces) {
    out.names.push_back(coordinate_text(m_.spec(), of));
    out.units.emplace_back(
        is_angle(m_.spec().joints[static_cast<std::size_t>(of.joint)].type, of.coordinate) ? "N m" : "N");
  }
  const auto count = static_cast<Eigen::Index>(times.size());
  out.time.resize(count);
  for (MatrixXd* x : {&out.position, &out.velocity, &out.acceleration, &out.force})
    x->setZero(count, static_cast<Eigen::Index>(drives_.size()));

  State s = assembled_state(m_, system_, options_.inputs);
  const State first = s;
  s.time = times.front();
  place(s);
  const Redundancy redundancy = find_redundancy(system_, s);
  reduces_ = redundancy.equations + redundancy.nearly > 0;
  rows_.channels().mark_undetermined(redundancy);
  out.header = rows_.header("");
  out.free = static_cast<int>(free_motions(s).cols());
  const bool forces_alone = driven_.forces != driven_.prescribed;
  const bool runs = options_.flexible == Options::Flexible::dynamic &&
                    (out.free > 0 || (acts_at_instants() && !forces_alone && !(begin > 0)));
  if (acts_at_instants() && !runs)
    out.warnings.emplace_back(
        "events do not happen here, and signals with 'every' keep what they are at the start");
  if (runs && forces_alone)
    throw InputError(Mark{}, fmt::format("{} independent motion{} are prescribed by nothing, and forces are "
                                         "looked for along other coordinates than the prescribed ones; take "
                                         "flexible: quasistatic, or prescribe all motions",
                                         out.free, out.free > 1 ? "s" : ""));
  const bool remembers = s.z.size() > 0 || s.u.size() > 0;
  const auto go = [&](double to, Eigen::Index instant, bool balances) {
    const double h = to - s.time;
    if (h > 0) {
      const VectorXd x = h * s.v + 0.5 * h * h * s.a;
      VectorXd q = s.q;
      system_.retract(s.q.data(), x.data(), q.data());
      s.q = q;
    }
    s.time = to;
    if (remembers) system_.enter(s.u.data(), s.z.data(), h);
    place(s);
    if (balances) balance(s);
    if (instant >= 0)
      observe(s, out, instant);
    else
      forces(s);
    if (remembers) {
      commit_signals(m_, system_, s);
      system_.enter(s.u.data(), s.z.data(), 0);
    }
  };
  // Far ones in parts, so that turns are counted and loops stay on their branch.
  const auto go_in_parts = [&](double to, Eigen::Index instant, bool balances) {
    for (int part = 0; part < most_parts_of_way; ++part) {
      double h = to - s.time;
      VectorXd x = h * s.v + 0.5 * h * h * s.a;
      if (const double moved = system_.scales().of_coordinates(x.data()); moved > most_moved)
        h *= std::max(most_moved / moved, 1e-3);
      // From rest nothing is known of the way.
      for (int halving = 0; halving < most_halvings_of_way && h > 0; ++halving, h /= 2) {
        State there = s;
        x = h * s.v + 0.5 * h * h * s.a;
        system_.retract(s.q.data(), x.data(), there.q.data());
        there.time += h;
        if (remembers) system_.enter(s.u.data(), s.z.data(), h);
        if (motion_.close(there) && motion_.change() <= most_moved) break;
      }
      const double next = s.time + h;
      if (!(next > s.time && next < to * (1 - 1e-12))) break;
      go(next, -1, balances);
    }
    go(to, instant, balances);
  };
  const bool frees = out.free > 0;
  if (runs) {
    Simulation simulation(driven_.model, run_options(times.back()));
    if (begin > simulation.time()) {
      // What is free begins there with the motion, from where it starts, not with a jump from a standstill.
      Simulation::Snapshot there = simulation.save();
      s = first;
      s.q = there.q;
      s.z = there.z;
      s.u = there.u;
      system_.enter(s.u.data(), s.z.data(), 0);
      system_.begin_step(s.q.data());
      place(s);
      go_in_parts(begin, -1, false);
      forget(s);
      there.time = begin;
      there.q = s.q;
      there.v = s.v;
      there.a = s.a;
      there.z = s.z;
      there.u = s.u;
      there.started = false;
      simulation.restart(there);
    }
    follow_dynamically(simulation, times, out);
    judge(out);
    return out;
  }
  // Blocks remember from the beginning on, by steps of the model.
  const bool blocks = m_.signals.clock >= 0;
  const auto follow_blocks = [&](double to) {
    const double from = s.time, parts = std::ceil((to - from) / m_.spec().simulation.step * (1 - 1e-9));
    for (double k = 1; k < parts; ++k) go_in_parts(from + (to - from) * k / parts, -1, frees);
  };
  if (blocks && times.front() > begin) {
    s = first;
    s.time = begin;
    go(begin, -1, frees);
  } else if (s.time != 0) {
    forget(s);
  }
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (blocks && times[k] > s.time) follow_blocks(times[k]);
    go_in_parts(times[k], static_cast<Eigen::Index>(k), frees);
  }
  judge(out);
  if (out.redundant > 0)
    out.warnings.push_back(fmt::format(
        "{} of the forces {} could be left out: of all that make this motion the smallest are given (least "
        "sum of squares by the scales of the coordinates)",
        out.redundant, fmt::join(out.names, ", ")));
  return out;
}

std::vector<double> instants(const Model& model, const PrescribedMotion* motion, const Options& options) {
  std::vector<double> times = options.times;
  if (times.empty() && motion) times = motion->time;
  if (times.empty()) {
    const double end = options.end.value_or(model.spec().simulation.end);
    if (!(options.steps > 0)) throw InputError(Mark{}, "steps must be at least 1");
    if (!(end >= options.start) || !std::isfinite(end))
      throw InputError(Mark{},
                       fmt::format("the motion ends at {} s, before it starts at {} s", end, options.start));
    for (int k = 0; k <= options.steps; ++k)
      times.push_back(options.start + (end - options.start) * k / options.steps);
  }
  for (std::size_t k = 0; k < times.size(); ++k)
    if (!(times[k] >= 0) || !std::isfinite(times[k]) || (k > 0 && !(times[k] >= times[k - 1])))
      throw InputError(Mark{}, fmt::format("the instants must ascend from 0 or later; number {} is {} s",
                                           k + 1, times[k]));
  if (motion && !motion->time.empty() &&
      (times.front() < motion->time.front() || times.back() > motion->time.back()))
    throw InputError(Mark{},
                     fmt::format("forces are asked for from {} to {} s, and the motion goes from {} to "
                                 "{} s",
                                 times.front(), times.back(), motion->time.front(), motion->time.back()));
  return times;
}

}  // namespace

InverseDynamics inverse_dynamics(const std::shared_ptr<const Model>& model, const PrescribedMotion* motion,
                                 const InverseDynamicsOptions& options) {
  const Driven driven = driven_model(*model, motion, options);
  const double begin = motion && !motion->time.empty() ? motion->time.front() : 0;
  return InverseProblem(driven, options).solve(instants(*model, motion, options), begin);
}

}  // namespace mimbre
