#pragma once
#include "signals/blocks/block.h"

/// Follows its input u no faster than it may: y₁ = u₁ within [y₀ + falling h, y₀ + rising h]. It begins where
/// its input is.
namespace mimbre::blocks::rate_limit {

constexpr int rising = 0, falling = 1;  ///< numbers, per s; falling < 0

template <class T>
void output(const BlockCall<T>& c) {
  if (!c.begun) {
    c.out[0] = c.in[0];
    return;
  }
  const T least = c.before[0] + c.numbers[falling] * c.h, most = c.before[0] + c.numbers[rising] * c.h;
  c.out[0] = select(c.in[0] > most, most, select(c.in[0] < least, least, c.in[0]));
}

template <class T>
void slope(const BlockCall<T>& c, T* by) {
  by[0] = T(1);
  if (!c.begun) return;
  const T least = c.before[0] + c.numbers[falling] * c.h, most = c.before[0] + c.numbers[rising] * c.h;
  by[0] = select((c.in[0] > most) || (c.in[0] < least), T(0), T(1));
}

inline bool keep(const BlockCall<double>& c, double* states) {
  BlockCall<double> of = c;
  of.out = states;  // read before it is written
  output(of);
  return false;
}

}  // namespace mimbre::blocks::rate_limit

namespace mimbre::blocks {

struct RateLimit {
  static constexpr std::array<LawNumber, 2> numbers{{
      {.key = "rising", .about = "largest rate upwards, per s", .above = 0},
      {.key = "falling", .about = "largest rate downwards, per s, below 0", .most = -1e-300},
  }};
  /// As fast downwards as upwards.
  static void complete(std::vector<double>& n) {
    if (std::isnan(n[rate_limit::falling])) n[rate_limit::falling] = -n[rate_limit::rising];
  }
  static void compile(const spec::Block& b, const BlockPlan& plan) {
    plan.block.states = 1;
    plan.add_numbers(b.numbers);
  }
  static constexpr BlockInfo info{.name = "rate_limit",
                                  .key = "rate_limit",
                                  .numbers = numbers,
                                  .complete = complete,
                                  .compile = compile};
  template <class T>
  static constexpr BlockRow<T> row{rate_limit::output<T>, rate_limit::slope<T>, nullptr, rate_limit::keep};
};

}  // namespace mimbre::blocks
