#pragma once
#include <Eigen/SparseCore>
#include <cstdint>
#include <string>
#include <vector>

#include "mimbre/diagnostics.h"
#include "mimbre/fe_import.h"

namespace mimbre::fe {

/// Row or column of a matrix while it is read: its dof in one number, which ascends with nodes and
/// directions.
inline int dof_key(const Dof& dof) { return 6 * dof.node + dof.direction; }
inline Dof dof_of_key(int key) { return {key / 6, key % 6}; }

/// Entries of a symmetric matrix in any order, of one triangle or of both, 16 bytes each.
class SymmetricEntries {
 public:
  struct Entry {
    int column, row;  ///< dof_key, row ≥ column
    double value;
  };

  void add(int row, int column, double value) {
    if (row >= column)
      lower_.push_back({column, row, value});
    else
      upper_.push_back({row, column, value});
  }
  /// Keys of the rows and columns that occur, ascending, each once.
  std::vector<int> keys() const;

  enum class Repeated { refused, summed };
  enum class Stored {
    triangle,  ///< each entry once, in either triangle, or the same in both
    full       ///< both triangles, unless one is empty: an entry without its mirror image is an error
  };
  /// The lower triangle over the dofs `keys`, ascending; the entries are used up. Throws InputError at `mark`
  /// when the two triangles differ, when an entry is there twice (`refused`), and at keys not in `keys`.
  Eigen::SparseMatrix<double> build(const std::vector<int>& keys, Repeated repeated, Stored stored,
                                    const Mark& mark, const SolidMesh& mesh);

 private:
  std::vector<Entry> lower_, upper_;  ///< upper mirrored
};

/// Matrices over explicit dofs (`rows`, sorted here) or, when empty, over all that occur.
struct MatrixEntries {
  SymmetricEntries stiffness, mass;
};
ImportedMatrices finish_matrices(SolidMesh mesh, std::vector<Diagnostic> warnings, MatrixEntries entries,
                                 std::vector<Dof> rows, SymmetricEntries::Repeated repeated,
                                 SymmetricEntries::Stored stiffness_stored,
                                 SymmetricEntries::Stored mass_stored, const Mark& stiffness,
                                 const Mark& mass, const FileUnits& units);

/// Checks that no dof occurs twice.
void check_unique(const std::vector<Dof>& dofs, const SolidMesh& mesh, const Mark& mark);

/// Multiplies by `factor`, and rows and columns of rotations by `length`.
void scale(Eigen::SparseMatrix<double>& matrix, const std::vector<Dof>& dofs, double factor, double length);

}  // namespace mimbre::fe
