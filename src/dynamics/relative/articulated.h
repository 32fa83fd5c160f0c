#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "dynamics/relative/kinematics.h"
#include "dynamics/relative/matrix.h"

/// The mass matrix of a tree factorised body by body, from the leaves to the root, in a time proportional to
/// the number of bodies (articulated bodies: Featherstone 2008, chapter 7; with modes: each body eliminates
/// its joint's and its modal coordinates together).
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
/// x is eliminated: K = D⁻¹ Cᵀ, A = P − C K, f' = f − Kᵀ b. The parent gets A and f' in P and f.
namespace mimbre::relative {

/// Whether bodies can be eliminated one by one: the mass matrix couples coordinates along branches only, and
/// no body has so many coordinates that its own sparse matrix is worth while.
inline bool is_articulated(const Compiled& m) {
  constexpr int most_coordinates = 60;
  return std::all_of(m.bodies.begin(), m.bodies.end(),
                     [](const BodyData& b) { return b.size() <= most_coordinates; }) &&
         std::all_of(m.elements.begin(), m.elements.end(),
                     [](const ElementData& e) { return e.inertia < 0 || e.body >= 0; });
}

/// The factors, sized once.
template <class T>
class ArticulatedBodies {
 public:
  explicit ArticulatedBodies(const Compiled& m) : bodies_(m.bodies.size()) {
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

  /// Factorises the mass matrix after motion_subspaces() and a residual at the same q. Returns the velocity
  /// coordinate whose pivot is not positive, −1: all are.
  int factor(const Compiled& m, Workspace<T>& w, const T* q);
  /// x ← M⁻¹ x.
  void solve(const Compiled& m, const Workspace<T>& w, T* x);

 private:
  using Spatial = T[6];
  struct Body {
    std::size_t coupling = 0,
                pivot = 0;  ///< places of C, then K (row k of coordinate k), and D (rows), then its L D Lᵀ
    T inertia[6][6];        ///< P, then A
    T force[6], motion[6];  ///< f; U
  };

  /// The subspace at the frame that carries a body's joint.
  static const MotionSubspace& carrier(const Compiled& m, const BodyData& b) {
    const FrameData& frame = m.frames[b.inboard_frame];
    return m.subspaces[frame.flexible < 0 ? m.bodies[b.parent].subspace : frame.subspace];
  }
  void add_own(const Compiled& m, Workspace<T>& w, const T* q, std::size_t i);
  int eliminate(const BodyData& b, Body& body);
  void add_to_parent(const Compiled& m, const Workspace<T>& w, const BodyData& b, const Body& body);

  std::vector<Body> bodies_;
  std::vector<T> couplings_, pivots_;
};

template <class T>
void ArticulatedBodies<T>::add_own(const Compiled& m, Workspace<T>& w, const T* q, std::size_t i) {
  const BodyData& b = m.bodies[i];
  Body& body = bodies_[i];
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
    body.inertia[r][r] += own.mass;
    for (int c = 0; c < 3; ++c) {
      body.inertia[3 + r][3 + c] += J(r, c);
      body.inertia[3 + r][c] += cross(r, c);
      body.inertia[r][3 + c] -= cross(r, c);
    }
  }
  // I S, and with it Sᵀ I S; then H.
  const T* S = w.subspaces.data() + set.offset;
  T* force = w.subspace_forces.data();
  composite_times<T>(own, S, s, force);
  T* C = couplings_.data() + body.coupling;
  T* D = pivots_.data() + body.pivot;
  for (int r = 0; r < n; ++r)
    for (int c = 0; c <= r; ++c) {
      T sum = T(0);
      for (int k = 0; k < 6; ++k) sum += S[k * s + r] * force[k * s + c];
      if (b.modes > 0)
        for (int k = 0; k < 6; ++k)
          sum += S[k * s + r] * elastic[k * s + c] + elastic[k * s + r] * S[k * s + c];
      D[r * n + c] += sum;
    }
  for (int r = 0; r < n; ++r)
    for (int k = 0; k < 6; ++k) {
      C[r * 6 + k] += force[k * s + r];
      if (b.modes > 0) C[r * 6 + k] += elastic[k * s + r];
    }
  if (b.modes == 0) return;
  const FlexibleData& f = m.flexible[b.flexible];
  const auto add = [&](const auto* modal_mass) {
    for (int r = 0; r < b.modes; ++r)
      for (int c = 0; c <= r; ++c)
        D[(b.joint_velocities + r) * n + b.joint_velocities + c] += modal_mass[r * f.stride + c];
  };
  if (f.products.empty())
    add(constant_inertia(m, w, b).modal_mass.data());
  else
    add(w.folded.data());
}

/// D = L Δ Lᵀ in place, K in place of C, A in place of P.
template <class T>
int ArticulatedBodies<T>::eliminate(const BodyData& b, Body& body) {
  const int n = b.size();
  T* D = pivots_.data() + body.pivot;
  T* C = couplings_.data() + body.coupling;
  for (int j = 0; j < n; ++j) {
    for (int k = 0; k < j; ++k) {
      const T share = D[j * n + k] * D[k * n + k];
      for (int r = j; r < n; ++r) D[r * n + j] -= D[r * n + k] * share;
    }
    if (!(D[j * n + j] > T(0))) return j;
    const T inverse = T(1) / D[j * n + j];
    for (int r = j + 1; r < n; ++r) D[r * n + j] *= inverse;
  }
  // Rows of C become L⁻¹ Cᵀ; A = P − (L⁻¹ Cᵀ)ᵀ Δ⁻¹ (L⁻¹ Cᵀ).
  for (int r = 0; r < n; ++r) {
    for (int k = 0; k < r; ++k)
      for (int c = 0; c < 6; ++c) C[r * 6 + c] -= D[r * n + k] * C[k * 6 + c];
    const T inverse = T(1) / D[r * n + r];
    for (int i = 0; i < 6; ++i) {
      const T share = inverse * C[r * 6 + i];
      for (int j = 0; j < 6; ++j) body.inertia[i][j] -= share * C[r * 6 + j];
    }
  }
  for (int r = n; r-- > 0;) {
    const T inverse = T(1) / D[r * n + r];
    for (int c = 0; c < 6; ++c) C[r * 6 + c] *= inverse;
    for (int k = r + 1; k < n; ++k)
      for (int c = 0; c < 6; ++c) C[r * 6 + c] -= D[k * n + r] * C[k * 6 + c];
  }
  return -1;
}

template <class T>
void ArticulatedBodies<T>::add_to_parent(const Compiled& m, const Workspace<T>& w, const BodyData& b,
                                         const Body& body) {
  const BodyData& parent = m.bodies[b.parent];
  Body& up = bodies_[static_cast<std::size_t>(b.parent)];
  const MotionSubspace& set = carrier(m, b);
  const T* S = w.subspaces.data() + set.offset;
  const int n = parent.size(), s = set.stride;
  T* C = couplings_.data() + up.coupling;
  T* D = pivots_.data() + up.pivot;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) up.inertia[i][j] += body.inertia[i][j];
  for (int r = 0; r < n; ++r) {
    Spatial force;  // A S, of one coordinate
    for (int i = 0; i < 6; ++i) {
      force[i] = T(0);
      for (int k = 0; k < 6; ++k) force[i] += body.inertia[i][k] * S[k * s + r];
      C[r * 6 + i] += force[i];
    }
    for (int c = r; c < n; ++c)
      for (int k = 0; k < 6; ++k) D[c * n + r] += S[k * s + c] * force[k];
  }
}

template <class T>
int ArticulatedBodies<T>::factor(const Compiled& m, Workspace<T>& w, const T* q) {
  for (Body& body : bodies_)
    for (auto& row : body.inertia) std::fill_n(row, 6, T(0));
  std::fill(couplings_.begin(), couplings_.end(), T(0));
  std::fill(pivots_.begin(), pivots_.end(), T(0));
  for (const ElementData& e : m.elements)
    if (e.inertia >= 0) {
      const BodyData& b = m.bodies[static_cast<std::size_t>(e.body)];
      pivots_[bodies_[static_cast<std::size_t>(e.body)].pivot +
              static_cast<std::size_t>(e.local * (b.size() + 1))] += w.signals.numbers[e.inertia];
    }
  for (std::size_t i = m.bodies.size(); i-- > 0;) {
    const BodyData& b = m.bodies[i];
    add_own(m, w, q, i);
    if (const int bad = eliminate(b, bodies_[i]); bad >= 0) return b.v + bad;
    if (b.parent >= 0) add_to_parent(m, w, b, bodies_[i]);
  }
  return -1;
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
    for (int r = 0; r < n; ++r)
      for (int k = 0; k < r; ++k) y[r] -= D[r * n + k] * y[k];
    for (int r = n; r-- > 0;) {
      y[r] /= D[r * n + r];
      for (int k = r + 1; k < n; ++k) y[r] -= D[k * n + r] * y[k];
    }
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
