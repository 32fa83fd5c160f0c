#include "portable/differentiate.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <unordered_map>

#include "math/function_values.h"

namespace mimbre::portable {
namespace {

using Op = Recording::Op;
using Node = Recording::Node;

bool is_zero(const Recorded& r) { return r.is_constant() && r.number == 0; }

/// Follows values back to what varies (forward mode: Griewank, Walther 2008, chapter 3).
class Variation {
 public:
  Variation(Program& program, VariationOf kept, const std::vector<int>& fixed)
      : program_(program), kept_(kept) {
    for (const int node : fixed) known_.emplace(node, 0);
  }

  Recorded of(const Recorded& value) {
    if (value.is_constant()) return 0;
    std::vector<int> wait{value.node};
    while (!wait.empty()) {
      const int k = wait.back();
      if (known_.contains(k)) {
        wait.pop_back();
        continue;
      }
      const Node n = node(k);
      bool ready = true;
      for_arguments(n, [&](int of) {
        if (known_.contains(of)) return;
        wait.push_back(of);
        ready = false;
      });
      if (!ready) continue;
      wait.pop_back();
      known_.emplace(k, rule(k, n));
    }
    return known_.at(value.node);
  }

 private:
  Node node(int k) const { return program_.recording.nodes()[static_cast<std::size_t>(k)]; }

  /// Of the arguments whose variations a node's needs.
  template <class F>
  static void for_arguments(const Node& n, const F& f) {
    switch (n.op) {
      case Op::constant:
      case Op::input:
        return;
      case Op::select:
        f(n.b);
        f(n.c);
        return;
      case Op::part:
      case Op::call:
        f(n.a);
        if (n.op == Op::call && n.b >= 0) f(n.b);
        if (n.op == Op::call && n.d >= 0) f(n.d);
        return;
      default:
        if (Recording::is_condition(n.op)) return;
        f(n.a);
        if (n.b >= 0) f(n.b);
    }
  }

  Recorded rule(int k, const Node& n) {
    const auto value = [](int of) { return of < 0 ? Recorded(0) : Recorded::of_node(of); };
    const auto varies = [&](int of) { return of < 0 ? Recorded(0) : known_.at(of); };
    if (n.op == Op::constant || Recording::is_condition(n.op)) return 0;
    if (n.op == Op::input && static_cast<Memory>(n.b) == Memory::delayed)
      return program_.input(Memory::delay_rate, n.a) * program_.input(Memory::d_time, 0);
    if (n.op == Op::input) {
      const std::optional<Memory> memory = kept_(static_cast<Memory>(n.b));
      if (!memory) throw NotRecordable("has an output that depends on second derivatives of signals");
      return *memory == Memory::count ? Recorded(0) : program_.input(*memory, n.a);
    }
    if (n.op == Op::call) return 0;  // its parts vary
    if (n.op == Op::part) return part(n);
    if (n.op == Op::select) return select(condition(n.a), varies(n.b), varies(n.c));
    const Recorded x = value(n.a), y = value(n.b), f = Recorded::of_node(k), dx = varies(n.a),
                   dy = varies(n.b), zero = 0, one = 1;
    if (is_zero(dx) && is_zero(dy)) return 0;
    // By a quotient that is not there where nothing can be divided by.
    const auto over = [&](const Recorded& a, const Recorded& b) {
      const auto none = b == zero;
      return select(none, zero, a / select(none, one, b));
    };
    switch (n.op) {
      case Op::add:
        return dx + dy;
      case Op::subtract:
        return dx - dy;
      case Op::multiply:
        return dx * y + x * dy;
      case Op::divide:
        return (dx - f * dy) / y;
      case Op::negative:
        return -dx;
      case Op::sqrt:
        return over(dx, Recorded(2) * f);
      case Op::sin:
        return cos(x) * dx;
      case Op::cos:
        return -(sin(x) * dx);
      case Op::tan:
        return (one + f * f) * dx;
      case Op::asin:
        return over(dx, sqrt(one - x * x));
      case Op::acos:
        return -over(dx, sqrt(one - x * x));
      case Op::atan:
        return dx / (one + x * x);
      case Op::sinh:
        return record(Op::cosh, x) * dx;
      case Op::cosh:
        return record(Op::sinh, x) * dx;
      case Op::tanh:
        return (one - f * f) * dx;
      case Op::asinh:
        return dx / sqrt(x * x + one);
      case Op::acosh:
        return over(dx, sqrt(x * x - one));
      case Op::atanh:
        return dx / (one - x * x);
      case Op::exp:
        return f * dx;
      case Op::expm1:
        return (f + one) * dx;
      case Op::log:
        return dx / x;
      case Op::log2:
        return dx / (x * Recorded(0.69314718055994530942));
      case Op::log10:
        return dx / (x * Recorded(2.30258509299404568402));
      case Op::abs:
        return select(x < zero, -dx, dx);
      case Op::round:
      case Op::rint:
        return 0;
      case Op::atan2:  // of x (first) over y
        return over(dx * y - x * dy, x * x + y * y);
      case Op::hypot:
        return over(x * dx + y * dy, f);
      case Op::pow: {
        const Recorded by_base = is_zero(dx) ? zero : y * pow(x, y - one) * dx;
        if (is_zero(dy)) return by_base;
        const auto positive = x > zero;
        return by_base + select(positive, f * log(select(positive, x, one)) * dy, zero);
      }
      default:
        throw NotRecordable("has an operation without a derivative");
    }
  }

  static RecordedCondition condition(int node) {
    RecordedCondition out;
    out.node = node;
    return out;
  }

  /// Parts of functions are the value and its derivatives; of roads the height and its slopes, and friction.
  Recorded part(const Node& n) {
    const Node call = node(n.a);
    const Recorded dx = known_.at(call.a), dy = call.b < 0 ? Recorded(0) : known_.at(call.b),
                   dz = call.d < 0 ? Recorded(0) : known_.at(call.d);
    if (is_zero(dx) && is_zero(dy) && is_zero(dz)) return 0;
    const Recording::Callee of = program_.recording.callees()[static_cast<std::size_t>(call.c)];
    const auto other = [&](int part) {
      return Recorded::of_node(program_.recording.node({Op::part, n.a, part, -1, 0}));
    };
    if (of.kind == static_cast<int>(RecordedCallee::noise)) return 0;
    if (of.kind == static_cast<int>(RecordedCallee::function) && n.b < 2) return other(n.b + 1) * dx;
    const Recorded x = Recorded::of_node(call.a);
    if (of.kind == static_cast<int>(RecordedCallee::antiderivative))
      return value_at(*static_cast<const FunctionData*>(of.data), x) * dx;
    if (of.kind == static_cast<int>(RecordedCallee::integral))
      return value_at(static_cast<const IntegralFunction*>(of.data)->f.front(), x) * dx;
    if ((of.kind == static_cast<int>(RecordedCallee::road) ||
         of.kind == static_cast<int>(RecordedCallee::table_of_two)) &&
        n.b == 0)
      return other(1) * dx + other(2) * dy;
    if (of.kind == static_cast<int>(RecordedCallee::road) && n.b == 3) return 0;
    if (of.kind == static_cast<int>(RecordedCallee::mesh) && n.b == 0)
      return other(1) * dx + other(2) * dy + other(3) * dz;
    throw NotRecordable(of.kind == static_cast<int>(RecordedCallee::road)
                            ? "has a road whose slopes have no derivatives"
                        : of.kind == static_cast<int>(RecordedCallee::mesh)
                            ? "has a contact with triangles, whose normal has no derivatives"
                            : "has a function whose derivatives are not known that far");
  }

  Program& program_;
  const VariationOf kept_;
  std::unordered_map<int, Recorded> known_;
};

}  // namespace

std::optional<Memory> variation_of(Memory memory) {
  switch (memory) {
    case Memory::q:
      return Memory::d_q;
    case Memory::v:
      return Memory::d_v;
    case Memory::a:
      return Memory::d_a;
    case Memory::multipliers:
      return Memory::d_multipliers;
    case Memory::held:
      return Memory::d_held;
    case Memory::states:
      return Memory::d_states;
    case Memory::increment:
      return Memory::d_increment;
    case Memory::slot:
      return Memory::d_slot;
    case Memory::rate:
      return Memory::d_rate;
    case Memory::second:
      return Memory::d_second;
    case Memory::phi:
      return Memory::d_phi;
    case Memory::phi_dot:
      return Memory::d_phi_dot;
    case Memory::phi_ddot:
      return Memory::d_phi_ddot;
    case Memory::residual:
      return Memory::d_residual;
    case Memory::increment_rate:
      return Memory::d_increment_rate;
    case Memory::state_rate:
      return Memory::d_state_rate;
    case Memory::output:
      return Memory::d_output;
    default:
      return Memory::count;
  }
}

std::optional<Memory> variation_at_rest(Memory memory) {
  switch (memory) {
    case Memory::held:
      return Memory::d_held;
    case Memory::time:
      return Memory::d_time;
    case Memory::slot:
      return Memory::d_slot;
    case Memory::rate:
      return Memory::d_rate;
    case Memory::second:
      return std::nullopt;
    case Memory::output:
      return Memory::d_output;
    default:
      return Memory::count;
  }
}

void differentiate(Program& program, const std::vector<std::string>& phases, const std::vector<int>& after,
                   VariationOf of, const std::vector<int>& fixed) {
  Variation variation(program, of, fixed);
  std::vector<int> before = after;
  for (const std::string& name : phases) {
    const auto found = std::find_if(program.phases.begin(), program.phases.end(),
                                    [&](const Phase& p) { return p.name == name; });
    if (found == program.phases.end()) continue;
    const std::vector<Store> stores = found->stores;
    const int number = program.begin("d_" + name, before);
    for (const Store& s : stores) {
      const std::optional<Memory> to = of(s.to);
      if (to && *to != Memory::count) program.store(*to, s.at, variation.of(s.value));
    }
    before.push_back(number);
  }
}

}  // namespace mimbre::portable
