#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>

#include "signals/blocks/block.h"

/// White noise that is sampled: of each instant a number of its own, which depends on the seed and on the
/// instant's number alone. So it is the same whatever the steps, the threads, and from where a run went on.
/// The bits are those of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014) at places of its sequence, normal
/// numbers those of Box and Muller's transform.
namespace mimbre::blocks::noise {

constexpr int mean = 0, deviation = 1, seed = 2, uniform = 3;  ///< numbers; uniform: 1 or 0

constexpr std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31);
}

/// In (0, 1), of the place in the seed's sequence.
inline double uniform_at(std::uint64_t of_seed, std::uint64_t place) {
  constexpr std::uint64_t golden = 0x9e3779b97f4a7c15U;
  const std::uint64_t bits = mixed(mixed(of_seed + golden) + (place + 1) * golden);
  return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
}

template <class T>
void output(const BlockCall<T>& c) {
  const auto instant = static_cast<std::int64_t>(std::floor(c.time / c.every + 1e-6));
  const auto of_seed = static_cast<std::uint64_t>(c.numbers[seed]),
             place = 2 * static_cast<std::uint64_t>(instant);
  const double a = uniform_at(of_seed, place), b = uniform_at(of_seed, place + 1);
  const double unit = c.numbers[uniform] > 0.5
                          ? std::numbers::sqrt3 * (2 * a - 1)
                          : std::sqrt(-2 * std::log(a)) * std::cos(2 * std::numbers::pi * b);
  c.out[0] = T(c.numbers[mean] + c.numbers[deviation] * unit);
}

template <class T>
void slope(const BlockCall<T>&, T*) {}

inline bool keep(const BlockCall<double>&, double*) { return false; }

}  // namespace mimbre::blocks::noise
