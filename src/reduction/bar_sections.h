#pragma once
#include <optional>

#include "mimbre/beam_reduction.h"

namespace mimbre::fe {

/// Section forces of the mesh's elements by the loads that BarSections lists. `shapes`: of the modes over the
/// mesh's dofs; `frames`: the nodes on which forces act. Each load has its static answer with the clamped
/// nodes held, which carry what of all loads together is not in balance: nothing but for the modes that were
/// left out.
BarSections bar_sections(const Mesh& mesh, const Matrices& matrices, const ReductionOptions& options,
                         const std::vector<NodeFrame>& frames, const Eigen::MatrixXd& shapes);

/// Stress by unit amplitudes of the modes; nothing where the shape of a section is not known.
std::optional<BarStress> bar_stress(const Mesh& mesh, const Eigen::MatrixXd& shapes);

}  // namespace mimbre::fe
