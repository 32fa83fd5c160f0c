#include "linalg/colouring.h"

#include <algorithm>

namespace mimbre::linalg {

ColumnColours::ColumnColours(int size, const std::vector<std::vector<int>>& groups)
    : rows_(static_cast<std::size_t>(size)), colour_(static_cast<std::size_t>(size), -1) {
  for (int k = 0; k < size; ++k) rows_[static_cast<std::size_t>(k)].push_back(k);
  for (const std::vector<int>& group : groups)
    for (const int column : group) {
      std::vector<int>& rows = rows_[static_cast<std::size_t>(column)];
      rows.insert(rows.end(), group.begin(), group.end());
    }
  for (std::vector<int>& rows : rows_) {
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  }
  // The pattern is symmetric: the columns with an entry in a row are that column's rows.
  std::vector<int> taken_by;
  for (int column = 0; column < size; ++column) {
    for (const int row : rows_[static_cast<std::size_t>(column)])
      for (const int other : rows_[static_cast<std::size_t>(row)])
        if (const int c = colour_[static_cast<std::size_t>(other)]; c >= 0)
          taken_by[static_cast<std::size_t>(c)] = column;
    const auto free = std::find_if(taken_by.begin(), taken_by.end(), [&](int by) { return by != column; });
    colour_[static_cast<std::size_t>(column)] = static_cast<int>(free - taken_by.begin());
    if (free == taken_by.end()) taken_by.push_back(-1);
  }
  count_ = static_cast<int>(taken_by.size());
}

Eigen::SparseMatrix<double> ColumnColours::assemble(
    const std::function<void(const Eigen::VectorXd&, Eigen::VectorXd&)>& product) const {
  const int n = size();
  std::vector<int> starts(static_cast<std::size_t>(n) + 1, 0);
  for (int k = 0; k < n; ++k)
    starts[static_cast<std::size_t>(k) + 1] =
        starts[static_cast<std::size_t>(k)] + static_cast<int>(rows_[static_cast<std::size_t>(k)].size());
  Eigen::SparseMatrix<double> A(n, n);
  A.resizeNonZeros(starts.back());
  std::copy(starts.begin(), starts.end(), A.outerIndexPtr());
  for (int k = 0; k < n; ++k)
    std::copy(rows_[static_cast<std::size_t>(k)].begin(), rows_[static_cast<std::size_t>(k)].end(),
              A.innerIndexPtr() + starts[static_cast<std::size_t>(k)]);
  Eigen::VectorXd x(n), y(n);
  for (int c = 0; c < count_; ++c) {
    for (int k = 0; k < n; ++k) x[k] = colour_[static_cast<std::size_t>(k)] == c;
    product(x, y);
    for (int k = 0; k < n; ++k) {
      if (colour_[static_cast<std::size_t>(k)] != c) continue;
      double* values = A.valuePtr() + starts[static_cast<std::size_t>(k)];
      for (const int row : rows_[static_cast<std::size_t>(k)]) *values++ = y[row];
    }
  }
  return A;
}

}  // namespace mimbre::linalg
