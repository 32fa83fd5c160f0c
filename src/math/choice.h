#pragma once

/// Choices by value that kernels make, here for one number; packs of lanes, whose lanes may choose
/// differently, have functions of the same names (math/pack.h).
namespace mimbre {

/// Whether a scalar is a Pack.
template <class T>
inline constexpr bool is_pack = false;

constexpr bool all(bool condition) { return condition; }
constexpr bool any(bool condition) { return condition; }

/// a where the condition holds, otherwise b.
template <class A>
constexpr A select(bool condition, const A& a, const A& b) {
  return condition ? a : b;
}

/// Likewise of two functions without arguments. Evaluates no more than is needed.
template <class F, class G>
auto choose(bool condition, const F& f, const G& g) -> decltype(f()) {
  return condition ? f() : g();
}

}  // namespace mimbre
