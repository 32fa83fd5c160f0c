#include "fe_files/bodies/user_modes_file.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <set>
#include <unordered_map>
#include <utility>

#include "base/zip_file.h"
#include "fe_files/matrices/matrix_files.h"
#include "fe_files/node_table.h"
#include "fe_files/text.h"
#include "fe_files/text_file.h"

namespace mimbre::fe {
namespace {

/// Rows as they come, with the checks that all formats share.
class Rows {
 public:
  explicit Rows(const SolidMesh& mesh) {
    for (std::size_t i = 0; i < mesh.labels.size(); ++i)
      by_label_.emplace(mesh.labels[i], static_cast<int>(i));
  }

  /// What is wrong with the row, or nothing.
  std::string add(std::int64_t label, int direction) {
    const auto node = by_label_.find(label);
    if (node == by_label_.end()) return fmt::format("node {} is not there", label);
    if (!seen_.insert({node->second, direction}).second)
      return fmt::format("direction {} of node {} is there twice", direction + 1, label);
    dofs.push_back({node->second, direction});
    return {};
  }

  std::vector<Dof> dofs;

 private:
  std::unordered_map<std::int64_t, int> by_label_;
  std::set<std::pair<int, int>> seen_;
};

std::vector<std::string_view> fields_of(std::string_view line) {
  const char separator = line.find(';') != std::string_view::npos   ? ';'
                         : line.find(',') != std::string_view::npos ? ','
                                                                    : ' ';
  std::vector<std::string_view> fields;
  while (!trimmed(line).empty())
    fields.push_back(separator == ' ' ? next_word(line) : next_field(line, separator));
  return fields;
}

}  // namespace

UserModes parse_user_modes(TextFile& file, const SolidMesh& mesh) {
  Rows rows(mesh);
  std::vector<double> values;
  std::size_t modes = 0;
  std::string_view line;
  bool first = true;
  while (file.next(line)) {
    if (trimmed(line).empty() || trimmed(line).starts_with('#')) continue;
    const std::vector<std::string_view> fields = fields_of(line);
    const auto label = fields.empty() ? std::nullopt : to_integer(fields[0]);
    if (std::exchange(first, false) && !fields.empty() && !to_real(fields[0])) continue;  // heading
    const int direction = fields.size() > 1 ? direction_of(fields[1]) : -1;
    if (!label || direction < 0 || fields.size() < 3)
      file.fail(
          fmt::format("'{}' is no row of modes: node, direction (1-6 or x y z rx ry rz) and a "
                      "displacement for each mode are needed",
                      shown(trimmed(line))));
    if (modes == 0) modes = fields.size() - 2;
    if (fields.size() - 2 != modes)
      file.fail(fmt::format("has {} displacements where the rows before have {}", fields.size() - 2, modes));
    if (const std::string wrong = rows.add(*label, direction); !wrong.empty()) file.fail(wrong);
    for (std::size_t k = 2; k < fields.size(); ++k) {
      const auto value = to_real(fields[k]);
      if (!value || !std::isfinite(*value)) file.fail(fmt::format("'{}' is no number", shown(fields[k])));
      values.push_back(*value);
    }
  }
  if (rows.dofs.empty()) file.fail("has no modes: lines 'node, direction, displacements' are needed");
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  UserModes result{std::move(rows.dofs), {}};
  result.shapes = Eigen::Map<const RowMajor>(values.data(), static_cast<Eigen::Index>(result.dofs.size()),
                                             static_cast<Eigen::Index>(modes));
  return result;
}

UserModes parse_user_modes_npz(std::string bytes, const std::string& path, const SolidMesh& mesh) {
  const ZipFile zip(std::move(bytes), path);
  const auto fail = [&](const std::string& message) { throw InputError({path, 0, 0}, message); };
  for (const char* member : {"label", "direction", "shapes"})
    if (!zip.has(std::string(member) + ".npy"))
      fail(fmt::format("has no array '{}': label, direction and shapes are needed", member));
  const Eigen::MatrixXd label = npz_matrix(zip, "label", path),
                        direction = npz_matrix(zip, "direction", path);
  UserModes result{{}, npz_matrix(zip, "shapes", path)};
  if (label.size() == 0 || label.cols() != 1 || direction.rows() != label.rows() || direction.cols() != 1 ||
      result.shapes.rows() != label.rows() || result.shapes.cols() < 1)
    fail(
        fmt::format("has arrays of {} labels, {} directions and {} x {} displacements: a row of each is "
                    "needed for every displacement",
                    label.size(), direction.size(), result.shapes.rows(), result.shapes.cols()));
  if (!result.shapes.allFinite()) fail("has displacements that are not finite");
  Rows rows(mesh);
  for (Eigen::Index r = 0; r < label.rows(); ++r) {
    const double d = direction(r, 0);
    if (!(std::abs(label(r, 0)) < 9e15))
      fail(fmt::format("has the label {} where a node's number is needed", label(r, 0)));
    if (!(d == 1 || d == 2 || d == 3 || d == 4 || d == 5 || d == 6))
      fail(fmt::format("has the direction {} where 1 to 6 are possible", d));
    if (const std::string wrong = rows.add(static_cast<std::int64_t>(label(r, 0)), static_cast<int>(d) - 1);
        !wrong.empty())
      fail(wrong);
  }
  result.dofs = std::move(rows.dofs);
  return result;
}

namespace {

UserModes read(const std::string& path, const SolidMesh& mesh) {
  if (lower(std::filesystem::path(path).extension().string()) == ".npz")
    return parse_user_modes_npz(read_bytes(path), path, mesh);
  TextFile file(path);
  return parse_user_modes(file, mesh);
}

}  // namespace

UserModes read_user_modes(const std::string& path, const SolidMesh& mesh, const FileUnits& units) {
  UserModes modes = read(path, mesh);
  for (std::size_t r = 0; r < modes.dofs.size(); ++r)
    if (modes.dofs[r].direction < 3) modes.shapes.row(static_cast<Eigen::Index>(r)) *= units.length;
  for (Eigen::Index k = 0; k < modes.shapes.cols(); ++k)
    if (modes.shapes.col(k).isZero(0))
      throw InputError({path, 0, 0}, fmt::format("mode {} moves nothing", k + 1));
  return modes;
}

}  // namespace mimbre::fe
