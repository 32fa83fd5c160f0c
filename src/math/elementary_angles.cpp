#include <bit>
#include <cstdint>
#include <limits>

#include "math/elementary.h"
#include "math/precise.h"

namespace mimbre {
namespace {

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

/// π/2 = the sum of three doubles, to 160 bits.
constexpr double half_pi[] = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54, -0x1.f1976b7ed8fbcp-110};
constexpr Precise right_angle{half_pi[0], half_pi[1]}, straight_angle{2 * half_pi[0], 2 * half_pi[1]};

/// x = quadrant π/2 + angle, |angle| ≤ π/4 but for round-off; the quadrant modulo 4.
struct Reduced {
  unsigned quadrant;
  Precise angle;
};

/// 2/π in binary, 64 bits behind the point a word, behind a word of zeros.
constexpr std::uint64_t two_over_pi[] = {0,
                                         0xa2f9836e4e441529,
                                         0xfc2757d1f534ddc0,
                                         0xdb6295993c439041,
                                         0xfe5163abdebbc561,
                                         0xb7246e3a424dd2e0,
                                         0x06492eea09d1921c,
                                         0xfe1deb1cb129a73e,
                                         0xe88235f52ebb4484,
                                         0xe99c7026b45f7e41,
                                         0x3991d639835339f4,
                                         0x9c845f8bbdf9283b,
                                         0x1ff897ffde05980f,
                                         0xef2f118b5a0a6d1f,
                                         0x6d367ecf27cb09b7,
                                         0x4f463f669e5fea2d,
                                         0x7527bac7ebe5f17b,
                                         0x3d0739f78a5292ea,
                                         0x6bfb5fb11f8d5d08,
                                         0x56033046fc7b6bab,
                                         0xf0cfbc209af4361d};

/// Of x ≥ 2^40: only those bits of 2/π enter that do not make multiples of a full turn (M. Payne, R. Hanek,
/// "Radian reduction for trigonometric functions", SIGNUM Newsletter 18, 1983). x = m 2^e with whole m.
Reduced reduce_large(double x) {
  __extension__ using Wide = unsigned __int128;
  __extension__ using Signed = __int128;
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const int e = static_cast<int>(bits >> 52) - 1075, first = 64 + e - 2, word = first / 64,
            shift = first % 64;
  const std::uint64_t m = (bits & 0xfffffffffffff) | 0x10000000000000;
  // 192 bits of 2/π from the one whose product with x's last bit is 2.
  std::uint64_t w[3];
  for (int k = 0; k < 3; ++k) {
    w[k] = two_over_pi[word + k] << shift;
    if (shift > 0) w[k] |= two_over_pi[word + k + 1] >> (64 - shift);
  }
  // x 2/π, in fourths of a turn: two bits before the point, 190 behind it.
  const Wide low = Wide(m) * w[2], middle = Wide(m) * w[1] + static_cast<std::uint64_t>(low >> 64);
  const std::uint64_t high = m * w[0] + static_cast<std::uint64_t>(middle >> 64);
  const Wide turn = (Wide(high) << 64) | static_cast<std::uint64_t>(middle);
  const Wide behind = (turn << 2) | (static_cast<std::uint64_t>(low) >> 62);
  // Behind the point 128 bits; from a half on it counts from the next quadrant.
  const auto rest = static_cast<Signed>(behind);
  const unsigned quadrant = static_cast<unsigned>(turn >> 126) + (rest < 0 ? 1 : 0);
  const double head = static_cast<double>(rest), tail = static_cast<double>(rest - static_cast<Signed>(head));
  return {quadrant % 4, Precise{0x1p-128 * head, 0x1p-128 * tail} * right_angle};
}

/// x − n π/2. The first difference is exact: it is below 1 and a multiple of the last places of both (W. J.
/// Cody, W. Waite, Software Manual for the Elementary Functions, 1980, in fused arithmetic).
Reduced reduce(double x) {
  if (std::abs(x) < 0.78) return {0, {x, 0}};
  if (!(std::abs(x) < 0x1p40)) {
    if (!std::isfinite(x)) return {0, {undefined, undefined}};
    Reduced r = reduce_large(std::abs(x));
    if (x < 0) r = {(4 - r.quadrant) % 4, -r.angle};
    return r;
  }
  const double n = std::nearbyint(x * (1 / half_pi[0])), first = __builtin_fma(-n, half_pi[0], x);
  const Precise second = precise_product(n, half_pi[1]), difference = precise_sum(first, -second.head);
  return {static_cast<unsigned>(static_cast<std::int64_t>(n) & 3),
          fast_sum(difference.head, difference.tail - second.tail - n * half_pi[2])};
}

// Taylor's series: up to π/4 what is left out is below 2^-60.

Precise sine(const Precise& x) {
  static constexpr double c[] = {
      -1. / 6,        1. / 120,         -1. / 5040,           1. / 362880,
      -1. / 39916800, 1. / 6227020800., -1. / 1307674368000., 1. / 355687428096000.};
  const double h = x.head, s = h * h;
  return fast_sum(h, __builtin_fma(h * s, polynomial(c, s), x.tail * (1 - 0.5 * s)));
}
Precise cosine(const Precise& x) {
  static constexpr double c[] = {1. / 24,        -1. / 720,          1. / 40320,          -1. / 3628800,
                                 1. / 479001600, -1. / 87178291200., 1. / 20922789888000.};
  const double h = x.head;
  const Precise square = precise_product(h, h), most = fast_sum(1, -0.5 * square.head);
  const double s = square.head,
               rest = __builtin_fma(s * s, polynomial(c, s), -0.5 * square.tail - h * x.tail);
  return fast_sum(most.head, most.tail + rest);
}

/// arctan(k/16).
constexpr Precise arc[] = {{0x0.0p+0, 0x0.0p+0},
                           {0x1.ff55bb72cfdeap-5, -0x1.c934d86d23f1dp-60},
                           {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
                           {0x1.7b97b4bce5b02p-3, 0x1.347b0b4f881cap-58},
                           {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
                           {0x1.362773707ebccp-2, -0x1.963a544b672d8p-57},
                           {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
                           {0x1.a64eec3cc23fdp-2, -0x1.24dec1b50b7ffp-56},
                           {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
                           {0x1.0657e94db30d0p-1, -0x1.d5b495f6349e6p-56},
                           {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
                           {0x1.345f01cce37bbp-1, 0x1.1021137c71102p-55},
                           {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
                           {0x1.5d58987169b18p-1, 0x1.0028e4bc5e7cap-57},
                           {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
                           {0x1.819d0b7158a4dp-1, -0x1.bf76229d3b917p-56},
                           {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55}};

/// arctan z = arctan c + arctan((z − c)/(1 + c z)) for 0 ≤ z ≤ 1, where c is the nearest sixteenth; the
/// series runs over at most 1/32.
Precise arc_tangent(const Precise& z) {
  static constexpr double coefficients[] = {-1. / 3, 1. / 5, -1. / 7, 1. / 9, -1. / 11, 1. / 13};
  const int k = static_cast<int>(16 * z.head + 0.5);
  Precise t = z;
  if (k > 0) {
    const double c = k / 16., below = __builtin_fma(c, z.head, 1);
    t = Precise{z.head - c, z.tail} / Precise{below, __builtin_fma(c, z.head, 1 - below) + c * z.tail};
  }
  const double s = t.head * t.head,
               rest = __builtin_fma(t.head * s, polynomial(coefficients, s), t.tail * (1 - s));
  const Precise sum = fast_sum(arc[k].head, t.head);
  return fast_sum(sum.head, sum.tail + (arc[k].tail + rest));
}

/// Of a point (x, |y|) in the plane, from 0 to π. Not both are zero or infinite.
double angle_of(Precise x, const Precise& y) {
  const bool left = std::signbit(x.head);
  if (left) x = -x;
  const bool steep = y.head > x.head;
  Precise a = arc_tangent(steep ? x / y : y / x);
  if (steep) a = right_angle - a;
  if (left) a = straight_angle - a;
  return a.head + a.tail;
}

/// √(1 − x²).
Precise other_leg(double x) {
  const Precise square = precise_product(x, x), rest = precise_sum(1, -square.head);
  return precise_root(fast_sum(rest.head, rest.tail - square.tail));
}

}  // namespace

double sin(double x) {
  if (std::abs(x) < 0x1p-27) return x;
  const Reduced r = reduce(x);
  const double s = r.quadrant & 1 ? cosine(r.angle).head : sine(r.angle).head;
  return r.quadrant & 2 ? -s : s;
}

double cos(double x) {
  const Reduced r = reduce(x);
  const double c = r.quadrant & 1 ? sine(r.angle).head : cosine(r.angle).head;
  return (r.quadrant + 1) & 2 ? -c : c;
}

double tan(double x) {
  if (std::abs(x) < 0x1p-27) return x;
  const Reduced r = reduce(x);
  const Precise s = sine(r.angle), c = cosine(r.angle), t = r.quadrant & 1 ? -c / s : s / c;
  return t.head + t.tail;
}

double atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return undefined;
  double a = std::abs(y), b = x;
  if (a == 0) return std::copysign(std::signbit(x) ? straight_angle.head : 0, y);
  if (std::isinf(a) || std::isinf(b)) {
    // Only the direction counts.
    a = std::isinf(a) ? 1 : 0;
    b = std::copysign(std::isinf(b) ? 1 : 0, b);
  } else if (std::abs(b) < 0x1p-900 && a < 0x1p-900) {
    // Lest the quotient's remainder is lost.
    a *= 0x1p120;
    b *= 0x1p120;
  }
  return std::copysign(angle_of({b, 0}, {a, 0}), y);
}

double atan(double x) {
  if (std::isnan(x)) return x;
  if (std::abs(x) < 0x1p-27) return x;
  return atan2(x, 1);
}

double asin(double x) {
  if (!(std::abs(x) <= 1)) return undefined;
  if (std::abs(x) < 0x1p-27) return x;
  return std::copysign(angle_of(other_leg(x), {std::abs(x), 0}), x);
}

double acos(double x) {
  if (!(std::abs(x) <= 1)) return undefined;
  return angle_of({x, 0}, other_leg(x));
}

double hypot(double x, double y) {
  if (std::isinf(x) || std::isinf(y)) return std::numeric_limits<double>::infinity();
  if (std::isnan(x) || std::isnan(y)) return undefined;
  double a = std::abs(x), b = std::abs(y), unit = 1;
  if (a < b) {
    const double c = a;
    a = b;
    b = c;
  }
  // Squares neither overflow nor lose digits.
  if (a > 0x1p500) unit = 0x1p600;
  if (b < 0x1p-400 && a < 0x1p-300) unit = 0x1p-600;
  a /= unit;
  b /= unit;
  const Precise first = precise_product(a, a), second = precise_product(b, b);
  const Precise root = precise_root(first + second);
  return (root.head + root.tail) * unit;
}

}  // namespace mimbre
