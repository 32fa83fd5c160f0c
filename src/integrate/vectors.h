#pragma once
#include <algorithm>
#include <cmath>

namespace mimbre {

/// max |x|; not a number counts as 0.
inline double largest(const double* x, int n) {
  double m = 0;
  for (int k = 0; k < n; ++k) m = std::max(m, std::abs(x[k]));
  return m;
}

/// Index of the first value that is not finite, -1 when all are.
inline int find_not_finite(const double* x, int n) {
  for (int k = 0; k < n; ++k)
    if (!std::isfinite(x[k])) return k;
  return -1;
}

}  // namespace mimbre
