#pragma once
#include "signals/blocks/block.h"

/// A relay with two thresholds: high from `rises_at` on, low from `falls_at` on downwards, between them as
/// before. A continuous one switches at the end of the step in which its input passes a threshold, so that
/// nothing jumps within the iterations of a step; Events ends a part of the step right behind the threshold.
/// A sampled one switches at the instant that sees it.
namespace mimbre::blocks::hysteresis {

constexpr int rises_at = 0, falls_at = 1, low = 2, high = 3, starts_high = 4;  ///< numbers

/// Whether it is high (1 or 0) with its input as it is now.
template <class T>
T decided(const BlockCall<T>& c) {
  const T before = c.begun ? c.before[0] : T(c.numbers[starts_high]);
  return select(c.in[0] >= T(c.numbers[rises_at]), T(1),
                select(c.in[0] <= T(c.numbers[falls_at]), T(0), before));
}

template <class T>
void output(const BlockCall<T>& c) {
  const T is = c.begun && !c.sampled() ? c.before[0] : decided(c);
  c.out[0] = select(is > T(0.5), T(c.numbers[high]), T(c.numbers[low]));
}

template <class T>
void slope(const BlockCall<T>&, T* by) {
  by[0] = T(0);
}

inline bool keep(const BlockCall<double>& c, double* states) {
  const double before = c.begun ? c.before[0] : decided(c), now = decided(c);
  states[0] = now;
  return now != before;
}

}  // namespace mimbre::blocks::hysteresis

namespace mimbre::blocks {

struct Hysteresis {
  static constexpr std::array<LawNumber, 5> numbers{{
      {.key = "rises_at", .about = "from which on it is high"},
      {.key = "falls_at", .about = "down to which it stays high"},
      {.key = "low", .about = "what it gives when it is low", .otherwise = 0},
      {.key = "high", .about = "what it gives when it is high", .otherwise = 1},
      {.key = "starts_high",
       .about = "whether it is high at the start, between the thresholds",
       .otherwise = 0,
       .least = 0,
       .most = 1},
  }};
  static void check(const spec::Block& b, const checks::CheckedItem& item) {
    const std::vector<double>& n = b.numbers;
    if (!(n[hysteresis::falls_at] < n[hysteresis::rises_at]))
      item.error(fmt::format("falls_at is {}, not below rises_at, {}", n[hysteresis::falls_at],
                             n[hysteresis::rises_at]));
  }
  static bool feeds_through(const spec::Block&) { return false; }
  static void compile(const spec::Block& b, const BlockPlan& plan) {
    plan.block.states = 1;
    plan.add_numbers(b.numbers);
  }
  static constexpr BlockInfo info{.name = "hysteresis",
                                  .key = "hysteresis",
                                  .numbers = numbers,
                                  .relay = true,
                                  .check = check,
                                  .feeds_through = feeds_through,
                                  .compile = compile};
  template <class T>
  static constexpr BlockRow<T> row{hysteresis::output<T>, hysteresis::slope<T>, nullptr, hysteresis::keep};
};

}  // namespace mimbre::blocks
