#include "dynamics/relative/system.h"
#include "dynamics/modal_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/relative/articulated.h"
#include "dynamics/relative/assembly.h"
#include "dynamics/relative/evaluation.h"
#include "dynamics/relative/retract.h"
#include "dynamics/relative/transfer_matrices.h"
#include "dynamics/relative/workspace_impl.h"
#include "mimbre/diagnostics.h"

namespace mimbre::relative {

template struct Workspace<double>;

namespace {

Scales scales_of(const Compiled& m) {
  Scales s;
  s.round_off = round_off_of_positions(m);
  s.coordinates.assign(m.velocities, 1.0);
  s.equations.assign(m.equations, 1.0);
  s.is_angle.assign(m.equations, 1);
  const auto is_length = [&](int equation) {
    s.equations[equation] = m.length_scale;
    s.is_angle[equation] = 0;
  };
  s.acceleration = m.gravity.norm() / m.length_scale;

  for (const BodyData& b : m.bodies) {
    for (int k = 0; k < b.joint_velocities; ++k)
      if (!is_angle(b.joint, k)) s.coordinates[b.v + k] = m.length_scale;
    for (int k = 0; k < b.modes; ++k) s.coordinates[b.v + b.joint_velocities + k] = modal_scale(m, b, k);
  }
  for (const LoopData& l : m.loops)
    for (int r = 0; r < l.count; ++r)
      if (l.closure[r].kind == LoopClosure::Kind::distance) is_length(l.first_equation + r);
  for (const DriveData& d : m.drives)
    if (!is_angle(m.bodies[d.body].joint, d.local)) is_length(d.equation);
  for (const ConstraintData& c : m.constraints)
    for (int r = 0; r < c.count; ++r)
      if (c.is_length(r)) is_length(c.first_equation + r);
  for (const ConstraintData& c : m.constraints) {
    if (c.rates == 0) continue;
    s.is_rate.resize(s.equations.size(), 0);
    for (int r = 0; r < c.count; ++r) s.is_rate[c.first_equation + r] = c.is_rate(r);
  }
  return s;
}

/// The velocity coordinates that move a sphere of a swarm, −1 between those of its bodies.
std::vector<int> columns_of(const Path& path) {
  std::vector<int> columns(static_cast<std::size_t>(path.width), -1);
  for (const PathEntry& e : path.entries)
    for (int k = 0; k < e.count; ++k) columns[static_cast<std::size_t>(e.offset + k)] = e.first + k;
  return columns;
}

/// Tangents that the matrix is assembled with, remembered.
struct KeptMarks {
  TangentMarks& marks;
  ElementTangents& tangents;
  PairCouplings& couplings;
  double* next_beam;
  void element(std::size_t k, const ElementState<double>& state, const MatrixWeights& weights) {
    marks.element(k) = element_tangent(state, weights);
    tangents.keep(k, state, weights);
  }
  void pair(const ElementData& e, const ElementEnds& ends, const double* tangent,
            const PairRows<double>& rows) {
    couplings.add(e, ends, tangent, rows.a, rows.path_a->width, rows.b, rows.path_b->width);
  }
  void beam(const FlexibleData& f, const double* y) {
    ancf::keep_marks(f, y, next_beam);
    next_beam += ancf::marks(f);
  }
};

}  // namespace

RelativeSystem::RelativeSystem(const Compiled& model, spec::Simulation::Inertia inertia)
    : model_(model),
      work_(model),
      factor_(model.symbolic),
      penalty_(model.equations),
      mu_(model.equations),
      scales_(scales_of(model)),
      marks_(model),
      couplings_(
          model, model.velocities,
          [&](int contact, int sphere) { return columns_of(model.swarms[contact].spheres[sphere].path); }),
      tangents_(model, static_cast<std::size_t>(model.symbolic.value_count())) {
  for_rows(model, [&](const EquationRows& e) {
    for (int r = 0; r < e.count; ++r) penalty_[e.first_equation + r] = model.mass_scale * e.scale[r];
  });
  for (const DriveData& d : model.drives) penalty_[d.equation] = model.mass_scale * d.scale;

  // What spheres of a pool feel of each other is not in the matrix.
  keeps_matrix_ = std::none_of(model.elements.begin(), model.elements.end(),
                               [](const ElementData& e) { return e.pooled; });

  for (const BodyData& b : model.bodies)
    for (int k = 0; b.elastodynamic && k < b.modes; ++k) driven_.push_back(b.v + b.joint_velocities + k);

  if (splits_by_bodies(model)) articulated_ = std::make_unique<ArticulatedBodies<double>>(model);
  always_by_bodies_ = model.velocities > 0 && model.symbolic.size() == 0;

  work_.projections = projection::constants(model, inertia);
  for (const projection::Constants& c : work_.projections) work_.projection.fit(c);
  if (work_.projections.empty()) return;
  for (const BodyData& b : model.bodies) {
    if (b.flexible < 0 || work_.projections[b.flexible].plain) continue;
    const spec::Body& body = model.spec().bodies[b.spec];
    throw InputError(body.mark,
                     fmt::format("the mesh of flexible body '{}' has nodes whose mass depends on the "
                                 "direction, which relative coordinates cannot project; use inertia: "
                                 "integrals",
                                 body.name));
  }
}

RelativeSystem::~RelativeSystem() = default;

void RelativeSystem::begin_step(const double* q) { set_origin<double>(model_, work_, q); }

/// A function of its own, or it would be compiled once more in residual().
[[gnu::flatten, gnu::noinline]] void RelativeSystem::kinematics(double t, const double* q, const double* v,
                                                                const double* a) {
  evaluate_motion<double>(model_, work_, t, q, v, a);
}

[[gnu::flatten]] void RelativeSystem::residual(double t, const double* q, const double* v, const double* a,
                                               const double* multipliers, double factor, double* r) {
  kinematics(t, q, v, a);
  evaluate_residual<double>(model_, work_, penalty_.data(), t, q, v, a, multipliers, factor, mu_.data(), r);
}

void RelativeSystem::assemble(const double* q, const MatrixWeights& weights) {
  ++matrices_;
  if (always_by_bodies_) return motion_subspaces<double>(model_, work_, q);
  factor_.set_zero();
  couplings_.clear();
  relative::assemble<double>(model_, work_, q, weights, penalty_.data(), factor_.values(),
                             KeptMarks{marks_, tangents_, couplings_, marks_.ancf()});
}

linalg::FactorStatus RelativeSystem::factor_by_bodies(const double* q, const MatrixWeights& weights) {
  motion_subspaces<double>(model_, work_, q);
  ++matrices_;
  by_bodies_ = true;
  return {articulated_->factor(model_, work_, q, weights, penalty_.data(),
                               KeptMarks{marks_, tangents_, couplings_, marks_.ancf()})};
}

void RelativeSystem::use_transfer_matrices() {
  transfer_ = std::make_unique<TransferMatrices<double>>(model_);
}

linalg::FactorStatus RelativeSystem::factor_by_transfer(const double* q, const MatrixWeights& weights) {
  motion_subspaces<double>(model_, work_, q);
  ++matrices_;
  return {transfer_->factor(model_, work_, q, weights, penalty_.data(),
                            KeptMarks{marks_, tangents_, couplings_, marks_.ancf()})};
}

linalg::FactorStatus RelativeSystem::factor_inertia(const double* q, double penalty) {
  const MatrixWeights weights{0, 0, penalty};
  if (transfer_) return factor_by_transfer(q, weights);
  return articulated_ ? factor_by_bodies(q, weights) : factor(q, weights);
}

linalg::FactorStatus RelativeSystem::factor(const double* q, const MatrixWeights& weights) {
  if (transfer_) return factor_by_transfer(q, weights);
  if (always_by_bodies_) return factor_by_bodies(q, weights);
  by_bodies_ = false;
  assemble(q, weights);
  tangents_.assembled(factor_.values());
  return factor_.factor();
}

linalg::FactorStatus RelativeSystem::factor_tangents(const double* q, const MatrixWeights& weights) {
  if (transfer_ || always_by_bodies_ || !tangents_.possible()) return factor(q, weights);
  by_bodies_ = false;
  ++matrices_;
  tangents_.exchange(model_, work_, weights, factor_.values(), [&](std::size_t k, const auto& state) {
    marks_.element(k) = element_tangent(state, weights);
  });
  return factor_.factor();
}

void RelativeSystem::transfer_matrix(StateTransfer& transfer) {
  if (transfer_) {
    transfer_->transfer(transfer);
    for (double& x : work_.subspaces) transfer(x);
    for (double& x : work_.jacobian) transfer(x);
    if (transfer.restoring()) ++matrices_;
    return;
  }
  if (always_by_bodies_) {
    articulated_->transfer(transfer);
    for (double& x : work_.subspaces) transfer(x);
    if (!transfer.restoring()) return;
    ++matrices_;
    by_bodies_ = true;
    return;
  }
  tangents_.transfer(transfer);
  factor_.transfer(transfer);
  // Rows of contacts that begin are made with the motion of now, but with these.
  for (double& x : work_.subspaces) transfer(x);
  for (double& x : work_.jacobian) transfer(x);
  if (!transfer.restoring()) return;
  ++matrices_;
  by_bodies_ = false;
}

void RelativeSystem::solve(double* x) const {
  if (transfer_) return transfer_->solve(model_, work_, x);
  if (by_bodies_) return articulated_->solve(model_, work_, x);
  couplings_.solve(x, [this](double* y) { factor_.solve(y); });
}

bool RelativeSystem::solve_with_constraint_forces(double scale, double penalty, const double* phi, double* x,
                                                  double* moved) const {
  if (!transfer_) return false;
  const double* alpha = penalty_.data();
  for (int k = 0; k < model_.velocities; ++k) x[k] *= -scale;
  for (const DriveData& d : model_.drives) x[d.v] -= penalty * alpha[d.equation] * phi[d.equation];
  transfer_->solve_with_forces(model_, work_, penalty, alpha, phi, x);
  jacobian_times(x, moved);
  transfer_->moved(penalty, alpha, phi, moved);
  return true;
}

void RelativeSystem::dense_matrix(const double* q, const MatrixWeights& weights, double* out) {
  if (always_by_bodies_) {
    ++matrices_;
    motion_subspaces<double>(model_, work_, q);
    return articulated_->dense_matrix(model_, work_, q, weights, penalty_.data(),
                                      KeptMarks{marks_, tangents_, couplings_, marks_.ancf()}, out);
  }
  assemble(q, weights);
  linalg::to_dense(model_.symbolic, factor_.values(), out);
  couplings_.add_to(out, model_.velocities);
}

void RelativeSystem::matrix_values(const double* q, const MatrixWeights& weights, double* values) {
  assemble(q, weights);
  std::copy_n(factor_.values(), model_.symbolic.value_count(), values);
}

bool RelativeSystem::tangent_changed(const double* q, const MatrixWeights& weights) const {
  return marks_.changed(model_, work_.elements.data(), weights, [&](std::size_t i) {
    return q + model_.bodies[i].q + model_.bodies[i].joint_positions;
  });
}

void RelativeSystem::multiply(const double* x, double* y) const {
  linalg::multiply(model_.symbolic, factor_.values(), x, y);
  couplings_.add_product(x, y);
}

void RelativeSystem::add_jacobian_transposed(const double* y, double weight, double* out) const {
  for_rows(model_, [&](const EquationRows& e) {
    with_count(e.count, [&](auto n) {
      double weighted[n];
      for (int r = 0; r < n; ++r) weighted[r] = weight * y[e.first_equation + r];
      add_rows_transposed<n>(e.path, work_.jacobian.data() + e.jacobian, weighted, out);
    });
  });
  for (const DriveData& d : model_.drives) out[d.v] += weight * y[d.equation];
}

void RelativeSystem::jacobian_times(const double* x, double* out) const {
  for_rows(model_, [&](const EquationRows& e) {
    with_count(e.count, [&](auto n) {
      rows_times<n>(e.path, work_.jacobian.data() + e.jacobian, x, out + e.first_equation);
    });
  });
  for (const DriveData& d : model_.drives) out[d.equation] = x[d.v];
}

std::vector<JacobianEntry> RelativeSystem::jacobian_entries() const {
  std::vector<JacobianEntry> entries;
  for_rows(model_, [&](const EquationRows& rows) {
    for (int r = 0; r < rows.count; ++r)
      for (const PathEntry& e : rows.path.entries) {
        const double* row = work_.jacobian.data() + rows.jacobian + r * rows.path.width + e.offset;
        for (int k = 0; k < e.count; ++k) entries.push_back({rows.first_equation + r, e.first + k, row[k]});
      }
  });
  for (const DriveData& d : model_.drives) entries.push_back({d.equation, d.v, 1});
  return entries;
}

void RelativeSystem::temper_prediction(double h, double* x) const {
  for (const BodyData& b : model_.bodies) {
    if (b.modes == 0) continue;
    const FlexibleData& f = model_.flexible[b.flexible];
    if (f.absolute()) continue;  // nodes move far without strain
    const Rows& modal_mass = constant_inertia(model_, work_, b).modal_mass;
    for (int k = 0; k < b.modes; ++k)
      x[b.v + b.joint_velocities + k] /= 1 + h * h * f.stiffness(k, k) / modal_mass(k, k);
  }
}

void RelativeSystem::retract(const double* q, const double* x, double* out) const {
  relative::retract<double>(model_, q, x, out);
}

void RelativeSystem::increment_rate(const double* x, const double* v, double* rate) const {
  relative::increment_rate<double>(model_, x, v, rate);
}

void RelativeSystem::compose(double* x, const double* d) const { relative::compose<double>(model_, x, d); }

bool RelativeSystem::has_loads_of_inertia() const { return geometric::has_loads_of_inertia(model_); }

void RelativeSystem::add_loads_of_inertia(const double* q, const double* a, double* r) {
  relative::add_loads_of_inertia<double>(model_, work_, q, a, r);
}

namespace {

/// Padded amplitudes of the frame's body, their rates and accelerations, one after the other.
const double* all_amplitudes(const RelativeSystem& system, const BodyData& b, int stride, const double* q,
                             const double* v, const double* a) {
  std::vector<double>& y = system.workspace().output;
  std::fill_n(y.begin(), 3 * stride, 0.0);
  for (int k = 0; k < b.modes; ++k) {
    y[k] = q[b.q + b.joint_positions + k];
    y[stride + k] = v[b.v + b.joint_velocities + k];
    y[2 * stride + k] = a[b.v + b.joint_velocities + k];
  }
  if (b.modes > 0) {
    const FlexibleData& flexible = system.model().flexible[b.flexible];
    extend(flexible, y.data());
    extend(flexible, y.data(), y.data() + stride);
    extend(flexible, y.data(), y.data() + stride, y.data() + 2 * stride);
  }
  return y.data();
}

}  // namespace

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
  const double* y = all_amplitudes(system, b, s, q, v, a);
  frame_motion<double>(f, system.workspace().bodies[f.body], y, y + s, y + 2 * s, out);
  return out;
}

Motion<double> observed_motion(const RelativeSystem& system, int frame, const double* q, const double* v,
                               const double* a) {
  const Compiled& m = system.model();
  const FrameData& f = m.frames[frame];
  if (!f.bends) return output_motion(system, frame, q, v, a);
  const BodyData& b = m.bodies[f.body];
  const int s = m.flexible[b.flexible].stride;
  const double* y = all_amplitudes(system, b, s, q, v, a);
  Motion<double> out;
  deformed_motion<double>(f, system.workspace().bodies[f.body], y, y + s, y + 2 * s, out);
  return out;
}

}  // namespace mimbre::relative
