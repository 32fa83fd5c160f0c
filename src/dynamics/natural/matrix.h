#pragma once
#include "dynamics/natural/constraints.h"
#include "dynamics/natural/forces.h"
#include "dynamics/natural/inertia.h"
#include "dynamics/system.h"

/// Assembly: every body, joint and force adds a small dense matrix over its stencil.
namespace mimbre::natural {

/// matrix(r, c ≤ r) += Σ weight row_r row_c over the first `size` columns; rows and matrix of this stride.
template <class T>
void add_squares(const T* rows, int count, int size, int stride, const T* weights, T* matrix) {
  for (int e = 0; e < count; ++e) {
    const T* row = rows + static_cast<std::ptrdiff_t>(e) * stride;
    for (int r = 0; r < size; ++r) {
      const T a = weights[e] * row[r];
      if (a == T(0)) continue;
      T* out = matrix + static_cast<std::ptrdiff_t>(r) * stride;
      const int end = pad(r + 1);
      for (int c = 0; c < end; ++c) out[c] += a * row[c];
    }
  }
}

/// matrix(r, c ≤ r) += Σ weights(i, j) row_i row_jᵀ, `weights` symmetric, count × count.
template <class T>
void add_products(const T* rows, int count, int size, int stride, const T* weights, T* matrix) {
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < count; ++j) {
      const T weight = weights[i * count + j];
      if (weight == T(0)) continue;
      const T *left = rows + static_cast<std::ptrdiff_t>(i) * stride,
              *right = rows + static_cast<std::ptrdiff_t>(j) * stride;
      for (int r = 0; r < size; ++r) {
        const T a = weight * left[r];
        if (a == T(0)) continue;
        T* out = matrix + static_cast<std::ptrdiff_t>(r) * stride;
        const int end = pad(r + 1);
        for (int c = 0; c < end; ++c) out[c] += a * right[c];
      }
    }
}

/// Puts the lower triangle of a stencil's matrix where it belongs.
template <class T>
void scatter(const Stencil& s, const T* matrix, T* values) {
  const std::ptrdiff_t* target = s.targets.data();
  const int n = s.size();
  for (int r = 0; r < n; ++r) {
    const T* row = matrix + static_cast<std::ptrdiff_t>(r) * s.stride;
    for (int c = 0; c <= r; ++c) values[*target++] += row[c];
  }
}

/// The links of the two spheres of a pooled contact. Its rows are those of a, then those of b.
struct PairLinks {
  const Link *a = nullptr, *b = nullptr;
};
inline PairLinks links_of(const Layout& l, const ElementData& e, const ElementEnds& ends) {
  const auto& spheres = l.spheres[e.spec];
  return {&spheres[ends.first], &spheres[ends.second]};
}

/// Mass of a flexible body's base vectors, and its coupling with the amplitudes, into the lower triangle of
/// the body's dense matrix. Returns the constant modal mass.
template <class T>
const Rows& add_coupled_mass(const Compiled& m, const Layout& l, Workspace<T>& w, int index, T* matrix) {
  const Body& b = l.bodies[index];
  const BodyData& data = m.bodies[index];
  const FlexibleData& f = m.flexible[data.flexible];
  const int stride = b.stencil.stride, s = f.stride, n = 3 * b.unknown;
  const T* y = w.y.data() + b.amplitudes;
  const Mat3<T> A = w.bodies[index].position.template rightCols<3>();
  // (S, S'^1, S'^2, S'^3): coupling of the base vectors with the amplitudes, body axes.
  T* coupling = w.coupling.data();
  const Rows* modal_mass = &f.mass;
  Eigen::Matrix<T, 4, 4> mass;
  if (w.projections.empty()) {
    const InertiaRows<T> rows = make_inertia_rows<T>(data, f, y, w.integrals.data());
    std::copy(f.S.data(), f.S.data() + 3 * s, coupling);
    const T* turning = rows.of(InertiaTerm::rotation_coupling_deformed);
    if (data.neglected.has(InertiaTerm::rotation_coupling))
      std::fill(coupling + 3 * s, coupling + 12 * s, T(0));
    else
      std::copy(turning, turning + 9 * s, coupling + 3 * s);
    mass = deformed_mass<T>(data, f, rows, y);
  } else {
    const projection::Constants& constants = w.projections[data.flexible];
    modal_mass = &constants.mass;
    mass = projection::base_mass(constants, w.projection, y, coupling);
  }
  for (int k = 0; k < b.unknown; ++k) {
    const Eigen::Matrix<T, 4, 1> column = mass * b.base.col(k).template cast<T>();
    for (int j = 0; j <= k; ++j) {
      const T x = column.dot(b.base.col(j).template cast<T>());
      for (int c = 0; c < 3; ++c) matrix[(3 * k + c) * stride + 3 * j + c] += x;
    }
  }
  for (int r = 0; r < 12; ++r) fold(f, y, coupling + r * s);
  T* rows = w.row_modal.data();
  for (int k = 0; k < b.unknown; ++k) {
    for (int r = 0; r < 3 * s; ++r)
      rows[r] = b.base(0, k) * coupling[r] + b.base(1, k) * coupling[3 * s + r] +
                b.base(2, k) * coupling[6 * s + r] + b.base(3, k) * coupling[9 * s + r];
    for (int i = 0; i < data.modes; ++i)
      for (int c = 0; c < 3; ++c)
        matrix[(n + i) * stride + 3 * k + c] +=
            A(c, 0) * rows[i] + A(c, 1) * rows[s + i] + A(c, 2) * rows[2 * s + i];
  }
  return *modal_mass;
}

/// weight · a matrix over the amplitudes; of second order in them where the body is.
template <class T>
void add_modal(const Compiled& m, const Layout& l, Workspace<T>& w, int index, const Rows& modal,
               double weight, T* matrix) {
  const Body& b = l.bodies[index];
  const BodyData& data = m.bodies[index];
  const FlexibleData& f = m.flexible[data.flexible];
  const int stride = b.stencil.stride, s = f.stride, n = 3 * b.unknown;
  const T* y = w.y.data() + b.amplitudes;
  const T* values = modal.data();
  if (!f.products.empty()) {
    fold(f, y, modal, w.folded.data());
    values = w.folded.data();
  }
  for (int i = 0; i < data.modes; ++i)
    for (int j = 0; j <= i; ++j) matrix[(n + i) * stride + n + j] += weight * values[i * s + j];
}

/// The tangents that depend on the deformation: stretching and bending coupled, and the stiffness of stress
/// by inertia forces.
template <class T>
void add_deformed_stiffness(const Compiled& m, const Layout& l, Workspace<T>& w, int index, double stiffness,
                            T* matrix) {
  const Body& b = l.bodies[index];
  const BodyData& data = m.bodies[index];
  const FlexibleData& f = m.flexible[data.flexible];
  const int stride = b.stencil.stride, s = f.stride, n = 3 * b.unknown;
  const T* y = w.y.data() + b.amplitudes;
  if (f.nonlinear_stiffness) {
    T* curvature = w.folded.data();
    std::fill(curvature, curvature + static_cast<std::ptrdiff_t>(s) * s, T(0));
    add_curvature(f, y, T(stiffness), curvature);
    for (int i = 0; i < data.modes; ++i)
      for (int j = 0; j <= i; ++j) matrix[(n + i) * stride + n + j] += curvature[i * s + j];
  }
  if (f.geometric.empty()) return;
  Base<T> second = w.bodies[index].acceleration;
  second.col(0) -= m.gravity.template cast<T>();
  T* geometric_stiffness = w.folded.data();
  geometric::stiffness(f.geometric,
                       stress_motion(f.geometric, w.bodies[index], second, w.ydd.data() + b.amplitudes), y,
                       geometric_stiffness, w.geometric_scratch.data());
  for (int i = 0; i < data.modes; ++i)
    for (int j = 0; j <= i; ++j)
      matrix[(n + i) * stride + n + j] += stiffness * geometric_stiffness[i * s + j];
}

/// Mass, elastic and damping matrix of a body into the lower triangle of its (cleared) dense matrix.
template <class T>
void body_matrix(const Compiled& m, const Layout& l, Workspace<T>& w, int index, double damping,
                 double stiffness, T* matrix) {
  const Body& b = l.bodies[index];
  const BodyData& data = m.bodies[index];
  const int stride = b.stencil.stride;
  const auto add_masses = [&](const auto& masses) {
    for (int k = 0; k < b.unknown; ++k)
      for (int j = 0; j <= k; ++j)
        for (int c = 0; c < 3; ++c) matrix[(3 * k + c) * stride + 3 * j + c] += T(masses(k, j));
  };
  if (data.modes == 0) {
    add_masses(b.variable_mass);
    return;
  }
  const FlexibleData& f = m.flexible[data.flexible];
  add_modal(m, l, w, index, add_coupled_mass(m, l, w, index, matrix), 1, matrix);
  if (f.absolute()) {
    const int n = 3 * b.unknown;
    ancf::add_tangent(f, w.y.data() + b.amplitudes, stiffness, damping, [&](int r, int c, const T& x) {
      if (c <= r) matrix[(n + r) * stride + n + c] += x;
    });
    return;
  }
  add_modal(m, l, w, index, f.damping, damping, matrix);
  add_modal(m, l, w, index, f.stiffness, stiffness, matrix);
  add_deformed_stiffness(m, l, w, index, stiffness, matrix);
}

/// The rows of Φq: of the rigidity of the base vectors.
template <class T>
void rigidity_rows(const Layout& l, Workspace<T>& w, T* storage) {
  for (std::size_t i = 0; i < l.bodies.size(); ++i) {
    const Body& b = l.bodies[i];
    T* row = storage + b.jacobian;
    for (const Rigidity& e : b.rigidity) {
      for (int k = 0; k < b.stencil.stride; ++k) row[k] = T(0);
      Base<T> base = Base<T>::Zero();
      act_by_rigidity<T>(b, e, w.bodies[i].position, T(1), base);
      for (int k = 0; k < b.unknown; ++k) {
        const Vec3<T> g = base * b.base.col(k).template cast<T>();
        for (int c = 0; c < 3; ++c) row[3 * k + c] = g[c];
      }
      row += b.stencil.stride;
    }
  }
}

/// The rows of Φq: of constraints.
template <class T>
void constraint_rows(const Compiled& m, const Layout& l, Workspace<T>& w, T* storage) {
  for (std::size_t i = 0; i < m.constraints.size(); ++i) {
    const ConstraintData& c = m.constraints[i];
    const ConstraintLink& link = l.constraints[i];
    const int terms = static_cast<int>(c.terms.size());
    T* row = storage + link.jacobian;
    for (int r = 0; r < c.count; ++r, row += link.stencil.stride) {
      for (int k = 0; k < link.stencil.stride; ++k) row[k] = T(0);
      for (int t = 0; t < terms; ++t) {
        const int k = c.covectors + r * terms + t;
        add_row(
            m, l, w, link.terms[t],
            [&](const Covector<T>& a, const Covector<T>& b) {
              act_by_term<T>(m, w, c.terms[t], w.constraint_linear[k], w.constraint_angular[k], a, b);
            },
            row);
      }
    }
  }
}

/// The rows of what elements measure; those of sums follow from their legs'.
template <class T>
void element_rows(const Compiled& m, const Layout& l, Workspace<T>& w, T* storage) {
  for (std::size_t i = 0; i < m.elements.size(); ++i) {
    const ElementData& e = m.elements[i];
    if (e.measure == Measure::none || e.measure == Measure::sum) continue;
    const ElementState<T> s = element_state(e, w.elements.data());
    if (e.measure == Measure::contact && !acts(s)) continue;
    const ElementEnds ends = ends_of(m, e, w.signals.states + e.states);
    const auto act = [&](int k, const Covector<T>& a, const Covector<T>& b) {
      act_by_element(m, w, e, ends.frame_a, ends.frame_b, s, k, T(1), a, b);
    };
    const PairLinks pair = e.pooled ? links_of(l, e, ends) : PairLinks{};
    for (int k = 0; k < e.count; ++k) {
      if (!e.pooled) {
        fill_row(
            m, l, w, l.elements[i], [&](const auto& a, const auto& b) { act(k, a, b); },
            storage + l.elements[i].jacobian + k * l.elements[i].stencil.stride);
        continue;
      }
      T* const rows = storage + l.elements[i].jacobian;
      fill_row(
          m, l, w, *pair.a, [&](const auto&, const auto& a) { act(k, a, {}); },
          rows + k * pair.a->stencil.stride);
      fill_row(
          m, l, w, *pair.b, [&](const auto&, const auto& b) { act(k, {}, b); },
          rows + e.count * pair.a->stencil.stride + k * pair.b->stencil.stride);
    }
  }
  for (const int k : m.sums) {
    const Link& sum = l.elements[k];
    T* row = storage + sum.jacobian;
    std::fill(row, row + sum.stencil.stride, T(0));
    for (std::size_t i = 0; i < sum.legs.size(); ++i) {
      const Leg& leg = m.elements[k].legs[i];
      const T* of = storage + l.elements[leg.element].jacobian;
      for (std::size_t c = 0; c < sum.legs[i].size(); ++c) row[sum.legs[i][c]] += leg.factor * of[c];
    }
  }
}

/// Rows of Φq over the stencils, and of what elements measure.
template <class T>
void jacobian(const Compiled& m, const Layout& l, Workspace<T>& w, const T* q) {
  T* storage = w.jacobian.data();
  rigidity_rows(l, w, storage);
  for (const Joint& j : l.joints) {
    T* row = storage + j.link.jacobian;
    for (const JointEquation& e : j.equations)
      for (int c = 0; c < e.count(); ++c) {
        fill_row(
            m, l, w, j.link,
            [&](const Covector<T>& a, const Covector<T>& b) { act_by_joint<T>(m, w, j, e, c, T(1), a, b); },
            row);
        row += j.link.stencil.stride;
      }
  }
  const auto coordinate = [&](const Link& link, int body, int local) {
    const JointCoordinate& c = l.joint_coordinates[body];
    fill_row(
        m, l, w, link,
        [&](const Covector<T>& a, const Covector<T>& b) {
          act_on_coordinate<T>(m, c, w.frames[c.frame_a], w.frames[c.frame_b], q + c.q, local, T(1), a, b);
        },
        storage + link.jacobian);
  };
  for (std::size_t k = 0; k < m.drives.size(); ++k)
    coordinate(l.drives[k], m.drives[k].body, m.drives[k].local);
  constraint_rows(m, l, w, storage);
  element_rows(m, l, w, storage);
}

}  // namespace mimbre::natural
