#pragma once
#include <algorithm>
#include <limits>

#include "dynamics/flexible.h"
#include "dynamics/geometric.h"
#include "dynamics/relative/workspace.h"

/// The workspace over any scalar, for the unit that instantiates it: system.cpp does for double.
namespace mimbre::relative {

template <class T>
Workspace<T>::Workspace(const Compiled& m) : signals(m) {
  // NaN everywhere, so that a value read before it is written shows.
  const T nan = T(std::numeric_limits<double>::quiet_NaN());
  const Vec3<T> nan3 = Vec3<T>::Constant(nan);
  const Mat3<T> nan33 = Mat3<T>::Constant(nan);
  bodies.assign(m.bodies.size(), {nan33, nan3, nan3, nan3, nan3, nan3});
  frames.assign(m.frames.size(), {nan33, nan3, nan3, nan3, nan3, nan3});
  move_origin<T>(m, *this, Vec3<T>::Zero());
  joint_angular.assign(m.velocities, nan3);
  joint_linear.assign(m.velocities, nan3);
  wrenches.assign(m.frames.size(), {nan3, nan3});
  transmitted.assign(m.bodies.size(), {nan3, nan3});
  phi.assign(m.equations, nan);
  phi_dot.assign(m.equations, nan);
  phi_ddot.assign(m.equations, nan);
  covector_linear.assign(m.equations, nan3);
  covector_angular.assign(m.equations, nan3);
  constraint_linear.assign(m.constraint_covectors, nan3);
  constraint_angular.assign(m.constraint_covectors, nan3);
  constraint_states.assign(m.constraint_states, nan);
  elements.assign(m.element_storage, nan);
  subspaces.assign(m.subspace_storage, nan);
  jacobian.assign(m.jacobian_storage, nan);
  weighted.assign(m.jacobian_storage, nan);
  composites.assign(m.bodies.size(), {nan, nan3, nan33});
  stress.assign(m.bodies.size(), {nan3, nan3, nan3});
  int widest = 8, elastic = 0, integral = 0;
  for (const BodyData& b : m.bodies) {
    widest = std::max(widest, pad(b.size()));
    elastic_offset.push_back(elastic);
    integral_offset.push_back(integral);
    if (b.modes == 0) continue;
    widest = std::max(widest, m.flexible[b.flexible].stride);
    elastic += 6 * pad(b.size());
    integral += inertia_row_storage(b, m.flexible[b.flexible]);
  }
  subspace_forces.assign(6 * widest, nan);
  elastic_forces.assign(elastic, nan);
  integrals.assign(integral, nan);
  for (std::size_t i = 0; i < m.bodies.size(); ++i)
    if (const BodyData& b = m.bodies[i]; b.modes > 0)
      set_undeformed_rows(b, m.flexible[b.flexible], integrals.data() + integral_offset[i]);
  scratch.assign(24 * widest, nan);
  output.assign(3 * widest, nan);
  folded.assign(static_cast<std::size_t>(widest) * widest, nan);
  geometric_scratch.assign(geometric::scratch(m), nan);
}

}  // namespace mimbre::relative
