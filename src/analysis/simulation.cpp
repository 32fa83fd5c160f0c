#include "mimbre/simulation.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "analysis/channels.h"
#include "analysis/energy.h"
#include "analysis/reactions.h"
#include "analysis/statics.h"
#include "analysis/validity.h"
#include "dynamics/natural/system.h"
#include "dynamics/relative/system.h"
#include "integrate/initial.h"
#include "integrate/profiled_system.h"
#include "integrate/stepper.h"
#include "math/cpu_time.h"

namespace mimbre {
namespace {

constexpr double default_rho = 0.4;
/// The default integrator repeats an inaccurate step in this many parts,
constexpr int default_substeps = 4;
/// when its energy is off by more than this per mass, J/kg: what lifts the mechanism by a tenth of a
/// millimetre.
constexpr double substep_energy = 2.5e-3;

IntegratorOptions integrator_options(const spec::Simulation& s, const RunOptions& o) {
  IntegratorOptions options;
  options.step = o.step > 0 ? o.step : s.step;
  options.rule = o.integrator.value_or(s.integrator);
  options.xi = o.xi <= 0 ? o.xi : s.xi;
  if (o.xi <= 0) options.rule = IntegratorOptions::Rule::newmark;
  if (o.rho >= 0 && options.rule == IntegratorOptions::Rule::newmark)
    options.rule = IntegratorOptions::Rule::generalized_alpha;
  options.rho = o.rho >= 0 ? o.rho : s.rho >= 0 ? s.rho : default_rho;
  if (s.tolerance > 0) options.tolerance = s.tolerance;
  if (s.penalty > 0) options.penalty = s.penalty;
  if (s.max_iterations > 0) options.max_iterations = s.max_iterations;
  return options;
}

/// Sets what the user gave of a joint's positions and velocities; weights 0 mark given ones.
void set_given(const Compiled& m, State& s, Eigen::VectorXd& position_weight,
               Eigen::VectorXd& velocity_weight) {
  for (const BodyData& b : m.bodies) {
    const spec::Joint& joint = m.spec.joints[b.joint_spec];
    const JointInfo& info = joint_info(joint.type);
    // Modes start straight and at rest unless the loops need them.
    position_weight.segment(b.v + b.joint_velocities, b.modes).setZero();
    velocity_weight.segment(b.v + b.joint_velocities, b.modes).setZero();
    if (info.quaternion >= 0) s.q[b.q + info.quaternion] = 1;
    Vec3d turn = Vec3d::Zero();
    for (int k = 0; k < static_cast<int>(joint.initial_position.size()); ++k) {
      if (!joint.initial_position[k]) continue;
      position_weight[b.v + k] = 0;
      const bool rotation = info.quaternion >= 0 && k >= info.rotation;
      if (rotation)
        turn[k - info.rotation] = *joint.initial_position[k];
      else
        s.q[b.q + k] = *joint.initial_position[k];
    }
    if (info.quaternion >= 0) s.q.segment<4>(b.q + info.quaternion) = quaternion_exp<double>(turn);
    for (int k = 0; k < static_cast<int>(joint.initial_velocity.size()); ++k) {
      if (!joint.initial_velocity[k]) continue;
      velocity_weight[b.v + k] = 0;
      s.v[b.v + k] = *joint.initial_velocity[k];
    }
  }
  for (const DriveData& d : m.drives) {
    s.q[d.q] = d.position.value(0);
    s.v[d.v] = d.position.derivative(0);
  }
}

State assembled_state(const Compiled& m, relative::RelativeSystem& system) {
  State s;
  s.q.setZero(m.positions);
  s.v.setZero(m.velocities);
  s.a.setZero(m.velocities);
  s.algorithmic.setZero(m.velocities);
  s.multipliers.setZero(m.equations);
  Eigen::VectorXd position_weight = Eigen::VectorXd::Ones(m.velocities), velocity_weight = position_weight;
  set_given(m, s, position_weight, velocity_weight);
  system.begin_step(s.q.data());

  const auto where = [&](double gap, const double* violation, const char* what, const char* unit) {
    for (const LoopData& l : m.loops)
      for (int r = 0; r < l.count; ++r)
        if (std::abs(violation[l.first_equation + r]) >= 0.99 * gap) {
          const spec::Joint& j = m.spec.joints[l.joint_spec];
          return InputError(
              j.mark, fmt::format("the loop through joint '{}' {}: {:.3g} {} is left; check the points "
                                  "and axes of the joints in the loop and the initial values that are given",
                                  j.name, what, gap, unit));
        }
    return InputError(
        {}, fmt::format("a driven joint contradicts the initial values: {:.3g} {} is left", gap, unit));
  };
  const double close_enough = 1e-8;
  double gap = close_positions(system, 0, position_weight, s.q);
  if (gap > close_enough) {  // let the modes help
    for (const BodyData& b : m.bodies) position_weight.segment(b.v + b.joint_velocities, b.modes).setOnes();
    gap = close_positions(system, 0, position_weight, s.q);
  }
  if (!(gap <= close_enough)) throw where(gap, system.phi(), "cannot be closed", "m");
  gap = close_velocities(system, 0, s.q, velocity_weight, s.v);
  if (gap > close_enough) {
    for (const BodyData& b : m.bodies) velocity_weight.segment(b.v + b.joint_velocities, b.modes).setOnes();
    gap = close_velocities(system, 0, s.q, velocity_weight, s.v);
  }
  if (!(gap <= close_enough)) throw where(gap, system.phi_dot(), "contradicts the initial velocities", "m/s");
  return s;
}

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Where a velocity coordinate belongs, for messages.
std::string coordinate_name(const Compiled& m, int coordinate) {
  for (const BodyData& b : m.bodies)
    if (coordinate >= b.v && coordinate < b.v + b.size()) {
      const int k = coordinate - b.v;
      if (k < b.joint_velocities) return fmt::format("joint '{}'", m.spec.joints[b.joint_spec].name);
      return fmt::format("mode {} of body '{}'", k - b.joint_velocities + 1, m.spec.bodies[b.spec].name);
    }
  return "the model";
}

std::string natural_name(const natural::NaturalSystem& system, int coordinate) {
  const int body = coordinate < 0 ? -1 : system.body_of(coordinate);
  if (body < 0) return "the model";
  return fmt::format("body '{}'", system.model().spec.bodies[system.model().bodies[body].spec].name);
}

/// The joint (or the body that must stay rigid) that a constraint equation belongs to, for messages.
std::string equation_name(const Compiled& m, const natural::NaturalSystem* natural, int equation) {
  const auto joint = [&](int spec) { return fmt::format("joint '{}'", m.spec.joints[spec].name); };
  if (natural) {
    const natural::Layout& l = natural->layout();
    for (std::size_t b = 0; b < l.bodies.size(); ++b)
      if (equation >= l.bodies[b].first_equation &&
          equation < l.bodies[b].first_equation + static_cast<int>(l.bodies[b].rigidity.size()))
        return fmt::format("the rigidity of body '{}'", m.spec.bodies[m.bodies[b].spec].name);
    for (const natural::Joint& j : l.joints)
      if (equation >= j.first_equation && equation < j.first_equation + j.count) return joint(j.spec);
    if (equation >= l.first_drive)
      return "the drive of " + joint(m.drives[equation - l.first_drive].joint_spec);
  } else {
    for (const LoopData& loop : m.loops)
      if (equation >= loop.first_equation && equation < loop.first_equation + loop.count)
        return joint(loop.joint_spec);
    for (const DriveData& d : m.drives)
      if (equation == d.equation) return "the drive of " + joint(d.joint_spec);
  }
  return "the constraints";
}

std::string place_name(const Compiled& m, const EnergyMeter::Place& place) {
  switch (place.kind) {
    case EnergyMeter::Place::Kind::spring:
      return fmt::format("spring '{}'", m.spec.springs[m.springs[place.index].spec].name);
    case EnergyMeter::Place::Kind::tyre:
      return fmt::format("tyre '{}'", m.spec.tyres[m.tyres[place.index].spec].name);
    case EnergyMeter::Place::Kind::none:
      break;
  }
  return "the joints";
}

/// Watches the energy that the numerics feed in, from its lowest level on. More than `share` of the energy
/// that was at play in the run (largest kinetic and stored energy, against the start) makes a warning.
struct EnergyMonitor {
  static constexpr double share = 0.01;
  double start_gravity = 0, at_play = 0, lowest = 0, fed = 0;
  double largest_input = 0, largest_at = 0;  // of a step
  EnergyMeter::Place largest_place;

  void start(const EnergyMeter& meter) {
    *this = {};
    start_gravity = meter.balance().gravitational;
    at_play = meter.balance().total() - start_gravity;
  }

  void watch(const EnergyMeter& meter, double time) {
    const EnergyBalance& e = meter.balance();
    at_play = std::max(
        at_play, e.kinetic + e.elastic + e.springs + e.tyres + std::abs(e.gravitational - start_gravity));
    lowest = std::min(lowest, e.numerical);
    fed = std::max(fed, e.numerical - lowest);
    if (meter.last_input() > largest_input) {
      largest_input = meter.last_input();
      largest_at = time;
      largest_place = meter.last_place();
    }
  }
};

std::unique_ptr<natural::NaturalSystem> make_natural(const Compiled& m, const RunOptions& o) {
  const spec::Simulation& s = m.spec.simulation;
  if (o.formulation.value_or(s.formulation) != spec::Simulation::Formulation::natural) return nullptr;
  return std::make_unique<natural::NaturalSystem>(m, o.inertia.value_or(s.inertia));
}

/// A state in relative coordinates by points and vectors.
State natural_state(const natural::NaturalSystem& natural, relative::RelativeSystem& observer,
                    const State& s) {
  observer.begin_step(s.q.data());
  observer.kinematics(s.time, s.q.data(), s.v.data(), s.a.data());
  return natural.from_relative(s, observer.workspace().bodies, observer.workspace().origin);
}

/// Static equilibrium near s, found in natural coordinates if there is such a system.
StaticsStatus equilibrium(natural::NaturalSystem* natural, relative::RelativeSystem& observer, State& s) {
  if (!natural) return find_equilibrium(observer, s);
  State n = natural_state(*natural, observer, s);
  const StaticsStatus status = find_equilibrium(*natural, n);
  natural->to_relative(n, s);
  observer.begin_step(s.q.data());
  find_multipliers(observer, s);
  return status;
}

}  // namespace

struct Simulation::Impl {
  explicit Impl(std::shared_ptr<const Model> m, const RunOptions& o)
      : model(std::move(m)),
        compiled(model->compiled()),
        observer(compiled, o.inertia.value_or(compiled.spec.simulation.inertia)),
        natural(make_natural(compiled, o)),
        system(natural ? static_cast<System&>(*natural) : observer),
        profiled(system),
        profile(o.profile),
        integrator(make_stepper(o.profile ? static_cast<System&>(profiled) : system,
                                o.formalism.value_or(compiled.spec.simulation.formalism),
                                integrator_options(compiled.spec.simulation, o))),
        meter(compiled),
        channels(compiled),
        meter_before(compiled),
        reactions(observer),
        validity(compiled),
        scratch(compiled.velocities) {
    const spec::Simulation& options = compiled.spec.simulation;
    const bool index3 = o.formalism.value_or(options.formalism) == spec::Simulation::Formalism::index3;
    substeps = o.substeps > 0                                                              ? o.substeps
               : options.substeps > 0                                                      ? options.substeps
               : !index3 || integrator->options().rule == IntegratorOptions::Rule::newmark ? 1
                                                                                           : default_substeps;
    double mass = 0;
    for (const BodyData& b : compiled.bodies) mass += b.mass;
    energy_tolerance = mass * substep_energy;
    const double start = thread_cpu_seconds();
    State assembled = assembled_state(compiled, observer);
    if (compiled.spec.simulation.start_at_equilibrium) {
      const Eigen::VectorXd velocities = assembled.v;
      const StaticsStatus status = equilibrium(natural.get(), observer, assembled);
      if (!status.converged)
        throw InputError(
            {compiled.spec.file, 0, 0},
            fmt::format("`initial: equilibrium`: no static equilibrium was found (unbalanced force {:.3g} "
                        "after {} iterations); start from the assembled position instead",
                        status.residual, status.iterations));
      assembled.v = velocities;
      const double gap =
          close_velocities(observer, 0, assembled.q, Eigen::VectorXd::Ones(compiled.velocities), assembled.v);
      if (!(gap < 1e-8))
        throw InputError({compiled.spec.file, 0, 0}, "the initial velocities contradict the constraints");
    }
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
    const auto start = profile ? Clock::now() : Clock::time_point();
    if (natural) observe();
    meter.update(observer, view());
    if (profile) energy_seconds += seconds_since(start);
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
  relative::RelativeSystem observer;  ///< the system itself in relative coordinates
  std::unique_ptr<natural::NaturalSystem> natural;
  System& system;
  ProfiledSystem profiled;
  bool profile;
  double step_seconds = 0, energy_seconds = 0;
  std::unique_ptr<Stepper> integrator;
  EnergyMeter meter;
  Channels channels;
  State state, seen;
  StepStatus last;
  State state_before;
  EnergyMeter meter_before;
  EnergyMonitor monitor;
  int substeps = 1;
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
  if (!impl_->profile) return impl_->step();
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
  if (s.substeps == 1) {
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
      s.integrator->set_step(h / s.substeps);
      report.substeps = s.substeps;
      report.code = StepReport::Code::ok;
      for (int k = 0; k < s.substeps && report.ok(); ++k) s.advance(report);
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
double Simulation::step_size() const { return impl_->integrator->options().step; }
int Simulation::coordinates() const { return impl_->system.velocities(); }
int Simulation::constraints() const { return impl_->system.equations(); }
double Simulation::initialisation_seconds() const { return impl_->initialisation; }

std::string Simulation::explain(const StepReport& r) const {
  const Impl& s = *impl_;
  const std::string where =
      s.natural ? natural_name(*s.natural, r.coordinate) : coordinate_name(s.compiled, r.coordinate);
  const double t = s.state.time + s.integrator->options().step;
  switch (r.code) {
    case StepReport::Code::ok:
      return "ok";
    case StepReport::Code::not_converged:
      return fmt::format(
          "the step to t = {:.6g} s did not converge in {} iterations, the largest correction in {}; "
          "a smaller step or an integrator with more damping (smaller rho) may help",
          t, r.iterations, where);
    case StepReport::Code::not_finite:
      return fmt::format("a number is not finite in the step to t = {:.6g} s, first in {}", t, where);
    case StepReport::Code::drifted:
      return fmt::format(
          "the constraints have come apart in the step to t = {:.6g} s: {} is off by {:.3g} m; this "
          "formalism "
          "does not hold them, take `index3`, a stabilised one or a smaller step",
          t, equation_name(s.compiled, s.natural.get(), r.equation), r.position_violation);
    case StepReport::Code::singular:
      if (r.equation >= 0)
        return fmt::format(
            "the constraints are dependent in the step to t = {:.6g} s, at {}: a singular position, or a "
            "joint "
            "too many; take a formalism that bears it (`index3`, `penalty`, `index1_augmented`)",
            t, equation_name(s.compiled, s.natural.get(), r.equation));
      return fmt::format(
          "the matrix of the step to t = {:.6g} s is singular at {}: is there a body without mass that "
          "nothing holds?",
          t, where);
  }
  return {};
}

Simulation::Snapshot Simulation::save() const {
  const State& s = impl_->state;
  return {s.time, s.q, s.v, s.a, s.algorithmic, s.multipliers, s.started};
}

void Simulation::restore(const Snapshot& c) {
  impl_->state = {c.time, c.q, c.v, c.a, c.algorithmic, c.multipliers, c.started};
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

Simulation::Energy Simulation::energy() const {
  const EnergyBalance& e = impl_->meter.balance();
  return {e.kinetic,    e.gravitational, e.elastic,   e.springs,   e.tyres,
          e.dissipated, e.drive_work,    e.load_work, e.road_work, e.numerical};
}

std::vector<std::string> Simulation::warnings() const {
  const EnergyMonitor& m = impl_->monitor;
  std::vector<std::string> all = impl_->validity.warnings();
  // At rest there is nothing at play but round-off.
  if (m.fed <= std::max(EnergyMonitor::share * m.at_play, 1e-3 * impl_->energy_tolerance)) return all;
  all.push_back(fmt::format(
      "the numerics fed in {:.3g} J, more than {:g} % of the {:.3g} J at play; the most in the step to t = "
      "{:.6g} s, {:.3g} J at {}: do not trust this run; take a smaller step or an integrator with damping "
      "(the default, generalised-alpha)",
      m.fed, 100 * EnergyMonitor::share, m.at_play, m.largest_at, m.largest_input,
      place_name(impl_->compiled, m.largest_place)));
  return all;
}

std::vector<Validity> Simulation::validity() const { return impl_->validity.worst(); }

int Simulation::degrees_of_freedom() {
  Impl& s = *impl_;
  const int velocities = s.system.velocities();
  if (s.system.equations() == 0) return velocities;
  const Eigen::MatrixXd jacobian = dense_jacobian(s.system, s.state.time, s.state.q);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(jacobian.rows(), jacobian.cols());
  qr.setThreshold(1e-9);
  qr.compute(jacobian);
  s.observe();
  // Where all equations are redundant the largest pivot is round-off, too.
  const bool determined = std::abs(qr.maxPivot()) > 1e-12 * s.compiled.length_scale;
  return velocities - (determined ? static_cast<int>(qr.rank()) : 0);
}

const Model& Simulation::model() const { return *impl_->model; }

StaticResult static_equilibrium(std::shared_ptr<const Model> model, const RunOptions& options) {
  const double start = thread_cpu_seconds();
  const Compiled& m = model->compiled();
  relative::RelativeSystem system(m, options.inertia.value_or(m.spec.simulation.inertia));
  const auto natural = make_natural(m, options);
  State s = assembled_state(m, system);
  const StaticsStatus status = equilibrium(natural.get(), system, s);
  if (!status.converged)
    throw std::runtime_error(
        fmt::format("no static equilibrium was found: unbalanced force {:.3g}, constraints off by "
                    "{:.3g} after {} iterations",
                    status.residual, status.violation, status.iterations));
  StaticResult result;
  Channels channels(m);
  EnergyMeter meter(m);
  Eigen::VectorXd r(m.velocities);
  system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  meter.start(system, s);
  system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  ResultsRow row;
  channels.sample(system, s, meter.balance(), {}, row);
  result.channels = channels.info();
  result.values = row.channels;
  result.output_count = channels.output_count();
  result.iterations = status.iterations;
  result.residual = status.residual;
  result.cpu_seconds = thread_cpu_seconds() - start;
  return result;
}

}  // namespace mimbre
