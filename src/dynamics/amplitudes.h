#pragma once
#include "compile/compiled.h"

/// Extended amplitudes η of a flexible body: its amplitudes y, then the products y_a y_b by which large
/// deflections enter (SecondOrder). Integrals, frames and stiffness belong to η; coordinates are y. Bodies
/// that are linear have no products, and nothing happens here.
namespace mimbre {

/// Appends the products to padded amplitudes.
template <class T>
void extend(const FlexibleData& f, T* y) {
  for (std::size_t p = 0; p < f.products.size(); ++p)
    y[f.amplitudes + p] = y[f.products[p][0]] * y[f.products[p][1]];
}

/// Their rates.
template <class T>
void extend(const FlexibleData& f, const T* y, T* yd) {
  for (std::size_t p = 0; p < f.products.size(); ++p) {
    const auto [a, b] = f.products[p];
    yd[f.amplitudes + p] = yd[a] * y[b] + y[a] * yd[b];
  }
}

/// Their second derivatives.
template <class T>
void extend(const FlexibleData& f, const T* y, const T* yd, T* ydd) {
  for (std::size_t p = 0; p < f.products.size(); ++p) {
    const auto [a, b] = f.products[p];
    ydd[f.amplitudes + p] = ydd[a] * y[b] + T(2) * yd[a] * yd[b] + y[a] * ydd[b];
  }
}

/// row ∂η/∂y, in place: forces on η, or what a unit of each η̇ moves, become those of y.
template <class T>
void fold(const FlexibleData& f, const T* y, T* row) {
  for (std::size_t p = 0; p < f.products.size(); ++p) {
    const auto [a, b] = f.products[p];
    const T x = row[f.amplitudes + p];
    row[a] += y[b] * x;
    row[b] += y[a] * x;
  }
}

/// (∂η/∂y)ᵀ A ∂η/∂y of a matrix of extended amplitudes; `out` has its stride.
template <class T>
void fold(const FlexibleData& f, const T* y, const Rows& A, T* out) {
  const int s = f.stride;
  for (int r = 0; r < f.modes; ++r) {
    for (int c = 0; c < s; ++c) out[r * s + c] = A(r, c);
    fold(f, y, out + r * s);
  }
  for (std::size_t p = 0; p < f.products.size(); ++p) {
    const auto [a, b] = f.products[p];
    const T* row = out + (f.amplitudes + static_cast<int>(p)) * s;
    for (int c = 0; c < s; ++c) {
      out[a * s + c] += y[b] * row[c];
      out[b * s + c] += y[a] * row[c];
    }
  }
}

/// Adds weight · Σ_p f_p ∂²η_p/∂y² to a folded matrix, f = Kᵀ η the elastic forces: what the change of ∂η/∂y
/// adds to the tangent of (∂η/∂y)ᵀ f.
template <class T>
void add_curvature(const FlexibleData& f, const T* y, T weight, T* out) {
  const int s = f.stride;
  for (std::size_t p = 0; p < f.products.size(); ++p) {
    const int column = f.amplitudes + static_cast<int>(p);
    T force(0);
    for (int l = 0; l < f.modes; ++l) force += f.stiffness(l, column) * y[l];
    const auto [a, b] = f.products[p];
    out[a * s + b] += weight * force;
    out[b * s + a] += weight * force;
  }
}

}  // namespace mimbre
