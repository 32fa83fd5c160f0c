#include "mimbre/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <type_traits>

#include "base/cpu_time.h"
#include "integrate/explicit/fastest_motion.h"
#include "simulation/describe/body_drawings.h"
#include "simulation/describe/drive_limit.h"
#include "simulation/describe/element_drawings.h"
#include "simulation/describe/explain.h"
#include "simulation/describe/names.h"
#include "simulation/describe/singular_position.h"
#include "simulation/observe/channels.h"
#include "simulation/observe/observers.h"
#include "simulation/observe/recorded_sections.h"
#include "simulation/observe/shown_reactions.h"
#include "simulation/start/choose_integrator.h"
#include "simulation/start/held_elsewhere.h"
#include "simulation/start/jumping_law.h"
#include "simulation/start/redundancy.h"
#include "simulation/start/start.h"
#include "simulation/state/fingerprint.h"
#include "simulation/step/event_step.h"
#include "simulation/step/mechanism.h"
#include "simulation/step/signal_state.h"
#include "simulation/step/step_maker.h"
#include "simulation/watch/range_watch.h"

namespace mimbre {
namespace {

/// Throws std::out_of_range for a handle of nothing; `call`: that was given it.
template <class Items>
void require_handle(int index, const Items& items, const char* call, const char* what) {
  if (index < 0 || index >= std::ssize(items))
    throw std::out_of_range(fmt::format("{}: there is no {} {}; they are counted from 0 to {}", call, what,
                                        index, std::ssize(items) - 1));
}

}  // namespace

/// The parts, in the order in which they are made: the mechanism is put where it starts, then it is stepped,
/// watched and shown.
struct Simulation::Impl {
  using Clock = std::chrono::steady_clock;

  Impl(std::shared_ptr<const Model> m, const RunOptions& options)
      : model(std::move(m)),
        compiled(model->compiled()),
        method(
            choose_integrator(compiled, resolve_method(compiled.spec().simulation, options), options.inputs)),
        mechanism(compiled, method),
        steps(mechanism, method),
        channels(compiled),
        sampler(compiled, method.step),
        ranges(compiled),
        events(compiled, ranges),
        begin(timed([&] { return start(mechanism, method, options.inputs, method.warnings); })),
        observers(mechanism, method, redundant()),
        reactions(mechanism, method, redundant()) {
    channels.mark_undetermined(begin.redundancy);
    timed([&] { observe_anew(); });
    for (const auto& [name, value] : options.inputs)
      ranges.set(find_input(compiled, name), value, mechanism.state.time);
    steps.keep_before(!events.none() && !method.fixed_cost);
  }

  /// Work whose time counts as initialisation.
  template <class Work>
  std::invoke_result_t<Work> timed(Work&& work) {
    struct Stopwatch {
      double& sum;
      double from = thread_cpu_seconds();
      ~Stopwatch() { sum += thread_cpu_seconds() - from; }
    } watch{initialisation};
    return work();
  }

  bool redundant() const { return begin.redundancy.equations + begin.redundancy.nearly > 0; }

  /// Energies and warnings count from the state of now; kinematics evaluated.
  void observe_anew() {
    steps.start();
    observers.start(mechanism, steps.meter());
    ranges.start();
    reactions.forget_unresolved();
    look_anew();
    if (!events.none()) see([&](auto&... seen_now) { events.start(seen_now...); });
    stopped = false;
  }

  /// Calls `work` with what events see: the state of now, evaluated.
  template <class Work>
  auto see(const Work& work)
      -> std::invoke_result_t<Work, Channels&, relative::RelativeSystem&, const State&> {
    if (events.needs() == Channels::Needs::reactions)
      show_reactions();
    else
      show_forces();
    return work(channels, *seen_by, *seen);
  }

  /// Signals and laws that are evaluated at instants, before the step that sees them.
  /// False: a block from elsewhere failed.
  bool sample_signals() {
    if (sampler.none()) return true;
    show_motion();
    relative::RelativeSystem& evaluated = reactions.find(mechanism);
    return sampler.sample(channels, evaluated, reactions.state(), method.step, mechanism.state);
  }

  /// What has jumped since the last step is what blocks start from; where a relay switches by that, its
  /// output has jumped, too.
  void take_jumps() {
    for (int k = 0; k < longest_chain && inputs_jumped(compiled, mechanism.state); ++k) {
      mechanism.enter(0);
      look_anew();
      show_forces();
      commit_blocks(compiled, mechanism.observer, mechanism.state);
      look_anew();
    }
  }

  void watch() { observers.watch(mechanism, steps.meter(), steps.length()); }

  StepReport step(double length) {
    stopped = false;
    jump.reset();
    if (!sample_signals()) {
      look_anew();
      StepReport failed;
      failed.code = StepReport::Code::block_failed;
      return failed;
    }
    take_jumps();
    look_anew();
    const auto start = method.profile ? Clock::now() : Clock::time_point();
    StepReport report;
    if (events.none()) {
      report = steps.step(length);
      if (report.ok()) watch();
    } else {
      EventStep<Impl> parts(*this, events, mechanism, steps, method.step);
      stopped_step_end = on_grid(mechanism.state.time + length);
      report = method.fixed_cost ? parts.whole(length) : parts.to(stopped_step_end);
      stopped = parts.stopped();
    }
    if (method.profile) step_seconds += std::chrono::duration<double>(Clock::now() - start).count();
    return report;
  }

  /// Sums of steps drift away from their multiples by round-off.
  double on_grid(double time) const {
    const double multiple = std::round(time / method.step) * method.step;
    return std::abs(time - multiple) < 1e-6 * method.step ? multiple : time;
  }

  /// All that is remembered beside the state and the tangent marks.
  void transfer(StateTransfer& transfer) {
    steps.transfer(transfer);
    observers.transfer(transfer);
    reactions.transfer(transfer);
    events.transfer(transfer);
    ranges.transfer(transfer);
    if (!events.none()) transfer(stopped, stopped_step_end);
  }

  Eigen::Index memory_size() {
    StateTransfer count;
    transfer(count);
    return static_cast<Eigen::Index>(count.count());
  }

  /// The state is another one: nothing of it has been evaluated for those who look at it.
  void look_anew() {
    shown = Shown::nothing;
    ++instant;
  }

  /// The state counts as that at a time which differs from its own by round-off.
  void move_time(double time) {
    if (mechanism.state.time == time) return;
    mechanism.state.time = time;
    look_anew();
  }

  void show_motion() {
    if (shown >= Shown::motion) return;
    mechanism.observe_afresh();
    shown = Shown::motion;
    seen_by = &mechanism.observer;
    seen = &mechanism.view();
  }

  void show_forces() {
    if (shown >= Shown::forces) return;
    show_motion();
    const State& s = mechanism.view();
    mechanism.observer.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0,
                                scratch.data());
    shown = Shown::forces;
  }

  void show_reactions() {
    if (shown >= Shown::reactions) return;
    show_motion();
    seen_by = &reactions.find(mechanism);
    seen = &reactions.state();
    shown = Shown::reactions;
  }

  /// After a step that failed, which has left its last iteration in the workspace: looked for when first
  /// asked for, since that is gone then.
  const std::string& law_that_jumps() {
    if (!jump) jump = find_jumping_law();
    return *jump;
  }
  /// Of the same: the drives that it could not follow.
  std::string drive_limit() const {
    const State& from = mechanism.view();
    return explain_drive_limit(compiled, method, from, from.time + steps.length());
  }
  /// Of an explicit integrator, s, at the state; 0: unknown.
  double longest_stable_step() {
    mechanism.enter(0);
    const double rate = fastest_motion(mechanism.system, mechanism.state);
    look_anew();
    return rate > 0 ? stable_reach(method.integrator) / rate : 0;
  }
  /// Of a step that failed: whether the loops' position may be the reason, and what helps.
  std::string singular_position() {
    const bool near = is_near_singular(mechanism.observer, mechanism.view(),
                                       begin.redundancy.equations + begin.redundancy.nearly);
    look_anew();
    using Rule = spec::Simulation::Integrator;
    const bool passes = method.integrator != Rule::rk4 && method.integrator != Rule::dopri853 &&
                        method.integrator != Rule::radau;
    if (!near) return {};
    std::string text =
        "; its loops are close to a singular position there, where accelerations are hardly determined";
    if (!passes) text += ": generalized_alpha with the formalism index3 (the default) passes through it";
    return text;
  }
  std::string find_jumping_law() {
    const auto seen_in = [](const auto& work) {
      return SeenByLaws{{work.signals.value.begin(), work.signals.value.end()},
                        {work.elements.begin(), work.elements.end()}};
    };
    const SeenByLaws last =
        mechanism.natural ? seen_in(mechanism.natural->workspace()) : seen_in(mechanism.observer.workspace());
    look_anew();
    show_forces();
    return jumping_law(compiled, seen_in(mechanism.observer.workspace()), last);
  }

  const EnergyBalance& energies() const {
    return method.energies ? steps.meter().balance() : unknown_energies();
  }
  Channels::Statistics statistics() const {
    const StepStatus& last = steps.last();
    return {static_cast<double>(last.iterations), last, events.records()};
  }

  double value(int channel) {
    const int number = channels.part_of(channel);
    std::int64_t& at = read_at[static_cast<std::size_t>(number)];
    if (at != instant) {
      const Channels::Part& part = channels.parts()[static_cast<std::size_t>(number)];
      switch (part.needs) {
        case Channels::Needs::motion:
          show_motion();
          break;
        case Channels::Needs::forces:
          show_forces();
          break;
        case Channels::Needs::reactions:
          show_reactions();
          break;
      }
      channels.read(part, *seen_by, *seen, energies(), statistics(), values.data());
      at = instant;
    }
    return values[static_cast<std::size_t>(channel)];
  }

  static const EnergyBalance& unknown_energies() {
    static const EnergyBalance unknown = [] {
      EnergyBalance e;
      for (const EnergyTerm& term : energy_terms) e.*term.value = std::numeric_limits<double>::quiet_NaN();
      return e;
    }();
    return unknown;
  }

  std::shared_ptr<const Model> model;
  const Compiled& compiled;
  const Method method;
  Mechanism mechanism;
  StepMaker steps;
  Channels channels;
  Sampler sampler;
  RangeWatch ranges;
  Events events;
  bool stopped = false;         ///< an event ended the last step before
  double stopped_step_end = 0;  ///< s, when it would have ended
  double initialisation = 0;    ///< CPU seconds
  const Start begin;
  Observers observers;
  ShownReactions reactions;
  /// What of the state has been evaluated for those who look at it; each includes those before.
  enum class Shown { nothing, motion, forces, reactions } shown = Shown::nothing;
  relative::RelativeSystem* seen_by = nullptr;  ///< which has it
  const State* seen = nullptr;                  ///< as it is there
  std::int64_t instant = 0;                     ///< counts states that were looked at
  std::vector<std::int64_t> read_at = std::vector<std::int64_t>(channels.parts().size(), -1);
  std::vector<double> values =
      std::vector<double>(channels.info().size());  ///< of parts read at this instant
  Eigen::VectorXd scratch = Eigen::VectorXd(compiled.velocities);
  double step_seconds = 0;
  std::optional<std::string> jump;  ///< why the last step did not converge, found when first asked for
  std::vector<std::string> drives;  ///< their warnings, found when first asked for
  double drives_until = 0;
  std::uint64_t fingerprint = 0;  ///< found when first asked for
};

Simulation::Simulation(std::shared_ptr<const Model> model, const RunOptions& options)
    : impl_(std::make_unique<Impl>(std::move(model), options)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;

StepReport Simulation::step() {
  Impl& s = *impl_;
  // What is left of a step that an event stopped comes first.
  const double now = s.mechanism.state.time, left = s.stopped ? s.stopped_step_end - now : 0;
  return s.step(left > event_resolution(s.method.step, now) ? left : s.method.step);
}

StepReport Simulation::step_to(double time) {
  Impl& s = *impl_;
  if (!(time > s.mechanism.state.time && std::isfinite(time)))
    throw std::invalid_argument(
        fmt::format("step_to: {} s is not later than now, t = {} s", time, s.mechanism.state.time));
  // Times are sums of steps: a whole step but for rounding is a whole step.
  const double h = s.method.step, rest = time - s.mechanism.state.time;
  const StepReport report = s.step(std::abs(rest - h) < 1e-6 * h ? h : rest);
  if (report.ok() && !s.stopped) s.move_time(time);
  return report;
}

Simulation::Phases Simulation::phases() const {
  const Impl& s = *impl_;
  const PhaseSeconds& p = s.steps.phases();
  const double energy = s.steps.energy_seconds();
  return {p.residual, p.matrix,
          p.solution, p.kinematics,
          energy,     s.step_seconds - p.residual - p.matrix - p.solution - p.kinematics - energy};
}

bool Simulation::stopped() const { return impl_->stopped; }
std::vector<EventRecord> Simulation::events() const { return impl_->events.records(); }

double Simulation::time() const { return impl_->mechanism.state.time; }
double Simulation::step_size() const { return impl_->method.step; }
const Method& Simulation::method() const { return impl_->method; }
int Simulation::coordinates() const { return impl_->mechanism.system.velocities(); }
int Simulation::constraints() const { return impl_->mechanism.system.equations(); }

std::string Simulation::explain(const StepReport& report) const {
  Impl& s = *impl_;
  if (report.code == StepReport::Code::block_failed) return s.sampler.outside().failure();
  std::string jump, meaningless;
  if (report.code == StepReport::Code::not_converged) {
    jump = s.law_that_jumps();
    meaningless = s.observers.meaningless();
    if (jump.empty() && meaningless.empty()) meaningless = s.drive_limit();
  }
  double stable = 0;
  if (report.code == StepReport::Code::unstable && report.part == 0) stable = s.longest_stable_step();
  std::string text =
      mimbre::explain(s.mechanism, report, time() + s.steps.length(), jump, meaningless, stable);
  if (report.code == StepReport::Code::not_converged && jump.empty() && meaningless.empty()) {
    if (const std::string elsewhere =
            explain_held_elsewhere(s.compiled.spec(), bodies_held_elsewhere(s.compiled.spec()));
        !elsewhere.empty())
      text += "; " + elsewhere;
    text += explain_contradiction(s.compiled, s.begin.redundancy);
  }
  const bool may_be_singular =
      report.code == StepReport::Code::unstable || report.code == StepReport::Code::not_converged;
  if (may_be_singular && jump.empty() && meaningless.empty()) text += s.singular_position();
  if (report.code == StepReport::Code::drifted)
    if (const std::string limit = s.drive_limit(); !limit.empty()) text += "; " + limit;
  return report.ok() ? text : text + sunk_wheels(s.compiled, s.steps.contacts());
}

double Simulation::initialisation_seconds() const { return impl_->initialisation; }

std::uint64_t Simulation::fingerprint() const {
  Impl& s = *impl_;
  if (s.fingerprint == 0) s.fingerprint = mimbre::fingerprint(*s.model, s.method, s.channels.info());
  return s.fingerprint;
}

Simulation::Snapshot Simulation::save() const {
  Snapshot snapshot;
  save(snapshot);
  return snapshot;
}

void Simulation::save(Snapshot& out) const {
  Impl& i = *impl_;
  const State& s = i.mechanism.state;
  out.model = fingerprint();
  out.time = s.time;
  out.q = s.q;
  out.v = s.v;
  out.a = s.a;
  out.algorithmic = s.algorithmic;
  out.multipliers = s.multipliers;
  out.z = s.z;
  out.u = s.u;
  out.started = s.started;
  out.energy_error = s.energy_error;
  const std::span<const double> marks = i.mechanism.system.tangent_marks();
  out.marks = Eigen::Map<const Eigen::VectorXd>(marks.data(), static_cast<Eigen::Index>(marks.size()));
  out.memory.resize(i.memory_size());
  StateTransfer to = StateTransfer::to({out.memory.data(), static_cast<std::size_t>(out.memory.size())});
  i.transfer(to);
  if (i.sampler.outside().none()) return;
  const std::vector<double> outside = i.sampler.outside().save();
  out.memory.conservativeResize(out.memory.size() + std::ssize(outside));
  std::copy(outside.begin(), outside.end(), out.memory.end() - std::ssize(outside));
}

std::string Simulation::not_saved() const { return impl_->sampler.outside().not_saved(); }

/// What of a snapshot's memory belongs to blocks from elsewhere; nothing where it is not of this model.
static std::span<const double> outside_of(const Simulation::Snapshot& c, Eigen::Index own) {
  return c.memory.size() > own
             ? std::span<const double>(c.memory.data() + own, static_cast<std::size_t>(c.memory.size() - own))
             : std::span<const double>();
}

void Simulation::restart(const Snapshot& c) {
  Impl& i = *impl_;
  State& s = i.mechanism.state;
  const std::span<double> marks = i.mechanism.system.tangent_marks();
  const std::pair<const char*, std::pair<Eigen::Index, Eigen::Index>> sizes[] = {
      {"positions", {c.q.size(), s.q.size()}},
      {"velocities", {c.v.size(), s.v.size()}},
      {"accelerations", {c.a.size(), s.a.size()}},
      {"algorithmic accelerations", {c.algorithmic.size(), s.algorithmic.size()}},
      {"multipliers", {c.multipliers.size(), s.multipliers.size()}},
      {"internal states", {c.z.size(), s.z.size()}},
      {"inputs", {c.u.size(), s.u.size()}},
      {"marks", {c.marks.size(), static_cast<Eigen::Index>(marks.size())}}};
  for (const auto& [what, size] : sizes)
    if (size.first != size.second)
      throw InputError(Mark{},
                       fmt::format("the state has {} {}, the model {}", size.first, what, size.second));
  if (const auto states = outside_of(c, i.memory_size()); !states.empty() && !i.sampler.outside().none())
    i.sampler.outside().check(states);
  s = {c.time, c.q, c.v, c.a, c.algorithmic, c.multipliers, c.z, c.u, c.energy_error, c.started};
  std::copy(c.marks.begin(), c.marks.end(), marks.begin());
  // The same motion: with the integrator's memory, where the snapshot has that of this model.
  OutsideBlocks& outside = i.sampler.outside();
  const Eigen::Index own = i.memory_size();
  if (outside.none() ? c.memory.size() == own : c.memory.size() > own) {
    StateTransfer from = StateTransfer::from({c.memory.data(), static_cast<std::size_t>(own)});
    i.steps.transfer_integrator(from);
  } else {
    i.steps.forget();
  }
  if (!outside.none()) {
    if (const auto states = outside_of(c, own); !states.empty())
      outside.restore(states);
    else
      outside.restart(s);
  }
  i.mechanism.enter(0);
  i.mechanism.observe_afresh();
  i.observe_anew();
}

void Simulation::restore(const Snapshot& c) {
  Impl& i = *impl_;
  if (c.model != fingerprint())
    throw InputError(Mark{},
                     "the saved state is of another model, or of another method (step, formulation, "
                     "integrator, tolerances, ...): it goes on only with what it was saved with");
  const Eigen::Index own = i.memory_size();
  if (i.sampler.outside().none() ? c.memory.size() != own : c.memory.size() <= own)
    throw InputError(Mark{},
                     fmt::format("the state remembers {} numbers, the model {}", c.memory.size(), own));
  restart(c);
  StateTransfer from = StateTransfer::from({c.memory.data(), static_cast<std::size_t>(own)});
  i.transfer(from);
}

const std::vector<ChannelInfo>& Simulation::channels() const { return impl_->channels.info(); }
int Simulation::output_count() const { return impl_->channels.output_count(); }

Simulation::Channel Simulation::channel(const std::string& name) const {
  return {find_by_name(channels(), name, "channel")};
}

double Simulation::value(Channel channel) {
  require_handle(channel.index, channels(), "value", "channel");
  return impl_->value(channel.index);
}

Simulation::Body Simulation::body(const std::string& name) const {
  return {find_by_name(impl_->compiled.spec().bodies, name, "body")};
}

spec::Pose Simulation::pose(Body body) {
  Impl& s = *impl_;
  require_handle(body.index, s.compiled.spec().bodies, "pose", "body");
  s.show_motion();
  const relative::Workspace<double>& w = s.mechanism.observer.workspace();
  const auto& motion = w.bodies[s.compiled.body_of_spec[body.index]];
  return {motion.position + w.origin, motion.rotation};
}

const std::vector<spec::Input>& Simulation::inputs() const { return impl_->compiled.spec().inputs; }

int Simulation::input(const std::string& name) const { return find_input(impl_->compiled, name); }

void Simulation::set_input(int input, double value) {
  Impl& s = *impl_;
  require_handle(input, inputs(), "set_input", "input");
  if (!std::isfinite(value))
    throw std::invalid_argument(
        fmt::format("set_input: the value of input '{}' is {}; a finite number is needed",
                    inputs()[static_cast<std::size_t>(input)].name, value));
  s.ranges.set(input, value, s.mechanism.state.time);
  set_held_input(s.compiled, input, value, s.method.step, s.mechanism.state);
  s.mechanism.enter(0);
  s.look_anew();
}

double Simulation::input_value(int input) const {
  require_handle(input, inputs(), "input_value", "input");
  return held_input_value(impl_->compiled, input, impl_->mechanism.state);
}

void Simulation::sample(ResultsRow& row) {
  Impl& s = *impl_;
  s.show_motion();
  relative::RelativeSystem& system = s.reactions.find(s.mechanism);
  s.channels.sample(system, s.reactions.state(), s.energies(), s.statistics(), row);
}

void Simulation::picture(ResultsRow& row) {
  Impl& s = *impl_;
  s.show_motion();
  s.channels.picture(s.mechanism.observer, s.mechanism.view(), row);
}

int Simulation::most_attempts() const { return impl_->steps.most_attempts(); }

ResultsHeader Simulation::header(const std::string& options_json) const {
  const Impl& s = *impl_;
  ResultsHeader h;
  h.title = s.compiled.spec().title;
  h.model_text = s.compiled.spec().text;
  h.options_json = options_json;
  h.step = step_size();
  h.channels = s.channels.info();
  h.bodies = body_drawings(s.compiled.spec());
  h.roads = s.channels.roads();
  ElementDrawings drawn = element_drawings(s.compiled, h.bodies);
  h.frames = std::move(drawn.frames);
  h.elements = std::move(drawn.elements);
  h.sections = recorded_sections(s.compiled.spec());
  return h;
}

const EnergyBalance& Simulation::energy() const {
  return impl_->method.energies ? impl_->steps.meter().balance() : Impl::unknown_energies();
}

std::vector<std::string> Simulation::warnings() const {
  Impl& s = *impl_;
  if (!s.method.warnings) return {};
  std::vector<std::string> all = s.begin.warnings;
  for (const std::string& text : s.observers.validity_warnings()) all.push_back(text);
  for (const std::string& text : s.observers.spin_warnings()) all.push_back(text);
  for (const std::string& text : s.observers.loop_warnings()) all.push_back(text);
  const auto unresolved = s.reactions.unresolved() ? s.reactions.unresolved() : s.observers.unresolved();
  if (unresolved) all.push_back(explain_unresolved(s.compiled, *unresolved));
  // At rest there is nothing at play but round-off.
  if (const std::string text = s.observers.energy_warning(s.steps); !text.empty()) all.push_back(text);
  for (const std::string& text : s.observers.winch_warnings()) all.push_back(text);
  for (const std::string& text : s.observers.turn_warnings()) all.push_back(text);
  for (const std::string& text : s.observers.road_warnings()) all.push_back(text);
  for (const std::string& text : s.ranges.warnings()) all.push_back(text);
  for (const std::string& text : s.sampler.outside().warnings()) all.push_back(text);
  for (const std::string& text : contact_warnings(s.compiled, s.steps.contacts(), s.method.substeps))
    all.push_back(text);
  if (const double end = std::max(s.compiled.spec().simulation.end, time()); end > s.drives_until) {
    s.drives = drive_warnings(s.compiled, end);
    s.drives_until = end;
  }
  all.insert(all.end(), s.drives.begin(), s.drives.end());
  return all;
}

std::vector<Validity> Simulation::validity() const { return impl_->observers.validity(); }

Redundancy Simulation::redundancy() {
  Impl& s = *impl_;
  if (!s.mechanism.state.started) return s.begin.redundancy;
  // Looking assembles a matrix; the next step has to find the tangents of the one that it left.
  const State& state = s.mechanism.view();
  relative::RelativeSystem reader(s.compiled, s.method.inertia);
  reader.enter(state.u.data(), state.z.data(), 0);
  reader.begin_step(state.q.data());
  return find_redundancy(reader, state);
}

int Simulation::degrees_of_freedom() {
  const Compiled& m = impl_->compiled;
  return m.velocities - (m.equations - redundancy().equations);
}

const Model& Simulation::model() const { return *impl_->model; }

}  // namespace mimbre
