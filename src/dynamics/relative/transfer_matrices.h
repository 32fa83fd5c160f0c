#pragma once
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <vector>

#include "dynamics/relative/assembly.h"
#include "dynamics/relative/body_block.h"
#include "dynamics/relative/transfer_rows.h"
#include "dynamics/state_transfer.h"

/// Discrete-time transfer matrices (Rui, He, Lu, Lu, Wang 2005) by Riccati's transformation (Rui, Bestle,
/// Wang, Zhang, Rui, He 2020), for the increments of positions in a Newton iteration of a step.
///
/// The state vector of a joint has two halves. z: the increment of the motion of the frame that carries it,
/// as a displacement at the common point and a rotation; and the increments ψ of those forces between bodies
/// on either side of the joint that are not the joint's. f: force and moment of the joint; and how far apart
/// the ψ have moved what they act on. The plain product of transfer matrices, which gives both halves of one
/// joint by those of the next, loses digits with the length of the chain. Riccati's does not: from the leaves
/// on,
///
///     f = A z − e
///
/// holds at every joint. With x, the increments of a body's own coordinates and of the ψ that end with it,
/// with its own inertia, and with A and e at the joints behind it, which move with T z + S x,
///
///     [ P  Cᵀ ] [z]   [f + e']      P = P_own + Σ Tᵀ A T
///     [ C  D  ] [x] = [  b   ],     C = C_own + Σ Sᵀ A T,   D = D_own + Σ Sᵀ A S,
///
/// x is eliminated: K = D⁻¹ C, A = P − Cᵀ K, e = e' − Kᵀ b. At the root z = 0, and x = D⁻¹ b − K z outwards.
///
/// What acts on several bodies by the scaled rows J' = Lᵀ J, with the tangent W = L σ Lᵀ, σ of ±1, has
/// ψ = σ J' x: J' in C or D of each body on its path, and −σ in D where it ends. So loops, constraints and
/// force elements between any bodies are some more columns on their way only. Without them A is the
/// articulated inertia of Featherstone (2008, chapter 7): both methods are the same elimination.
namespace mimbre::relative {

template <class T>
class TransferMatrices {
 public:
  explicit TransferMatrices(const Compiled& m);

  /// Factorises M + damping·C + stiffness·K + penalty·Φzᵀ α Φz after motion_subspaces() and a residual at the
  /// same q; writes the rows of the equations in the workspace's Jacobian. Returns the velocity coordinate
  /// whose pivot cannot be divided by, −1: none.
  template <class Marks>
  int factor(const Compiled& m, Workspace<T>& w, const T* q, const MatrixWeights& weights,
             const double* penalty, Marks marks);
  /// x ← (the factorised matrix)⁻¹ x.
  void solve(const Compiled& m, const Workspace<T>& w, T* x);
  /// x ← A⁻¹ (x − penalty·Φzᵀ α φ), without drives. α φ is no force on the bodies, which the penalty would
  /// make large: with ψ = Lᵀ (φ + Φz x), L Lᵀ the penalties, it belongs to the equation of ψ.
  void solve_with_forces(const Compiled& m, const Workspace<T>& w, double penalty, const double* alpha,
                         const double* phi, T* x);
  /// Φz x of those equations that couple bodies, by the forces ψ of solve_with_forces().
  void moved(double penalty, const double* alpha, const double* phi, double* out) const;
  /// The factors, to save and restore.
  void transfer(StateTransfer& transfer) { transfer(couplings_, pivots_); }

 private:
  /// Where a node's numbers begin.
  struct Places {
    std::size_t pivot = 0, coupling = 0, inertia = 0, unknown = 0, half = 0;
  };
  T* pivots(std::size_t i) { return pivots_.data() + places_[i].pivot; }
  T* couplings(std::size_t i) { return couplings_.data() + places_[i].coupling; }
  T* inertia(std::size_t i) { return inertias_.data() + places_[i].inertia; }

  template <class Marks>
  void add_elements(const Compiled& m, Workspace<T>& w, const MatrixWeights& weights, Marks& marks);
  void add_grounded(const Compiled& m, Workspace<T>& w, const GroundElement& on,
                    const MatrixWeights& weights);
  void add_rows(const CoupledRows& r);
  void add_moved_rows(std::size_t i);
  template <class Size>
  int eliminate_node(const Compiled& m, Workspace<T>& w, const T* q, std::size_t i, Size size);
  void add_motion_to_parent(const Compiled& m, const Workspace<T>& w, std::size_t i);
  void add_forces_to_parent(const Compiled& m, const Workspace<T>& w, std::size_t i);
  /// With the right-hand sides of forces in `unknowns_`.
  void eliminate_and_spread(const Compiled& m, const Workspace<T>& w, T* x);
  /// ψ of coupled rows among the unknowns.
  std::size_t place_of(const CoupledRows& r, int k) const {
    return places_[static_cast<std::size_t>(r.node)].unknown + static_cast<std::size_t>(r.unknown + k);
  }
  T& force(const CoupledRows& r, int k) { return unknowns_[place_of(r, k)]; }
  const T& force(const CoupledRows& r, int k) const { return unknowns_[place_of(r, k)]; }
  void gather(const Compiled& m, const Workspace<T>& w, std::size_t i);
  void spread(const Compiled& m, const Workspace<T>& w, std::size_t i);
  const T* carrier_subspace(const Compiled& m, const Workspace<T>& w, std::size_t i, int& stride) const;

  TransferPlan plan_;
  std::vector<Places> places_;
  std::vector<T> couplings_, pivots_, inertias_;  ///< C, then K; D, then its L Δ Lᵀ; P, then A
  std::vector<T> unknowns_, halves_;              ///< x; e, then z
  std::vector<T> scaled_, signs_;                 ///< of coupled rows: J' and σ
};

template <class T>
TransferMatrices<T>::TransferMatrices(const Compiled& m) : plan_(m), places_(plan_.nodes.size()) {
  Places next;
  for (std::size_t i = 0; i < plan_.nodes.size(); ++i) {
    const TransferNode& node = plan_.nodes[i];
    const auto n = static_cast<std::size_t>(node.unknowns), size = static_cast<std::size_t>(node.size);
    places_[i] = next;
    next.pivot += n * n;
    next.coupling += n * size;
    next.inertia += size * size;
    next.unknown += n;
    next.half += size;
  }
  pivots_.assign(next.pivot, T(0));
  couplings_.assign(next.coupling, T(0));
  inertias_.assign(next.inertia, T(0));
  unknowns_.assign(next.unknown, T(0));
  halves_.assign(next.half, T(0));
  scaled_.assign(plan_.scaled, T(0));
  signs_.assign(plan_.signs, T(0));
}

/// A force element between a body and the ground: an inertia of its covectors at its place on the body.
template <class T>
void TransferMatrices<T>::add_grounded(const Compiled& m, Workspace<T>& w, const GroundElement& on,
                                       const MatrixWeights& weights) {
  const ElementData& e = m.elements[on.element];
  const ElementState<T> state = element_state(e, w.elements.data());
  if (e.inertia < 0 && !acts(state)) return;
  T W[36], covectors[36], A[36] = {};
  tangent_of(w, e, state, weights, W);
  const Vec3<T>& place = w.frames[e.frame_b].position;
  for (int r = 0; r < e.count; ++r) {
    const Vec3<T> linear = state.linear_of(r);
    Vec3<T> angular = place.cross(linear);
    if (has_moment(e.measure)) angular += state.angular_of(r);
    for (int i = 0; i < 3; ++i) {
      covectors[6 * r + i] = linear[i];
      covectors[6 * r + 3 + i] = angular[i];
    }
  }
  for (int r = 0; r < e.count; ++r)
    for (int c = 0; c < e.count; ++c)
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j)
          A[6 * i + j] += W[r * e.count + c] * covectors[6 * r + i] * covectors[6 * c + j];
  const auto i = static_cast<std::size_t>(on.body);
  const TransferNode& node = plan_.nodes[i];
  const MotionSubspace& set = m.subspaces[on.subspace];
  add_inertia(A, 6, w.subspaces.data() + set.offset, set.stride, node.coordinates, inertia(i), node.size,
              couplings(i), pivots(i), node.unknowns);
}

/// Tangents of single coordinates and of what acts between a body and the ground.
template <class T>
template <class Marks>
void TransferMatrices<T>::add_elements(const Compiled& m, Workspace<T>& w, const MatrixWeights& weights,
                                       Marks& marks) {
  for (std::size_t k = 0; k < m.elements.size(); ++k) {
    const ElementData& e = m.elements[k];
    if (!e.marked && e.body < 0) continue;
    const ElementState<T> state = element_state(e, w.elements.data());
    if (e.marked) marks.element(k, state, weights);
    if (e.body < 0) continue;
    const auto i = static_cast<std::size_t>(e.body);
    T W;
    tangent_of(w, e, state, weights, &W);
    pivots(i)[e.local * (plan_.nodes[i].unknowns + 1)] += W;
  }
  for (const GroundElement& on : plan_.grounded) add_grounded(m, w, on, weights);
}

/// Coupled rows of a single body to its coordinates; of others −σ where their forces end.
template <class T>
void TransferMatrices<T>::add_rows(const CoupledRows& r) {
  const auto i = static_cast<std::size_t>(r.node);
  const int n = plan_.nodes[i].unknowns;
  T* D = pivots(i);
  const T* signs = signs_.data() + r.signs;
  if (r.unknown >= 0) {
    for (int k = 0; k < r.count; ++k) D[(r.unknown + k) * (n + 1)] -= signs[k];
    return;
  }
  const PathEntry& e = r.path->entries[0];
  for (int k = 0; k < r.count; ++k) {
    const T* row = scaled_.data() + r.scaled + k * r.path->width + e.offset;
    for (int a = 0; a < e.count; ++a) {
      const T factor = signs[k] * row[a];
      for (int b = 0; b <= a; ++b) D[a * n + b] += factor * row[b];
    }
  }
}

/// The body's part of coupled rows of several bodies.
template <class T>
void TransferMatrices<T>::add_moved_rows(std::size_t i) {
  const TransferNode& node = plan_.nodes[i];
  for (const RowsOfBody& of : node.moves) {
    const CoupledRows& r = plan_.rows[static_cast<std::size_t>(of.rows)];
    const PathEntry& e = r.path->entries[static_cast<std::size_t>(of.entry)];
    for (int k = 0; k < r.count; ++k) {
      const T* row = scaled_.data() + r.scaled + k * r.path->width + e.offset;
      if (of.place >= 0)
        for (int a = 0; a < e.count; ++a) couplings(i)[a * node.size + of.place + k] += row[a];
      else
        for (int a = 0; a < e.count; ++a) pivots(i)[(-1 - of.place + k) * node.unknowns + a] += row[a];
    }
  }
}

/// Motion subspace at the frame that carries a body's joint, of the parent's coordinates.
template <class T>
const T* TransferMatrices<T>::carrier_subspace(const Compiled& m, const Workspace<T>& w, std::size_t i,
                                               int& stride) const {
  const MotionSubspace& set = carrier(m, m.bodies[i]);
  stride = set.stride;
  return w.subspaces.data() + set.offset;
}

/// A of the motion that carries a joint, to the parent of its body.
template <class T>
void TransferMatrices<T>::add_motion_to_parent(const Compiled& m, const Workspace<T>& w, std::size_t i) {
  const TransferNode& node = plan_.nodes[i];
  const auto p = static_cast<std::size_t>(node.parent);
  if (p == m.bodies.size()) return;  // the ground does not move
  const TransferNode& up = plan_.nodes[p];
  int s = 0;
  const T* S = carrier_subspace(m, w, i, s);
  if (node.size == 6 && up.size == 6)
    add_inertia(inertia(i), 6, S, s, up.coordinates, inertia(p), std::integral_constant<int, 6>(),
                couplings(p), pivots(p), up.unknowns);
  else
    add_inertia(inertia(i), node.size, S, s, up.coordinates, inertia(p), up.size, couplings(p), pivots(p),
                up.unknowns);
}

/// A of the forces that pass a joint, with the motion and among each other, to where they are at the parent.
template <class T>
void TransferMatrices<T>::add_forces_to_parent(const Compiled& m, const Workspace<T>& w, std::size_t i) {
  const TransferNode& node = plan_.nodes[i];
  const auto p = static_cast<std::size_t>(node.parent);
  const TransferNode& up = plan_.nodes[p];
  T *P = inertia(p), *C = couplings(p), *D = pivots(p);
  int s = 0;
  const T* S = p < m.bodies.size() ? carrier_subspace(m, w, i, s) : nullptr;
  for (std::size_t j = 0; j < node.passes.size(); ++j) {
    const T* row = inertia(i) + (6 + j) * static_cast<std::size_t>(node.size);
    const int to = node.passes[j], unknown = -1 - to;
    if (S) {
      for (int k = 0; k < 6; ++k) {
        if (to < 0) {
          C[unknown * up.size + k] += row[k];
          continue;
        }
        P[to * up.size + k] += row[k];
        P[k * up.size + to] += row[k];
      }
      for (int r = 0; r < up.coordinates; ++r) {
        T sum = T(0);
        for (int k = 0; k < 6; ++k) sum += S[k * s + r] * row[k];
        (to >= 0 ? C[r * up.size + to] : D[unknown * up.unknowns + r]) += sum;
      }
    }
    for (std::size_t k = 0; k <= j; ++k) {
      const T x = row[6 + k];
      const int other = node.passes[k];
      if (to >= 0 && other >= 0) {
        P[to * up.size + other] += x;
        if (k < j) P[other * up.size + to] += x;
      } else if (to < 0 && other < 0) {
        D[std::max(unknown, -1 - other) * up.unknowns + std::min(unknown, -1 - other)] += x;
      } else {
        C[(to < 0 ? unknown : -1 - other) * up.size + std::max(to, other)] += x;
      }
    }
  }
}

/// A body's own part, and the elimination of its unknowns; as eliminate() returns.
template <class T>
template <class Size>
int TransferMatrices<T>::eliminate_node(const Compiled& m, Workspace<T>& w, const T* q, std::size_t i,
                                        Size size) {
  const int n = plan_.nodes[i].unknowns;
  if (i < m.bodies.size()) add_body<T>(m, w, q, i, inertia(i), size, couplings(i), pivots(i), n);
  return eliminate<T>(n, pivots(i), couplings(i), inertia(i), size);
}

template <class T>
template <class Marks>
int TransferMatrices<T>::factor(const Compiled& m, Workspace<T>& w, const T* q, const MatrixWeights& weights,
                                const double* penalty, Marks marks) {
  for (std::vector<T>* all : {&inertias_, &couplings_, &pivots_}) std::fill(all->begin(), all->end(), T(0));
  coupled_jacobian(m, w, plan_);
  add_elements(m, w, weights, marks);
  for (const DriveData& d : m.drives) {
    const auto i = static_cast<std::size_t>(d.body);
    pivots(i)[d.local * (plan_.nodes[i].unknowns + 1)] += weights.penalty * penalty[d.equation];
  }
  for (const CoupledRows& r : plan_.rows) {
    scale_rows(m, w, r, weights, penalty, scaled_.data() + r.scaled, signs_.data() + r.signs);
    add_rows(r);
  }
  for (std::size_t i = 0; i < m.bodies.size(); ++i) {
    if (m.bodies[i].modes > 0)
      add_modal_tangent<T>(m, w, i, q, weights, pivots_.data(),
                           {static_cast<std::ptrdiff_t>(places_[i].pivot), plan_.nodes[i].unknowns, 1},
                           marks);
    add_moved_rows(i);
  }
  for (std::size_t i = m.bodies.size(); i-- > 0;) {
    const TransferNode& node = plan_.nodes[i];
    const int bad = node.size == 6 ? eliminate_node(m, w, q, i, std::integral_constant<int, 6>())
                                   : eliminate_node(m, w, q, i, node.size);
    if (bad >= 0) return m.bodies[i].v + std::min(bad, std::max(node.coordinates - 1, 0));
    add_motion_to_parent(m, w, i);
    add_forces_to_parent(m, w, i);
  }
  return eliminate_node(m, w, q, m.bodies.size(), plan_.nodes.back().size) < 0 ? -1 : 0;
}

/// e of a node, from those behind it, passed on to its parent; D⁻¹ b of its unknowns.
template <class T>
void TransferMatrices<T>::gather(const Compiled& m, const Workspace<T>& w, std::size_t i) {
  const TransferNode& node = plan_.nodes[i];
  T *x = unknowns_.data() + places_[i].unknown, *e = halves_.data() + places_[i].half;
  const T* K = couplings(i);
  for (int r = 0; r < node.unknowns; ++r)
    for (int c = 0; c < node.size; ++c) e[c] -= K[r * node.size + c] * x[r];
  divide(pivots(i), node.unknowns, x);
  if (node.parent < 0) return;
  const auto p = static_cast<std::size_t>(node.parent);
  T *up_x = unknowns_.data() + places_[p].unknown, *up_e = halves_.data() + places_[p].half;
  if (p < m.bodies.size()) {
    int s = 0;
    const T* S = carrier_subspace(m, w, i, s);
    for (int k = 0; k < 6; ++k) up_e[k] += e[k];
    for (int r = 0; r < plan_.nodes[p].coordinates; ++r)
      for (int k = 0; k < 6; ++k) up_x[r] += S[k * s + r] * e[k];
  }
  for (std::size_t j = 0; j < node.passes.size(); ++j) {
    const int to = node.passes[j];
    (to >= 0 ? up_e[to] : up_x[-1 - to]) += e[6 + j];
  }
}

/// z of a node, from its parent's z and x, and its own x.
template <class T>
void TransferMatrices<T>::spread(const Compiled& m, const Workspace<T>& w, std::size_t i) {
  const TransferNode& node = plan_.nodes[i];
  T *x = unknowns_.data() + places_[i].unknown, *z = halves_.data() + places_[i].half;
  const auto p = static_cast<std::size_t>(node.parent);
  const T *up_x = unknowns_.data() + places_[p].unknown, *up_z = halves_.data() + places_[p].half;
  int s = 0;
  const T* S = p < m.bodies.size() ? carrier_subspace(m, w, i, s) : nullptr;
  for (int k = 0; k < 6; ++k) {
    z[k] = S ? up_z[k] : T(0);
    for (int r = 0; S && r < plan_.nodes[p].coordinates; ++r) z[k] += S[k * s + r] * up_x[r];
  }
  for (std::size_t j = 0; j < node.passes.size(); ++j) {
    const int from = node.passes[j];
    z[6 + j] = from >= 0 ? up_z[from] : up_x[-1 - from];
  }
  const T* K = couplings(i);
  for (int r = 0; r < node.unknowns; ++r)
    for (int c = 0; c < node.size; ++c) x[r] -= K[r * node.size + c] * z[c];
}

template <class T>
void TransferMatrices<T>::solve(const Compiled& m, const Workspace<T>& w, T* x) {
  std::fill(unknowns_.begin(), unknowns_.end(), T(0));
  eliminate_and_spread(m, w, x);
}

template <class T>
void TransferMatrices<T>::solve_with_forces(const Compiled& m, const Workspace<T>& w, double penalty,
                                            const double* alpha, const double* phi, T* x) {
  std::fill(unknowns_.begin(), unknowns_.end(), T(0));
  for (const CoupledRows& r : plan_.rows)
    for (int k = 0; r.equation >= 0 && k < r.count; ++k) {
      const int e = r.equation + k;
      if (r.unknown >= 0) {
        force(r, k) = -std::sqrt(penalty * alpha[e]) * phi[e];
        continue;
      }
      const T weighted = -penalty * alpha[e] * phi[e];
      add_rows_transposed<1>(*r.path, w.jacobian.data() + r.jacobian + k * r.path->width, &weighted, x);
    }
  eliminate_and_spread(m, w, x);
}

template <class T>
void TransferMatrices<T>::moved(double penalty, const double* alpha, const double* phi, double* out) const {
  for (const CoupledRows& r : plan_.rows)
    for (int k = 0; r.equation >= 0 && r.unknown >= 0 && k < r.count; ++k) {
      const int e = r.equation + k;
      if (const double root = std::sqrt(penalty * alpha[e]); root > 0) out[e] = force(r, k) / root - phi[e];
    }
}

template <class T>
void TransferMatrices<T>::eliminate_and_spread(const Compiled& m, const Workspace<T>& w, T* x) {
  std::fill(halves_.begin(), halves_.end(), T(0));
  const std::size_t bodies = m.bodies.size();
  for (std::size_t i = 0; i < bodies; ++i)
    std::copy_n(x + m.bodies[i].v, m.bodies[i].size(), unknowns_.data() + places_[i].unknown);
  for (std::size_t i = bodies; i-- > 0;) gather(m, w, i);
  gather(m, w, bodies);
  for (std::size_t i = 0; i < bodies; ++i) {
    spread(m, w, i);
    std::copy_n(unknowns_.data() + places_[i].unknown, m.bodies[i].size(), x + m.bodies[i].v);
  }
}

}  // namespace mimbre::relative
