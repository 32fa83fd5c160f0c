#include "fe/solve/block_pattern.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace mimbre::fe {
namespace {

/// Cells of each node: `cells[begin[node]] …`, ascending.
struct NodeCells {
  std::vector<int> begin;
  std::vector<int> cells;
};

NodeCells cells_of_nodes(const MeshCells& cells) {
  NodeCells result;
  result.begin.assign(cells.node_dofs.size() + 1, 0);
  for (int node : cells.nodes) ++result.begin[node + 1];
  std::partial_sum(result.begin.begin(), result.begin.end(), result.begin.begin());
  result.cells.resize(cells.nodes.size());
  std::vector<int> next(result.begin.begin(), result.begin.end() - 1);
  for (int cell = 0; cell < cells.size(); ++cell)
    for (int k = cells.first[cell]; k < cells.first[cell + 1]; ++k)
      result.cells[next[cells.nodes[k]]++] = cell;
  return result;
}

/// Entries of one column of a node, its own block's below and on the diagonal included.
int column_size(const BlockPattern& pattern, BlockKind kind, int node, int column) {
  const int begin = pattern.begin[node];
  const int end = pattern.begin[node + 1];
  if (kind == BlockKind::full) {
    const int last = pattern.neighbours[end - 1];
    return pattern.rows_before[end - 1] + pattern.first_dof[last + 1] - pattern.first_dof[last] - column;
  }
  return static_cast<int>(
      std::count_if(pattern.neighbours.begin() + begin, pattern.neighbours.begin() + end,
                    [&](int b) { return pattern.first_dof[b + 1] - pattern.first_dof[b] > column; }));
}

}  // namespace

BlockPattern block_pattern(const MeshCells& cells) {
  const int nodes = static_cast<int>(cells.node_dofs.size());
  BlockPattern pattern;
  pattern.first_dof.assign(nodes + 1, 0);
  std::int64_t dofs = 0;
  for (int node = 0; node < nodes; ++node) {
    dofs += cells.node_dofs[node];
    if (dofs > std::numeric_limits<int>::max()) throw std::length_error("the mesh has too many dofs");
    pattern.first_dof[node + 1] = static_cast<int>(dofs);
  }

  const NodeCells of_nodes = cells_of_nodes(cells);
  pattern.begin.reserve(nodes + 1);
  pattern.begin.push_back(0);
  std::vector<int> seen(nodes, -1);
  for (int node = 0; node < nodes; ++node) {
    const auto own = static_cast<std::ptrdiff_t>(pattern.neighbours.size());
    for (int c = of_nodes.begin[node]; c < of_nodes.begin[node + 1]; ++c) {
      const int cell = of_nodes.cells[c];
      for (int k = cells.first[cell]; k < cells.first[cell + 1]; ++k) {
        const int other = cells.nodes[k];
        if (other < node || seen[other] == node) continue;
        seen[other] = node;
        pattern.neighbours.push_back(other);
      }
    }
    // What only equations, masses or springs hold.
    if (own == static_cast<std::ptrdiff_t>(pattern.neighbours.size()) && cells.node_dofs[node] > 0)
      pattern.neighbours.push_back(node);
    std::sort(pattern.neighbours.begin() + own, pattern.neighbours.end());
    if (pattern.neighbours.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
      throw std::length_error("the mesh has too many elements");
    pattern.begin.push_back(static_cast<int>(pattern.neighbours.size()));
  }

  pattern.rows_before.resize(pattern.neighbours.size());
  for (int node = 0; node < nodes; ++node) {
    int rows = 0;
    for (int k = pattern.begin[node]; k < pattern.begin[node + 1]; ++k) {
      pattern.rows_before[k] = rows;
      rows += cells.node_dofs[pattern.neighbours[k]];
    }
  }
  return pattern;
}

Eigen::SparseMatrix<double> empty_matrix(const BlockPattern& pattern, BlockKind kind) {
  const int nodes = static_cast<int>(pattern.begin.size()) - 1;
  const int dofs = pattern.first_dof[nodes];
  Eigen::SparseMatrix<double> matrix(dofs, dofs);
  std::int64_t entries = 0;
  for (int node = 0; node < nodes; ++node)
    for (int dof = pattern.first_dof[node]; dof < pattern.first_dof[node + 1]; ++dof) {
      matrix.outerIndexPtr()[dof] = static_cast<int>(entries);
      entries += column_size(pattern, kind, node, dof - pattern.first_dof[node]);
      if (entries > std::numeric_limits<int>::max())
        throw std::length_error("the assembled matrix has more than 2^31 - 1 entries");
    }
  matrix.outerIndexPtr()[dofs] = static_cast<int>(entries);
  matrix.resizeNonZeros(entries);
  std::fill_n(matrix.valuePtr(), entries, 0.0);

  int* row = matrix.innerIndexPtr();
  for (int node = 0; node < nodes; ++node)
    for (int dof = pattern.first_dof[node]; dof < pattern.first_dof[node + 1]; ++dof)
      for (int k = pattern.begin[node]; k < pattern.begin[node + 1]; ++k) {
        const int begin = pattern.first_dof[pattern.neighbours[k]];
        const int end = pattern.first_dof[pattern.neighbours[k] + 1];
        const int column = dof - pattern.first_dof[node];
        if (kind == BlockKind::full)
          for (int r = std::max(begin, dof); r < end; ++r) *row++ = r;
        else if (begin + column < end)
          *row++ = begin + column;
      }
  return matrix;
}

int neighbour_place(const BlockPattern& pattern, int node, int neighbour) {
  const auto begin = pattern.neighbours.begin() + pattern.begin[node];
  const auto end = pattern.neighbours.begin() + pattern.begin[node + 1];
  return static_cast<int>(std::lower_bound(begin, end, neighbour) - begin);
}

}  // namespace mimbre::fe
