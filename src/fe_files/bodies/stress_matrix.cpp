#include "fe_files/bodies/stress_matrix.h"

#include <fmt/format.h>

#include <filesystem>
#include <numeric>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "fe_files/matrices/matrix_files.h"
#include "fe_files/text.h"
#include "fe_files/units.h"

namespace mimbre::fe {

std::vector<int> parse_stress_nodes(TextFile& file, const SolidMesh& mesh) {
  std::unordered_map<std::int64_t, int> by_label;
  for (std::size_t i = 0; i < mesh.labels.size(); ++i) by_label.emplace(mesh.labels[i], static_cast<int>(i));
  std::vector<int> nodes;
  std::unordered_set<int> seen;
  std::string_view line;
  bool first = true;
  while (file.next(line)) {
    line = trimmed(line);
    if (line.empty() || line.starts_with('#')) continue;
    const std::string_view field = line.substr(0, line.find_first_of(",; \t"));
    const auto label = to_integer(field);
    if (std::exchange(first, false) && !label && !to_real(field)) continue;  // heading
    if (!label) file.fail(fmt::format("'{}' is no label of a node", shown(field)));
    const auto node = by_label.find(*label);
    if (node == by_label.end()) file.fail(fmt::format("node {} is not there", *label));
    if (!seen.insert(node->second).second) file.fail(fmt::format("node {} is there twice", *label));
    nodes.push_back(node->second);
  }
  if (nodes.empty()) file.fail("has no nodes: a label on each line is needed");
  return nodes;
}

StressMatrix parse_stress_matrix(std::string bytes, const std::string& name, std::vector<int> nodes,
                                 const SolidMesh& mesh, const FeMatrices& matrices,
                                 const std::vector<Dof>& columns, const FileUnits& units) {
  check(units);
  const Mark mark{name, 0, 0};
  const SparseFile file = parse_any_npz(std::move(bytes), name);
  const bool all = nodes.empty();
  if (all) {
    nodes.resize(static_cast<std::size_t>(mesh.nodes.cols()));
    std::iota(nodes.begin(), nodes.end(), 0);
  }
  const auto count = static_cast<std::int64_t>(nodes.size());
  if (file.rows != 6 * count)
    throw InputError(mark,
                     fmt::format("has {} rows where {} {} nodes need {}, six of each{}", file.rows,
                                 all ? "the model's" : "the table's", count, 6 * count,
                                 all ? "; a table of the nodes that the rows belong to may be given" : ""));
  const std::vector<Dof>& dofs = columns.empty() ? matrices.dofs : columns;
  if (file.columns != static_cast<std::int64_t>(dofs.size()))
    throw InputError(mark,
                     fmt::format("has {} columns where the model has {} dofs", file.columns, dofs.size()));
  std::unordered_map<int, int> by_dof;
  for (std::size_t r = 0; r < matrices.dofs.size(); ++r)
    by_dof.emplace(dof_key(matrices.dofs[r]), static_cast<int>(r));
  std::vector<int> column_of;
  for (const Dof& dof : dofs) {
    const auto found = by_dof.find(dof_key(dof));
    if (found == by_dof.end())
      throw InputError(mark, "has columns of dofs that the model's matrices do not have");
    column_of.push_back(found->second);
  }
  const double pascal = units.mass / (units.length * units.time * units.time);
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(file.value.size());
  for (std::size_t i = 0; i < file.value.size(); ++i) {
    const auto column = static_cast<std::size_t>(file.column[i]);
    entries.emplace_back(file.row[i], column_of[column],
                         file.value[i] * (dofs[column].direction < 3 ? pascal / units.length : pascal));
  }
  StressMatrix result;
  result.matrix.resize(file.rows, file.columns);
  result.matrix.setFromTriplets(entries.begin(), entries.end());
  result.nodes = std::move(nodes);
  return result;
}

StressMatrix read_stress_matrix(const std::string& path, const std::string& nodes_path, const SolidMesh& mesh,
                                const FeMatrices& matrices, const std::vector<Dof>& columns,
                                const FileUnits& units) {
  if (lower(std::filesystem::path(path).extension().string()) != ".npz")
    throw InputError({path, 0, 0}, "is no sparse matrix by its name: .npz (SciPy) is needed");
  std::vector<int> nodes;
  if (!nodes_path.empty()) {
    TextFile table(nodes_path);
    nodes = parse_stress_nodes(table, mesh);
  }
  return parse_stress_matrix(read_bytes(path), path, std::move(nodes), mesh, matrices, columns, units);
}

}  // namespace mimbre::fe
