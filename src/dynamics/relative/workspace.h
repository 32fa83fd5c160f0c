#pragma once
#include <vector>

#include "dynamics/projection.h"
#include "dynamics/stress_motion.h"
#include "linalg/block_sparse.h"
#include "math/rotation.h"
#include "model/compiled.h"

/// Scratch of the relative formulation, sized once. Every array says who writes it. All vectors are in global
/// axes, all points relative to the common point `origin`, unless a comment says otherwise.
namespace mimbre::relative {

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

template <class T>
struct Workspace {
  explicit Workspace(const Compiled& model);

  Vec3d origin = Vec3d::Zero();        ///< the common point, global; by set_origin
  std::vector<Motion<T>> bodies;       ///< by kinematics
  std::vector<Motion<T>> frames;       ///< by kinematics (dynamic ones), by frame_motion (others)
  std::vector<Vec3<T>> joint_angular;  ///< velocities × 1: column of a joint coordinate, by kinematics
  std::vector<Vec3<T>> joint_linear;   ///< likewise: velocity of the point of the body at the common point
  std::vector<Wrench<T>>
      wrenches;  ///< on dynamic frames: by forces, constraints, then children in the residual

  std::vector<Wrench<T>>
      transmitted;  ///< through each body's own joint, on the body, about the common point; by residual

  std::vector<T> phi, phi_dot, phi_ddot;  ///< equations × 1, by constraints
  std::vector<Vec3<T>> covector_linear;   ///< of loop equations about the common point, by constraints
  std::vector<Vec3<T>> covector_angular;

  struct SpringState {
    T length, rate, tension;
    T stiffness, damping;  ///< ∂tension/∂length, ∂tension/∂rate
    Vec3<T> direction;     ///< from end a to end b
  };
  std::vector<SpringState> springs;  ///< by forces
  struct TyreState {
    T force, penetration, road;
    T stiffness;  ///< 0 without contact
  };
  std::vector<TyreState> tyres;                                                     ///< by forces
  std::vector<T> joint_spring_stiffness, joint_spring_damping, joint_spring_force;  ///< by forces

  AlignedVector<T> columns;   ///< Compiled::column_sets, six rows each (linear 3, angular 3), by columns()
  AlignedVector<T> jacobian;  ///< rows of loops, springs, tyres along their paths, by jacobian()

  AlignedVector<T> weighted;  ///< weighted Jacobian rows; by add_squares

  /// Composite inertia of a body and all after it, about the common point; by mass.
  struct Composite {
    T mass;
    Vec3<T> moment;  ///< ∫ r dm
    Mat3<T> second;  ///< ∫ r rᵀ dm
  };
  std::vector<Composite> composites;
  AlignedVector<T> forces_of_columns;  ///< six rows of the widest body: composite inertia times its columns
  AlignedVector<T> elastic_forces;  ///< coupling of elastic coordinates with their subtree, six rows per body
  std::vector<int> elastic_offset;  ///< by body into elastic_forces
  AlignedVector<T> integrals;       ///< per flexible body: S'^i rows (9 × stride), by kinematics
  std::vector<int> integral_offset;
  AlignedVector<T> folded;  ///< a matrix of extended amplitudes folded, by mass and assembly
  AlignedVector<T> scratch;
  std::vector<StressMotion<T>> stress;  ///< of bodies with geometric stiffness, by residual

  /// By flexible body's data, for inertia by projection; empty: shape integrals. By the system.
  std::vector<projection::Constants> projections;
  projection::Work projection;
};

}  // namespace mimbre::relative
