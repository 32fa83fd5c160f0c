#pragma once
#include <array>
#include <cmath>

#include "math/choice.h"
#include "math/rotation.h"

namespace mimbre {

/// Where a point is against a surface, in the surface's axes: its distance, negative inside, and the outward
/// unit normal, which is the distance's gradient.
template <class T>
struct Touch {
  T distance;
  Vec3<T> normal;
};
template <class Condition, class T>
Touch<T> select(const Condition& condition, const Touch<T>& x, const Touch<T>& y) {
  Touch<T> chosen{select(condition, x.distance, y.distance), {}};
  for (int k = 0; k < 3; ++k) chosen.normal[k] = select(condition, x.normal[k], y.normal[k]);
  return chosen;
}

}  // namespace mimbre

namespace mimbre::surfaces {

/// Of a point at `from` a ball's centre. At the centre itself the normal is z.
template <class T>
Touch<T> ball(const Vec3<T>& from, const T& radius) {
  using std::sqrt;
  const T square = from.squaredNorm();
  const auto away = square > T(0);
  return choose(
      away,
      [&] {
        const T length = sqrt(select(away, square, T(1)));
        return Touch<T>{length - radius, from / length};
      },
      [&] {
        return Touch<T>{-radius, Vec3<T>::UnitZ()};
      });
}

/// The larger of two or three distances along directions at right angles to each other separates inside from
/// outside; outside of several, their hypotenuse is the distance. `out(k)`: distance beyond face k,
/// `normal(k)`.
template <int count, class T>
Touch<T> convex(const std::array<T, count>& out, const std::array<Vec3<T>, count>& normals) {
  using std::sqrt;
  T square(0), deepest = out[0];
  Vec3<T> beyond = Vec3<T>::Zero(), inner = normals[0];
  for (int k = 0; k < count; ++k) {
    const auto outside = out[k] > T(0);
    const T part = select(outside, out[k], T(0));
    square += part * part;
    beyond += part * normals[k];
    const auto further = out[k] > deepest;
    deepest = select(further, out[k], deepest);
    for (int c = 0; c < 3; ++c) inner[c] = select(further, normals[k][c], inner[c]);
  }
  const auto outside = square > T(0);
  return choose(
      outside,
      [&] {
        const T length = sqrt(select(outside, square, T(1)));
        return Touch<T>{length, beyond / length};
      },
      [&] {
        return Touch<T>{deepest, inner};
      });
}

}  // namespace mimbre::surfaces
