#pragma once
#include <algorithm>
#include <type_traits>
#include <vector>

#include "compile/by_bodies.h"
#include "dynamics/relative/assembly.h"
#include "dynamics/relative/body_block.h"

/// The leading matrix of a tree factorised body by body, from the leaves to the root, in a time proportional
/// to the number of bodies (articulated bodies: Featherstone 2008, chapter 7; with modes: each body
/// eliminates its joint's and its modal coordinates together).
///
/// U: motion of the frame on the parent that carries a body's joint, as a velocity at the common point and an
/// angular velocity; x: rates of the body's own coordinates; S: its motion subspace. The body itself moves
/// with U + S x, its child c is carried by U_c = U + S_c x. With the body's inertia I about the common point,
/// coupling H and matrix E of its modes, and the articulated inertias A_c of its children,
///
///     [ P  C ] [U]   [f]      P = I + Σ A_c
///     [ Cᵀ D ] [x] = [b],     C = I S + H + Σ A_c S_c
///                             D = Sᵀ I S + Sᵀ H + Hᵀ S + E + Σ S_cᵀ A_c S_c.
///
/// Tangents of modes and of joint coordinates are added to D; those of a force element between the body and
/// the ground are an inertia A_e at its frame, which adds as a child's does.
///
/// x is eliminated: K = D⁻¹ Cᵀ, A = P − C K, f' = f − Kᵀ b. The parent gets A and f' in P and f.
namespace mimbre::relative {

/// The factors, sized once.
template <class T>
class ArticulatedBodies {
 public:
  explicit ArticulatedBodies(const Compiled& m) : bodies_(m.bodies.size()), acts_on_(m.elements.size()) {
    for (std::size_t k = 0; k < m.elements.size(); ++k)
      if (const auto on = acts_on_body(m.elements[k], m)) acts_on_[k] = *on;
    std::size_t couplings = 0, pivots = 0;
    for (std::size_t i = 0; i < m.bodies.size(); ++i) {
      const std::size_t n = static_cast<std::size_t>(m.bodies[i].size());
      bodies_[i].coupling = couplings;
      bodies_[i].pivot = pivots;
      couplings += 6 * n;
      pivots += n * n;
    }
    couplings_.assign(couplings, T(0));
    pivots_.assign(pivots, T(0));
  }

  /// Factorises M + damping·C + stiffness·K + penalty·α (of drives) after motion_subspaces() and a residual
  /// at the same q. Returns the velocity coordinate whose pivot cannot be divided by, −1: none.
  template <class Marks>
  int factor(const Compiled& m, Workspace<T>& w, const T* q, const MatrixWeights& weights,
             const double* penalty, Marks marks);
  /// x ← (the factorised matrix)⁻¹ x.
  void solve(const Compiled& m, const Workspace<T>& w, T* x);
  /// The same matrix, not factorised: velocities × velocities, column-major. factor() must not follow before
  /// it is asked for again.
  template <class Marks>
  void dense_matrix(const Compiled& m, Workspace<T>& w, const T* q, const MatrixWeights& weights,
                    const double* penalty, Marks marks, T* out);
  /// The factors, to save and restore.
  void transfer(StateTransfer& transfer) { transfer(couplings_, pivots_); }

 private:
  using Spatial = T[6];
  using Six = std::integral_constant<int, 6>;
  struct Body {
    std::size_t coupling = 0,
                pivot = 0;  ///< places of C, then K (row k of coordinate k), and D (rows), then its L D Lᵀ
    T inertia[6][6];        ///< P, then A
    T force[6], motion[6];  ///< f; U
  };

  template <class Marks>
  void begin(const Compiled& m, Workspace<T>& w, const MatrixWeights& weights, const double* penalty,
             Marks& marks);
  void add_element(const Compiled& m, const Workspace<T>& w, std::size_t k, const ElementState<T>& state,
                   const MatrixWeights& weights);
  void add_inertia(const T (&inertia)[6][6], const T* S, int stride, int n, Body& body) {
    relative::add_inertia(&inertia[0][0], 6, S, stride, n, &body.inertia[0][0], Six(),
                          couplings_.data() + body.coupling, pivots_.data() + body.pivot, n);
  }
  T& pivot(const Compiled& m, int body, int local) {
    const auto i = static_cast<std::size_t>(body);
    return pivots_[bodies_[i].pivot + static_cast<std::size_t>(local * (m.bodies[i].size() + 1))];
  }
  linalg::BlockPlace block(std::size_t i, const BodyData& b) const {
    return {static_cast<std::ptrdiff_t>(bodies_[i].pivot), b.size(), 1};
  }
  void add_own(const Compiled& m, Workspace<T>& w, const T* q, std::size_t i) {
    Body& body = bodies_[i];
    add_body<T>(m, w, q, i, &body.inertia[0][0], Six(), couplings_.data() + body.coupling,
                pivots_.data() + body.pivot, m.bodies[i].size());
  }
  int eliminate(const BodyData& b, Body& body) {
    return relative::eliminate<T>(b.size(), pivots_.data() + body.pivot, couplings_.data() + body.coupling,
                                  &body.inertia[0][0], Six());
  }
  void add_to_parent(const Compiled& m, const Workspace<T>& w, const BodyData& b, const Body& body);

  std::vector<Body> bodies_;
  std::vector<OnBody> acts_on_;  ///< by element
  std::vector<T> couplings_, pivots_;
};

/// Jᵀ (damping C + stiffness K) J of what acts on one body.
template <class T>
void ArticulatedBodies<T>::add_element(const Compiled& m, const Workspace<T>& w, std::size_t k,
                                       const ElementState<T>& state, const MatrixWeights& weights) {
  const ElementData& e = m.elements[k];
  if (e.body >= 0) {
    T& d = pivot(m, e.body, e.local);
    d += weights.damping * state.damping[0] + weights.stiffness * state.stiffness[0];
    if (e.inertia >= 0) d += w.signals.numbers[e.inertia];
    return;
  }
  const OnBody& on = acts_on_[k];
  if (on.body < 0 || !acts(state)) return;
  Spatial covectors[6];
  const Vec3<T>& place = w.frames[e.frame_b].position;
  for (int r = 0; r < e.count; ++r) {
    const Vec3<T> linear = state.linear_of(r);
    Vec3<T> angular = place.cross(linear);
    if (has_moment(e.measure)) angular += state.angular_of(r);
    for (int i = 0; i < 3; ++i) {
      covectors[r][i] = linear[i];
      covectors[r][3 + i] = angular[i];
    }
  }
  T inertia[6][6] = {};
  for (int r = 0; r < e.count; ++r)
    for (int c = 0; c < e.count; ++c) {
      const T tangent = weights.damping * state.damping[r * e.count + c] +
                        weights.stiffness * state.stiffness[r * e.count + c];
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) inertia[i][j] += tangent * covectors[r][i] * covectors[c][j];
    }
  const BodyData& b = m.bodies[on.body];
  Body& body = bodies_[static_cast<std::size_t>(on.body)];
  const int n = b.size(), s = m.subspaces[on.plus >= 0 ? on.plus : on.minus].stride;
  if (on.carried) {
    const int set = on.plus >= 0 ? on.plus : on.minus;
    add_inertia(inertia, w.subspaces.data() + m.subspaces[set].offset, s, n, body);
    return;
  }
  const auto column = [&](int k_row, int coordinate) {
    T sum = T(0);
    if (on.plus >= 0) sum += w.subspaces[m.subspaces[on.plus].offset + k_row * s + coordinate];
    if (on.minus >= 0) sum -= w.subspaces[m.subspaces[on.minus].offset + k_row * s + coordinate];
    return sum;
  };
  T* D = pivots_.data() + body.pivot;
  for (int r = 0; r < n; ++r) {
    Spatial force;
    for (int i = 0; i < 6; ++i) {
      force[i] = T(0);
      for (int j = 0; j < 6; ++j) force[i] += inertia[i][j] * column(j, r);
    }
    for (int c = r; c < n; ++c)
      for (int i = 0; i < 6; ++i) D[c * n + r] += column(i, c) * force[i];
  }
}

/// Clears all, and adds what forces and drives contribute.
template <class T>
template <class Marks>
void ArticulatedBodies<T>::begin(const Compiled& m, Workspace<T>& w, const MatrixWeights& weights,
                                 const double* penalty, Marks& marks) {
  for (Body& body : bodies_)
    for (auto& row : body.inertia) std::fill_n(row, 6, T(0));
  std::fill(couplings_.begin(), couplings_.end(), T(0));
  std::fill(pivots_.begin(), pivots_.end(), T(0));
  for (std::size_t k = 0; k < m.elements.size(); ++k) {
    const ElementState<T> state = element_state(m.elements[k], w.elements.data());
    if (m.elements[k].marked) marks.element(k, state, weights);
    add_element(m, w, k, state, weights);
  }
  for (const DriveData& d : m.drives) pivot(m, d.body, d.local) += weights.penalty * penalty[d.equation];
}

template <class T>
void ArticulatedBodies<T>::add_to_parent(const Compiled& m, const Workspace<T>& w, const BodyData& b,
                                         const Body& body) {
  const MotionSubspace& set = carrier(m, b);
  add_inertia(body.inertia, w.subspaces.data() + set.offset, set.stride, m.bodies[b.parent].size(),
              bodies_[static_cast<std::size_t>(b.parent)]);
}

template <class T>
template <class Marks>
int ArticulatedBodies<T>::factor(const Compiled& m, Workspace<T>& w, const T* q, const MatrixWeights& weights,
                                 const double* penalty, Marks marks) {
  begin(m, w, weights, penalty, marks);
  for (std::size_t i = m.bodies.size(); i-- > 0;) {
    const BodyData& b = m.bodies[i];
    add_own(m, w, q, i);
    if (b.modes > 0) add_modal_tangent<T>(m, w, i, q, weights, pivots_.data(), block(i, b), marks);
    if (const int bad = eliminate(b, bodies_[i]); bad >= 0) return b.v + bad;
    if (b.parent >= 0) add_to_parent(m, w, b, bodies_[i]);
  }
  return -1;
}

template <class T>
template <class Marks>
void ArticulatedBodies<T>::dense_matrix(const Compiled& m, Workspace<T>& w, const T* q,
                                        const MatrixWeights& weights, const double* penalty, Marks marks,
                                        T* out) {
  begin(m, w, weights, penalty, marks);
  const std::ptrdiff_t size = m.velocities;
  std::fill_n(out, size * size, T(0));
  for (std::size_t i = m.bodies.size(); i-- > 0;) {
    const BodyData& b = m.bodies[i];
    Body& body = bodies_[i];
    add_own(m, w, q, i);
    if (b.modes > 0) add_modal_tangent<T>(m, w, i, q, weights, pivots_.data(), block(i, b), marks);
    // Without elimination A is P, the inertia of the body and all after it.
    if (b.parent >= 0) add_to_parent(m, w, b, body);
    const int n = b.size();
    const T *D = pivots_.data() + body.pivot, *C = couplings_.data() + body.coupling;
    for (int r = 0; r < n; ++r)
      for (int c = 0; c <= r; ++c)
        out[(b.v + c) * size + b.v + r] = out[(b.v + r) * size + b.v + c] = D[r * n + c];
    for (const BodyData* below = &b; below->parent >= 0; below = &m.bodies[below->parent]) {
      const BodyData& above = m.bodies[below->parent];
      const MotionSubspace& set = carrier(m, *below);
      const T* S = w.subspaces.data() + set.offset;
      for (int r = 0; r < above.size(); ++r)
        for (int c = 0; c < n; ++c) {
          T sum = T(0);
          for (int k = 0; k < 6; ++k) sum += S[k * set.stride + r] * C[c * 6 + k];
          out[(b.v + c) * size + above.v + r] = out[(above.v + r) * size + b.v + c] = sum;
        }
    }
  }
}

template <class T>
void ArticulatedBodies<T>::solve(const Compiled& m, const Workspace<T>& w, T* x) {
  for (Body& body : bodies_) std::fill_n(body.force, 6, T(0));
  for (std::size_t i = m.bodies.size(); i-- > 0;) {
    const BodyData& b = m.bodies[i];
    Body& body = bodies_[i];
    const int n = b.size();
    const T* D = pivots_.data() + body.pivot;
    const T* K = couplings_.data() + body.coupling;
    T* y = x + b.v;
    for (int r = 0; r < n; ++r)
      for (int c = 0; c < 6; ++c) body.force[c] -= K[r * 6 + c] * y[r];
    divide(D, n, y);
    if (b.parent < 0) continue;
    Body& up = bodies_[static_cast<std::size_t>(b.parent)];
    const BodyData& parent = m.bodies[b.parent];
    const MotionSubspace& set = carrier(m, b);
    const T* S = w.subspaces.data() + set.offset;
    for (int k = 0; k < 6; ++k) up.force[k] += body.force[k];
    for (int r = 0; r < parent.size(); ++r)
      for (int k = 0; k < 6; ++k) x[parent.v + r] += S[k * set.stride + r] * body.force[k];
  }
  for (std::size_t i = 0; i < m.bodies.size(); ++i) {
    const BodyData& b = m.bodies[i];
    Body& body = bodies_[i];
    if (b.parent < 0) {
      std::fill_n(body.motion, 6, T(0));
      continue;
    }
    const BodyData& parent = m.bodies[b.parent];
    const MotionSubspace& set = carrier(m, b);
    const T* S = w.subspaces.data() + set.offset;
    for (int k = 0; k < 6; ++k) {
      body.motion[k] = bodies_[static_cast<std::size_t>(b.parent)].motion[k];
      for (int r = 0; r < parent.size(); ++r) body.motion[k] += S[k * set.stride + r] * x[parent.v + r];
    }
    const T* K = couplings_.data() + body.coupling;
    for (int r = 0; r < b.size(); ++r)
      for (int c = 0; c < 6; ++c) x[b.v + r] -= K[r * 6 + c] * body.motion[c];
  }
}

}  // namespace mimbre::relative
