#pragma once
#include "math/dual.h"
#include "math/pack.h"

/// Lane by lane: a pack has several, every other scalar one.
namespace mimbre {

template <class T>
constexpr int lane_count = 1;
template <int N>
constexpr int lane_count<Pack<N>> = N;
inline double in_lane(double x, int) { return x; }
inline double in_lane(const Dual& x, int) { return x.value; }
template <int N>
double in_lane(const Pack<N>& x, int lane) {
  return x[lane];
}
template <class T>
void put_in_lane(T& to, const T& x, int lane) {
  if constexpr (is_pack<T>)
    to[lane] = x[lane];
  else
    to = x;
}

}  // namespace mimbre
