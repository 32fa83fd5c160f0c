#pragma once
#include <vector>

#include "dynamics/relative/workspace.h"

/// Momentum of bodies that move, as one body has it: of the motion that kinematics last saw.
namespace mimbre::relative {

struct Momentum {
  double mass = 0;
  Vec3d centre = Vec3d::Zero();   ///< of mass, relative to the common point
  Vec3d linear = Vec3d::Zero();   ///< kg m/s
  Vec3d angular = Vec3d::Zero();  ///< about the centre of mass, kg m²/s
  Mat3d inertia = Mat3d::Zero();  ///< about it
  Mat3d spread = Mat3d::Zero();  ///< ∫ x ẋᵀ dm, x from the centre of mass: how the inertia changes, kg m²/s

  Vec3d velocity() const { return linear / mass; }
};

/// Of the bodies listed, after kinematics at q, v. Exact for the displacement field of flexible bodies, with
/// the inertia that the system uses.
Momentum momentum(const Compiled& m, Workspace<double>& w, const std::vector<int>& bodies, const double* q,
                  const double* v);

/// ω of J ω = L. Directions without inertia, of a line of points, get no rotation.
Vec3d mean_spin(const Mat3d& inertia, const Vec3d& angular);

/// By which the energy of rotation ½ Lᵀ J⁻¹ L grows at constant L, W: what centrifugal forces take from it
/// for the motion of the parts relative to each other, negative,
///   −½ ωᵀ J̇ ω = ωᵀ N ω − ω² tr N,   N = ∫ x ẋᵀ dm,   ω = J⁻¹ L.
/// The motion of `p` need not have the angular momentum `angular`: a rigid rotation is added that gives it.
double centrifugal_power(const Momentum& p, const Vec3d& angular);

}  // namespace mimbre::relative
