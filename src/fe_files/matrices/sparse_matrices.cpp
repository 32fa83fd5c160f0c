#include <fmt/format.h>

#include <filesystem>

#include "fe_files/matrices/matrix_files.h"
#include "fe_files/node_table.h"
#include "fe_files/text.h"

namespace mimbre::fe {

std::vector<Dof> dofs_of_rows(const std::string& dofs_path, std::int64_t rows, const SolidMesh& mesh,
                              const Mark& matrix) {
  std::vector<Dof> dofs;
  if (!dofs_path.empty()) {
    TextFile file(dofs_path);
    dofs = parse_dof_table(file, mesh);
    if (static_cast<std::int64_t>(dofs.size()) != rows)
      throw InputError(matrix,
                       fmt::format("has {} rows where '{}' has {} dofs", rows, dofs_path, dofs.size()));
    check_unique(dofs, mesh, {dofs_path, 0, 0});
    return dofs;
  }
  const std::int64_t nodes = mesh.nodes.cols();
  if (rows != 3 * nodes && rows != 6 * nodes)
    throw InputError(
        matrix, fmt::format("has {} rows where there are {} nodes: neither 3 nor 6 a node; a table 'row, "
                            "node, direction' is needed",
                            rows, nodes));
  const int per_node = static_cast<int>(rows / nodes);
  for (int node = 0; node < nodes; ++node)
    for (int direction = 0; direction < per_node; ++direction) dofs.push_back({node, direction});
  return dofs;
}

namespace {

struct Matrix {
  SymmetricEntries entries;
  bool full = false;  ///< both triangles are there
};

/// `rows` are found with the first of the two matrices.
Matrix read_matrix(const std::string& path, const std::string& dofs_path, const SolidMesh& mesh,
                   std::vector<Dof>& rows) {
  Matrix matrix;
  Triangles triangles;
  const Mark mark{path, 0, 0};
  const auto need = [&](std::int64_t count) {
    if (rows.empty()) rows = dofs_of_rows(dofs_path, count, mesh, mark);
    if (static_cast<std::int64_t>(rows.size()) != count)
      throw InputError(mark, fmt::format("has {} rows, the stiffness {}", count, rows.size()));
  };
  const std::string kind = lower(std::filesystem::path(path).extension().string());
  if (kind == ".mtx") {
    TextFile file(path);
    const MatrixMarketHead head = parse_matrix_market_head(file);
    need(head.rows);
    matrix.entries = parse_matrix_market_entries(file, head, rows, triangles);
    matrix.full = !head.symmetric && triangles.lower && triangles.upper;
    return matrix;
  }
  if (kind != ".npz")
    throw InputError(mark, "is no sparse matrix by its name: .mtx (Matrix Market) or .npz (SciPy) is needed");
  SparseFile file = parse_npz(read_bytes(path), path);
  need(file.rows);
  for (std::size_t i = 0; i < file.value.size(); ++i) {
    triangles.note(file.row[i], file.column[i]);
    matrix.entries.add(dof_key(rows[static_cast<std::size_t>(file.row[i])]),
                       dof_key(rows[static_cast<std::size_t>(file.column[i])]), file.value[i]);
  }
  matrix.full = triangles.lower && triangles.upper;
  return matrix;
}

}  // namespace

ImportedMatrices read_sparse_matrices(const std::string& stiffness_path, const std::string& mass_path,
                                      const std::string& nodes_path, const std::string& dofs_path,
                                      const FileUnits& units) {
  ImportedMesh mesh = read_nodes(nodes_path, units);
  std::vector<Dof> rows;
  Matrix stiffness = read_matrix(stiffness_path, dofs_path, mesh.mesh, rows);
  Matrix mass = read_matrix(mass_path, dofs_path, mesh.mesh, rows);
  MatrixEntries entries{std::move(stiffness.entries), std::move(mass.entries)};
  const auto stored = [](const Matrix& matrix) {
    return matrix.full ? SymmetricEntries::Stored::full : SymmetricEntries::Stored::triangle;
  };
  return finish_matrices(std::move(mesh.mesh), std::move(mesh.warnings), std::move(entries), std::move(rows),
                         SymmetricEntries::Repeated::summed, stored(stiffness), stored(mass),
                         {stiffness_path, 0, 0}, {mass_path, 0, 0}, units);
}

}  // namespace mimbre::fe
