#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/relative/matrix.h"

/// What a body itself adds where bodies are eliminated one by one (articulated.h, transfer_matrices.h).
namespace mimbre::relative {

/// The subspace at the frame that carries a body's joint.
inline const MotionSubspace& carrier(const Compiled& m, const BodyData& b) {
  const FrameData& frame = m.frames[b.inboard_frame];
  return m.subspaces[frame.flexible < 0 ? m.bodies[b.parent].subspace : frame.subspace];
}

/// What has the inertia A (6 × 6, rows `a` apart) about the common point and moves with U + S x adds A to P,
/// A S to C and Sᵀ A S to D. P: rows `size` apart; C: of each coordinate a row of that length; D: rows
/// `unknowns` apart, its lower triangle. S: `n` columns, rows `stride` apart.
template <class T, class Size>
[[gnu::always_inline]] inline void add_inertia(const T* A, int a, const T* S, int stride, int n, T* P,
                                               Size size, T* C, T* D, int unknowns) {
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) P[i * size + j] += A[i * a + j];
  for (int r = 0; r < n; ++r) {
    T force[6];  // of one coordinate
    for (int i = 0; i < 6; ++i) {
      force[i] = T(0);
      for (int k = 0; k < 6; ++k) force[i] += A[i * a + k] * S[k * stride + r];
      C[r * size + i] += force[i];
    }
    for (int c = r; c < n; ++c)
      for (int k = 0; k < 6; ++k) D[c * unknowns + r] += S[k * stride + c] * force[k];
  }
}

/// A body's own inertia, of its frame and its modes, to P, C and D as above, after motion_subspaces() and a
/// residual at the same q.
template <class T, class Size>
[[gnu::always_inline]] inline void add_body(const Compiled& m, Workspace<T>& w, const T* q, std::size_t i,
                                            T* P, Size size, T* C, T* D, int unknowns) {
  const BodyData& b = m.bodies[i];
  typename Workspace<T>::Composite own{T(0), Vec3<T>::Zero(), Mat3<T>::Zero()};
  const MotionSubspace& set = m.subspaces[b.subspace];
  const int n = b.size(), s = set.stride;
  T* elastic = w.elastic_forces.data() + w.elastic_offset[i];
  if (b.modes > 0) std::fill_n(elastic, 6 * s, T(0));
  add_own_inertia<T>(m, w, i, q, own, elastic);

  const Mat3<T> J = own.second.trace() * Mat3<T>::Identity() - own.second;
  const Vec3<T>& d = own.moment;
  const Mat3<T> cross = skew<T>(d);
  for (int r = 0; r < 3; ++r) {
    P[r * size + r] += own.mass;
    for (int c = 0; c < 3; ++c) {
      P[(3 + r) * size + 3 + c] += J(r, c);
      P[(3 + r) * size + c] += cross(r, c);
      P[r * size + 3 + c] -= cross(r, c);
    }
  }
  // I S, and with it Sᵀ I S; then H.
  const T* S = w.subspaces.data() + set.offset;
  T* force = w.subspace_forces.data();
  composite_times<T>(own, S, s, force);
  for (int r = 0; r < n; ++r)
    for (int c = 0; c <= r; ++c) {
      T sum = T(0);
      for (int k = 0; k < 6; ++k) sum += S[k * s + r] * force[k * s + c];
      if (b.modes > 0)
        for (int k = 0; k < 6; ++k)
          sum += S[k * s + r] * elastic[k * s + c] + elastic[k * s + r] * S[k * s + c];
      D[r * unknowns + c] += sum;
    }
  for (int r = 0; r < n; ++r)
    for (int k = 0; k < 6; ++k) {
      C[r * size + k] += force[k * s + r];
      if (b.modes > 0) C[r * size + k] += elastic[k * s + r];
    }
  if (b.modes == 0) return;
  const FlexibleData& f = m.flexible[b.flexible];
  const auto add = [&](const auto* modal_mass) {
    for (int r = 0; r < b.modes; ++r)
      for (int c = 0; c <= r; ++c)
        D[(b.joint_velocities + r) * unknowns + b.joint_velocities + c] += modal_mass[r * f.stride + c];
  };
  if (f.products.empty())
    add(constant_inertia(m, w, b).modal_mass.data());
  else
    add(w.folded.data());
}

/// x = D⁻¹ x by the factors of eliminate().
template <class T>
void divide(const T* D, int n, T* x) {
  for (int r = 0; r < n; ++r)
    for (int k = 0; k < r; ++k) x[r] -= D[r * n + k] * x[k];
  for (int r = n; r-- > 0;) {
    x[r] /= D[r * n + r];
    for (int k = r + 1; k < n; ++k) x[r] -= D[k * n + r] * x[k];
  }
}

/// D = L Δ Lᵀ in place, K = D⁻¹ C in place of C, A = P − Cᵀ D⁻¹ C in place of P. Returns which of the n
/// unknowns has a pivot that cannot be divided by, −1: none.
template <class T, class Size>
[[gnu::always_inline]] inline int eliminate(int n, T* D, T* C, T* P, Size size) {
  for (int j = 0; j < n; ++j) {
    for (int k = 0; k < j; ++k) {
      const T share = D[j * n + k] * D[k * n + k];
      for (int r = j; r < n; ++r) D[r * n + j] -= D[r * n + k] * share;
    }
    const T magnitude = std::abs(D[j * n + j]);
    if (!(magnitude > T(0) && magnitude < std::numeric_limits<T>::infinity())) return j;
    const T inverse = T(1) / D[j * n + j];
    for (int r = j + 1; r < n; ++r) D[r * n + j] *= inverse;
  }
  // Rows of C become L⁻¹ C; A = P − (L⁻¹ C)ᵀ Δ⁻¹ (L⁻¹ C).
  for (int r = 0; r < n; ++r) {
    for (int k = 0; k < r; ++k)
      for (int c = 0; c < size; ++c) C[r * size + c] -= D[r * n + k] * C[k * size + c];
    const T inverse = T(1) / D[r * n + r];
    for (int i = 0; i < size; ++i) {
      const T share = inverse * C[r * size + i];
      for (int j = 0; j < size; ++j) P[i * size + j] -= share * C[r * size + j];
    }
  }
  for (int r = n; r-- > 0;) {
    const T inverse = T(1) / D[r * n + r];
    for (int c = 0; c < size; ++c) C[r * size + c] *= inverse;
    for (int k = r + 1; k < n; ++k)
      for (int c = 0; c < size; ++c) C[r * size + c] -= D[k * n + r] * C[k * size + c];
  }
  return -1;
}

}  // namespace mimbre::relative
