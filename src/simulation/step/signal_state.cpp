#include "simulation/step/signal_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "signals/once/sampled_chains.h"
#include "simulation/describe/names.h"

namespace mimbre {

namespace {

const SignalsData::HeldInput& held(const Compiled& m, int input) {
  const auto& all = m.signals.held;
  return *std::find_if(all.begin(), all.end(),
                       [&](const SignalsData::HeldInput& h) { return h.input == input; });
}

double within_range(const Compiled& m, int input, double value) {
  const spec::Input& range = m.spec().inputs[static_cast<std::size_t>(input)];
  return std::clamp(value, range.min, range.max);
}

/// What is held has another value from now on.
void note_jump(const Compiled& m, State& state) {
  if (m.signals.clock >= 0) state.u[m.signals.clock + 1] = 1;
}

/// Moves a block's memory, which is there, on to now. True where its output jumps by that.
bool keep_block(const SignalsData::Block& b, const BlockCall<double>& call, double* held) {
  const bool jumps = blocks::rows<double>[static_cast<std::size_t>(b.type)].keep(call, held + 1 + b.inputs);
  if (call.h > 0 || call.sampled()) held[0] = 1;
  std::copy_n(call.in, b.inputs, held + 1);
  return jumps;
}

/// The model. What is due more often than there are steps would be late, without a word: throws InputError.
const Compiled& with_intervals(const Compiled& m, double step) {
  const auto check = [&](const std::string& name, const Mark& mark, double every) {
    if (every > 0 && step > every * (1 + 1e-6))
      throw InputError(mark, fmt::format("signal '{}' is evaluated every {} s, and the steps are of {} s: "
                                         "take steps of {} s or shorter, or a longer 'every'",
                                         name, every, step, every));
  };
  for (const spec::Block& b : m.spec().blocks) check(b.name, b.mark, b.every);
  for (const spec::Signal& s : m.spec().signals)
    if (s.block < 0) check(s.name, s.mark, s.every);
  return m;
}

}  // namespace

int find_input(const Compiled& m, const std::string& name) {
  return find_by_name(m.spec().inputs, name, "input or tunable parameter");
}

void start_signals(const Compiled& m, const std::map<std::string, double>& inputs, State& state) {
  state.u = Eigen::Map<const Eigen::VectorXd>(m.signals.start.data(), std::ssize(m.signals.start));
  state.z = Eigen::Map<const Eigen::VectorXd>(m.states.data(), std::ssize(m.states));
  for (const auto& [name, value] : inputs) {
    const int input = find_input(m, name);
    if (!std::isfinite(value))
      throw InputError(Mark{}, fmt::format("input '{}': is {}; a finite number is needed", name, value));
    const SignalsData::HeldInput& h = held(m, input);
    state.u[h.held] = within_range(m, input, value);
    if (h.linear) state.u[h.held + 2] = state.u[h.held];
  }
}

namespace {

void commit_element(const ElementData& e, const relative::Workspace<double>& w, State& state) {
  const ElementState<const double> s = element_state(e, w.elements.data());
  std::copy_n(s.states, e.state_count, state.z.data() + e.states);
}

}  // namespace

void commit_signalled_laws(const Compiled& m, const relative::RelativeSystem& system, State& state) {
  for (const ElementData& e : m.elements)
    if (e.state_count > 0 && e.argument_count > 0 && !e.user) commit_element(e, system.workspace(), state);
}

void commit_signals(const Compiled& m, const relative::RelativeSystem& system, State& state) {
  const auto& w = system.workspace();
  for (const ElementData& e : m.elements)
    if (e.state_count > 0) commit_element(e, w, state);
  for (const ConstraintData& c : m.constraints)
    std::copy_n(w.constraint_states.data() + c.next_states, c.state_count, state.z.data() + c.states);
  for (const SignalsData::Integral& i : m.signals.integrals) {
    state.u[i.held] = w.signals.value[i.slot];
    state.u[i.held + 1] = state.time;
  }
  commit_blocks(m, system, state);
}

void commit_blocks(const Compiled& m, const relative::RelativeSystem& system, State& state) {
  const SignalsData& d = m.signals;
  if (d.clock < 0) return;
  const SignalValues<double>& s = system.workspace().signals;
  state.u[d.clock] = s.time;
  state.u[d.clock + 1] = 0;
  for (const SignalsData::Block& b : d.blocks) {
    if (b.every > 0) continue;
    const BlockInputs<double> in = block_inputs(b, s);
    BlockCall<double> call = block_call(d, b, s);
    call.in = in.data();
    if (!keep_block(b, call, state.u.data() + b.held)) continue;
    state.started = false;
    note_jump(m, state);
  }
}

bool inputs_jumped(const Compiled& m, const State& state) {
  return m.signals.clock >= 0 && state.u[m.signals.clock + 1] > 0;
}

void set_held_input(const Compiled& m, int input, double value, double step, State& state) {
  const SignalsData::HeldInput& h = held(m, input);
  value = within_range(m, input, value);
  double* at = state.u.data() + h.held;
  if (!h.linear) {
    // A jump: the step starts from accelerations with the new value. Who sets an input before every step has
    // steps for jumps, and pays for one factorisation each.
    if (value != at[0] && state.time - at[1] > 1.5 * step) state.started = false;
    if (value != at[0]) {
      at[1] = state.time;
      note_jump(m, state);
    }
    at[0] = value;
    return;
  }
  at[0] = held_input(h, state.u.data(), state.time).value;
  at[1] = state.time;
  at[2] = value;
  at[3] = state.time + step;
}

double held_input_value(const Compiled& m, int input, const State& state) {
  return held_input(held(m, input), state.u.data(), state.time).value;
}

Seen::Seen(const Compiled& m, SignalsData::Seen data) : data_(std::move(data)) {
  for (const SignalsData::Seen::Argument& a : data_.arguments) {
    sensors_.emplace_back();
    if (a.sensor >= 0) sensors_.back().emplace(m, m.spec().sensors[static_cast<std::size_t>(a.sensor)]);
  }
}

double Seen::value(const Channels& channels, relative::RelativeSystem& system, const State& state) const {
  std::array<double, Formula::most_variables> x;
  for (std::size_t k = 0; k < sensors_.size(); ++k)
    x[k] = sensors_[k] ? channels.value(*sensors_[k], system, state)
                       : system.workspace().signals.value[static_cast<std::size_t>(data_.arguments[k].slot)];
  return data_.formula.value(x.data());
}

Sampler::Sampler(const Compiled& m, double step) : model_(m), outside_(with_intervals(m, step), step) {
  const std::vector<char> chained = takes_sampled(m.signals);
  for (const SignalsData::Sampled& s : m.signals.sampled) {
    signals_.push_back({&s, {}, chained[signals_.size()] != 0});
    for (const SignalsData::Seen& input : s.inputs) signals_.back().inputs.emplace_back(m, input);
  }
  for (std::size_t k = 0; k < m.elements.size(); ++k)
    if (m.elements[k].sampled) laws_.push_back(static_cast<int>(k));
}

/// What a sampled block makes of inputs at an instant; its memory moves on.
void Sampler::make_block(const SignalsData::Sampled& s, const double* in, double made, State& state,
                         double* out) {
  const SignalsData& d = model_.signals;
  const SignalsData::Block& b = d.blocks[static_cast<std::size_t>(s.block)];
  double* held = state.u.data() + b.held;
  const bool begun = held[0] > 0.5;
  // Steps come to instants but for round-off.
  const double h = begun ? std::round((state.time - made) / s.every) * s.every : 0;
  const BlockCall<double> call = sampled_call<double>(d, b, held, state.time, h, begun, in, out);
  blocks::rows<double>[static_cast<std::size_t>(b.type)].output(call);
  keep_block(b, call, held);
}

bool Sampler::sample(const Channels& channels, relative::RelativeSystem& system, const State& seen,
                     double step, State& state) {
  auto& w = system.workspace();
  bool stale = false;  // signals are of before what has been made now
  const auto refresh = [&] {
    const double* held = std::exchange(w.signals.held, state.u.data());
    w.signals.time = std::numeric_limits<double>::quiet_NaN();
    fix_signals(model_.signals, state.time, w.signals);
    make_moving_signals(model_.signals, w.signals);
    w.signals.held = held;
    w.signals.time = std::numeric_limits<double>::quiet_NaN();
    stale = false;
  };
  for (const Signal& s : signals_) {
    const SignalsData::Sampled& data = *s.data;
    double *at = state.u.data() + data.held, &due = at[data.values], &made = at[data.values + 1];
    // Sums of steps are off their multiples by round-off.
    if (state.time < due - 1e-6 * data.every) continue;
    static_assert(most_outside_values >= most_block_inputs && most_outside_values >= most_block_outputs);
    if (stale && s.chained) refresh();
    std::array<double, most_outside_values> in;
    std::array<double, most_outside_values> out;
    for (std::size_t k = 0; k < s.inputs.size(); ++k) in[k] = s.inputs[k].value(channels, system, seen);
    if (data.block < 0)
      out[0] = in[0];
    else if (model_.spec().blocks[static_cast<std::size_t>(data.block)].outside) {
      if (!outside_.exchange(data, in.data(), made, state, out.data())) return false;
    } else
      make_block(data, in.data(), made, state, out.data());
    for (int k = 0; k < data.values; ++k) {
      if (out[k] == at[k]) continue;
      if (data.every > 1.5 * step) state.started = false;  // as of inputs
      note_jump(model_, state);
      at[k] = out[k];
      stale = true;
    }
    made = state.time;
    // The next instant that is a multiple of the interval.
    due = (std::floor(state.time / data.every + 1e-6) + 1) * data.every;
  }
  if (stale && !laws_.empty()) refresh();
  for (const int k : laws_) {
    const ElementData& e = model_.elements[static_cast<std::size_t>(k)];
    ElementState<double> s = element_state(e, w.elements.data());
    double* own = state.z.data() + e.states + e.own_states;
    std::array<double, forces::user::most_arguments> next{};
    const LawContext<double> context = law_context(model_, e, w.signals);
    // The force that is kept comes first.
    const forces::user::Answer answer =
        forces::user::call(context, s.x, s.v, context.states + e.own_states + e.count, next.data());
    std::copy_n(answer.force, e.count, own);
    std::copy_n(next.data(), context.user().states.size(), own + e.count);
  }
  return true;
}

}  // namespace mimbre
