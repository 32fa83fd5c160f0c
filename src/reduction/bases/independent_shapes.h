#pragma once
#include <vector>

#include "reduction/bases/shapes.h"

namespace mimbre::fe {

/// What `added` shapes have beyond the `known` ones and those before them, by strain energy, each scaled to
/// unit modal mass. A shape of which no more than a millionth (of displacements) is new is left out; `fresh`
/// returns for each of the added how much of its strain energy is new, 0: left out. The stiffness must be
/// positive definite on all of these shapes.
Shapes independent_shapes(const FeMatrices& matrices, const Shapes& known, Shapes added,
                          std::vector<double>& fresh);

}  // namespace mimbre::fe
