#pragma once
#include <Eigen/Core>

#include "dynamics/relative/system.h"
#include "dynamics/state.h"
#include "mimbre/reduced_body.h"

namespace mimbre {

/// N, Vy, Vz, T, My, Mz (N, N m) of a section of a body made of bars (BarSections), after a residual with the
/// state's accelerations and multipliers. `body`: of the compiled model.
Eigen::Matrix<double, 6, 1> section_forces(const relative::RelativeSystem& system,
                                           const BarSections& sections, int body, int section,
                                           const State& state);

/// The largest von Mises stress in a section, Pa: of its outermost fibres by N, My and Mz, and of its largest
/// shear stress by T, as if both were at one place; shear stress by V, which is zero there, is left out. NaN
/// where the section's shape is not known.
double largest_stress(const BarSections::Section& section, const Eigen::Matrix<double, 6, 1>& forces);

}  // namespace mimbre
