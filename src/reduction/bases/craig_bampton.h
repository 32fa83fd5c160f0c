#pragma once
#include <Eigen/Core>
#include <vector>

#include "mimbre/beam_reduction.h"

namespace mimbre::fe {

/// The mode shapes of a reduction and the stiffness in their coordinates.
struct Basis {
  Eigen::MatrixXd shapes;     ///< Φ, 6·nodes × modes, body axes
  Eigen::MatrixXd stiffness;  ///< ΦᵀKΦ: the static modes' block, then ω² of the fixed-interface modes
  std::vector<std::string> names;
  Eigen::MatrixXd responses;  ///< 6·nodes × loads: static, with clamped, fixed and boundary dofs held
};

/// Static constraint modes, one per boundary dof, then the lowest fixed-interface modes (Craig, Bampton 1968;
/// Lugrís 2008, 2.7–2.9). Errors as for reduce(). `loads`: forces on the mesh's dofs, 6·nodes × loads, whose
/// static responses are wanted too.
Basis craig_bampton(const Mesh& mesh, const Matrices& matrices, const ReductionOptions& options,
                    const Eigen::MatrixXd& loads = {});

}  // namespace mimbre::fe
