#pragma once
#include <type_traits>

#include "dynamics/flexible.h"
#include "dynamics/frame_turn.h"
#include "dynamics/relative/kinematics.h"
#include "dynamics/relative/workspace.h"
#include "dynamics/system.h"
#include "forces/measure.h"
#include "math/four.h"

/// Mass matrix by composite inertias, Jacobian rows, and their assembly into the static sparse matrix.
namespace mimbre::relative {

/// out = A rows: three padded rows of body-axes components turned to global axes.
template <class T, class R>
void rotate_rows(const Mat3<T>& A, const R* rows, int stride, T* out) {
  const R *x = rows, *y = x + stride, *z = y + stride;
  for (int r = 0; r < 3; ++r) {
    const T a = A(r, 0), b = A(r, 1), c = A(r, 2);
    T* o = out + r * stride;
    for (int k = 0; k < stride; k += 8)
      for (int j = k; j < k + 8; ++j) o[j] = multiply_add(c, z[j], multiply_add(b, y[j], T(a * x[j])));
  }
}

/// Angular velocity of the frame by unit rates of the amplitudes: three padded rows, turned by A.
template <class T>
void turn_rows(const FrameData& f, const T* y, const Mat3<T>& A, int stride, T* out) {
  if (f.turn != FrameTurn::exponential) return other_turn_rows(f, y, A, stride, out);
  const Vec3<T> theta = times(f.X_theta, y);
  rotate_rows<T>(A * left_jacobian<T>(theta), f.X_theta.data(), stride, out);
}

/// out += p × columns of three padded rows.
template <class T>
void add_cross_rows(const Vec3<T>& p, const T* rows, int stride, T* out) {
  const T *x = rows, *y = x + stride, *z = y + stride;
  T *ox = out, *oy = ox + stride, *oz = oy + stride;
  for (int k = 0; k < stride; k += 8)
    for (int j = k; j < k + 8; ++j) {
      ox[j] = multiply_add(T(-p[2]), y[j], multiply_add(p[1], z[j], ox[j]));
      oy[j] = multiply_add(T(-p[0]), z[j], multiply_add(p[2], x[j], oy[j]));
      oz[j] = multiply_add(T(-p[1]), x[j], multiply_add(p[0], y[j], oz[j]));
    }
}

/// Motion subspaces of a body's coordinates at each of its frames: velocity of the body's point at the common
/// point (rows 0..2) and angular velocity (rows 3..5) per unit velocity coordinate.
template <class T>
void motion_subspaces(const Compiled& m, Workspace<T>& w, const T* q) {
  for (const MotionSubspace& set : m.subspaces) {
    const BodyData& b = m.bodies[set.body];
    T* c = w.subspaces.data() + set.offset;
    const int s = set.stride;
    for (int k = 0; k < 6 * s; ++k) c[k] = T(0);
    for (int j = 0; j < b.joint_velocities; ++j)
      for (int r = 0; r < 3; ++r) {
        c[r * s + j] = w.joint_linear[b.v + j][r];
        c[(3 + r) * s + j] = w.joint_angular[b.v + j][r];
      }
    if (b.modes == 0) continue;
    const auto add_frame = [&](const FrameData& f, const Vec3<T>& position, const T& sign) {
      const Mat3<T>& A = w.bodies[set.body].rotation;
      const int fs = static_cast<int>(f.X.cols());
      T *linear = w.scratch.data(), *angular = linear + 3 * fs, *y = angular + 3 * fs;
      const FlexibleData& flexible = m.flexible[b.flexible];
      copy_modes(b, q + b.q + b.joint_positions, fs, y);
      extend(flexible, y);
      rotate_rows<T>(A, f.X.data(), fs, linear);
      for (int r = 0; r < 3; ++r) fold(flexible, y, linear + r * fs);
      if (f.turns) {
        turn_rows<T>(f, y, A, fs, angular);
        add_cross_rows<T>(position, angular, fs, linear);
      }
      T* out = c + b.joint_velocities;
      for (int r = 0; r < 3; ++r)
        for (int k = 0; k < b.modes; ++k) {
          out[r * s + k] += sign * linear[r * fs + k];
          if (f.turns) out[(3 + r) * s + k] += sign * angular[r * fs + k];
        }
    };
    if (set.frame >= 0) add_frame(m.frames[set.frame], w.frames[set.frame].position, T(1));
    const FrameData& own = m.frames[b.outboard_frame];
    if (own.flexible >= 0) {
      // The inboard side holds the outboard frame: where modes move that frame in the body, the body moves
      // the opposite way in space.
      Motion<T> at;
      T* y = w.scratch.data() + 8 * own.X.cols();  // behind add_frame's part
      for (int k = 0; k < 3 * own.X.cols(); ++k) y[k] = T(0);
      for (int k = 0; k < b.modes; ++k) y[k] = q[b.q + b.joint_positions + k];
      extend(m.flexible[b.flexible], y);
      frame_motion<T>(own, w.bodies[set.body], y, y + own.X.cols(), y + 2 * own.X.cols(), at);
      add_frame(own, at.position, T(-1));
    }
  }
}

/// The product below for rows that lie next to each other, of a count that the compiler knows: the left side
/// stays in registers. Reads, and writes back unchanged, up to three values beyond the last row.
template <int count>
void add_columns(const double* left, int left_stride, int rows, const double* right, int right_stride,
                 int cols, double* values, int col_stride) {
  for (int r = 0; r < rows; r += 4) {
    Four side[count];
    for (int k = 0; k < count; ++k) side[k] = load_four(left + k * left_stride + r);
    for (int c = 0; c < cols; ++c) {
      Four sum{};
      for (int k = 0; k < count; ++k) sum = multiply_add(side[k], four_of(right[k * right_stride + c]), sum);
      double* out = values + c * col_stride + r;
      const Four old = load_four(out), fresh = old + sum;
      store_four(out, rows - r >= 4 ? fresh : first_lanes(rows - r, fresh, old));
    }
  }
}

/// f(std::integral_constant) of a count from 0 to 6, as of the rows of one element or of a motion subspace.
template <class F>
void with_count(int count, const F& f) {
  switch (count) {
    case 1:
      return f(std::integral_constant<int, 1>());
    case 2:
      return f(std::integral_constant<int, 2>());
    case 3:
      return f(std::integral_constant<int, 3>());
    case 4:
      return f(std::integral_constant<int, 4>());
    case 5:
      return f(std::integral_constant<int, 5>());
    case 6:
      return f(std::integral_constant<int, 6>());
    default:
      return;
  }
}

/// out(r, c) += Σ_k left(k, r) right(k, c), k < count, into the sparse matrix; rows padded to the strides.
template <class T>
void add_product(const T* left, int left_stride, int rows, const T* right, int right_stride, int cols,
                 int count, T* values, const linalg::BlockPlace& place) {
  if (place.row_stride != 1)  // the columns lie next to each other: exchange the roles
    return add_product(right, right_stride, cols, left, left_stride, rows, count, values,
                       {place.offset, place.col_stride, place.row_stride});
  if constexpr (std::is_same_v<T, double>)
    return with_count(count, [&](auto known) {
      add_columns<known>(left, left_stride, rows, right, right_stride, cols, values + place.offset,
                         place.col_stride);
    });
  for (int c = 0; c < cols; ++c) {
    T* out = values + place.offset + c * place.col_stride;
    for (int r = 0; r < rows; r += 4) {
      T sum[4];
      for (int j = 0; j < 4; ++j) sum[j] = T(0);
      for (int k = 0; k < count; ++k) {
        const T x = right[k * right_stride + c];
        const T* l = left + k * left_stride + r;
        for (int j = 0; j < 4; ++j) sum[j] = multiply_add(l[j], x, sum[j]);
      }
      const int n = rows - r < 4 ? rows - r : 4;
      for (int j = 0; j < n; ++j) out[r + j] += sum[j];
    }
  }
}

/// Spatial inertia about the common point times six-row columns: F = [m s + ω × m̄; m̄ × s + J ω].
template <class T>
void composite_times(const typename Workspace<T>::Composite& c, const T* columns, int stride, T* out) {
  const Mat3<T> J = c.second.trace() * Mat3<T>::Identity() - c.second;
  const T m = c.mass, x = c.moment[0], y = c.moment[1], z = c.moment[2];
  const T *s0 = columns, *s1 = s0 + stride, *s2 = s1 + stride, *w0 = s2 + stride, *w1 = w0 + stride,
          *w2 = w1 + stride;
  T *f0 = out, *f1 = f0 + stride, *f2 = f1 + stride, *n0 = f2 + stride, *n1 = n0 + stride, *n2 = n1 + stride;
  for (int k = 0; k < stride; ++k) {
    f0[k] = multiply_add(T(-y), w2[k], multiply_add(z, w1[k], T(m * s0[k])));
    f1[k] = multiply_add(T(-z), w0[k], multiply_add(x, w2[k], T(m * s1[k])));
    f2[k] = multiply_add(T(-x), w1[k], multiply_add(y, w0[k], T(m * s2[k])));
    const auto turned = [&](int r) {
      return multiply_add(J(r, 2), w2[k], multiply_add(J(r, 1), w1[k], T(J(r, 0) * w0[k])));
    };
    n0[k] = multiply_add(y, s2[k], multiply_add(T(-z), s1[k], turned(0)));
    n1[k] = multiply_add(z, s0[k], multiply_add(T(-x), s2[k], turned(1)));
    n2[k] = multiply_add(x, s1[k], multiply_add(T(-y), s0[k], turned(2)));
  }
}

/// Own inertia of a body in its axes, about its origin.
template <class T>
struct OwnInertia {
  T mass;
  Vec3<T> first;   ///< ∫ r dm
  Mat3<T> second;  ///< ∫ r rᵀ dm
};

/// The deformed inertia of a flexible body, and its coupling with the modes (6 × s at `elastic`, modes from
/// column joint_velocities on).
template <class T>
[[gnu::always_inline]] inline void add_flexible_inertia(const Compiled& m, Workspace<T>& w, std::size_t i,
                                                        const T* q, OwnInertia<T>& own, T* elastic) {
  const BodyData& b = m.bodies[i];
  const Mat3<T>& A = w.bodies[i].rotation;
  const int s = m.subspaces[b.subspace].stride;
  const FlexibleData& f = m.flexible[b.flexible];
  const int fs = f.stride;
  T* y = w.scratch.data();
  copy_modes(b, q + b.q + b.joint_positions, fs, y);
  extend(f, y);
  T* integrals = w.integrals.data() + w.integral_offset[i];
  const InertiaRows<T> rows = inertia_rows<T>(b, f, integrals);
  const ConstantInertia constant = constant_inertia(m, w, b);
  if (w.projections.empty()) {
    own.first = deformed_first_moment<T>(b, f, y);
    own.second = deformed_second_moment<T>(b, f, rows, y);
  } else if constexpr (std::is_same_v<T, double>) {
    own.mass = constant.mass;
    projection::rigid_mass(w.projections[b.flexible], w.projection, y, own.first, own.second, integrals);
  }
  T *linear = y + fs, *crossed = linear + 3 * fs, *angular = crossed + 3 * fs;
  if (b.elastodynamic) return;
  rotate_rows<T>(A, constant.S.data(), fs, linear);
  if (turns_undeformed(b)) {
    for (int k = 0; k < 3 * fs; ++k) crossed[k] = T(f.C.data()[k]);
  } else {
    const bool turns = !b.neglected.has(InertiaTerm::rotation_coupling);
    const T* positions = rows.of(InertiaTerm::rotation_coupling_deformed);
    for (int r = 0; r < 3; ++r) {  // C_a = S'^b_c − S'^c_b, (a, b, c) cyclic
      const T *plus = positions + (3 * ((r + 1) % 3) + (r + 2) % 3) * fs,
              *minus = positions + (3 * ((r + 2) % 3) + (r + 1) % 3) * fs;
      for (int k = 0; k < fs; ++k) crossed[r * fs + k] = turns ? plus[k] - minus[k] : T(0);
    }
  }
  rotate_rows<T>(A, crossed, fs, angular);
  add_cross_rows<T>(w.bodies[i].position, linear, fs, angular);
  for (int r = 0; r < 3; ++r) {
    fold(f, y, linear + r * fs);
    fold(f, y, angular + r * fs);
  }
  if (!f.products.empty()) fold(f, y, constant.modal_mass, w.folded.data());
  T* out = elastic + b.joint_velocities;
  for (int r = 0; r < 3; ++r)
    for (int k = 0; k < b.modes; ++k) {
      out[r * s + k] += linear[r * fs + k];
      out[(3 + r) * s + k] += angular[r * fs + k];
    }
}

/// Adds to a flexible body's diagonal block what its modes contribute; `own`: its motion subspace, `force`:
/// the composite inertia times it, to which the coupling is added.
template <class T>
[[gnu::always_inline]] inline void add_modal_mass(const Compiled& m, Workspace<T>& w, std::size_t i,
                                                  const T* own, const T* elastic, T* force, T* values) {
  const BodyData& b = m.bodies[i];
  const linalg::BlockPlace& diagonal = m.diagonal[i];
  const int s = m.subspaces[b.subspace].stride, n = b.size();
  // Diagonal block: bᵀ(Mc b + H) + (H part of elastic columns)ᵀ b + elastic–elastic.
  add_product<T>(elastic, s, n, own, s, n, 6, values, diagonal);
  for (int k = 0; k < 6 * s; ++k) force[k] += elastic[k];
  const FlexibleData& f = m.flexible[b.flexible];
  const auto add = [&](const auto* modal_mass) {
    for (int c = 0; c < b.modes; ++c)
      for (int r = 0; r < b.modes; ++r)
        values[diagonal.offset + (b.joint_velocities + r) * diagonal.row_stride +
               (b.joint_velocities + c) * diagonal.col_stride] += modal_mass[r * f.stride + c];
  };
  if (f.products.empty())
    add(constant_inertia(m, w, b).modal_mass.data());
  else
    add(w.folded.data());
}

/// The share of a parent's modes in the inertia of the subtree at a body, where they move the joint's frame.
template <class T>
[[gnu::always_inline]] inline void add_modes_of_parent(const Compiled& m, Workspace<T>& w, std::size_t i,
                                                       T* values) {
  const BodyData& b = m.bodies[i];
  const FrameData& frame = m.frames[b.inboard_frame];
  if (frame.flexible < 0) return;
  const BodyData& parent = m.bodies[b.parent];
  const MotionSubspace& set = m.subspaces[frame.subspace];
  const MotionSubspace& parent_set = m.subspaces[parent.subspace];
  const int ps = set.stride;
  // φ: what the modes add at the frame to the motion of the body frame.
  T* phi = w.scratch.data();
  T* phi_force = phi + 6 * ps;
  const T* at_frame = w.subspaces.data() + set.offset;
  const T* at_body = w.subspaces.data() + parent_set.offset;
  for (int k = 0; k < 6 * ps; ++k) phi[k] = at_frame[k] - at_body[k];
  composite_times<T>(w.composites[i], phi, ps, phi_force);
  T* parent_elastic = w.elastic_forces.data() + w.elastic_offset[b.parent];
  for (int k = 0; k < 6 * ps; ++k) parent_elastic[k] += phi_force[k];
  add_product<T>(phi, ps, parent.size(), phi_force, ps, parent.size(), 6, values, m.diagonal[b.parent]);
}

/// Adds a body's own inertia about the common point to `composite`, and to `elastic` (six rows, zero or what
/// its children have added) the coupling of its modes with the motion of its frame. Where it has modes whose
/// matrix is not constant, w.folded becomes their mass matrix.
template <class T>
[[gnu::always_inline]] inline void add_own_inertia(const Compiled& m, Workspace<T>& w, std::size_t i,
                                                   const T* q, typename Workspace<T>::Composite& composite,
                                                   T* elastic) {
  const BodyData& b = m.bodies[i];
  const Motion<T>& motion = w.bodies[i];
  const Mat3<T>& A = motion.rotation;
  // Own inertia about the common point: r = p + A r̄.
  OwnInertia<T> inertia{T(b.mass), b.first_moment.template cast<T>(), b.second_moment.template cast<T>()};
  if (b.modes > 0) add_flexible_inertia(m, w, i, q, inertia, elastic);
  const Vec3<T>& p = motion.position;
  const Vec3<T> first_global = A * inertia.first;
  composite.mass += inertia.mass;
  composite.moment += inertia.mass * p + first_global;
  const Mat3<T> mixed = p * first_global.transpose();
  composite.second +=
      inertia.mass * p * p.transpose() + mixed + mixed.transpose() + A * inertia.second * A.transpose();
}

/// Adds the mass matrix (composite sums from the leaves, Lugrís 2008, 2.132–2.156) to the sparse values,
/// after motion_subspaces(). By shape integrals it needs w.integrals at the same amplitudes (residual writes
/// them).
template <class T>
void mass(const Compiled& m, Workspace<T>& w, const T* q, T* values) {
  for (auto& c : w.composites) {
    c.mass = T(0);
    c.moment.setZero();
    c.second.setZero();
  }
  for (T& x : w.elastic_forces) x = T(0);
  for (std::size_t i = m.bodies.size(); i-- > 0;) {
    const BodyData& b = m.bodies[i];
    const MotionSubspace& body_set = m.subspaces[b.subspace];
    const int s = body_set.stride;
    auto& composite = w.composites[i];
    T* elastic = w.elastic_forces.data() + w.elastic_offset[i];
    add_own_inertia<T>(m, w, i, q, composite, elastic);

    // Force of each coordinate: composite inertia times the body's column, plus the elastic coupling.
    const T* own = w.subspaces.data() + body_set.offset;
    T* force = w.subspace_forces.data();
    composite_times<T>(composite, own, s, force);
    const linalg::BlockPlace& diagonal = m.diagonal[i];
    const int n = b.size();
    if (b.modes > 0) add_modal_mass<T>(m, w, i, own, elastic, force, values);
    add_product<T>(own, s, n, force, s, n, 6, values, diagonal);
    for (const MassPlace& place : m.mass_places[i]) {
      const MotionSubspace& set = m.subspaces[place.subspace];
      add_product<T>(w.subspaces.data() + set.offset, set.stride, m.bodies[place.ancestor].size(), force, s,
                     n, 6, values, place.place);
    }
    if (b.parent < 0) continue;

    auto& up = w.composites[b.parent];
    up.mass += composite.mass;
    up.moment += composite.moment;
    up.second += composite.second;
    add_modes_of_parent(m, w, i, values);
  }
}

/// Adds to one Jacobian row along a path: covector · (motion subspace of the plus side − that of the minus
/// side).
template <class T>
void add_to_row(const Compiled& m, const Workspace<T>& w, const Path& path, const Vec3<T>& linear,
                const Vec3<T>& angular, T* row) {
  for (const PathEntry& e : path.entries) {
    const int s = m.subspaces[e.plus >= 0 ? e.plus : e.minus].stride;
    T* out = row + e.offset;
    const auto add = [&](int set, const T& sign) {
      const T* c = w.subspaces.data() + m.subspaces[set].offset;
      const T factors[6] = {sign * linear[0],  sign * linear[1],  sign * linear[2],
                            sign * angular[0], sign * angular[1], sign * angular[2]};
      for (int k = 0; k < s; k += 4) {
        if constexpr (std::is_same_v<T, double>) {
          Four sum = load_four(out + k);
          for (int i = 0; i < 6; ++i) sum = multiply_add(load_four(c + i * s + k), four_of(factors[i]), sum);
          store_four(out + k, sum);
        } else {
          for (int i = 0; i < 6; ++i)
            for (int j = k; j < k + 4; ++j) out[j] = multiply_add(c[i * s + j], factors[i], out[j]);
        }
      }
    };
    if (e.plus >= 0) add(e.plus, T(1));
    if (e.minus >= 0) add(e.minus, T(-1));
  }
}

/// A row that is nothing else.
template <class T>
void jacobian_row(const Compiled& m, const Workspace<T>& w, const Path& path, const Vec3<T>& linear,
                  const Vec3<T>& angular, T* row) {
  for (int k = 0; k < path.width; ++k) row[k] = T(0);
  add_to_row<T>(m, w, path, linear, angular, row);
}

/// Rows of a constraint: what its terms have along their own paths, and of coordinates in the tree.
template <class T>
void constraint_rows(const Compiled& m, const Workspace<T>& w, const ConstraintData& c, T* rows) {
  const int terms = static_cast<int>(c.terms.size());
  for (int k = 0; k < c.count * c.path.width; ++k) rows[k] = T(0);
  for (int r = 0; r < c.count; ++r)
    for (int t = 0; t < terms; ++t) {
      const ConstraintTerm& term = c.terms[t];
      T* row = rows + r * c.path.width;
      if (term.body >= 0) {
        for (const PathEntry& e : c.path.entries)
          if (e.body == term.body) row[e.offset + term.local] += T(term.factor);
        continue;
      }
      const int k = c.covectors + r * terms + t;
      add_to_row<T>(m, w, term.path, w.constraint_linear[k], w.constraint_angular[k], row);
    }
}

/// The row of a sum, from those of its legs; `rows`: all of the elements' rows.
template <class T>
void sum_row(const Compiled& m, const ElementData& e, T* rows) {
  T* out = rows + e.jacobian;
  for (int k = 0; k < e.path.width; ++k) out[k] = T(0);
  for (const Leg& leg : e.legs) {
    const ElementData& of = m.elements[leg.element];
    if (of.body >= 0) {
      out[leg.offsets[0]] += T(leg.factor);
      continue;
    }
    for (std::size_t i = 0; i < of.path.entries.size(); ++i) {
      const PathEntry& entry = of.path.entries[i];
      for (int k = 0; k < m.bodies[entry.body].size(); ++k)
        out[leg.offsets[i] + k] += T(leg.factor) * rows[of.jacobian + entry.offset + k];
    }
  }
}

/// Rows of what an element measures along its path.
template <class T>
void element_rows(const Compiled& m, Workspace<T>& w, const ElementData& e, const ElementState<T>& s) {
  const Vec3<T>& place = w.frames[e.frame_b].position;
  for (int k = 0; k < e.count; ++k) {
    const Vec3<T> linear = s.linear_of(k);
    Vec3<T> angular = place.cross(linear);
    if (has_moment(e.measure)) angular += s.angular_of(k);
    jacobian_row<T>(m, w, e.path, linear, angular, w.jacobian.data() + e.jacobian + k * e.path.width);
  }
}

/// Jacobian rows of loops and of constraints, after motion_subspaces().
template <class T>
void equation_rows(const Compiled& m, Workspace<T>& w) {
  for (const LoopData& loop : m.loops)
    for (int r = 0; r < loop.count; ++r) {
      const int k = loop.first_equation + r;
      jacobian_row<T>(m, w, loop.path, w.covector_linear[k], w.covector_angular[k],
                      w.jacobian.data() + loop.jacobian + r * loop.path.width);
    }
  for (const ConstraintData& c : m.constraints) constraint_rows<T>(m, w, c, w.jacobian.data() + c.jacobian);
}

/// The same, and of what elements measure, contacts that touch among them.
template <class T>
void jacobian(const Compiled& m, Workspace<T>& w) {
  equation_rows(m, w);
  for (const ElementData& e : m.elements) {
    if (e.path.entries.empty() || e.measure == Measure::sum) continue;
    const ElementState<T> s = element_state(e, w.elements.data());
    if (e.measure == Measure::contact && !acts(s)) continue;
    element_rows(m, w, e, s);
  }
  for (const int k : m.sums) sum_row<T>(m, m.elements[k], w.jacobian.data());
}

/// Adds (weighted rows)ᵀ rows, which is symmetric, to the sparse values.
template <class T>
void add_pairs(const Path& path, const T* weighted, const T* rows, int count, T* values) {
  const int width = path.width;
  for (std::size_t i = 0; i < path.entries.size(); ++i) {
    const PathEntry& e = path.entries[i];
    for (std::size_t j = 0; j <= i; ++j) {
      const PathEntry& f = path.entries[j];
      add_product<T>(weighted + e.offset, width, e.count, rows + f.offset, width, f.count, count, values,
                     path.places[i * (i + 1) / 2 + j]);
    }
  }
}

/// Adds Σ_r weight[r] J_rᵀ J_r to the sparse values. `weighted`: scratch of count × path.width.
template <class T>
void add_squares(const Path& path, const T* rows, int count, const T* weight, T* weighted, T* values) {
  const int width = path.width;
  for (int r = 0; r < count; ++r)
    for (int k = 0; k < width; ++k) weighted[r * width + k] = weight[r] * rows[r * width + k];
  add_pairs(path, weighted, rows, count, values);
}

/// weighted = weight · rows, of n rows: weight(r, c).
template <class T, class Weight>
void weigh_rows(int n, int width, const T* rows, T* weighted, const Weight& weight) {
  for (int r = 0; r < n; ++r) {
    T* out = weighted + r * width;
    for (int c = 0; c < n; ++c) {
      const T factor = weight(r, c);
      if (c == 0)
        for (int k = 0; k < width; ++k) out[k] = factor * rows[k];
      else
        for (int k = 0; k < width; ++k) out[k] += factor * rows[c * width + k];
    }
  }
}

/// Adds Jᵀ (inertia + damping C + stiffness K) J of an element; what has inertia has one component.
template <class T>
void add_element(const ElementData& e, const ElementState<T>& s, const MatrixWeights& weights,
                 const T* numbers, const T* rows, T* weighted, T* values) {
  const int width = e.path.width, n = e.count;
  const T inertia = e.inertia < 0 ? T(0) : numbers[e.inertia];
  if (e.inertia < 0 && !acts(s)) return;
  weigh_rows<T>(n, width, rows, weighted, [&](int r, int c) {
    return inertia + weights.damping * s.damping[r * n + c] + weights.stiffness * s.stiffness[r * n + c];
  });
  add_pairs(e.path, weighted, rows, n, values);
}

/// Rows of what a pooled contact measures per unit of the coordinates that move each of its spheres.
template <class T>
struct PairRows {
  const Path *path_a, *path_b;
  T *a, *b;  ///< count × path width
};

/// Adds to the matrix what each of the two bodies of a pooled contact feels of its own motion. `tangent`:
/// count × count.
template <class T>
PairRows<T> add_pair(const Compiled& m, Workspace<T>& w, const ElementData& e, const ElementEnds& ends,
                     const ElementState<T>& s, const T* tangent, T* values) {
  const auto& spheres = m.swarms[e.spec].spheres;
  PairRows<T> rows{&spheres[ends.first].path, &spheres[ends.second].path, nullptr, nullptr};
  rows.a = w.jacobian.data() + e.jacobian;
  rows.b = rows.a + e.count * rows.path_a->width;
  const Vec3<T>& place = w.frames[ends.frame_b].position;
  for (int k = 0; k < e.count; ++k) {
    const Vec3<T> linear = s.linear_of(k), angular = place.cross(linear) + s.angular_of(k);
    jacobian_row<T>(m, w, *rows.path_a, -linear, -angular, rows.a + k * rows.path_a->width);
    jacobian_row<T>(m, w, *rows.path_b, linear, angular, rows.b + k * rows.path_b->width);
  }
  for (const auto& [path, of] : {std::pair(rows.path_a, rows.a), std::pair(rows.path_b, rows.b)}) {
    T* const weighted = w.weighted.data();
    const int width = path->width;
    for (int r = 0; r < e.count; ++r)
      for (int k = 0; k < width; ++k) {
        weighted[r * width + k] = T(0);
        for (int c = 0; c < e.count; ++c)
          weighted[r * width + k] += tangent[r * e.count + c] * of[c * width + k];
      }
    add_pairs(*path, weighted, of, e.count, values);
  }
  return rows;
}

/// Adds Σ_r x[r] J_r of n rows of a path to a vector of velocity coordinates.
template <int n, class T>
void add_rows_transposed(const Path& path, const T* rows, const T* x, T* out) {
  for (const PathEntry& e : path.entries) {
    const T* at = rows + e.offset;
    for (int k = 0; k < e.count; ++k) {
      T sum = out[e.first + k];
      for (int r = 0; r < n; ++r) sum = multiply_add(x[r], at[r * path.width + k], sum);
      out[e.first + k] = sum;
    }
  }
}

/// sums[r] = J_r · x of n rows of a path.
template <int n, class T>
void rows_times(const Path& path, const T* rows, const T* x, T* sums) {
  T sum[n];
  for (int r = 0; r < n; ++r) sum[r] = T(0);
  for (const PathEntry& e : path.entries) {
    const T* at = rows + e.offset;
    for (int k = 0; k < e.count; ++k)
      for (int r = 0; r < n; ++r) sum[r] = multiply_add(at[r * path.width + k], x[e.first + k], sum[r]);
  }
  for (int r = 0; r < n; ++r) sums[r] = sum[r];
}

}  // namespace mimbre::relative
