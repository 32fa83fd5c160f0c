#pragma once
#include <cstring>

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

/// The first `count` lanes of a, the others of b.
inline Four first_lanes(int count, const Four& a, const Four& b) {
  using Whole = long long __attribute__((vector_size(sizeof(Four))));
  return Whole{0, 1, 2, 3} < Whole{} + count ? a : b;
}

}  // namespace mimbre
