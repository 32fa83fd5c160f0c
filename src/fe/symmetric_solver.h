#pragma once
#include <Eigen/Sparse>
#ifdef MIMBRE_WITH_CHOLMOD
#include <Eigen/CholmodSupport>
#endif

namespace mimbre::fe {

/// Sparse Cholesky factorisation of the finite-element matrices. CHOLMOD itself chooses between its
/// simplicial and supernodal methods; frames of beams are so sparse that it takes the simplicial one.
#ifdef MIMBRE_WITH_CHOLMOD
using SymmetricSolver = Eigen::CholmodDecomposition<Eigen::SparseMatrix<double>>;
#else
using SymmetricSolver = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>;
#endif

}  // namespace mimbre::fe
