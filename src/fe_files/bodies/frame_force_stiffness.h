#pragma once
#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "mimbre/reduced_body.h"

/// Geometric stiffness by the loads that exchange formats have: unit loads of inertia on the body with
/// nothing but its body frame held, and unit forces and torques on it at its frames. ReducedBody has the same
/// by other loads: of inertia with the boundary held, and forces of the static modes that come with
/// amplitudes.
namespace mimbre::fe {

struct FrameForceStiffness {
  /// By the numbers of GeometricStiffness below `boundary`; modes × modes, empty: none.
  std::array<Eigen::MatrixXd, GeometricStiffness::boundary> inertia;
  /// Six of each frame: force along, torque about x, y, z of the body; empty: none.
  std::vector<Eigen::MatrixXd> forces;

  bool any() const;
};

/// Factors of ωx², ωy², ωz², ωxωy, ωyωz, ωxωz in ∫φ · ω × (ω × r) dm, of A = ∫φ rᵀ dm.
Eigen::Matrix<double, 1, 6> centrifugal(const Eigen::Matrix3d& A);

/// The same stiffening as that of the body, where it deforms as it does at rest under its loads: a force of
/// the static modes is then what forces at the frames and of inertia do on their displacements. Throws
/// std::invalid_argument where boundary loads meet a stiffness that is not positive definite.
FrameForceStiffness by_frame_forces(const ReducedBody& body);

/// The way back, into body.geometric (none where there is no stiffening): the forces are those that hold the
/// frames with matrices in `given` at their displacements, the rest of the body being free. Exact for what
/// `by_frame_forces` makes of static modes of the frames. Returns what could not be taken, or nothing.
std::string take_frame_forces(const FrameForceStiffness& given, ReducedBody& body);

}  // namespace mimbre::fe
