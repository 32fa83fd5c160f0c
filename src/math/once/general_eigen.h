#pragma once
#include <Eigen/Core>

/// Eigenvectors of dense matrices that are not symmetric; the only place that instantiates Eigen's for them,
/// as decompositions.h is of the others.
namespace mimbre {

/// A x = λ x of any square A, vectors of length 1. Eigenvalues that A shows are put outside and A is balanced
/// by powers of two first (Parlett, Reinsch, Numer. Math. 13, 1969).
struct ComplexPairs {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;
  bool ok = false;  ///< the iteration converged
};
ComplexPairs general_eigen(const Eigen::MatrixXd& A);
/// The inverse of the matrix of vectors: its rows are left vectors. What is singular gives numbers that are
/// not finite.
Eigen::MatrixXcd left_vectors(const ComplexPairs& pairs);
/// A⁻¹, likewise.
Eigen::MatrixXcd complex_inverse(const Eigen::MatrixXcd& A);

}  // namespace mimbre
