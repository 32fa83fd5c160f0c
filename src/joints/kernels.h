#pragma once
#include "joints/cylindrical.h"
#include "joints/fixed.h"
#include "joints/floating.h"
#include "joints/planar.h"
#include "joints/prismatic.h"
#include "joints/revolute.h"
#include "joints/spherical.h"
#include "joints/universal.h"
#include "mimbre/joint_type.h"

/// The motion of a joint by its type. Apart from the table, so that a unit that only asks how many
/// coordinates a joint has does not compile its kernels.
namespace mimbre {

/// Motion of b relative to a at positions q with velocities v.
template <class T>
void joint_motion(spec::JointType type, const T* q, const T* v, JointMotion<T>& m) {
  m.reset();
  switch (type) {
    case spec::JointType::fixed:
    case spec::JointType::bracket:
      return fixed_motion(q, v, m);
    case spec::JointType::revolute:
      return revolute_motion(q, v, m);
    case spec::JointType::prismatic:
      return prismatic_motion(q, v, m);
    case spec::JointType::cylindrical:
      return cylindrical_motion(q, v, m);
    case spec::JointType::universal:
      return universal_motion(q, v, m);
    case spec::JointType::spherical:
      return spherical_motion(q, v, m);
    case spec::JointType::planar:
      return planar_motion(q, v, m);
    case spec::JointType::floating:
      return floating_motion(q, v, m);
  }
}

/// Inverse of joint_motion: positions q that give this rotation and displacement of b relative to a (as
/// nearly as the joint can); angles within ±π, quaternions of either sign.
template <class T>
void joint_coordinates(spec::JointType type, const Mat3<T>& rotation, const Vec3<T>& displacement, T* q) {
  switch (type) {
    case spec::JointType::revolute:
      return revolute_coordinates(rotation, displacement, q);
    case spec::JointType::prismatic:
      return prismatic_coordinates(rotation, displacement, q);
    case spec::JointType::cylindrical:
      return cylindrical_coordinates(rotation, displacement, q);
    case spec::JointType::universal:
      return universal_coordinates(rotation, displacement, q);
    case spec::JointType::planar:
      return planar_coordinates(rotation, displacement, q);
    case spec::JointType::spherical:
      return spherical_coordinates(rotation, displacement, q);
    case spec::JointType::floating:
      return floating_coordinates(rotation, displacement, q);
    case spec::JointType::fixed:
    case spec::JointType::bracket:
      return;
  }
}

}  // namespace mimbre
