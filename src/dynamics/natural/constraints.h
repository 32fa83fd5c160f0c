#pragma once
#include "constraints/table.h"
#include "dynamics/natural/joint_rates.h"

/// Rigidity of the bodies, what joints do not share, drives, and constraints between bodies.
namespace mimbre::natural {

/// x · z and its derivatives.
template <class T>
void dot_product(const Vec3<T>& x, const Vec3<T>& x1, const Vec3<T>& x2, const Vec3<T>& z, const Vec3<T>& z1,
                 const Vec3<T>& z2, T& value, T& first, T& second) {
  value = x.dot(z);
  first = x1.dot(z) + x.dot(z1);
  second = x2.dot(z) + T(2) * x1.dot(z1) + x.dot(z2);
}

/// Positions of a coupling's joint in the tree among q; null where it is cut.
template <class T>
const T* known_positions(const Layout& l, const ConstraintTerm& term, const T* q) {
  return term.body < 0 ? nullptr : q + l.joint_coordinates[term.body].q;
}

/// Φ, Φ̇, Φ̈ of constraints, with the covectors of what they have between two frames.
template <class T>
void constrain_bodies(const Compiled& m, const Layout& l, Workspace<T>& w, const T* q) {
  for (std::size_t i = 0; i < m.constraints.size(); ++i) {
    const ConstraintData& c = m.constraints[i];
    const int k = l.constraints[i].first_equation, terms = static_cast<int>(c.terms.size());
    for (int r = 0; r < c.count; ++r) w.phi[k + r] = w.phi_dot[k + r] = w.phi_ddot[k + r] = T(0);
    if (c.of_coordinates) w.phi[k] = T(-c.numbers[0]);
    for (int t = 0; t < terms; ++t) {
      const ConstraintTerm& term = c.terms[t];
      const FrameMotion<T>& A = w.frames[term.frame_a];
      const RelativeMotion<T> motion = relative_motion<T>(A, w.frames[term.frame_b]);
      ScalarEquation<T> equation[constraints::most_equations];
      constraints::equations<T>[c.kind](
          {c, term, motion, known_positions<T>(l, term, q), w.signals.states + c.states,
           w.constraint_states.data() + c.next_states, w.rate_time, c.road < 0 ? nullptr : &m.roads[c.road]},
          equation);
      for (int r = 0; r < c.count; ++r) {
        w.phi[k + r] += equation[r].value;
        w.phi_dot[k + r] += equation[r].rate(motion);
        w.phi_ddot[k + r] += equation[r].second(motion);
        w.constraint_linear[c.covectors + r * terms + t] = A.axes * equation[r].linear;
        w.constraint_angular[c.covectors + r * terms + t] = A.axes * equation[r].angular;
      }
    }
  }
}

/// Puts `force` and `moment` of a constraint's term on its two bodies.
template <class T>
void act_by_term(const Compiled& m, const Workspace<T>& w, const ConstraintTerm& term, const Vec3<T>& force,
                 const Vec3<T>& moment, const Covector<T>& on_a, const Covector<T>& on_b) {
  act_between<T>(m, term.frame_a, term.frame_b, w.frames[term.frame_a], w.frames[term.frame_b], force, moment,
                 on_a, on_b);
}

/// Φ, Φ̇, Φ̈ of all equations, after kinematics; q's joint coordinates belong to the same position.
template <class T>
void constraints(const Compiled& m, const Layout& l, Workspace<T>& w, const T* q) {
  T *phi = w.phi.data(), *phi1 = w.phi_dot.data(), *phi2 = w.phi_ddot.data();
  for (std::size_t i = 0; i < l.bodies.size(); ++i) {
    const Body& b = l.bodies[i];
    if (b.rigidity.empty()) continue;
    const BaseMotion<T>& motion = w.bodies[i];
    const Mat3<T> directions = b.directions.template cast<T>();
    const Mat3<T> x = motion.position.template rightCols<3>() * directions,
                  x1 = motion.velocity.template rightCols<3>() * directions,
                  x2 = motion.acceleration.template rightCols<3>() * directions;
    int k = b.first_equation;
    for (const Rigidity& e : b.rigidity) {
      dot_product<T>(x.col(e.i), x1.col(e.i), x2.col(e.i), x.col(e.j), x1.col(e.j), x2.col(e.j), phi[k],
                     phi1[k], phi2[k]);
      phi[k++] -= b.directions.col(e.i).dot(b.directions.col(e.j));
    }
  }
  for (const Joint& j : l.joints) {
    const FrameMotion<T>&A = w.frames[j.frame_a], &B = w.frames[j.frame_b];
    const Vec3<T> d = B.position - A.position, d1 = B.velocity - A.velocity,
                  d2 = B.acceleration - A.acceleration;
    int k = j.first_equation;
    for (const JointEquation& e : j.equations) {
      const auto xa = A.axes.col(e.axis_a), xa1 = A.axes_velocity.col(e.axis_a),
                 xa2 = A.axes_acceleration.col(e.axis_a);
      switch (e.kind) {
        case JointEquation::Kind::coincidence:
          for (int c = 0; c < 3; ++c) {
            phi[k + c] = d[c];
            phi1[k + c] = d1[c];
            phi2[k + c] = d2[c];
          }
          break;
        case JointEquation::Kind::distance:
          dot_product<T>(xa, xa1, xa2, d, d1, d2, phi[k], phi1[k], phi2[k]);
          break;
        case JointEquation::Kind::angle:
          dot_product<T>(xa, xa1, xa2, B.axes.col(e.axis_b), B.axes_velocity.col(e.axis_b),
                         B.axes_acceleration.col(e.axis_b), phi[k], phi1[k], phi2[k]);
          break;
      }
      k += e.count();
    }
  }
  for (std::size_t i = 0; i < m.drives.size(); ++i) {
    const DriveData& d = m.drives[i];
    const JointCoordinate& c = l.joint_coordinates[d.body];
    const BodyData& body = m.bodies[d.body];
    JointRates<T> rates;
    joint_rates<T>(body.joint, body.joint_velocities, w.frames[c.frame_a], w.frames[c.frame_b], q + c.q,
                   rates);
    const int k = l.first_drive + static_cast<int>(i);
    phi[k] = q[c.q + d.local] - w.signals.value[d.slot];
    phi1[k] = rates.v[d.local] - w.signals.rate[d.slot];
    phi2[k] = rates.a[d.local] - w.signals.second[d.slot];
  }
  constrain_bodies<T>(m, l, w, q);
}

/// Adds μ Φq of one equation of rigidity to the forces on the body's base vectors.
template <class T>
void act_by_rigidity(const Body& b, const Rigidity& e, const Base<T>& position, const T& mu, Base<T>& out) {
  const auto A = position.template rightCols<3>();
  const Vec3<T> di = A * b.directions.col(e.i).template cast<T>(),
                dj = A * b.directions.col(e.j).template cast<T>();
  for (int s = 0; s < 3; ++s)
    out.col(1 + s) += mu * (T(b.directions(s, e.i)) * dj + T(b.directions(s, e.j)) * di);
}

/// The same for equation `e` of a joint; `component`: of a coincidence.
template <class T>
void act_by_joint(const Compiled& m, const Workspace<T>& w, const Joint& j, const JointEquation& e,
                  int component, const T& mu, const Covector<T>& on_a, const Covector<T>& on_b) {
  const FrameMotion<T>&A = w.frames[j.frame_a], &B = w.frames[j.frame_b];
  const FrameData &a = m.frames[j.frame_a], &b = m.frames[j.frame_b];
  switch (e.kind) {
    case JointEquation::Kind::coincidence: {
      const Vec3<T> g = mu * Vec3<T>::Unit(component);
      act_on_point<T>(b, B, g, on_b);
      act_on_point<T>(a, A, -g, on_a);
      return;
    }
    case JointEquation::Kind::distance: {
      const Vec3<T> g = mu * A.axes.col(e.axis_a);
      act_on_point<T>(b, B, g, on_b);
      act_on_point<T>(a, A, -g, on_a);
      act_on_axis<T>(a, A, e.axis_a, mu * (B.position - A.position), on_a);
      return;
    }
    case JointEquation::Kind::angle:
      act_on_axis<T>(b, B, e.axis_b, mu * A.axes.col(e.axis_a), on_b);
      act_on_axis<T>(a, A, e.axis_a, mu * B.axes.col(e.axis_b), on_a);
  }
}

/// Adds Φqᵀ μ to the forces on the bodies.
template <class T>
void apply_multipliers(const Compiled& m, const Layout& l, Workspace<T>& w, const T* q, const T* mu) {
  for (std::size_t i = 0; i < l.bodies.size(); ++i) {
    int k = l.bodies[i].first_equation;
    for (const Rigidity& e : l.bodies[i].rigidity)
      act_by_rigidity<T>(l.bodies[i], e, w.bodies[i].position, mu[k++], w.forces[i]);
  }
  for (const Joint& j : l.joints) {
    const Covector<T> on_a = collector(m, l, w, j.link.body_a), on_b = collector(m, l, w, j.link.body_b);
    int k = j.first_equation;
    for (const JointEquation& e : j.equations)
      for (int c = 0; c < e.count(); ++c) act_by_joint<T>(m, w, j, e, c, mu[k++], on_a, on_b);
  }
  for (std::size_t i = 0; i < m.drives.size(); ++i) {
    const DriveData& d = m.drives[i];
    const JointCoordinate& c = l.joint_coordinates[d.body];
    const Link& link = l.drives[i];
    act_on_coordinate<T>(m, c, w.frames[c.frame_a], w.frames[c.frame_b], q + c.q, d.local,
                         mu[l.first_drive + i], collector(m, l, w, link.body_a),
                         collector(m, l, w, link.body_b));
  }
  for (std::size_t i = 0; i < m.constraints.size(); ++i) {
    const ConstraintData& c = m.constraints[i];
    const ConstraintLink& link = l.constraints[i];
    const int terms = static_cast<int>(c.terms.size());
    for (int t = 0; t < terms; ++t) {
      Vec3<T> force = Vec3<T>::Zero(), moment = Vec3<T>::Zero();
      for (int r = 0; r < c.count; ++r) {
        force += mu[link.first_equation + r] * w.constraint_linear[c.covectors + r * terms + t];
        moment += mu[link.first_equation + r] * w.constraint_angular[c.covectors + r * terms + t];
      }
      act_by_term<T>(m, w, c.terms[t], force, moment, collector(m, l, w, link.terms[t].body_a),
                     collector(m, l, w, link.terms[t].body_b));
    }
  }
}

}  // namespace mimbre::natural
