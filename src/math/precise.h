#pragma once
#include <cmath>

/// Numbers of about 106 bits: unevaluated sums of two doubles (T. J. Dekker, "A floating-point technique for
/// extending the available precision", Numer. Math. 18, 1971). They keep what rounding loses inside the
/// elementary functions.
namespace mimbre {

/// head + tail, where |tail| is at most half the last place of head, unless a function states otherwise.
struct Precise {
  double head, tail;
};

/// a + b where |a| ≥ |b| or a = 0.
inline Precise fast_sum(double a, double b) {
  const double s = a + b;
  return {s, b - (s - a)};
}

/// a + b (D. E. Knuth, The Art of Computer Programming, volume 2, 4.2.2, theorem B).
inline Precise precise_sum(double a, double b) {
  const double s = a + b, of_b = s - a;
  return {s, (a - (s - of_b)) + (b - of_b)};
}

inline Precise precise_product(double a, double b) {
  const double p = a * b;
  return {p, __builtin_fma(a, b, -p)};
}

inline Precise operator-(const Precise& a) { return {-a.head, -a.tail}; }

inline Precise operator+(const Precise& a, const Precise& b) {
  const Precise s = precise_sum(a.head, b.head);
  return fast_sum(s.head, s.tail + (a.tail + b.tail));
}
inline Precise operator-(const Precise& a, const Precise& b) { return a + -b; }

inline Precise operator*(const Precise& a, const Precise& b) {
  const Precise p = precise_product(a.head, b.head);
  return fast_sum(p.head, p.tail + (a.head * b.tail + a.tail * b.head));
}

/// The tail may be larger than half the last place of the head, by little.
inline Precise operator/(const Precise& a, const Precise& b) {
  const double q = a.head / b.head;
  return {q, (__builtin_fma(-q, b.head, a.head) + a.tail - q * b.tail) / b.head};
}

inline Precise precise_root(const Precise& a) {
  const double r = std::sqrt(a.head);
  return {r, r > 0 ? (__builtin_fma(-r, r, a.head) + a.tail) / (2 * r) : 0};
}

/// Whether the processor multiplies and adds in one instruction. WebAssembly does not, and the exact product
/// that takes its place there (cmake/wasm/missing.h) is twenty operations.
#ifdef __wasm__
constexpr bool fused_instruction = false;
#else
constexpr bool fused_instruction = true;
#endif

/// c₀ + c₁ x + … by Horner's rule, each step rounded once; without the fused instruction twice. For small
/// corrections, whose last bits do not reach the result.
template <int n>
double polynomial(const double (&c)[n], double x) {
  double sum = c[n - 1];
  for (int k = n - 2; k >= 0; --k) sum = fused_instruction ? __builtin_fma(sum, x, c[k]) : sum * x + c[k];
  return sum;
}

}  // namespace mimbre
