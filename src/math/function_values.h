#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <type_traits>
#include <utility>

#include "math/dual.h"
#include "math/function_data.h"
#include "math/jet.h"
#include "math/pack.h"

/// Functions and formulas of any scalar of the kernels. Of packs lane by lane; of dual numbers by the exact
/// derivatives that they know.
namespace mimbre {

namespace numbers {
template <class T>
struct Jet {
  T value, first, second;
};
template <class T>
struct Gradient {
  T value, by_first, by_second;
};
}  // namespace numbers

/// A Jet and a Gradient whose parts are of the scalar.
template <class T>
using JetOf = std::conditional_t<std::is_same_v<T, double>, Jet, numbers::Jet<T>>;
template <class T>
using GradientOf = std::conditional_t<std::is_same_v<T, double>, Gradient, numbers::Gradient<T>>;

inline double value_at(const FunctionData& f, double x) { return f.value(x); }
template <int N>
Pack<N> value_at(const FunctionData& f, const Pack<N>& x) {
  Pack<N> out;
  for (int i = 0; i < N; ++i) out[i] = f.value(x[i]);
  return out;
}
inline Dual value_at(const FunctionData& f, const Dual& x) {
  const auto [value, slope] = f.tangent(x.value);
  return Dual::chain(value, slope, x);
}

/// The value and the derivative by x.
inline std::pair<double, double> tangent_at(const FunctionData& f, double x) { return f.tangent(x); }
template <int N>
std::pair<Pack<N>, Pack<N>> tangent_at(const FunctionData& f, const Pack<N>& x) {
  std::pair<Pack<N>, Pack<N>> out;
  for (int i = 0; i < N; ++i) std::tie(out.first[i], out.second[i]) = f.tangent(x[i]);
  return out;
}
inline std::pair<Dual, Dual> tangent_at(const FunctionData& f, const Dual& x) {
  const Jet jet = f.jet(x.value);
  return {Dual::chain(jet.value, jet.first, x), Dual::chain(jet.first, jet.second, x)};
}

/// Of formulas, x is one value per variable.
inline double value_at(const Expression& f, const double* x) { return f.value(x); }
template <int N>
Pack<N> value_at(const Expression& f, const Pack<N>* x) {
  Pack<N> out;
  std::array<double, Formula::most_variables> of;
  for (int i = 0; i < N; ++i) {
    for (std::size_t k = 0; k < f.variables(); ++k) of[k] = x[k][i];
    out[i] = f.value(of.data());
  }
  return out;
}
inline Dual value_at(const Expression& f, const Dual* x) {
  std::array<Jet, Formula::most_variables> of;
  for (std::size_t k = 0; k < f.variables(); ++k) of[k] = {x[k].value, x[k].derivative, 0};
  const Jet jet = f.jet(of.data());
  return {jet.value, jet.first};
}

/// A formula along a line through its variables, x(s) = value + s rate, that turns with the parameter of
/// dual numbers: its value and its derivative by s, dual both.
///
/// With a = rate, d = value', c = rate', what is not known at once is aᵀ H d + c · ∇f of the second dual
/// part; it is a quarter of the difference of the second derivatives along a + d and a − d, on curves that
/// bend by ±2 c.
template <class Value, class Rate>
std::pair<Dual, Dual> along_line(const Expression& f, const Value& value, const Rate& rate) {
  std::array<Jet, Formula::most_variables> of;
  const std::size_t n = f.variables();
  double most_a = 0, most_d = 0;
  bool varies = false;
  for (std::size_t k = 0; k < n; ++k) {
    most_a = std::max(most_a, std::abs(rate(k).value));
    most_d = std::max(most_d, std::abs(value(k).derivative));
    varies = varies || value(k).derivative != 0 || rate(k).derivative != 0;
    of[k] = {value(k).value, rate(k).value, 0};
  }
  const Jet by_rate = f.jet(of.data());
  if (!varies) return {by_rate.value, by_rate.first};
  for (std::size_t k = 0; k < n; ++k) of[k] = {value(k).value, value(k).derivative, 0};
  const Jet by_parameter = f.jet(of.data());
  // Both directions of one size, so that the difference keeps its digits.
  const double scale = most_a > 0 && most_d > 0 ? most_a / most_d : 1;
  double second[2];
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? 1 : -1;
    for (std::size_t k = 0; k < n; ++k)
      of[k] = {value(k).value, rate(k).value + sign * scale * value(k).derivative,
               sign * 2 * scale * rate(k).derivative};
    second[side] = f.jet(of.data()).second;
  }
  return {{by_rate.value, by_parameter.first}, {by_rate.first, 0.25 * (second[0] - second[1]) / scale}};
}

/// ∂/∂x[0] and ∂/∂x[1].
inline std::pair<double, double> derivatives_at(const Expression& f, const double* x) {
  return f.derivatives(x);
}
template <int N>
std::pair<Pack<N>, Pack<N>> derivatives_at(const Expression& f, const Pack<N>* x) {
  std::pair<Pack<N>, Pack<N>> out;
  std::array<double, Formula::most_variables> of;
  for (int i = 0; i < N; ++i) {
    for (std::size_t k = 0; k < f.variables(); ++k) of[k] = x[k][i];
    std::tie(out.first[i], out.second[i]) = f.derivatives(of.data());
  }
  return out;
}
inline std::pair<Dual, Dual> derivatives_at(const Expression& f, const Dual* x) {
  const auto by = [&](std::size_t variable) {
    return along_line(
               f, [&](std::size_t k) { return x[k]; },
               [&](std::size_t k) { return Dual(k == variable ? 1 : 0); })
        .second;
  };
  return {by(0), by(1)};
}

inline bool reads(const Expression& f, std::size_t variable) {
  for (const ExpressionProgram::Instruction& i : f.program().code)
    if (i.op == ExpressionProgram::Op::variable && static_cast<std::size_t>(i.at) == variable) return true;
  return false;
}

/// The derivative of a second derivative by time with the parameter of dual numbers. Where no variable has a
/// rate it is c · ∇f, c the variables' second derivatives. Elsewhere third derivatives belong to it, which
/// formulas do not know: a difference, exact to about 1e-10 where the formula hardly bends over a thousandth
/// of its variables (of 1 where these are smaller), and wrong where it turns within that.
inline double derivative_of_second(const Expression& f, const JetOf<Dual>* x) {
  bool moves = false;
  double size = 0;  // of what varies, of the variables' own size
  const auto add = [&](const Dual& part) {
    size = std::max(size, std::abs(part.derivative) / std::max(1.0, std::abs(part.value)));
  };
  for (std::size_t k = 0; k < f.variables(); ++k) {
    moves = moves || (x[k].first.value != 0 && reads(f, k));
    add(x[k].value), add(x[k].first), add(x[k].second);
  }
  if (size == 0) return 0;
  if (!moves)
    return along_line(
               f, [&](std::size_t k) { return x[k].value; }, [&](std::size_t k) { return x[k].second; })
        .second.derivative;
  const auto second = [&](double by) {
    const auto at = [by](const Dual& part) { return part.value + by * part.derivative; };
    std::array<Jet, Formula::most_variables> of;
    for (std::size_t k = 0; k < f.variables(); ++k) of[k] = {at(x[k].value), at(x[k].first), at(x[k].second)};
    return f.jet(of.data()).second;
  };
  const double h = 1e-3 / size;
  return (8 * (second(h) - second(-h)) - (second(2 * h) - second(-2 * h))) / (12 * h);
}

/// With the derivatives by what the variables depend on.
template <class T>
JetOf<T> jet_at(const Expression& f, const JetOf<T>* x) {
  if constexpr (std::is_same_v<T, double>) {
    return f.jet(x);
  } else if constexpr (is_pack<T>) {
    JetOf<T> out;
    std::array<Jet, Formula::most_variables> of;
    for (int i = 0; i < T::lanes; ++i) {
      for (std::size_t k = 0; k < f.variables(); ++k) of[k] = {x[k].value[i], x[k].first[i], x[k].second[i]};
      const Jet jet = f.jet(of.data());
      out.value[i] = jet.value;
      out.first[i] = jet.first;
      out.second[i] = jet.second;
    }
    return out;
  } else {
    const auto [value, first] = along_line(
        f, [&](std::size_t k) { return x[k].value; }, [&](std::size_t k) { return x[k].first; });
    std::array<Jet, Formula::most_variables> of;
    for (std::size_t k = 0; k < f.variables(); ++k)
      of[k] = {x[k].value.value, x[k].first.value, x[k].second.value};
    return {value, first, T(f.jet(of.data()).second, derivative_of_second(f, x))};
  }
}
template <class T>
GradientOf<T> gradient_at(const Expression& f, const GradientOf<T>* x) {
  if constexpr (std::is_same_v<T, double>) {
    return f.gradient(x);
  } else if constexpr (is_pack<T>) {
    GradientOf<T> out;
    std::array<Gradient, Formula::most_variables> of;
    for (int i = 0; i < T::lanes; ++i) {
      for (std::size_t k = 0; k < f.variables(); ++k)
        of[k] = {x[k].value[i], x[k].by_first[i], x[k].by_second[i]};
      const Gradient gradient = f.gradient(of.data());
      out.value[i] = gradient.value;
      out.by_first[i] = gradient.by_first;
      out.by_second[i] = gradient.by_second;
    }
    return out;
  } else {
    const auto value = [&](std::size_t k) { return x[k].value; };
    const auto first = along_line(f, value, [&](std::size_t k) { return x[k].by_first; });
    const auto second = along_line(f, value, [&](std::size_t k) { return x[k].by_second; });
    return {first.first, first.second, second.second};
  }
}

}  // namespace mimbre
