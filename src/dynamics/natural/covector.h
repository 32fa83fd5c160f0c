#pragma once
#include "dynamics/amplitudes.h"
#include "dynamics/flexible.h"
#include "dynamics/frame_turn.h"
#include "dynamics/natural/workspace.h"

/// Generalised forces of what acts on points and axes of bodies, by virtual work with δr0, δu, δv, δw, δy.
namespace mimbre::natural {

/// What acts on one body: on its base vectors, and on its padded modal amplitudes (none: null).
template <class T>
struct Covector {
  Base<T>* base = nullptr;  ///< null: the ground, nothing is collected
  T* modal = nullptr;
  const BaseMotion<T>* body = nullptr;
  const T* y = nullptr;
};

/// g on the frame's origin.
template <class T>
void act_on_point(const FrameData& f, const FrameMotion<T>& frame, const Vec3<T>& g, const Covector<T>& out) {
  if (!out.base) return;
  out.base->col(0) += g;
  for (int i = 0; i < 3; ++i) out.base->col(1 + i) += frame.place[i] * g;
  if (f.flexible >= 0)
    add_transposed<T>(f.X, out.body->position.template rightCols<3>().transpose() * g, out.modal);
}

/// g on the tip of the frame's axis.
template <class T>
void act_on_axis(const FrameData& f, const FrameMotion<T>& frame, int axis, const Vec3<T>& g,
                 const Covector<T>& out) {
  if (!out.base) return;
  for (int i = 0; i < 3; ++i) out.base->col(1 + i) += frame.rotation(i, axis) * g;
  if (!f.turns) return;
  const Vec3<T> turning =
      frame.rotation.col(axis).cross(Vec3<T>(out.body->position.template rightCols<3>().transpose() * g));
  add_moment<T>(f, out.y, turning, out.modal);
}

/// Moment on the frame: ω = ½ Σ e × ė over its axes e.
template <class T>
void act_by_moment(const FrameData& f, const FrameMotion<T>& frame, const Vec3<T>& moment,
                   const Covector<T>& out) {
  for (int axis = 0; axis < 3; ++axis)
    act_on_axis<T>(f, frame, axis, T(0.5) * moment.cross(Vec3<T>(frame.axes.col(axis))), out);
}

/// Force on the origin of b with a moment about it, and on a what balances them.
template <class T>
void act_between(const Compiled& m, int frame_a, int frame_b, const FrameMotion<T>& a,
                 const FrameMotion<T>& b, const Vec3<T>& force, const Vec3<T>& moment,
                 const Covector<T>& on_a, const Covector<T>& on_b) {
  act_on_point<T>(m.frames[frame_b], b, force, on_b);
  act_by_moment<T>(m.frames[frame_b], b, moment, on_b);
  act_on_point<T>(m.frames[frame_a], a, -force, on_a);
  act_by_moment<T>(m.frames[frame_a], a, -moment - Vec3<T>(b.position - a.position).cross(force), on_a);
}

/// Where the residual collects what acts on a body.
template <class T>
Covector<T> collector(const Compiled& m, const Layout& l, Workspace<T>& w, int body) {
  if (body < 0) return {};
  const int at = l.bodies[body].amplitudes;
  const bool modes = m.bodies[body].modes > 0;
  return {&w.forces[body], modes ? w.modal.data() + at : nullptr, &w.bodies[body],
          modes ? w.y.data() + at : nullptr};
}

/// Adds a covector to a row over a link's columns, `columns` being those of the body's own stencil.
template <class T>
void add_to_row(const Body& b, const Base<T>& base, const T* modal, int modes,
                const std::vector<int>& columns, T* row) {
  for (int k = 0; k < b.unknown; ++k) {
    const Vec3<T> g = base * b.base.col(k).template cast<T>();
    for (int c = 0; c < 3; ++c) row[columns[3 * k + c]] += g[c];
  }
  for (int i = 0; i < modes; ++i) row[columns[3 * b.unknown + i]] += modal[i];
}

/// Adds to a row over the columns of two sides: `act(a, b)` puts its covectors on both bodies.
template <class T, class Act>
void add_row(const Compiled& m, const Layout& l, Workspace<T>& w, const Sides& sides, const Act& act,
             T* row) {
  Base<T> base[2];
  T* modal[2] = {w.row_modal.data(), w.row_modal.data() + w.row_modal.size() / 2};
  Covector<T> covectors[2];
  const int bodies[2] = {sides.body_a, sides.body_b};
  for (int side = 0; side < 2; ++side) {
    if (bodies[side] < 0) continue;
    covectors[side] = collector(m, l, w, bodies[side]);
    base[side].setZero();
    covectors[side].base = &base[side];
    const BodyData& b = m.bodies[bodies[side]];
    if (b.modes == 0) continue;
    covectors[side].modal = modal[side];
    for (int k = 0; k < m.flexible[b.flexible].stride; ++k) modal[side][k] = T(0);
  }
  act(covectors[0], covectors[1]);
  for (int side = 0; side < 2; ++side) {
    if (bodies[side] < 0) continue;
    const BodyData& b = m.bodies[bodies[side]];
    if (b.modes > 0)
      fold(m.flexible[b.flexible], w.y.data() + l.bodies[bodies[side]].amplitudes, modal[side]);
    add_to_row(l.bodies[bodies[side]], base[side], modal[side], m.bodies[bodies[side]].modes,
               side == 0 ? sides.columns_a : sides.columns_b, row);
  }
}

/// One row of a link.
template <class T, class Act>
void fill_row(const Compiled& m, const Layout& l, Workspace<T>& w, const Link& link, const Act& act, T* row) {
  for (int k = 0; k < link.stencil.stride; ++k) row[k] = T(0);
  add_row(m, l, w, link, act, row);
}

}  // namespace mimbre::natural
