#pragma once
#include <cmath>

#include "mimbre/function.h"

/// Numbers that carry derivatives, so that a formula gives them exactly.
namespace mimbre {

/// What a function of one number is there: f, f' and f''.
struct Taylor {
  double f = 0, f1 = 0, f2 = 0;
};

/// The factor times a derivative, which is 0 where nothing varies, however steep the function is there.
inline double along(double factor, double derivative) { return derivative == 0 ? 0 : factor * derivative; }

/// f of x, by the chain rule.
inline Jet chain(const Taylor& t, const Jet& x) {
  return {t.f, along(t.f1, x.first), along(t.f2, x.first * x.first) + along(t.f1, x.second)};
}
inline Gradient chain(const Taylor& t, const Gradient& x) {
  return {t.f, along(t.f1, x.by_first), along(t.f1, x.by_second)};
}

inline Jet operator+(const Jet& a, const Jet& b) {
  return {a.value + b.value, a.first + b.first, a.second + b.second};
}
inline Jet operator-(const Jet& a, const Jet& b) {
  return {a.value - b.value, a.first - b.first, a.second - b.second};
}
inline Jet operator-(const Jet& a) { return {-a.value, -a.first, -a.second}; }
inline Jet operator*(const Jet& a, const Jet& b) {
  return {a.value * b.value, along(a.value, b.first) + along(b.value, a.first),
          along(a.value, b.second) + 2 * (a.first * b.first) + along(b.value, a.second)};
}
inline Jet operator/(const Jet& a, const Jet& b) {
  const double q = a.value / b.value, q1 = (a.first - along(q, b.first)) / b.value;
  return {q, q1, (a.second - 2 * along(q1, b.first) - along(q, b.second)) / b.value};
}

inline Gradient operator+(const Gradient& a, const Gradient& b) {
  return {a.value + b.value, a.by_first + b.by_first, a.by_second + b.by_second};
}
inline Gradient operator-(const Gradient& a, const Gradient& b) {
  return {a.value - b.value, a.by_first - b.by_first, a.by_second - b.by_second};
}
inline Gradient operator-(const Gradient& a) { return {-a.value, -a.by_first, -a.by_second}; }
inline Gradient operator*(const Gradient& a, const Gradient& b) {
  return {a.value * b.value, along(a.value, b.by_first) + along(b.value, a.by_first),
          along(a.value, b.by_second) + along(b.value, a.by_second)};
}
inline Gradient operator/(const Gradient& a, const Gradient& b) {
  const double q = a.value / b.value;
  return {q, (a.by_first - along(q, b.by_first)) / b.value, (a.by_second - along(q, b.by_second)) / b.value};
}

inline bool varies(const Jet& x) { return x.first != 0 || x.second != 0; }
inline bool varies(const Gradient& x) { return x.by_first != 0 || x.by_second != 0; }

/// The mean of derivatives where two branches meet: that of a kink.
inline Jet mean(const Jet& a, const Jet& b) {
  return {a.value, 0.5 * (a.first + b.first), 0.5 * (a.second + b.second)};
}
inline Gradient mean(const Gradient& a, const Gradient& b) {
  return {a.value, 0.5 * (a.by_first + b.by_first), 0.5 * (a.by_second + b.by_second)};
}

inline void set_constant(double& x, double value) { x = value; }
inline void set_constant(Jet& x, double value) { x = {value, 0, 0}; }
inline void set_constant(Gradient& x, double value) { x = {value, 0, 0}; }

inline double value_of(double x) { return x; }
inline double value_of(const Jet& x) { return x.value; }
inline double value_of(const Gradient& x) { return x.value; }

}  // namespace mimbre
