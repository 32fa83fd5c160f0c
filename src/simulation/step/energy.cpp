#include "simulation/step/energy.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "dynamics/amplitudes.h"
#include "dynamics/elasticity.h"
#include "dynamics/flexible.h"
#include "dynamics/geometric.h"
#include "dynamics/relative/forces.h"
#include "dynamics/relative/kinematics.h"
#include "math/elementary.h"

namespace mimbre {

void add_kinetic_energy(const Compiled& m, relative::Workspace<double>& w, std::size_t body, const double* q,
                        const double* v, double& energy) {
  const BodyData& b = m.bodies[body];
  const auto& motion = w.bodies[body];
  const Vec3d u = motion.rotation.transpose() * motion.velocity,
              omega = motion.rotation.transpose() * motion.omega;
  if (b.modes == 0 || b.elastodynamic) {
    energy += 0.5 * b.mass * u.squaredNorm() + u.dot(omega.cross(b.first_moment)) +
              0.5 * omega.dot(b.inertia * omega);
    return;
  }
  // Velocity field in body axes: u + ω × r̄ + X ẏ.
  const FlexibleData& f = m.flexible[b.flexible];
  const int n = f.stride;
  double *y = w.scratch.data(), *yd = y + n, *integrals = yd + n;
  relative::copy_modes(b, q + b.q + b.joint_positions, n, y);
  relative::copy_modes(b, v + b.v + b.joint_velocities, n, yd);
  extend(f, y);
  extend(f, y, yd);
  if (!w.projections.empty()) {
    energy += projection::kinetic_energy(w.projections[b.flexible], w.projection,
                                         projection::rigid_base(u, omega), y, yd, integrals);
    return;
  }
  const InertiaRows<double> rows = make_inertia_rows<double>(b, f, y, integrals);
  const Vec3d first = deformed_first_moment<double>(b, f, y), sy = times(f.S, yd);
  const Mat3d second = deformed_second_moment<double>(b, f, rows, y);
  const Mat3d inertia = second.trace() * Mat3d::Identity() - second;
  const double* positions = rows.of(InertiaTerm::rotation_coupling_deformed);
  const auto d = [&](int r, int c) { return dot(positions + (3 * r + c) * n, yd, n); };
  Vec3d cy(d(1, 2) - d(2, 1), d(2, 0) - d(0, 2), d(0, 1) - d(1, 0));
  if (b.neglected.has(InertiaTerm::rotation_coupling)) cy.setZero();
  energy += 0.5 * b.mass * u.squaredNorm() + u.dot(omega.cross(first) + sy) +
            0.5 * omega.dot(inertia * omega) + omega.dot(cy);
  if (f.identity_mass) {
    energy += 0.5 * dot(yd, yd, n);
  } else {
    for (int k = 0; k < f.modes; ++k) energy += 0.5 * yd[k] * dot(f.mass.data() + k * n, yd, n);
  }
}

double kinetic_energy(const Compiled& m, relative::Workspace<double>& w, const double* q, const double* v) {
  double energy = 0;
  for (std::size_t i = 0; i < m.bodies.size(); ++i) add_kinetic_energy(m, w, i, q, v, energy);
  for (const ElementData& e : m.elements)
    if (e.inertia >= 0) {
      const double rate = element_state(e, w.elements.data()).v[0];
      energy += 0.5 * w.signals.numbers[e.inertia] * rate * rate;
    }
  return energy;
}

namespace {

/// Energy that is stored where an element would measure this, with the same states.
double stored_at(const LawContext<double>& c, ElementState<double> s, double x) {
  s.x = &x;
  ElementEnergy energy;
  forces::rows<double>[static_cast<std::size_t>(c.element.law)].energy(c, s, energy);
  return energy.stored;
}
/// Likewise in other surroundings.
double stored_at(const LawContext<double>& c, ElementState<double> s, double x, double* surroundings) {
  s.surroundings = surroundings;
  return stored_at(c, s, x);
}

/// Whether the force moves along the rate and not along what is measured, of which that is no derivative.
bool by_rate(const ElementData& e, int component) {
  return is_velocity(e.measure, component) || e.measure == Measure::wheel ||
         (e.measure == Measure::axis && law_info(e.law).given);
}

bool over_time(const Compiled& m, const ElementData& e) {
  return on_road(e.measure) && m.roads[e.road].over == spec::Road::Over::time;
}

/// Whether its force may change while nothing moves.
bool hears_signals(const Compiled& m, const ElementData& e) {
  return e.measure == Measure::none || e.argument_count > 0 || e.sampled ||
         (e.formula >= 0 && !m.formulas[e.formula].slots.empty()) || over_time(m, e);
}

}  // namespace

EnergyMeter::EnergyMeter(const Compiled& m)
    : model_(&m),
      flows_(m.elements.size()),
      generalised_(m.velocities),
      drive_position_(m.drives.size()),
      drive_force_(m.drives.size()),
      damping_force_(Eigen::VectorXd::Zero(m.velocities)),
      modal_(Eigen::VectorXd::Zero(m.velocities)),
      geometric_force_(Eigen::VectorXd::Zero(m.velocities)) {
  const auto add = [&](Place::Kind kind, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) stores_.push_back({{kind, static_cast<int>(k)}});
  };
  add(Place::Kind::element, m.elements.size());
  add(Place::Kind::body, m.bodies.size());
}

void EnergyMeter::start(relative::RelativeSystem& system, const State& s) {
  balance_ = {};
  started_ = false;
  pending_jump_ = 0;
  for (Store& store : stores_) store = {store.place};
  observe(system, s);
  start_total_ = balance_.total();
  started_ = true;
}

void EnergyMeter::update(relative::RelativeSystem& system, const State& s) {
  const double before = balance_.numerical;
  observe(system, s);
  balance_.numerical = balance_.total() - start_total_ - balance_.drive_work - balance_.load_work -
                       balance_.road_work + balance_.dissipated;
  last_input_ = balance_.numerical - before;
}

void EnergyMeter::jump(relative::RelativeSystem& system, const State& s) {
  auto& w = system.workspace();
  relative::forces(*model_, w, s.time, s.q.data(), s.v.data(), s.a.data(), generalised_.data());
  for (std::size_t k = 0; k < model_->elements.size(); ++k)
    if (hears_signals(*model_, model_->elements[k])) jump_element(k, w);
}

bool EnergyMeter::follows_accelerations() const {
  return !model_->drives.empty() || std::any_of(model_->flexible.begin(), model_->flexible.end(),
                                                [](const FlexibleData& f) { return !f.geometric.empty(); });
}

void EnergyMeter::begin(relative::RelativeSystem& system, const State& s) {
  const Compiled& m = *model_;
  auto& w = system.workspace();
  for (std::size_t k = 0; k < m.drives.size(); ++k) drive_force_[k] = -s.multipliers[m.drives[k].equation];
  for (std::size_t i = 0; i < m.bodies.size(); ++i) {
    const BodyData& b = m.bodies[i];
    if (b.modes == 0 || m.flexible[b.flexible].geometric.empty()) continue;
    const FlexibleData& f = m.flexible[b.flexible];
    double *y = w.scratch.data(), *forces = y + f.stride;
    relative::copy_modes(b, s.q.data() + b.q + b.joint_positions, f.stride, y);
    extend(f, y);
    inertial_forces(i, w, s, y, forces);
    for (int k = 0; k < f.geometric.modes; ++k) {
      double& before = geometric_force_[b.v + b.joint_velocities + k];
      balance_.load_work += 0.5 * (forces[k] - before) * y[k];
      before = forces[k];
    }
  }
}

/// K_G y of a body at the loads of inertia and gravity of now; `forces` has room for twice a body's
/// amplitudes.
void EnergyMeter::inertial_forces(std::size_t body, const relative::Workspace<double>& w, const State& s,
                                  const double* y, double* forces) const {
  const BodyData& b = model_->bodies[body];
  const FlexibleData& f = model_->flexible[b.flexible];
  double* ydd = forces + f.stride;
  relative::copy_modes(b, s.a.data() + b.v + b.joint_velocities, f.stride, ydd);
  const auto& motion = w.bodies[body];
  const Mat3d to_body = motion.rotation.transpose();
  std::fill(forces, forces + f.stride, 0.0);
  geometric::add_inertial_forces(
      f.geometric,
      geometric::stress_motion<double>(f.geometric, to_body * motion.omega, to_body * motion.acceleration,
                                       to_body * motion.alpha, ydd),
      y, forces);
}

/// Energy ½ yᵀ K_G y at the present loads of inertia and gravity, and what their change put in since the last
/// step: as the work of K_G y is its mean times the displacement, that is ½ y0ᵀ (K_G1 − K_G0) y1. Forces at
/// the boundary have an energy of their own. `forces`: scratch.
void EnergyMeter::observe_geometric(std::size_t body, const relative::Workspace<double>& w, const State& s,
                                    const double* y, double* forces) {
  const BodyData& b = model_->bodies[body];
  const GeometricData& g = model_->flexible[b.flexible].geometric;
  const int first = b.v + b.joint_velocities;
  balance_.elastic += geometric::boundary_energy(g, y, forces);
  inertial_forces(body, w, s, y, forces);
  for (int k = 0; k < g.modes; ++k) {
    balance_.elastic += 0.5 * forces[k] * y[k];
    double& before = geometric_force_[first + k];
    if (started_) balance_.load_work += 0.5 * (forces[k] * modal_[first + k] - before * y[k]);
    before = forces[k];
  }
}

void EnergyMeter::observe_store(std::size_t k, double energy) {
  Store& store = stores_[k];
  if (started_) {
    const double change = energy - store.energy;
    store.exchanged += std::abs(change);
    store.unresolved += std::abs(change - store.change);
    store.change = change;
    store.highest = std::max(store.highest, energy);
    store.lowest = std::min(store.lowest, energy);
    if (std::abs(change) > most_exchanged_) {
      most_exchanged_ = std::abs(change);
      place_ = store.place;
    }
  } else {
    store.highest = store.lowest = energy;
  }
  store.energy = energy;
}

EnergyMeter::Unresolved EnergyMeter::most_unresolved(double nothing) const {
  const Store* most = nullptr;
  for (const Store& store : stores_)
    if (store.highest - store.lowest > nothing && store.unresolved > (most ? most->unresolved : 0))
      most = &store;
  if (!most) return {};
  // The energy of a vibration varies as sin² ωt: its second differences are 2 sin ωh times the first.
  const double angle = mimbre::asin(std::min(1.0, 0.5 * most->unresolved / most->exchanged));
  return {most->place, 2 * std::numbers::pi / angle, most->highest - most->lowest};
}

void EnergyMeter::observe_element(std::size_t k, relative::Workspace<double>& w, double h) {
  const Compiled& m = *model_;
  const ElementData& d = m.elements[k];
  const ElementState<double> s = element_state(d, w.elements.data());
  const LawContext<double> context = law_context(m, d, w.signals);
  EnergyBalance& e = balance_;
  Flow& f = flows_[k];
  ElementEnergy now;
  if (d.pooled) {
    // Another pair may have the place than before; none that touched has left it.
    if (ends_of(m, d, context.states).frame_b < 0) return;
    if (context.states[contact_states::gap] >= 0) {
      f = {};
      f.progress[0] = context.states[contact_states::gap];
    }
  }
  forces::rows<double>[static_cast<std::size_t>(d.law)].energy(context, s, now);
  if (d.measure == Measure::none) return observe_load(s, w.frames[d.frame_b], w.origin, h, f);
  (on_road(d.measure) ? e.tyres : e.springs) += now.stored;
  if (started_) {
    e.dissipated += now.lost - (now.held - f.held);
    e.load_work += now.given;
    for (int c = 0; c < s.count; ++c) {
      const double dx = by_rate(d, c) ? 0.5 * h * (s.v[c] + f.progress[c]) : s.x[c] - f.progress[c],
                   wound = c == 0 ? now.wound : 0, damped = 0.5 * (now.dissipating[c] + f.dissipating[c]);
      e.dissipated += damped * (dx - wound) + 0.5 * (now.inner[c] + f.inner[c]) * dx;
      e.load_work -= damped * wound + 0.5 * (now.working[c] + f.working[c]) * dx;
    }
  }
  if (d.measure == Measure::height) observe_road(k, context, s, w, now.stored, f);
  if (d.measure == Measure::wheel) observe_wheel(context, s, now, h, f);
  observe_store(k, now.stored);
  keep(d, s, now, f);
  f.held = now.held;
}

void EnergyMeter::keep(const ElementData& d, const ElementState<double>& s, const ElementEnergy& now,
                       Flow& f) {
  for (int c = 0; c < s.count; ++c) {
    f.progress[c] = by_rate(d, c) ? s.v[c] : s.x[c];
    f.dissipating[c] = now.dissipating[c];
    f.working[c] = now.working[c];
    f.inner[c] = now.inner[c];
  }
}

/// What stands still while signals jump. What internal states then hold more or less is reckoned with their
/// work in the next step.
void EnergyMeter::jump_element(std::size_t k, relative::Workspace<double>& w) {
  const Compiled& m = *model_;
  const ElementData& d = m.elements[k];
  const ElementState<double> s = element_state(d, w.elements.data());
  const LawContext<double> context = law_context(m, d, w.signals);
  Flow& f = flows_[k];
  if (d.measure == Measure::none) return observe_load(s, w.frames[d.frame_b], w.origin, 0, f);
  ElementEnergy now;
  forces::rows<double>[static_cast<std::size_t>(d.law)].energy(context, s, now);
  balance_.load_work += now.given;
  if (over_time(m, d)) {
    const double before = d.measure == Measure::height ? f.height - f.road : f.gap,
                 put_in = stored_at(context, s, s.x[0]) - stored_at(context, s, before);
    balance_.road_work += put_in;
    stores_[k].energy += put_in;
    if (d.measure == Measure::height) {
      pending_jump_ += std::abs(put_in);
      f.road = *s.surroundings;
      f.slope = w.signals.rate[m.roads[d.road].slot];
    } else {
      keep_wheel(s, now, f);
    }
  }
  keep(d, s, now, f);
}

/// Work of a force and a moment on a frame.
void EnergyMeter::observe_load(const ElementState<double>& s, const Motion<double>& frame,
                               const Vec3d& origin, double h, Flow& f) {
  const Vec3d force = -s.force[0] * s.linear_of(0), position = frame.position + origin;
  const double power = -s.force[0] * s.angular_of(0).dot(frame.omega);
  if (started_)
    balance_.load_work +=
        0.5 * (force + f.load_force).dot(position - f.load_position) + 0.5 * h * (power + f.load_power);
  f.load_position = position;
  f.load_force = force;
  f.load_power = power;
}

/// What a road does to what stands on it.
void EnergyMeter::observe_road(std::size_t k, const LawContext<double>& context,
                               const ElementState<double>& s, relative::Workspace<double>& w, double stored,
                               Flow& f) {
  const ElementData& d = context.element;
  const RoadData& r = context.model.roads[d.road];
  const double road = *s.surroundings, height = s.x[0] + road;
  const bool distance = r.over == spec::Road::Over::distance;
  const double x1 = distance ? w.frames[d.frame_b].position[0] + w.origin[0] : w.signals.time;
  const bool grid = r.over == spec::Road::Over::grid;  // which has no jumps
  const double slope = distance ? r.height.derivative(x1) : grid ? 0 : w.signals.rate[r.slot];
  if (started_) {
    // The road moves under the wheel, half of it before and half after the wheel does: exact for jumps too.
    const double moved_first = stored_at(context, s, f.height - road),
                 moved_last = stored_at(context, s, height - f.road);
    balance_.road_work += 0.5 * (moved_first - stores_[k].energy + stored - moved_last);
    // What a jump of the road alone releases or stores.
    const double smooth = f.road + 0.5 * (f.slope + slope) * (x1 - f.along);
    if (!grid) jump_ += std::abs(moved_first - stored_at(context, s, f.height - smooth));
  }
  f.along = x1;
  f.slope = slope;
  f.height = height;
  f.road = road;
}

void EnergyMeter::keep_wheel(const ElementState<double>& s, const ElementEnergy& now, Flow& f) {
  f.gap = s.x[wheel::gap];
  f.spring = now.dissipating[wheel::gap] - s.force[wheel::gap];
  std::copy_n(s.surroundings, surroundings_size(Measure::wheel), f.surroundings);
}

/// What a road does to a wheel: it moves the gap by more than the wheel's own motion does, where it rises, or
/// bends below the wheel; half of that before and half after the wheel moves. And what a tyre stores that
/// grows with its spin.
void EnergyMeter::observe_wheel(const LawContext<double>& context, const ElementState<double>& s,
                                const ElementEnergy& now, double h, Flow& f) {
  // Within this share of the depth the spring's force is as good as constant.
  constexpr double little = 1e-3;
  const double gap = s.x[wheel::gap], was = f.gap, before = f.spring;
  const double moved = gap - was - 0.5 * h * (s.v[wheel::gap] + f.progress[wheel::gap]);
  double surroundings[surroundings_size(Measure::wheel)];
  std::copy(std::begin(f.surroundings), std::end(f.surroundings), surroundings);
  keep_wheel(s, now, f);
  if (!started_) return;
  if (gap > 0 && was > 0 && std::min(was + moved, gap - moved) > 0) return;
  const double there = stored_at(context, s, was);
  balance_.road_work += 0.5 * (now.stored - stored_at(context, s, gap, surroundings) + there -
                               stored_at(context, s, was, surroundings));
  if (std::abs(moved) < little * std::min(-gap, -was))
    balance_.road_work -= 0.5 * (before + f.spring) * moved;
  else
    balance_.road_work +=
        0.5 * (stored_at(context, s, was + moved) - there + now.stored - stored_at(context, s, gap - moved));
}

void EnergyMeter::observe(relative::RelativeSystem& system, const State& s) {
  const Compiled& m = *model_;
  auto& w = system.workspace();
  relative::forces(m, w, s.time, s.q.data(), s.v.data(), s.a.data(), generalised_.data());
  EnergyBalance& e = balance_;
  const double h = s.time - time_;
  jump_ = std::exchange(pending_jump_, 0.0);
  most_exchanged_ = 0;
  place_ = {};
  const std::size_t body_store = m.elements.size();

  e.kinetic = kinetic_energy(m, w, s.q.data(), s.v.data());
  e.gravitational = e.elastic = e.springs = e.tyres = 0;
  for (std::size_t i = 0; i < m.bodies.size(); ++i) {
    const BodyData& b = m.bodies[i];
    double mass = b.mass;
    Vec3d first = b.first_moment;
    if (b.modes > 0 && !b.elastodynamic) {
      const double elastic_of_others = e.elastic;
      const FlexibleData& f = m.flexible[b.flexible];
      const relative::ConstantInertia inertia = relative::constant_inertia(m, w, b);
      mass = inertia.mass;
      first = inertia.first_moment;
      double *y = w.scratch.data(), *yd = y + f.stride;
      relative::copy_modes(b, s.q.data() + b.q + b.joint_positions, f.stride, y);
      relative::copy_modes(b, s.v.data() + b.v + b.joint_velocities, f.stride, yd);
      extend(f, y);
      double* forces = yd + f.stride;
      std::fill(forces, forces + f.stride, 0.0);
      if (f.absolute()) {
        ancf::add_forces(f, 0, 1, y, yd, forces);
        e.elastic += ancf::energy(f, y);
      }
      if (!f.geometric.empty()) observe_geometric(i, w, s, y, forces + f.stride);
      double work = 0;
      for (int k = 0; k < f.modes; ++k) {
        first += y[k] * inertia.S.matrix().col(k);
        double elastic = 0, damping = forces[k];
        if (f.diagonal_stiffness) {
          elastic = f.stiffness(k, k) * y[k];
          damping = f.damping(k, k) * yd[k];
        } else if (!f.absolute()) {
          for (int l = 0; l < f.modes; ++l) {
            elastic += f.stiffness(l, k) * y[l];
            damping += f.damping(l, k) * yd[l];
          }
        }
        e.elastic += 0.5 * elastic * y[k];
        if (k >= b.modes) continue;  // products have no damping of their own
        const int at = b.v + b.joint_velocities + k;
        if (started_) work += 0.5 * (damping + damping_force_[at]) * (y[k] - modal_[at]);
        damping_force_[at] = damping;
        modal_[at] = y[k];
      }
      e.dissipated += work;
      if (b.modes > 0) observe_store(body_store + i, e.elastic - elastic_of_others);
    }
    e.gravitational -= m.gravity.dot(mass * (w.bodies[i].position + w.origin) + w.bodies[i].rotation * first);
  }
  for (std::size_t k = 0; k < m.elements.size(); ++k) observe_element(k, w, h);
  for (std::size_t k = 0; k < m.drives.size(); ++k) {
    const DriveData& d = m.drives[k];
    const double force = -s.multipliers[d.equation];
    if (started_) e.drive_work += 0.5 * (force + drive_force_[k]) * (s.q[d.q] - drive_position_[k]);
    drive_position_[k] = s.q[d.q];
    drive_force_[k] = force;
  }
  time_ = s.time;
}

}  // namespace mimbre
