#include "dynamics/relative/momentum.h"

#include "dynamics/flexible.h"
#include "dynamics/relative/kinematics.h"

namespace mimbre::relative {
namespace {

/// Momentum of one body, its angular part about its origin, its inertia there, and ∫ s ẋᵀ dm, s from there;
/// body axes.
struct BodyMomentum {
  double mass;
  Vec3d first_moment, linear, angular;
  Mat3d inertia, spread;
};

Mat3d inertia_of(const Mat3d& second_moment) {
  return second_moment.trace() * Mat3d::Identity() - second_moment;
}

/// p = m u + ω × m̄ + S ẏ,   l = m̄ × u + J ω + C ẏ  (the rows of the mass matrix)
BodyMomentum body_momentum(const Compiled& m, Workspace<double>& w, const BodyData& b, const Vec3d& u,
                           const Vec3d& omega, const double* q, const double* v) {
  BodyMomentum out{b.mass, b.first_moment, Vec3d::Zero(), Vec3d::Zero(), b.inertia, Mat3d::Zero()};
  Vec3d modal = Vec3d::Zero(), modal_moment = Vec3d::Zero();
  Mat3d second = b.second_moment;
  if (b.modes > 0 && !b.elastodynamic) {
    const FlexibleData& f = m.flexible[b.flexible];
    const int n = f.stride;
    double *y = w.scratch.data(), *yd = y + n, *integrals = yd + n;
    copy_modes(b, q + b.q + b.joint_positions, n, y);
    copy_modes(b, v + b.v + b.joint_velocities, n, yd);
    extend(f, y);
    extend(f, y, yd);
    const double* positions = integrals;
    if (w.projections.empty()) {
      const InertiaRows<double> rows = make_inertia_rows<double>(b, f, y, integrals);
      out.first_moment = deformed_first_moment<double>(b, f, y);
      second = deformed_second_moment<double>(b, f, rows, y);
      modal = times(f.S, yd);
      positions = rows.of(InertiaTerm::rotation_coupling_deformed);
    } else {
      const projection::Constants& c = w.projections[b.flexible];
      projection::rigid_mass(c, w.projection, y, out.first_moment, second, integrals);
      out.mass = c.total_mass;
      modal = times(c.S, yd);
    }
    out.inertia = inertia_of(second);
    const auto d = [&](int r, int c) { return dot(positions + (3 * r + c) * n, yd, n); };
    if (!b.neglected.has(InertiaTerm::rotation_coupling))
      modal_moment = Vec3d(d(1, 2) - d(2, 1), d(2, 0) - d(0, 2), d(0, 1) - d(1, 0));
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) out.spread(r, c) = d(r, c);
  }
  out.linear = out.mass * u + omega.cross(out.first_moment) + modal;
  out.angular = out.first_moment.cross(u) + out.inertia * omega + modal_moment;
  // ẋ = u + ω × s + X ẏ.
  for (int r = 0; r < 3; ++r)
    out.spread.row(r) += out.first_moment[r] * u.transpose() + omega.cross(Vec3d(second.row(r))).transpose();
  return out;
}

}  // namespace

Momentum momentum(const Compiled& m, Workspace<double>& w, const std::vector<int>& bodies, const double* q,
                  const double* v) {
  Momentum out;
  Vec3d moment = Vec3d::Zero();
  for (const int i : bodies) {
    const Motion<double>& at = w.bodies[i];
    const Mat3d& A = at.rotation;
    const BodyMomentum b =
        body_momentum(m, w, m.bodies[i], A.transpose() * at.velocity, A.transpose() * at.omega, q, v);
    const Vec3d p = A * b.linear, s = A * b.first_moment, &r = at.position;
    out.mass += b.mass;
    moment += b.mass * r + s;
    out.linear += p;
    out.angular += A * b.angular + r.cross(p);
    out.spread += A * b.spread * A.transpose() + r * p.transpose();
    // ∫ (r + s)(r + s)ᵀ dm; the body's own part follows below.
    const Mat3d mixed = r * s.transpose();
    out.inertia +=
        A * b.inertia * A.transpose() + inertia_of(b.mass * r * r.transpose() + mixed + mixed.transpose());
  }
  out.centre = moment / out.mass;
  out.angular -= out.centre.cross(out.linear);
  out.spread -= out.centre * out.linear.transpose();
  out.inertia -= inertia_of(out.mass * out.centre * out.centre.transpose());
  return out;
}

Vec3d mean_spin(const Mat3d& inertia, const Vec3d& angular) {
  const Mat3d J = inertia + 1e-11 * inertia.trace() * Mat3d::Identity();
  // The rows of the inverse: cross products of columns over the determinant.
  const Vec3d a = J.col(1).cross(J.col(2)), b = J.col(2).cross(J.col(0)), c = J.col(0).cross(J.col(1));
  const double determinant = J.col(0).dot(a);
  if (!(determinant > 0)) return Vec3d::Zero();
  return Vec3d(a.dot(angular), b.dot(angular), c.dot(angular)) / determinant;
}

double centrifugal_power(const Momentum& p, const Vec3d& angular) {
  const Vec3d spin = mean_spin(p.inertia, angular), added = mean_spin(p.inertia, angular - p.angular);
  return spin.dot(p.spread * spin) - spin.squaredNorm() * p.spread.trace() - spin.dot(added.cross(angular));
}

}  // namespace mimbre::relative
