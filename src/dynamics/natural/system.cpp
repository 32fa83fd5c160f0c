#include "dynamics/natural/system.h"
#include "dynamics/modal_scale.h"

#include <algorithm>
#include <cmath>

#include "compile/find_scales.h"
#include "dynamics/natural/joint_positions.h"
#include "dynamics/natural/matrix.h"
#include "dynamics/natural/residual.h"

namespace mimbre::natural {
namespace {

Scales scales_of(const Compiled& m, const Layout& l) {
  const double length = m.length_scale;
  Scales s;
  s.round_off = round_off_of_positions(m);
  s.coordinates.assign(l.unknowns, length);
  s.equations.assign(l.equations, 1.0);
  s.is_angle.assign(l.equations, 1);
  const auto is_length = [&](int equation) {
    s.equations[equation] = length;
    s.is_angle[equation] = 0;
  };
  s.acceleration = m.gravity.norm() / length;

  for (int k = 0; k < l.unknown_variables; ++k)
    if (!l.variables[k].point) std::fill_n(s.coordinates.begin() + 3 * k, 3, 1.0);
  for (std::size_t i = 0; i < l.bodies.size(); ++i)
    for (int k = 0; k < m.bodies[i].modes; ++k)
      s.coordinates[static_cast<std::size_t>(l.bodies[i].q + k)] = modal_scale(m, m.bodies[i], k);
  for (const Joint& j : l.joints) {
    int row = j.first_equation;
    for (const JointEquation& e : j.equations)
      for (int k = 0; k < e.count(); ++k, ++row)
        if (e.kind != JointEquation::Kind::angle) is_length(row);
  }
  for (std::size_t k = 0; k < m.drives.size(); ++k)
    if (!is_angle(m.bodies[m.drives[k].body].joint, m.drives[k].local))
      is_length(l.first_drive + static_cast<int>(k));
  for (std::size_t k = 0; k < m.constraints.size(); ++k)
    for (int r = 0; r < m.constraints[k].count; ++r)
      if (m.constraints[k].is_length(r)) is_length(l.constraints[k].first_equation + r);
  for (std::size_t k = 0; k < m.constraints.size(); ++k) {
    if (m.constraints[k].rates == 0) continue;
    s.is_rate.resize(s.equations.size(), 0);
    for (int r = 0; r < m.constraints[k].count; ++r)
      s.is_rate[l.constraints[k].first_equation + r] = m.constraints[k].is_rate(r);
  }
  return s;
}

/// Calls f(stencil, columns, offset of the rows, first equation, count) for all that have equations.
template <class F>
void for_rows(const Compiled& m, const Layout& l, const F& f) {
  for (const Body& b : l.bodies)
    f(b.stencil, 3 * b.unknown, b.jacobian, b.first_equation, static_cast<int>(b.rigidity.size()));
  for (const Joint& j : l.joints)
    f(j.link.stencil, j.link.stencil.size(), j.link.jacobian, j.first_equation, j.count);
  for (std::size_t k = 0; k < l.drives.size(); ++k)
    f(l.drives[k].stencil, l.drives[k].stencil.size(), l.drives[k].jacobian,
      l.first_drive + static_cast<int>(k), 1);
  for (std::size_t k = 0; k < l.constraints.size(); ++k)
    f(l.constraints[k].stencil, l.constraints[k].stencil.size(), l.constraints[k].jacobian,
      l.constraints[k].first_equation, m.constraints[k].count);
}

}  // namespace

NaturalSystem::NaturalSystem(const Compiled& model, spec::Simulation::Inertia inertia)
    : model_(model),
      layout_(model),
      work_(model, layout_),
      factor_(*layout_.symbolic),
      penalty_(layout_.equations),
      mu_(layout_.equations),
      scales_(scales_of(model, layout_)),
      marks_(model),
      couplings_(model, layout_.unknowns, [this](int contact, int sphere) {
        return layout_.spheres[contact][sphere].stencil.columns;
      }) {
  work_.projections = projection::constants(model, inertia);
  for (const projection::Constants& c : work_.projections) work_.projection.fit(c);
  for (const Body& b : layout_.bodies)
    for (std::size_t k = 0; k < b.rigidity.size(); ++k)
      penalty_[b.first_equation + k] = penalty_scale(
          model.mass_scale * b.lengths[b.rigidity[k].i] * b.lengths[b.rigidity[k].j], b.inertia);
  for (const Joint& j : layout_.joints)
    for (int k = 0; k < j.count; ++k) penalty_[j.first_equation + k] = model.mass_scale * j.scale[k];
  for (std::size_t k = 0; k < model.drives.size(); ++k)
    penalty_[layout_.first_drive + k] = model.mass_scale * model.drives[k].scale;
  for (std::size_t k = 0; k < model.constraints.size(); ++k)
    for (int r = 0; r < model.constraints[k].count; ++r)
      penalty_[layout_.constraints[k].first_equation + r] = model.mass_scale * model.constraints[k].scale[r];
  for (std::size_t f = 0; f < model.frames.size(); ++f)
    if (model.frames[f].body < 0) work_.frames[f] = ground_frame<double>(model.frames[f], layout_.origin);
}

[[gnu::flatten]] void NaturalSystem::kinematics(double t, const double* q, const double* v, const double* a) {
  natural::kinematics<double>(model_, layout_, work_, q, v, a);
  fix_signals(model_.signals, t, work_.signals);
  constraints<double>(model_, layout_, work_, q);
}

[[gnu::flatten]] void NaturalSystem::residual(double t, const double* q, const double* v, const double* a,
                                              const double* multipliers, double factor, double* r) {
  kinematics(t, q, v, a);
  for (int k = 0; k < layout_.equations; ++k) mu_[k] = multipliers[k] + factor * penalty_[k] * work_.phi[k];
  natural::residual<double>(model_, layout_, work_, q, mu_.data(), r);
}

[[gnu::flatten]] void NaturalSystem::assemble(const double* q, const MatrixWeights& weights) {
  jacobian<double>(model_, layout_, work_, q);
  factor_.set_zero();
  couplings_.clear();
  double *values = factor_.values(), *local = work_.local.data();
  double weight[6];
  double* marks = marks_.ancf();
  const auto clear = [&](const Stencil& s) {
    std::fill(local, local + static_cast<std::ptrdiff_t>(s.size()) * s.stride, 0.0);
  };
  for (std::size_t i = 0; i < layout_.bodies.size(); ++i) {
    const Body& b = layout_.bodies[i];
    clear(b.stencil);
    const int rows = static_cast<int>(b.rigidity.size());
    for (int k = 0; k < rows; ++k) weight[k] = weights.penalty * penalty_[b.first_equation + k];
    add_squares<double>(work_.jacobian.data() + b.jacobian, rows, 3 * b.unknown, b.stencil.stride, weight,
                        local);
    body_matrix<double>(model_, layout_, work_, static_cast<int>(i), weights.damping, weights.stiffness,
                        local);
    scatter(b.stencil, local, values);
    if (model_.bodies[i].modes == 0 || !model_.flexible[model_.bodies[i].flexible].absolute()) continue;
    const FlexibleData& f = model_.flexible[model_.bodies[i].flexible];
    ancf::keep_marks(f, q + b.q, marks);
    marks += ancf::marks(f);
  }
  const auto add_link = [&](const auto& link, int rows) {
    clear(link.stencil);
    add_squares<double>(work_.jacobian.data() + link.jacobian, rows, link.stencil.size(), link.stencil.stride,
                        weight, local);
    scatter(link.stencil, local, values);
  };
  for (const Joint& j : layout_.joints) {
    for (int k = 0; k < j.count; ++k) weight[k] = weights.penalty * penalty_[j.first_equation + k];
    add_link(j.link, j.count);
  }
  for (std::size_t k = 0; k < model_.drives.size(); ++k) {
    weight[0] = weights.penalty * penalty_[layout_.first_drive + k];
    add_link(layout_.drives[k], 1);
  }
  for (std::size_t k = 0; k < model_.constraints.size(); ++k) {
    const ConstraintLink& link = layout_.constraints[k];
    const int rows = model_.constraints[k].count;
    for (int r = 0; r < rows; ++r) weight[r] = weights.penalty * penalty_[link.first_equation + r];
    add_link(link, rows);
  }
  for (std::size_t k = 0; k < model_.elements.size(); ++k) {
    const ElementData& e = model_.elements[k];
    const ElementState<double> state = element_state(e, work_.elements.data());
    if (e.marked) marks_.element(k) = element_tangent(state, weights);
    if (e.measure == Measure::none) continue;
    double tangent[36];
    bool any = false;
    for (int i = 0; i < e.count * e.count; ++i) {
      tangent[i] = weights.damping * state.damping[i] + weights.stiffness * state.stiffness[i];
      if (e.inertia >= 0) tangent[i] += work_.signals.numbers[e.inertia];
      any = any || tangent[i] != 0;
    }
    if (!any) continue;
    if (e.pooled) {
      const ElementEnds ends = ends_of(model_, e, work_.signals.states + e.states);
      if (ends.frame_b < 0) continue;
      const PairLinks pair = links_of(layout_, e, ends);
      const double *rows_a = work_.jacobian.data() + layout_.elements[k].jacobian,
                   *rows_b = rows_a + e.count * pair.a->stencil.stride;
      for (const auto& [link, rows] : {std::pair(pair.a, rows_a), std::pair(pair.b, rows_b)}) {
        clear(link->stencil);
        add_products<double>(rows, e.count, link->stencil.size(), link->stencil.stride, tangent, local);
        scatter(link->stencil, local, values);
      }
      couplings_.add(e, ends, tangent, rows_a, pair.a->stencil.stride, rows_b, pair.b->stencil.stride);
      continue;
    }
    const Link& link = layout_.elements[k];
    clear(link.stencil);
    add_products<double>(work_.jacobian.data() + link.jacobian, e.count, link.stencil.size(),
                         link.stencil.stride, tangent, local);
    scatter(link.stencil, local, values);
  }
}

linalg::FactorStatus NaturalSystem::factor(const double* q, const MatrixWeights& weights) {
  assemble(q, weights);
  return factor_.factor();
}

void NaturalSystem::dense_matrix(const double* q, const MatrixWeights& weights, double* out) {
  assemble(q, weights);
  linalg::to_dense(*layout_.symbolic, factor_.values(), out);
  couplings_.add_to(out, layout_.unknowns);
}

void NaturalSystem::matrix_values(const double* q, const MatrixWeights& weights, double* values) {
  assemble(q, weights);
  std::copy_n(factor_.values(), layout_.symbolic->value_count(), values);
}

bool NaturalSystem::tangent_changed(const double* q, const MatrixWeights& weights) const {
  return marks_.changed(model_, work_.elements.data(), weights,
                        [&](std::size_t i) { return q + layout_.bodies[i].q; });
}

void NaturalSystem::add_jacobian_transposed(const double* y, double weight, double* out) const {
  const auto add_rows = [&](const Stencil& s, int columns, int offset, int first, int count) {
    const double* row = work_.jacobian.data() + offset;
    for (int e = 0; e < count; ++e, row += s.stride) {
      const double f = weight * y[first + e];
      for (int c = 0; c < columns; ++c) out[s.columns[c]] += f * row[c];
    }
  };
  for_rows(model_, layout_, add_rows);
}

void NaturalSystem::jacobian_times(const double* x, double* out) const {
  const auto rows_times = [&](const Stencil& s, int columns, int offset, int first, int count) {
    const double* row = work_.jacobian.data() + offset;
    for (int e = 0; e < count; ++e, row += s.stride) {
      double sum = 0;
      for (int c = 0; c < columns; ++c) sum += row[c] * x[s.columns[c]];
      out[first + e] = sum;
    }
  };
  for_rows(model_, layout_, rows_times);
}

std::vector<JacobianEntry> NaturalSystem::jacobian_entries() const {
  std::vector<JacobianEntry> entries;
  const auto add_rows = [&](const Stencil& s, int columns, int offset, int first, int count) {
    const double* row = work_.jacobian.data() + offset;
    for (int e = 0; e < count; ++e, row += s.stride)
      for (int c = 0; c < columns; ++c) entries.push_back({first + e, s.columns[c], row[c]});
  };
  for_rows(model_, layout_, add_rows);
  return entries;
}

void NaturalSystem::temper_prediction(double h, double* x) const {
  for (std::size_t i = 0; i < layout_.bodies.size(); ++i) {
    const BodyData& b = model_.bodies[i];
    if (b.modes == 0) continue;
    const FlexibleData& f = model_.flexible[b.flexible];
    if (f.absolute()) continue;  // nodes move far without strain
    for (int k = 0; k < b.modes; ++k)
      x[layout_.bodies[i].q + k] /= 1 + h * h * f.stiffness(k, k) / f.mass(k, k);
  }
}

/// Positions are sums.
void NaturalSystem::increment_rate(const double*, const double* v, double* rate) const {
  std::copy_n(v, layout_.unknowns, rate);
}

void NaturalSystem::retract(const double* q, const double* x, double* out) const {
  for (int k = 0; k < layout_.unknowns; ++k) out[k] = q[k] + x[k];
  if (out != q) std::copy(q + layout_.unknowns, q + layout_.positions, out + layout_.unknowns);
  joint_positions(out);
}

[[gnu::flatten]] void NaturalSystem::joint_positions(double* q) const {
  natural::joint_positions<double>(model_, layout_, work_, q);
}

void NaturalSystem::compose(double* x, const double* d) const {
  for (int k = 0; k < layout_.unknowns; ++k) x[k] += d[k];
}

bool NaturalSystem::has_loads_of_inertia() const { return geometric::has_loads_of_inertia(model_); }

void NaturalSystem::add_loads_of_inertia(const double*, const double*, double* r) {
  for (std::size_t i = 0; i < layout_.bodies.size(); ++i) {
    const int modes = model_.bodies[i].modes;
    if (modes == 0 || model_.flexible[model_.bodies[i].flexible].geometric.empty()) continue;
    const Body& b = layout_.bodies[i];
    const FlexibleData& f = model_.flexible[model_.bodies[i].flexible];
    Base<double> second = work_.bodies[i].acceleration;
    second.col(0) -= model_.gravity;
    double* forces = work_.row_modal.data();
    std::fill(forces, forces + f.stride, 0.0);
    geometric::add_inertial_forces(
        f.geometric, stress_motion(f.geometric, work_.bodies[i], second, work_.ydd.data() + b.amplitudes),
        work_.y.data() + b.amplitudes, forces);
    for (int k = 0; k < modes; ++k) r[b.q + k] += forces[k];
  }
}

void NaturalSystem::to_relative(const State& s, State& out) {
  natural::kinematics<double>(model_, layout_, work_, s.q.data(), s.v.data(), s.a.data());
  out.time = s.time;
  out.started = s.started;
  for (std::size_t i = 0; i < model_.bodies.size(); ++i) {
    const BodyData& b = model_.bodies[i];
    const JointCoordinate& c = layout_.joint_coordinates[i];
    const FrameMotion<double> A = motion_of(model_, layout_, work_, c.frame_a),
                              B = motion_of(model_, layout_, work_, c.frame_b);
    const double* q = s.q.data() + c.q;
    JointRates<double> rates;
    joint_rates<double>(b.joint, b.joint_velocities, A, B, q, rates);
    std::copy_n(q, b.joint_positions, out.q.data() + b.q);
    std::copy_n(rates.v, b.joint_velocities, out.v.data() + b.v);
    std::copy_n(rates.a, b.joint_velocities, out.a.data() + b.v);
    std::copy_n(s.q.data() + layout_.bodies[i].q, b.modes, out.q.data() + b.q + b.joint_positions);
    std::copy_n(s.v.data() + layout_.bodies[i].q, b.modes, out.v.data() + b.v + b.joint_velocities);
    std::copy_n(s.a.data() + layout_.bodies[i].q, b.modes, out.a.data() + b.v + b.joint_velocities);
  }
  out.algorithmic = out.a;
  out.multipliers.setZero();
  for (std::size_t k = 0; k < model_.drives.size(); ++k)
    out.multipliers[model_.drives[k].equation] = s.multipliers[layout_.first_drive + static_cast<int>(k)];
  for (std::size_t k = 0; k < model_.constraints.size(); ++k)
    out.multipliers.segment(model_.constraints[k].first_equation, model_.constraints[k].count) =
        s.multipliers.segment(layout_.constraints[k].first_equation, model_.constraints[k].count);
}

State NaturalSystem::from_relative(const State& s, const std::vector<Motion<double>>& bodies,
                                   const Vec3d& common_point) const {
  State out;
  out.time = s.time;
  out.started = s.started;
  out.q.setZero(layout_.positions);
  out.v.setZero(layout_.unknowns);
  out.a.setZero(layout_.unknowns);
  out.multipliers.setZero(layout_.equations);
  for (int k = 0; k < layout_.unknown_variables; ++k) {
    const Variable& x = layout_.variables[k];
    const Motion<double>& b = bodies[x.body];
    const Vec3d r = b.rotation * x.place, v = b.omega.cross(r);
    const Vec3d a = b.alpha.cross(r) + b.omega.cross(v);
    out.q.segment<3>(3 * k) = x.point ? Vec3d(b.position + common_point - layout_.origin + r) : r;
    out.v.segment<3>(3 * k) = x.point ? Vec3d(b.velocity + v) : v;
    out.a.segment<3>(3 * k) = x.point ? Vec3d(b.acceleration + model_.gravity + a) : a;
  }
  for (std::size_t i = 0; i < model_.bodies.size(); ++i) {
    const BodyData& b = model_.bodies[i];
    const int at = layout_.bodies[i].q;
    out.q.segment(at, b.modes) = s.q.segment(b.q + b.joint_positions, b.modes);
    out.v.segment(at, b.modes) = s.v.segment(b.v + b.joint_velocities, b.modes);
    out.a.segment(at, b.modes) = s.a.segment(b.v + b.joint_velocities, b.modes);
    out.q.segment(layout_.joint_coordinates[i].q, b.joint_positions) = s.q.segment(b.q, b.joint_positions);
  }
  for (std::size_t k = 0; k < model_.drives.size(); ++k)
    out.multipliers[layout_.first_drive + static_cast<int>(k)] = s.multipliers[model_.drives[k].equation];
  for (std::size_t k = 0; k < model_.constraints.size(); ++k)
    out.multipliers.segment(layout_.constraints[k].first_equation, model_.constraints[k].count) =
        s.multipliers.segment(model_.constraints[k].first_equation, model_.constraints[k].count);
  joint_positions(out.q.data());
  out.algorithmic = out.a;
  return out;
}

void NaturalSystem::shift(const std::vector<char>& of, RigidShift shift, const Vec3d& common_point,
                          State& s) const {
  shift.centre += common_point - layout_.origin;
  shift.acceleration += model_.gravity;
  for (int k = 0; k < layout_.unknown_variables; ++k) {
    if (!of[layout_.variables[k].body]) continue;
    Vec3d x = s.q.segment<3>(3 * k), v = s.v.segment<3>(3 * k), a = s.a.segment<3>(3 * k);
    if (layout_.variables[k].point)
      shift.point(x, v, a);
    else
      shift.vector(x, v, a);
    s.algorithmic.segment<3>(3 * k) += a - s.a.segment<3>(3 * k);
    s.q.segment<3>(3 * k) = x;
    s.v.segment<3>(3 * k) = v;
    s.a.segment<3>(3 * k) = a;
  }
  joint_positions(s.q.data());
}

void NaturalSystem::add_rigid_motion(const std::vector<char>& of, double times, const Vec3d& velocity,
                                     const Vec3d& spin, const Vec3d& common_point, State& s) const {
  for (int k = 0; k < layout_.unknown_variables; ++k) {
    const Variable& variable = layout_.variables[k];
    if (!of[variable.body]) continue;
    const Vec3d x = s.q.segment<3>(3 * k);
    s.v.segment<3>(3 * k) +=
        times * (variable.point ? Vec3d(velocity + spin.cross(x + layout_.origin - common_point))
                                : Vec3d(spin.cross(x)));
  }
}

int NaturalSystem::body_of(int unknown) const {
  if (unknown < 3 * layout_.unknown_variables) return layout_.variables[unknown / 3].body;
  for (std::size_t i = 0; i < layout_.bodies.size(); ++i)
    if (unknown >= layout_.bodies[i].q && unknown < layout_.bodies[i].q + model_.bodies[i].modes)
      return static_cast<int>(i);
  return -1;
}

}  // namespace mimbre::natural
