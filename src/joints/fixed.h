#pragma once
#include "joints/joint_kind.h"
#include "joints/motion.h"

namespace mimbre::joints {

/// No relative motion.
struct Fixed {
  static constexpr JointInfo info{
      .type = spec::JointType::fixed,
      .name = "fixed",
      .elsewhere = "weld rigid",
      .equations = 6,
      .closure = {closure::dx, closure::dy, closure::dz, closure::xy, closure::yz, closure::zx},
      .any_place = true};

  template <class T>
  static void motion(const T*, const T*, JointMotion<T>&) {}
  template <class T>
  static void coordinates(const Mat3<T>&, const Vec3<T>&, T*) {}
};

/// Likewise, between flexible bodies: all six static modes.
struct Bracket : Fixed {
  static constexpr JointInfo info = [] {
    JointInfo of = Fixed::info;
    of.type = spec::JointType::bracket;
    of.name = "bracket";
    of.elsewhere = {};
    of.all_static_modes = true;
    return of;
  }();
};

}  // namespace mimbre::joints
