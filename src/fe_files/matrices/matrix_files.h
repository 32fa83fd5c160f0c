#pragma once
#include <Eigen/Core>
#include <string>

#include "base/zip_file.h"
#include "fe_files/matrices/symmetric_entries.h"
#include "fe_files/text_file.h"

namespace mimbre::fe {

/// Dofs of the rows from a table beside the matrices or, without one, `rows` shared evenly among the nodes.
std::vector<Dof> dofs_of_rows(const std::string& dofs_path, std::int64_t rows, const SolidMesh& mesh,
                              const Mark& matrix);

/// Which triangles of a matrix a file has, by its own order of rows.
struct Triangles {
  bool lower = false, upper = false;

  void note(std::int64_t row, std::int64_t column) {
    lower = lower || row > column;
    upper = upper || row < column;
  }
};

/// Matrix Market's coordinate text.
struct MatrixMarketHead {
  bool symmetric = false;
  std::int64_t rows = 0, entries = 0;
};
MatrixMarketHead parse_matrix_market_head(TextFile& file);
SymmetricEntries parse_matrix_market_entries(TextFile& file, const MatrixMarketHead& head,
                                             const std::vector<Dof>& rows, Triangles& triangles);

/// Whether Abaqus' matrix file names nodes and dofs; otherwise it has rows and columns.
bool abaqus_is_labelled(TextFile& file);
SymmetricEntries parse_abaqus_labelled(TextFile& file, const SolidMesh& mesh);
SymmetricEntries parse_abaqus_coordinates(TextFile& file, const std::vector<Dof>& rows);
std::int64_t count_abaqus_rows(TextFile& file);

/// SciPy's save_npz as bytes: a ZIP of arrays.
struct SparseFile {
  std::int64_t rows = 0, columns = 0;
  std::vector<int> row, column;  ///< of each entry
  std::vector<double> value;
};
/// A square matrix; the second one of any shape.
SparseFile parse_npz(std::string bytes, const std::string& name);
SparseFile parse_any_npz(std::string bytes, const std::string& name);

/// An array of such an archive as numbers; one of one dimension is a column. Throws InputError for others.
Eigen::MatrixXd npz_matrix(const ZipFile& zip, const std::string& member, const std::string& name);

}  // namespace mimbre::fe
