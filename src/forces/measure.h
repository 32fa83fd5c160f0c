#pragma once
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "forces/element.h"
#include "forces/element_ends.h"
#include "forces/measure_contact.h"
#include "forces/measure_turning.h"
#include "forces/measure_wheel.h"
#include "forces/motion.h"
#include "joints/joint_kind.h"
#include "joints/table.h"
#include "math/elementary.h"
#include "math/function_values.h"
#include "spec/force_law.h"

/// What elements measure between two frames: x, its rate v, and the directions in which a force against it
/// acts. All vectors are in global axes.
namespace mimbre {

/// Where the ends of a distance meet, its direction is that in which they part; without any, there is none.
template <class T>
void measure_distance(const Motion<T>& a, const Motion<T>& b, ElementState<T>& s) {
  const Vec3<T> r = b.position - a.position, u = b.velocity - a.velocity;
  const T length = r.norm();
  const Vec3<T> direction = choose(
      length > T(0), [&] { return Vec3<T>(r / length); },
      [&] {
        const T speed = u.norm();
        return choose(
            speed > T(0), [&] { return Vec3<T>(u / speed); }, [] { return Vec3<T>(Vec3<T>::Zero()); });
      });
  s.x[0] = length;
  s.v[0] = direction.dot(u);
  s.set_linear(0, direction);
}

/// The second derivative of a joint's coordinate; q: all of its positions.
template <class T>
T coordinate_acceleration(const ElementData& e, const Motion<T>& a, const Motion<T>& b, const T* q) {
  Vec3<T> d, u, w;
  relative_velocity(a, b, d, u, w);
  const Mat3<T> At = a.rotation.transpose();
  // Of u and w, as seen from frame a.
  const Vec3<T> du = At * Vec3<T>(b.acceleration - a.acceleration - a.alpha.cross(d) -
                                  a.omega.cross(Vec3<T>(a.omega.cross(d) + T(2) * u))),
                dw = At * Vec3<T>(b.alpha - a.alpha - a.omega.cross(w));
  T rates[6] = {T(0), T(0), T(0), T(0), T(0), T(0)};
  JointMotion<T> motion;
  joint_motion<T>(e.joint, q, rates, motion);
  for (int k = 0; k < joint_info(e.joint).velocities; ++k)
    rates[k] = motion.linear.col(k).dot(At * u) + motion.angular.col(k).dot(At * w);
  joint_motion<T>(e.joint, q, rates, motion);
  return motion.linear.col(e.local).dot(du) + motion.angular.col(e.local).dot(dw - motion.angular_bias);
}

/// A coordinate of a joint that is cut, whose angles count turns from `last` on.
template <class T>
void measure_coordinate(const ElementData& e, const Motion<T>& a, const Motion<T>& b, const T& last,
                        ElementState<T>& s) {
  Vec3<T> d, u, w;
  relative_velocity(a, b, d, u, w);
  T q[7];
  const Mat3<T> At = a.rotation.transpose();
  joint_coordinates<T>(e.joint, At * b.rotation, At * d, q);
  const T rest[6] = {T(0), T(0), T(0), T(0), T(0), T(0)};
  JointMotion<T> motion;
  joint_motion<T>(e.joint, q, rest, motion);
  const Vec3<T> linear = a.rotation * motion.linear.col(e.local),
                angular = a.rotation * motion.angular.col(e.local);
  // The columns of every joint type are orthonormal.
  s.v[0] = linear.dot(u) + angular.dot(w);
  s.x[0] = q[e.local];
  if (e.inertia >= 0) *s.acceleration = coordinate_acceleration(e, a, b, q);
  if (is_angle(e.joint, e.local)) {
    using std::round;
    constexpr double turn = 2 * std::numbers::pi;
    s.x[0] += T(turn) * T(round((last - s.x[0]) / turn));
  }
  s.set_linear(0, linear);
  s.set_angular(0, angular);
}

/// Along a direction of a, or about it. An angle about it is that of b's turning since the assembled
/// position, as far as that is about the direction. A torque that is given acts about the direction itself,
/// and its rate is that of turning about that; a torque by the angle acts about the line halfway between the
/// direction in a and in b, by which the angle grows as b tilts: so a torque's work is that of an energy.
template <class T>
void measure_axis(const ElementData& e, const Motion<T>& a, const Motion<T>& b, const T& last,
                  ElementState<T>& s) {
  Vec3<T> d, u, w;
  relative_velocity(a, b, d, u, w);
  const Vec3<T> direction = a.rotation * e.direction.template cast<T>();
  if (!e.about) {
    s.x[0] = direction.dot(d) - T(e.reference);
    s.v[0] = direction.dot(u);
    s.set_linear(0, direction);
    s.set_angular(0, Vec3<T>::Zero());
    return;
  }
  using mimbre::atan2, std::round;
  const Mat3<T> turned = a.rotation.transpose() * b.rotation * e.rotation.transpose().template cast<T>();
  const Vec3<T> vee(turned(2, 1) - turned(1, 2), turned(0, 2) - turned(2, 0), turned(1, 0) - turned(0, 1));
  constexpr double turn = 2 * std::numbers::pi;
  const Vec3<T> n = e.direction.template cast<T>(), tilted = turned * n;
  // Twist of the quaternion about n: of rotations about n alone it is the angle.
  const T sine = n.dot(vee), cosine = turned.trace() - n.dot(tilted);
  s.x[0] = atan2(sine, cosine);
  s.x[0] += T(turn) * T(round((last - s.x[0]) / turn));
  const T twice = T(1) + n.dot(tilted);  // 2 cos² of half the tilt
  const Vec3<T> about =
      law_info(e.law).given
          ? direction
          : Vec3<T>(a.rotation * Vec3<T>((n + tilted) / select(twice > T(turning::least_square), twice,
                                                               T(turning::least_square))));
  s.v[0] = about.dot(w);
  s.set_linear(0, Vec3<T>::Zero());
  s.set_angular(0, about);
}

/// Displacement of b's origin in a's axes from where it was assembled, and b's turning since then
/// (measure_turning.h).
template <class T>
void measure_relative(const ElementData& e, const Motion<T>& a, const Motion<T>& b, const T* states,
                      ElementState<T>& s) {
  Vec3<T> d, u, w;
  relative_velocity(a, b, d, u, w);
  const Mat3<T> At = a.rotation.transpose();
  const Vec3<T> x = At * d - e.position.template cast<T>();
  const Mat3<T> rotation = At * b.rotation * e.rotation.transpose().template cast<T>();
  T unknown[2 * turning::count];
  std::fill(std::begin(unknown), std::end(unknown), T(0));
  const T* before = e.turns < 0 ? unknown : states + e.turns;
  T* next = e.turns < 0 ? unknown + turning::count : s.states + e.turns;
  const turning::Turned<T> turned = turning::measure<T>(rotation, before, next);
  const Vec3<T> ua = At * u, rate = turned.by_spin * (At * w);
  const Mat3<T> directions = a.rotation * turned.by_spin.transpose();  // ẋₖ = directions.col(k) · w
  for (int k = 0; k < 3; ++k) {
    s.x[k] = x[k];
    s.v[k] = ua[k];
    s.x[3 + k] = turned.x[k];
    s.v[3 + k] = rate[k];
    s.set_linear(k, a.rotation.col(k));
    s.set_angular(k, Vec3<T>::Zero());
    s.set_linear(3 + k, Vec3<T>::Zero());
    s.set_angular(3 + k, directions.col(k));
  }
}

/// Height above a road; `place`: of b's origin, global.
template <class T>
void measure_height(const RoadData& road, const Vec3<T>& place, const Motion<T>& b, const T* signals,
                    ElementState<T>& s) {
  using Over = spec::Road::Over;
  *s.surroundings = road.over == Over::distance ? value_at(road.height, place[0])
                    : road.over == Over::grid   ? roads::place(road, 0, place[0], place[1]).z
                                                : signals[road.slot];
  s.x[0] = place[2] - *s.surroundings;
  s.v[0] = b.velocity[2];  // as over a road that stands still
  s.set_linear(0, Vec3<T>::UnitZ());
}

/// Velocity of b's origin in b's axes, as what is measured and as its rate.
template <class T>
void measure_velocity(const Motion<T>& b, ElementState<T>& s) {
  for (int k = 0; k < 3; ++k) {
    const Vec3<T> axis = b.rotation.col(k);
    s.x[k] = s.v[k] = axis.dot(b.velocity);
    s.set_linear(k, axis);
  }
}

/// Σ factor · what a leg measures; after these. `storage`: of all elements' states.
template <class T>
void measure_sums(const Compiled& m, T* storage) {
  for (const int k : m.sums) {
    ElementState<T> s = element_state(m.elements[k], storage);
    s.x[0] = s.v[0] = T(0);
    for (const Leg& leg : m.elements[k].legs) {
      const ElementState<T> part = element_state(m.elements[leg.element], storage);
      s.x[0] += leg.factor * part.x[0];
      s.v[0] += leg.factor * part.v[0];
    }
  }
}

/// What an element that is no coordinate in the tree, and no sum, measures, and the way it acts. `step`: as
/// of LawContext.
template <class T>
void measure(const Compiled& m, const ElementData& e, const Motion<T>* a, const Motion<T>& b,
             const Vec3<T>& origin, const T* signals, const T* states, ElementState<T>& s, double step = 0) {
  switch (e.measure) {
    case Measure::distance:
      return measure_distance(*a, b, s);
    case Measure::height:
      return measure_height(m.roads[e.road], Vec3<T>(b.position + origin), b, signals, s);
    case Measure::coordinate:
      measure_coordinate(e, *a, b, e.turns < 0 ? T(0) : states[e.turns], s);
      break;
    case Measure::axis:
      measure_axis(e, *a, b, e.turns < 0 ? T(0) : states[e.turns], s);
      break;
    case Measure::relative:
      return measure_relative(e, *a, b, states, s);
    case Measure::velocity:
      return measure_velocity(b, s);
    case Measure::sum:  // measure_sums()
      return;
    case Measure::wheel:
      return measure_wheel(m.roads[e.road], e, origin, b, signals, s);
    case Measure::contact: {
      const ElementEnds ends = ends_of(m, e, states);
      measure_contact(m.surfaces[ends.surface], ends.radius, *a, b, states, step, s);
      for (int k = law_states(e); k < e.state_count; ++k) s.states[k] = states[k];
      return;
    }
    case Measure::none: {
      s.x[0] = s.v[0] = T(0);
      const Vec3<T> force = e.direction.template cast<T>(), moment = e.second.template cast<T>();
      s.set_linear(0, e.follower ? Vec3<T>(b.rotation * force) : force);
      s.set_angular(0, e.follower ? Vec3<T>(b.rotation * moment) : moment);
      return;
    }
  }
  if (e.turns >= 0) s.states[e.turns] = s.x[0];
}

/// Whether its force has a moment about b's origin, or about a's beyond that of its arm.
constexpr bool has_moment(Measure m) {
  return m != Measure::distance && m != Measure::height && m != Measure::velocity;
}
/// Whether it depends on the axes and angular velocities of its frames.
constexpr bool needs_axes(Measure m) { return has_moment(m) || m == Measure::velocity; }

}  // namespace mimbre
