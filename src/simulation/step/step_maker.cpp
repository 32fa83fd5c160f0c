#include "simulation/step/step_maker.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "dynamics/geometric.h"
#include "forces/sticks.h"
#include "integrate/global_modes/loops.h"
#include "math/elementary.h"
#include "mimbre/diagnostics.h"
#include "mimbre/method_names.h"
#include "simulation/describe/names.h"

namespace mimbre {
namespace {

IntegratorOptions integrator_options(const Method& method) {
  IntegratorOptions options;
  options.step = method.step;
  options.rule = method.integrator;
  options.rho = method.rho;
  options.xi = method.xi;
  options.tolerance = method.tolerance;
  options.penalty = method.penalty;
  options.accuracy = method.accuracy;
  options.max_iterations = method.max_iterations;
  options.fixed_cost = method.fixed_cost;
  return options;
}

/// A step is repeated in parts when its energy is off by more than Method::energy_tolerance of what moves or
/// is stored, and so many times that of what would lift the mechanism by its length scale; without gravity by
/// so many times the former alone.
constexpr double of_lifting = 10, without_gravity = 4;
/// Of the energy that lifts the mechanism so, or moves it by its length scale in so many steps: round-off.
constexpr double round_off_energy = 2.5e-7, energy_of_bristles = 3e-5, slow_steps = 1000;

/// How often a part that does not converge is divided again, and one in which contacts cannot be followed:
/// the latter down to a part in so many. An impact takes its depth by its speed, and a hundredth of that has
/// to show at its ends: that is 10⁻⁶ of a step in which the sphere goes 10⁴ times its radius.
constexpr int levels_of_convergence = 6;
constexpr int most_parts = 1 << 22;

/// Where parts follow from an estimate of their error: what of it they aim at, by how much they grow and
/// shrink at most, and how many there may be in a step, those that are made again included.
constexpr double caution = 0.9, least_growth = 0.2, most_growth = 5;
/// The error of a part and of the one before it predict the next part where they are of a lower order than
/// this.
constexpr int predicted_below = 8;
/// Of the error over the accuracy that the next one is predicted from, at least.
constexpr double least_error = 0.01;
constexpr int most_parts_by_error = 10000;
/// Of the time, below which a part does not move it.
constexpr double round_off_of_time = 1e-14;

bool has_contacts(const Compiled& m) { return m.first_of_contact.back() != m.first_of_contact.front(); }

int levels(const Compiled& model, const Method& method) {
  if (method.accuracy > 0) return 2;  // the step's begin, and the part's
  if (method.substeps == 1) return 0;
  if (!has_contacts(model))
    return sticks(model) || method.integrator == IntegratorOptions::Rule::radau ? levels_of_convergence : 1;
  int levels = 1;
  for (int parts = method.substeps; parts <= most_parts / method.substeps; parts *= method.substeps) ++levels;
  return levels;
}

/// How often in a step a part is divided at most, a level: an impact takes two to four divisions a level down
/// to its own. Beyond, parts are taken as they are, so that what a step may cost is known beforehand.
constexpr int divisions_a_level = 16;

std::vector<double> memory_of(Stepper& integrator) {
  StateTransfer count;
  integrator.transfer(count);
  return std::vector<double>(count.count());
}

using Clock = std::chrono::steady_clock;

}  // namespace

StepMaker::StepMaker(Mechanism& mechanism, const Method& method)
    : mechanism_(mechanism),
      method_(method),
      profiled_(mechanism.system),
      integrator_(make_stepper(method.profile ? static_cast<System&>(profiled_) : mechanism.system,
                               method.formalism, integrator_options(method))),
      conserves_(method.integrator == spec::Simulation::Integrator::conserve),
      free_flight_(mechanism.model),
      energy_keeper_(mechanism.model, free_flight_.groups()),
      swarms_(mechanism.model),
      meter_(mechanism.model),
      contacts_(mechanism.model),
      log_(empty_contact_log(mechanism.model)),
      begins_(static_cast<std::size_t>(levels(mechanism.model, method)),
              {mechanism.state, meter_, log_, memory_of(*integrator_)}),
      beginning_(mechanism.state),
      end_(mechanism.state),
      stressed_(method.energies && geometric::has_loads_of_inertia(mechanism.model)),
      before_{mechanism.state, meter_, log_, memory_of(*integrator_)},
      length_(method.step) {
  const Compiled& m = mechanism.model;
  double mass = 0;
  for (const BodyData& b : m.bodies) mass += b.mass;
  const double extent = m.length_scale, speed = extent / (slow_steps * method.step);
  lifting_energy_ = mass * m.gravity.norm() * extent;
  resting_energy_ = round_off_energy * std::max(lifting_energy_, mass * speed * speed);
  if (sticks(m))  // of what bends bristles that hold all in its place
    resting_energy_ = std::max(resting_energy_, energy_of_bristles * lifting_energy_);
  if (begins_.size() > 1 && has_contacts(m)) {  // of impacts that are not followed
    const double quiet = quiet_speed(m, method.step);
    resting_energy_ = std::max(resting_energy_, 0.5 * mass * quiet * quiet);
  }
}

/// Makes what the formalism needs beforehand.
void StepMaker::prepare() {
  mechanism_.enter(0);
  try {
    if (integrator_->prepare(mechanism_.state)) mechanism_.observe_afresh();
  } catch (const global_modes::NoGlobalModes& no) {
    const std::string who =
        no.equation >= 0     ? equation_name(mechanism_.model, mechanism_.natural.get(), no.equation)
        : no.coordinate >= 0 ? coordinate_name(mechanism_.model, mechanism_.natural.get(), no.coordinate)
                             : "the model";
    throw InputError(Mark{mechanism_.model.spec().file, 0, 0},
                     fmt::format("formalism global_modes: {}: {}", who, no.what()));
  }
}

void StepMaker::start() {
  under_way_ = false;
  prepare();
  if (method_.energies) meter_.start(mechanism_.observer, mechanism_.view());
  std::fill(log_.begin(), log_.end(), ContactTrouble());
  if (!contacts_.none() && method_.energies) {  // these have evaluated the forces
    contacts_.look(mechanism_.observer.workspace(), mechanism_.state.z.data());
    contacts_.note(mechanism_.state.time, log_);
  }
  for (Begin& begin : begins_) begin.state = mechanism_.state;
  before_.state = beginning_ = end_ = mechanism_.state;
}

/// How wrong the last step may be, J: energy that the numerics put in or took out, or that a jump of a road
/// did.
double StepMaker::step_error() const { return std::max(std::abs(meter_.last_input()), meter_.last_jump()); }

/// What it may be.
double StepMaker::step_tolerance() const {
  const EnergyBalance& e = meter_.balance();
  const double play = e.kinetic + e.elastic + e.springs + e.tyres;
  const double share = method_.energy_tolerance;
  return lifting_energy_ > 0 ? share * play + of_lifting * share * lifting_energy_
                             : without_gravity * share * play;
}

/// Where a step begins with accelerations of its own, signals may have jumped: forces, what elements
/// store, and what their laws remember of it.
void StepMaker::begin_anew() {
  Mechanism& m = mechanism_;
  m.enter(0);
  m.observe_afresh();
  if (method_.energies) meter_.jump(m.observer, m.view());
  m.commit_jump(method_.energies);
}

/// What constraints do, and loads of inertia, follows from the accelerations with which a step that begins
/// anew begins. These are known when it has been made.
void StepMaker::book_beginning() {
  Mechanism& m = mechanism_;
  integrator_->begun(beginning_);
  const State& seen = m.observe_other(beginning_);
  meter_.begin(m.observer, seen);
  m.observe();
}

/// The end of the step as the energies see it: loads of inertia that stiffen bodies did so by the
/// accelerations of the equations. `known`: the observer's kinematics are of these.
const State& StepMaker::observe_end(bool known) {
  Mechanism& m = mechanism_;
  if (!stressed_) return m.view();
  end_ = m.state;
  integrator_->ended(end_);
  return known ? end_ : m.observe_other(end_);
}

/// One step of the integrator, with the energies after it.
void StepMaker::advance(StepReport& report) {
  Mechanism& m = mechanism_;
  // Runge–Kutta methods are of higher order than what would be corrected.
  const bool corrects = conserves_ || (!free_flight_.none() && !is_runge_kutta(method_.integrator));
  if (corrects) {
    m.observe_afresh();
    free_flight_.begin(m.observer, m.view());
  }
  if (!swarms_.none()) {
    if (!corrects) m.observe_afresh();
    swarms_.find(m.observer.workspace(), integrator_->options().step, m.state.z.data());
  }
  if (!contacts_.none()) contacts_.begin(m.state.z.data(), !method_.energies);
  m.enter(integrator_->options().step);
  const bool begins = !m.state.started && method_.energies && meter_.follows_accelerations();
  if (begins) beginning_ = m.state;
  last_ = integrator_->step(m.state);
  report.code = static_cast<StepReport::Code>(last_.code);
  report.iterations += last_.iterations;
  report.factorisations += last_.factorisations;
  report.raise(last_);
  report.coordinate = last_.coordinate;
  report.equation = last_.equation;
  report.equation_violation = last_.equation_violation;
  report.unconverged = report.unconverged || last_.unconverged;
  if (!report.ok()) return m.enter(0);
  const auto start = method_.profile ? Clock::now() : Clock::time_point();
  if (begins) book_beginning();
  if (m.natural && (corrects || method_.energies || method_.validity || m.remembers())) m.observe();
  if (corrects) {
    free_flight_.end(m.observer, m.natural.get(), m.view(), integrator_->options().step, m.state);
    m.observe();
  }
  if (conserves_) {
    energy_keeper_.end(m.observer, m.natural.get(), observe_end(false), meter_, m.state);
    m.observe();
  }
  if (method_.energies) {
    const bool known = !m.natural && !corrects && !begins;
    meter_.update(m.observer, observe_end(known));
    if (stressed_ && !known) m.observe();
  }
  // Energies have evaluated the forces at the end, else commit() does.
  const auto look_at_contacts = [&] {
    followed_ = contacts_.none() || contacts_.followed(m.observer.workspace(), integrator_->options().step,
                                                       quiet_speed(m.model, length_));
  };
  if (method_.energies) look_at_contacts();
  m.commit(method_.energies);
  if (!method_.energies) look_at_contacts();
  m.enter(0);
  if (conserves_) m.state.energy_error += meter_.last_input();
  if (method_.profile) energy_seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
}

void StepMaker::keep_in(Begin& begin) const {
  begin.state = mechanism_.state;
  begin.meter = meter_;
  begin.log = log_;
  StateTransfer to = StateTransfer::to(begin.memory);
  integrator_->transfer(to);
}

void StepMaker::back_to(const Begin& begin) {
  mechanism_.state = begin.state;
  mechanism_.enter(0);
  meter_ = begin.meter;
  log_ = begin.log;
  StateTransfer from = StateTransfer::from(begin.memory);
  integrator_->transfer(from);
}

void StepMaker::undo() { back_to(before_); }

/// Whether the integrator's last step was. What goes wrong beyond contacts is repeated in parts but once.
bool StepMaker::accurate(int level) const {
  return followed_ && (level > 0 || step_error() <= step_tolerance());
}

/// One step; where an impact made it inaccurate, or it did not converge, the same interval again in parts.
void StepMaker::cover(double length, int level, StepReport& report) {
  Mechanism& m = mechanism_;
  const auto number = static_cast<std::size_t>(level);
  const bool whole = number == begins_.size() || divisions_left_ == 0;
  if (!whole) keep_in(begins_[number]);
  const StepReport before = report;
  advance(report);
  if (report.ok() && (whole || accurate(level))) {
    if (!contacts_.none()) contacts_.note(m.state.time, log_);
    return;
  }
  if (whole || (!report.ok() && level >= levels_of_convergence)) return;
  back_to(begins_[number]);
  --divisions_left_;
  // Of what is accepted.
  report.code = StepReport::Code::ok;
  static_cast<Violations&>(report) = before;
  report.substeps = before.substeps + method_.substeps - 1;
  integrator_->set_step(length / method_.substeps);
  for (int k = 0; k < method_.substeps && report.ok(); ++k)
    cover(length / method_.substeps, level + 1, report);
  integrator_->set_step(length);
  if (!report.ok()) back_to(begins_[number]);
}

/// By how much the next part may be longer than this one. With an error of low order also by what this error
/// is to that of the part before (Gustafsson 1994; Hairer, Wanner 1996, IV.8): changes of step go on.
double StepMaker::growth_by_error(double part, double error) const {
  if (!(error > 0)) return most_growth;
  const int order = integrator_->order_of_error();
  double growth = caution * mimbre::pow(error, -1. / order);
  if (order < predicted_below && accepted_part_ > 0)
    growth = std::min(
        growth, caution * part / accepted_part_ * mimbre::pow(accepted_error_ / (error * error), 1. / order));
  return std::clamp(growth, least_growth, most_growth);
}

/// One step, in parts whose estimated error is within the accuracy.
void StepMaker::cover_by_error(double length, StepReport& report) {
  using Code = StepReport::Code;
  keep_in(begins_[0]);
  double done = 0;
  for (int count = 0; done < length; ++count) {
    const double left = length - done;
    // Two halves rather than a part and a sliver.
    const double part = next_part_ == 0 || next_part_ >= left ? left
                        : next_part_ >= 0.6 * left            ? 0.5 * left
                                                              : next_part_;
    if (count == most_parts_by_error || !(part > round_off_of_time * (mechanism_.state.time + length))) {
      report.code = Code::unstable;
      report.coordinate = -1;
      report.part = part;
      break;
    }
    keep_in(begins_[1]);
    const StepReport before = report;
    integrator_->set_step(part);
    advance(report);
    const bool fails = !report.ok();
    const double error = last_.error;
    const double growth = fails ? least_growth : growth_by_error(part, error);
    if (fails || error > 1) {
      back_to(begins_[1]);
      report.code = Code::ok;
      static_cast<Violations&>(report) = before;
      next_part_ = part * growth;
      continue;
    }
    accepted_part_ = part;
    accepted_error_ = std::max(error, least_error);
    // A short last part says nothing of the next step's first.
    if (part < left || part * growth > next_part_) next_part_ = part * growth;
    if (!contacts_.none()) contacts_.note(mechanism_.state.time, log_);
    done = part == left ? length : done + part;
  }
  integrator_->set_step(length);
  if (!report.ok()) back_to(begins_[0]);
}

StepReport StepMaker::step(double length) {
  Mechanism& m = mechanism_;
  length_ = length;
  if (length != integrator_->options().step) integrator_->set_step(length);
  divisions_left_ = most_divisions();
  StepReport report;
  // Where something jumps, a step that begins anew from there costs another residual and another factor.
  if (method_.fixed_cost && under_way_) m.state.started = true;
  if (!m.state.started) begin_anew();
  if (keeps_) keep_in(before_);
  method_.accuracy > 0 ? cover_by_error(length, report) : cover(length, 0, report);
  if (!report.ok()) return report;
  under_way_ = true;
  // Sums of steps drift away from their multiples by round-off; what an event leaves of one has no multiples.
  if (length != method_.step) return report;
  const double multiple = std::round(m.state.time / length) * length;
  if (std::abs(m.state.time - multiple) < 1e-6 * length) m.state.time = multiple;
  return report;
}

int StepMaker::most_divisions() const {
  if (method_.accuracy > 0) return most_parts_by_error;
  const int levels = static_cast<int>(begins_.size());
  return levels <= 1 ? levels : divisions_a_level * levels;
}

int StepMaker::most_attempts() const {
  return (1 + most_divisions() * method_.substeps) * integrator_->most_attempts();
}

void StepMaker::transfer(StateTransfer& transfer) {
  transfer_integrator(transfer);
  meter_.transfer(transfer);
  for (ContactTrouble& trouble : log_) trouble.transfer(transfer);
  if (method_.fixed_cost) transfer(under_way_);
  if (method_.accuracy > 0) transfer(next_part_, accepted_part_, accepted_error_);
  transfer(last_.iterations, last_.position_violation, last_.angle_violation, last_.velocity_violation,
           last_.angular_velocity_violation);
}

}  // namespace mimbre
