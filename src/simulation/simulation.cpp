#include "mimbre/simulation.h"

#include <chrono>
#include <cmath>

#include "base/cpu_time.h"
#include "base/helper_threads.h"
#include "integrate/initial.h"
#include "integrate/profiled_system.h"
#include "math/decompositions.h"
#include "simulation/assembly.h"
#include "simulation/channels.h"
#include "simulation/energy_monitor.h"
#include "simulation/explain.h"
#include "simulation/reactions.h"
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

/// A step is repeated in parts when its energy is off by more than this per mass, J/kg: what lifts the
/// mechanism by a quarter of a millimetre.
constexpr double substep_energy = 2.5e-3;

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
        reactions(observer),
        validity(compiled),
        scratch(compiled.velocities) {
    double mass = 0;
    for (const BodyData& b : compiled.bodies) mass += b.mass;
    energy_tolerance = mass * substep_energy;
    const double start = thread_cpu_seconds();
    State assembled = assembled_state(compiled, observer);
    if (compiled.spec.simulation.start_at_equilibrium)
      start_at_equilibrium(natural.get(), observer, assembled);
    seen = assembled;
    state = natural ? natural_state(*natural, observer, assembled) : assembled;
    if (!solve_accelerations(system, state))
      throw InputError(
          {compiled.spec.file, 0, 0},
          "the accelerations at the start are not determined: a body without mass (or inertia) is not held "
          "by any joint; give it a mass");
    observe();
    meter.start(observer, view());
    monitor.start(meter);
    watch_validity();
    state_before = state;
    initialisation = thread_cpu_seconds() - start;
    end_helper_threads();
  }

  StepReport step();

  /// One step of the integrator, with the energies after it.
  void advance(StepReport& report) {
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
    meter.update(observer, view());
    if (method.profile) energy_seconds += seconds_since(start);
  }

  /// How wrong the last step may be, J: energy that the numerics put in or took out, or that a jump of a road
  /// did.
  double step_error() const { return std::max(std::abs(meter.last_input()), meter.last_jump()); }

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
    const State& s = view();
    if (natural)
      reactions.find(observer, seen);
    else
      observer.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, scratch.data());
    validity.watch_loads(observer.workspace(), s.time);
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
  double energy_tolerance = 0;
  double initialisation = 0;
  Reactions reactions;
  ValidityMonitor validity;
  Eigen::VectorXd scratch;
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
    if (!report.ok() || s.step_error() > s.energy_tolerance) {
      s.state = s.state_before;
      s.meter = s.meter_before;
      const double h = s.integrator->options().step;
      s.integrator->set_step(h / s.method.substeps);
      report.substeps = s.method.substeps;
      report.code = StepReport::Code::ok;
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
  return mimbre::explain(s.compiled, s.natural.get(), report, s.state.time + step_size());
}

double Simulation::initialisation_seconds() const { return impl_->initialisation; }

Simulation::Snapshot Simulation::save() const {
  const State& s = impl_->state;
  const std::span<const double> marks = impl_->system.tangent_marks();
  return {s.time,
          s.q,
          s.v,
          s.a,
          s.algorithmic,
          s.multipliers,
          s.started,
          Eigen::Map<const Eigen::VectorXd>(marks.data(), static_cast<Eigen::Index>(marks.size()))};
}

void Simulation::restore(const Snapshot& c) {
  impl_->state = {c.time, c.q, c.v, c.a, c.algorithmic, c.multipliers, c.started};
  std::copy(c.marks.begin(), c.marks.end(), impl_->system.tangent_marks().begin());
  impl_->system.begin_step(c.q.data());
  impl_->observe();
  impl_->meter.start(impl_->observer, impl_->view());
  impl_->monitor.start(impl_->meter);
  impl_->validity.start();
  impl_->watch_validity();
}

const std::vector<ChannelInfo>& Simulation::channels() const { return impl_->channels.info(); }
int Simulation::output_count() const { return impl_->channels.output_count(); }

void Simulation::sample(ResultsRow& row) {
  Impl& s = *impl_;
  s.observe();
  if (s.channels.needs_residual()) {
    if (s.natural) find_multipliers(s.observer, s.seen);
    const State& v = s.view();
    s.observer.residual(v.time, v.q.data(), v.v.data(), v.a.data(), v.multipliers.data(), 0,
                        s.scratch.data());
  }
  s.channels.sample(
      s.observer, s.view(), s.meter.balance(),
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
  return h;
}

const EnergyBalance& Simulation::energy() const { return impl_->meter.balance(); }

std::vector<std::string> Simulation::warnings() const {
  std::vector<std::string> all = impl_->validity.warnings();
  // At rest there is nothing at play but round-off.
  if (const std::string text = impl_->monitor.warning(impl_->compiled, 1e-3 * impl_->energy_tolerance);
      !text.empty())
    all.push_back(text);
  return all;
}

std::vector<Validity> Simulation::validity() const { return impl_->validity.worst(); }

int Simulation::degrees_of_freedom() {
  Impl& s = *impl_;
  const int velocities = s.system.velocities();
  if (s.system.equations() == 0) return velocities;
  // Looking factorises; the next step has to find the tangents it left.
  const std::span<double> marks = s.system.tangent_marks();
  const std::vector<double> before(marks.begin(), marks.end());
  const Eigen::MatrixXd jacobian = dense_jacobian(s.system, s.state.time, s.state.q);
  std::copy(before.begin(), before.end(), marks.begin());
  const ColumnOrder columns = order_columns(jacobian, 1e-9);
  s.observe();
  // Where all equations are redundant the largest pivot is round-off, too.
  const bool determined = columns.largest > 1e-12 * s.compiled.length_scale;
  return velocities - (determined ? columns.rank : 0);
}

const Model& Simulation::model() const { return *impl_->model; }

}  // namespace mimbre
