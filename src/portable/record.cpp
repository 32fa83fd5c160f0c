#include "portable/recorded_kernels.h"
// The kernels come behind what they take of recorded scalars.
#include "portable/record.h"

#include <fmt/format.h>

#include <map>

#include "compile/element_name.h"
#include "compile/signals/compile_signals.h"
#include "dynamics/relative/assembly.h"
#include "dynamics/relative/evaluation.h"
#include "dynamics/relative/momentum_impl.h"
#include "dynamics/relative/retract.h"
#include "dynamics/relative/shift_impl.h"
#include "dynamics/relative/workspace_impl.h"
#include "dynamics/tangent_marks.h"
#include "forces/sticks.h"
#include "linalg/block_factor_impl.h"
#include "outputs/frame_angles.h"
#include "outputs/wheel_quantities.h"
#include "portable/continuous_rates.h"
#include "portable/differentiate.h"
#include "signals/blocks/table.h"
#include "signals/sensors.h"
#include "simulation/observe/run_channels.h"
#include "simulation/step/flight_laws.h"
#include "simulation/step/free_flight.h"
#include "spec/output_kind.h"

namespace mimbre::portable {
namespace {

using T = Recorded;

/// When signals are looked at: before the first step, at rest, and at the end of a step.
enum class Instant { fresh, rest, step };
constexpr std::array instants{Instant::fresh, Instant::rest, Instant::step};
constexpr std::array instant_names{"fresh", "rest", "step"};

class Recorder {
 public:
  Recorder(const Compiled& m, const MatrixWeights& weights, const std::vector<double>& penalty, double step,
           const std::vector<double>& small_marks)
      : out_(std::make_unique<RecordedModel>()),
        p_(out_->program),
        m_(m),
        weights_(weights),
        penalty_(penalty),
        step_(step),
        small_marks_(small_marks),
        w_(m),
        start_(p_.inputs(Memory::start, m.positions)),
        q_(p_.inputs(Memory::q, m.positions)),
        v_(p_.inputs(Memory::v, m.velocities)),
        a_(p_.inputs(Memory::a, m.velocities)),
        multipliers_(p_.inputs(Memory::multipliers, m.equations)),
        states_(p_.inputs(Memory::states, static_cast<int>(m.states.size()))),
        numbers_(m.numbers.begin(), m.numbers.end()),
        residual_(static_cast<std::size_t>(m.velocities)),
        slots_(static_cast<std::size_t>(m.signals.slots)) {
    // ∂x/∂v of the integrator's rule (System::set_rate_time); an instant has none.
    if (weights.damping > 0) w_.rate_time = weights.stiffness / weights.damping;
    w_.signals.numbers = numbers_.data();
    w_.signals.states = states_.data();
    out_->senses = !m.signals.sensors.empty();
    out_->blocks = m.signals.clock >= 0;
    for (std::size_t k = 0; k < m.signals.blocks.size(); ++k)
      if (is_delay(m.signals.blocks[k])) out_->delays.push_back(static_cast<int>(k));
    out_->remembers = !m.states.empty() || !m.signals.integrals.empty() || out_->blocks;
  }

  std::unique_ptr<RecordedModel> record(bool varies) {
    record_origin();
    for (const Instant i : instants)
      if (i == Instant::step || out_->blocks) record_signals(i);
    record_motion();
    for (const Instant i : instants)
      if (i == Instant::step || out_->blocks) record_senses(i);
    record_forces();
    record_loads();
    record_flights();
    record_outputs();
    record_samples();
    record_events();
    record_matrix();
    record_exchange();
    record_steps();
    if (varies) record_variations_at_rest();
    return std::move(out_);
  }

  std::unique_ptr<RecordedModel> record_instant() {
    record_origin();
    const std::vector<Instant> looks =
        out_->blocks ? std::vector{Instant::fresh, Instant::rest} : std::vector{Instant::step};
    for (const Instant i : looks) record_signals(i);
    record_motion();
    record_rows();
    for (const Instant i : looks) record_sight(i);
    if (out_->blocks) record_blocks(Instant::fresh);
    feedback_.assign(m_.elements.size(), {T(0), T(0)});
    phase(rest_, "forces", {origin_, motion_});
    make_forces(0);
    finish_residual();
    record_rest_elements();
    record_turns();
    record_rates();
    record_outputs();
    record_mass();
    record_retract();
    record_increment_rate();
    record_variations(looks.back());
    return std::move(out_);
  }

 private:
  static bool is_delay(const SignalsData::Block& b) { return block_info(b.type).name == "delay"; }

  /// The values of signals from here on, of an instant: what is held, and what time decides.
  void enter(Instant i) {
    const SignalsData& d = m_.signals;
    held_ = p_.inputs(Memory::held, static_cast<int>(d.start.size()));
    for (const SignalsData::Block& b : d.blocks)
      if (!(b.every > 0)) held_[static_cast<std::size_t>(b.held)] = i == Instant::fresh ? 0 : 1;
    // What a delay finds in its list of points is one point, found by hand.
    for (std::size_t k = 0; k < out_->delays.size(); ++k) {
      const SignalsData::Block& b = d.blocks[static_cast<std::size_t>(out_->delays[k])];
      T* list = held_.data() + b.held + 1 + b.inputs;
      list[blocks::delay::count] = 1;
      list[blocks::delay::newest] = list[blocks::delay::first_point] = 0;
      list[blocks::delay::first_point + 1] = p_.input(Memory::delayed, static_cast<int>(k));
      p_.input(Memory::delay_rate, static_cast<int>(k));
    }
    SignalValues<T>& s = w_.signals;
    s.held = held_.data();
    s.step = i == Instant::step ? step_ : 0;
    s.since = i == Instant::step && out_->blocks ? step_ : 0;
    s.holds = i == Instant::step && out_->sticks ? p_.input(Memory::holds, 0) : T(0);
    s.time = 0;  // what time decides is there
    if (s.since == 0) return;
    for (const SignalsData::Block& b : d.blocks)
      if (const auto prepare = blocks::rows<T>[static_cast<std::size_t>(b.type)].prepare;
          prepare && !(b.every > 0))
        prepare(b, d.numbers.data() + b.numbers, s.since, s.matrices.data() + b.matrices);
  }

  void record_origin() {
    phase(origin_, "origin", {});
    relative::set_origin<T>(m_, w_, start_.data());
    for (int k = 0; k < 3; ++k) {
      p_.store(Memory::origin, k, w_.origin[k]);
      if (!w_.origin[k].is_constant()) w_.origin[k] = p_.input(Memory::origin, k);
    }
  }

  void phase(int& number, const std::string& name, const std::vector<int>& after) {
    number = p_.begin(name, after);
  }

  T time() { return p_.input(Memory::time, 0); }

  JetOf<T> held_jet(const SignalsData::HeldInput& h) {
    const T* at = held_.data() + h.held;
    if (!h.linear) return {at[0], 0, 0};
    const T from = at[0], start = at[1], to = at[2], end = at[3], now = time();
    const auto there = !(end > start) || now >= end, begins = now <= start;
    const T rate = (to - from) / (end - start);
    return {select(there, to, select(begins, from, from + rate * (now - start))),
            select(there || begins, T(0), rate), 0};
  }

  /// What fix_signals() does, at a time that is not known.
  void record_signals(Instant i) {
    const SignalsData& d = m_.signals;
    const std::size_t n = static_cast<std::size_t>(i);
    phase(signals_[n], fmt::format("signals_{}", instant_names[n]), {});
    enter(i);
    SignalValues<T>& s = w_.signals;
    std::fill(s.value.begin(), s.value.end(), T(std::numeric_limits<double>::quiet_NaN()));
    s.put(0, JetOf<T>{time(), 1, 0});
    for (const SignalsData::HeldInput& h : d.held) s.put(h.slot, held_jet(h));
    for (const SignalsData::OfTime& f : d.of_time) s.put(f.slot, jet_at(f.function, time()));
    make_signals(d, d.fixed, false, s, [&](const SignalsData::Computed& f) {
      if (f.block < 0)
        s.put(f.slot, signal_jet(f.law, s));
      else
        make_block_jets(d, d.blocks[f.block], s);
    });
    note_limited(i);
    for (const SignalsData::Integral& of : d.integrals) {
      const T from = s.held[of.held], span = time() - s.held[of.held + 1], now = s.value[of.rate];
      s.put(of.slot, JetOf<T>{from + span * (now - T(0.5) * span * s.rate[of.rate]), now, s.rate[of.rate]});
    }
    for (int k = 0; k < d.slots; ++k) {
      const std::size_t at = static_cast<std::size_t>(k);
      const bool moves = k >= d.first_moving;
      if (moves) s.value[at] = s.rate[at] = s.second[at] = T(0);
      keep_slot(Memory::slot, k, s.value[at], slots_[at].value, moves);
      keep_slot(Memory::rate, k, s.rate[at], slots_[at].first, moves);
      keep_slot(Memory::second, k, s.second[at], slots_[at].second, moves);
    }
  }
  /// Later phases read it, but for constants that are the same at all instants.
  void keep_slot(Memory memory, int k, const T& made, T& read, bool moves) {
    if (moves) {
      read = memory == Memory::slot ? p_.input(memory, k) : T(0);
      return;
    }
    if (made.is_constant() && !out_->blocks) {
      read = made;
      return;
    }
    p_.store(memory, k, made);
    read = p_.input(memory, k);
  }
  void read_slots() {
    for (std::size_t k = 0; k < slots_.size(); ++k) {
      w_.signals.value[k] = slots_[k].value;
      w_.signals.rate[k] = slots_[k].first;
      w_.signals.second[k] = slots_[k].second;
    }
  }

  void record_motion() {
    phase(motion_, "motion", {origin_});
    enter(Instant::step);
    read_slots();
    relative::move_origin<T>(m_, w_, Vec3<T>(w_.origin));
    relative::kinematics<T>(m_, w_, q_.data(), v_.data(), a_.data());
    relative::constraints<T>(m_, w_, q_.data(), v_.data(), a_.data());
    for (int k = 0; k < m_.equations; ++k) {
      p_.store(Memory::phi, k, w_.phi[static_cast<std::size_t>(k)]);
      p_.store(Memory::phi_dot, k, w_.phi_dot[static_cast<std::size_t>(k)]);
      p_.store(Memory::phi_ddot, k, w_.phi_ddot[static_cast<std::size_t>(k)]);
    }
  }

  /// Signals that see the motion.
  void record_sight(Instant i) {
    const std::size_t n = static_cast<std::size_t>(i);
    phase(senses_[n], fmt::format("sense_{}", instant_names[n]), {origin_, motion_});
    enter(i);
    read_slots();
    relative::measure_elements<T>(m_, w_, q_.data(), v_.data(), a_.data());
    if (m_.signals.moving_loops) return record_circle(i);
    relative::sense<T>(m_, w_, q_.data());
    note_limited(i);
    for (int k = m_.signals.first_moving; k < m_.signals.slots; ++k)
      p_.store(Memory::slot, k, w_.signals.value[static_cast<std::size_t>(k)]);
  }
  /// Loops of signals: a round, and what follows once they have settled.
  void record_circle(Instant i) {
    const SignalsData& d = m_.signals;
    const std::size_t n = static_cast<std::size_t>(i);
    SignalValues<T>& s = w_.signals;
    relative::read_sensors<T>(m_, w_, q_.data());
    for (const SignalsData::Sensor& sensor : d.sensors)
      p_.store(Memory::slot, sensor.slot, s.value[static_cast<std::size_t>(sensor.slot)]);
    out_->circle.clear();
    const auto for_ahead = [&](const auto& f) {
      for (const SignalsData::Computed& made : d.moving)
        if (made.block >= 0 && d.blocks[made.block].ahead) f(d.blocks[made.block]);
    };
    for_ahead([&](const SignalsData::Block& b) {
      begin_signal_loop(d, b, s);
      for (int k = 0; k < b.outputs; ++k) {
        p_.store(Memory::ahead, static_cast<int>(out_->circle.size()),
                 s.value[static_cast<std::size_t>(b.slot + k)]);
        out_->circle.push_back(b.slot + k);
      }
    });
    int number = 0;
    phase(number, fmt::format("sense_round_{}", instant_names[n]), {});
    enter(i);
    read_slots();
    for (std::size_t k = 0; k < out_->circle.size(); ++k)
      s.value[static_cast<std::size_t>(out_->circle[k])] = p_.input(Memory::ahead, static_cast<int>(k));
    int at = 0;
    for (const SignalsData::Computed& made : d.moving) {
      make_moving_signal(d, made, s);
      if (made.block < 0 || !d.blocks[made.block].ahead) continue;
      const SignalsData::Block& b = d.blocks[made.block];
      const BlockInputs<T> inputs = block_inputs(b, s);
      const std::span<const T> made_of(inputs.data(), static_cast<std::size_t>(b.inputs));
      for (int k = 0; k < b.outputs; ++k, ++at) {
        const T now = s.value[static_cast<std::size_t>(b.slot + k)], before = p_.input(Memory::ahead, at);
        p_.store(Memory::made, at, now);
        p_.store(Memory::unsettled, at, select(has_settled(now, before), T(0), T(1)));
        p_.store(Memory::lost, at, select(is_unsettled(now, before, made_of), T(1), T(0)));
      }
    }
    for (const SignalsData::Computed& made : d.moving) {
      const int count = made.block < 0 ? 1 : d.blocks[made.block].outputs;
      for (int k = made.slot; k < made.slot + count; ++k)
        p_.store(Memory::slot, k, s.value[static_cast<std::size_t>(k)]);
    }
    phase(senses_[n], fmt::format("see_{}", instant_names[n]), {origin_, motion_});
    enter(i);
    read_slots();
    relative::measure_elements<T>(m_, w_, q_.data(), v_.data(), a_.data());
  }
  /// A limit of rates lets nothing change at once, although at rest its value is that of its input.
  void note_limited(Instant i) {
    if (i != Instant::rest) return;
    for (const SignalsData::Block& b : m_.signals.blocks)
      if (const T& value = w_.signals.value[static_cast<std::size_t>(b.slot)];
          value.node >= 0 && blocks::infos[static_cast<std::size_t>(b.type)]->name == "rate_limit")
        limited_.push_back(value.node);
  }
  /// And what elements feel of theirs by their own motion.
  void record_senses(Instant i) {
    record_sight(i);
    feedback_.assign(m_.elements.size(), {T(0), T(0)});
    for (std::size_t k = 0; k < m_.elements.size(); ++k) {
      if (m_.elements[k].feedback < 0) continue;
      const auto [by_x, by_v] = feedback(m_, m_.elements[k], w_.signals);
      const int at = static_cast<int>(k);
      p_.store(Memory::by_measure, at, by_x);
      p_.store(Memory::by_rate, at, by_v);
      feedback_[k] = {p_.input(Memory::by_measure, at), p_.input(Memory::by_rate, at)};
    }
    if (out_->blocks) record_blocks(i);
  }

  /// What continuous blocks remember from this instant on.
  void record_blocks(Instant i) {
    const SignalsData& d = m_.signals;
    const std::size_t n = static_cast<std::size_t>(i);
    if (i != Instant::step)
      phase(blocks_[n], fmt::format("keep_blocks_{}", instant_names[n]), {origin_, motion_, senses_[n]});
    next_held_ = p_.inputs(Memory::held, static_cast<int>(d.start.size()));
    next_held_[static_cast<std::size_t>(d.clock)] = time();
    next_held_[static_cast<std::size_t>(d.clock) + 1] = 0;
    for (const SignalsData::Block& b : d.blocks)
      if (!(b.every > 0)) keep_block(b, i);
    if (i != Instant::step) store_held(next_held_);
  }
  /// All but the lists of delays.
  void store_held(const std::vector<T>& next) {
    std::vector<char> skips(next.size());
    for (const int k : out_->delays) {
      const SignalsData::Block& b = m_.signals.blocks[static_cast<std::size_t>(k)];
      std::fill_n(skips.begin() + b.held + 1 + b.inputs, b.states, 1);
    }
    p_.input(Memory::next_held, static_cast<int>(next.size()) - 1);
    for (std::size_t k = 0; k < next.size(); ++k)
      if (!skips[k]) p_.store(Memory::next_held, static_cast<int>(k), next[k]);
  }

  /// A block's states now: of sampled ones from the next instant on.
  static void keep_states(BlockCall<T> call, std::string_view type, T* states) {
    std::array<T, most_block_outputs> next;
    call.out = next.data();
    if (type == "pid") {
      T integral, filtered;
      blocks::pid::output_and<T>(call, &integral, &filtered, nullptr);
      states[blocks::pid::integral] = integral;
      states[blocks::pid::filtered] = filtered;
    } else if (type == "rate_limit") {
      blocks::rate_limit::output<T>(call);
      states[0] = next[0];
    } else if (type == "transfer_function" || type == "state_space") {
      const auto now =
          call.sampled() ? blocks::linear::next_states_of<T>(call) : blocks::linear::states_of<T>(call);
      for (int k = 0; k < call.states; ++k) states[k] = now[static_cast<std::size_t>(k)];
    } else if (type == "hysteresis") {
      states[0] = blocks::hysteresis::decided<T>(call);
    } else if (call.states > 0 && type != "delay") {
      throw NotRecordable(fmt::format("has a block of type {}", type));
    }
  }

  void keep_block(const SignalsData::Block& b, Instant i) {
    const SignalValues<T>& s = w_.signals;
    const BlockInputs<T> in = block_inputs(b, s);
    BlockCall<T> call = block_call(m_.signals, b, s);
    call.in = in.data();
    T* to = next_held_.data() + b.held;
    T* states = to + 1 + b.inputs;
    keep_states(call, blocks::infos[static_cast<std::size_t>(b.type)]->name, states);
    // Whether it has begun.
    to[0] = i == Instant::step ? T(1) : p_.input(Memory::held, b.held);
    for (int k = 0; k < b.inputs; ++k) to[1 + k] = in[static_cast<std::size_t>(k)];
    // A relay that switches is a jump for what sees it.
    if (block_info(b.type).relay && call.begun) {
      T& jump = next_held_[static_cast<std::size_t>(m_.signals.clock) + 1];
      jump = select(states[0] != call.before[0], T(1), jump);
    }
  }

  /// The residual, with elements as in a step or at rest.
  void make_forces(double step) {
    enter(step > 0 ? Instant::step : Instant::rest);
    read_slots();
    relative::measure_elements<T>(m_, w_, q_.data(), v_.data(), a_.data());
    const auto feedback_of = [&](const ElementData& e) {
      return feedback_[static_cast<std::size_t>(&e - m_.elements.begin())];
    };
    relative::act<T>(m_, w_, residual_.data(), [&](const ElementData& e) {
      evaluate_law(m_, e, w_.signals, w_.elements.data(), feedback_of);
    });
  }
  void finish_residual() {
    relative::apply_multipliers<T>(m_, w_, multipliers_.data(), residual_.data());
    relative::residual<T>(m_, w_, q_.data(), v_.data(), a_.data(), residual_.data());
    for (int k = 0; k < m_.velocities; ++k)
      p_.store(Memory::residual, k, residual_[static_cast<std::size_t>(k)]);
  }

  void record_forces() {
    out_->sticks = sticks(m_);
    if (feedback_.empty()) feedback_.assign(m_.elements.size(), {T(0), T(0)});
    out_->rests = !m_.states.empty();
    for (const ElementData& e : m_.elements)
      out_->jumps = out_->jumps || (e.state_count > 0 && e.argument_count > 0);
    if (out_->rests) {
      phase(rest_, "forces_rest", {origin_, motion_});
      make_forces(0);
      finish_residual();
      if (out_->jumps) {
        int number = 0;
        phase(number, "keep_laws", {origin_, motion_});
        std::vector<T> next = states_;
        for (const ElementData& e : m_.elements)
          if (e.state_count > 0 && e.argument_count > 0) keep_element(e, next);
        for (std::size_t k = 0; k < next.size(); ++k)
          p_.store(Memory::next_states, static_cast<int>(k), next[k]);
      }
      record_rest_elements();
    }
    phase(forces_, "forces_step", {origin_, motion_});
    make_forces(step_);
    finish_residual();
    record_marks();
    if (!out_->rests) {
      rest_ = forces_;
      record_rest_elements();
    }
    if (out_->remembers) record_commit();
  }

  /// Of inertia, by which the first accelerations are sought.
  void record_loads() {
    out_->loads = geometric::has_loads_of_inertia(m_);
    if (!out_->loads) return;
    int number = 0;
    phase(number, "loads", {origin_, motion_});
    std::vector<T> loads(static_cast<std::size_t>(m_.velocities), T(0));
    relative::add_loads_of_inertia<T>(m_, w_, q_.data(), a_.data(), loads.data());
    for (std::size_t k = 0; k < loads.size(); ++k) p_.store(Memory::loads, static_cast<int>(k), loads[k]);
  }

  /// What FreeFlight does.
  void record_flights() {
    const std::vector<FreeGroup> groups = free_groups(m_);
    if (groups.empty()) return;
    const auto momentum_of = [&](const FreeGroup& group) {
      return relative::momentum<T>(m_, w_, group.bodies, q_.data(), v_.data());
    };
    const auto is_loaded = [&](const FreeGroup& group) {
      RecordedCondition any = false;
      for (const int slot : group.loads)
        any = any || slot >= m_.signals.first_moving || slots_[static_cast<std::size_t>(slot)].value != T(0);
      return any;
    };
    const std::vector<T> at_start = p_.inputs(Memory::flight, flight_kept * static_cast<int>(groups.size()));
    const auto start_of = [&](std::size_t k) {
      const T* from = at_start.data() + flight_kept * k;
      return flight::Start<T>{{from[0], from[1], from[2]},
                              {from[3], from[4], from[5]},
                              {from[6], from[7], from[8]},
                              from[9],
                              p_.input(Memory::flight_sum, static_cast<int>(k))};
    };
    int number = 0;
    phase(number, "flight_begin", {origin_, motion_});
    enter(Instant::step);
    for (std::size_t k = 0; k < groups.size(); ++k) {
      const BodyData& root = m_.bodies[groups[k].root];
      out_->flights.push_back({root.q, root.v, groups[k].rigid});
      const flight::Start<T> start = flight::start_of<T>(momentum_of(groups[k]));
      int at = flight_kept * static_cast<int>(k);
      for (const Vec3<T>& x : {start.centre, start.velocity, start.angular})
        for (int c = 0; c < 3; ++c) p_.store(Memory::flight, at++, x[c]);
      p_.store(Memory::flight, at++, start.rotation);
      p_.store(Memory::flight, at++, select(is_loaded(groups[k]), T(1), T(0)));
    }
    if (std::any_of(groups.begin(), groups.end(), [](const FreeGroup& group) { return !group.rigid; })) {
      phase(number, "flight_rates", {});
      std::vector<T> rates(v_.size());
      flight::set_rates<T>(m_, start_.data(), q_.data(), v_.data(), step_, rates.data());
      for (std::size_t k = 0; k < rates.size(); ++k)
        p_.store(Memory::flight_rate, static_cast<int>(k), rates[k]);
      phase(number, "flight_gain", {origin_, motion_});
      for (std::size_t k = 0; k < groups.size(); ++k)
        p_.store(Memory::flight_gain, static_cast<int>(k),
                 groups[k].rigid ? T(0)
                                 : T(0.5 * step_) * relative::centrifugal_power<T>(momentum_of(groups[k]),
                                                                                   start_of(k).angular));
    }
    phase(number, "flight_end", {origin_, motion_});
    std::vector<T> q = q_, v = v_, a = a_, algorithmic = p_.inputs(Memory::algorithmic, m_.velocities);
    for (std::size_t k = 0; k < groups.size(); ++k) {
      const RigidShiftOf<T> shift = flight::restoring_shift<T>(start_of(k), momentum_of(groups[k]),
                                                               m_.gravity.cast<T>(), Vec3<T>::Zero(), step_);
      relative::shift_root<T>(m_, w_, groups[k].root, shift,
                              {q.data(), v.data(), a.data(), algorithmic.data()});
      const RecordedCondition loaded = is_loaded(groups[k]) || at_start[flight_kept * k + 10] > T(0.5);
      const BodyData& root = m_.bodies[groups[k].root];
      int at = flight_moved * static_cast<int>(k);
      const auto put = [&](const T& to, const T& from) {
        p_.store(Memory::flown, at++, select(loaded, from, to));
      };
      for (int c = root.q; c < root.q + 7; ++c)
        put(q[static_cast<std::size_t>(c)], q_[static_cast<std::size_t>(c)]);
      for (const auto& [to, from] : {std::pair(&v, &v_), std::pair(&a, &a_)})
        for (int c = root.v; c < root.v + 6; ++c)
          put((*to)[static_cast<std::size_t>(c)], (*from)[static_cast<std::size_t>(c)]);
      for (int c = root.v; c < root.v + 6; ++c)
        put(algorithmic[static_cast<std::size_t>(c)], p_.input(Memory::algorithmic, c));
    }
  }

  void record_rest_elements() { rest_elements_ = w_.elements; }

  void keep_element(const ElementData& e, std::vector<T>& next) {
    const ElementState<T> s = element_state(e, w_.elements.data());
    std::copy_n(s.states, e.state_count, next.begin() + e.states);
  }

  void record_marks() {
    int tangent = 0;
    for (std::size_t k = 0; k < m_.elements.size(); ++k) {
      const ElementData& e = m_.elements[k];
      if (!e.marked) continue;
      MarkedElement marked{static_cast<int>(k), e.count, tangent, e.measure == Measure::contact,
                           small_marks_[k]};
      tangent += e.count * e.count;
      const ElementState<T> s = element_state(e, w_.elements.data());
      T sum = 0;
      for (int c = 0; c < (e.count == 1 ? 1 : 3); ++c)
        sum += T(weights_.damping) * s.damping[c * (e.count + 1)] +
               T(weights_.stiffness) * s.stiffness[c * (e.count + 1)];
      p_.store(Memory::mark, static_cast<int>(out_->marked.size()), sum);
      out_->marked.push_back(marked);
    }
    if (out_->marked.empty()) return;
    int number = 0;
    phase(number, "tangents", {origin_, motion_, forces_});
    for (const MarkedElement& marked : out_->marked) {
      const ElementState<T> s =
          element_state(m_.elements[static_cast<std::size_t>(marked.element)], w_.elements.data());
      for (int c = 0; c < s.count * s.count; ++c)
        p_.store(Memory::tangent, marked.tangent + c,
                 T(weights_.damping) * s.damping[c] + T(weights_.stiffness) * s.stiffness[c]);
    }
  }

  /// What is remembered from the end of a step on.
  void record_commit() {
    int number = 0;
    std::vector<int> after{origin_, motion_};
    if (out_->senses) after.push_back(senses_[2]);
    phase(number, "commit", after);
    std::vector<T> next = states_;
    for (const ElementData& e : m_.elements)
      if (e.state_count > 0) keep_element(e, next);
    for (const ConstraintData& c : m_.constraints)
      std::copy_n(w_.constraint_states.begin() + c.next_states, c.state_count, next.begin() + c.states);
    for (std::size_t k = 0; k < next.size(); ++k) p_.store(Memory::next_states, static_cast<int>(k), next[k]);
    if (m_.signals.integrals.empty() && !out_->blocks) return;
    std::vector<T> held =
        next_held_.empty() ? p_.inputs(Memory::held, static_cast<int>(m_.signals.start.size())) : next_held_;
    for (const SignalsData::Integral& i : m_.signals.integrals) {
      held[static_cast<std::size_t>(i.held)] = slots_[static_cast<std::size_t>(i.slot)].value;
      held[static_cast<std::size_t>(i.held) + 1] = time();
    }
    store_held(held);
  }

  void record_matrix() {
    phase(matrix_, "assemble", {origin_, motion_, forces_});
    std::vector<T> values(static_cast<std::size_t>(m_.symbolic.value_count()) + 2 * linalg::kLanes, T(0));
    relative::assemble<T>(m_, w_, q_.data(), weights_, penalty_.data(), values.data(), relative::NoMarks{});
    for (std::size_t k = 0; k < static_cast<std::size_t>(m_.symbolic.value_count()); ++k)
      if (values[k].node >= 0 || values[k].number != 0)
        p_.store(Memory::matrix, static_cast<int>(k), values[k]);
    store_jacobian();
    for (const MarkedElement& marked : out_->marked) {
      store_rows(marked);
      if (marked.contact) store_subspaces(m_.elements[static_cast<std::size_t>(marked.element)].path);
    }
  }
  /// Rows that are made anew are made with the motion of then, but with these.
  void store_subspaces(const Path& path) {
    for (const PathEntry& e : path.entries)
      for (const int set : {e.plus, e.minus}) {
        if (set < 0) continue;
        const MotionSubspace& of = m_.subspaces[static_cast<std::size_t>(set)];
        for (int k = of.offset; k < of.offset + 6 * of.stride; ++k) {
          T& kept = subspaces_.try_emplace(k, w_.subspaces[static_cast<std::size_t>(k)]).first->second;
          if (kept.is_constant() || kept.node != w_.subspaces[static_cast<std::size_t>(k)].node) continue;
          p_.store(Memory::subspace, k, kept);
          kept = p_.input(Memory::subspace, k);
        }
      }
  }
  void store_jacobian() {
    const auto add = [&](int equation, int coordinate, const T& value) {
      if (value.is_constant() && value.number == 0) return;
      p_.store(Memory::jacobian, static_cast<int>(out_->jacobian.size()), value);
      out_->jacobian.push_back({equation, coordinate, value.is_constant() ? value.number : 0});
    };
    for_rows(m_, [&](const EquationRows& rows) {
      for (int r = 0; r < rows.count; ++r)
        for (const PathEntry& e : rows.path.entries)
          for (int k = 0; k < e.count; ++k)
            add(rows.first_equation + r, e.first + k,
                w_.jacobian[static_cast<std::size_t>(rows.jacobian + r * rows.path.width + e.offset + k)]);
    });
    for (const DriveData& d : m_.drives) add(d.equation, d.v, 1);
  }

  // Of an instant.
  void record_rows() {
    phase(matrix_, "jacobian", {origin_, motion_});
    relative::motion_subspaces<T>(m_, w_, q_.data());
    relative::jacobian<T>(m_, w_);
    store_jacobian();
  }
  /// M: the entries that are there.
  void record_mass() {
    int number = 0;
    phase(number, "inertia", {origin_, motion_, matrix_});
    const std::vector<double> none(static_cast<std::size_t>(m_.equations), 0.0);
    std::vector<T> values(static_cast<std::size_t>(m_.symbolic.value_count()) + 2 * linalg::kLanes, T(0));
    relative::assemble<T>(m_, w_, q_.data(), {0, 0, 0}, none.data(), values.data(), relative::NoMarks{});
    const std::size_t n = static_cast<std::size_t>(m_.velocities);
    std::vector<T> dense(n * n);
    linalg::to_dense<T>(m_.symbolic, values.data(), dense.data());
    for (int c = 0; c < m_.velocities; ++c)
      for (int r = c; r < m_.velocities; ++r) {
        const T& x = dense[static_cast<std::size_t>(c) * n + static_cast<std::size_t>(r)];
        if (x.is_constant() && x.number == 0) continue;
        p_.store(Memory::mass, static_cast<int>(out_->mass.size()), x);
        out_->mass.push_back({r, c, x.is_constant() ? x.number : 0});
      }
  }
  /// What counts turns of elements follows their motion at once.
  void record_turns() {
    int number = 0;
    phase(number, "keep_turns", {origin_, motion_, rest_});
    for (const ElementData& e : m_.elements)
      for (int k = 0; k < e.own_states; ++k)
        p_.store(Memory::next_states, e.states + k, element_state(e, w_.elements.data()).states[k]);
  }
  void record_increment_rate() {
    int number = 0;
    phase(number, "increment_rate", {});
    const std::vector<T> x = p_.inputs(Memory::increment, m_.velocities);
    std::vector<T> rate(static_cast<std::size_t>(m_.velocities));
    relative::increment_rate<T>(m_, x.data(), v_.data(), rate.data());
    for (std::size_t k = 0; k < rate.size(); ++k)
      p_.store(Memory::increment_rate, static_cast<int>(k), rate[k]);
  }

  /// How all of that varies, where this is known.
  void record_variations(Instant at) {
    const std::string name = instant_names[static_cast<std::size_t>(at)];
    std::vector<std::string> phases{"signals_" + name, "motion"};
    if (out_->senses) phases.push_back("sense_" + name);
    for (const char* other : {"forces", "rates", "outputs", "increment_rate"}) phases.emplace_back(other);
    const std::size_t before = p_.phases.size();
    try {
      differentiate(p_, phases, {origin_});
    } catch (const NotRecordable& reason) {
      p_.phases.resize(before);
      out_->without_variations = reason.what();
    }
  }

  /// How outputs vary with inputs and the time while the motion does not, at all instants at which they are
  /// looked at. What phases hand on may be of another instant, so that each computes what it needs.
  void record_variations_at_rest() {
    if (m_.signals.moving_loops) {
      out_->without_variations = "has signals that go around in loops";
      return;
    }
    const std::size_t before = p_.phases.size();
    try {
      for (const Instant i :
           out_->blocks ? std::vector{Instant::fresh, Instant::rest} : std::vector{Instant::step}) {
        const std::string name = instant_names[static_cast<std::size_t>(i)];
        const std::vector<int> fixed = i == Instant::rest ? limited_ : std::vector<int>();
        differentiate(p_, {"signals_" + name}, {origin_}, variation_at_rest, fixed);
        if (out_->senses) differentiate(p_, {"sense_" + name}, {origin_}, variation_at_rest, fixed);
      }
      differentiate(p_, {"outputs"}, {origin_}, variation_at_rest);
    } catch (const NotRecordable& reason) {
      p_.phases.resize(before);
      out_->without_variations = reason.what();
    }
  }

  void add_rate(bool held, int at, const T& rate, const std::string& meaning) {
    p_.store(Memory::state_rate, static_cast<int>(out_->states.size()), rate);
    out_->states.push_back({held, at, meaning});
  }
  /// Of what force elements and signals remember.
  void record_rates() {
    int number = 0;
    phase(number, "rates", {origin_, motion_, rest_});
    enter(Instant::rest);
    read_slots();
    for (const ElementData& e : m_.elements) {
      int k = 0;
      for (const auto& [at, rate] : element_rates(e, element_state(e, w_.elements.data()), states_, numbers_))
        add_rate(false, e.states + e.own_states + at, rate,
                 fmt::format("state {} of {}", ++k, element_name(m_, e)));
    }
    const SignalsData& d = m_.signals;
    for (const SignalsData::Block& b : d.blocks) {
      const BlockInputs<T> in = block_inputs(b, w_.signals);
      BlockCall<T> call = block_call(d, b, w_.signals);
      call.in = in.data();
      const std::vector<T> rates = block_rates(call, blocks::infos[static_cast<std::size_t>(b.type)]->name);
      for (std::size_t k = 0; k < rates.size(); ++k)
        add_rate(true, b.held + 1 + b.inputs + static_cast<int>(k), rates[k],
                 fmt::format("state {} of {}", k + 1, signal_name(b.slot)));
    }
    for (const SignalsData::Integral& i : d.integrals)
      add_rate(true, i.held, slots_[static_cast<std::size_t>(i.rate)].value, "an integral over time");
  }
  std::string signal_name(int slot) const {
    const auto& slots = m_.signals.slot_of_signal;
    for (std::size_t k = 0; k < m_.spec().signals.size(); ++k)
      if (slots[k] == slot) return fmt::format("signal '{}'", m_.spec().signals[k].name);
    return "a block";
  }

  // Of a step.
  void store_rows(const MarkedElement& marked) {
    const ElementData& e = m_.elements[static_cast<std::size_t>(marked.element)];
    if (e.body >= 0) return;
    for (int k = 0; k < e.count * e.path.width; ++k) {
      const T& x = w_.jacobian[static_cast<std::size_t>(e.jacobian + k)];
      if (x.node >= 0) p_.store(Memory::rows, e.jacobian + k, x);
    }
  }

  /// Of a contact that did not touch when the matrix was assembled.
  void record_rows_anew(const ElementData& e, const std::string& name) {
    int number = 0;
    phase(number, name, {origin_, motion_, forces_});
    const auto subspaces = w_.subspaces;
    const auto assembled = w_.jacobian;
    for (const auto& [k, x] : subspaces_) w_.subspaces[static_cast<std::size_t>(k)] = x;
    relative::element_rows<T>(m_, w_, e, element_state(e, w_.elements.data()));
    for (int k = e.jacobian; k < e.jacobian + e.count * e.path.width; ++k)
      if (assembled[static_cast<std::size_t>(k)].node >= 0)
        p_.store(Memory::rows, k, w_.jacobian[static_cast<std::size_t>(k)]);
    w_.subspaces = subspaces;
    w_.jacobian = assembled;
  }

  /// Of each marked element what a change of its tangent adds to the matrix.
  void record_exchange() {
    for (std::size_t i = 0; i < out_->marked.size(); ++i) {
      const MarkedElement& marked = out_->marked[i];
      const ElementData& e = m_.elements[static_cast<std::size_t>(marked.element)];
      int number = 0;
      if (marked.contact) record_rows_anew(e, fmt::format("rows_{}", i));
      phase(number, fmt::format("exchange_{}", i), {});
      const std::vector<T> difference = p_.inputs(Memory::difference, e.count * e.count);
      std::vector<T> values(static_cast<std::size_t>(m_.symbolic.value_count()) + 2 * linalg::kLanes, T(0));
      if (e.body >= 0) {
        const linalg::BlockPlace& place = m_.diagonal[e.body];
        values[static_cast<std::size_t>(place.offset + e.local * (place.row_stride + place.col_stride))] =
            difference[0];
      } else {
        std::vector<T> rows, weighted(static_cast<std::size_t>(e.count * e.path.width));
        for (int k = 0; k < e.count * e.path.width; ++k) {
          const T& x = w_.jacobian[static_cast<std::size_t>(e.jacobian + k)];
          rows.push_back(x.node >= 0 ? p_.input(Memory::rows, e.jacobian + k) : x);
        }
        relative::weigh_rows<T>(e.count, e.path.width, rows.data(), weighted.data(), [&](int r, int c) {
          return difference[static_cast<std::size_t>(r * e.count + c)];
        });
        relative::add_pairs<T>(e.path, weighted.data(), rows.data(), e.count, values.data());
      }
      for (std::size_t k = 0; k < static_cast<std::size_t>(m_.symbolic.value_count()); ++k)
        if (values[k].node >= 0) p_.store(Memory::assembled, static_cast<int>(k), values[k], true);
    }
  }

  /// Positions and increments.
  void record_retract() {
    int number = 0;
    phase(number, "retract", {});
    const std::vector<T> x = p_.inputs(Memory::increment, m_.velocities);
    std::vector<T> moved(static_cast<std::size_t>(m_.positions));
    relative::retract<T>(m_, start_.data(), x.data(), moved.data());
    for (std::size_t k = 0; k < moved.size(); ++k) p_.store(Memory::moved, static_cast<int>(k), moved[k]);
  }
  void record_steps() {
    record_retract();
    int number = 0;
    phase(number, "compose", {});
    std::vector<T> composed = p_.inputs(Memory::increment, m_.velocities);
    const std::vector<T> correction = p_.inputs(Memory::correction, m_.velocities);
    relative::compose<T>(m_, composed.data(), correction.data());
    for (std::size_t k = 0; k < composed.size(); ++k)
      p_.store(Memory::composed, static_cast<int>(k), composed[k]);
  }

  // Outputs.
  Motion<T> motion_of(int spec_frame) {
    const int frame = m_.frame_of_spec[spec_frame];
    const FrameData& f = m_.frames[frame];
    if (frame < m_.dynamic_frames && f.full) return w_.frames[static_cast<std::size_t>(frame)];
    Motion<T> out;
    if (f.body < 0) {
      out.rotation = f.rotation.cast<T>();
      out.position = f.position.cast<T>() - w_.origin;
      out.velocity = out.omega = out.alpha = Vec3<T>::Zero();
      out.acceleration = -m_.gravity.cast<T>();
      return out;
    }
    const BodyData& b = m_.bodies[f.body];
    const int s = b.modes > 0 ? m_.flexible[b.flexible].stride : 0;
    std::vector<T> y(static_cast<std::size_t>(3 * s), T(0));
    for (int k = 0; k < b.modes; ++k) {
      y[static_cast<std::size_t>(k)] = q_[static_cast<std::size_t>(b.q + b.joint_positions + k)];
      y[static_cast<std::size_t>(s + k)] = v_[static_cast<std::size_t>(b.v + b.joint_velocities + k)];
      y[static_cast<std::size_t>(2 * s + k)] = a_[static_cast<std::size_t>(b.v + b.joint_velocities + k)];
    }
    if (b.modes > 0) {
      const FlexibleData& flexible = m_.flexible[b.flexible];
      extend(flexible, y.data());
      extend(flexible, y.data(), y.data() + s);
      extend(flexible, y.data(), y.data() + s, y.data() + 2 * s);
    }
    relative::frame_motion<T>(f, w_.bodies[static_cast<std::size_t>(f.body)], y.data(), y.data() + s,
                              y.data() + 2 * s, out);
    return out;
  }

  /// A joint's coordinates and their rates.
  struct Coordinates {
    std::array<T, 7> positions;
    std::array<T, 6> rates;
  };
  Coordinates coordinates(int joint) {
    Coordinates out;
    const spec::Joint& of = m_.spec().joints[static_cast<std::size_t>(joint)];
    const JointInfo& info = joint_info(of.type);
    for (const BodyData& b : m_.bodies) {
      if (b.joint_spec != joint) continue;
      for (int k = 0; k < info.positions; ++k)
        out.positions[static_cast<std::size_t>(k)] = q_[static_cast<std::size_t>(b.q + k)];
      for (int k = 0; k < info.velocities; ++k)
        out.rates[static_cast<std::size_t>(k)] = v_[static_cast<std::size_t>(b.v + k)];
      return out;
    }
    const Motion<T> a = motion_of(of.frame_a), b = motion_of(of.frame_b);
    Vec3<T> d, u, w;
    relative_velocity(a, b, d, u, w);
    const Mat3<T> At = a.rotation.transpose();
    joint_coordinates<T>(of.type, At * b.rotation, At * d, out.positions.data());
    const T rest[6] = {0, 0, 0, 0, 0, 0};
    JointMotion<T> motion;
    joint_motion<T>(of.type, out.positions.data(), rest, motion);
    for (int k = 0; k < info.velocities; ++k)
      out.rates[static_cast<std::size_t>(k)] =
          motion.linear.col(k).dot(At * u) + motion.angular.col(k).dot(At * w);
    return out;
  }

  T element_force(int element) { return element_state(m_.elements[element], rest_elements_.data()).force[0]; }

  T wheel_quantity(int tyre, int quantity) {
    const ElementData& e = m_.elements[m_.first_tyre + tyre];
    std::array<T, wheel_quantities.size()> values;
    read_wheel(m_, e, element_state(e, rest_elements_.data()), values.data());
    return values[static_cast<std::size_t>(quantity)];
  }

  /// The value of an output of the model. Throws NotRecordable where it is of a kind that the code has not.
  T value(const spec::Output& o) {
    const std::string& kind = o.kind;
    const std::size_t c = static_cast<std::size_t>(o.component);
    if (kind == "position") return motion_of(o.item).position[o.component] + w_.origin[o.component];
    if (kind == "velocity") return motion_of(o.item).velocity[o.component];
    if (kind == "acceleration")
      return motion_of(o.item).acceleration[o.component] + T(m_.gravity[o.component]);
    if (kind == "angular_velocity")
      return outputs::AngularVelocity::component(motion_of(o.item), o.own_axes, o.component);
    if (kind == "angular_acceleration") {
      const Motion<T> here = motion_of(o.item);
      return (o.own_axes ? Vec3<T>(here.rotation.transpose() * here.alpha) : here.alpha)[o.component];
    }
    if (kind == "roll") return outputs::Roll::angle<T>(motion_of(o.item).rotation);
    if (kind == "pitch") return outputs::Pitch::angle<T>(motion_of(o.item).rotation);
    if (kind == "yaw") return outputs::Yaw::angle<T>(motion_of(o.item).rotation);
    if (kind == "displacement") {
      const Motion<T> from = motion_of(o.reference), here = motion_of(o.item);
      const Vec3<T> direction = o.direction.cast<T>();
      return direction.dot(Vec3<T>(from.rotation.transpose() * Vec3<T>(here.position - from.position))) +
             T(o.offset);
    }
    if (kind == "deflection") {
      const FrameData& f = m_.frames[m_.frame_of_spec[o.item]];
      if (f.flexible < 0) return 0;
      const BodyData& b = m_.bodies[f.body];
      std::vector<T> y(static_cast<std::size_t>(f.X.cols()), T(0));
      for (int k = 0; k < b.modes; ++k)
        y[static_cast<std::size_t>(k)] = q_[static_cast<std::size_t>(b.q + b.joint_positions + k)];
      extend(m_.flexible[b.flexible], y.data());
      return o.direction.cast<T>().dot(times(f.X, y.data()));
    }
    if (kind == "modal_amplitude") {
      const BodyData& b = m_.bodies[m_.body_of_spec[o.item]];
      const spec::Body& body = m_.spec().bodies[static_cast<std::size_t>(o.item)];
      T sum = 0;
      if (body.flexible)
        for (int k = 0; k < b.modes; ++k)
          sum += T(body.flexible->user_from_modal(o.component, k)) *
                 q_[static_cast<std::size_t>(b.q + b.joint_positions + k)];
      return sum;
    }
    if (kind == "joint") return coordinates(o.item).positions[c] + T(o.offset);
    if (kind == "joint_velocity") return coordinates(o.item).rates[c];
    if (kind == "spring_force") return element_force(o.item);
    if (kind == "spring_length") return element_state(m_.elements[o.item], rest_elements_.data()).x[0];
    if (kind == "tyre_force" && o.component == 0) return -element_force(m_.first_tyre + o.item);
    for (const auto& [name, first] :
         {std::pair("tyre_force", -1), std::pair("tyre_moment", first_wheel_moment),
          std::pair("tyre_slip", first_wheel_slip), std::pair("tyre_slip_angle", first_wheel_slip + 1),
          std::pair("tyre_camber", first_wheel_slip + 2), std::pair("tyre_deflection", first_wheel_slip + 3)})
      if (kind == name) return wheel_quantity(o.item, first + (first < first_wheel_slip ? o.component : 0));
    throw NotRecordable(kind);
  }

  void add_output(const std::string& name, const std::string& unit, const std::string& meaning,
                  const T& made) {
    p_.store(Memory::output, static_cast<int>(out_->outputs.size()), made);
    out_->outputs.push_back({name, unit, meaning});
  }

  void record_outputs() {
    int number = 0;
    phase(number, "outputs", {origin_, motion_, rest_});
    enter(Instant::rest);
    read_slots();
    for (const spec::Output& o : m_.spec().outputs) {
      try {
        const T made = value(o);
        const ChannelInfo info = output_info(o).describe(m_, o);
        add_output(info.name, info.unit, info.meaning, made);
      } catch (const NotRecordable&) {
        out_->left_out.push_back(fmt::format("{} ({})", o.name, o.kind));
      }
    }
    for (std::size_t k = 0; k < m_.spec().signals.size(); ++k) {
      const int slot = m_.signals.slot_of_signal[k];
      if (slot < 0) continue;
      const spec::Signal& signal = m_.spec().signals[k];
      if (signal.named)
        add_output(signal.name, signal.unit.empty() ? "1" : signal.unit,
                   fmt::format("signal '{}'", signal.name), slots_[static_cast<std::size_t>(slot)].value);
    }
    for (std::size_t k = 0; k < m_.spec().events.size(); ++k) {
      std::vector<ChannelInfo> info;
      add_event_info(m_.spec().events[k], info);
      for (const auto& [channel, memory] :
           {std::pair(&info[0], Memory::event_count), std::pair(&info[1], Memory::event_time)})
        add_output(channel->name, channel->unit, channel->meaning, p_.input(memory, static_cast<int>(k)));
    }
    for (std::size_t j = 0; j < m_.spec().joints.size() && m_.spec().outputs.empty(); ++j) {
      const spec::Joint& joint = m_.spec().joints[j];
      const JointInfo& info = joint_info(joint.type);
      const Coordinates of = coordinates(static_cast<int>(j));
      const int plain = info.quaternion < 0 ? info.velocities : info.quaternion;
      for (int k = 0; k < plain; ++k)
        add_output(fmt::format("joint.{}.position{}", joint.name,
                               info.velocities > 1 ? fmt::format(".{}", k) : std::string()),
                   is_angle(joint.type, k) ? "rad" : "m",
                   fmt::format("coordinate {} of joint '{}'", k, joint.name),
                   of.positions[static_cast<std::size_t>(k)]);
    }
  }

  // Instants.
  T seen(const SignalsData::Seen& of) {
    std::array<T, Formula::most_variables> x;
    for (std::size_t k = 0; k < of.arguments.size(); ++k) {
      const SignalsData::Seen::Argument& a = of.arguments[k];
      x[k] = a.sensor >= 0 ? value(m_.spec().sensors[static_cast<std::size_t>(a.sensor)])
                           : slots_[static_cast<std::size_t>(a.slot)].value;
    }
    return value_at(of.formula, x.data());
  }
  /// What is evaluated at instants: of blocks the first time and later.
  void record_samples() {
    const SignalsData& d = m_.signals;
    for (std::size_t k = 0; k < d.sampled.size(); ++k) {
      const SignalsData::Sampled& s = d.sampled[k];
      for (const bool first : {true, false})
        if (s.block >= 0 || !first)
          record_sample(s, fmt::format("sample_{}_{}", k, first ? "first" : "next"), first);
    }
  }
  void record_sample(const SignalsData::Sampled& s, const std::string& name, bool first) {
    const SignalsData& d = m_.signals;
    int number = 0, at = 0;
    phase(number, name, {origin_, motion_, rest_});
    enter(Instant::rest);
    read_slots();
    std::array<T, most_block_inputs> in;
    for (std::size_t k = 0; k < s.inputs.size(); ++k) {
      try {
        in[k] = seen(s.inputs[k]);
      } catch (const NotRecordable& kind) {
        throw NotRecordable(fmt::format(
            "has a signal with 'every' that sees a {}, which the code does not have", kind.what()));
      }
    }
    if (s.block < 0) return p_.store(Memory::sampled, 0, in[0]);
    const SignalsData::Block& b = d.blocks[static_cast<std::size_t>(s.block)];
    const T* held = held_.data() + b.held;
    std::array<T, most_block_outputs> out;
    const BlockCall<T> call = sampled_call<T>(d, b, held, std::numeric_limits<double>::quiet_NaN(),
                                              first ? 0 : s.every, !first, in.data(), out.data());
    if (block_info(b.type).name == "noise")
      out[0] = record_call({call.numbers, b.every, static_cast<int>(RecordedCallee::noise)}, time(), nullptr,
                           1)[0];
    else
      blocks::rows<T>[static_cast<std::size_t>(b.type)].output(call);
    for (int k = 0; k < b.outputs; ++k) p_.store(Memory::sampled, at++, out[static_cast<std::size_t>(k)]);
    std::vector<T> states(static_cast<std::size_t>(is_delay(b) ? 0 : b.states));
    keep_states(call, blocks::infos[static_cast<std::size_t>(b.type)]->name, states.data());
    p_.store(Memory::sampled, at++, T(1));
    for (int k = 0; k < b.inputs; ++k) p_.store(Memory::sampled, at++, in[static_cast<std::size_t>(k)]);
    for (const T& x : states) p_.store(Memory::sampled, at++, x);
  }

  /// Their values, and what they set.
  void record_events() {
    if (m_.spec().events.empty()) return;
    int number = 0, at = 0;
    phase(number, "events", {origin_, motion_, rest_});
    enter(Instant::rest);
    read_slots();
    try {
      for (std::size_t k = 0; k < m_.spec().events.size(); ++k)
        p_.store(Memory::event_value, static_cast<int>(k), seen(seen_of(m_, m_.spec().events[k].when)));
      for (const spec::Event& e : m_.spec().events)
        for (const spec::Event::Set& set : e.sets)
          p_.store(Memory::event_set, at++, seen(seen_of(m_, set.value)));
    } catch (const NotRecordable& kind) {
      throw NotRecordable(
          fmt::format("has an event that sees a {}, which the code does not have", kind.what()));
    }
  }

  struct Slot {
    T value, first, second;
  };

  std::unique_ptr<RecordedModel> out_;
  Program& p_;
  const Compiled& m_;
  const MatrixWeights weights_;
  const std::vector<double>& penalty_;
  const double step_;
  const std::vector<double>& small_marks_;
  relative::Workspace<T> w_;
  const std::vector<T> start_, q_, v_, a_, multipliers_, states_, numbers_;
  std::vector<T> held_, next_held_, residual_;
  std::vector<Slot> slots_;                ///< as phases read them
  std::vector<std::pair<T, T>> feedback_;  ///< by element
  AlignedVector<T> rest_elements_;
  int origin_ = -1, motion_ = -1, rest_ = -1, forces_ = -1, matrix_ = -1;
  std::array<int, 3> signals_{}, senses_{}, blocks_{};
  std::map<int, T> subspaces_;  ///< those of contacts, as they were when the matrix was assembled
  std::vector<int> limited_;    ///< nodes of blocks that limit rates, at rest
};

}  // namespace

std::unique_ptr<RecordedModel> record_model(const Compiled& model, const MatrixWeights& weights,
                                            const std::vector<double>& penalty, double step,
                                            const std::vector<double>& small_marks, bool varies) {
  return Recorder(model, weights, penalty, step, small_marks).record(varies);
}

std::unique_ptr<RecordedModel> record_instant(const Compiled& model) {
  const std::vector<double> none;
  return Recorder(model, {0, 0, 0}, none, 1, none).record_instant();
}

}  // namespace mimbre::portable
