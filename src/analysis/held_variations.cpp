#include "analysis/held_variations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "dynamics/relative/forces.h"
#include "dynamics/relative/kinematics.h"
#include "dynamics/relative/workspace_impl.h"
#include "math/dual.h"
#include "mimbre/diagnostics.h"
#include "signals/blocks/table.h"
#include "simulation/observe/channels.h"
#include "simulation/observe/shown_reactions.h"
#include "simulation/step/mechanism.h"

namespace mimbre {

using Eigen::VectorXd;

namespace {

using Part = Channels::Part;

/// fix_signals() at an instant: `by_time` is the derivative of the time.
void fix_varied_signals(const SignalsData& d, double time, double by_time, SignalValues<Dual>& s) {
  s.time = time;
  s.put(0, JetOf<Dual>{Dual(time, by_time), Dual(1), Dual(0)});
  for (const SignalsData::HeldInput& h : d.held) {
    JetOf<Dual> jet = held_input(h, s.held, time);
    jet.value.derivative += jet.first.value * by_time;
    s.put(h.slot, jet);
  }
  for (const SignalsData::OfTime& f : d.of_time) {
    const Jet jet = f.function.jet(time);
    s.put(f.slot, JetOf<Dual>{Dual(jet.value, jet.first * by_time), Dual(jet.first, jet.second * by_time),
                              jet.second});
  }
  enter_blocks(d, s);
  make_signals(d, d.fixed, d.fixed_loops, s, [&](const SignalsData::Computed& f) {
    if (f.block < 0)
      s.put(f.slot, signal_jet(f.law, s));
    else
      make_block_jets(d, d.blocks[static_cast<std::size_t>(f.block)], s);
  });
  for (const SignalsData::Integral& i : d.integrals) {
    const Dual span = Dual(time, by_time) - s.held[i.held + 1],
               now = s.value[static_cast<std::size_t>(i.rate)];
    const Dual rate = s.rate[static_cast<std::size_t>(i.rate)];
    s.put(i.slot, JetOf<Dual>{s.held[i.held] + span * (now - Dual(0.5) * span * rate), now, rate});
  }
}

/// How a channel's derivative is found.
enum class Way { none, dual, differences };

/// Of an output: dual where it is linear in the signals, or in what one element measures and does.
Way way_of_output(const spec::Output& output, Channels::Needs needs) {
  if (needs == Channels::Needs::motion) return Way::none;
  const std::string_view kind = output_info(output).name;
  const bool linear = kind == "signal" || kind == "input" || kind.starts_with("spring_") ||
                      kind.starts_with("element_") || (kind == "tyre_force" && output.component == 0);
  return linear ? Way::dual : Way::differences;
}

Way way_of(const spec::Model& model, const Part& part) {
  using Kind = Part::Kind;
  switch (part.kind) {
    case Kind::input:
    case Kind::signal:
    case Kind::spring:
    case Kind::tyre:
    case Kind::load:
    case Kind::element:
      return Way::dual;
    case Kind::output:
      return way_of_output(model.outputs[static_cast<std::size_t>(part.item)], part.needs);
    default:
      return part.needs == Channels::Needs::motion ? Way::none : Way::differences;
  }
}

std::vector<Dual> duals_of(const VectorXd& values) { return {values.begin(), values.end()}; }

/// The derivative at 0 of what `f(x)` returns, a vector, by central differences over widths from `width`
/// downwards, extrapolated: each component from where its error is estimated as smallest (Ridders, Advances
/// in Engineering Software 4, 1982).
template <class F>
VectorXd extrapolated_slope(const F& f, double width) {
  constexpr int levels = 6;
  constexpr double shrink = 1.6;
  std::array<VectorXd, levels> row, before;
  VectorXd best, error;
  for (int k = 0; k < levels; ++k, width /= shrink) {
    std::swap(row, before);
    row[0] = (f(width) - f(-width)) / (2 * width);
    if (k == 0) {
      best = row[0];
      error = VectorXd::Constant(best.size(), std::numeric_limits<double>::infinity());
    }
    double factor = 1;
    for (int j = 1; j <= k; ++j) {
      factor *= shrink * shrink;
      const VectorXd &finer = row[static_cast<std::size_t>(j - 1)],
                     &coarser = before[static_cast<std::size_t>(j - 1)];
      VectorXd& made = row[static_cast<std::size_t>(j)];
      made = finer + (finer - coarser) / (factor - 1);
      for (Eigen::Index i = 0; i < best.size(); ++i) {
        const double e = std::max(std::abs(made[i] - finer[i]), std::abs(made[i] - coarser[i]));
        if (!(e < error[i])) continue;
        error[i] = e;
        best[i] = made[i];
      }
    }
  }
  return best;
}

}  // namespace

struct HeldVariations::Impl {
  Impl(std::shared_ptr<const Model> given, const Method& of_method, bool redundant)
      : model(std::move(given)),
        method(of_method),
        m(model->compiled()),
        mechanism(m, method),
        channels(m),
        reactions(mechanism, method, redundant),
        values(static_cast<Eigen::Index>(channels.info().size())),
        residual(m.velocities),
        work(m),
        numbers(m.numbers.begin(), m.numbers.end()) {
    State& seen = mechanism.seen;
    seen.q.setZero(m.positions);
    seen.v.setZero(m.velocities);
    seen.a = seen.algorithmic = seen.v;
    seen.multipliers.setZero(m.equations);
    for (const spec::Input& input : m.spec().inputs) {
      const double wide = input.max - input.min;
      ranges.push_back(std::isfinite(wide) ? wide : 0);
    }
  }

  /// Shows forces at the mechanism's state.
  void show_forces() {
    mechanism.enter(0);
    mechanism.observe_afresh();
    const State& s = mechanism.view();
    mechanism.observer.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0,
                                residual.data());
  }

  void enter(const Simulation::Snapshot& c) {
    mechanism.state = {c.time,         c.q,      c.v, c.a, c.algorithmic, c.multipliers, c.z, c.u,
                       c.energy_error, c.started};
    show_forces();
    const State& s = mechanism.view();
    q = duals_of(s.q);
    v = duals_of(s.v);
    a = duals_of(s.a);
    held = duals_of(c.u);
    states = duals_of(c.z);
    hold_limited();
  }

  /// A limit of rates lets nothing change at once, although at rest its value is that of its input but for
  /// round-off: it is put a little below that.
  void hold_limited() {
    for (const SignalsData::Block& b : m.signals.blocks) {
      if (b.every > 0 || blocks::infos[static_cast<std::size_t>(b.type)]->name != "rate_limit") continue;
      double& value = held[static_cast<std::size_t>(b.held + 1 + b.inputs)].value;
      value -=
          100 * std::numeric_limits<double>::epsilon() * std::abs(value) + std::numeric_limits<double>::min();
    }
  }

  /// Signals and elements over dual numbers.
  void evaluate(std::span<const double> inputs, double by_time) {
    for (const SignalsData::HeldInput& h : m.signals.held)
      if (h.input >= 0 && !h.linear)
        held[static_cast<std::size_t>(h.held)].derivative = inputs[static_cast<std::size_t>(h.input)];
    work.signals.enter(held.data(), states.data(), 0);
    work.signals.numbers = numbers.data();
    relative::move_origin<Dual>(m, work, mechanism.observer.workspace().origin.cast<Dual>());
    relative::kinematics<Dual>(m, work, q.data(), v.data(), a.data());
    fix_varied_signals(m.signals, mechanism.state.time, by_time, work.signals);
    relative::measure_elements<Dual>(m, work, q.data(), v.data(), a.data());
    relative::sense<Dual>(m, work, q.data());
    for (const ElementData& e : m.elements) {
      const ElementEnds ends = ends_of(m, e, work.signals.states + e.states);
      if (ends.frame_b < 0 && e.pooled) continue;
      evaluate_law(m, e, work.signals, work.elements.data());
    }
  }

  /// Reads channels that are linear in signals, measures and forces from their derivatives.
  void read_duals(const std::vector<int>& parts) {
    relative::Workspace<double>& w = mechanism.observer.workspace();
    for (std::size_t k = 0; k < w.signals.value.size(); ++k)
      w.signals.value[k] = work.signals.value[k].derivative;
    for (const ElementData& e : m.elements) {
      const ElementState<double> to = element_state(e, w.elements.data());
      const ElementState<Dual> from = element_state(e, work.elements.data());
      for (int k = 0; k < e.count; ++k) {
        to.x[k] = from.x[k].derivative;
        to.v[k] = from.v[k].derivative;
        to.force[k] = from.force[k].derivative;
      }
    }
    read(parts, mechanism.observer, mechanism.view());
  }

  void read(const std::vector<int>& parts, relative::RelativeSystem& system, const State& state) {
    for (const int part : parts)
      channels.read(channels.parts()[static_cast<std::size_t>(part)], system, state, EnergyBalance{}, {},
                    values.data());
  }

  /// All values of channels, of which those of the parts are read, where inputs and the time have moved along
  /// the direction.
  VectorXd shown(const Simulation::Snapshot& c, std::span<const double> inputs, double by_time, double ahead,
                 const std::vector<int>& parts) {
    State& s = mechanism.state;
    s.u = c.u;
    s.time = c.time + ahead * by_time;
    for (const SignalsData::HeldInput& h : m.signals.held)
      if (h.input >= 0 && !h.linear) s.u[h.held] += ahead * inputs[static_cast<std::size_t>(h.input)];
    show_forces();
    relative::RelativeSystem& system = reactions.find(mechanism);
    values.setZero();
    read(parts, system, reactions.state());
    return values;
  }

  /// By which the direction is divided for differences: a share of each input's size and of a few steps.
  double width(const Simulation::Snapshot& c, std::span<const double> inputs, double by_time) const {
    double most = std::abs(by_time) / (10 * method.step);
    for (const SignalsData::HeldInput& h : m.signals.held) {
      if (h.input < 0 || h.linear) continue;
      const auto at = static_cast<std::size_t>(h.input);
      const double size = std::max(std::abs(c.u[h.held]), 0.1 * ranges[at]);
      most = std::max(most, std::abs(inputs[at]) / (size > 0 ? size : 1));
    }
    return most > 0 ? 0.1 / most : 0;
  }

  std::shared_ptr<const Model> model;
  const Method method;
  const Compiled& m;
  Mechanism mechanism;
  Channels channels;
  ShownReactions reactions;
  VectorXd values, residual;
  relative::Workspace<Dual> work;
  std::vector<Dual> numbers, held, states, q, v, a;
  std::vector<double> ranges;  ///< of inputs: how wide; 0: without end
};

HeldVariations::HeldVariations(std::shared_ptr<const Model> model, const Method& method, bool redundant)
    : impl_(std::make_unique<Impl>(std::move(model), method, redundant)) {}
HeldVariations::~HeldVariations() = default;

void HeldVariations::along(const Simulation::Snapshot& state, std::span<const double> inputs, double time,
                           std::span<const int> wanted, double* derivatives) {
  Impl& i = *impl_;
  std::vector<int> exact, others;
  const auto note = [](std::vector<int>& parts, int part) {
    if (std::find(parts.begin(), parts.end(), part) == parts.end()) parts.push_back(part);
  };
  for (const int channel : wanted) {
    const int part = i.channels.part_of(channel);
    const Way way = way_of(i.m.spec(), i.channels.parts()[static_cast<std::size_t>(part)]);
    if (way != Way::none) note(way == Way::dual ? exact : others, part);
  }
  VectorXd out = VectorXd::Zero(i.values.size());
  if (!exact.empty() || !others.empty()) i.enter(state);
  if (!exact.empty()) {
    i.evaluate(inputs, time);
    i.values.setZero();
    i.read_duals(exact);
    out += i.values;
  }
  if (const double width = i.width(state, inputs, time); width > 0 && !others.empty())
    out +=
        extrapolated_slope([&](double ahead) { return i.shown(state, inputs, time, ahead, others); }, width);
  for (std::size_t k = 0; k < wanted.size(); ++k) derivatives[k] = out[wanted[k]];
}

}  // namespace mimbre
