#include "simulation/energy.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dynamics/amplitudes.h"
#include "dynamics/elasticity.h"
#include "dynamics/flexible.h"
#include "dynamics/geometric.h"
#include "dynamics/relative/forces.h"
#include "dynamics/relative/kinematics.h"

namespace mimbre {
double kinetic_energy(const Compiled& m, relative::Workspace<double>& w, const double* q, const double* v) {
  double energy = 0;
  for (std::size_t i = 0; i < m.bodies.size(); ++i) {
    const BodyData& b = m.bodies[i];
    const auto& motion = w.bodies[i];
    const Vec3d u = motion.rotation.transpose() * motion.velocity,
                omega = motion.rotation.transpose() * motion.omega;
    if (b.modes == 0) {
      energy += 0.5 * b.mass * u.squaredNorm() + u.dot(omega.cross(b.first_moment)) +
                0.5 * omega.dot(b.inertia * omega);
      continue;
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
      continue;
    }
    deformed_integrals<double>(f, y, integrals);
    const Vec3d first = b.first_moment + times(f.S, y), sy = times(f.S, yd);
    const Mat3d second = deformed_second_moment<double>(f, b.second_moment, integrals, y);
    const Mat3d inertia = second.trace() * Mat3d::Identity() - second;
    const auto d = [&](int r, int c) { return dot(integrals + (3 * r + c) * n, yd, n); };
    const Vec3d cy(d(1, 2) - d(2, 1), d(2, 0) - d(0, 2), d(0, 1) - d(1, 0));
    energy += 0.5 * b.mass * u.squaredNorm() + u.dot(omega.cross(first) + sy) +
              0.5 * omega.dot(inertia * omega) + omega.dot(cy);
    if (f.identity_mass) {
      energy += 0.5 * dot(yd, yd, n);
    } else {
      for (int k = 0; k < f.modes; ++k) energy += 0.5 * yd[k] * dot(f.mass.data() + k * n, yd, n);
    }
  }
  return energy;
}

EnergyMeter::EnergyMeter(const Compiled& m)
    : model_(&m),
      springs_(m.springs.size()),
      joint_springs_(m.joint_springs.size()),
      tyre_height_(m.tyres.size()),
      tyre_road_(m.tyres.size()),
      tyre_x_(m.tyres.size()),
      generalised_(m.velocities),
      drive_position_(m.drives.size()),
      drive_force_(m.drives.size()),
      load_position_(m.loads.size()),
      load_force_(m.loads.size()),
      load_power_(m.loads.size()),
      damping_force_(Eigen::VectorXd::Zero(m.velocities)),
      modal_(Eigen::VectorXd::Zero(m.velocities)),
      geometric_force_(Eigen::VectorXd::Zero(m.velocities)) {
  const auto add = [&](Place::Kind kind, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) stores_.push_back({{kind, static_cast<int>(k)}});
  };
  add(Place::Kind::spring, m.springs.size());
  add(Place::Kind::joint_spring, m.joint_springs.size());
  add(Place::Kind::tyre, m.tyres.size());
  add(Place::Kind::body, m.bodies.size());
}

void EnergyMeter::start(relative::RelativeSystem& system, const State& s) {
  balance_ = {};
  started_ = false;
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

/// Energy ½ yᵀ K_G y at the present loads of inertia and gravity, and what their change put in since the last
/// step: as the work of K_G y is its mean times the displacement, that is ½ y0ᵀ (K_G1 − K_G0) y1. Forces at
/// the boundary have an energy of their own. `first`: the velocity coordinate of the first amplitude,
/// `forces`: scratch.
void EnergyMeter::observe_geometric(const GeometricData& g, const StressMotion<double>& motion, int first,
                                    const double* y, double* forces) {
  balance_.elastic += geometric::boundary_energy(g, y, forces);
  std::fill(forces, forces + g.stiffness.cols(), 0.0);
  geometric::add_inertial_forces(g, motion, y, forces);
  for (int k = 0; k < g.modes; ++k) {
    balance_.elastic += 0.5 * forces[k] * y[k];
    if (started_)
      balance_.load_work += 0.5 * (forces[k] * modal_[first + k] - geometric_force_[first + k] * y[k]);
    geometric_force_[first + k] = forces[k];
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

EnergyMeter::Unresolved EnergyMeter::most_unresolved() const {
  const Store* most = nullptr;
  for (const Store& store : stores_)
    if (store.unresolved > (most ? most->unresolved : 0)) most = &store;
  if (!most) return {};
  // The energy of a vibration varies as sin² ωt: its second differences are 2 sin ωh times the first.
  const double angle = std::asin(std::min(1.0, 0.5 * most->unresolved / most->exchanged));
  return {most->place, 2 * std::numbers::pi / angle, most->highest - most->lowest};
}

void EnergyMeter::observe(relative::RelativeSystem& system, const State& s) {
  const Compiled& m = *model_;
  auto& w = system.workspace();
  relative::forces<double>(m, w, s.time, s.q.data(), s.v.data(), generalised_.data());
  EnergyBalance& e = balance_;
  const double h = s.time - time_;
  jump_ = most_exchanged_ = 0;
  place_ = {};
  const std::size_t joint_store = m.springs.size(), tyre_store = joint_store + m.joint_springs.size(),
                    body_store = tyre_store + m.tyres.size();

  e.kinetic = kinetic_energy(m, w, s.q.data(), s.v.data());
  e.gravitational = e.elastic = e.springs = e.tyres = 0;
  for (std::size_t i = 0; i < m.bodies.size(); ++i) {
    const BodyData& b = m.bodies[i];
    double mass = b.mass;
    Vec3d first = b.first_moment;
    if (b.modes > 0) {
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
      if (!f.ancf.empty()) {
        ancf::add_forces(f, 0, 1, y, yd, forces);
        e.elastic += ancf::energy(f, y);
      }
      if (!f.geometric.empty()) {
        double* ydd = forces + f.stride;
        relative::copy_modes(b, s.a.data() + b.v + b.joint_velocities, f.stride, ydd);
        const auto& motion = w.bodies[i];
        const Mat3d to_body = motion.rotation.transpose();
        observe_geometric(
            f.geometric,
            geometric::stress_motion<double>(f.geometric, to_body * motion.omega,
                                             to_body * motion.acceleration, to_body * motion.alpha, ydd),
            b.v + b.joint_velocities, y, ydd + f.stride);
      }
      double work = 0;
      for (int k = 0; k < f.modes; ++k) {
        first += y[k] * inertia.S.col(k);
        double elastic = 0, damping = forces[k];
        if (f.diagonal_stiffness) {
          elastic = f.stiffness(k, k) * y[k];
          damping = f.damping(k, k) * yd[k];
        } else if (f.ancf.empty()) {
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
  for (std::size_t k = 0; k < m.springs.size(); ++k) {
    const SpringData& d = m.springs[k];
    const auto& state = w.springs[k];
    Flow& f = springs_[k];
    const double potential = spring_potential(d, state.length);
    // What an expression owes to the rate is a damper's. (It may be undefined at rest.)
    const double whole = spring_general(d, state.length, state.rate, s.time),
                 at_rest = spring_general(d, state.length, 0, s.time),
                 general = std::isfinite(at_rest) ? at_rest : 0,
                 damping = spring_damping(d, state.rate) + whole - general;
    e.springs += potential;
    if (started_) {
      const double dl = state.length - f.length;
      e.dissipated += 0.5 * (damping + f.damping) * dl;
      e.load_work -= 0.5 * (general + f.general) * dl;
    }
    observe_store(k, potential);
    f = {state.length, state.tension, damping, general};
  }
  for (std::size_t k = 0; k < m.joint_springs.size(); ++k) {
    const JointSpringData& d = m.joint_springs[k];
    Flow& f = joint_springs_[k];
    const double x = s.q[d.q], damping = joint_spring_damping(d, s.v[d.v]);
    const double potential = joint_spring_potential(d, x);
    e.springs += potential;
    observe_store(joint_store + k, potential);
    if (started_) e.dissipated += 0.5 * (damping + f.damping) * (x - f.length);
    f = {x, 0, damping, 0};
  }
  for (std::size_t k = 0; k < m.tyres.size(); ++k) {
    const TyreData& t = m.tyres[k];
    const double wheel = w.frames[t.frame].position[2] + w.origin[2], road = w.tyres[k].road;
    const double potential = tyre_potential(t, wheel, road);
    const RoadData& r = m.roads[t.road];
    const double x1 =
        r.over == spec::Road::Over::distance ? w.frames[t.frame].position[0] + w.origin[0] : s.time;
    e.tyres += potential;
    if (started_) {
      // The road moves under the wheel, half of it before and half after the wheel does: exact for jumps too.
      e.road_work += 0.5 * (tyre_potential(t, tyre_height_[k], road) - stores_[tyre_store + k].energy +
                            potential - tyre_potential(t, wheel, tyre_road_[k]));
      // What a jump of the road alone releases or stores.
      const double x0 = tyre_x_[k];
      const double smooth =
          tyre_road_[k] + 0.5 * (r.height.derivative(x0) + r.height.derivative(x1)) * (x1 - x0);
      jump_ +=
          std::abs(tyre_potential(t, tyre_height_[k], road) - tyre_potential(t, tyre_height_[k], smooth));
    }
    tyre_x_[k] = x1;
    tyre_height_[k] = wheel;
    tyre_road_[k] = road;
    observe_store(tyre_store + k, potential);
  }
  for (std::size_t k = 0; k < m.drives.size(); ++k) {
    const DriveData& d = m.drives[k];
    const double force = -s.multipliers[d.equation];
    if (started_) e.drive_work += 0.5 * (force + drive_force_[k]) * (s.q[d.q] - drive_position_[k]);
    drive_position_[k] = s.q[d.q];
    drive_force_[k] = force;
  }
  for (std::size_t k = 0; k < m.loads.size(); ++k) {
    const LoadData& l = m.loads[k];
    const auto& frame = w.frames[l.frame];
    const auto [force, moment] = load_wrench<double>(l, frame.rotation, s.time);
    const double power = moment.dot(frame.omega);
    const Vec3d position = frame.position + w.origin;
    if (started_)
      e.load_work += 0.5 * (force + load_force_[k]).dot(position - load_position_[k]) +
                     0.5 * h * (power + load_power_[k]);
    load_position_[k] = position;
    load_force_[k] = force;
    load_power_[k] = power;
  }
  time_ = s.time;
}

}  // namespace mimbre
