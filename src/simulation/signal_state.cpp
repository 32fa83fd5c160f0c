#include "simulation/signal_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simulation/names.h"

namespace mimbre {

namespace {

const SignalsData::Held& held(const Compiled& m, int input) {
  const auto& all = m.signals.held;
  return *std::find_if(all.begin(), all.end(), [&](const SignalsData::Held& h) { return h.input == input; });
}

double within_range(const Compiled& m, int input, double value) {
  const spec::Input& range = m.spec().inputs[static_cast<std::size_t>(input)];
  return std::clamp(value, range.min, range.max);
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
    const SignalsData::Held& h = held(m, input);
    state.u[h.held] = within_range(m, input, value);
    if (h.linear) state.u[h.held + 2] = state.u[h.held];
  }
}

void commit_signals(const Compiled& m, const relative::RelativeSystem& system, State& state) {
  const auto& w = system.workspace();
  for (const ElementData& e : m.elements) {
    if (e.state_count == 0) continue;
    const ElementState<const double> s = element_state(e, w.elements.data());
    std::copy_n(s.states, e.state_count, state.z.data() + e.states);
  }
  for (const SignalsData::Integral& i : m.signals.integrals) {
    state.u[i.held] = w.signals.value[i.slot];
    state.u[i.held + 1] = state.time;
  }
}

void set_held_input(const Compiled& m, int input, double value, double step, State& state) {
  const SignalsData::Held& h = held(m, input);
  value = within_range(m, input, value);
  double* at = state.u.data() + h.held;
  if (!h.linear) {
    // A jump: the step starts from accelerations with the new value. Who sets an input before every step has
    // steps for jumps, and pays for one factorisation each.
    if (value != at[0] && state.time - at[1] > 1.5 * step) state.started = false;
    if (value != at[0]) at[1] = state.time;
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

Sampler::Sampler(const Compiled& m) : model_(m) {
  for (const SignalsData::Sampled& s : m.signals.sampled) {
    Signal signal{&s, {}, {}};
    for (const SignalsData::Sampled::Argument& a : s.arguments) {
      signal.sensors.push_back(a.sensor < 0 ? nullptr
                                            : &m.spec().sensors[static_cast<std::size_t>(a.sensor)]);
      signal.mass_of.push_back(a.sensor < 0 ? std::vector<int>() : bodies_of(m, *signal.sensors.back()));
    }
    signals_.push_back(std::move(signal));
  }
  for (std::size_t k = 0; k < m.elements.size(); ++k)
    if (m.elements[k].sampled) laws_.push_back(static_cast<int>(k));
}

void Sampler::sample(const Channels& channels, relative::RelativeSystem& system, const State& seen,
                     double step, State& state) {
  auto& w = system.workspace();
  for (const Signal& s : signals_) {
    double* at = state.u.data() + s.data->held;
    // Sums of steps are off their multiples by round-off.
    if (state.time < at[1] - 1e-6 * s.data->every) continue;
    std::array<double, Formula::most_variables> x;
    for (std::size_t k = 0; k < s.sensors.size(); ++k)
      x[k] = s.sensors[k] ? channels.value(*s.sensors[k], s.mass_of[k], system, seen)
                          : w.signals.value[s.data->arguments[k].slot];
    const double value = s.data->formula.value(x.data());
    if (value != at[0] && s.data->every > 1.5 * step) state.started = false;  // as of inputs
    at[0] = value;
    // The next instant that is a multiple of the interval.
    at[1] = (std::floor(state.time / s.data->every + 1e-6) + 1) * s.data->every;
  }
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
}

}  // namespace mimbre
