#pragma once
#include "dynamics/relative/momentum.h"

#include <type_traits>

#include "dynamics/flexible.h"
#include "dynamics/relative/kinematics.h"

namespace mimbre::relative {
namespace momentum_parts {

/// Momentum of one body, its angular part about its origin, its inertia there, and ∫ s ẋᵀ dm, s from there;
/// body axes.
template <class T>
struct BodyMomentum {
  T mass;
  Vec3<T> first_moment, linear, angular;
  Mat3<T> inertia, spread;
};

template <class T>
Mat3<T> inertia_of(const Mat3<T>& second_moment) {
  return second_moment.trace() * Mat3<T>::Identity() - second_moment;
}

/// p = m u + ω × m̄ + S ẏ,   l = m̄ × u + J ω + C ẏ  (the rows of the mass matrix)
template <class T>
BodyMomentum<T> body_momentum(const Compiled& m, Workspace<T>& w, const BodyData& b, const Vec3<T>& u,
                              const Vec3<T>& omega, const T* q, const T* v) {
  BodyMomentum<T> out{b.mass,          b.first_moment.cast<T>(), Vec3<T>::Zero(),
                      Vec3<T>::Zero(), b.inertia.cast<T>(),      Mat3<T>::Zero()};
  Vec3<T> modal = Vec3<T>::Zero(), modal_moment = Vec3<T>::Zero();
  Mat3<T> second = b.second_moment.cast<T>();
  if (b.modes > 0 && !b.elastodynamic) {
    const FlexibleData& f = m.flexible[b.flexible];
    const int n = f.stride;
    T *y = w.scratch.data(), *yd = y + n, *integrals = yd + n;
    copy_modes(b, q + b.q + b.joint_positions, n, y);
    copy_modes(b, v + b.v + b.joint_velocities, n, yd);
    extend(f, y);
    extend(f, y, yd);
    const T* positions = integrals;
    if (w.projections.empty()) {
      const InertiaRows<T> rows = make_inertia_rows<T>(b, f, y, integrals);
      out.first_moment = deformed_first_moment<T>(b, f, y);
      second = deformed_second_moment<T>(b, f, rows, y);
      modal = times(f.S, yd);
      positions = rows.of(InertiaTerm::rotation_coupling_deformed);
    } else if constexpr (std::is_same_v<T, double>) {
      const projection::Constants& c = w.projections[b.flexible];
      projection::rigid_mass(c, w.projection, y, out.first_moment, second, integrals);
      out.mass = c.total_mass;
      modal = times(c.S, yd);
    }
    out.inertia = inertia_of<T>(second);
    const auto d = [&](int r, int c) { return dot(positions + (3 * r + c) * n, yd, n); };
    if (!b.neglected.has(InertiaTerm::rotation_coupling))
      modal_moment = Vec3<T>(d(1, 2) - d(2, 1), d(2, 0) - d(0, 2), d(0, 1) - d(1, 0));
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) out.spread(r, c) = d(r, c);
  }
  out.linear = out.mass * u + omega.cross(out.first_moment) + modal;
  out.angular = out.first_moment.cross(u) + out.inertia * omega + modal_moment;
  // ẋ = u + ω × s + X ẏ.
  for (int r = 0; r < 3; ++r)
    out.spread.row(r) +=
        out.first_moment[r] * u.transpose() + omega.cross(Vec3<T>(second.row(r))).transpose();
  return out;
}

}  // namespace momentum_parts

template <class T>
MomentumOf<T> momentum(const Compiled& m, Workspace<T>& w, const std::vector<int>& bodies, const T* q,
                       const T* v) {
  using momentum_parts::inertia_of, momentum_parts::body_momentum;
  MomentumOf<T> out;
  Vec3<T> moment = Vec3<T>::Zero();
  for (const int i : bodies) {
    const Motion<T>& at = w.bodies[i];
    const Mat3<T>& A = at.rotation;
    const momentum_parts::BodyMomentum<T> b =
        body_momentum<T>(m, w, m.bodies[i], A.transpose() * at.velocity, A.transpose() * at.omega, q, v);
    const Vec3<T> p = A * b.linear, s = A * b.first_moment, &r = at.position;
    out.mass += b.mass;
    moment += b.mass * r + s;
    out.linear += p;
    out.angular += A * b.angular + r.cross(p);
    out.spread += A * b.spread * A.transpose() + r * p.transpose();
    // ∫ (r + s)(r + s)ᵀ dm; the body's own part follows below.
    const Mat3<T> mixed = r * s.transpose();
    out.inertia +=
        A * b.inertia * A.transpose() + inertia_of<T>(b.mass * r * r.transpose() + mixed + mixed.transpose());
  }
  out.centre = moment / out.mass;
  out.angular -= out.centre.cross(out.linear);
  out.spread -= out.centre * out.linear.transpose();
  out.inertia -= inertia_of<T>(out.mass * out.centre * out.centre.transpose());
  return out;
}

template <class T>
Vec3<T> mean_spin(const Mat3<T>& inertia, const Vec3<T>& angular) {
  const Mat3<T> J = inertia + T(1e-11) * inertia.trace() * Mat3<T>::Identity();
  // The rows of the inverse: cross products of columns over the determinant.
  const Vec3<T> a = J.col(1).cross(J.col(2)), b = J.col(2).cross(J.col(0)), c = J.col(0).cross(J.col(1));
  const T determinant = J.col(0).dot(a);
  return choose(
      determinant > T(0),
      [&] { return Vec3<T>(Vec3<T>(a.dot(angular), b.dot(angular), c.dot(angular)) / determinant); },
      [] { return Vec3<T>(Vec3<T>::Zero()); });
}

template <class T>
T centrifugal_power(const MomentumOf<T>& p, const Vec3<T>& angular) {
  const Vec3<T> spin = mean_spin<T>(p.inertia, angular), added = mean_spin<T>(p.inertia, angular - p.angular);
  return spin.dot(p.spread * spin) - spin.squaredNorm() * p.spread.trace() - spin.dot(added.cross(angular));
}

}  // namespace mimbre::relative
