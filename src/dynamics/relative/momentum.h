#pragma once
#include <vector>

#include "dynamics/relative/workspace.h"

/// Momentum of bodies that move, as one body has it: of the motion that kinematics last saw. Instantiated for
/// doubles; other scalars include momentum_impl.h.
namespace mimbre::relative {

template <class T>
struct MomentumOf {
  T mass = 0;
  Vec3<T> centre = Vec3<T>::Zero();   ///< of mass, relative to the common point
  Vec3<T> linear = Vec3<T>::Zero();   ///< kg m/s
  Vec3<T> angular = Vec3<T>::Zero();  ///< about the centre of mass, kg m²/s
  Mat3<T> inertia = Mat3<T>::Zero();  ///< about it
  Mat3<T> spread =
      Mat3<T>::Zero();  ///< ∫ x ẋᵀ dm, x from the centre of mass: how the inertia changes, kg m²/s

  Vec3<T> velocity() const { return linear / mass; }
};
using Momentum = MomentumOf<double>;

/// Of the bodies listed, after kinematics at q, v. Exact for the displacement field of flexible bodies, with
/// the inertia that the system uses.
template <class T>
MomentumOf<T> momentum(const Compiled& m, Workspace<T>& w, const std::vector<int>& bodies, const T* q,
                       const T* v);

/// ω of J ω = L. Directions without inertia, of a line of points, get no rotation.
template <class T>
Vec3<T> mean_spin(const Mat3<T>& inertia, const Vec3<T>& angular);

/// By which the energy of rotation ½ Lᵀ J⁻¹ L grows at constant L, W: what centrifugal forces take from it
/// for the motion of the parts relative to each other, negative,
///   −½ ωᵀ J̇ ω = ωᵀ N ω − ω² tr N,   N = ∫ x ẋᵀ dm,   ω = J⁻¹ L.
/// The motion of `p` need not have the angular momentum `angular`: a rigid rotation is added that gives it.
template <class T>
T centrifugal_power(const MomentumOf<T>& p, const Vec3<T>& angular);

}  // namespace mimbre::relative
