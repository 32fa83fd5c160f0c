#pragma once
#include <Eigen/Core>
#include <cmath>

namespace mimbre {

/// A number of any kind T with its derivative by one parameter, for formulas of +, −, ·, / and √ (Dual, of
/// doubles, knows more).
template <class T>
struct Forward {
  T value, by;

  Forward() = default;
  Forward(const T& x, const T& derivative = T(0)) : value(x), by(derivative) {}

  friend Forward operator+(const Forward& a, const Forward& b) { return {a.value + b.value, a.by + b.by}; }
  friend Forward operator-(const Forward& a, const Forward& b) { return {a.value - b.value, a.by - b.by}; }
  friend Forward operator*(const Forward& a, const Forward& b) {
    return {a.value * b.value, a.value * b.by + a.by * b.value};
  }
  friend Forward operator/(const Forward& a, const Forward& b) {
    const T q = a.value / b.value;
    return {q, (a.by - q * b.by) / b.value};
  }
  friend Forward operator-(const Forward& a) { return {-a.value, -a.by}; }
  Forward& operator+=(const Forward& b) { return *this = *this + b; }
  Forward& operator-=(const Forward& b) { return *this = *this - b; }
  Forward& operator*=(const Forward& b) { return *this = *this * b; }
  Forward& operator/=(const Forward& b) { return *this = *this / b; }
  friend Forward sqrt(const Forward& a) {
    using std::sqrt;
    const T root = sqrt(a.value);
    return {root, a.by / (T(2) * root)};
  }
};

}  // namespace mimbre

template <class T>
struct Eigen::NumTraits<mimbre::Forward<T>> : Eigen::NumTraits<double> {
  using Real = mimbre::Forward<T>;
  using NonInteger = mimbre::Forward<T>;
  using Nested = mimbre::Forward<T>;
  enum {
    RequireInitialization = 0,
    ReadCost = 2,
    AddCost = 2,
    MulCost = 3,
  };
};
