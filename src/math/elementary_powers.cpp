#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include "math/elementary.h"
#include "math/precise.h"

namespace mimbre {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                 infinity = std::numeric_limits<double>::infinity();
constexpr Precise ln2{0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56};
constexpr Precise per_ln2{0x1.71547652b82fep+0, 0x1.777d0ffda0d24p-56};
constexpr Precise per_ln10{0x1.bcb7b1526e50ep-2, 0x1.95355baaafad3p-57};

/// x 2^k, rounded once; |k| ≤ 2044.
double scaled(double x, int k) {
  const auto power = [](int n) { return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + n) << 52); };
  return x * power(k / 2) * power(k - k / 2);
}

/// e^x = 2^k (1 + more), |more| ≤ 0.42.
struct Exponential {
  int k;
  Precise more;
};

/// Of |x| < 1000. The first difference is exact, as in the reduction of angles; then Taylor's series, its
/// first two terms with their tails.
Exponential exponential(const Precise& x) {
  static constexpr double c[] = {1. / 6,         1. / 24,        1. / 120,         1. / 720,
                                 1. / 5040,      1. / 40320,     1. / 362880,      1. / 3628800,
                                 1. / 39916800., 1. / 479001600, 1. / 6227020800., 1. / 87178291200.};
  const double n = std::nearbyint(x.head * per_ln2.head);
  const Precise r = precise_sum(__builtin_fma(-n, ln2.head, x.head), __builtin_fma(-n, ln2.tail, x.tail));
  const double h = r.head;
  const Precise square = precise_product(h, h), sum = fast_sum(h, 0.5 * square.head);
  const double rest = __builtin_fma(h * square.head, polynomial(c, h), 0.5 * square.tail + r.tail * (1 + h));
  return {static_cast<int>(n), fast_sum(sum.head, sum.tail + rest)};
}

double rounded(const Exponential& e) {
  const Precise one_more = fast_sum(1, e.more.head);
  return scaled(one_more.head + (one_more.tail + e.more.tail), e.k);
}

/// ln(k/32) for k = 23 … 45.
constexpr Precise logs[] = {
    {-0x1.522ae0738a3d8p-2, 0x1.8f7e9b38a6979p-57},  {-0x1.269621134db92p-2, -0x1.e0efadd9db02bp-56},
    {-0x1.f991c6cb3b379p-3, -0x1.f665066f980a2p-57}, {-0x1.a93ed3c8ad9e3p-3, -0x1.bcafa9de97203p-57},
    {-0x1.5bf406b543db2p-3, 0x1.1f5b44c0df7e7p-61},  {-0x1.1178e8227e47cp-3, 0x1.0e63a5f01c691p-58},
    {-0x1.9335e5d594989p-4, 0x1.478a85704ccb7p-58},  {-0x1.08598b59e3a07p-4, 0x1.dd7009902bf32p-58},
    {-0x1.0415d89e74444p-5, -0x1.c05cf1d753622p-59}, {0x0.0p+0, 0x0.0p+0},
    {0x1.f829b0e783300p-6, 0x1.33e3f04f1ef23p-60},   {0x1.f0a30c01162a6p-5, 0x1.85f325c5bbacdp-59},
    {0x1.6f0d28ae56b4cp-4, -0x1.906d99184b992p-58},  {0x1.e27076e2af2e6p-4, -0x1.61578001e0162p-60},
    {0x1.29552f81ff523p-3, 0x1.301771c407dbfp-57},   {0x1.5ff3070a793d4p-3, -0x1.bc60efafc6f6ep-58},
    {0x1.9525a9cf456b4p-3, 0x1.d904c1d4e2e26p-57},   {0x1.c8ff7c79a9a22p-3, -0x1.4f689f8434012p-57},
    {0x1.fb9186d5e3e2bp-3, -0x1.caaae64f21acbp-57},  {0x1.1675cababa60ep-2, 0x1.ce63eab883717p-61},
    {0x1.2e8e2bae11d31p-2, -0x1.8f4cdb95ebdf9p-56},  {0x1.4618bc21c5ec2p-2, 0x1.f42decdeccf1dp-56},
    {0x1.5d1bdbf5809cap-2, 0x1.4236383dc7fe1p-56}};

/// ln x to about 66 bits, of 0 < x < ∞: x = 2^k m, √½ ≤ m < √2, and F the nearest 32nd to m; then
/// ln(m/F) = 2 artanh s of s = (m − F)/(m + F), at most 1/90.
Precise logarithm(Precise x) {
  static constexpr double c[] = {2. / 3, 2. / 5, 2. / 7, 2. / 9, 2. / 11};
  int k = 0;
  if (x.head < 0x1p-1022) {
    x = {x.head * 0x1p54, x.tail * 0x1p54};
    k = -54;
  }
  const auto bits = std::bit_cast<std::uint64_t>(x.head);
  const auto above_root_of_half = static_cast<std::int64_t>(bits - 0x3fe6a09e667f3bcd);
  const int shift = static_cast<int>(above_root_of_half >> 52);
  k += shift;
  const double m = std::bit_cast<double>(bits - (static_cast<std::uint64_t>(shift) << 52));
  const double m_tail = x.tail == 0 ? 0 : scaled(x.tail, -shift);
  const int nearest = static_cast<int>(32 * m + 0.5);
  const double F = nearest / 32., f = m - F;
  Precise sum = fast_sum(2 * F, f);
  sum.tail += m_tail;
  const Precise s = Precise{f, m_tail} / sum;
  const double z = s.head * s.head, rest = __builtin_fma(s.head * z, polynomial(c, z), 2 * s.tail);
  const Precise of_2 = precise_product(k, ln2.head), of_F = logs[nearest - 23];
  const Precise large = fast_sum(of_2.head, of_F.head), all = fast_sum(large.head, 2 * s.head);
  return fast_sum(all.head, all.tail + (large.tail + (of_2.tail + k * ln2.tail + of_F.tail) + rest));
}

double rounded(const Precise& a) { return a.head + a.tail; }

/// Where a logarithm is not a number between −∞ and ∞.
double logarithm_at_the_edge(double x) { return x == 0 ? -infinity : x > 0 ? x : nan; }

/// sinh x/2^… and cosh x/2^… alike: half of e^x and of e^-x, of 0.3 ≤ x ≤ 711, divided by 2^k.
struct Halves {
  int k;
  Precise up, down;
};
Halves halves(double x) {
  const Exponential e = exponential({x, 0});
  const Precise sum = fast_sum(1, e.more.head), up = fast_sum(0.5 * sum.head, 0.5 * (sum.tail + e.more.tail));
  // 1/(4 up) 2^-2k.
  Precise down{0, 0};
  if (e.k < 100) {
    const Precise inverse = Precise{0.25, 0} / up;
    down = {scaled(inverse.head, -2 * e.k), scaled(inverse.tail, -2 * e.k)};
  }
  return {e.k, up, down};
}

/// sinh x of |x| < 0.3.
Precise small_sinh(double x) {
  static constexpr double c[] = {1. / 6, 1. / 120, 1. / 5040, 1. / 362880, 1. / 39916800, 1. / 6227020800.};
  const double s = x * x;
  return fast_sum(x, x * s * polynomial(c, s));
}

}  // namespace

double exp(double x) {
  if (std::isnan(x)) return x;
  return rounded(exponential({std::clamp(x, -760., 720.), 0}));
}

double expm1(double x) {
  if (std::isnan(x) || std::abs(x) < 0x1p-54) return x;
  const Exponential e = exponential({std::clamp(x, -60., 720.), 0});
  if (e.k == 0) return e.more.head + e.more.tail;
  if (e.k > 100) return rounded(e);
  // 2^k + 2^k more − 1.
  const Precise p{scaled(e.more.head, e.k), scaled(e.more.tail, e.k)};
  const Precise whole = precise_sum(scaled(1, e.k), -1), sum = precise_sum(whole.head, p.head);
  return sum.head + (sum.tail + (whole.tail + p.tail));
}

double log(double x) {
  if (!(x > 0 && x < infinity)) return logarithm_at_the_edge(x);
  return rounded(logarithm({x, 0}));
}

double log1p(double x) {
  if (!(x > -1 && x < infinity)) return logarithm_at_the_edge(x + 1);
  if (std::abs(x) < 0x1p-30) return x - 0.5 * x * x;
  return rounded(logarithm(precise_sum(1, x)));
}

double log2(double x) {
  if (!(x > 0 && x < infinity)) return logarithm_at_the_edge(x);
  return rounded(logarithm({x, 0}) * per_ln2);
}

double log10(double x) {
  if (!(x > 0 && x < infinity)) return logarithm_at_the_edge(x);
  return rounded(logarithm({x, 0}) * per_ln10);
}

double pow(double base, double exponent) {
  if (exponent == 0 || base == 1) return 1;
  if (std::isnan(base) || std::isnan(exponent)) return nan;
  const double size = std::abs(base);
  const bool whole = std::floor(exponent) == exponent;
  const bool odd = whole && std::abs(exponent) < 0x1p53 && (static_cast<std::int64_t>(exponent) & 1);
  const double sign = odd && std::signbit(base) ? -1 : 1;
  if (size == 0 || std::isinf(size)) return sign * ((size == 0) == (exponent > 0) ? 0 : infinity);
  if (size == 1 && (base > 0 || whole)) return sign;
  if (std::isinf(exponent)) return (size < 1) == (exponent > 0) ? 0 : infinity;
  if (base < 0 && !whole) return nan;
  const Precise l = logarithm({size, 0}), product = precise_product(exponent, l.head);
  if (!(std::abs(product.head) < 760)) return sign * (product.head < 0 ? 0 : infinity);
  return sign * rounded(exponential({product.head, product.tail + exponent * l.tail}));
}

double cbrt(double x) {
  if (x == 0 || !std::isfinite(x)) return x;
  return std::copysign(rounded(exponential(logarithm({std::abs(x), 0}) / Precise{3, 0})), x);
}

double sinh(double x) {
  const double a = std::abs(x);
  if (std::isnan(x) || a < 0x1p-27) return x;
  if (a < 0.3) return rounded(small_sinh(x));
  const Halves h = halves(std::min(a, 720.));
  return std::copysign(scaled(rounded(h.up - h.down), h.k), x);
}

double cosh(double x) {
  if (std::isnan(x)) return x;
  const Halves h = halves(std::min(std::abs(x), 720.));
  return scaled(rounded(h.up + h.down), h.k);
}

double tanh(double x) {
  const double a = std::abs(x);
  if (std::isnan(x) || a < 0x1p-27) return x;
  const Halves h = halves(std::min(a, 30.));
  // Below 0.3 the power of two is 0 or 1.
  Precise s = h.up - h.down;
  if (a < 0.3) {
    s = small_sinh(a);
    s = {scaled(s.head, -h.k), scaled(s.tail, -h.k)};
  }
  return std::copysign(rounded(s / (h.up + h.down)), x);
}

double asinh(double x) {
  static constexpr double c[] = {-1. / 6, 3. / 40, -5. / 112};
  const double a = std::abs(x), s = a * a;
  if (!std::isfinite(x) || a < 0x1p-27) return x;
  if (a < 0x1p-8) return x + x * s * polynomial(c, s);
  Precise l;
  if (a > 0x1p100) {
    l = logarithm({a, 0}) + ln2;
  } else {
    l = logarithm(precise_root(precise_product(a, a) + Precise{1, 0}) + Precise{a, 0});
  }
  return std::copysign(rounded(l), x);
}

double acosh(double x) {
  if (!(x >= 1)) return nan;
  if (std::isinf(x)) return x;
  if (x > 0x1p100) return rounded(logarithm({x, 0}) + ln2);
  return rounded(logarithm(precise_root(precise_product(x, x) - Precise{1, 0}) + Precise{x, 0}));
}

double atanh(double x) {
  if (!(std::abs(x) <= 1)) return nan;
  if (std::abs(x) == 1) return std::copysign(infinity, x);
  if (std::abs(x) < 0x1p-27) return x;
  const Precise difference = logarithm(precise_sum(1, x)) - logarithm(precise_sum(1, -x));
  return 0.5 * rounded(difference);
}

}  // namespace mimbre
