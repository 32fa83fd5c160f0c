#include <array>
#include <cmath>
#include <numbers>

#include "math/recorded.h"

/// Functions and formulas, recorded.
namespace mimbre {
namespace {

using Op = Recording::Op;
using Program = ExpressionProgram;
using Jets = JetOf<Recorded>;
using Gradients = GradientOf<Recorded>;

/// What a function of one number is there: f, f' and f''.
struct RecordedTaylor {
  Recorded f, f1, f2;
};

Recorded chain(const RecordedTaylor& t, const Recorded&) { return t.f; }
Jets chain(const RecordedTaylor& t, const Jets& x) {
  return {t.f, t.f1 * x.first, t.f2 * (x.first * x.first) + t.f1 * x.second};
}
Gradients chain(const RecordedTaylor& t, const Gradients& x) {
  return {t.f, t.f1 * x.by_first, t.f1 * x.by_second};
}

const Recorded& value_of(const Recorded& x) { return x; }
const Recorded& value_of(const Jets& x) { return x.value; }
const Recorded& value_of(const Gradients& x) { return x.value; }
void set_constant(Recorded& x, const Recorded& value) { x = value; }
void set_constant(Jets& x, const Recorded& value) { x = {value, 0, 0}; }
void set_constant(Gradients& x, const Recorded& value) { x = {value, 0, 0}; }

Jets add(const Jets& a, const Jets& b) { return {a.value + b.value, a.first + b.first, a.second + b.second}; }
Gradients add(const Gradients& a, const Gradients& b) {
  return {a.value + b.value, a.by_first + b.by_first, a.by_second + b.by_second};
}
Recorded add(const Recorded& a, const Recorded& b) { return a + b; }
Jets opposite(const Jets& a) { return {-a.value, -a.first, -a.second}; }
Gradients opposite(const Gradients& a) { return {-a.value, -a.by_first, -a.by_second}; }
Recorded opposite(const Recorded& a) { return -a; }
Recorded product(const Recorded& a, const Recorded& b) { return a * b; }
Jets product(const Jets& a, const Jets& b) {
  return {a.value * b.value, a.value * b.first + b.value * a.first,
          a.value * b.second + Recorded(2) * (a.first * b.first) + b.value * a.second};
}
Gradients product(const Gradients& a, const Gradients& b) {
  return {a.value * b.value, a.value * b.by_first + b.value * a.by_first,
          a.value * b.by_second + b.value * a.by_second};
}
Recorded quotient(const Recorded& a, const Recorded& b) { return a / b; }
Jets quotient(const Jets& a, const Jets& b) {
  const Recorded q = a.value / b.value, q1 = (a.first - q * b.first) / b.value;
  return {q, q1, (a.second - Recorded(2) * (q1 * b.first) - q * b.second) / b.value};
}
Gradients quotient(const Gradients& a, const Gradients& b) {
  const Recorded q = a.value / b.value;
  return {q, (a.by_first - q * b.by_first) / b.value, (a.by_second - q * b.by_second) / b.value};
}

Recorded picked(const RecordedCondition& c, const Recorded& a, const Recorded& b) { return select(c, a, b); }
Jets picked(const RecordedCondition& c, const Jets& a, const Jets& b) {
  return {select(c, a.value, b.value), select(c, a.first, b.first), select(c, a.second, b.second)};
}
Gradients picked(const RecordedCondition& c, const Gradients& a, const Gradients& b) {
  return {select(c, a.value, b.value), select(c, a.by_first, b.by_first),
          select(c, a.by_second, b.by_second)};
}
/// The mean of derivatives where two branches meet.
template <class S>
S mean(const S& a, const S& b) {
  S half;
  set_constant(half, 0.5);
  S out = product(half, add(a, b));
  return out;
}

Recorded sign_of(const Recorded& x) {
  return select(x > Recorded(0), Recorded(1), select(x < Recorded(0), Recorded(-1), Recorded(0)));
}

RecordedTaylor taylor(Program::Op op, const Recorded& x) {
  using P = Program::Op;
  const Recorded one(1), two(2);
  const auto of = [&](Op simple) { return record(simple, x); };
  const auto logarithm = [&](Op simple, double base) {
    return RecordedTaylor{of(simple), one / (x * Recorded(base)), -one / (x * x * Recorded(base))};
  };
  switch (op) {
    case P::square:
      return {x * x, two * x, two};
    case P::cube:
      return {x * x * x, Recorded(3) * x * x, Recorded(6) * x};
    case P::fourth:
      return {x * x * x * x, Recorded(4) * x * x * x, Recorded(12) * x * x};
    case P::sin:
      return {of(Op::sin), of(Op::cos), -of(Op::sin)};
    case P::cos:
      return {of(Op::cos), -of(Op::sin), -of(Op::cos)};
    case P::tan: {
      const Recorded f = of(Op::tan), f1 = one + f * f;
      return {f, f1, two * f * f1};
    }
    case P::asin:
    case P::acos: {
      const Recorded c = one - x * x, slope = Recorded(op == P::asin ? 1 : -1) / record(Op::sqrt, c);
      return {of(op == P::asin ? Op::asin : Op::acos), slope, slope * x / c};
    }
    case P::atan: {
      const Recorded slope = one / (one + x * x);
      return {of(Op::atan), slope, Recorded(-2) * x * slope * slope};
    }
    case P::sinh:
      return {of(Op::sinh), of(Op::cosh), of(Op::sinh)};
    case P::cosh:
      return {of(Op::cosh), of(Op::sinh), of(Op::cosh)};
    case P::tanh: {
      const Recorded c = of(Op::cosh), slope = one / (c * c), f = of(Op::tanh);
      return {f, slope, Recorded(-2) * f * slope};
    }
    case P::asinh: {
      const Recorded c = one + x * x, slope = one / record(Op::sqrt, c);
      return {of(Op::asinh), slope, -slope * x / c};
    }
    case P::acosh: {
      const Recorded c = (x - one) * (x + one), slope = one / record(Op::sqrt, c);
      return {of(Op::acosh), slope, -slope * x / c};
    }
    case P::atanh: {
      const Recorded slope = one / ((one - x) * (one + x));
      return {of(Op::atanh), slope, two * x * slope * slope};
    }
    case P::log2:
      return logarithm(Op::log2, std::numbers::ln2);
    case P::log10:
      return logarithm(Op::log10, std::numbers::ln10);
    case P::ln:
      return logarithm(Op::log, 1);
    case P::exp:
      return {of(Op::exp), of(Op::exp), of(Op::exp)};
    case P::sqrt: {
      const Recorded f = of(Op::sqrt);
      return {f, Recorded(0.5) / f, Recorded(-0.25) / (f * x)};
    }
    case P::abs:
      return {of(Op::abs), sign_of(x), 0};
    case P::sign:
      return {sign_of(x), 0, 0};
    case P::rint:
      return {of(Op::rint), 0, 0};
    default:
      throw NotRecordable("a formula has an operation that is not known");
  }
}

template <class S>
S unary(Program::Op op, const S& x) {
  return chain(taylor(op, value_of(x)), x);
}

Recorded power(const Recorded& a, const Recorded& b) {
  if (b.is_constant()) {
    if (b.number == 0) return 1;
    if (b.number == 1) return a;
    if (b.number == 2) return a * a;
    if (b.number == 0.5) return record(Op::sqrt, a);
  }
  return record(Op::pow, a, b);
}
template <class S>
S power(const S& a, const S& b) {
  const Recorded x = a.value, n = b.value, f = power(x, n);
  if (n.is_constant()) {
    const double p = n.number;
    return chain(RecordedTaylor{f, p == 0 ? Recorded(0) : n * power(x, p - 1),
                                p == 0 || p == 1 ? Recorded(0) : Recorded(p * (p - 1)) * power(x, p - 2)},
                 a);
  }
  // As for numbers: by the base alone where that is 0, else exp(b ln a).
  const Recorded f1 = n * record(Op::pow, x, n - Recorded(1)),
                 f2 = n * (n - Recorded(1)) * record(Op::pow, x, n - Recorded(2));
  const S by_base = chain(RecordedTaylor{f, f1, f2}, a);
  S all = chain(RecordedTaylor{f, f, f}, product(b, unary(Program::Op::ln, a)));
  all.value = f;
  return picked(x == Recorded(0), by_base, all);
}

Recorded arc_tangent(const Recorded& y, const Recorded& x) { return record(Op::atan2, y, x); }
Gradients arc_tangent(const Gradients& y, const Gradients& x) {
  const Recorded s = x.value * x.value + y.value * y.value;
  return {record(Op::atan2, y.value, x.value), (x.value * y.by_first - y.value * x.by_first) / s,
          (x.value * y.by_second - y.value * x.by_second) / s};
}
Jets arc_tangent(const Jets& y, const Jets& x) {
  const Recorded s = x.value * x.value + y.value * y.value,
                 first = (x.value * y.first - y.value * x.first) / s;
  return {record(Op::atan2, y.value, x.value), first,
          (x.value * y.second - y.value * x.second -
           Recorded(2) * (x.value * x.first + y.value * y.first) * first) /
              s};
}

template <class S>
S least(const S& a, const S& b, bool smallest) {
  const Recorded &x = value_of(smallest ? a : b), &y = value_of(smallest ? b : a);
  return picked(x < y, a, picked(y < x, b, mean(a, b)));
}
Recorded least(const Recorded& a, const Recorded& b, bool smallest) {
  return smallest ? select(b < a, b, a) : select(a < b, b, a);
}

RecordedCondition holds(Program::Op op, const Recorded& a, const Recorded& b) {
  using P = Program::Op;
  switch (op) {
    case P::less:
      return a < b;
    case P::greater:
      return a > b;
    case P::less_or_equal:
      return a <= b;
    case P::greater_or_equal:
      return a >= b;
    case P::equal:
      return a == b;
    case P::not_equal:
      return a != b;
    case P::both:
      return a != Recorded(0) && b != Recorded(0);
    default:
      return a != Recorded(0) || b != Recorded(0);
  }
}

/// Instructions [at, end), on a stack. `c ? a : b` is: c, a jump to b if it is 0, a, a jump behind b, b.
template <class S>
void run(const Program& program, std::size_t at, std::size_t end, const S* variables, std::vector<S>& stack) {
  using P = Program::Op;
  const auto pop = [&] {
    S top = stack.back();
    stack.pop_back();
    return top;
  };
  for (; at < end; ++at) {
    const Program::Instruction& i = program.code[at];
    S x;
    switch (i.op) {
      case P::number:
        set_constant(x, i.number);
        stack.push_back(x);
        break;
      case P::variable:
        stack.push_back(variables[i.at]);
        break;
      case P::negative:
        stack.back() = opposite(stack.back());
        break;
      case P::divided_by_number:
        set_constant(x, i.number);
        stack.back() = quotient(stack.back(), x);
        break;
      case P::add:
        x = pop();
        stack.back() = add(stack.back(), x);
        break;
      case P::subtract:
        x = pop();
        stack.back() = add(stack.back(), opposite(x));
        break;
      case P::multiply:
        x = pop();
        stack.back() = product(stack.back(), x);
        break;
      case P::divide:
        x = pop();
        stack.back() = quotient(stack.back(), x);
        break;
      case P::power:
        x = pop();
        stack.back() = power(stack.back(), x);
        break;
      case P::atan2:
        x = pop();
        stack.back() = arc_tangent(stack.back(), x);
        break;
      case P::min:
      case P::max:
        x = pop();
        stack.back() = least(stack.back(), x, i.op == P::min);
        break;
      case P::less:
      case P::greater:
      case P::less_or_equal:
      case P::greater_or_equal:
      case P::equal:
      case P::not_equal:
      case P::both:
      case P::either: {
        x = pop();
        const RecordedCondition c = holds(i.op, value_of(stack.back()), value_of(x));
        set_constant(stack.back(), select(c, Recorded(1), Recorded(0)));
        break;
      }
      case P::jump:
        throw NotRecordable("a formula jumps in a way that is not known");
      case P::jump_if_zero: {
        const RecordedCondition c = value_of(pop()) != Recorded(0);
        const std::size_t otherwise = i.at, behind = program.code[otherwise - 1].at;
        if (program.code[otherwise - 1].op != P::jump)
          throw NotRecordable("a formula jumps in a way that is not known");
        run(program, at + 1, otherwise - 1, variables, stack);
        const S a = pop();
        run(program, otherwise, behind, variables, stack);
        stack.back() = picked(c, a, stack.back());
        at = behind - 1;
        break;
      }
      default:
        stack.back() = unary(i.op, stack.back());
    }
  }
}

template <class S>
S result(const Expression& f, const S* variables) {
  S zero;
  set_constant(zero, 0);
  if (f.is_zero()) return zero;
  std::vector<S> stack;
  run(f.program(), 0, f.program().code.size(), variables, stack);
  return stack.back();
}

constexpr int function_results = 3;

/// Value and both derivatives.
Jets jet_of(const FunctionData& f, const Recorded& x) {
  if (f.is_zero()) return {0, 0, 0};
  if (x.is_constant()) {
    const Jet jet = f.jet(x.number);
    return {jet.value, jet.first, jet.second};
  }
  if (const OneVariable* formula = f.formula()) {
    const Jets of{x, 1, 0};
    return result(formula->expression, &of);
  }
  if (const IntegralFunction* integral = f.integral()) {
    const FunctionData& rate = integral->f.front();
    const std::vector<Recorded> value =
        integral->exact
            ? record_call({&rate, 0, static_cast<int>(RecordedCallee::antiderivative)}, x, nullptr, 1)
            : record_call({integral, 0, static_cast<int>(RecordedCallee::integral)}, x, nullptr, 1);
    const Jets of = jet_of(rate, x);
    return {Recorded(integral->start) + value[0], of.value, of.first};
  }
  const std::vector<Recorded> parts =
      record_call({&f, 0, static_cast<int>(RecordedCallee::function)}, x, nullptr, function_results);
  return {parts[0], parts[1], parts[2]};
}

}  // namespace

Jets jet_at(const FunctionData& f, const Recorded& x) { return jet_of(f, x); }
Recorded value_at(const FunctionData& f, const Recorded& x) { return jet_of(f, x).value; }
std::pair<Recorded, Recorded> tangent_at(const FunctionData& f, const Recorded& x) {
  const Jets jet = jet_of(f, x);
  return {jet.value, jet.first};
}
Recorded value_at(const Expression& f, const Recorded* x) { return result(f, x); }
std::pair<Recorded, Recorded> derivatives_at(const Expression& f, const Recorded* x) {
  std::array<Gradients, Formula::most_variables> of;
  for (std::size_t k = 0; k < f.variables(); ++k) of[k] = {x[k], k == 0 ? 1 : 0, k == 1 ? 1 : 0};
  const Gradients g = result(f, of.data());
  return {g.by_first, g.by_second};
}
template <>
Jets jet_at<Recorded>(const Expression& f, const Jets* x) {
  return result(f, x);
}
template <>
Gradients gradient_at<Recorded>(const Expression& f, const Gradients* x) {
  return result(f, x);
}

/// Of four quaternions that are the same but for round-off the one that divides by the largest component.
template <>
Quat<Recorded> quaternion_of<Recorded>(const Mat3<Recorded>& r) {
  const Recorded one(1), zero(0), half(0.5);
  const auto of_trace = [&] {
    const Recorded s = sqrt(r.trace() + one), t = half / s;
    Quat<Recorded> q;
    q << half * s, (r(2, 1) - r(1, 2)) * t, (r(0, 2) - r(2, 0)) * t, (r(1, 0) - r(0, 1)) * t;
    return q;
  };
  const auto of_axis = [&](int i) {
    const int j = (i + 1) % 3, k = (j + 1) % 3;
    const Recorded s = sqrt(r(i, i) - r(j, j) - r(k, k) + one), t = half / s;
    Quat<Recorded> q;
    q[0] = (r(k, j) - r(j, k)) * t;
    q[1 + i] = half * s;
    q[1 + j] = (r(j, i) + r(i, j)) * t;
    q[1 + k] = (r(k, i) + r(i, k)) * t;
    return q;
  };
  const RecordedCondition y_over_x = r(1, 1) > r(0, 0);
  const Recorded most = select(y_over_x, r(1, 1), r(0, 0));
  const Quat<Recorded> of_xy = select(y_over_x, of_axis(1), of_axis(0));
  const Quat<Recorded> of_axes = select(r(2, 2) > most, of_axis(2), of_xy);
  const Quat<Recorded> q = select(r.trace() > zero, of_trace(), of_axes);
  return q / sqrt(q.squaredNorm());
}

}  // namespace mimbre
