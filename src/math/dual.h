#pragma once
#include <Eigen/Core>
#include <cmath>

#include "math/choice.h"
#include "math/elementary.h"

/// A number with its derivative by one parameter: kernels that run over it give exact derivatives of what
/// they compute. Comparisons are those of the values; what varies not at all has the derivative 0 even where
/// a function is infinitely steep.
namespace mimbre {

struct Dual {
  double value, derivative;

  Dual() = default;
  Dual(double x, double by = 0) : value(x), derivative(by) {}

  friend Dual operator+(const Dual& a, const Dual& b) {
    return {a.value + b.value, a.derivative + b.derivative};
  }
  friend Dual operator-(const Dual& a, const Dual& b) {
    return {a.value - b.value, a.derivative - b.derivative};
  }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.value * b.derivative + a.derivative * b.value};
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const double q = a.value / b.value;
    return {q, (a.derivative - q * b.derivative) / b.value};
  }
  friend Dual operator-(const Dual& a) { return {-a.value, -a.derivative}; }
  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }

  friend bool operator<(const Dual& a, const Dual& b) { return a.value < b.value; }
  friend bool operator>(const Dual& a, const Dual& b) { return a.value > b.value; }
  friend bool operator<=(const Dual& a, const Dual& b) { return a.value <= b.value; }
  friend bool operator>=(const Dual& a, const Dual& b) { return a.value >= b.value; }
  friend bool operator==(const Dual& a, const Dual& b) { return a.value == b.value; }
  friend bool operator!=(const Dual& a, const Dual& b) { return a.value != b.value; }

  /// f(a) of a function whose value and slope at a are these.
  static Dual chain(double f, double slope, const Dual& a) {
    return {f, a.derivative == 0 ? 0 : slope * a.derivative};
  }
  friend Dual sqrt(const Dual& a) {
    const double root = std::sqrt(a.value);
    return chain(root, 0.5 / root, a);
  }
  friend Dual sin(const Dual& a) { return chain(mimbre::sin(a.value), mimbre::cos(a.value), a); }
  friend Dual cos(const Dual& a) { return chain(mimbre::cos(a.value), -mimbre::sin(a.value), a); }
  friend Dual exp(const Dual& a) {
    const double e = mimbre::exp(a.value);
    return chain(e, e, a);
  }
  friend Dual expm1(const Dual& a) { return chain(mimbre::expm1(a.value), mimbre::exp(a.value), a); }
  friend Dual log(const Dual& a) { return chain(mimbre::log(a.value), 1 / a.value, a); }
  friend Dual abs(const Dual& a) {
    return chain(std::abs(a.value), a.value > 0 ? 1 : a.value < 0 ? -1 : 0, a);
  }
  friend Dual round(const Dual& a) { return {std::round(a.value), 0}; }
  friend Dual atan2(const Dual& y, const Dual& x) {
    const double change = x.value * y.derivative - y.value * x.derivative;
    return {mimbre::atan2(y.value, x.value),
            change == 0 ? 0 : change / (x.value * x.value + y.value * y.value)};
  }
  friend Dual pow(const Dual& base, const Dual& exponent) {
    const double b = base.value, e = exponent.value, power = mimbre::pow(b, e);
    const Dual by_base = chain(power, e == 0 ? 0 : e * mimbre::pow(b, e - 1), base);
    return by_base + chain(0, exponent.derivative == 0 ? 0 : power * mimbre::log(b), exponent);
  }
  friend Dual hypot(const Dual& y, const Dual& x) {
    const double length = mimbre::hypot(y.value, x.value),
                 change = x.value * x.derivative + y.value * y.derivative;
    return {length, change == 0 ? 0 : change / length};
  }
  friend bool isfinite(const Dual& a) { return std::isfinite(a.value) && std::isfinite(a.derivative); }
};

}  // namespace mimbre

template <>
struct Eigen::NumTraits<mimbre::Dual> : Eigen::NumTraits<double> {
  using Real = mimbre::Dual;
  using NonInteger = mimbre::Dual;
  using Nested = mimbre::Dual;
  enum {
    RequireInitialization = 0,
    ReadCost = 2,
    AddCost = 2,
    MulCost = 3,
  };
};
