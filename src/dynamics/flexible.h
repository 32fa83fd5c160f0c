#pragma once
#include <algorithm>

#include "compile/compiled.h"
#include "dynamics/motion.h"
#include "math/four.h"
#include "math/multiply_add.h"

/// Kernels of flexible bodies over padded rows of mode values (see FlexibleData): dot products, y-dependent
/// integrals.
namespace mimbre {

/// Σ_k row[k] y[k] over the padded length, in eight partial sums so that it vectorises in a fixed order.
template <class A, class T>
T dot(const A* row, const T* y, int stride) {
  if constexpr (std::is_same_v<A, double> && std::is_same_v<T, double>) {
    Four low = load_four(row) * load_four(y), high = load_four(row + 4) * load_four(y + 4);
    for (int k = 8; k < stride; k += 8) {
      low = multiply_add(load_four(row + k), load_four(y + k), low);
      high = multiply_add(load_four(row + k + 4), load_four(y + k + 4), high);
    }
    const Four p = low + high;
    return (p[0] + p[2]) + (p[1] + p[3]);
  }
  T p[8];
  for (int j = 0; j < 8; ++j) p[j] = row[j] * y[j];
  for (int k = 8; k < stride; k += 8)
    for (int j = 0; j < 8; ++j) p[j] = multiply_add(row[k + j], y[k + j], p[j]);
  return ((p[0] + p[4]) + (p[2] + p[6])) + ((p[1] + p[5]) + (p[3] + p[7]));
}

/// Three rows times y: a vector in body axes.
template <class T>
Vec3<T> times(const Rows& rows, const T* y) {
  const int s = static_cast<int>(rows.cols());
  return Vec3<T>(dot(rows.data(), y, s), dot(rows.data() + s, y, s), dot(rows.data() + 2 * s, y, s));
}

/// out[k] += Σ_i rows(i, k) f[i]: generalised force of a body-axes vector.
template <class T>
void add_transposed(const Rows& rows, const Vec3<T>& f, T* out) {
  const int s = static_cast<int>(rows.cols());
  by_lanes<T>(out, s, [&](auto sum, const auto& row) {
    for (int i = 0; i < 3; ++i) sum = multiply_add(row(rows.data() + i * s), row.all(f[i]), sum);
    return sum;
  });
}

/// S'^i_j = S̄^i_j + yᵀS^ij (Lugrís 2008, 3.34): nine rows of `stride` values.
template <class T>
void deformed_integrals(const FlexibleData& f, const T* y, T* integrals) {
  const int width = 9 * f.stride;
  std::copy(f.S_position.data(), f.S_position.data() + width, integrals);
  by_lanes<T>(integrals, width, [&](auto sum, const auto& row) {
    for (int l = 0; l < f.modes; ++l)
      sum = multiply_add(row.all(y[l]), row(f.S_modes.data() + static_cast<std::ptrdiff_t>(l) * width), sum);
    return sum;
  });
}

/// P̄(y) = P̄u + S̄^j_i y + S'^i_j y (Lugrís 2008, 3.27), symmetric.
template <class T>
Mat3<T> deformed_second_moment(const FlexibleData& f, const Mat3d& undeformed, const T* integrals,
                               const T* y) {
  Mat3<T> p;
  const int s = f.stride;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) {
      p(i, j) = undeformed(i, j) + dot(integrals + (3 * i + j) * s, y, s) +
                dot(f.S_position.data() + (3 * j + i) * s, y, s);
      p(j, i) = p(i, j);
    }
  return p;
}

}  // namespace mimbre
