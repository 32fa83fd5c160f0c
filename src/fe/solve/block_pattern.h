#pragma once
#include <Eigen/SparseCore>
#include <vector>

#include "fe/elements/mesh_cells.h"

/// The structure of assembled matrices by nodes: a block of rows and columns per node, lower triangles.
namespace mimbre::fe {

struct BlockPattern {
  std::vector<int> first_dof;  ///< of each node, and the end
  std::vector<int> begin;      ///< of each node in the two lists, and the end
  std::vector<int>
      neighbours;  ///< nodes that share a cell with it and are not before it, ascending: itself first
  std::vector<int> rows_before;  ///< rows of the neighbours before each neighbour (itself: 0)
};
BlockPattern block_pattern(const MeshCells& cells);

/// What of a node pair's block is not zero.
enum class BlockKind {
  full,
  diagonal  ///< only the entries that join the same direction of both nodes
};

/// Lower triangle with the diagonal, all values zero, columns sorted. Throws std::length_error above 2³¹ − 1
/// entries.
Eigen::SparseMatrix<double> empty_matrix(const BlockPattern& pattern, BlockKind kind);

/// Where `neighbour` (not before `node`) is in the list of the neighbours of `node`, counted from its begin.
int neighbour_place(const BlockPattern& pattern, int node, int neighbour);

/// Adds to the lower triangle the block whose rows are the neighbour's dofs and whose columns are the node's;
/// `entry(row, column)` for row, column < dofs.
template <class Entry>
void add_full_block(Eigen::SparseMatrix<double>& matrix, const BlockPattern& pattern, int node, int place,
                    int dofs, const Entry& entry) {
  const int first = pattern.first_dof[node];
  for (int column = 0; column < dofs; ++column) {
    // The column begins on the diagonal: what is left of the node's own block comes before the neighbours.
    double* values = matrix.valuePtr() + matrix.outerIndexPtr()[first + column] - column +
                     pattern.rows_before[pattern.begin[node] + place];
    for (int row = place == 0 ? column : 0; row < dofs; ++row) values[row] += entry(row, column);
  }
}

/// Adds value · identity (3 × 3) to such a block of a matrix of the given kind.
inline void add_scalar_block(Eigen::SparseMatrix<double>& matrix, const BlockPattern& pattern, BlockKind kind,
                             int node, int place, double value) {
  const int first = pattern.first_dof[node];
  for (int k = 0; k < 3; ++k) {
    const int at = kind == BlockKind::diagonal ? place : pattern.rows_before[pattern.begin[node] + place];
    matrix.valuePtr()[matrix.outerIndexPtr()[first + k] + at] += value;
  }
}

}  // namespace mimbre::fe
