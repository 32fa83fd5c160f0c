#pragma once
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <string>
#include <system_error>

// What the standard library of emscripten 3.1 lacks of C++20.
#if defined(__EMSCRIPTEN__) && !__has_builtin(__builtin_clear_padding)
#define __builtin_clear_padding(pointer) static_cast<void>(pointer)
#endif
#ifndef __cpp_lib_bit_cast
namespace std {
template <class To, class From>
constexpr To bit_cast(const From& from) noexcept {
  return __builtin_bit_cast(To, from);
}
/// Of decimal numbers, and nearly so: nothing in the page reads texts.
inline from_chars_result from_chars(const char* first, const char* last, double& value) {
  const string text(first, last);
  char* end = nullptr;
  const double read = strtod(text.c_str(), &end);
  if (end == text.c_str()) return {first, errc::invalid_argument};
  value = read;
  return {first + (end - text.c_str()), errc()};
}
}  // namespace std
#endif

// WebAssembly has no fused multiply-add, and the library's function that takes its place makes a step many
// times as long. Kernels take the product and the sum, each rounded; the elementary functions, whose last
// bits rest on it, (MIMBRE_EXACT_PRODUCTS) the product with its error.
namespace mimbre_wasm {

/// a b − p, where p is a b rounded (T. J. Dekker, Numerische Mathematik 18, 1971, 224).
inline double product_error(double a, double b, double p) {
  constexpr double split = 0x1p27 + 1;
  const double a_split = split * a, b_split = split * b;
  const double a_high = a_split - (a_split - a), b_high = b_split - (b_split - b);
  const double a_low = a - a_high, b_low = b - b_high;
  return ((a_high * b_high - p) + a_high * b_low + a_low * b_high) + a_low * b_low;
}

inline double multiply_add(double a, double b, double c) {
  const double p = a * b, sum = p + c;
#ifdef MIMBRE_EXACT_PRODUCTS
  const double of_c = sum - p, rest = ((p - (sum - of_c)) + (c - of_c)) + product_error(a, b, p);
  // Where the parts overflow, there is nothing to add.
  return rest - rest == 0 ? sum + rest : sum;
#else
  return sum;
#endif
}

}  // namespace mimbre_wasm
#define __builtin_fma(a, b, c) (::mimbre_wasm::multiply_add(a, b, c))
