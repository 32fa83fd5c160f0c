#include "linalg/once/sparse_qr.h"

#include <Eigen/Core>
#include <Eigen/Householder>
#include <Eigen/OrderingMethods>
#include <algorithm>
#include <limits>
#include <utility>

namespace mimbre::linalg {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Columns that are eliminated together as they have the same rows, in one dense matrix: the rows of A that
/// begin in them, and what the fronts before have left. Its first columns are its own.
struct Front {
  int first = 0, own = 0;    ///< columns that it eliminates, in the order of elimination
  std::vector<int> columns;  ///< in that order
  std::vector<int> rows;     ///< in the vectors that Q acts on
  /// R in the rows of the reflections, below them the reflections, behind its own columns what it leaves.
  MatrixXd dense;
  struct Reflection {
    int row = 0, column = 0;
    double factor = 0;
  };
  std::vector<Reflection> reflections;  ///< of its own columns, then of what it leaves
  int rank = 0;                         ///< number of the former
  int left() const { return std::min(static_cast<int>(rows.size()), rank + rest()) - rank; }
  int rest() const { return static_cast<int>(columns.size()) - own; }
  bool trapezoidal() const { return reflections.size() > static_cast<std::size_t>(rank); }
};

/// The entries of one row: column in the order of elimination, value.
using Row = std::vector<std::pair<int, double>>;

/// Which column comes next of those after it with which a column shares entries of AᵀA once those before are
/// eliminated; −1: none (Liu 1986; Davis 2006, chapter 4).
std::vector<int> elimination_tree(const SparseMatrix& A, const std::vector<int>& order) {
  std::vector<int> parent(order.size(), -1), ancestor = parent, last(static_cast<std::size_t>(A.rows()), -1);
  for (int k = 0; k < static_cast<int>(order.size()); ++k)
    for (SparseMatrix::InnerIterator entry(A, order[k]); entry; ++entry) {
      int& seen = last[static_cast<std::size_t>(entry.row())];
      for (int i = seen; i >= 0 && i < k;) {
        const int next = ancestor[i];
        ancestor[i] = k;
        if (next < 0) parent[i] = k;
        i = next;
      }
      seen = k;
    }
  return parent;
}

/// Order in which each column directly follows its subtree, for a tree whose parents have larger numbers.
std::vector<int> postorder(const std::vector<int>& parent) {
  const int n = static_cast<int>(parent.size());
  std::vector<int> head(parent.size() + 1, -1), next(parent.size(), -1), order, stack;
  for (int k = n - 1; k >= 0; --k) {
    int& list = head[parent[k] < 0 ? n : parent[k]];
    next[k] = list;
    list = k;
  }
  order.reserve(parent.size());
  for (int root = head[n]; root >= 0; root = next[root]) {
    stack.push_back(root);
    while (!stack.empty()) {
      int& child = head[stack.back()];
      if (child >= 0) {
        stack.push_back(std::exchange(child, next[child]));
      } else {
        order.push_back(stack.back());
        stack.pop_back();
      }
    }
  }
  return order;
}

/// Columns in an order of little fill in R, and their tree in this order.
struct Elimination {
  std::vector<int> order, parent;
};

Elimination elimination(const SparseMatrix& A) {
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> places;
  Eigen::COLAMDOrdering<int>()(A, places);
  std::vector<int> few_fills(static_cast<std::size_t>(A.cols()));
  for (int k = 0; k < A.cols(); ++k) few_fills[static_cast<std::size_t>(places.indices()[k])] = k;
  const std::vector<int> parent = elimination_tree(A, few_fills), post = postorder(parent);
  Elimination e{std::vector<int>(post.size()), std::vector<int>(post.size(), -1)};
  std::vector<int> place(post.size());
  for (std::size_t k = 0; k < post.size(); ++k) place[post[k]] = static_cast<int>(k);
  for (std::size_t k = 0; k < post.size(); ++k) {
    e.order[k] = few_fills[post[k]];
    if (parent[post[k]] >= 0) e.parent[k] = place[parent[post[k]]];
  }
  return e;
}

}  // namespace

struct SparseQr::Impl {
  Index rows = 0;
  std::vector<int> order;          ///< columns of A in the order of elimination
  std::vector<char> is_set_aside;  ///< of these
  std::vector<Front> fronts;
  int rank = 0;
  double least_pivot = std::numeric_limits<double>::infinity();

  Impl(const SparseMatrix& A, double threshold) : rows(A.rows()) {
    if (A.cols() == 0) return;
    SparseMatrix compressed = A;
    compressed.makeCompressed();
    Elimination e = elimination(compressed);
    order = std::move(e.order);
    is_set_aside.assign(order.size(), 0);
    std::vector<Row> entries(static_cast<std::size_t>(rows));
    for (int k = 0; k < static_cast<int>(order.size()); ++k)
      for (SparseMatrix::InnerIterator entry(compressed, order[k]); entry; ++entry)
        entries[static_cast<std::size_t>(entry.row())].emplace_back(k, entry.value());
    find_fronts(e.parent, entries);
    eliminate(e.parent, entries, threshold);
  }

  /// Columns and rows of A of each front.
  void find_fronts(const std::vector<int>& parent, const std::vector<Row>& entries) {
    const int n = static_cast<int>(order.size());
    std::vector<std::vector<int>> beginning(order.size()), children(order.size()), shape(order.size());
    for (std::size_t row = 0; row < entries.size(); ++row)
      if (!entries[row].empty()) beginning[entries[row].front().first].push_back(static_cast<int>(row));
    std::vector<int> mark(order.size(), -1);
    std::size_t last_width = 0;
    for (int k = 0; k < n; ++k) {
      std::vector<int>& columns = shape[k];
      const auto add = [&](int column) {
        if (column >= k && std::exchange(mark[column], k) != k) columns.push_back(column);
      };
      add(k);
      for (const int row : beginning[k])
        for (const auto& [column, value] : entries[row]) add(column);
      for (const int child : children[k]) {
        for (const int column : shape[child]) add(column);
        shape[child] = {};
      }
      std::sort(columns.begin(), columns.end());
      const bool joins = k > 0 && parent[k - 1] == k && columns.size() + 1 == last_width;
      last_width = columns.size();
      if (!joins) {
        fronts.push_back({});
        fronts.back().first = k;
        fronts.back().columns = columns;
      }
      Front& front = fronts.back();
      ++front.own;
      front.rows.insert(front.rows.end(), beginning[k].begin(), beginning[k].end());
      if (parent[k] >= 0) children[parent[k]].push_back(k);
    }
  }

  void eliminate(const std::vector<int>& parent, const std::vector<Row>& entries, double threshold) {
    std::vector<int> front_of(order.size()), place(order.size());
    for (std::size_t f = 0; f < fronts.size(); ++f)
      std::fill_n(front_of.begin() + fronts[f].first, fronts[f].own, static_cast<int>(f));
    std::vector<std::vector<int>> before(fronts.size());
    for (std::size_t f = 0; f < fronts.size(); ++f) {
      Front& front = fronts[f];
      const std::size_t of_matrix = front.rows.size();
      for (const int b : before[f])
        front.rows.insert(front.rows.end(), fronts[b].rows.begin() + fronts[b].rank,
                          fronts[b].rows.begin() + fronts[b].rank + fronts[b].left());
      for (std::size_t c = 0; c < front.columns.size(); ++c) place[front.columns[c]] = static_cast<int>(c);
      front.dense.setZero(std::ssize(front.rows), std::ssize(front.columns));
      for (std::size_t r = 0; r < of_matrix; ++r)
        for (const auto& [column, value] : entries[front.rows[r]])
          front.dense(static_cast<Index>(r), place[column]) = value;
      Index row = static_cast<Index>(of_matrix);
      for (const int b : before[f]) {
        const Front& from = fronts[b];
        for (int r = 0; r < from.left(); ++r, ++row)
          for (int c = from.trapezoidal() ? r : 0; c < from.rest(); ++c)
            front.dense(row, place[from.columns[from.own + c]]) = from.dense(from.rank + r, from.own + c);
      }
      factor(front, threshold);
      const int next = parent[front.first + front.own - 1];
      if (next >= 0 && front.left() > 0) before[front_of[next]].push_back(static_cast<int>(f));
    }
  }

  /// Householder's reflections: of a front's own columns but those that add too little; of what it leaves,
  /// where that has more rows than columns.
  void factor(Front& front, double threshold) {
    MatrixXd& dense = front.dense;
    const auto height = static_cast<int>(dense.rows()), width = static_cast<int>(dense.cols());
    VectorXd work(width);
    int row = 0;
    const auto reflect = [&](int column) {
      Front::Reflection h{row, column, 0};
      double pivot = 0;
      dense.col(column).tail(height - row).makeHouseholderInPlace(h.factor, pivot);
      dense.bottomRightCorner(height - row, width - column - 1)
          .applyHouseholderOnTheLeft(dense.col(column).tail(height - row - 1), h.factor, work.data());
      dense(row, column) = pivot;
      front.reflections.push_back(h);
      ++row;
    };
    for (int column = 0; column < front.own; ++column) {
      const double length = dense.col(column).tail(height - row).norm();
      if (length > 0 && length >= threshold) {
        reflect(column);
        least_pivot = std::min(least_pivot, length);
      } else {
        is_set_aside[front.first + column] = 1;
        dense.col(column).tail(height - row).setZero();
      }
    }
    front.rank = row;
    rank += row;
    if (height - row > front.rest())
      for (int column = front.own; column < width; ++column) reflect(column);
  }
};

SparseQr::SparseQr(const SparseMatrix& A, double threshold) : impl_(std::make_unique<Impl>(A, threshold)) {}

SparseQr::~SparseQr() = default;

int SparseQr::rank() const { return impl_->rank; }

double SparseQr::least_pivot() const { return impl_->least_pivot; }

std::vector<int> SparseQr::dependent() const {
  std::vector<int> columns;
  for (std::size_t k = 0; k < impl_->order.size(); ++k)
    if (impl_->is_set_aside[k]) columns.push_back(impl_->order[k]);
  return columns;
}

VectorXd SparseQr::null_vector(const VectorXd& of_dependent) const {
  VectorXd x = VectorXd::Zero(std::ssize(impl_->order));
  Index given = 0;
  for (std::size_t k = 0; k < impl_->order.size(); ++k)
    if (impl_->is_set_aside[k]) x[impl_->order[k]] = of_dependent[given++];
  for (auto front = impl_->fronts.rbegin(); front != impl_->fronts.rend(); ++front)
    for (int r = front->rank - 1; r >= 0; --r) {
      const int column = front->reflections[r].column;
      double sum = 0;
      for (std::size_t c = column + 1; c < front->columns.size(); ++c)
        sum += front->dense(r, static_cast<Index>(c)) * x[impl_->order[front->columns[c]]];
      x[impl_->order[front->columns[column]]] = -sum / front->dense(r, column);
    }
  return x;
}

VectorXd SparseQr::shortest(const VectorXd& b) const {
  // Rᵀ y = b, and x = Q y.
  VectorXd x = VectorXd::Zero(impl_->rows), known = VectorXd::Zero(std::ssize(impl_->order));
  for (const Front& front : impl_->fronts)
    for (int r = 0; r < front.rank; ++r) {
      const int column = front.reflections[r].column, k = front.columns[column];
      const double y = (b[impl_->order[k]] - known[k]) / front.dense(r, column);
      for (std::size_t c = column + 1; c < front.columns.size(); ++c)
        known[front.columns[c]] += front.dense(r, static_cast<Index>(c)) * y;
      x[front.rows[r]] = y;
    }
  for (auto front = impl_->fronts.rbegin(); front != impl_->fronts.rend(); ++front) {
    const auto height = static_cast<int>(front->rows.size());
    for (auto h = front->reflections.rbegin(); h != front->reflections.rend(); ++h) {
      double sum = x[front->rows[h->row]];
      for (int r = h->row + 1; r < height; ++r) sum += front->dense(r, h->column) * x[front->rows[r]];
      sum *= h->factor;
      x[front->rows[h->row]] -= sum;
      for (int r = h->row + 1; r < height; ++r) x[front->rows[r]] -= sum * front->dense(r, h->column);
    }
  }
  return x;
}

}  // namespace mimbre::linalg
