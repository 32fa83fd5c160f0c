#pragma once
#include <array>
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

/// A formula of jets with their derivatives by the parameter of dual numbers; `jet_of(k)` is the k-th
/// variable.
template <class JetOfVariable>
JetOf<Dual> varying_jet_at(const Expression& f, const JetOfVariable& jet_of) {
  std::array<VaryingJet, Formula::most_variables> of;
  for (std::size_t k = 0; k < f.variables(); ++k) {
    const JetOf<Dual> x = jet_of(k);
    of[k] = {{x.value.value, x.first.value, x.second.value},
             {x.value.derivative, x.first.derivative, x.second.derivative}};
  }
  const VaryingJet out = f.jet(of.data());
  return {{out.at.value, out.by.value}, {out.at.first, out.by.first}, {out.at.second, out.by.second}};
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
    return varying_jet_at(f,
                          [&](std::size_t k) {
                            return JetOf<Dual>{x[k], Dual(k == variable ? 1 : 0), 0};
                          })
        .first;
  };
  return {by(0), by(1)};
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
    return varying_jet_at(f, [&](std::size_t k) { return x[k]; });
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
    const JetOf<Dual> first = varying_jet_at(f, [&](std::size_t k) {
      return JetOf<Dual>{x[k].value, x[k].by_first, 0};
    });
    const JetOf<Dual> second = varying_jet_at(f, [&](std::size_t k) {
      return JetOf<Dual>{x[k].value, x[k].by_second, 0};
    });
    return {first.value, first.first, second.first};
  }
}

}  // namespace mimbre
