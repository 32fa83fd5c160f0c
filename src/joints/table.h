#pragma once
#include <array>

#include "joints/cylindrical.h"
#include "joints/fixed.h"
#include "joints/floating.h"
#include "joints/pin_slot.h"
#include "joints/planar.h"
#include "joints/prismatic.h"
#include "joints/revolute.h"
#include "joints/spherical.h"
#include "joints/universal.h"

/// The types of joints. A new one is a file like universal.h, its name in this list and in spec::JointType.
namespace mimbre {
namespace joints {

template <class... Types>
struct TypeList {};
/// In the order of spec::JointType.
using Types = TypeList<Fixed, Bracket, Revolute, Prismatic, Cylindrical, Universal, Spherical, Planar,
                       Floating, PinSlot>;

template <class... Type>
constexpr std::array<const JointInfo*, sizeof...(Type)> infos_of(TypeList<Type...>) {
  return {&Type::info...};
}
inline constexpr auto infos = infos_of(Types());
static_assert([] {
  for (std::size_t k = 0; k < infos.size(); ++k)
    if (infos[k]->type != static_cast<spec::JointType>(k)) return false;
  return true;
}());

template <class T, class... Type>
void motion(TypeList<Type...>, spec::JointType type, const T* q, const T* v, JointMotion<T>& m) {
  (void)((Type::info.type == type && (Type::motion(q, v, m), true)) || ...);
}
template <class T, class... Type>
void coordinates(TypeList<Type...>, spec::JointType type, const Mat3<T>& rotation,
                 const Vec3<T>& displacement, T* q) {
  (void)((Type::info.type == type && (Type::coordinates(rotation, displacement, q), true)) || ...);
}

}  // namespace joints

/// Motion of b relative to a at positions q with velocities v.
template <class T>
void joint_motion(spec::JointType type, const T* q, const T* v, JointMotion<T>& m) {
  m.reset();
  joints::motion<T>(joints::Types(), type, q, v, m);
}

/// Inverse of joint_motion: positions q that give this rotation and displacement of b relative to a (as
/// nearly as the joint can); angles within ±π, quaternions of either sign.
template <class T>
void joint_coordinates(spec::JointType type, const Mat3<T>& rotation, const Vec3<T>& displacement, T* q) {
  joints::coordinates<T>(joints::Types(), type, rotation, displacement, q);
}

}  // namespace mimbre
