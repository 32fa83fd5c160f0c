#pragma once
#include "dynamics/relative/workspace.h"
#include "dynamics/rigid_shift.h"
#include "dynamics/state.h"

namespace mimbre::relative {

/// Coordinates of a mechanism, with the accelerations that the integrator remembers.
template <class T>
struct MovedState {
  T *q, *v, *a, *algorithmic;
};

/// Changes the coordinates of a floating joint between the ground and body `root` so that all that the body
/// carries moves by the shift; the accelerations that the integrator remembers change as the true ones do.
/// After kinematics at the state; c̈ of the shift is minus gravity, as in the workspace. Instantiated for
/// doubles; other scalars include shift_impl.h.
template <class T>
void shift_root(const Compiled& m, Workspace<T>& w, int root, const RigidShiftOf<T>& shift,
                const MovedState<T>& s);

/// Adds `times` the velocities of a rigid motion, of the point at the common point and angular, to those of a
/// floating joint between the ground and body `root`. After kinematics at the state's position.
void add_rigid_motion(const Compiled& m, Workspace<double>& w, int root, double times, const Vec3d& velocity,
                      const Vec3d& spin, State& s);

}  // namespace mimbre::relative
