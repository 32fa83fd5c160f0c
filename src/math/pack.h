#pragma once
#include <Eigen/Core>
#include <array>
#include <cmath>

#include "math/choice.h"
#include "math/elementary.h"

/// Several numbers that a kernel handles at once as if they were one: each lane is a mechanism of its own.
namespace mimbre {

/// What a comparison of packs gives.
template <int N>
struct Mask {
  std::array<bool, N> lane;

  friend Mask operator&&(const Mask& a, const Mask& b) {
    Mask out;
    for (int i = 0; i < N; ++i) out.lane[i] = a.lane[i] && b.lane[i];
    return out;
  }
  friend Mask operator||(const Mask& a, const Mask& b) {
    Mask out;
    for (int i = 0; i < N; ++i) out.lane[i] = a.lane[i] || b.lane[i];
    return out;
  }
  friend Mask operator!(const Mask& a) {
    Mask out;
    for (int i = 0; i < N; ++i) out.lane[i] = !a.lane[i];
    return out;
  }
  friend bool all(const Mask& a) {
    for (int i = 0; i < N; ++i)
      if (!a.lane[i]) return false;
    return true;
  }
  friend bool any(const Mask& a) { return !all(!a); }
};

template <int N>
struct Pack {
  static constexpr int lanes = N;

  Pack() = default;
  Pack(double x) {
    for (double& l : lane) l = x;
  }
  double& operator[](int i) { return lane[i]; }
  double operator[](int i) const { return lane[i]; }

  friend Pack operator+(const Pack& a, const Pack& b) {
    return each([](double x, double y) { return x + y; }, a, b);
  }
  friend Pack operator-(const Pack& a, const Pack& b) {
    return each([](double x, double y) { return x - y; }, a, b);
  }
  friend Pack operator*(const Pack& a, const Pack& b) {
    return each([](double x, double y) { return x * y; }, a, b);
  }
  friend Pack operator/(const Pack& a, const Pack& b) {
    return each([](double x, double y) { return x / y; }, a, b);
  }
  friend Pack operator-(const Pack& a) {
    return each([](double x) { return -x; }, a);
  }
  Pack& operator+=(const Pack& b) { return *this = *this + b; }
  Pack& operator-=(const Pack& b) { return *this = *this - b; }
  Pack& operator*=(const Pack& b) { return *this = *this * b; }
  Pack& operator/=(const Pack& b) { return *this = *this / b; }

  friend Mask<N> operator<(const Pack& a, const Pack& b) {
    return compare([](double x, double y) { return x < y; }, a, b);
  }
  friend Mask<N> operator>(const Pack& a, const Pack& b) { return b < a; }
  friend Mask<N> operator<=(const Pack& a, const Pack& b) {
    return compare([](double x, double y) { return x <= y; }, a, b);
  }
  friend Mask<N> operator>=(const Pack& a, const Pack& b) { return b <= a; }
  friend Mask<N> operator==(const Pack& a, const Pack& b) {
    return compare([](double x, double y) { return x == y; }, a, b);
  }
  friend Mask<N> operator!=(const Pack& a, const Pack& b) { return !(a == b); }

  friend Pack sqrt(const Pack& a) {
    return each([](double x) { return std::sqrt(x); }, a);
  }
  friend Pack sin(const Pack& a) {
    return each([](double x) { return mimbre::sin(x); }, a);
  }
  friend Pack cos(const Pack& a) {
    return each([](double x) { return mimbre::cos(x); }, a);
  }
  friend Pack exp(const Pack& a) {
    return each([](double x) { return mimbre::exp(x); }, a);
  }
  friend Pack expm1(const Pack& a) {
    return each([](double x) { return mimbre::expm1(x); }, a);
  }
  friend Pack log(const Pack& a) {
    return each([](double x) { return mimbre::log(x); }, a);
  }
  friend Pack abs(const Pack& a) {
    return each([](double x) { return std::abs(x); }, a);
  }
  friend Pack round(const Pack& a) {
    return each([](double x) { return std::round(x); }, a);
  }
  friend Pack atan2(const Pack& y, const Pack& x) {
    return each([](double s, double c) { return mimbre::atan2(s, c); }, y, x);
  }
  friend Pack pow(const Pack& base, const Pack& exponent) {
    return each([](double b, double e) { return mimbre::pow(b, e); }, base, exponent);
  }
  friend Pack hypot(const Pack& y, const Pack& x) {
    return each([](double a, double b) { return mimbre::hypot(a, b); }, y, x);
  }
  friend Mask<N> isfinite(const Pack& a) {
    return compare([](double x, double) { return std::isfinite(x); }, a, a);
  }

  double lane[N];

 private:
  template <class F, class... Packs>
  static Pack each(const F& f, const Packs&... x) {
    Pack out;
    for (int i = 0; i < N; ++i) out.lane[i] = f(x.lane[i]...);
    return out;
  }
  template <class F>
  static Mask<N> compare(const F& f, const Pack& a, const Pack& b) {
    Mask<N> out;
    for (int i = 0; i < N; ++i) out.lane[i] = f(a.lane[i], b.lane[i]);
    return out;
  }
};

template <int N>
inline constexpr bool is_pack<Pack<N>> = true;

template <int N>
Pack<N> select(const Mask<N>& condition, const Pack<N>& a, const Pack<N>& b) {
  Pack<N> out;
  for (int i = 0; i < N; ++i) out[i] = condition.lane[i] ? a[i] : b[i];
  return out;
}
template <int N, int rows, int columns>
Eigen::Matrix<Pack<N>, rows, columns> select(const Mask<N>& condition,
                                             const Eigen::Matrix<Pack<N>, rows, columns>& a,
                                             const Eigen::Matrix<Pack<N>, rows, columns>& b) {
  Eigen::Matrix<Pack<N>, rows, columns> out;
  for (Eigen::Index k = 0; k < out.size(); ++k) out(k) = select(condition, a(k), b(k));
  return out;
}

/// Lane by lane the value of f or of g; only where lanes differ are both evaluated.
template <int N, class F, class G>
auto choose(const Mask<N>& condition, const F& f, const G& g) -> decltype(f()) {
  if (all(condition)) return f();
  if (!any(condition)) return g();
  return select(condition, f(), g());
}

}  // namespace mimbre

template <int N>
struct Eigen::NumTraits<mimbre::Pack<N>> : Eigen::NumTraits<double> {
  using Real = mimbre::Pack<N>;
  using NonInteger = mimbre::Pack<N>;
  using Nested = mimbre::Pack<N>;
  enum {
    RequireInitialization = 0,
    ReadCost = N,
    AddCost = N,
    MulCost = N,
  };
};
