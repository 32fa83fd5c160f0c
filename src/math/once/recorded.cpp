#include "math/recorded.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "math/elementary.h"

namespace mimbre {

using Op = Recording::Op;

namespace {

thread_local Recording* in_use = nullptr;

int node_of(const Recorded& x) {
  return x.node >= 0 ? x.node : Recording::active().constant(x.number == 0 ? 0.0 : x.number);
}

double value_of(Op op, double a, double b) {
  switch (op) {
    case Op::sqrt:
      return std::sqrt(a);
    case Op::sin:
      return mimbre::sin(a);
    case Op::cos:
      return mimbre::cos(a);
    case Op::tan:
      return mimbre::tan(a);
    case Op::asin:
      return mimbre::asin(a);
    case Op::acos:
      return mimbre::acos(a);
    case Op::atan:
      return mimbre::atan(a);
    case Op::sinh:
      return mimbre::sinh(a);
    case Op::cosh:
      return mimbre::cosh(a);
    case Op::tanh:
      return mimbre::tanh(a);
    case Op::asinh:
      return mimbre::asinh(a);
    case Op::acosh:
      return mimbre::acosh(a);
    case Op::atanh:
      return mimbre::atanh(a);
    case Op::exp:
      return mimbre::exp(a);
    case Op::expm1:
      return mimbre::expm1(a);
    case Op::log:
      return mimbre::log(a);
    case Op::log2:
      return mimbre::log2(a);
    case Op::log10:
      return mimbre::log10(a);
    case Op::abs:
      return std::abs(a);
    case Op::round:
      return std::round(a);
    case Op::rint:
      return std::nearbyint(a);
    case Op::atan2:
      return mimbre::atan2(a, b);
    case Op::pow:
      return mimbre::pow(a, b);
    case Op::hypot:
      return mimbre::hypot(a, b);
    default:
      return std::numeric_limits<double>::quiet_NaN();
  }
}

/// x where `node` is −x.
int opposite_of(int node) {
  const Recording::Node& n = Recording::active().nodes()[static_cast<std::size_t>(node)];
  return n.op == Op::negative ? n.a : -1;
}
int opposite_of(const Recorded& x) { return x.node < 0 ? -1 : opposite_of(x.node); }

Recorded made(const Recording::Node& node) { return Recorded::of_node(Recording::active().node(node)); }
RecordedCondition condition(const Recording::Node& node) {
  RecordedCondition c;
  c.node = Recording::active().node(node);
  return c;
}

}  // namespace

Recording::Recording() : before_(in_use) { in_use = this; }
Recording::~Recording() { in_use = before_; }

Recording& Recording::active() {
  if (!in_use) throw NotRecordable("there is no recording");
  return *in_use;
}

std::size_t Recording::Hash::operator()(const Node& n) const {
  std::uint64_t h = static_cast<std::uint64_t>(n.op);
  for (const std::uint64_t part :
       {static_cast<std::uint64_t>(static_cast<std::uint32_t>(n.a)),
        static_cast<std::uint64_t>(static_cast<std::uint32_t>(n.b)),
        static_cast<std::uint64_t>(static_cast<std::uint32_t>(n.c)),
        static_cast<std::uint64_t>(static_cast<std::uint32_t>(n.d)), std::bit_cast<std::uint64_t>(n.number)})
    h = (h ^ part) * 0x9e3779b97f4a7c15u + (h >> 29);
  return static_cast<std::size_t>(h ^ (h >> 32));
}

int Recording::node(const Node& node) {
  if (std::isnan(node.number)) {  // equal to none
    nodes_.push_back(node);
    return static_cast<int>(nodes_.size()) - 1;
  }
  const auto [at, fresh] = known_.try_emplace(node, static_cast<int>(nodes_.size()));
  if (fresh) nodes_.push_back(node);
  return at->second;
}

int Recording::callee(const Callee& of) {
  const auto at = std::find(callees_.begin(), callees_.end(), of);
  if (at != callees_.end()) return static_cast<int>(at - callees_.begin());
  callees_.push_back(of);
  return static_cast<int>(callees_.size()) - 1;
}

RecordedCondition operator&&(const RecordedCondition& a, const RecordedCondition& b) {
  if (a.node < 0) return a.known ? b : a;
  if (b.node < 0) return b.known ? a : b;
  if (a.node == b.node) return a;
  return condition({Op::both, std::min(a.node, b.node), std::max(a.node, b.node)});
}
RecordedCondition operator||(const RecordedCondition& a, const RecordedCondition& b) {
  if (a.node < 0) return a.known ? a : b;
  if (b.node < 0) return b.known ? b : a;
  if (a.node == b.node) return a;
  return condition({Op::either, std::min(a.node, b.node), std::max(a.node, b.node)});
}
RecordedCondition operator!(const RecordedCondition& a) {
  if (a.node < 0) return !a.known;
  return condition({Op::opposite, a.node});
}

Recorded Recorded::of_node(int node) {
  const Recording::Node& n = Recording::active().nodes()[static_cast<std::size_t>(node)];
  Recorded x;
  if (n.op == Op::constant)
    x.number = n.number;
  else
    x.node = node;
  return x;
}

Recorded Recorded::input(int array, int index) { return made({Op::input, index, array}); }

double Recorded::value() const {
  if (node >= 0) throw NotRecordable("goes by the value of what changes");
  return number;
}

Recorded operator+(const Recorded& a, const Recorded& b) {
  if (a.is_constant() && b.is_constant()) return a.number + b.number;
  if (a.is_constant() && a.number == 0) return b;
  if (b.is_constant() && b.number == 0) return a;
  if (const int x = opposite_of(b); x >= 0) return a - Recorded::of_node(x);
  if (const int x = opposite_of(a); x >= 0) return b - Recorded::of_node(x);
  const int i = node_of(a), j = node_of(b);
  return made({Op::add, std::min(i, j), std::max(i, j)});
}
Recorded operator-(const Recorded& a, const Recorded& b) {
  if (a.is_constant() && b.is_constant()) return a.number - b.number;
  if (a.is_constant() && a.number == 0) return -b;
  if (b.is_constant() && b.number == 0) return a;
  if (a.node >= 0 && a.node == b.node) return 0.0;
  if (const int x = opposite_of(b); x >= 0) return a + Recorded::of_node(x);
  if (const int x = opposite_of(a); x >= 0) return -(Recorded::of_node(x) + b);
  return made({Op::subtract, node_of(a), node_of(b)});
}
Recorded operator-(const Recorded& a) {
  if (a.is_constant()) return -a.number;
  if (const int x = opposite_of(a); x >= 0) return Recorded::of_node(x);
  return made({Op::negative, a.node});
}
Recorded operator*(const Recorded& a, const Recorded& b) {
  if (a.is_constant() && b.is_constant()) return a.number * b.number;
  if (b.is_constant()) return b * a;
  if (a.is_constant()) {
    if (a.number == 0) return 0.0;
    if (a.number == 1) return b;
    if (a.number == -1) return -b;
    if (const int x = opposite_of(b); x >= 0) return Recorded(-a.number) * Recorded::of_node(x);
    // Of products by opposite numbers one is the opposite of the other.
    if (a.number < 0) return -(Recorded(-a.number) * b);
  }
  const int x = opposite_of(a), y = opposite_of(b);
  if (x >= 0 && y >= 0) return Recorded::of_node(x) * Recorded::of_node(y);
  if (x >= 0) return -(Recorded::of_node(x) * b);
  if (y >= 0) return -(a * Recorded::of_node(y));
  const int i = node_of(a), j = node_of(b);
  return made({Op::multiply, std::min(i, j), std::max(i, j)});
}
Recorded operator/(const Recorded& a, const Recorded& b) {
  if (a.is_constant() && b.is_constant()) return a.number / b.number;
  if (a.is_constant() && a.number == 0) return 0.0;
  if (b.is_constant() && b.number == 1) return a;
  if (b.is_constant() && b.number == -1) return -a;
  // A product, off by one rounding, costs a fraction of a quotient.
  if (b.is_constant() && std::isnormal(1 / b.number)) return Recorded(1 / b.number) * a;
  if (const int x = opposite_of(a); x >= 0) return -(Recorded::of_node(x) / b);
  return made({Op::divide, node_of(a), node_of(b)});
}

RecordedCondition operator<(const Recorded& a, const Recorded& b) {
  if (a.is_constant() && b.is_constant()) return a.number < b.number;
  return condition({Op::less, node_of(a), node_of(b)});
}
RecordedCondition operator<=(const Recorded& a, const Recorded& b) {
  if (a.is_constant() && b.is_constant()) return a.number <= b.number;
  return condition({Op::less_or_equal, node_of(a), node_of(b)});
}
RecordedCondition operator==(const Recorded& a, const Recorded& b) {
  if (a.is_constant() && b.is_constant()) return a.number == b.number;
  const int i = node_of(a), j = node_of(b);
  return condition({Op::equal, std::min(i, j), std::max(i, j)});
}
RecordedCondition isfinite(const Recorded& a) {
  if (a.is_constant()) return std::isfinite(a.number);
  return condition({Op::finite, a.node});
}

Recorded record(Op op, const Recorded& a) {
  if (a.is_constant()) return value_of(op, a.number, 0);
  if (const int x = opposite_of(a); x >= 0) {
    if (op == Op::cos || op == Op::abs) return record(op, Recorded::of_node(x));
    if (op == Op::sin || op == Op::tan || op == Op::atan) return -record(op, Recorded::of_node(x));
  }
  return made({op, a.node});
}
Recorded record(Op op, const Recorded& a, const Recorded& b) {
  if (a.is_constant() && b.is_constant()) return value_of(op, a.number, b.number);
  return made({op, node_of(a), node_of(b)});
}
std::vector<Recorded> record_call(const Recording::Callee& of, const Recorded& a, const Recorded* b,
                                  int results, const Recorded* d) {
  Recording& r = Recording::active();
  const int call =
      r.node({Op::call, node_of(a), b ? node_of(*b) : -1, r.callee(of), 0, d ? node_of(*d) : -1});
  std::vector<Recorded> out;
  for (int k = 0; k < results; ++k) out.push_back(made({Op::part, call, k}));
  return out;
}

Recorded sqrt(const Recorded& a) { return record(Op::sqrt, a); }
Recorded sin(const Recorded& a) { return record(Op::sin, a); }
Recorded cos(const Recorded& a) { return record(Op::cos, a); }
Recorded exp(const Recorded& a) { return record(Op::exp, a); }
Recorded expm1(const Recorded& a) { return record(Op::expm1, a); }
Recorded log(const Recorded& a) { return record(Op::log, a); }
Recorded abs(const Recorded& a) { return record(Op::abs, a); }
Recorded round(const Recorded& a) { return record(Op::round, a); }
Recorded atan2(const Recorded& y, const Recorded& x) { return record(Op::atan2, y, x); }
Recorded pow(const Recorded& base, const Recorded& exponent) { return record(Op::pow, base, exponent); }
Recorded hypot(const Recorded& y, const Recorded& x) { return record(Op::hypot, y, x); }

Recorded select(const RecordedCondition& c, const Recorded& a, const Recorded& b) {
  if (c.node < 0) return c.known ? a : b;
  if (a.node == b.node && (a.node >= 0 || a.number == b.number)) return a;
  return made({Op::select, c.node, node_of(a), node_of(b)});
}

}  // namespace mimbre
