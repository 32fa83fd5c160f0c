#pragma once
#include "mimbre/reduced_body.h"
#include "reduction/bases/shapes.h"

namespace mimbre::fe {

/// Forces on the dofs, a column per load. Throws std::invalid_argument for loads without nodes or force, on
/// nodes that cannot take it, and for names that are there twice.
Eigen::MatrixXd load_forces(const FeMatrices& matrices, const std::vector<SpreadLoad>& loads);
/// "load NAME".
std::vector<std::string> load_names(const std::vector<SpreadLoad>& loads);

/// Static deflections by the loads with all interfaces held.
Shapes load_shapes(const TiedModel& tied, const FeMatrices& matrices,
                   const std::vector<Interface>& interfaces, const std::vector<SpreadLoad>& loads);

/// What became of each load's mode; `fresh` as of independent_shapes.
std::vector<Check> load_checks(const std::vector<SpreadLoad>& loads, const std::vector<double>& fresh);

}  // namespace mimbre::fe
