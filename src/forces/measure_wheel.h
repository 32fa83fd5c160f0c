#pragma once
#include <array>

#include "forces/element.h"
#include "forces/motion.h"
#include "forces/road_surface.h"
#include "math/elementary.h"

/// A wheel as a circle that rolls on a road. Its axes at the contact are those of ISO 8855: x forwards, along
/// the road, in the plane of the wheel; y to the left; z the normal of the road. The axis of the wheel points
/// to the left, so that a wheel that rolls forwards turns positively about it.
namespace mimbre {

namespace wheel {
/// Components: the gap between the lowest point of the circle and the plane that touches the road there,
/// negative in contact, m; velocities at which the tread slips along x and y, m/s; angular velocities about x
/// (overturning), the wheel's axis (rolling), and z (aligning), rad/s. Of the velocities x = v.
constexpr int gap = 0, forth = 1, across = 2, overturning = 3, rolling = 4, aligning = 5;
/// Surroundings: global z of the road; speed of the centre forwards, m/s; the wheel's angular velocity about
/// its axis, rad/s; camber (inclination to the right positive), rad; factor on friction.
constexpr int road = 0, forward = 1, spin = 2, camber = 3, friction = 4;
/// Among the states. Of the wheel where it was last: the middle of its footprint, global; the direction to
/// that in its own axes; its loaded radius, m, and 0 of one that did not stand. Then the law's: the bend of
/// the carcass along and across, m, by which the wheel is ahead of its footprint.
constexpr int middle = 0, down = 3, stood = 6, bend = 7;

/// A wheel stands that is slower than this share of the speed at which it hardly rolls.
constexpr double still = 1e-8;

/// A wheel that lies flatter on the road than this (sine of the angle between them) loses its grip, and is
/// pushed nearer to its middle.
constexpr double flat = 0.1;

/// How far the lowest point of a circle of radius 1 is below its centre along the road's normal, as a
/// function of that sine: equal to it but near 0, where the lowest point would jump from one side to the
/// other. There its derivative passes smoothly to 0, so that a circle that lies flat is pushed at its middle.
/// With derivative over sine.
template <class T>
struct Reach {
  T down, slope;
};
template <class T>
Reach<T> reach(const T& sine) {
  const T r = sine / T(flat), square = r * r;
  const auto lies = r < T(1);
  return {select(lies, T(T(flat / 8) * (T(3) + square * (T(6) - square))), sine),
          select(lies, T((T(12) - T(4) * square) / T(8 * flat)), T(T(1) / select(lies, T(1), sine)))};
}

/// Radius at which it rolls, m.
template <class T>
T rolling_radius(const ElementData& e, const T& x) {
  const T deep = select(x < T(0), T(-x), T(0)), radius(e.radius);
  return select(T(e.rolling) * deep < radius, T(radius - T(e.rolling) * deep), T(0));
}
/// Speed at which the tread runs through the footprint, m/s, positive forwards.
template <class T>
T rolling_speed(const ElementData& e, const ElementState<T>& s) {
  return s.surroundings[spin] * rolling_radius<T>(e, s.x[gap]);
}

/// Loaded radius, m.
template <class T>
T loaded_radius(const ElementData& e, const T& x) {
  const T deep = select(x < T(0), T(-x), T(0)), radius(e.radius);
  return select(deep < radius, T(radius - deep), T(0));
}
/// Sets among the states whether it stands. `slow`: speed at which it hardly rolls, m/s.
template <class T>
void set_stood(const ElementData& e, const T& slow, ElementState<T>& s) {
  const T ahead = s.surroundings[forward], turning = T(e.radius) * s.v[rolling], most = T(still) * slow;
  const T square = ahead * ahead + s.v[across] * s.v[across] + turning * turning;
  s.states[stood] = select(square < most * most, loaded_radius<T>(e, s.x[gap]), T(0));
}
/// How far the tread has gone along x and y since the wheel stood, m, of what `forth` and `across` are the
/// rates; 0 of a wheel that did not stand. `before`: the states then.
template <class T>
std::array<T, 2> gone(const ElementData& e, const T* before, const ElementState<T>& s) {
  using mimbre::atan2;
  const auto vector = [](const T* p) { return Vec3<T>(p[0], p[1], p[2]); };
  const Vec3<T> t = s.linear_of(forth), side = s.linear_of(across), up = t.cross(s.angular_of(rolling)),
                spoke = vector(s.states + down), was = vector(before + down);
  const T from = before[stood];
  const auto stands = from > T(0);
  // As if the loaded radius had been the same.
  const Vec3<T> way =
      vector(s.states + middle) + (loaded_radius<T>(e, s.x[gap]) - from) * up - vector(before + middle);
  const T turned =
      atan2(e.direction.template cast<T>().dot(spoke.cross(was)), select(stands, T(spoke.dot(was)), T(1)));
  return {select(stands, T(t.dot(way) - rolling_radius<T>(e, s.x[gap]) * turned), T(0)),
          select(stands, side.dot(way), T(0))};
}
}  // namespace wheel

/// Forces act against these rates, so their power is exact: the vertical one at the lowest point of the
/// circle, whose height over a plane is the gap; the one across at the loaded radius; the one along at the
/// radius at which the wheel rolls, so that a force without slip does no work but on what moves.
template <class T>
void measure_wheel(const RoadData& road_data, const ElementData& e, const Vec3<T>& origin, const Motion<T>& b,
                   const T* signals, ElementState<T>& s) {
  using namespace wheel;
  using mimbre::atan2, std::sqrt;
  const Vec3<T> axis = b.rotation * e.direction.template cast<T>();
  const Vec3<T> centre = b.position + origin;
  const T radius(e.radius);
  // From the centre to the lowest point over a plane with that normal.
  const auto lowest_over = [&](const Vec3<T>& n) {
    const Vec3<T> t = axis.cross(n), along = n - n.dot(axis) * axis;  // of the sine's size, and its square's
    const T square = t.squaredNorm();
    const auto stands = square > T(1e-12);
    const T sine = select(stands, sqrt(select(stands, square, T(1))), T(0));
    const Reach<T> by = reach(sine);
    return Vec3<T>(T(-1) * radius * (by.slope * (along - square * n) + by.down * n));
  };
  // Forwards along a plane with that normal; zero where the wheel lies on it.
  const auto forwards = [&](const Vec3<T>& n, T& steep) {
    const Vec3<T> t = axis.cross(n);
    const T square = t.squaredNorm();
    const auto stands = square > T(1e-12);
    const T size = sqrt(select(stands, square, T(1)));
    steep = select(stands, size, T(0));
    return Vec3<T>(t * select(stands, T(T(1) / size), T(0)));
  };
  T steep;
  const roads::Place<T> below = roads::place(road_data, e.footprint, centre[0], centre[1], signals);
  const Vec3<T> place = centre + lowest_over(roads::normal(below));
  const roads::Place<T> at = roads::place(road_data, e.footprint, place[0], place[1], signals);
  const Vec3<T> n = roads::normal(at), t = forwards(n, steep), side = n.cross(t), up = t.cross(axis);
  const Vec3<T> lowest = lowest_over(n);
  s.x[gap] = n.dot(Vec3<T>(centre + lowest)) - n[0] * place[0] - n[1] * place[1] - n[2] * at.z;
  const T loaded = loaded_radius<T>(e, s.x[gap]), rolls = rolling_radius<T>(e, s.x[gap]);
  const auto component = [&](int k, const Vec3<T>& linear, const Vec3<T>& angular) {
    s.set_linear(k, linear);
    s.set_angular(k, angular);
    s.v[k] = linear.dot(b.velocity) + angular.dot(b.omega);
    if (k != gap) s.x[k] = s.v[k];
  };
  const Vec3<T> none = Vec3<T>::Zero();
  component(gap, n, lowest.cross(n));
  component(forth, t, Vec3<T>(T(-1) * rolls * axis));
  component(across, side, Vec3<T>(T(-1) * loaded * up.cross(side)));
  component(overturning, none, t);
  component(rolling, none, axis);
  component(aligning, none, n);
  s.surroundings[road] = at.z;
  s.surroundings[forward] = t.dot(b.velocity);
  s.surroundings[spin] = s.v[rolling];
  s.surroundings[camber] = atan2(axis.dot(n), steep);
  const T grip = steep / T(flat);
  s.surroundings[friction] = at.friction * select(grip < T(1), grip, T(1));

  const Vec3<T> footprint = centre - loaded * up, spoke = T(-1) * (b.rotation.transpose() * up);
  for (int k = 0; k < 3; ++k) {
    s.states[middle + k] = footprint[k];
    s.states[down + k] = spoke[k];
  }
}

}  // namespace mimbre
