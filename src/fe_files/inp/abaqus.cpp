#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "fe_files/matrices/matrix_files.h"
#include "fe_files/text.h"

// Format: Abaqus Analysis User's Guide, "Generating matrices", text output in the "matrix input" and the
// "coordinate" form.

namespace mimbre::fe {

namespace {

bool holds_no_entry(std::string_view line) {
  line = trimmed(line);
  return line.empty() || line.starts_with("*") || line.starts_with("%");
}

struct Coordinates {
  std::int64_t row, column;
  double value;
};

/// `row column value`, or the same with commas.
Coordinates coordinates(std::string_view line, const TextFile& file) {
  std::string_view rest = line;
  const bool commas = line.find(',') != std::string_view::npos;
  const auto cut = [&] { return commas ? next_field(rest) : next_word(rest); };
  const auto row = to_integer(cut()), column = to_integer(cut());
  const auto value = to_real(cut());
  if (!row || !column || !value || !trimmed(rest).empty())
    file.fail(
        fmt::format("'{}' is no entry: 'row column value' (or 'row node, dof, column node, dof, value') "
                    "is needed",
                    shown(line)));
  if (*row < 1 || *column < 1) file.fail("rows and columns count from 1");
  return {*row, *column, *value};
}

}  // namespace

bool abaqus_is_labelled(TextFile& file) {
  std::string_view line;
  while (file.next(line)) {
    if (holds_no_entry(line)) continue;
    file.put_back();
    return std::count(line.begin(), line.end(), ',') >= 4;
  }
  file.fail("has no entries");
}

SymmetricEntries parse_abaqus_labelled(TextFile& file, const SolidMesh& mesh) {
  std::unordered_map<std::int64_t, int> by_label;
  for (std::size_t i = 0; i < mesh.labels.size(); ++i) by_label.emplace(mesh.labels[i], static_cast<int>(i));
  SymmetricEntries entries;
  const auto key = [&](std::string_view& rest, std::string_view line) {
    const auto label = to_integer(next_field(rest)), direction = to_integer(next_field(rest));
    if (!label || !direction)
      file.fail(
          fmt::format("'{}' is no entry: 'row node, dof, column node, dof, value' is needed", shown(line)));
    if (*label <= 0)
      file.fail(
          fmt::format("node {} is internal to an element; only nodes of the mesh can have dofs", *label));
    if (*direction < 1 || *direction > 6)
      file.fail(
          fmt::format("dof {} of node {}: only 1 to 6 are displacements and rotations", *direction, *label));
    const auto node = by_label.find(*label);
    if (node == by_label.end()) file.fail(fmt::format("node {} is not there", *label));
    return dof_key({node->second, static_cast<int>(*direction) - 1});
  };
  std::string_view line;
  while (file.next(line)) {
    if (holds_no_entry(line)) continue;
    std::string_view rest = line;
    const int row = key(rest, line), column = key(rest, line);
    const auto value = to_real(next_field(rest));
    if (!value || !trimmed(rest).empty())
      file.fail(fmt::format("'{}' has no finite value at its end", shown(line)));
    entries.add(row, column, *value);
  }
  return entries;
}

std::int64_t count_abaqus_rows(TextFile& file) {
  std::int64_t rows = 0;
  std::string_view line;
  while (file.next(line)) {
    if (holds_no_entry(line)) continue;
    const Coordinates entry = coordinates(line, file);
    rows = std::max({rows, entry.row, entry.column});
  }
  return rows;
}

SymmetricEntries parse_abaqus_coordinates(TextFile& file, const std::vector<Dof>& rows) {
  SymmetricEntries entries;
  const auto n = static_cast<std::int64_t>(rows.size());
  std::string_view line;
  while (file.next(line)) {
    if (holds_no_entry(line)) continue;
    const auto [row, column, value] = coordinates(line, file);
    if (row > n || column > n)
      file.fail(fmt::format("row or column {} where there are {} dofs", std::max(row, column), n));
    entries.add(dof_key(rows[static_cast<std::size_t>(row - 1)]),
                dof_key(rows[static_cast<std::size_t>(column - 1)]), value);
  }
  return entries;
}

ImportedMatrices read_abaqus_matrices(const std::string& stiffness_path, const std::string& mass_path,
                                      const std::string& nodes_path, const std::string& dofs_path,
                                      const FileUnits& units) {
  ImportedMesh mesh = read_nodes(nodes_path, units);
  TextFile stiffness(stiffness_path);
  TextFile mass(mass_path);
  const bool labelled = abaqus_is_labelled(stiffness);
  if (labelled != abaqus_is_labelled(mass))
    mass.fail("is not of the same form (matrix input or coordinates) as the stiffness");
  MatrixEntries entries;
  std::vector<Dof> rows;
  if (labelled) {
    entries.stiffness = parse_abaqus_labelled(stiffness, mesh.mesh);
    entries.mass = parse_abaqus_labelled(mass, mesh.mesh);
  } else {
    TextFile first_stiffness(stiffness_path), first_mass(mass_path);
    const std::int64_t count = std::max(count_abaqus_rows(first_stiffness), count_abaqus_rows(first_mass));
    rows = dofs_of_rows(dofs_path, count, mesh.mesh, {stiffness_path, 0, 0});
    entries.stiffness = parse_abaqus_coordinates(stiffness, rows);
    entries.mass = parse_abaqus_coordinates(mass, rows);
  }
  return finish_matrices(std::move(mesh.mesh), std::move(mesh.warnings), std::move(entries), std::move(rows),
                         SymmetricEntries::Repeated::refused, SymmetricEntries::Stored::triangle,
                         SymmetricEntries::Stored::triangle, {stiffness_path, 0, 0}, {mass_path, 0, 0},
                         units);
}

}  // namespace mimbre::fe
