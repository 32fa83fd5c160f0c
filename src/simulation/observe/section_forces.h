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

}  // namespace mimbre
