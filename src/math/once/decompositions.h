#pragma once
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <optional>
#include <vector>

/// Decompositions of small dense matrices. This is the only place that instantiates Eigen's: they take a
/// compiler tens of seconds, and every unit that named one would pay them again. Nothing here allocates that
/// says so.
namespace mimbre {

/// λ ascending, and the vectors as columns, of length 1 (by M where there is one).
struct EigenPairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
  bool ok = false;  ///< the iteration converged
};
/// A x = λ x; of the symmetric A the lower triangle is read.
EigenPairs symmetric_eigen(const Eigen::MatrixXd& A);
/// K x = λ M x; likewise, M positive definite.
EigenPairs symmetric_eigen(const Eigen::MatrixXd& K, const Eigen::MatrixXd& M);
/// The values alone.
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& A);
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& K, const Eigen::MatrixXd& M);
/// Of any square matrix A; empty where the iteration does not converge.
Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& A);
/// Of small matrices, without allocating.
Eigen::Vector3d eigenvalues3(const Eigen::Matrix3d& A);
Eigen::Vector4d eigenvalues4(const Eigen::Matrix4d& A);
Eigen::Matrix<double, 6, 1> eigenvalues6(const Eigen::Matrix<double, 6, 6>& A);

/// A = L Lᵀ, for A positive definite.
class Cholesky {
 public:
  Cholesky() = default;
  explicit Cholesky(const Eigen::MatrixXd& A);
  bool ok() const { return ok_; }  ///< A is positive definite
  Eigen::MatrixXd lower() const;   ///< L
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;
  Eigen::MatrixXd solve_lower(const Eigen::MatrixXd& b) const;  ///< L⁻¹ b
  Eigen::MatrixXd solve_upper(const Eigen::MatrixXd& b) const;  ///< L⁻ᵀ b

 private:
  Eigen::LLT<Eigen::MatrixXd> factor_;
  bool ok_ = false;
};
bool is_positive_definite(const Eigen::MatrixXd& A);

/// A = Pᵀ L D Lᵀ P, for A semidefinite of either sign.
class PivotedCholesky {
 public:
  PivotedCholesky() = default;
  explicit PivotedCholesky(const Eigen::MatrixXd& A);
  /// Factors another matrix; does not allocate when it is no larger than the largest before.
  void compute(const Eigen::MatrixXd& A);
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;
  /// Without allocating.
  void solve_in_place(Eigen::VectorXd& b) const;
  double least_pivot() const;  ///< of D
  /// Index of the first pivot that is at most `least` of its entry in the diagonal of A; -1: none is. `work`
  /// has A's size.
  int singular_at(const Eigen::MatrixXd& A, double least, Eigen::VectorXd& work) const;

 private:
  Eigen::LDLT<Eigen::MatrixXd> factor_;
};

/// A⁻¹ b for square A, pivoted by rows; what is singular gives numbers that are not finite.
Eigen::MatrixXd solve(const Eigen::MatrixXd& A, const Eigen::MatrixXd& b);
Eigen::MatrixXd inverse(const Eigen::MatrixXd& A);
/// Pivoted by rows and columns; nothing where A has no full rank.
std::optional<Eigen::MatrixXd> inverse_if_regular(const Eigen::MatrixXd& A);

/// min |A x − b|, A of full column rank.
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& A, const Eigen::MatrixXd& b);
/// Of all x with least |A x − b| the shortest. Directions with pivots below `threshold` of the largest count
/// as dependent; 0: round-off.
Eigen::MatrixXd shortest_solution(const Eigen::MatrixXd& A, const Eigen::MatrixXd& b, double threshold = 0);
/// A⁺, likewise.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& A, double threshold = 0);

/// The columns of A by what each adds to those before it.
struct ColumnOrder {
  std::vector<int> order;  ///< of all columns
  int rank = 0;            ///< so many add more than `threshold` of the first
  double largest = 0;      ///< what the first adds, its length
};
ColumnOrder order_columns(const Eigen::MatrixXd& A, double threshold = 0);
/// Orthonormal columns N with A N = 0.
Eigen::MatrixXd null_space(const Eigen::MatrixXd& A, double threshold);

}  // namespace mimbre
