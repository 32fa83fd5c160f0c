#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "portable/program.h"

/// Operations as statements of C99, in functions that compilers get through in bounded time.
namespace mimbre::portable {
namespace {

using Op = Recording::Op;

/// Statements of a function at most, about.
constexpr int most_statements = 400;

bool is_leaf(const Recording::Node& n) { return n.op == Op::constant || n.op == Op::input; }

const char* function_of(Op op) {
  switch (op) {
    case Op::sqrt:
      return "sqrt";
    case Op::sin:
      return "sin";
    case Op::cos:
      return "cos";
    case Op::tan:
      return "tan";
    case Op::asin:
      return "asin";
    case Op::acos:
      return "acos";
    case Op::atan:
      return "atan";
    case Op::sinh:
      return "sinh";
    case Op::cosh:
      return "cosh";
    case Op::tanh:
      return "tanh";
    case Op::asinh:
      return "asinh";
    case Op::acosh:
      return "acosh";
    case Op::atanh:
      return "atanh";
    case Op::exp:
      return "exp";
    case Op::expm1:
      return "expm1";
    case Op::log:
      return "log";
    case Op::log2:
      return "log2";
    case Op::log10:
      return "log10";
    case Op::abs:
      return "fabs";
    case Op::round:
      return "round";
    case Op::rint:
      return "rint";
    case Op::atan2:
      return "atan2";
    case Op::pow:
      return "pow";
    case Op::hypot:
      return "hypot";
    default:
      return nullptr;
  }
}

/// Calls f with each node that a node needs.
template <class F>
void for_arguments(const Recording::Node& n, const F& f) {
  if (is_leaf(n)) return;
  f(n.a);
  if (n.op == Op::part) return;
  if (n.b >= 0) f(n.b);
  if (n.op == Op::select && n.c >= 0) f(n.c);
  if (n.d >= 0) f(n.d);
}

/// The operation of a node in C, `of(k)` the text of a node that it needs.
template <class Of>
std::string expression(const Recording::Node& n, const Of& of) {
  switch (n.op) {
    case Op::add:
      return fmt::format("{} + {}", of(n.a), of(n.b));
    case Op::subtract:
      return fmt::format("{} - {}", of(n.a), of(n.b));
    case Op::multiply:
      return fmt::format("{}*{}", of(n.a), of(n.b));
    case Op::divide:
      return fmt::format("{}/{}", of(n.a), of(n.b));
    case Op::negative:
      return fmt::format("-{}", of(n.a));
    case Op::less:
      return fmt::format("{} < {}", of(n.a), of(n.b));
    case Op::less_or_equal:
      return fmt::format("{} <= {}", of(n.a), of(n.b));
    case Op::equal:
      return fmt::format("{} == {}", of(n.a), of(n.b));
    case Op::both:
      return fmt::format("{} && {}", of(n.a), of(n.b));
    case Op::either:
      return fmt::format("{} || {}", of(n.a), of(n.b));
    case Op::opposite:
      return fmt::format("!{}", of(n.a));
    case Op::finite:
      return fmt::format("{0} - {0} == 0.0", of(n.a));
    case Op::select:
      return fmt::format("{} ? {} : {}", of(n.a), of(n.b), of(n.c));
    case Op::part:
      return fmt::format("c{}[{}]", n.a, n.b);
    default:
      return n.b < 0 ? fmt::format("{}({})", function_of(n.op), of(n.a))
                     : fmt::format("{}({}, {})", function_of(n.op), of(n.a), of(n.b));
  }
}

/// A call, whose results are c0, c1, … by the number of its node.
template <class Of>
std::string call(const Recording::Node& n, int k, const std::string& name, const Of& of) {
  std::string others;
  for (const int other : {n.b, n.d})
    if (other >= 0) others += ", " + of(other);
  return fmt::format("  double c{0}[4];\n  {1}_call_{2}({3}{4}, c{0});\n", k, name, n.c, of(n.a), others);
}

const char* type_of(Op op) { return Recording::is_condition(op) ? "int" : "double"; }

class Writer {
 public:
  Writer(const Program& program, const std::string& name) : program_(program), name_(name) {
    const std::size_t phases = program.phases.size();
    live_.resize(phases);
    kept_of_.resize(phases);
    for (std::size_t p = 0; p < phases; ++p) find_live(p);
  }

  PhaseCode write() {
    for (std::size_t p = 0; p < program_.phases.size(); ++p) write_phase(p);
    out_.kept = static_cast<int>(slot_.size());
    return std::move(out_);
  }

 private:
  const std::vector<Recording::Node>& nodes() const { return program_.recording.nodes(); }
  const Recording::Node& node(int k) const { return nodes()[static_cast<std::size_t>(k)]; }

  /// What a phase has to compute; what is there already is kept by the phase that did.
  void find_live(std::size_t p) {
    const Phase& phase = program_.phases[p];
    std::vector<int> waiting;
    std::set<int>& live = live_[p];
    const auto want = [&](int k) {
      if (is_leaf(node(k)) || live.contains(k)) return;
      if (node(k).op != Op::call)
        for (auto before = phase.after.rbegin(); before != phase.after.rend(); ++before)
          if (live_[static_cast<std::size_t>(*before)].contains(k)) {
            kept_of_[static_cast<std::size_t>(*before)].insert(k);
            slot_.try_emplace(k, static_cast<int>(slot_.size()));
            return;
          }
      live.insert(k);
      waiting.push_back(k);
    };
    for (const Store& s : phase.stores)
      if (s.value.node >= 0) want(s.value.node);
    while (!waiting.empty()) {
      const int k = waiting.back();
      waiting.pop_back();
      for_arguments(node(k), want);
    }
  }

  std::string kept(int k) const {
    const std::string place = fmt::format("s->kept[{}]", slot_.at(k));
    return Recording::is_condition(node(k).op) ? fmt::format("({} != 0.0)", place) : place;
  }

  /// A node as an argument in a function that has made `local`.
  std::string text(int k, const std::set<int>& local) const {
    const Recording::Node& n = node(k);
    if (n.op == Op::constant) return literal(n.number);
    if (n.op == Op::input) return fmt::format("s->{}[{}]", name_of(static_cast<Memory>(n.b)), n.a);
    if (local.contains(k)) return fmt::format("t{}", k);
    return kept(k);
  }

  void write_phase(std::size_t p) {
    const Phase& phase = program_.phases[p];
    // Parts come next to their calls.
    std::vector<int> all(live_[p].begin(), live_[p].end());
    const auto place = [&](int k) { return node(k).op == Op::part ? node(k).a : k; };
    std::stable_sort(all.begin(), all.end(), [&](int a, int b) { return place(a) < place(b); });
    // Functions, each from a node on.
    std::vector<std::size_t> begins{0};
    for (std::size_t k = 0; k < all.size(); ++k)
      if (k - begins.back() >= most_statements && node(all[k]).op != Op::part) begins.push_back(k);
    begins.push_back(all.size());
    std::map<int, std::size_t> function_of_node;
    for (std::size_t f = 0; f + 1 < begins.size(); ++f)
      for (std::size_t k = begins[f]; k < begins[f + 1]; ++k) function_of_node[all[k]] = f;
    // What a later function needs is kept.
    std::set<int>& keep = kept_of_[p];
    for (const int k : all)
      for_arguments(node(k), [&](int of) {
        const auto at = function_of_node.find(of);
        if (at == function_of_node.end() || at->second == function_of_node[k]) return;
        keep.insert(of);
        slot_.try_emplace(of, static_cast<int>(slot_.size()));
      });
    std::multimap<int, const Store*> stores;
    std::vector<const Store*> others;
    for (const Store& s : phase.stores)
      if (s.value.node >= 0 && live_[p].contains(s.value.node))
        stores.emplace(s.value.node, &s);
      else
        others.push_back(&s);
    std::string calls;
    long operations = 0;
    for (std::size_t f = 0; f + 1 < begins.size(); ++f) {
      const bool last = f + 2 == begins.size();
      const bool only = begins.size() == 2;
      std::string body;
      std::set<int> local;
      for (std::size_t i = begins[f]; i < begins[f + 1]; ++i) {
        const int k = all[i];
        const Recording::Node& n = node(k);
        const auto of = [&](int argument) { return text(argument, local); };
        if (n.op == Op::call) {
          body += call(n, k, name_, of);
          operations += 20;
          continue;
        }
        ++operations;
        body += fmt::format("  const {} t{} = {};\n", type_of(n.op), k, expression(n, of));
        local.insert(k);
        if (keep.contains(k)) body += fmt::format("  s->kept[{}] = t{};\n", slot_.at(k), k);
        const auto [from, to] = stores.equal_range(k);
        for (auto at = from; at != to; ++at) body += assignment(*at->second, fmt::format("t{}", k));
      }
      if (last)
        for (const Store* s : others)
          body +=
              assignment(*s, s->value.is_constant() ? literal(s->value.number) : text(s->value.node, local));
      const std::string own = only ? phase.name : fmt::format("{}_{}", phase.name, f);
      if (body.empty() && phase.name.starts_with("sense_")) continue;  // nobody calls it
      if (body.empty()) body = "  (void)s;\n";
      out_.text += fmt::format("static void {}_{}({} *s) {{\n{}}}\n\n", name_, own, name_, body);
      calls += fmt::format("  {}_{}(s);\n", name_, own);
    }
    if (begins.size() > 2)
      out_.text += fmt::format("static void {}_{}({} *s) {{\n{}}}\n\n", name_, phase.name, name_, calls);
    out_.operations.push_back(operations);
  }

  static std::string assignment(const Store& s, const std::string& value) {
    return fmt::format("  s->{}[{}] {} {};\n", name_of(s.to), s.at, s.adds ? "+=" : "=", value);
  }

  const Program& program_;
  const std::string name_;
  std::vector<std::set<int>> live_, kept_of_;  ///< by phase
  std::map<int, int> slot_;                    ///< of what is kept
  PhaseCode out_;
};

}  // namespace

std::string literal(double x) {
  if (std::isnan(x)) return "NAN";
  if (std::isinf(x)) return x > 0 ? "HUGE_VAL" : "(-HUGE_VAL)";
  std::string text = fmt::format("{}", x);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return x < 0 ? "(" + text + ")" : text;
}

PhaseCode write_phases(const Program& program, const std::string& name) {
  return Writer(program, name).write();
}

std::string write_function(const Recording& recording, const Recorded& result, const std::string& name) {
  const auto node = [&](int k) { return recording.nodes()[static_cast<std::size_t>(k)]; };
  std::set<int> live;
  std::vector<int> waiting;
  const auto want = [&](int k) {
    if (!is_leaf(node(k)) && live.insert(k).second) waiting.push_back(k);
  };
  if (result.node >= 0) want(result.node);
  while (!waiting.empty()) {
    const int k = waiting.back();
    waiting.pop_back();
    for_arguments(node(k), want);
  }
  const auto of = [&](int k) -> std::string {
    const Recording::Node n = node(k);
    return n.op == Op::constant ? literal(n.number) : n.op == Op::input ? "x" : fmt::format("t{}", k);
  };
  std::string text = fmt::format("static double {}(double x) {{\n", name);
  for (const int k : live)
    text += node(k).op == Op::call
                ? call(node(k), k, name, of)
                : fmt::format("  const {} t{} = {};\n", type_of(node(k).op), k, expression(node(k), of));
  const std::string value = result.is_constant() ? literal(result.number) : of(result.node);
  return text + (live.empty() ? "  (void)x;\n" : "") + fmt::format("  return {};\n}}\n", value);
}

}  // namespace mimbre::portable
