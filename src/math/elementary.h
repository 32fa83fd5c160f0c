#pragma once

/// Elementary functions whose bits do not depend on the machine. Those of the C library do: it picks among
/// variants by the processor (with and without fused multiply-add) and by its own version, and they differ in
/// the last bit for some arguments. These are sums, products, quotients and square roots of doubles, which
/// IEEE 754 defines to the bit, in one order. Angles are in radians.
///
/// Errors, in units of the last place (ulp), are measured against the C library in extended precision by
/// bench/elementary_bench.cpp; no function reaches 0.85 ulp. Special values (infinities, NaN, signed zeros,
/// subnormal numbers, arguments out of the domain) are those of C's Annex F, but no error flag is set.
///
/// What is exact or rounded correctly everywhere (sqrt, abs, floor, round, fmod, remainder, ldexp, fma)
/// stays the standard library's.
namespace mimbre {

double sin(double x);
double cos(double x);
double tan(double x);
double asin(double x);
double acos(double x);
double atan(double x);
double atan2(double y, double x);

double exp(double x);
double expm1(double x);
double log(double x);
double log1p(double x);
double log2(double x);
double log10(double x);
double pow(double base, double exponent);
double cbrt(double x);

double sinh(double x);
double cosh(double x);
double tanh(double x);
double asinh(double x);
double acosh(double x);
double atanh(double x);

double hypot(double x, double y);

}  // namespace mimbre
