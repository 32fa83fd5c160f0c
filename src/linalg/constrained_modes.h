#pragma once
#include <Eigen/Core>

#include "linalg/once/sparse_factor.h"

/// Modes of large linear systems.
namespace mimbre::linalg {

/// (λ² M + λ C + K) x + Jᵀ μ = 0, J x = 0. Coordinates along their scales, rows of J of length one.
struct ConstrainedPencil {
  SparseMatrix M, C, K, J;
};

struct ConstrainedModes {
  Eigen::VectorXcd values;   ///< λ with Im λ ≥ 0, ascending |λ|, zeros left out
  Eigen::MatrixXcd vectors;  ///< x as columns, of length one
  Eigen::MatrixXd rigid;     ///< orthonormal x with λ = 0
  bool symmetric = false;    ///< M, C and K are, along the motions with J x = 0
  bool ok = false;
};

/// The `count` modes of least |λ|, rigid ones among them, by shift-and-invert block Arnoldi iteration with
/// full orthogonalisation (Saad, Numerical Methods for Large Eigenvalue Problems, 2nd ed., 2011, chapters 6
/// to 8) of the pencil of first order in (x, λ x). The shift is real, near the largest |λ| wanted, which
/// counts of negative pivots find (Sylvester). Blocks find equal eigenvalues. Where M, C and K are symmetric
/// each λ is the root of its Rayleigh quotient, exact to the second order of the vector's error. Not ok: it
/// has not converged.
ConstrainedModes lowest_modes(const ConstrainedPencil& pencil, int count);

}  // namespace mimbre::linalg
