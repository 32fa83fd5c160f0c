#pragma once
#include <limits>
#include <vector>

#include "dynamics/geometric.h"
#include "dynamics/motion.h"
#include "dynamics/natural/once/layout.h"
#include "dynamics/projection.h"
#include "signals/values.h"

/// Scratch of the formulation in natural coordinates, sized once. Global axes; points relative to
/// Layout::origin.
namespace mimbre::natural {

/// Four columns: of the body's origin and of its unit vectors u, v, w.
template <class T>
using Base = Eigen::Matrix<T, 3, 4>;

template <class T>
struct BaseMotion {
  Base<T> position, velocity, acceleration;
};

/// A frame on a body as vectors, without use of angular velocities.
template <class T>
struct FrameMotion {
  Vec3<T> position, velocity, acceleration;
  Mat3<T> axes, axes_velocity, axes_acceleration;
  Vec3<T> place;     ///< of its origin, deformed, body axes
  Mat3<T> rotation;  ///< its axes in body axes, deformed
};

template <class T>
struct Workspace {
  Workspace(const Compiled& m, const Layout& l);

  std::vector<Vec3<T>> values, rates, seconds;  ///< of the variables, constants behind
  std::vector<BaseMotion<T>> bodies;            ///< by kinematics
  AlignedVector<T> y, yd, ydd;                  ///< padded modal amplitudes, by kinematics
  std::vector<FrameMotion<T>> frames;           ///< those in use, by kinematics
  std::vector<Base<T>> forces;                  ///< residual's forces on the bodies' base vectors
  AlignedVector<T> modal;                       ///< residual's forces on padded modal amplitudes
  AlignedVector<T> integrals;                   ///< S'^i of one flexible body
  std::vector<Vec3<T>> constraint_linear;       ///< of constraints' terms at frame b, by constraints
  std::vector<Vec3<T>> constraint_angular;
  std::vector<T> constraint_states;  ///< that they remember at the end of the step, by constraints
  double rate_time = 0;              ///< System::set_rate_time
  AlignedVector<T> elements;         ///< ElementState of each, by forces
  SignalValues<T> signals;           ///< by kinematics (what time decides) and forces (what motion decides)
  std::vector<T> phi, phi_dot, phi_ddot;
  AlignedVector<T> jacobian;   ///< rows over the stencils' columns, by jacobian()
  AlignedVector<T> local;      ///< a stencil's dense matrix
  AlignedVector<T> row_modal;  ///< a row's part on the amplitudes of its two bodies; three rows
  /// By flexible body's data, for inertia by projection; empty: shape integrals. By the system.
  std::vector<projection::Constants> projections;
  projection::Work projection;
  AlignedVector<T> folded;             ///< a matrix of extended amplitudes folded, by matrix
  AlignedVector<T> geometric_scratch;  ///< of geometric stiffness, by inertia and matrix
  AlignedVector<T> coupling;           ///< 12 rows of base vectors and amplitudes, by matrix
  std::vector<Base<T>> poses;          ///< of the bodies, by joint_positions
};

template <class T>
Workspace<T>::Workspace(const Compiled& m, const Layout& l) : signals(m) {
  // NaN everywhere, so that a value read before it is written shows.
  const T nan = T(std::numeric_limits<double>::quiet_NaN());
  const Vec3<T> nan3 = Vec3<T>::Constant(nan);
  const Mat3<T> nan33 = Mat3<T>::Constant(nan);
  const Base<T> nan34 = Base<T>::Constant(nan);
  values.assign(l.variables.size(), nan3);
  rates.assign(l.variables.size(), Vec3<T>::Zero());
  seconds.assign(l.variables.size(), Vec3<T>::Zero());
  for (std::size_t k = l.unknown_variables; k < l.variables.size(); ++k)
    values[k] = l.variables[k].place.template cast<T>();
  bodies.assign(m.bodies.size(), {nan34, nan34, nan34});
  y.assign(l.amplitude_storage, T(0));
  yd.assign(l.amplitude_storage, T(0));
  ydd.assign(l.amplitude_storage, T(0));
  frames.assign(m.frames.size(), {nan3, nan3, nan3, nan33, nan33, nan33, nan3, nan33});
  forces.assign(m.bodies.size(), nan34);
  modal.assign(l.amplitude_storage, nan);
  int integral = 0, stride = 8;
  for (const BodyData& b : m.bodies) {
    if (b.modes == 0) continue;
    const FlexibleData& f = m.flexible[b.flexible];
    integral = std::max(integral, inertia_row_storage(b, f));
    stride = std::max(stride, f.stride);
  }
  integrals.assign(integral, nan);
  constraint_linear.assign(m.constraint_covectors, nan3);
  constraint_angular.assign(m.constraint_covectors, nan3);
  constraint_states.assign(m.constraint_states, nan);
  elements.assign(m.element_storage, nan);
  for (auto* v : {&phi, &phi_dot, &phi_ddot}) v->assign(l.equations, nan);
  jacobian.assign(l.jacobian_storage, nan);
  local.assign(static_cast<std::size_t>(l.widest) * l.widest, nan);
  row_modal.assign(4 * stride, nan);
  coupling.assign(12 * stride, nan);
  folded.assign(static_cast<std::size_t>(stride) * stride, nan);
  geometric_scratch.assign(geometric::scratch(m), nan);
  poses.assign(m.bodies.size(), nan34);
}

}  // namespace mimbre::natural
