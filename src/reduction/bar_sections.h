#pragma once
#include "mimbre/beam_reduction.h"

namespace mimbre::fe {

/// Section forces of the mesh's elements by the loads that BarSections lists. `shapes`: of the modes over the
/// mesh's dofs; `frames`: the nodes on which forces act. Each load has its static answer with the clamped
/// nodes held, which bear what of all loads together is not in balance: nothing but for the modes that were
/// left out.
BarSections bar_sections(const Mesh& mesh, const Matrices& matrices, const ReductionOptions& options,
                         const std::vector<NodeFrame>& frames, const Eigen::MatrixXd& shapes);

}  // namespace mimbre::fe
