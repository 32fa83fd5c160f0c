#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "math/choice.h"
#include "math/function_values.h"
#include "math/lanes.h"
#include "math/rotation.h"

/// A scalar that writes down what is done with it: kernels that run over it once give the list of operations
/// that they take, from which straight-line code is made (src/portable).
namespace mimbre {

/// What cannot be written down: who runs kernels over recorded scalars catches it.
struct NotRecordable : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Operations on doubles, each once: constants are folded, zeros and ones dropped, the arguments of sums and
/// products are in one order, and what has been computed before is taken from there. Not a number times 0 is
/// taken as 0.
class Recording {
 public:
  enum class Op : std::uint8_t {
    constant,
    input,  ///< number `a` of the array `b`
    // Of numbers.
    add,
    subtract,
    multiply,
    divide,
    negative,
    sqrt,
    sin,
    cos,
    tan,
    asin,
    acos,
    atan,
    sinh,
    cosh,
    tanh,
    asinh,
    acosh,
    atanh,
    exp,
    expm1,
    log,
    log2,
    log10,
    abs,
    round,
    rint,
    atan2,
    pow,
    hypot,
    // Conditions.
    less,
    less_or_equal,
    equal,
    both,
    either,
    opposite,
    finite,
    select,  ///< b where a holds, else c
    call,    ///< function `c` of a, b and d (−1: of fewer), whose results are parts
    part     ///< result b of the call a
  };
  struct Node {
    Op op;
    std::int32_t a = -1, b = -1, c = -1;
    double number = 0;
    std::int32_t d = -1;
    bool operator==(const Node&) const = default;
  };
  static bool is_condition(Op op) { return op >= Op::less && op <= Op::finite; }

  /// What recorded scalars of this thread are written down in, while it is there.
  Recording();
  ~Recording();
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;
  static Recording& active();

  const std::vector<Node>& nodes() const { return nodes_; }
  int node(const Node& node);
  int constant(double number) { return node({Op::constant, -1, -1, -1, number}); }

  /// Functions that are called: their kinds are of who makes code of them.
  struct Callee {
    const void* data;
    double number;  ///< a footprint
    int kind;
    bool operator==(const Callee&) const = default;
  };
  int callee(const Callee& of);
  const std::vector<Callee>& callees() const { return callees_; }

 private:
  struct Hash {
    std::size_t operator()(const Node& n) const;
  };
  std::vector<Node> nodes_;
  std::unordered_map<Node, int, Hash> known_;
  std::vector<Callee> callees_;
  Recording* before_;
};

/// What a comparison gives: known (node −1), or written down.
struct RecordedCondition {
  int node = -1;
  bool known = false;

  RecordedCondition() = default;
  RecordedCondition(bool value) : known(value) {}
  friend RecordedCondition operator&&(const RecordedCondition& a, const RecordedCondition& b);
  friend RecordedCondition operator||(const RecordedCondition& a, const RecordedCondition& b);
  friend RecordedCondition operator!(const RecordedCondition& a);
  /// Surely, and possibly.
  friend bool all(const RecordedCondition& a) { return a.node < 0 && a.known; }
  friend bool any(const RecordedCondition& a) { return a.node >= 0 || a.known; }
};

struct Recorded {
  int node = -1;  ///< −1: the constant `number`
  double number = 0;

  Recorded() = default;
  Recorded(double x) : number(x) {}
  static Recorded of_node(int node);
  /// Number `index` of an array.
  static Recorded input(int array, int index);
  bool is_constant() const { return node < 0; }
  /// Of constants: where a kernel asks for the value of another one, NotRecordable.
  double value() const;

  friend Recorded operator+(const Recorded& a, const Recorded& b);
  friend Recorded operator-(const Recorded& a, const Recorded& b);
  friend Recorded operator*(const Recorded& a, const Recorded& b);
  friend Recorded operator/(const Recorded& a, const Recorded& b);
  friend Recorded operator-(const Recorded& a);
  Recorded& operator+=(const Recorded& b) { return *this = *this + b; }
  Recorded& operator-=(const Recorded& b) { return *this = *this - b; }
  Recorded& operator*=(const Recorded& b) { return *this = *this * b; }
  Recorded& operator/=(const Recorded& b) { return *this = *this / b; }

  friend RecordedCondition operator<(const Recorded& a, const Recorded& b);
  friend RecordedCondition operator<=(const Recorded& a, const Recorded& b);
  friend RecordedCondition operator==(const Recorded& a, const Recorded& b);
  friend RecordedCondition operator>(const Recorded& a, const Recorded& b) { return b < a; }
  friend RecordedCondition operator>=(const Recorded& a, const Recorded& b) { return b <= a; }
  friend RecordedCondition operator!=(const Recorded& a, const Recorded& b) { return !(a == b); }

  friend Recorded sqrt(const Recorded& a);
  friend Recorded sin(const Recorded& a);
  friend Recorded cos(const Recorded& a);
  friend Recorded exp(const Recorded& a);
  friend Recorded expm1(const Recorded& a);
  friend Recorded log(const Recorded& a);
  friend Recorded abs(const Recorded& a);
  friend Recorded round(const Recorded& a);
  friend Recorded atan2(const Recorded& y, const Recorded& x);
  friend Recorded pow(const Recorded& base, const Recorded& exponent);
  friend Recorded hypot(const Recorded& y, const Recorded& x);
  friend RecordedCondition isfinite(const Recorded& a);
};

/// Any operation of one or two numbers.
Recorded record(Recording::Op op, const Recorded& a);
Recorded record(Recording::Op op, const Recorded& a, const Recorded& b);
/// A call of a function of up to three numbers with so many results, which come next to each other.
std::vector<Recorded> record_call(const Recording::Callee& of, const Recorded& a, const Recorded* b,
                                  int results, const Recorded* d = nullptr);

Recorded select(const RecordedCondition& condition, const Recorded& a, const Recorded& b);
}  // namespace mimbre

template <>
struct Eigen::NumTraits<mimbre::Recorded> : Eigen::NumTraits<double> {
  using Real = mimbre::Recorded;
  using NonInteger = mimbre::Recorded;
  using Nested = mimbre::Recorded;
  enum {
    RequireInitialization = 1,
    ReadCost = 2,
    AddCost = 2,
    MulCost = 3,
  };
};

namespace mimbre {

template <int rows, int columns>
Eigen::Matrix<Recorded, rows, columns> select(const RecordedCondition& condition,
                                              const Eigen::Matrix<Recorded, rows, columns>& a,
                                              const Eigen::Matrix<Recorded, rows, columns>& b) {
  Eigen::Matrix<Recorded, rows, columns> out;
  for (Eigen::Index k = 0; k < out.size(); ++k) out(k) = select(condition, a(k), b(k));
  return out;
}
/// Both, where it is not known.
template <class F, class G>
auto choose(const RecordedCondition& condition, const F& f, const G& g) -> decltype(f()) {
  if (all(condition)) return f();
  if (!any(condition)) return g();
  return select(condition, f(), g());
}

// The functions and formulas of function_values.h, and what kernels do with the values of other scalars.

/// Functions that recordings call. Of a FunctionData: its value with both derivatives, or its antiderivative.
/// Of an IntegralFunction: its integral from 0. Of a RoadData: the height with its slopes, and friction. Of a
/// TriangleMesh: the distance of a point, and the normal there. Of a block's numbers: noise at a time;
/// what a table of two variables has there, and its slopes.
enum class RecordedCallee { function, antiderivative, integral, road, mesh, noise, table_of_two };

inline double in_lane(const Recorded& x, int) { return x.value(); }
Recorded value_at(const FunctionData& f, const Recorded& x);
std::pair<Recorded, Recorded> tangent_at(const FunctionData& f, const Recorded& x);
JetOf<Recorded> jet_at(const FunctionData& f, const Recorded& x);
Recorded value_at(const Expression& f, const Recorded* x);
std::pair<Recorded, Recorded> derivatives_at(const Expression& f, const Recorded* x);
template <>
JetOf<Recorded> jet_at<Recorded>(const Expression& f, const JetOf<Recorded>* x);
template <>
GradientOf<Recorded> gradient_at<Recorded>(const Expression& f, const GradientOf<Recorded>* x);
template <>
Quat<Recorded> quaternion_of<Recorded>(const Mat3<Recorded>& r);

}  // namespace mimbre
