#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>

#include "base/random_numbers.h"
#include "math/elementary.h"
#include "signals/blocks/block.h"

/// White noise that is sampled: of each instant a number of its own, which depends on the seed and on the
/// instant's number alone. So it is the same whatever the steps, the threads, and from where a run went on.
/// Normal numbers are those of Box and Muller's transform.
namespace mimbre::blocks::noise {

constexpr int mean = 0, deviation = 1, seed = 2, uniform = 3;  ///< numbers; uniform: 1 or 0

template <class T>
void output(const BlockCall<T>& c) {
  const auto instant = static_cast<std::int64_t>(std::floor(c.time / c.every + 1e-6));
  const auto of_seed = static_cast<std::uint64_t>(c.numbers[seed]),
             place = 2 * static_cast<std::uint64_t>(instant);
  const double a = uniform_at(of_seed, place), b = uniform_at(of_seed, place + 1);
  const double unit = c.numbers[uniform] > 0.5
                          ? std::numbers::sqrt3 * (2 * a - 1)
                          : std::sqrt(-2 * mimbre::log(a)) * mimbre::cos(2 * std::numbers::pi * b);
  c.out[0] = T(c.numbers[mean] + c.numbers[deviation] * unit);
}

template <class T>
void slope(const BlockCall<T>&, T*) {}

inline bool keep(const BlockCall<double>&, double*) { return false; }

}  // namespace mimbre::blocks::noise

namespace mimbre::blocks {

struct Noise {
  static constexpr std::array<LawNumber, 4> numbers{{
      {.key = "mean", .otherwise = 0},
      {.key = "deviation", .about = "standard deviation", .otherwise = 1, .least = 0},
      {.key = "seed", .about = "a whole number", .otherwise = 0, .least = 0, .most = 9007199254740992.0},
      {.key = "uniform", .about = "1: uniform; 0: normal", .otherwise = 0, .least = 0, .most = 1},
  }};
  static constexpr const char* words[] = {"normal", "uniform"};
  static void check(const spec::Block& b, const checks::CheckedItem& item) {
    if (b.numbers[noise::seed] != std::floor(b.numbers[noise::seed])) item.error("seed is no whole number");
  }
  static constexpr BlockInfo info{.name = "noise",
                                  .key = "noise",
                                  .inputs = 0,
                                  .numbers = numbers,
                                  .words = words,
                                  .continuous = false,
                                  .check = check};
  template <class T>
  static constexpr BlockRow<T> row{noise::output<T>, noise::slope<T>, nullptr, noise::keep};
};

}  // namespace mimbre::blocks
