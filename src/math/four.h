#pragma once
#include <cstring>
#include <type_traits>

namespace mimbre {

/// Four doubles side by side, with the operators of the language (GCC's and Clang's vector extension). For
/// inner loops that compilers do not see through; lane by lane the bits of doubles.
using Four = double __attribute__((vector_size(4 * sizeof(double))));

inline Four load_four(const double* p) {
  Four v;
  std::memcpy(&v, p, sizeof v);
  return v;
}

inline void store_four(double* p, const Four& v) { std::memcpy(p, &v, sizeof v); }

/// a b + c, rounded once.
inline Four multiply_add(const Four& a, const Four& b, const Four& c) {
  Four out;
  for (int i = 0; i < 4; ++i) out[i] = __builtin_fma(a[i], b[i], c[i]);
  return out;
}

inline Four four_of(double x) { return Four{x, x, x, x}; }

/// out[k] = f(out[k], row) for k < count, a multiple of four: four at a time where they are doubles, whose
/// sums then stay in a register. f finds entry k of a row of numbers or of T by row(first entry), and factors
/// that all entries share by row.all(factor).
template <class T, class F>
void by_lanes(T* out, int count, const F& f) {
  if constexpr (std::is_same_v<T, double>) {
    struct Row {
      int k;
      Four operator()(const double* first) const { return load_four(first + k); }
      Four all(double x) const { return four_of(x); }
    };
    for (int k = 0; k < count; k += 4) store_four(out + k, f(load_four(out + k), Row{k}));
  } else {
    struct Row {
      int k;
      double operator()(const double* first) const { return first[k]; }
      T operator()(const T* first) const { return first[k]; }
      T all(const T& x) const { return x; }
    };
    for (int k = 0; k < count; ++k) out[k] = f(out[k], Row{k});
  }
}

/// The first `count` lanes of a, the others of b.
inline Four first_lanes(int count, const Four& a, const Four& b) {
  using Whole = long long __attribute__((vector_size(sizeof(Four))));
  return Whole{0, 1, 2, 3} < Whole{} + count ? a : b;
}

}  // namespace mimbre
