#pragma once
#include <vector>

#include "compile/compiled.h"
#include "dynamics/motion.h"
#include "dynamics/projection.h"
#include "dynamics/stress_motion.h"
#include "signals/values.h"

/// Scratch of the relative formulation, sized once. Every array names its writer. All vectors are in global
/// axes, all points relative to the common point `origin`, unless a comment states otherwise.
namespace mimbre::relative {

template <class T>
struct Workspace {
  explicit Workspace(const Compiled& model);

  Vec3<T> origin = Vec3<T>::Zero();  ///< the common point, global; by move_origin
  std::vector<Motion<T>> bodies;     ///< by kinematics
  /// By kinematics (dynamic ones), by move_origin (those of the ground), by frame_motion (others).
  std::vector<Motion<T>> frames;
  std::vector<Vec3<T>> joint_angular;  ///< velocities × 1: column of a joint coordinate, by kinematics
  std::vector<Vec3<T>> joint_linear;   ///< likewise: velocity of the point of the body at the common point
  std::vector<Wrench<T>>
      wrenches;  ///< on dynamic frames: by forces, constraints, then children in the residual

  std::vector<Wrench<T>>
      transmitted;  ///< through each body's own joint, on the body, about the common point; by residual

  std::vector<T> phi, phi_dot, phi_ddot;  ///< equations × 1, by constraints
  std::vector<Vec3<T>> covector_linear;   ///< of loop equations about the common point, by constraints
  std::vector<Vec3<T>> covector_angular;

  std::vector<Vec3<T>> constraint_linear;  ///< of constraints' terms about the common point, by constraints
  std::vector<Vec3<T>> constraint_angular;
  std::vector<T> constraint_states;  ///< that they remember at the end of the step, by constraints
  double rate_time = 0;              ///< System::set_rate_time

  AlignedVector<T> elements;  ///< ElementState of each, by forces
  SignalValues<T> signals;    ///< by kinematics (what time decides) and forces (what motion decides)

  AlignedVector<T>
      subspaces;  ///< Compiled::subspaces, six rows each (linear 3, angular 3), by motion_subspaces()
  AlignedVector<T> jacobian;  ///< rows of loops, constraints and elements along their paths, by jacobian()

  AlignedVector<T> weighted;  ///< weighted Jacobian rows; by add_squares

  /// Composite inertia of a body and all after it, about the common point; by mass.
  struct Composite {
    T mass;
    Vec3<T> moment;  ///< ∫ r dm
    Mat3<T> second;  ///< ∫ r rᵀ dm
  };
  std::vector<Composite> composites;
  AlignedVector<T>
      subspace_forces;  ///< six rows of the widest body: composite inertia times its motion subspace
  AlignedVector<T> elastic_forces;  ///< coupling of elastic coordinates with their subtree, six rows per body
  std::vector<int> elastic_offset;  ///< by body into elastic_forces
  AlignedVector<T> integrals;       ///< per flexible body: S'^i rows (9 × stride), by residual
  std::vector<int> integral_offset;
  AlignedVector<T> folded;             ///< a matrix of extended amplitudes folded, by mass and assembly
  AlignedVector<T> geometric_scratch;  ///< of geometric stiffness's tangent, by assembly
  AlignedVector<T> scratch;
  mutable std::vector<T> output;        ///< amplitudes and their rates, by output_motion
  std::vector<StressMotion<T>> stress;  ///< of bodies with geometric stiffness, by residual

  /// By flexible body's data, for inertia by projection; empty: shape integrals. By the system.
  std::vector<projection::Constants> projections;
  projection::Work projection;
};

/// Makes `to` (global) the common point, and places the frames of the ground, which do not move in a step.
template <class T>
void move_origin(const Compiled& m, Workspace<T>& w, const Vec3<T>& to) {
  w.origin = to;
  const Vec3<T> no_gravity = -m.gravity.template cast<T>();
  for (int k = m.first_ground_frame; k < m.last_ground_frame; ++k) {
    Motion<T>& f = w.frames[k];
    f.rotation = m.frames[k].rotation.template cast<T>();
    f.position = m.frames[k].position.template cast<T>() - to;
    f.velocity.setZero();
    f.omega.setZero();
    f.acceleration = no_gravity;
    f.alpha.setZero();
  }
}

/// What a flexible body's inertia does not change with the motion, by shape integrals or by projection.
struct ConstantInertia {
  double mass;
  const Vec3d& first_moment;  ///< undeformed
  const Rows& S;
  const Rows& modal_mass;
};
template <class T>
ConstantInertia constant_inertia(const Compiled& m, const Workspace<T>& w, const BodyData& b) {
  if (w.projections.empty()) {
    const FlexibleData& f = m.flexible[b.flexible];
    return {b.mass, b.first_moment, f.S, f.mass};
  }
  const projection::Constants& c = w.projections[b.flexible];
  return {c.total_mass, c.first_moment, c.S, c.mass};
}

}  // namespace mimbre::relative
