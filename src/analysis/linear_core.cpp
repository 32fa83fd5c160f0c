#include "analysis/linear_core.h"

#include <algorithm>
#include <cmath>

#include "dynamics/relative/evaluation.h"
#include "dynamics/relative/retract.h"
#include "dynamics/relative/workspace_impl.h"
#include "math/dual.h"
#include "signals/blocks/linear.h"
#include "signals/blocks/table.h"

/// The unit that compiles all of the core over dual numbers.
namespace mimbre::linear {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int places(const ElementData& e) {
  return 2 * e.count + surroundings_size(e.measure) + e.argument_count;
}

std::string_view block_name(const SignalsData::Block& b) {
  return blocks::infos[static_cast<std::size_t>(b.type)]->name;
}

/// Whether a continuous block has states with rates: those of a limit of rates, a delay and a relay have
/// none.
bool has_rates(const SignalsData::Block& b) {
  const std::string_view name = block_name(b);
  return !(b.every > 0) && b.states > 0 && name != "rate_limit" && name != "delay" && name != "hysteresis";
}

/// ẋ of a continuous block at its states x (first) and inputs u (behind them), and by both. Linear ones have
/// their matrices; others are asked for short steps, in which their inputs stay: those are piecewise linear
/// in x and u.
struct BlockRates {
  VectorXd value;
  MatrixXd by;  ///< states × (states + inputs)
};
BlockRates block_rates(const SignalsData& d, const SignalsData::Block& b, const VectorXd& at, double pace) {
  const int n = b.states, inputs = b.inputs;
  const double* numbers = d.numbers.data() + b.numbers;
  const auto& row = blocks::rows<double>[static_cast<std::size_t>(b.type)];
  BlockRates out{VectorXd(n), MatrixXd(n, n + inputs)};
  if (row.prepare == blocks::linear::discretise) {
    const blocks::linear::Shape s{n, inputs, b.outputs};
    for (int r = 0; r < n; ++r) {
      for (int c = 0; c < n; ++c) out.by(r, c) = numbers[r * n + c];
      for (int c = 0; c < inputs; ++c) out.by(r, n + c) = numbers[s.b() + r * inputs + c];
    }
    out.value = out.by * at;
    return out;
  }
  std::vector<double> matrices(static_cast<std::size_t>(d.matrices));
  const auto rate = [&](const VectorXd& x, double h) {
    if (row.prepare) row.prepare(b, numbers, h, matrices.data());
    VectorXd states = x.head(n);
    const VectorXd in = x.tail(inputs);
    BlockCall<double> call{numbers,
                           matrices.data(),
                           b.function < 0 ? nullptr : &d.functions[static_cast<std::size_t>(b.function)],
                           inputs,
                           b.outputs,
                           n,
                           0,
                           0,
                           h,
                           true,
                           x.data(),
                           in.data(),
                           in.data(),
                           nullptr};
    row.keep(call, states.data());
    return VectorXd((states - x.head(n)) / h);
  };
  // To h → 0 from three steps.
  const auto limit = [&](const VectorXd& x) {
    const double h = 1e-3 / pace;
    const VectorXd a = rate(x, h), c = rate(x, h / 2), e = rate(x, h / 4), f = 2 * c - a, g = 2 * e - c;
    return VectorXd(g + (g - f) / 3);
  };
  out.value = limit(at);
  for (int c = 0; c < n + inputs; ++c) {
    VectorXd x = at;
    const double width = 1e-4 * std::max(1.0, std::abs(at[c]));
    x[c] = at[c] + width;
    const VectorXd plus = limit(x);
    x[c] = at[c] - width;
    out.by.col(c) = (plus - limit(x)) / (2 * width);
  }
  return out;
}

}  // namespace

struct LinearCore::Impl {
  Impl(const Compiled& compiled, const State& s, double given_pace)
      : m(compiled),
        state(s),
        pace(given_pace),
        work(compiled),
        numbers(compiled.numbers.begin(), compiled.numbers.end()),
        held(s.u.begin(), s.u.end()),
        states(s.z.begin(), s.z.end()),
        q(s.q.begin(), s.q.end()),
        v(s.v.begin(), s.v.end()),
        a(static_cast<std::size_t>(compiled.velocities), Dual(0)),
        moved(q.size()),
        multipliers(static_cast<std::size_t>(compiled.equations), Dual(0)),
        mu(multipliers.size()),
        r(static_cast<std::size_t>(compiled.velocities)),
        penalty(multipliers.size(), 0.0),
        inputs(compiled.spec().inputs.size()),
        place_of_element(compiled.elements.size(), -1) {
    for (const SignalsData::Block& b : m.signals.blocks) {
      if (b.every > 0) continue;
      // All have begun; what limits rates passes on its input where it does not limit.
      const std::string_view name = block_name(b);
      const auto at = static_cast<std::size_t>(b.held);
      held[at] = name == "rate_limit" && held[at + 1].value == held[at + 2].value ? Dual(0) : Dual(1);
      if (name == "delay") held[at] = Dual(0);
    }
    if (m.signals.clock >= 0) held[static_cast<std::size_t>(m.signals.clock)] = Dual(s.time);
    work.signals.enter(held.data(), states.data(), 0);
    work.signals.moves = false;
    work.signals.numbers = numbers.data();
    relative::set_origin<Dual>(m, work, q.data());
    find_elements();
    list_parameters();
  }

  // --- what the states' rates depend on -------------------------------------------------------------------

  void find_elements() {
    // What all elements see, with their laws.
    evaluate();
    std::vector<double> slots;
    for (const Dual& x : work.signals.value) slots.push_back(x.value);
    for (std::size_t k = 0; k < m.elements.size(); ++k) {
      const ElementData& e = m.elements[k];
      if (!needs_linear_element(e)) continue;
      const ElementEnds ends = ends_of(m, e, s_of(e));
      if (ends.frame_b < 0 && e.pooled) continue;
      SeenByElement seen;
      seen.count = e.count;
      seen.surroundings = surroundings_size(e.measure);
      seen.arguments = e.argument_count;
      VectorXd values(places(e));
      see(e, [&](int row, const Dual& x) { values[row] = x.value; });
      seen.values = values;
      linear.push_back(
          linear_element(m, static_cast<int>(k), state.time, seen, slots, state.z.data() + e.states, pace));
    }
    for (std::size_t k = 0; k < linear.size(); ++k)
      place_of_element[static_cast<std::size_t>(linear[k].element)] = static_cast<int>(k);
    for (const LinearElement& e : linear) {
      first_seen.push_back(seen_rows);
      seen_rows += places(m.elements[static_cast<std::size_t>(e.element)]);
      element_rates.push_back(VectorXd::Zero(std::ssize(e.states)));
    }
    for (std::size_t k = 0; k < m.signals.blocks.size(); ++k) {
      first_input.push_back(seen_rows);
      if (has_rates(m.signals.blocks[k])) seen_rows += m.signals.blocks[k].inputs;
    }
    first_integral = seen_rows;
    seen_rows += static_cast<int>(m.signals.integrals.size());
  }

  const Dual* s_of(const ElementData& e) const { return states.data() + e.states; }

  template <class F>
  void see(const ElementData& e, const F& f) {
    const ElementState<Dual> s = element_state(e, work.elements.data());
    int row = 0;
    for (int k = 0; k < e.count; ++k) f(row++, s.x[k]);
    for (int k = 0; k < e.count; ++k) f(row++, s.v[k]);
    for (int k = 0; k < surroundings_size(e.measure); ++k) f(row++, s.surroundings[k]);
    for (int k = 0; k < e.argument_count; ++k)
      f(row++,
        work.signals.value[static_cast<std::size_t>(m.arguments[static_cast<std::size_t>(e.arguments + k)])]);
  }

  /// After an evaluation.
  void see_all(Eigen::Ref<VectorXd> out) {
    for (std::size_t k = 0; k < linear.size(); ++k)
      see(m.elements[static_cast<std::size_t>(linear[k].element)],
          [&](int row, const Dual& x) { out[first_seen[k] + row] = x.derivative; });
    for (std::size_t k = 0; k < m.signals.blocks.size(); ++k) {
      const SignalsData::Block& b = m.signals.blocks[k];
      if (!has_rates(b)) continue;
      const BlockInputs<Dual> in = block_inputs(b, work.signals);
      for (int i = 0; i < b.inputs; ++i) out[first_input[k] + i] = in[static_cast<std::size_t>(i)].derivative;
    }
    for (std::size_t k = 0; k < m.signals.integrals.size(); ++k)
      out[first_integral + static_cast<int>(k)] =
          work.signals.value[static_cast<std::size_t>(m.signals.integrals[k].rate)].derivative;
  }

  void list_parameters() {
    using Kind = Parameter::Kind;
    for (std::size_t k = 0; k < linear.size(); ++k)
      for (std::size_t i = 0; i < linear[k].states.size(); ++i)
        parameters.push_back({Kind::element_state, static_cast<int>(k), static_cast<int>(i)});
    for (std::size_t k = 0; k < m.signals.blocks.size(); ++k)
      if (has_rates(m.signals.blocks[k]))
        for (int i = 0; i < m.signals.blocks[k].states; ++i)
          parameters.push_back({Kind::block_state, static_cast<int>(k), i});
    for (std::size_t k = 0; k < m.signals.integrals.size(); ++k)
      parameters.push_back({Kind::integral, static_cast<int>(k), 0});
    state_count = static_cast<int>(parameters.size());
    for (const Kind kind : {Kind::input, Kind::input_rate, Kind::input_second})
      for (std::size_t k = 0; k < m.spec().inputs.size(); ++k)
        parameters.push_back({kind, static_cast<int>(k), 0});
  }

  /// The number of a parameter that can be varied; element states are apart.
  void vary(const Parameter& p, double by) {
    using Kind = Parameter::Kind;
    switch (p.kind) {
      case Kind::element_state:
        element_rates[static_cast<std::size_t>(p.item)][p.index] = by;
        return;
      case Kind::block_state: {
        const SignalsData::Block& b = m.signals.blocks[static_cast<std::size_t>(p.item)];
        held[static_cast<std::size_t>(b.held + 1 + b.inputs + p.index)].derivative = by;
        return;
      }
      case Kind::integral:
        held[static_cast<std::size_t>(m.signals.integrals[static_cast<std::size_t>(p.item)].held)]
            .derivative = by;
        return;
      case Kind::input:
        inputs[static_cast<std::size_t>(p.item)].value = by;
        return;
      case Kind::input_rate:
        inputs[static_cast<std::size_t>(p.item)].rate = by;
        return;
      case Kind::input_second:
        inputs[static_cast<std::size_t>(p.item)].second = by;
        return;
    }
  }

  // --- an evaluation --------------------------------------------------------------------------------------

  void law(const ElementData& e) {
    const int place = place_of_element[static_cast<std::size_t>(&e - m.elements.begin())];
    if (place < 0) return evaluate_law(m, e, work.signals, work.elements.data());
    const LinearElement& l = linear[static_cast<std::size_t>(place)];
    const ElementState<Dual> s = element_state(e, work.elements.data());
    VectorXd seen(places(e));
    see(e, [&](int row, const Dual& x) { seen[row] = x.derivative; });
    const VectorXd varies =
        l.force_by_seen * seen + l.force_by_states * element_rates[static_cast<std::size_t>(place)];
    for (int k = 0; k < e.count; ++k) s.force[k] = Dual(l.force[k], varies[k]);
    if (e.inertia >= 0) s.force[0] += numbers[static_cast<std::size_t>(e.inertia)] * *s.acceleration;
    for (const Leg& leg : e.legs)
      element_state(m.elements[static_cast<std::size_t>(leg.element)], work.elements.data()).force[0] =
          leg.factor * s.force[0];
  }

  /// At the positions `at`; with derivatives as they are set.
  void evaluate_at(const Dual* at) {
    fix_signals_by(m.signals, state.time, work.signals, [&](const SignalsData::HeldInput& h) {
      JetOf<Dual> jet = held_input(h, work.signals.held, state.time);
      if (h.input >= 0) {
        const InputRates& by = inputs[static_cast<std::size_t>(h.input)];
        jet.value.derivative += by.value;
        jet.first.derivative += by.rate;
        jet.second.derivative += by.second;
      }
      return jet;
    });
    relative::evaluate_motion<Dual>(m, work, state.time, at, v.data(), a.data());
    relative::look<Dual>(m, work, state.time, at, v.data(), a.data());
    relative::act<Dual>(m, work, r.data(), [&](const ElementData& e) { law(e); });
    for (std::size_t k = 0; k < mu.size(); ++k) mu[k] = multipliers[k];
    relative::apply_multipliers<Dual>(m, work, mu.data(), r.data());
    relative::residual<Dual>(m, work, at, v.data(), a.data(), r.data());
  }
  void evaluate() { evaluate_at(q.data()); }

  template <class Out>
  void derivatives_of(const std::vector<Dual>& of, Out&& out) const {
    for (std::size_t k = 0; k < of.size(); ++k) out[static_cast<Eigen::Index>(k)] = of[k].derivative;
  }
  VectorXd values_of(const std::vector<Dual>& of) const {
    VectorXd out(std::ssize(of));
    for (std::size_t k = 0; k < of.size(); ++k) out[static_cast<Eigen::Index>(k)] = of[k].value;
    return out;
  }

  struct InputRates {
    double value = 0, rate = 0, second = 0;
  };

  const Compiled& m;
  const State& state;
  double pace;
  relative::Workspace<Dual> work;
  std::vector<Dual> numbers, held, states, q, v, a, moved, multipliers, mu, r;
  std::vector<double> penalty;
  std::vector<InputRates> inputs;
  std::vector<int> place_of_element;
  std::vector<LinearElement> linear;
  std::vector<VectorXd> element_rates;  ///< derivatives of the elements' states
  std::vector<int> first_seen, first_input;
  int first_integral = 0, seen_rows = 0, state_count = 0;
  std::vector<Parameter> parameters;
};

LinearCore::LinearCore(const Compiled& model, const State& state, double pace)
    : impl_(std::make_unique<Impl>(model, state, pace)) {}
LinearCore::~LinearCore() = default;

const std::vector<LinearElement>& LinearCore::elements() const { return impl_->linear; }
const std::vector<Parameter>& LinearCore::parameters() const { return impl_->parameters; }

MatrixXd LinearCore::turning(const Compiled& m, const VectorXd& v) {
  MatrixXd W = MatrixXd::Zero(m.velocities, m.velocities);
  for (const BodyData& b : m.bodies) {
    const JointInfo& info = joint_info(b.joint);
    if (info.quaternion < 0) continue;
    const int at = b.v + info.rotation;
    // δv = δ̇ + v × δ.
    W.block<3, 3>(at, at) = skew<double>(Vec3d(v[at], v[at + 1], v[at + 2]));
  }
  return W;
}

LinearCore::Rates LinearCore::rates() const {
  Impl& i = *impl_;
  const auto p = static_cast<Eigen::Index>(i.parameters.size());
  Rates out{VectorXd::Zero(i.state_count), MatrixXd::Zero(i.state_count, i.seen_rows),
            MatrixXd::Zero(i.state_count, p)};
  int row = 0;
  for (std::size_t k = 0; k < i.linear.size(); ++k) {
    const LinearElement& e = i.linear[k];
    const auto n = static_cast<Eigen::Index>(e.states.size());
    out.value.segment(row, n) = e.rate;
    out.by_seen.block(row, i.first_seen[k], n, e.rate_by_seen.cols()) = e.rate_by_seen;
    out.by_parameters.block(row, row, n, n) = e.rate_by_states;
    row += static_cast<int>(n);
  }
  i.evaluate();
  for (std::size_t k = 0; k < i.m.signals.blocks.size(); ++k) {
    const SignalsData::Block& b = i.m.signals.blocks[k];
    if (!has_rates(b)) continue;
    const BlockInputs<Dual> in = block_inputs(b, i.work.signals);
    VectorXd at(b.states + b.inputs);
    for (int j = 0; j < b.states; ++j)
      at[j] = i.held[static_cast<std::size_t>(b.held + 1 + b.inputs + j)].value;
    for (int j = 0; j < b.inputs; ++j) at[b.states + j] = in[static_cast<std::size_t>(j)].value;
    const BlockRates rates = block_rates(i.m.signals, b, at, i.pace);
    out.value.segment(row, b.states) = rates.value;
    out.by_parameters.block(row, row, b.states, b.states) = rates.by.leftCols(b.states);
    out.by_seen.block(row, i.first_input[k], b.states, b.inputs) = rates.by.rightCols(b.inputs);
    row += b.states;
  }
  for (std::size_t k = 0; k < i.m.signals.integrals.size(); ++k, ++row) {
    out.value[row] = i.work.signals.value[static_cast<std::size_t>(i.m.signals.integrals[k].rate)].value;
    out.by_seen(row, i.first_integral + static_cast<int>(k)) = 1;
  }
  return out;
}

VectorXd LinearCore::curvature(const VectorXd& along) {
  Impl& i = *impl_;
  const std::vector<Dual> kept = i.v;
  std::vector<Dual> x;
  for (std::size_t k = 0; k < i.v.size(); ++k) {
    i.v[k] = Dual(along[static_cast<Eigen::Index>(k)]);
    x.emplace_back(0, along[static_cast<Eigen::Index>(k)]);
  }
  relative::retract<Dual>(i.m, i.q.data(), x.data(), i.moved.data());
  i.evaluate_at(i.moved.data());
  i.v = kept;
  VectorXd out(i.m.equations);
  i.derivatives_of(i.work.phi_dot, out);
  return out;
}

void LinearCore::find_mass(Derivatives& out) {
  Impl& i = *impl_;
  const int n = i.m.velocities, m = i.m.equations;
  for (Dual& x : i.a) x = Dual(0);
  for (Dual& x : i.multipliers) x = Dual(0);
  out.mass.resize(n, n);
  out.jacobian.resize(m, n);
  for (int k = 0; k < n; ++k) {
    i.a[static_cast<std::size_t>(k)].derivative = 1;
    i.evaluate();
    i.derivatives_of(i.r, out.mass.col(k));
    i.derivatives_of(i.work.phi_ddot, out.jacobian.col(k));
    i.a[static_cast<std::size_t>(k)].derivative = 0;
  }
  i.evaluate();
  out.residual = i.values_of(i.r);
  out.phi_rate = i.values_of(i.work.phi_dot);
  out.phi_second = i.values_of(i.work.phi_ddot);
}

void LinearCore::find_derivatives(const VectorXd& a, const VectorXd& multipliers, Derivatives& out) {
  Impl& i = *impl_;
  const int n = i.m.velocities, m = i.m.equations, s = i.seen_rows;
  const auto p = static_cast<int>(i.parameters.size());
  for (int k = 0; k < n; ++k) i.a[static_cast<std::size_t>(k)] = Dual(a[k]);
  for (int k = 0; k < m; ++k) i.multipliers[static_cast<std::size_t>(k)] = Dual(multipliers[k]);
  for (MatrixXd* x : {&out.residual_q, &out.residual_v}) x->resize(n, n);
  out.residual_p.resize(n, p);
  for (MatrixXd* x : {&out.rate_q, &out.second_q, &out.second_v}) x->resize(m, n);
  for (MatrixXd* x : {&out.phi_p, &out.rate_p, &out.second_p}) x->resize(m, p);
  for (MatrixXd* x : {&out.seen_q, &out.seen_v}) x->resize(s, n);
  out.seen_p.resize(s, p);
  std::vector<Dual> x(static_cast<std::size_t>(n), Dual(0));
  for (int k = 0; k < n; ++k) {
    Dual& of_q = x[static_cast<std::size_t>(k)];
    of_q.derivative = 1;
    relative::retract<Dual>(i.m, i.q.data(), x.data(), i.moved.data());
    of_q.derivative = 0;
    i.evaluate_at(i.moved.data());
    i.derivatives_of(i.r, out.residual_q.col(k));
    i.derivatives_of(i.work.phi_dot, out.rate_q.col(k));
    i.derivatives_of(i.work.phi_ddot, out.second_q.col(k));
    i.see_all(out.seen_q.col(k));
  }
  for (int k = 0; k < n; ++k) {
    Dual& of_v = i.v[static_cast<std::size_t>(k)];
    of_v.derivative = 1;
    i.evaluate();
    of_v.derivative = 0;
    i.derivatives_of(i.r, out.residual_v.col(k));
    i.derivatives_of(i.work.phi_ddot, out.second_v.col(k));
    i.see_all(out.seen_v.col(k));
  }
  for (int k = 0; k < p; ++k) {
    i.vary(i.parameters[static_cast<std::size_t>(k)], 1);
    i.evaluate();
    i.vary(i.parameters[static_cast<std::size_t>(k)], 0);
    i.derivatives_of(i.r, out.residual_p.col(k));
    i.derivatives_of(i.work.phi, out.phi_p.col(k));
    i.derivatives_of(i.work.phi_dot, out.rate_p.col(k));
    i.derivatives_of(i.work.phi_ddot, out.second_p.col(k));
    i.see_all(out.seen_p.col(k));
  }
  out.turn = turning(i.m, i.state.v);
}

void LinearCore::find_stiffness(const VectorXd& multipliers, Derivatives& out) {
  Impl& i = *impl_;
  const int n = i.m.velocities;
  for (Dual& a : i.a) a = Dual(0);
  for (int k = 0; k < i.m.equations; ++k) i.multipliers[static_cast<std::size_t>(k)] = Dual(multipliers[k]);
  out.residual_q.resize(n, n);
  std::vector<Dual> x(static_cast<std::size_t>(n), Dual(0));
  for (int k = 0; k < n; ++k) {
    x[static_cast<std::size_t>(k)].derivative = 1;
    relative::retract<Dual>(i.m, i.q.data(), x.data(), i.moved.data());
    x[static_cast<std::size_t>(k)].derivative = 0;
    i.evaluate_at(i.moved.data());
    i.derivatives_of(i.r, out.residual_q.col(k));
  }
}

}  // namespace mimbre::linear
