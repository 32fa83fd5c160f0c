#pragma once
#include <Eigen/Core>
#include <array>

/// Products of an element's matrices in plain loops. As an expression of Eigen each would take a compiler a
/// second or more, since every size is a type of its own.
namespace mimbre::fe {

/// into += factor · Bᵀ A B. Rows of B beyond those of A do not count.
template <class Into, class Columns, class Square>
void add_congruent(Into& into, double factor, const Columns& B, const Square& A) {
  const Eigen::Index inner = A.rows(), size = B.cols();
  std::array<double, 60> column;  // of A B
  for (Eigen::Index j = 0; j < size; ++j) {
    for (Eigen::Index k = 0; k < inner; ++k) {
      double sum = 0;
      for (Eigen::Index l = 0; l < inner; ++l) sum += A(k, l) * B(l, j);
      column[static_cast<std::size_t>(k)] = factor * sum;
    }
    for (Eigen::Index i = 0; i < size; ++i) {
      double sum = 0;
      for (Eigen::Index k = 0; k < inner; ++k) sum += B(k, i) * column[static_cast<std::size_t>(k)];
      into(i, j) += sum;
    }
  }
}

/// into += factor · Bᵀ B
template <class Into, class Columns>
void add_square(Into& into, double factor, const Columns& B) {
  for (Eigen::Index j = 0; j < B.cols(); ++j)
    for (Eigen::Index i = 0; i < B.cols(); ++i) {
      double sum = 0;
      for (Eigen::Index k = 0; k < B.rows(); ++k) sum += B(k, i) * B(k, j);
      into(i, j) += factor * sum;
    }
}

}  // namespace mimbre::fe
