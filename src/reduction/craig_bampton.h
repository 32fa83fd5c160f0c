#pragma once
#include <Eigen/Core>
#include <vector>

#include "mimbre/fe.h"

namespace mimbre::fe {

/// The mode shapes of a reduction and the stiffness in their coordinates.
struct Basis {
  Eigen::MatrixXd shapes;     ///< Φ, 6·nodes × modes, body axes
  Eigen::MatrixXd stiffness;  ///< ΦᵀKΦ: the static modes' block, then ω² of the fixed-interface modes
  std::vector<std::string> names;
};

/// Static constraint modes, one per boundary dof, then the lowest fixed-interface modes (Craig, Bampton 1968;
/// Lugrís 2008, 2.7–2.9). Errors as for reduce().
Basis craig_bampton(const Mesh& mesh, const Matrices& matrices, const ReductionOptions& options);

}  // namespace mimbre::fe
