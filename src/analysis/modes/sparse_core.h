#pragma once
#include <string>

#include "dynamics/natural/system.h"
#include "linalg/constrained_modes.h"

/// Exact derivatives of the equations of motion of large mechanisms at rest.
namespace mimbre::linear {

/// M δq̈ + C δq̇ + K δq + Φqᵀ δλ = 0, Φq δq = 0 in natural coordinates, along their scales and with rows of Φq
/// of length one. K contains the stiffness of prestress and of constraint forces.
struct SparseEquations {
  linalg::ConstrainedPencil pencil;
  Eigen::VectorXd scale;  ///< δq = scale times x
  /// The largest work of forces that do not balance at the point, of that of the heaviest part's weight or of
  /// what else is at play.
  double unbalanced = 0;
};

/// Why derivatives by colours are not those of this model; empty: they are.
std::string not_sparse(const Compiled& model);

/// At a state at rest, in natural coordinates, with its multipliers; u, z: inputs and states of elements as
/// in the relative formulation. `at_play`: the largest work of a force along the scales. Derivatives are
/// those over dual numbers, all columns of a colour at once. Throws std::runtime_error where a force acts
/// elsewhere than between what it measures.
SparseEquations sparse_equations(const natural::NaturalSystem& system, const State& natural,
                                 const Eigen::VectorXd& u, const Eigen::VectorXd& z, double at_play);

}  // namespace mimbre::linear
