#pragma once
#include <type_traits>

#include "dynamics/elasticity.h"
#include "dynamics/flexible.h"
#include "dynamics/geometric.h"
#include "dynamics/natural/workspace.h"

/// Inertia of bodies in natural coordinates (Lugrís 2008, 3.13–3.47).
namespace mimbre::natural {

/// ∫ (1, r̄)(1, r̄)ᵀ dm of a deformed body; `rows`: its S'^i rows at y.
template <class T>
Eigen::Matrix<T, 4, 4> deformed_mass(const BodyData& b, const FlexibleData& f, const InertiaRows<T>& rows,
                                     const T* y) {
  Eigen::Matrix<T, 4, 4> mass;
  const Vec3<T> moment = deformed_first_moment<T>(b, f, y);
  mass(0, 0) = T(b.mass);
  mass.template block<3, 1>(1, 0) = moment;
  mass.template block<1, 3>(0, 1) = moment.transpose();
  mass.template bottomRightCorner<3, 3>() = deformed_second_moment<T>(b, f, rows, y);
  return mass;
}

/// The forces that inertia() adds for one flexible body, by projection of its mesh.
inline void projected_inertia(const projection::Constants& c, projection::Work& work,
                              const BaseMotion<double>& motion, const Base<double>& second, const double* y,
                              const double* yd, const double* ydd, Base<double>& out, double* elastic) {
  const Mat3d A = motion.position.rightCols<3>();
  projection::Base base, forces;
  for (int s = 0; s < 4; ++s) base[s] = A.transpose() * second.col(s);
  projection::inertia_forces(c, work, base, A.transpose() * motion.velocity.rightCols<3>(), y, yd, ydd,
                             forces, elastic);
  for (int s = 0; s < 4; ++s) out.col(s) += A * forces[s];
}

/// What stresses a body with geometric stiffness, by its base vectors' motion and their accelerations,
/// gravity taken off.
template <class T>
StressMotion<T> stress_motion(const GeometricData& g, const BaseMotion<T>& base, const Base<T>& second,
                              const T* ydd) {
  const Mat3<T> A = base.position.template rightCols<3>();
  const Mat3<T> turning = A.transpose() * base.velocity.template rightCols<3>(),
                gradient = A.transpose() * second.template rightCols<3>();
  const auto axis = [](const Mat3<T>& m) {
    return Vec3<T>(T(0.5) * (m(2, 1) - m(1, 2)), T(0.5) * (m(0, 2) - m(2, 0)), T(0.5) * (m(1, 0) - m(0, 1)));
  };
  return geometric::stress_motion<T>(g, axis(turning), A.transpose() * second.col(0), axis(gradient), ydd);
}

/// elastic += Mff ÿ.
template <class T>
void add_modal_inertia(const FlexibleData& f, const T* ydd, T* elastic) {
  const int s = f.stride;
  if (f.identity_mass)
    for (int k = 0; k < s; ++k) elastic[k] += ydd[k];
  else
    for (int r = 0; r < f.modes; ++r)
      for (int k = 0; k < s; ++k) elastic[k] += ydd[r] * f.mass(r, k);
}

/// elastic += Σ S'^iᵀ Aᵀ ä_i, `local` = Aᵀ (ä_1, ä_2, ä_3) = α~ + ω~ ω~: its skew part by angular
/// acceleration, the symmetric one centrifugal.
template <class T>
void add_turning_forces(const BodyData& b, int stride, const Mat3<T>& local, const InertiaRows<T>& rows,
                        T* elastic) {
  const auto add = [&](const Mat3<T>& gradient, const T* of) {
    for (int r = 0; r < 9; ++r) {
      const T c = gradient(r % 3, r / 3);
      const T* row = of + r * stride;
      for (int k = 0; k < stride; ++k) elastic[k] += c * row[k];
    }
  };
  if (b.neglected.empty()) return add(local, rows.deformed);
  const Mat3<T> symmetric = T(0.5) * (local + local.transpose());
  if (!b.neglected.has(InertiaTerm::centrifugal)) add(symmetric, rows.of(InertiaTerm::centrifugal_deformed));
  if (!b.neglected.has(InertiaTerm::rotation_coupling))
    add(local - symmetric, rows.of(InertiaTerm::rotation_coupling_deformed));
}

/// Adds M̄ q̈ − Q̄v of all bodies, gravity, and elastic and damping forces:
///   on r0:  m r̈0 + Σ m̄_i ä_i + A S ÿ + 2 Ȧ S ẏ                         (a_1, a_2, a_3 = u, v, w)
///   on a_i: m̄_i r̈0 + Σ P̄_ij ä_j + A S'^i ÿ + 2 Ȧ S'^i ẏ
///   on y:   Sᵀ Aᵀ r̈0 + Σ S'^iᵀ Aᵀ ä_i + Mff ÿ + 2 ∫XᵀAᵀȦX dm ẏ + K y + C ẏ
/// with r̈0 − g for r̈0.
template <class T>
void inertia(const Compiled& m, const Layout& l, Workspace<T>& w) {
  for (std::size_t i = 0; i < l.bodies.size(); ++i) {
    const Body& b = l.bodies[i];
    const BodyData& data = m.bodies[i];
    Base<T> second = w.bodies[i].acceleration;
    second.col(0) -= m.gravity.template cast<T>();
    Base<T>& out = w.forces[i];
    if (data.modes == 0) {
      out.noalias() += second * b.mass.template cast<T>();
      continue;
    }
    const FlexibleData& f = m.flexible[data.flexible];
    const int s = f.stride;
    const T *y = w.y.data() + b.amplitudes, *yd = w.yd.data() + b.amplitudes,
            *ydd = w.ydd.data() + b.amplitudes;
    T* elastic = w.modal.data() + b.amplitudes;
    if (!f.geometric.empty()) {
      geometric::add_inertial_forces(f.geometric, stress_motion(f.geometric, w.bodies[i], second, ydd), y,
                                     elastic);
      geometric::add_boundary_forces(f.geometric, y, w.geometric_scratch.data(), elastic);
    }
    if constexpr (std::is_same_v<T, double>) {
      if (!w.projections.empty()) {
        projected_inertia(w.projections[data.flexible], w.projection, w.bodies[i], second, y, yd, ydd, out,
                          elastic);
        add_elasticity(f, y, yd, elastic);
        continue;
      }
    }
    const InertiaRows<T> rows = make_inertia_rows<T>(data, f, y, w.integrals.data());
    out.noalias() += second * deformed_mass<T>(data, f, rows, y);
    const Mat3<T> A = w.bodies[i].position.template rightCols<3>(),
                  Ad = w.bodies[i].velocity.template rightCols<3>();
    const auto keeps = [&](InertiaTerm term) { return !data.neglected.has(term); };
    Base<T> rate = Base<T>::Zero(), accelerated = rate;  // S ẏ and S'^i ẏ; likewise with ÿ
    const auto spread = [&](InertiaTerm by_deformation, const T* rates, Base<T>& field) {
      const T* row = rows.of(by_deformation);
      for (int a = 0; a < 3; ++a)
        for (int c = 0; c < 3; ++c) field(c, 1 + a) = dot(row + (3 * a + c) * s, rates, s);
    };
    accelerated.col(0) = times(f.S, ydd);
    if (keeps(InertiaTerm::coriolis_body)) {
      rate.col(0) = times(f.S, yd);
      spread(InertiaTerm::coriolis_body_deformed, yd, rate);
    }
    if (keeps(InertiaTerm::rotation_coupling))
      spread(InertiaTerm::rotation_coupling_deformed, ydd, accelerated);
    out.noalias() += A * accelerated + T(2) * (Ad * rate);

    const Base<T> local = A.transpose() * second;
    add_transposed<T>(f.S, local.col(0), elastic);
    add_turning_forces<T>(data, s, local.template rightCols<3>(), rows, elastic);
    if (!keeps(InertiaTerm::coriolis_modes)) {
      add_modal_inertia(f, ydd, elastic);
      add_elasticity(f, y, yd, elastic);
      continue;
    }
    const Mat3<T> turning = A.transpose() * Ad;
    const T w0 = turning(2, 1) - turning(1, 2), w1 = turning(0, 2) - turning(2, 0),
            w2 = turning(1, 0) - turning(0, 1);  // 2 ω in body axes
    for (int r = 0; r < f.modes; ++r) {
      const double* n = f.coriolis.data() + static_cast<std::ptrdiff_t>(r) * 3 * s;
      const T v = yd[r];
      for (int k = 0; k < s; ++k) elastic[k] += v * (w0 * n[k] + w1 * n[s + k] + w2 * n[2 * s + k]);
    }
    add_modal_inertia(f, ydd, elastic);
    add_elasticity(f, y, yd, elastic);
  }
}

}  // namespace mimbre::natural
