#pragma once
#include "dynamics/ancf.h"
#include "dynamics/geometric.h"
#include "dynamics/relative/kinematics.h"
#include "dynamics/relative/matrix.h"

/// The leading matrix of a Newton step.
namespace mimbre::relative {

/// Where nothing asks later whether tangents have changed.
struct NoMarks {
  template <class T>
  void element(std::size_t, const ElementState<T>&, const MatrixWeights&) {}
  template <class T>
  void pair(const ElementData&, const ElementEnds&, const T*, const PairRows<T>&) {}
  template <class T>
  void beam(const FlexibleData&, const T*) {}
};

/// damping·C + stiffness·K of a body's modes, into its block `place` of the values.
template <class T, class Marks>
void add_modal_tangent(const Compiled& m, Workspace<T>& w, std::size_t i, const T* q,
                       const MatrixWeights& weights, T* values, const linalg::BlockPlace& place,
                       Marks& marks) {
  const BodyData& b = m.bodies[i];
  const FlexibleData& f = m.flexible[b.flexible];
  T* out = values + place.offset;
  const int n0 = b.joint_velocities;
  if (!f.geometric.empty()) {
    T* y = w.scratch.data();
    copy_modes(b, q + b.q + b.joint_positions, f.stride, y);
    geometric::stiffness<T>(f.geometric, w.stress[i], y, w.folded.data(), w.geometric_scratch.data());
    for (int c = 0; c < b.modes; ++c)
      for (int r = 0; r < b.modes; ++r)
        out[(n0 + r) * place.row_stride + (n0 + c) * place.col_stride] +=
            weights.stiffness * w.folded[r * f.stride + c];
  }
  if (f.absolute()) {
    T* y = w.scratch.data();
    copy_modes(b, q + b.q + b.joint_positions, f.stride, y);
    marks.beam(f, y);
    ancf::add_tangent(f, y, weights.stiffness, weights.damping, [&](int r, int c, const T& x) {
      out[(n0 + r) * place.row_stride + (n0 + c) * place.col_stride] += x;
    });
  } else if (f.diagonal_stiffness) {
    for (int k = 0; k < b.modes; ++k)
      out[(n0 + k) * (place.row_stride + place.col_stride)] +=
          weights.damping * f.damping(k, k) + weights.stiffness * f.stiffness(k, k);
  } else {
    const auto add = [&](const auto* stiffness) {
      for (int c = 0; c < b.modes; ++c)
        for (int r = 0; r < b.modes; ++r)
          out[(n0 + r) * place.row_stride + (n0 + c) * place.col_stride] +=
              weights.damping * f.damping(r, c) + weights.stiffness * stiffness[r * f.stride + c];
    };
    if (f.products.empty()) {
      add(f.stiffness.data());
      return;
    }
    T* y = w.scratch.data();
    copy_modes(b, q + b.q + b.joint_positions, f.stride, y);
    extend(f, y);
    fold(f, y, f.stiffness, w.folded.data());
    if (f.nonlinear_stiffness) add_curvature(f, y, T(1), w.folded.data());
    add(w.folded.data());
  }
}

/// The tangent of one force element; with the inertia that a law adds to its coordinate.
template <class T, class Marks>
void add_element_tangent(const Compiled& m, Workspace<T>& w, std::size_t k, const MatrixWeights& weights,
                         T* values, Marks& marks) {
  const ElementData& e = m.elements[k];
  const ElementState<T> state = element_state(e, w.elements.data());
  if (e.marked) marks.element(k, state, weights);
  if (e.body >= 0) {
    const linalg::BlockPlace& place = m.diagonal[e.body];
    values[place.offset + e.local * (place.row_stride + place.col_stride)] +=
        weights.damping * state.damping[0] + weights.stiffness * state.stiffness[0];
    if (e.inertia >= 0)
      values[place.offset + e.local * (place.row_stride + place.col_stride)] += w.signals.numbers[e.inertia];
  } else if (e.pooled) {
    const ElementEnds ends = ends_of(m, e, w.signals.states + e.states);
    if (ends.frame_b < 0 || !acts(state)) return;
    T tangent[36];
    for (int i = 0; i < e.count * e.count; ++i)
      tangent[i] = weights.damping * state.damping[i] + weights.stiffness * state.stiffness[i];
    marks.pair(e, ends, tangent, add_pair<T>(m, w, e, ends, state, tangent, values));
  } else if (!e.path.entries.empty()) {
    add_element<T>(e, state, weights, w.signals.numbers, w.jacobian.data() + e.jacobian, w.weighted.data(),
                   values);
  }
}

/// Adds M + damping·C + stiffness·K + penalty·Φzᵀ α Φz (α: `penalty`) to the sparse values at the last
/// evaluation's state, with q as given there. `marks` sees the tangents that may change at once, and
/// those between the two spheres of a swarm's pairs, which are not in the matrix.
template <class T, class Marks>
void assemble(const Compiled& m, Workspace<T>& w, const T* q, const MatrixWeights& weights,
              const double* penalty, T* values, Marks marks) {
  motion_subspaces<T>(m, w, q);
  jacobian<T>(m, w);
  mass<T>(m, w, q, values);
  for (std::size_t i = 0; i < m.bodies.size(); ++i)
    if (m.bodies[i].modes > 0) add_modal_tangent<T>(m, w, i, q, weights, values, m.diagonal[i], marks);
  for (std::size_t k = 0; k < m.elements.size(); ++k) add_element_tangent<T>(m, w, k, weights, values, marks);
  for_rows(m, [&](const EquationRows& e) {
    T weight[6];
    for (int r = 0; r < e.count; ++r) weight[r] = weights.penalty * penalty[e.first_equation + r];
    add_squares<T>(e.path, w.jacobian.data() + e.jacobian, e.count, weight, w.weighted.data(), values);
  });
  for (const DriveData& d : m.drives) {
    const linalg::BlockPlace& place = m.diagonal[d.body];
    values[place.offset + d.local * (place.row_stride + place.col_stride)] +=
        weights.penalty * penalty[d.equation];
  }
}

}  // namespace mimbre::relative
