#pragma once
#include <Eigen/Core>
#include <Eigen/SparseCore>

/// Dense matrices as tests compare with; here, not in every unit, as they take long to compile.
namespace mimbre::test {

/// Both triangles of a symmetric matrix given by its lower one.
Eigen::MatrixXd full(const Eigen::SparseMatrix<double>& lower);
/// Tᵀ A T.
Eigen::MatrixXd congruent(const Eigen::MatrixXd& A, const Eigen::MatrixXd& T);
/// The largest difference of entries over the largest entry of both, at least `floor`.
double relative_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double floor = 1.0);
/// A⁻¹ b.
Eigen::MatrixXcd solve(const Eigen::MatrixXcd& A, const Eigen::MatrixXd& b);
/// Of any square matrix.
Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& A);

}  // namespace mimbre::test
