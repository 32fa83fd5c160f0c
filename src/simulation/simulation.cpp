#include "mimbre/simulation.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "base/cpu_time.h"
#include "base/helper_threads.h"
#include "integrate/initial.h"
#include "integrate/profiled_system.h"
#include "simulation/assembly.h"
#include "simulation/channels.h"
#include "simulation/drawn_open.h"
#include "simulation/drive_smoothness.h"
#include "simulation/element_drawings.h"
#include "simulation/energy_keeper.h"
#include "simulation/energy_monitor.h"
#include "simulation/explain.h"
#include "simulation/free_flight.h"
#include "simulation/reactions.h"
#include "simulation/redundancy.h"
#include "simulation/start_branches.h"
#include "simulation/validity.h"

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
  options.max_iterations = method.max_iterations;
  return options;
}

/// A step is repeated in parts when its energy is off by more than these shares of what moves or is stored,
/// and of what would lift the mechanism by its length scale; without gravity of the former alone.
constexpr double substep_energy = 1e-4, substep_lifting = 1e-3, substep_without_gravity = 4e-4;
/// Of the energy that lifts the mechanism so, or without gravity moves it by its length scale in a second:
/// round-off.
constexpr double round_off_energy = 2.5e-7;

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

struct Simulation::Impl {
  Impl(std::shared_ptr<const Model> m, const RunOptions& options)
      : model(std::move(m)),
        compiled(model->compiled()),
        method(resolve_method(compiled.spec.simulation, options)),
        observer(compiled, method.inertia),
        natural(make_natural(compiled, method)),
        system(natural ? static_cast<System&>(*natural) : observer),
        profiled(system),
        integrator(make_stepper(method.profile ? static_cast<System&>(profiled) : system, method.formalism,
                                integrator_options(method))),
        meter(compiled),
        channels(compiled),
        meter_before(compiled),
        free_flight(compiled),
        conserves(method.integrator == spec::Simulation::Integrator::conserve),
        energy_keeper(compiled, free_flight.groups()),
        reactions(observer),
        eyes(!natural && compiled.equations > 0
                 ? std::make_unique<relative::RelativeSystem>(compiled, method.inertia)
                 : nullptr),
        validity(compiled),
        scratch(compiled.velocities) {
    double mass = 0;
    for (const BodyData& b : compiled.bodies) mass += b.mass;
    const double extent = compiled.length_scale, weight = mass * compiled.gravity.norm();
    lifting_energy = weight * extent;
    resting_energy = round_off_energy * std::max(weight, mass * extent) * extent;
    const double start = thread_cpu_seconds();
    State assembled = assembled_state(compiled, observer);
    warn(drawn_open(observer, assembled));
    if (compiled.spec.simulation.start_at_equilibrium) warn(start_at_equilibrium(observer, assembled));
    seen = assembled;
    if (compiled.equations > 0) {
      redundancy = find_redundancy(observer, assembled);
      warn(explain_near_redundancy(redundancy));
      channels.mark_undetermined(redundancy);
      reactions.choose_smallest(compiled, redundancy.equations + redundancy.nearly > 0);
    }
    state = natural ? natural_state(*natural, observer, assembled) : assembled;
    if (!solve_accelerations(system, state))
      throw InputError({compiled.spec.file, 0, 0}, explain_undetermined_start(compiled));
    if (conserves && !compiled.drives.empty())
      warn(fmt::format(
          "integrator conserve: drives prescribe velocities, so that {} to take back the energy that the "
          "numerics feed in; look at energy.numerical, or take a smaller step",
          free_flight.none() ? "nothing is left" : "only turns of what flies freely are left"));
    observe();
    warn(explain_branches(observer, view()));
    meter.start(observer, view());
    monitor.start(meter);
    watch_validity();
    state_before = state;
    initialisation = thread_cpu_seconds() - start;
    end_helper_threads();
  }

  StepReport step();

  void warn(const std::string& text) {
    if (!text.empty()) start_warnings.push_back(text);
  }

  /// One step of the integrator, with the energies after it.
  void advance(StepReport& report) {
    const bool corrects = conserves || !free_flight.none();
    if (corrects) {
      if (!natural) observer.begin_step(state.q.data());
      observe();
      free_flight.begin(observer, view());
      if (conserves) energy_keeper.begin(observer, view());
    }
    last = integrator->step(state);
    report.code = static_cast<StepReport::Code>(last.code);
    report.iterations += last.iterations;
    report.factorisations += last.factorisations;
    report.position_violation = std::max(report.position_violation, last.position_violation);
    report.velocity_violation = std::max(report.velocity_violation, last.velocity_violation);
    report.coordinate = last.coordinate;
    report.equation = last.equation;
    if (!report.ok()) return;
    const auto start = method.profile ? Clock::now() : Clock::time_point();
    if (natural) observe();
    if (corrects) {
      free_flight.end(observer, natural.get(), view(), integrator->options().step, state);
      observe();
    }
    if (conserves) {
      energy_keeper.end(observer, natural.get(), view(), state);
      observe();
    }
    meter.update(observer, view());
    if (conserves) state.energy_error += meter.last_input();
    if (method.profile) energy_seconds += seconds_since(start);
  }

  /// How wrong the last step may be, J: energy that the numerics put in or took out, or that a jump of a road
  /// did.
  double step_error() const { return std::max(std::abs(meter.last_input()), meter.last_jump()); }

  /// What it may be.
  double step_tolerance() const {
    const EnergyBalance& e = meter.balance();
    const double play = e.kinetic + e.elastic + e.springs + e.tyres;
    return lifting_energy > 0 ? substep_energy * play + substep_lifting * lifting_energy
                              : substep_without_gravity * play;
  }

  /// The state in relative coordinates, in which energies and outputs are evaluated whatever the formulation.
  const State& view() const { return natural ? seen : state; }
  /// Kinematics at the state, for energies and output.
  void observe() {
    if (natural) {
      natural->to_relative(state, seen);
      observer.begin_step(seen.q.data());
    }
    const State& s = view();
    observer.kinematics(s.time, s.q.data(), s.v.data(), s.a.data());
  }

  /// What linear theory neglects, at an accepted state.
  void watch_validity() {
    validity.watch(view());
    if (!validity.loads_due()) return;
    validity.watch_loads(find_reactions().workspace(), view().time);
  }

  /// The reactions to show: in `seen`, but for open chains, which have none but what balances them. The
  /// system returned has them in its last residual. Where the constraints determine them, they are the
  /// integrator's own (natural coordinates: what balances its accelerations); elsewhere, also at singular
  /// positions on the way, the smallest ones, and within a step of those no more than is resolved. The
  /// integrator, and what it keeps from step to step, is left alone.
  relative::RelativeSystem& find_reactions() {
    relative::RelativeSystem& system_seen = eyes ? *eyes : observer;
    const auto evaluate = [&](const State& s) {
      system_seen.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0,
                           scratch.data());
    };
    if (natural) {
      reactions.find(observer, seen);
      reactions.limit(observer, seen, method.step);
      return observer;
    }
    if (eyes) {
      seen = state;
      eyes->begin_step(seen.q.data());
      if (!reactions.find(*eyes, seen) || reactions.determined()) {
        seen.multipliers = state.multipliers;
        evaluate(seen);
      }
      reactions.limit(*eyes, seen, method.step);
      return *eyes;
    }
    evaluate(state);
    return system_seen;
  }

  std::shared_ptr<const Model> model;
  const Compiled& compiled;
  const Method method;
  relative::RelativeSystem observer;  ///< the system itself in relative coordinates
  std::unique_ptr<natural::NaturalSystem> natural;
  System& system;
  ProfiledSystem profiled;
  double step_seconds = 0, energy_seconds = 0;
  std::unique_ptr<Stepper> integrator;
  EnergyMeter meter;
  Channels channels;
  State state, seen;
  StepStatus last;
  State state_before;
  EnergyMeter meter_before;
  EnergyMonitor monitor;
  double lifting_energy = 0;  ///< of the whole mechanism by its length scale, J
  double resting_energy = 0;  ///< what is round-off when nothing is at play, J
  double initialisation = 0;
  FreeFlight free_flight;
  const bool conserves;
  EnergyKeeper energy_keeper;
  double length = method.step;  ///< of the step that is made, s
  Reactions reactions;
  std::unique_ptr<relative::RelativeSystem> eyes;  ///< for reactions of loops in relative coordinates
  ValidityMonitor validity;
  std::vector<std::string> drives;  ///< what was said of them, found when first asked for
  double drives_until = 0;
  Eigen::VectorXd scratch;
  std::vector<std::string> start_warnings;
  Redundancy redundancy;  ///< at the start
};

Simulation::Simulation(std::shared_ptr<const Model> model, const RunOptions& options)
    : impl_(std::make_unique<Impl>(std::move(model), options)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;

StepReport Simulation::step() {
  if (!impl_->method.profile) return impl_->step();
  const auto start = Clock::now();
  const StepReport report = impl_->step();
  impl_->step_seconds += seconds_since(start);
  return report;
}

StepReport Simulation::step_to(double time) {
  Impl& s = *impl_;
  // Times are sums of steps: a whole step but for rounding is a whole step.
  const double rest = time - s.state.time;
  const bool whole = std::abs(rest - s.method.step) < 1e-6 * s.method.step;
  s.length = whole ? s.method.step : rest;
  s.integrator->set_step(s.length);
  const StepReport report = step();
  s.integrator->set_step(s.method.step);
  if (report.ok()) s.state.time = time;
  return report;
}

Simulation::Phases Simulation::phases() const {
  const Impl& s = *impl_;
  const PhaseSeconds& p = s.profiled.seconds();
  Phases phases{p.residual, p.matrix, p.solution, p.kinematics, s.energy_seconds, 0};
  phases.other = s.step_seconds - p.residual - p.matrix - p.solution - p.kinematics - s.energy_seconds;
  return phases;
}

StepReport Simulation::Impl::step() {
  Impl& s = *this;
  StepReport report;
  if (s.method.substeps == 1) {
    s.advance(report);
  } else {
    // One step; where an impact made it inaccurate, or it did not converge, the same interval again in parts.
    s.state_before = s.state;
    s.meter_before = s.meter;
    s.advance(report);
    if (!report.ok() || s.step_error() > s.step_tolerance()) {
      s.state = s.state_before;
      s.meter = s.meter_before;
      const double h = s.integrator->options().step;
      s.integrator->set_step(h / s.method.substeps);
      report.substeps = s.method.substeps;
      report.code = StepReport::Code::ok;
      report.position_violation = report.velocity_violation = 0;  // of what is accepted
      for (int k = 0; k < s.method.substeps && report.ok(); ++k) s.advance(report);
      s.integrator->set_step(h);
      if (!report.ok()) {
        s.state = s.state_before;
        s.meter = s.meter_before;
      }
    }
  }
  if (!report.ok()) return report;
  // Sums of steps drift away from their multiples by round-off.
  const double h = s.integrator->options().step, multiple = std::round(s.state.time / h) * h;
  if (std::abs(s.state.time - multiple) < 1e-6 * h) s.state.time = multiple;
  s.monitor.watch(s.meter, s.state.time);
  s.watch_validity();
  return report;
}

double Simulation::time() const { return impl_->state.time; }
double Simulation::step_size() const { return impl_->method.step; }
const Method& Simulation::method() const { return impl_->method; }
int Simulation::coordinates() const { return impl_->system.velocities(); }
int Simulation::constraints() const { return impl_->system.equations(); }

std::string Simulation::explain(const StepReport& report) const {
  const Impl& s = *impl_;
  return mimbre::explain(s.compiled, s.natural.get(), report, s.state.time + s.length);
}

double Simulation::initialisation_seconds() const { return impl_->initialisation; }

Simulation::Snapshot Simulation::save() const {
  const State& s = impl_->state;
  const std::span<const double> marks = impl_->system.tangent_marks();
  return {
      s.time,        s.q,
      s.v,           s.a,
      s.algorithmic, s.multipliers,
      s.started,     Eigen::Map<const Eigen::VectorXd>(marks.data(), static_cast<Eigen::Index>(marks.size())),
      s.energy_error};
}

void Simulation::restore(const Snapshot& c) {
  impl_->state = {c.time, c.q, c.v, c.a, c.algorithmic, c.multipliers, c.energy_error, c.started};
  std::copy(c.marks.begin(), c.marks.end(), impl_->system.tangent_marks().begin());
  impl_->system.begin_step(c.q.data());
  impl_->observe();
  impl_->meter.start(impl_->observer, impl_->view());
  impl_->monitor.start(impl_->meter);
  impl_->validity.start();
  impl_->reactions.forget_unresolved();
  impl_->watch_validity();
}

const std::vector<ChannelInfo>& Simulation::channels() const { return impl_->channels.info(); }
int Simulation::output_count() const { return impl_->channels.output_count(); }

void Simulation::sample(ResultsRow& row) {
  Impl& s = *impl_;
  s.observe();
  relative::RelativeSystem& system = s.find_reactions();
  s.channels.sample(
      system, s.natural || s.eyes ? s.seen : s.state, s.meter.balance(),
      {static_cast<double>(s.last.iterations), s.last.position_violation, s.last.velocity_violation}, row);
}

ResultsHeader Simulation::header(const std::string& options_json) const {
  const Impl& s = *impl_;
  ResultsHeader h;
  h.title = s.compiled.spec.title;
  h.model_text = s.compiled.spec.text;
  h.options_json = options_json;
  h.step = step_size();
  h.channels = s.channels.info();
  h.bodies = s.channels.drawings();
  h.roads = s.channels.roads();
  ElementDrawings drawn = element_drawings(s.compiled, h.bodies);
  h.frames = std::move(drawn.frames);
  h.elements = std::move(drawn.elements);
  return h;
}

const EnergyBalance& Simulation::energy() const { return impl_->meter.balance(); }

std::vector<std::string> Simulation::warnings() const {
  std::vector<std::string> all = impl_->start_warnings;
  for (const std::string& text : impl_->validity.warnings()) all.push_back(text);
  if (const auto& unresolved = impl_->reactions.unresolved())
    all.push_back(explain_unresolved(impl_->compiled, *unresolved));
  // At rest there is nothing at play but round-off.
  if (const std::string text = impl_->monitor.warning(impl_->compiled, impl_->meter, impl_->resting_energy);
      !text.empty())
    all.push_back(text);
  if (const double end = std::max(impl_->compiled.spec.simulation.end, time()); end > impl_->drives_until) {
    impl_->drives = drive_warnings(impl_->compiled, end);
    impl_->drives_until = end;
  }
  all.insert(all.end(), impl_->drives.begin(), impl_->drives.end());
  return all;
}

std::vector<Validity> Simulation::validity() const { return impl_->validity.worst(); }

Redundancy Simulation::redundancy() {
  Impl& s = *impl_;
  if (!s.state.started) return s.redundancy;
  // Looking factorises; the next step has to find the tangents it left.
  const std::span<double> marks = s.observer.tangent_marks();
  const std::vector<double> before(marks.begin(), marks.end());
  Redundancy redundancy = find_redundancy(s.observer, s.view());
  std::copy(before.begin(), before.end(), marks.begin());
  s.observe();
  return redundancy;
}

int Simulation::degrees_of_freedom() {
  const Compiled& m = impl_->compiled;
  return m.velocities - (m.equations - redundancy().equations);
}

const Model& Simulation::model() const { return *impl_->model; }

}  // namespace mimbre
