#pragma once
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "math/elementary.h"

/// How far the elementary functions are from the C library's in extended precision, which has eleven bits
/// more and shares no code with them.
namespace mimbre::test {

/// |value − exact| in units of double's last place at `exact`; infinite where only one of both is a number.
inline double error_in_ulp(double value, long double exact) {
  if (std::isnan(value) && std::isnan(exact)) return 0;
  if (static_cast<double>(exact) == value && std::isinf(value)) return 0;
  if (!std::isfinite(value) || !std::isfinite(exact)) return HUGE_VAL;
  int exponent = 0;
  std::frexp(exact, &exponent);
  return static_cast<double>(std::abs(value - exact) / std::ldexp(1.0L, std::max(exponent - 53, -1074)));
}

enum class Spread { even, by_size, by_positive_size };

/// A function with its namesake in extended precision. Arguments lie evenly between the limits, or their
/// sizes are two to the power of such numbers, with both signs or one.
struct Tried {
  const char* name;
  double (*function)(double);
  long double (*exact)(long double);
  Spread spread;
  double low, high;
};
struct TriedPair {
  const char* name;
  double (*function)(double, double);
  long double (*exact)(long double, long double);
  double low[2], high[2];
};

inline const std::vector<Tried>& tried() {
  using enum Spread;
  static const std::vector<Tried> all{
      {"sin", sin, sinl, even, -7, 7},
      {"sin", sin, sinl, by_size, -40, 1023.9},
      {"cos", cos, cosl, even, -7, 7},
      {"cos", cos, cosl, by_size, -40, 1023.9},
      {"tan", tan, tanl, even, -7, 7},
      {"tan", tan, tanl, by_size, -40, 1023.9},
      {"asin", asin, asinl, even, -1, 1},
      {"asin", asin, asinl, by_size, -60, 0},
      {"acos", acos, acosl, even, -1, 1},
      {"acos", acos, acosl, by_size, -60, 0},
      {"atan", atan, atanl, even, -2, 2},
      {"atan", atan, atanl, by_size, -60, 60},
      {"exp", exp, expl, even, -1, 1},
      {"exp", exp, expl, even, -745.2, 709.8},
      {"expm1", expm1, expm1l, even, -1.5, 1.5},
      {"expm1", expm1, expm1l, by_size, -60, 9.4},
      {"log", log, logl, even, 0.5, 2},
      {"log", log, logl, by_positive_size, -1074, 1023.9},
      {"log1p", log1p, log1pl, even, -0.9999, 2},
      {"log1p", log1p, log1pl, by_size, -70, -0.001},
      {"log2", log2, log2l, even, 0.5, 2},
      {"log2", log2, log2l, by_positive_size, -1074, 1023.9},
      {"log10", log10, log10l, even, 0.5, 2},
      {"log10", log10, log10l, by_positive_size, -1074, 1023.9},
      {"cbrt", cbrt, cbrtl, by_size, -1074, 1023.9},
      {"sinh", sinh, sinhl, even, -2, 2},
      {"sinh", sinh, sinhl, by_size, -30, 9.46},
      {"cosh", cosh, coshl, even, -2, 2},
      {"cosh", cosh, coshl, by_size, -30, 9.46},
      {"tanh", tanh, tanhl, even, -2, 2},
      {"tanh", tanh, tanhl, by_size, -30, 6},
      {"asinh", asinh, asinhl, even, -2, 2},
      {"asinh", asinh, asinhl, by_size, -30, 1023.9},
      {"acosh", acosh, acoshl, even, 1, 3},
      {"acosh", acosh, acoshl, by_positive_size, 0, 1023.9},
      {"atanh", atanh, atanhl, even, -1, 1},
      {"atanh", atanh, atanhl, by_size, -30, 0},
  };
  return all;
}

inline const std::vector<TriedPair>& tried_pairs() {
  static const std::vector<TriedPair> all{
      {"atan2", atan2, atan2l, {-1, -1}, {1, 1}},
      {"atan2", atan2, atan2l, {-1e-300, -1}, {1e-300, 1}},
      {"hypot", hypot, hypotl, {-1, -1}, {1, 1}},
      {"hypot", hypot, hypotl, {-1e-160, -1e-163}, {1e-160, 1e-163}},
      {"hypot", hypot, hypotl, {-1e300, -5e307}, {1e300, 5e307}},
      {"pow", pow, powl, {0.2, -3}, {5, 3}},
      {"pow", pow, powl, {0, -40}, {1e6, 40}},
      {"pow", pow, powl, {0.999, -7e5}, {1.001, 7e5}},
  };
  return all;
}

/// The largest error, in ulp, of so many random arguments.
inline double largest_error(const Tried& f, int count) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> within(f.low, f.high);
  double most = 0;
  for (int k = 0; k < count; ++k) {
    double x = within(random);
    if (f.spread != Spread::even) x = std::exp2(x) * (f.spread == Spread::by_size && k % 2 == 1 ? -1 : 1);
    most = std::max(most, error_in_ulp(f.function(x), f.exact(static_cast<long double>(x))));
  }
  return most;
}
inline double largest_error(const TriedPair& f, int count) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> first(f.low[0], f.high[0]), second(f.low[1], f.high[1]);
  double most = 0;
  for (int k = 0; k < count; ++k) {
    const double x = first(random), y = second(random);
    most = std::max(most, error_in_ulp(f.function(x, y), f.exact(x, y)));
  }
  return most;
}

}  // namespace mimbre::test
