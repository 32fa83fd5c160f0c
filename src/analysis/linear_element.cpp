#include "analysis/linear_element.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "forces/table.h"
#include "forces/user.h"
#include "math/dual.h"

namespace mimbre::linear {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int levels = 5;             ///< of the extrapolation
constexpr double good = 1e-12;        ///< of what is extrapolated: no better step is sought
constexpr double acceptable = 1e-7;   ///< beyond, it has not converged
constexpr double difference = 1e-4;   ///< of what a law by the user is given,
constexpr double least_given = 1e-2;  ///< which counts as at least this

/// The law of one element over one step, from what it sees at its start.
class StepOfElement {
 public:
  StepOfElement(const Compiled& m, int element, double time, const SeenByElement& seen,
                const std::vector<double>& slots, const double* states)
      : m_(m),
        e_(m.elements[static_cast<std::size_t>(element)]),
        time_(time),
        seen_(seen),
        slots_(slots),
        z_(states, states + e_.state_count),
        first_(e_.own_states),
        last_(law_states(e_)) {}

  int inputs() const { return static_cast<int>(seen_.values.size()); }
  int states() const { return last_ - first_; }
  int first() const { return first_; }
  int count() const { return e_.count; }
  const double* before() const { return z_.data() + first_; }
  bool differences() const { return e_.user; }

  /// Force, then states after a step h, and how they vary along one of the inputs or, behind them, of the
  /// states; `tied`: states that begin the step with what the law makes of the start itself. -1: along none.
  struct Result {
    VectorXd values, derivatives;
  };
  Result step(double h, int along, const std::vector<char>& tied) const {
    if (!e_.user) return over_duals(h, along, tied);
    Result r;
    r.values = over_numbers(h, along, 0, tied);
    if (along < 0) return r;
    // The user's law does not see what surrounds it, which need not be numbers.
    r.derivatives = VectorXd::Zero(r.values.size());
    if (along >= 2 * count() && along < 2 * count() + seen_.surroundings) return r;
    const double base =
        along < inputs() ? seen_.values[along] : z_[static_cast<std::size_t>(first_ + along - inputs())];
    const double width = difference * std::max(std::abs(base), least_given);
    const auto slope = [&](double by) {
      return VectorXd((over_numbers(h, along, by, tied) - over_numbers(h, along, -by, tied)) / (2 * by));
    };
    const VectorXd wide = slope(width), narrow = slope(width / 2);
    r.derivatives = narrow + (narrow - wide) / 3;
    return r;
  }

 private:
  template <class T>
  struct Inputs {
    std::vector<T> seen, states, slots;
  };

  /// The element's law, at what it sees `ahead` later. Returns force and states.
  template <class T>
  std::vector<T> law(const Inputs<T>& in, const std::vector<T>& states, double h, double ahead) const {
    const int n = e_.count;
    std::vector<T> storage(static_cast<std::size_t>(element_storage(e_)), T(0)),
        numbers(m_.numbers.begin(), m_.numbers.end());
    ElementState<T> s = element_state_at(e_, storage.data());
    for (int k = 0; k < n; ++k) {
      const T &x = in.seen[static_cast<std::size_t>(k)], &v = in.seen[static_cast<std::size_t>(n + k)];
      s.v[k] = v;
      if (is_velocity(e_.measure, k))
        s.x[k] = v;
      else if (e_.measure == Measure::contact && k > 0)
        s.x[k] = T(ahead) * v;  // the way since the start of the step
      else
        s.x[k] = x + T(ahead) * v;
    }
    for (int k = 0; k < seen_.surroundings; ++k)
      s.surroundings[k] = in.seen[static_cast<std::size_t>(2 * n + k)];
    std::copy(states.begin(), states.end(), s.states);
    const LawContext<T> context{m_, e_, time_, in.slots.data(), states.data(), h, numbers.data()};
    if constexpr (std::is_same_v<T, double>) {
      if (e_.sampled)
        ask(context, s);
      else
        forces::rows<T>[static_cast<std::size_t>(e_.law)].law(context, s);
    } else {
      forces::rows<T>[static_cast<std::size_t>(e_.law)].law(context, s);
    }
    std::vector<T> out(s.force, s.force + n);
    out.insert(out.end(), s.states + first_, s.states + last_);
    return out;
  }

  /// A law that steps call at their start, as if they were infinitely short: what it says now, not what it
  /// said before. The force that is kept comes first of its states.
  void ask(const LawContext<double>& context, ElementState<double>& s) const {
    double* own = s.states + first_;
    const forces::user::Answer answer =
        forces::user::call(context, s.x, s.v, context.states + first_ + s.count, own + s.count);
    std::copy_n(answer.force, s.count, s.force);
    std::copy_n(answer.force, s.count, own);
  }

  template <class T>
  std::vector<T> run(Inputs<T> in, double h, const std::vector<char>& tied) const {
    if (std::find(tied.begin(), tied.end(), 1) != tied.end()) {
      const std::vector<T> start = law(in, in.states, h, 0);
      for (std::size_t k = 0; k < tied.size(); ++k)
        if (tied[k])
          in.states[static_cast<std::size_t>(first_) + k] = start[static_cast<std::size_t>(e_.count) + k];
    }
    std::vector<T> out = law(in, in.states, h, h);
    // As change over the step.
    for (std::size_t k = 0; k < static_cast<std::size_t>(states()); ++k)
      out[static_cast<std::size_t>(e_.count) + k] -= in.states[static_cast<std::size_t>(first_) + k];
    return out;
  }

  /// `along` put in the direction `by`.
  template <class T, class Add>
  Inputs<T> inputs_with(int along, const Add& add) const {
    Inputs<T> in{
        {seen_.values.begin(), seen_.values.end()}, {z_.begin(), z_.end()}, {slots_.begin(), slots_.end()}};
    if (along >= inputs()) add(in.states[static_cast<std::size_t>(first_ + along - inputs())]);
    if (along >= 0 && along < inputs()) add(in.seen[static_cast<std::size_t>(along)]);
    for (int k = 0; k < seen_.arguments; ++k)
      in.slots[static_cast<std::size_t>(m_.arguments[static_cast<std::size_t>(e_.arguments + k)])] =
          in.seen[static_cast<std::size_t>(2 * e_.count + seen_.surroundings + k)];
    return in;
  }

  Result over_duals(double h, int along, const std::vector<char>& tied) const {
    const std::vector<Dual> out = run(inputs_with<Dual>(along, [](Dual& x) { x.derivative = 1; }), h, tied);
    Result r{VectorXd(std::ssize(out)), VectorXd(std::ssize(out))};
    for (Eigen::Index k = 0; k < std::ssize(out); ++k) {
      r.values[k] = out[static_cast<std::size_t>(k)].value;
      r.derivatives[k] = out[static_cast<std::size_t>(k)].derivative;
    }
    return r;
  }
  VectorXd over_numbers(double h, int along, double width, const std::vector<char>& tied) const {
    const std::vector<double> out =
        run(inputs_with<double>(along, [width](double& x) { x += width; }), h, tied);
    return Eigen::Map<const VectorXd>(out.data(), std::ssize(out));
  }

  const Compiled& m_;
  const ElementData& e_;
  double time_;
  const SeenByElement& seen_;
  const std::vector<double>& slots_;
  std::vector<double> z_;
  int first_, last_;
};

/// Force and rates (rows) at the point (column 0) and by inputs and states (the others) for one step h.
MatrixXd rates_over(const StepOfElement& step, double h, const std::vector<char>& tied) {
  const int n = step.count(), states = step.states(), columns = step.inputs() + states;
  MatrixXd all(n + states, 1 + columns);
  for (int c = 0; c < columns; ++c) {
    const StepOfElement::Result r = step.step(h, c, tied);
    all.col(1 + c) = r.derivatives;
    if (c == 0) all.col(0) = r.values;
  }
  if (columns == 0) all.col(0) = step.step(h, -1, tied).values;
  all.bottomRows(states) /= h;
  return all;
}

/// The rows as h → 0, and by how much the last two extrapolations differ, of the largest entry of each row.
MatrixXd extrapolated(const StepOfElement& step, double h, const std::vector<char>& tied,
                      const std::vector<int>& rows, double& error) {
  std::vector<MatrixXd> row;
  MatrixXd before;
  for (int l = 0; l < levels; ++l) {
    std::vector<MatrixXd> next{rates_over(step, std::ldexp(h, -l), tied)(rows, Eigen::all)};
    for (int order = 1; order <= l; ++order) {
      const auto j = static_cast<std::size_t>(order);
      next.push_back(next[j - 1] + (next[j - 1] - row[j - 1]) / ((1 << order) - 1));
    }
    before = row.empty() ? next.back() : row.back();
    row = std::move(next);
  }
  const MatrixXd& best = row.back();
  error = 0;
  for (Eigen::Index r = 0; r < best.rows(); ++r) {
    const double size = best.row(r).cwiseAbs().maxCoeff(),
                 off = (best.row(r) - before.row(r)).cwiseAbs().maxCoeff(), share = size > 0 ? off / size : 0;
    error = std::isfinite(share) ? std::max(error, share) : std::numeric_limits<double>::infinity();
  }
  return best;
}

/// What the states of an element are to its force.
struct StatesOfElement {
  std::vector<char> tied;  ///< its new value depends on no old one
  std::vector<int> count;  ///< those that the force, or one of these, depends on, and that are not tied
};
StatesOfElement sort_states(const StepOfElement& step, double pace) {
  const int n = step.count(), count = step.states(), first = 1 + step.inputs();
  StatesOfElement out;
  out.tied.assign(static_cast<std::size_t>(count), 0);
  if (count == 0) return out;
  constexpr double instant = 1e-9, nothing = 1e-9;
  const double h = instant / pace;
  MatrixXd once = rates_over(step, h, out.tied);
  once.bottomRows(count) *= h;
  for (int k = 0; k < count; ++k) once(n + k, first + k) += 1;  // values instead of changes
  const auto depends = [&](int row, int state) {
    const double by = std::abs(once(row, first + state));
    return row < n ? by > 0 : by > nothing;
  };
  for (int k = 0; k < count; ++k) {
    bool none = true;
    for (int j = 0; j < count; ++j) none = none && !depends(n + k, j);
    out.tied[static_cast<std::size_t>(k)] = none;
  }
  std::vector<char> counts(static_cast<std::size_t>(count), 0);
  for (bool more = true; more;) {
    more = false;
    for (int j = 0; j < count; ++j) {
      if (counts[static_cast<std::size_t>(j)]) continue;
      bool acts = false;
      for (int r = 0; r < n + count; ++r)
        if (r < n || (r != n + j && counts[static_cast<std::size_t>(r - n)])) acts = acts || depends(r, j);
      if (acts) counts[static_cast<std::size_t>(j)] = more = true;
    }
  }
  for (int j = 0; j < count; ++j)
    if (counts[static_cast<std::size_t>(j)] && !out.tied[static_cast<std::size_t>(j)]) out.count.push_back(j);
  return out;
}

}  // namespace

bool needs_linear_element(const ElementData& e) { return !e.leg && (e.user || law_states(e) > e.own_states); }

LinearElement linear_element(const Compiled& m, int element, double time, const SeenByElement& seen,
                             const std::vector<double>& slots, const double* states, double pace) {
  const StepOfElement step(m, element, time, seen, slots, states);
  const int n = step.count(), inputs = step.inputs();
  const StatesOfElement sorted = sort_states(step, pace);
  const auto count = static_cast<int>(sorted.count.size());
  std::vector<int> rows;
  for (int k = 0; k < n; ++k) rows.push_back(k);
  for (const int state : sorted.count) rows.push_back(n + state);
  // The step that extrapolates best.
  MatrixXd best;
  double least = std::numeric_limits<double>::infinity();
  for (const double factor : {1e-2, 1e-3, 1e-1, 1e-4, 1., 1e-5, 1e-6, 10., 1e-7, 1e-8}) {
    double error = 0;
    const MatrixXd rates = extrapolated(step, factor / pace, sorted.tied, rows, error);
    if (best.size() > 0 && !(error < least)) continue;
    least = error;
    best = rates;
    if (count == 0 || least <= good) break;
  }
  LinearElement out;
  out.element = element;
  out.by_differences = step.differences();
  out.settled = least <= acceptable;
  std::vector<int> columns;
  for (const int state : sorted.count) {
    out.states.push_back(step.first() + state);
    columns.push_back(1 + inputs + state);
  }
  out.force = best.col(0).head(n);
  out.force_by_seen = best.block(0, 1, n, inputs);
  out.force_by_states = best(Eigen::seqN(0, n), columns);
  out.rate = best.col(0).tail(count);
  out.rate_by_seen = best.block(n, 1, count, inputs);
  out.rate_by_states = best(Eigen::seqN(n, count), columns);
  return out;
}

}  // namespace mimbre::linear
