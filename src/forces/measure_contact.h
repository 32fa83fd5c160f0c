#pragma once
#include "forces/contact_states.h"
#include "forces/element.h"
#include "forces/motion.h"
#include "forces/surfaces/table.h"

namespace mimbre {

/// Two unit vectors at right angles to the unit vector n, steady but for n near −z (Duff et al., J. Computer
/// Graphics Techniques 6, 2017).
template <class T>
void tangents_of(const Vec3<T>& n, Vec3<T>& first, Vec3<T>& second) {
  const T sign = select(n[2] < T(0), T(-1), T(1)), a = T(-1) / (sign + n[2]), b = n[0] * n[1] * a;
  first = {T(1) + sign * n[0] * n[0] * a, sign * b, -sign * n[0]};
  second = {b, sign + n[1] * n[1] * a, -n[1]};
}

/// Gap between a sphere about b's origin and a surface in a's axes, and, where they touch, the slip of the
/// sphere on it since the start of the step along its two tangents, and b's turn in a since then about the
/// tangents and the normal. Where the sphere did not touch before, the slip is that of its speed. With n, t
/// the normal and a tangent, ρ the contact's distance from the centre: ẋ = n · u and t · u − ρ (n × t) · w.
template <class T>
void measure_contact(const SurfaceData& surface, double radius, const Motion<T>& a, const Motion<T>& b,
                     const T* before, double step, ElementState<T>& s) {
  using namespace contact_states;
  Vec3<T> d, u, w;
  relative_velocity(a, b, d, u, w);
  const Mat3<T> At = a.rotation.transpose();
  const Vec3<T> centre = At * d;
  const Touch<T> touch = surfaces::touch(surface, centre);
  const T distance = touch.distance - T(radius);
  s.x[0] = distance;
  const Vec3<T> n = a.rotation * touch.normal;
  s.v[0] = n.dot(u);
  s.set_linear(0, n);
  for (int k = 0; k < 3 * s.count; ++k) s.angular[k] = T(0);
  s.states[gap] = distance;
  s.states[speed] = s.v[0];
  for (int k = 0; k < 3; ++k) s.states[place + k] = centre[k];
  const auto touches = distance < T(0);
  if (!any(touches)) {
    for (int k = 1; k < s.count; ++k) s.x[k] = s.v[k] = T(0);
    for (int k = 3; k < 3 * s.count; ++k) s.linear[k] = T(0);
    for (int k = 0; k < 6; ++k) s.surroundings[k] = T(0);
    for (int k = 0; k < 4; ++k) s.states[turn + k] = T(0);
    return;
  }
  const auto kept = [&](const T& x) { return select(touches, x, T(0)); };
  const auto kept3 = [&](const Vec3<T>& x) { return Vec3<T>(kept(x[0]), kept(x[1]), kept(x[2])); };
  const Quat<T> turned = quaternion_of(Mat3<T>(At * b.rotation));
  for (int k = 0; k < 4; ++k) s.states[turn + k] = kept(turned[k]);
  Quat<T> back;
  back << before[turn], -before[turn + 1], -before[turn + 2], -before[turn + 3];
  const auto knows = before[gap] < T(0);
  const Vec3<T> since = quaternion_log(quaternion_product(turned, back)),
                went = centre - Vec3<T>(before[place], before[place + 1], before[place + 2]);
  Vec3<T> axes[3] = {touch.normal, touch.normal, touch.normal};
  tangents_of(touch.normal, axes[0], axes[1]);
  const Vec3<T> arm = T(-0.5) * (T(radius) + touch.distance) * touch.normal;
  const auto component = [&](int k, const Vec3<T>& linear, const Vec3<T>& angular) {
    const Vec3<T> along = a.rotation * linear, about = a.rotation * angular;
    s.set_linear(k, kept3(along));
    s.set_angular(k, kept3(about));
    const T rate = along.dot(u) + about.dot(w);
    s.v[k] = kept(rate);
    s.x[k] = kept(select(knows, T(linear.dot(went) + angular.dot(since)), T(T(step) * rate)));
  };
  for (int k = 0; k < 2; ++k) {
    component(1 + k, axes[k], arm.cross(axes[k]));
    for (int c = 0; c < 3; ++c) s.surroundings[3 * k + c] = kept(axes[k][c]);
  }
  for (int k = 0; k + 3 < s.count; ++k) component(3 + k, Vec3<T>::Zero(), axes[k]);
}

}  // namespace mimbre
