#pragma once
#include <vector>

#include "linalg/block_sparse.h"
#include "math/rotation.h"
#include "model/compiled.h"

/// What both formulations say of motions and forces. All vectors are in global axes.
namespace mimbre {

/// Pose and motion of a body frame or a frame on a body.
template <class T>
struct Motion {
  Mat3<T> rotation;      ///< its axes to global axes
  Vec3<T> position;      ///< of its origin, relative to the common point
  Vec3<T> velocity;      ///< of its origin
  Vec3<T> omega;         ///< angular velocity
  Vec3<T> acceleration;  ///< of its origin, minus gravity (the ground accelerates with −g)
  Vec3<T> alpha;         ///< angular acceleration
};

/// Force on a frame's origin and moment, acting on the body.
template <class T>
struct Wrench {
  Vec3<T> force;
  Vec3<T> moment;
};

template <class T>
using AlignedVector = std::vector<T, linalg::CacheAligned<T>>;

/// State of a spring-damper.
template <class T>
struct SpringState {
  T length, rate, tension;
  T stiffness, damping;  ///< ∂tension/∂length, ∂tension/∂rate
  Vec3<T> direction;     ///< from end a to end b
};

/// State of a tyre.
template <class T>
struct TyreState {
  T force, penetration, road;
  T stiffness;  ///< 0 without contact
};

}  // namespace mimbre
