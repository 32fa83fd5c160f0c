#pragma once
#include <functional>

#include "reduction/bases/shapes.h"

namespace mimbre::fe {

/// Lowest elastic modes of the model with its interfaces tied but free, and what forces at the interfaces do
/// statically beyond these modes: residual attachment modes by inertia relief (MacNeal 1971; Rubin 1975;
/// Craig, Chang 1977). All are without momentum; attachment modes that depend on others are left out.
/// `loads` (dofs × loads, called `load_names`) are treated as forces at the interfaces are.
/// Count: `modes`, or where `limit` (ω², s⁻²) is positive all below it. `eigenvalues`: of the modes.
Shapes free_interface_shapes(const TiedModel& tied, const FeMatrices& matrices,
                             const std::vector<Interface>& interfaces, const Eigen::MatrixXd& R, int modes,
                             double limit, const Eigen::MatrixXd& loads,
                             const std::vector<std::string>& load_names, Eigen::VectorXd& eigenvalues,
                             const std::function<void(double)>& progress = {});

}  // namespace mimbre::fe
