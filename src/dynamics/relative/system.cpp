#include "dynamics/relative/system.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/relative/constraints.h"
#include "dynamics/relative/forces.h"
#include "dynamics/relative/kinematics.h"
#include "dynamics/relative/matrix.h"
#include "dynamics/relative/residual.h"
#include "mimbre/diagnostics.h"

namespace mimbre::relative {

template <class T>
Workspace<T>::Workspace(const Compiled& m) : signals(m) {
  // NaN everywhere, so that a value read before it is written shows.
  const T nan = T(std::numeric_limits<double>::quiet_NaN());
  const Vec3<T> nan3 = Vec3<T>::Constant(nan);
  const Mat3<T> nan33 = Mat3<T>::Constant(nan);
  bodies.assign(m.bodies.size(), {nan33, nan3, nan3, nan3, nan3, nan3});
  frames.assign(m.frames.size(), {nan33, nan3, nan3, nan3, nan3, nan3});
  joint_angular.assign(m.velocities, nan3);
  joint_linear.assign(m.velocities, nan3);
  wrenches.assign(m.frames.size(), {nan3, nan3});
  transmitted.assign(m.bodies.size(), {nan3, nan3});
  phi.assign(m.equations, nan);
  phi_dot.assign(m.equations, nan);
  phi_ddot.assign(m.equations, nan);
  covector_linear.assign(m.equations, nan3);
  covector_angular.assign(m.equations, nan3);
  elements.assign(m.element_storage, nan);
  subspaces.assign(m.subspace_storage, nan);
  jacobian.assign(m.jacobian_storage, nan);
  weighted.assign(m.jacobian_storage, nan);
  composites.assign(m.bodies.size(), {nan, nan3, nan33});
  stress.assign(m.bodies.size(), {nan3, nan3, nan3});
  int widest = 8, elastic = 0, integral = 0;
  for (const BodyData& b : m.bodies) {
    widest = std::max(widest, pad(b.size()));
    elastic_offset.push_back(elastic);
    integral_offset.push_back(integral);
    if (b.modes == 0) continue;
    widest = std::max(widest, m.flexible[b.flexible].stride);
    elastic += 6 * pad(b.size());
    integral += 9 * m.flexible[b.flexible].stride;
  }
  subspace_forces.assign(6 * widest, nan);
  elastic_forces.assign(elastic, nan);
  integrals.assign(integral, nan);
  scratch.assign(24 * widest, nan);
  output.assign(3 * widest, nan);
  folded.assign(static_cast<std::size_t>(widest) * widest, nan);
  geometric_scratch.assign(geometric::scratch(m), nan);
}

template struct Workspace<double>;

namespace {

Scales scales_of(const Compiled& m) {
  Scales s;
  s.round_off = round_off_of_positions(m);
  s.coordinates.assign(m.velocities, 1.0);
  s.equations.assign(m.equations, 1.0);
  s.acceleration = m.gravity.norm() / m.length_scale;

  for (const BodyData& b : m.bodies) {
    for (int k = 0; k < b.joint_velocities; ++k)
      if (!is_angle(b.joint, k)) s.coordinates[b.v + k] = m.length_scale;
    for (int k = 0; k < b.modes; ++k) s.coordinates[b.v + b.joint_velocities + k] = amplitude_scale(m, b);
  }
  for (const LoopData& l : m.loops)
    for (int r = 0; r < l.count; ++r)
      if (l.closure[r].kind == LoopClosure::Kind::distance)
        s.equations[l.first_equation + r] = m.length_scale;
  for (const DriveData& d : m.drives) s.equations[d.equation] = s.coordinates[d.v];
  return s;
}

}  // namespace

RelativeSystem::RelativeSystem(const Compiled& model, spec::Simulation::Inertia inertia)
    : model_(model),
      work_(model),
      factor_(*model.symbolic),
      penalty_(model.equations),
      mu_(model.equations),
      weight_(8),
      scales_(scales_of(model)),
      marks_(model) {
  for (const LoopData& loop : model.loops)
    for (int r = 0; r < loop.count; ++r) penalty_[loop.first_equation + r] = model.mass_scale * loop.scale[r];
  for (const DriveData& d : model.drives) penalty_[d.equation] = model.mass_scale * d.scale;

  work_.projections = projection::constants(model, inertia);
  for (const projection::Constants& c : work_.projections) work_.projection.fit(c);
  if (work_.projections.empty()) return;
  for (const BodyData& b : model.bodies) {
    if (b.flexible < 0 || work_.projections[b.flexible].plain) continue;
    const spec::Body& body = model.spec.bodies[b.spec];
    throw InputError(body.mark,
                     fmt::format("the mesh of flexible body '{}' has nodes whose mass depends on the "
                                 "direction, which relative coordinates cannot project; use inertia: "
                                 "integrals",
                                 body.name));
  }
}

void RelativeSystem::begin_step(const double* q) {
  // The first body's joint frame: for a floating root its own origin, otherwise a point on the ground near
  // it.
  if (model_.bodies.empty()) return;
  const BodyData& root = model_.bodies.front();
  const FrameData& base = model_.frames[root.inboard_frame];
  Vec3d at = Vec3d::Zero();
  if (root.joint == spec::JointType::floating && !root.reversed)
    at = Vec3d(q[root.q], q[root.q + 1], q[root.q + 2]);
  work_.origin = base.position + base.rotation * at;
}

[[gnu::flatten]] void RelativeSystem::kinematics(double t, const double* q, const double* v,
                                                 const double* a) {
  relative::kinematics<double>(model_, work_, q, v, a);
  fix_signals(model_.signals, t, work_.signals);
  relative::constraints<double>(model_, work_, q, v, a);
}

[[gnu::flatten]] void RelativeSystem::residual(double t, const double* q, const double* v, const double* a,
                                               const double* multipliers, double factor, double* r) {
  kinematics(t, q, v, a);
  forces(model_, work_, t, q, v, r);
  for (int k = 0; k < model_.equations; ++k) mu_[k] = multipliers[k] + factor * penalty_[k] * work_.phi[k];
  apply_multipliers<double>(model_, work_, mu_.data(), r);
  relative::residual<double>(model_, work_, q, v, a, r);
}

void RelativeSystem::assemble(const double* q, const MatrixWeights& weights) {
  motion_subspaces<double>(model_, work_, q);
  relative::jacobian<double>(model_, work_);
  factor_.set_zero();
  double* values = factor_.values();
  mass<double>(model_, work_, q, values);
  double* marks = marks_.ancf();
  for (std::size_t i = 0; i < model_.bodies.size(); ++i) {
    const BodyData& b = model_.bodies[i];
    if (b.modes == 0) continue;
    const FlexibleData& f = model_.flexible[b.flexible];
    const linalg::BlockPlace& place = model_.diagonal[i];
    double* out = values + place.offset;
    const int n0 = b.joint_velocities;
    if (!f.geometric.empty()) {
      double* y = work_.scratch.data();
      copy_modes(b, q + b.q + b.joint_positions, f.stride, y);
      geometric::stiffness<double>(f.geometric, work_.stress[i], y, work_.folded.data(),
                                   work_.geometric_scratch.data());
      for (int c = 0; c < b.modes; ++c)
        for (int r = 0; r < b.modes; ++r)
          out[(n0 + r) * place.row_stride + (n0 + c) * place.col_stride] +=
              weights.stiffness * work_.folded[r * f.stride + c];
    }
    if (!f.ancf.empty()) {
      double* y = work_.scratch.data();
      copy_modes(b, q + b.q + b.joint_positions, f.stride, y);
      ancf::keep_marks(f, y, marks);
      marks += ancf::marks(f);
      ancf::add_tangent(f, y, weights.stiffness, weights.damping, [&](int r, int c, double x) {
        out[(n0 + r) * place.row_stride + (n0 + c) * place.col_stride] += x;
      });
    } else if (f.diagonal_stiffness) {
      for (int k = 0; k < b.modes; ++k)
        out[(n0 + k) * (place.row_stride + place.col_stride)] +=
            weights.damping * f.damping(k, k) + weights.stiffness * f.stiffness(k, k);
    } else {
      const double* stiffness = f.stiffness.data();
      if (!f.products.empty()) {
        double* y = work_.scratch.data();
        copy_modes(b, q + b.q + b.joint_positions, f.stride, y);
        extend(f, y);
        fold(f, y, f.stiffness, work_.folded.data());
        if (f.nonlinear_stiffness) add_curvature(f, y, 1.0, work_.folded.data());
        stiffness = work_.folded.data();
      }
      for (int c = 0; c < b.modes; ++c)
        for (int r = 0; r < b.modes; ++r)
          out[(n0 + r) * place.row_stride + (n0 + c) * place.col_stride] +=
              weights.damping * f.damping(r, c) + weights.stiffness * stiffness[r * f.stride + c];
    }
  }
  for (std::size_t k = 0; k < model_.elements.size(); ++k) {
    const ElementData& e = model_.elements[k];
    const ElementState<double> state = element_state(e, work_.elements.data());
    if (e.marked) marks_.element(k) = element_tangent(state, weights);
    if (e.body >= 0) {
      const linalg::BlockPlace& place = model_.diagonal[e.body];
      values[place.offset + e.local * (place.row_stride + place.col_stride)] +=
          weights.damping * state.damping[0] + weights.stiffness * state.stiffness[0];
    } else if (!e.path.entries.empty()) {
      add_element<double>(model_, e, state, weights, work_.jacobian.data() + e.jacobian,
                          work_.weighted.data(), values);
    }
  }
  for (const LoopData& loop : model_.loops) {
    for (int r = 0; r < loop.count; ++r) weight_[r] = weights.penalty * penalty_[loop.first_equation + r];
    add_squares<double>(model_, loop.path, work_.jacobian.data() + loop.jacobian, loop.count, weight_.data(),
                        work_.weighted.data(), values);
  }
  for (const DriveData& d : model_.drives) {
    const linalg::BlockPlace& place = model_.diagonal[d.body];
    values[place.offset + d.local * (place.row_stride + place.col_stride)] +=
        weights.penalty * penalty_[d.equation];
  }
}

linalg::FactorStatus RelativeSystem::factor(const double* q, const MatrixWeights& weights) {
  assemble(q, weights);
  return factor_.factor();
}

void RelativeSystem::dense_matrix(const double* q, const MatrixWeights& weights, double* out) {
  assemble(q, weights);
  linalg::to_dense(*model_.symbolic, factor_.values(), out);
}

bool RelativeSystem::tangent_changed(const double* q, const MatrixWeights& weights) const {
  return marks_.changed(model_, work_.elements.data(), weights, [&](std::size_t i) {
    return q + model_.bodies[i].q + model_.bodies[i].joint_positions;
  });
}

void RelativeSystem::multiply(const double* x, double* y) const {
  linalg::multiply(*model_.symbolic, factor_.values(), x, y);
}

void RelativeSystem::add_jacobian_transposed(const double* y, double weight, double* out) const {
  for (const LoopData& loop : model_.loops)
    for (int r = 0; r < loop.count; ++r)
      add_row_transposed<double>(model_, loop.path,
                                 work_.jacobian.data() + loop.jacobian + r * loop.path.width,
                                 weight * y[loop.first_equation + r], out);
  for (const DriveData& d : model_.drives) out[d.v] += weight * y[d.equation];
}

void RelativeSystem::jacobian_times(const double* x, double* out) const {
  for (const LoopData& loop : model_.loops)
    for (int r = 0; r < loop.count; ++r)
      out[loop.first_equation + r] = row_times<double>(
          model_, loop.path, work_.jacobian.data() + loop.jacobian + r * loop.path.width, x);
  for (const DriveData& d : model_.drives) out[d.equation] = x[d.v];
}

std::vector<JacobianEntry> RelativeSystem::jacobian_entries() const {
  std::vector<JacobianEntry> entries;
  for (const LoopData& loop : model_.loops)
    for (int r = 0; r < loop.count; ++r)
      for (const PathEntry& e : loop.path.entries) {
        const BodyData& b = model_.bodies[e.body];
        const double* row = work_.jacobian.data() + loop.jacobian + r * loop.path.width + e.offset;
        for (int k = 0; k < b.size(); ++k) entries.push_back({loop.first_equation + r, b.v + k, row[k]});
      }
  for (const DriveData& d : model_.drives) entries.push_back({d.equation, d.v, 1});
  return entries;
}

void RelativeSystem::temper_prediction(double h, double* x) const {
  for (const BodyData& b : model_.bodies) {
    if (b.modes == 0) continue;
    const FlexibleData& f = model_.flexible[b.flexible];
    if (!f.ancf.empty()) continue;  // nodes move far without strain
    const Rows& modal_mass = constant_inertia(model_, work_, b).modal_mass;
    for (int k = 0; k < b.modes; ++k)
      x[b.v + b.joint_velocities + k] /= 1 + h * h * f.stiffness(k, k) / modal_mass(k, k);
  }
}

void RelativeSystem::retract(const double* q, const double* x, double* out) const {
  for (const BodyData& b : model_.bodies) {
    const JointInfo& info = joint_info(b.joint);
    const double* qb = q + b.q;
    const double* xb = x + b.v;
    double* ob = out + b.q;
    const int plain = info.quaternion < 0 ? info.velocities : info.rotation;
    for (int k = 0; k < plain; ++k) ob[k] = qb[k] + xb[k];
    if (info.quaternion >= 0) {
      const double* p = qb + info.quaternion;
      const double* t = xb + info.rotation;
      Quat<double> r = quaternion_product<double>(Quat<double>(p[0], p[1], p[2], p[3]),
                                                  quaternion_exp<double>(Vec3d(t[0], t[1], t[2])));
      r.normalize();
      for (int k = 0; k < 4; ++k) ob[info.quaternion + k] = r[k];
    }
    for (int k = 0; k < b.modes; ++k)
      ob[info.positions + k] = qb[info.positions + k] + xb[info.velocities + k];
  }
}

void RelativeSystem::compose(double* x, const double* d) const {
  for (const BodyData& b : model_.bodies) {
    const JointInfo& info = joint_info(b.joint);
    double* xb = x + b.v;
    const double* db = d + b.v;
    const int plain = info.quaternion < 0 ? info.velocities : info.rotation;
    for (int k = 0; k < plain; ++k) xb[k] += db[k];
    if (info.quaternion >= 0) {
      double* t = xb + info.rotation;
      const double* s = db + info.rotation;
      const Vec3d u(t[0], t[1], t[2]), v(s[0], s[1], s[2]);
      Vec3d sum;
      if (u.squaredNorm() + v.squaredNorm() < 1e-3) {
        // log(exp u exp v) to third order (Baker, Campbell, Hausdorff): enough for a step of Newton's method,
        // as the positions follow from x itself.
        const Vec3d uv = u.cross(v);
        sum = u + v + 0.5 * uv + (1. / 12) * (u.cross(uv) - v.cross(uv));
      } else {
        sum = quaternion_log<double>(
            quaternion_product<double>(quaternion_exp<double>(u), quaternion_exp<double>(v)));
      }
      for (int k = 0; k < 3; ++k) t[k] = sum[k];
    }
    for (int k = 0; k < b.modes; ++k) xb[info.velocities + k] += db[info.velocities + k];
  }
}

Motion<double> output_motion(const RelativeSystem& system, int frame, const double* q, const double* v,
                             const double* a) {
  const Compiled& m = system.model();
  const FrameData& f = m.frames[frame];
  if (frame < m.dynamic_frames && f.full) return system.workspace().frames[frame];
  Motion<double> out;
  if (f.body < 0) {
    out.rotation = f.rotation;
    out.position = f.position - system.workspace().origin;
    out.velocity = out.omega = out.alpha = Vec3d::Zero();
    out.acceleration = -m.gravity;
    return out;
  }
  const BodyData& b = m.bodies[f.body];
  const int s = b.modes > 0 ? m.flexible[b.flexible].stride : 0;
  std::vector<double>& y = system.workspace().output;
  std::fill_n(y.begin(), 3 * s, 0.0);
  for (int k = 0; k < b.modes; ++k) {
    y[k] = q[b.q + b.joint_positions + k];
    y[s + k] = v[b.v + b.joint_velocities + k];
    y[2 * s + k] = a[b.v + b.joint_velocities + k];
  }
  if (b.modes > 0) {
    const FlexibleData& flexible = m.flexible[b.flexible];
    extend(flexible, y.data());
    extend(flexible, y.data(), y.data() + s);
    extend(flexible, y.data(), y.data() + s, y.data() + 2 * s);
  }
  frame_motion<double>(f, system.workspace().bodies[f.body], y.data(), y.data() + s, y.data() + 2 * s, out);
  return out;
}

}  // namespace mimbre::relative
