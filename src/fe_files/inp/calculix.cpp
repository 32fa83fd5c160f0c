#include "fe_files/inp/calculix.h"

#include <fmt/format.h>

#include <filesystem>
#include <unordered_map>

#include "fe_files/text.h"
#include "fe_files/units.h"

// Format: CalculiX CrunchiX user's manual, *FREQUENCY (SOLVER=MATRIXSTORAGE), checked against version 2.20.

namespace mimbre::fe {

std::vector<Dof> parse_calculix_dofs(TextFile& file, const SolidMesh& mesh) {
  std::unordered_map<std::int64_t, int> by_label;
  for (std::size_t i = 0; i < mesh.labels.size(); ++i) by_label.emplace(mesh.labels[i], static_cast<int>(i));
  std::vector<Dof> dofs;
  std::string_view line;
  while (file.next(line)) {
    line = trimmed(line);
    if (line.empty()) continue;
    const std::size_t point = line.find('.');
    const auto label = to_integer(line.substr(0, point));
    const auto direction =
        point == std::string_view::npos ? std::nullopt : to_integer(line.substr(point + 1));
    if (!label || !direction)
      file.fail(fmt::format("'{}' is no dof: node.direction is needed, as in 12.3", shown(line)));
    if (*direction < 1 || *direction > 3)
      file.fail(
          fmt::format("direction {} of node {}: only 1, 2 and 3 are displacements", *direction, *label));
    const auto node = by_label.find(*label);
    if (node == by_label.end())
      file.fail(fmt::format(
          "node {} is not in the input file; CalculiX adds nodes to shells, beams and C3D8I: mesh "
          "the body with C3D4, C3D10, C3D8, C3D20, C3D6 or C3D15",
          *label));
    dofs.push_back({node->second, static_cast<int>(*direction) - 1});
  }
  if (dofs.empty()) file.fail("has no dofs: lines 'node.direction' are needed");
  check_unique(dofs, mesh, {file.name(), 0, 0});
  return dofs;
}

SymmetricEntries parse_calculix_matrix(TextFile& file, const std::vector<Dof>& rows) {
  const auto n = static_cast<std::int64_t>(rows.size());
  SymmetricEntries entries;
  std::string_view line;
  std::int64_t last = 0;
  while (file.next(line)) {
    std::string_view rest = line;
    const auto row = to_integer(next_word(rest));
    if (!row && trimmed(line).empty()) continue;
    const auto column = to_integer(next_word(rest));
    const auto value = to_real(next_word(rest));
    if (!row || !column || !value || !trimmed(rest).empty())
      file.fail(fmt::format("'{}' is no entry: row, column and a finite value are needed", shown(line)));
    if (*row < 1 || *column < 1) file.fail("rows and columns count from 1");
    if (*row > n || *column > n)
      file.fail(fmt::format(
          "row or column {} where the .dof file has {} dofs: the files are not of one run, or the "
          "model is cyclically symmetric, which doubles the matrix and is not read",
          std::max(*row, *column), n));
    last = std::max(last, std::max(*row, *column));
    if (*value == 0 && *row != *column) continue;
    entries.add(dof_key(rows[static_cast<std::size_t>(*row - 1)]),
                dof_key(rows[static_cast<std::size_t>(*column - 1)]), *value);
  }
  if (last != n) file.fail(fmt::format("ends at row {} of {}: the file is not whole", last, n));
  return entries;
}

ImportedMatrices read_calculix_matrices(const std::string& inp_path, const FileUnits& units) {
  const auto neighbour = [&](const char* ending) {
    const std::string path = std::filesystem::path(inp_path).replace_extension(ending).string();
    if (!std::filesystem::exists(path))
      throw InputError({path, 0, 0},
                       "is not there; CalculiX writes it in a step with *FREQUENCY, SOLVER=MATRIXSTORAGE");
    return path;
  };
  if (lower(std::filesystem::path(inp_path).extension().string()) != ".inp")
    throw InputError({inp_path, 0, 0},
                     "the input file (.inp) is needed; .sti, .mas and .dof must be in the same folder");
  ImportedMesh mesh = read_inp(inp_path, units);
  TextFile dof_file(neighbour(".dof"));
  TextFile stiffness(neighbour(".sti"));
  TextFile mass(neighbour(".mas"));
  const std::vector<Dof> rows = parse_calculix_dofs(dof_file, mesh.mesh);
  MatrixEntries entries;
  entries.stiffness = parse_calculix_matrix(stiffness, rows);
  entries.mass = parse_calculix_matrix(mass, rows);
  return finish_matrices(std::move(mesh.mesh), std::move(mesh.warnings), std::move(entries), rows,
                         SymmetricEntries::Repeated::refused, SymmetricEntries::Stored::triangle,
                         SymmetricEntries::Stored::triangle, {stiffness.name(), 0, 0}, {mass.name(), 0, 0},
                         units);
}

Eigen::SparseMatrix<double> read_calculix_geometric_stiffness(const std::string& str_path,
                                                              const std::string& dof_path,
                                                              const ImportedMatrices& matrices,
                                                              const FileUnits& units) {
  check(units);
  TextFile dof_file(dof_path);
  TextFile file(str_path);
  const std::vector<Dof> rows = parse_calculix_dofs(dof_file, matrices.mesh);
  SymmetricEntries entries = parse_calculix_matrix(file, rows);
  std::vector<int> keys;
  for (const Dof& dof : matrices.matrices.dofs) keys.push_back(dof_key(dof));
  Eigen::SparseMatrix<double> result =
      entries.build(keys, SymmetricEntries::Repeated::refused, SymmetricEntries::Stored::triangle,
                    {str_path, 0, 0}, matrices.mesh);
  scale(result, matrices.matrices.dofs, -units.mass / (units.time * units.time), units.length);
  return result;
}

}  // namespace mimbre::fe
