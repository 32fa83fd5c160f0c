#pragma once
#include "forces/motion.h"
#include "joints/rates.h"

namespace mimbre {

template <class T>
RelativeMotion<T> relative_motion(const Motion<T>& a, const Motion<T>& b) {
  const Mat3<T> At = a.rotation.transpose();
  const Vec3<T> d = b.position - a.position, w = b.omega - a.omega;
  const Vec3<T> u = b.velocity - a.velocity - a.omega.cross(d);
  return {
      At * b.rotation,
      At * d,
      At * u,
      At * (b.acceleration - a.acceleration - a.alpha.cross(d) - a.omega.cross(a.omega.cross(d) + T(2) * u)),
      At * w,
      At * (b.alpha - a.alpha - a.omega.cross(w))};
}

}  // namespace mimbre
