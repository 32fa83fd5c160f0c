#pragma once
#include "math/choice.h"
#include "math/dual.h"
#include "math/pack.h"

/// Sign and size of a number without the jump and the kink at 0: exact from `full` on, smooth to the first
/// derivative everywhere. `full` is above 0.
namespace mimbre::smooth {

/// ±1 from `full` on; 2 r/(1 + r²) with r = x/full below.
template <class T>
T direction(const T& x, const T& full) {
  const T r = x / full, sign = select(r < T(0), T(-1), T(1));
  return select(r * r < T(1), T(T(2) * r / (T(1) + r * r)), sign);
}
/// Its derivative by x.
template <class T>
T direction_slope(const T& x, const T& full) {
  const T r = x / full, square = r * r, below = T(1) + square;
  return select(square < T(1), T(T(2) * (T(1) - square) / (below * below * full)), T(0));
}

/// |x| from `full` on; full (1 + r²)/2 below.
template <class T>
T size(const T& x, const T& full) {
  const T r = x / full, whole = select(x < T(0), T(-x), x);
  return select(r * r < T(1), T(T(0.5) * full * (T(1) + r * r)), whole);
}

}  // namespace mimbre::smooth
