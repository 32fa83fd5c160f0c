#pragma once
#include <vector>

#include "mimbre/fe_reduce.h"

namespace mimbre::fe {

/// As check_matrices of the public header; the nodes of rigid interfaces, which move together, need no
/// stiffness of their own.
std::vector<Check> check_matrices(const SolidMesh& mesh, const FeMatrices& matrices,
                                  const std::vector<Interface>& interfaces);

}  // namespace mimbre::fe
