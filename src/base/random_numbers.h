#pragma once
#include <cstdint>

/// Random numbers that depend on a seed and on a place in its sequence alone, so that they are the same in
/// whatever order they are asked for. The bits are those of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014) at
/// places of its sequence.
namespace mimbre {

constexpr std::uint64_t mixed_bits(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31);
}

/// In (0, 1), of the place in the seed's sequence.
inline double uniform_at(std::uint64_t of_seed, std::uint64_t place) {
  constexpr std::uint64_t golden = 0x9e3779b97f4a7c15U;
  const std::uint64_t bits = mixed_bits(mixed_bits(of_seed + golden) + (place + 1) * golden);
  return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
}

}  // namespace mimbre
