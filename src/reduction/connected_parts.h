#pragma once
#include <vector>

#include "mimbre/fe_reduce.h"

namespace mimbre::fe {

/// Whether elements (entries of the stiffness) and interfaces join all nodes that have dofs. Where they do
/// not, reports how many parts there are, where the smallest is, and how many nodes of different parts
/// coincide, as in meshes that were never merged.
Check connected_check(const SolidMesh& mesh, const FeMatrices& matrices,
                      const std::vector<Interface>& interfaces);

}  // namespace mimbre::fe
