#include "fe_files/node_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "fe_files/mesh_builder.h"
#include "fe_files/text.h"

namespace mimbre::fe {

namespace {

/// Fields of a line of CSV, whose separator is what the line has.
template <std::size_t count>
bool split(std::string_view line, std::array<std::string_view, count>& fields) {
  const char separator = line.find(';') != std::string_view::npos   ? ';'
                         : line.find(',') != std::string_view::npos ? ','
                                                                    : ' ';
  for (std::string_view& field : fields)
    field = separator == ' ' ? next_word(line) : next_field(line, separator);
  return trimmed(line).empty() && !fields.back().empty();
}

bool holds_no_node(std::string_view line) {
  line = trimmed(line);
  return line.empty() || line.starts_with('#');
}

}  // namespace

int direction_of(std::string_view field) {
  if (const auto number = to_integer(field))
    return *number >= 1 && *number <= 6 ? static_cast<int>(*number) - 1 : -1;
  constexpr std::string_view names[] = {"x", "y", "z", "rx", "ry", "rz"};
  const std::string name = lower(field);
  for (int i = 0; i < 6; ++i)
    if (name == names[i]) return i;
  return -1;
}

ImportedMesh parse_node_table(TextFile& file) {
  NodeTable nodes;
  std::string_view line;
  std::array<std::string_view, 4> fields;
  bool first = true;
  while (file.next(line)) {
    if (holds_no_node(line)) continue;
    const bool good = split(line, fields);
    const auto label = good ? to_integer(fields[0]) : std::nullopt;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    bool numbers = label.has_value();
    for (std::size_t i = 0; i < 3 && numbers; ++i) {
      const auto value = to_real(fields[i + 1]);
      numbers = value.has_value();
      if (value) position(static_cast<int>(i)) = *value;
    }
    const bool heading = first && good && !to_real(fields[0]);
    first = false;
    if (heading) continue;
    if (!numbers) file.fail(fmt::format("'{}' is no node: label, x, y, z are needed", shown(trimmed(line))));
    nodes.add(*label, position, file);
  }
  if (nodes.size() == 0) file.fail("has no nodes: lines 'label, x, y, z' are needed");
  ImportedMesh result;
  nodes.move_into(result.mesh);
  return result;
}

std::vector<Dof> parse_dof_table(TextFile& file, const SolidMesh& mesh) {
  std::unordered_map<std::int64_t, int> by_label;
  for (std::size_t i = 0; i < mesh.labels.size(); ++i) by_label.emplace(mesh.labels[i], static_cast<int>(i));
  struct Row {
    std::int64_t row;
    Dof dof;
  };
  std::vector<Row> rows;
  std::string_view line;
  std::array<std::string_view, 3> fields;
  bool first = true;
  while (file.next(line)) {
    if (holds_no_node(line)) continue;
    const bool good = split(line, fields);
    const auto row = good ? to_integer(fields[0]) : std::nullopt;
    const auto label = good ? to_integer(fields[1]) : std::nullopt;
    const int direction = good ? direction_of(fields[2]) : -1;
    const bool heading = first && good && !row;
    first = false;
    if (heading) continue;
    if (!row || !label || direction < 0)
      file.fail(fmt::format("'{}' is no dof: row, node, direction (1-6 or x y z rx ry rz) are needed",
                            shown(trimmed(line))));
    const auto node = by_label.find(*label);
    if (node == by_label.end()) file.fail(fmt::format("node {} is not there", *label));
    rows.push_back({*row, {node->second, direction}});
  }
  if (rows.empty()) file.fail("has no dofs: lines 'row, node, direction' are needed");
  std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.row < b.row; });
  const std::int64_t base = rows.front().row;
  if (base != 0 && base != 1)
    file.fail(fmt::format("the first row is {}; rows count from 0 or from 1", base));
  std::vector<Dof> dofs;
  for (const Row& row : rows) {
    const std::int64_t right = base + static_cast<std::int64_t>(dofs.size());
    if (row.row != right)
      file.fail(row.row < right ? fmt::format("row {} is there twice", row.row)
                                : fmt::format("row {} is missing", right));
    dofs.push_back(row.dof);
  }
  return dofs;
}

}  // namespace mimbre::fe
