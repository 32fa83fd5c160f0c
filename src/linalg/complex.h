#pragma once
#include <cmath>

namespace mimbre::linalg {

/// A complex number for factorisations: products and quotients without the care of std::complex for what is
/// infinite.
struct Complex {
  double re = 0, im = 0;
  constexpr Complex() = default;
  constexpr explicit(false) Complex(double real, double imaginary = 0) : re(real), im(imaginary) {}

  Complex operator-() const { return {-re, -im}; }
  Complex& operator+=(const Complex& b) { return *this = {re + b.re, im + b.im}; }
  Complex& operator-=(const Complex& b) { return *this = {re - b.re, im - b.im}; }
};

inline Complex operator+(const Complex& a, const Complex& b) { return {a.re + b.re, a.im + b.im}; }
inline Complex operator-(const Complex& a, const Complex& b) { return {a.re - b.re, a.im - b.im}; }
inline Complex operator*(const Complex& a, const Complex& b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
inline Complex operator/(const Complex& a, const Complex& b) {
  const double square = b.re * b.re + b.im * b.im;
  return {(a.re * b.re + a.im * b.im) / square, (a.im * b.re - a.re * b.im) / square};
}

/// Whether a pivot of this inverse can be divided by (BlockFactor).
inline bool usable_inverse(Complex& inverse) {
  return (inverse.re != 0 || inverse.im != 0) && std::isfinite(inverse.re) && std::isfinite(inverse.im);
}

}  // namespace mimbre::linalg
