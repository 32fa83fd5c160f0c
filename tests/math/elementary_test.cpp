#include "math/elementary.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/hash64.h"
#include "support/elementary_error.h"

namespace mimbre::test::elementary_test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(Elementary, IsWithinOneUnitOfTheLastPlace) {
  for (const Tried& f : tried())
    EXPECT_LT(largest_error(f, 4000), 0.85) << f.name << " from " << f.low << " to " << f.high;
  for (const TriedPair& f : tried_pairs())
    EXPECT_LT(largest_error(f, 4000), 0.85) << f.name << " from " << f.low[0] << ", " << f.low[1];
}

/// Doubles that lie closest to multiples of π/2, where all digits of a bad reduction cancel (J.-M. Muller,
/// Elementary Functions, 11.3), and both sides of the limit between the two reductions.
TEST(Elementary, ReducesAnglesWhereTheyCancelMost) {
  for (const double x :
       {0x1.6ac5b262ca1ffp+849, 0x1.921fb54442d18p+0, 0x1.921fb54442d18p+1, 0x1.6c6cbc45dc8dep+5,
        0x1.fffffffffffffp+39, 0x1p+40, 0x1.0000000000001p+40, 1e22, 0x1.fffffffffffffp+1023})
    for (const double sign : {1., -1.}) {
      EXPECT_LT(error_in_ulp(sin(sign * x), sinl(sign * x)), 0.85) << x;
      EXPECT_LT(error_in_ulp(cos(sign * x), cosl(sign * x)), 0.85) << x;
      EXPECT_LT(error_in_ulp(tan(sign * x), tanl(sign * x)), 0.85) << x;
    }
}

/// C's Annex F, as the C library has it: signs of zeros, infinities, arguments outside the domain.
TEST(Elementary, HasTheSpecialValuesOfTheCLibrary) {
  const double special[] = {0,
                            1,
                            0.5,
                            2,
                            3,
                            1.5,
                            infinity,
                            5e-324,
                            1e-310,
                            0x1p53,
                            711,
                            1000,
                            709.78,
                            709.79,
                            745.13,
                            745.134,
                            1e300,
                            0x1p-54,
                            9007199254740993.,
                            std::numeric_limits<double>::quiet_NaN(),
                            std::numeric_limits<double>::max(),
                            1 + std::numeric_limits<double>::epsilon(),
                            1 - std::numeric_limits<double>::epsilon() / 2};
  const auto same = [](double a, double b) {
    return std::isnan(a) ? std::isnan(b) : std::signbit(a) == std::signbit(b) && error_in_ulp(a, b) <= 1;
  };
  for (const double size : special)
    for (const double x : {size, -size}) {
      const auto check = [&](const char* name, double own, long double exact) {
        EXPECT_TRUE(same(own, static_cast<double>(exact)))
            << name << '(' << x << ") = " << own << ", not " << static_cast<double>(exact);
      };
      for (const Tried& f : tried()) check(f.name, f.function(x), f.exact(static_cast<long double>(x)));
      for (const double other : special)
        for (const double y : {other, -other})
          for (const TriedPair& f : tried_pairs())
            check(fmt::format("{} with {}", f.name, y).c_str(), f.function(x, y), f.exact(x, y));
    }
}

TEST(Elementary, IsExactWhereTheResultIsADouble) {
  for (int k = -20; k <= 20; ++k) {
    EXPECT_EQ(log2(std::ldexp(1, k)), k);
    EXPECT_EQ(pow(2, k), std::ldexp(1, k));
    EXPECT_EQ(cbrt(k * k * k), k);
  }
  double ten = 1;
  for (int k = 0; k <= 22; ++k, ten *= 10) {
    EXPECT_EQ(pow(10, k), ten);
    EXPECT_EQ(log10(ten), k);
  }
  EXPECT_EQ(pow(1.5, 4), 5.0625);
  EXPECT_EQ(hypot(0x3p650, 0x4p650), 0x5p650);
  EXPECT_EQ(exp(0), 1);
}

/// Recorded on one machine, the same on all: with and without fused multiply-add, with every C library.
TEST(Elementary, HasTheSameBitsOnEveryMachine) {
  Hash64 hash;
  std::uint64_t seed = 1;
  // Numbers of all sizes by Marsaglia's xorshift; the standard library's generators use logarithms of its
  // own.
  const auto next = [&] {
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return static_cast<double>(seed >> 11) * 0x1p-53;
  };
  const auto limited = [&](double low, double high) { return low + (high - low) * next(); };
  const auto add = [&](double x) { hash.add(std::isnan(x) ? 0.5 : x); };
  for (const Tried& f : tried())
    for (int k = 0; k < 300; ++k) {
      const double x = limited(f.low, f.high);
      const int whole = static_cast<int>(std::floor(x));
      add(f.function(f.spread == Spread::even ? x : std::ldexp(1 + (x - whole), whole)));
    }
  for (const TriedPair& f : tried_pairs())
    for (int k = 0; k < 300; ++k) {
      const double x = limited(f.low[0], f.high[0]), y = limited(f.low[1], f.high[1]);
      add(f.function(x, y));
    }
  EXPECT_EQ(fmt::format("{:016x}", hash.value()), "f4f114752879b4aa");
}

}  // namespace
}  // namespace mimbre::test::elementary_test
