#pragma once
#include <Eigen/SparseCore>
#include <functional>
#include <vector>

namespace mimbre::linalg {

/// The columns of a sparse square matrix by colours: columns of one colour have no row in common, so that one
/// product with the sum of their unit vectors yields all of them (Curtis, Powell, Reid, J. Inst. Maths
/// Applics 13, 1974). The pattern consists of groups of unknowns that may couple with each other.
class ColumnColours {
 public:
  /// Of `size` unknowns; those that are in no group couple with themselves alone. A group may repeat itself.
  ColumnColours(int size, const std::vector<std::vector<int>>& groups);

  int size() const { return static_cast<int>(colour_.size()); }
  int colours() const { return count_; }
  /// A from its products: product(x, y) writes y = A x, x a sum of unit vectors. Entries outside the pattern
  /// must vanish. The result has all entries of the pattern, zeros too.
  Eigen::SparseMatrix<double> assemble(
      const std::function<void(const Eigen::VectorXd&, Eigen::VectorXd&)>& product) const;

 private:
  std::vector<std::vector<int>> rows_;  ///< of each column, ascending
  std::vector<int> colour_;
  int count_ = 0;
};

}  // namespace mimbre::linalg
