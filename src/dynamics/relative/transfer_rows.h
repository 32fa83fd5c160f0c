#pragma once
#include <algorithm>
#include <cmath>

#include "dynamics/relative/matrix.h"
#include "dynamics/relative/once/transfer_plan.h"

/// Rows that couple bodies, each scaled so that its force is an unknown of the size of motions.
namespace mimbre::relative {

/// W = Σ_k signs[k] L_k L_kᵀ, L_k the columns of `root`, of the symmetric W (n × n, n up to 6; it becomes
/// what is left). The largest diagonal entry is taken first; what has none left (forces that are exchanged
/// between two components alone) is left out, with a column of zero.
template <class T>
void signed_root(int n, T* W, T* root, T* signs) {
  for (int k = 0; k < n; ++k) {
    int at = 0;
    for (int i = 1; i < n; ++i)
      if (std::abs(W[i * n + i]) > std::abs(W[at * n + at])) at = i;
    const T pivot = W[at * n + at];
    signs[k] = pivot < T(0) ? T(-1) : T(1);
    const T inverse = std::abs(pivot) > T(0) ? T(1) / std::sqrt(std::abs(pivot)) : T(0);
    for (int i = 0; i < n; ++i) root[i * n + k] = inverse * W[i * n + at];
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) W[i * n + j] -= signs[k] * root[i * n + k] * root[j * n + k];
    for (int i = 0; i < n; ++i) W[i * n + at] = W[at * n + i] = T(0);
  }
}

/// Tangent of an element in a matrix of these weights, with its inertia (n × n).
template <class T>
void tangent_of(const Workspace<T>& w, const ElementData& e, const ElementState<T>& s,
                const MatrixWeights& weights, T* W) {
  const T inertia = e.inertia < 0 ? T(0) : T(w.signals.numbers[e.inertia]);
  for (int i = 0; i < e.count * e.count; ++i)
    W[i] = inertia + weights.damping * s.damping[i] + weights.stiffness * s.stiffness[i];
}

/// Rows of the workspace's Jacobian of all equations, and of those elements that couple bodies.
template <class T>
void coupled_jacobian(const Compiled& m, Workspace<T>& w, const TransferPlan& plan) {
  equation_rows(m, w);
  const auto of_element = [&](int k) {
    const ElementData& e = m.elements[k];
    const ElementState<T> s = element_state(e, w.elements.data());
    if (e.measure != Measure::sum && !(e.measure == Measure::contact && !acts(s))) element_rows(m, w, e, s);
  };
  for (const int k : plan.legs) of_element(k);
  for (const CoupledRows& r : plan.rows)
    if (r.element >= 0) of_element(r.element);
  for (const int k : m.sums) sum_row<T>(m, m.elements[k], w.jacobian.data());
}

/// Lᵀ J and the signs of W of coupled rows, after coupled_jacobian(). Of what does not act: zeros.
template <class T>
void scale_rows(const Compiled& m, Workspace<T>& w, const CoupledRows& r, const MatrixWeights& weights,
                const double* penalty, T* scaled, T* signs) {
  const int n = r.count, width = r.path->width;
  const T* rows = w.jacobian.data() + r.jacobian;
  if (r.element < 0) {
    for (int k = 0; k < n; ++k) {
      const T root = std::sqrt(weights.penalty * penalty[r.equation + k]);
      signs[k] = T(1);
      for (int i = 0; i < width; ++i) scaled[k * width + i] = root * rows[k * width + i];
    }
    return;
  }
  T W[36], root[36];
  const ElementData& e = m.elements[r.element];
  tangent_of(w, e, element_state(e, w.elements.data()), weights, W);
  signed_root(n, W, root, signs);
  std::fill_n(scaled, n * width, T(0));
  for (int k = 0; k < n; ++k)
    for (int c = 0; c < n; ++c) {
      const T factor = root[c * n + k];
      if (factor == T(0)) continue;  // rows of what does not touch are of before
      for (int i = 0; i < width; ++i) scaled[k * width + i] += factor * rows[c * width + i];
    }
}

}  // namespace mimbre::relative
