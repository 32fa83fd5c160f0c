#include "model_file/sections/surface_files.h"

#include <fmt/format.h>

#include <filesystem>
#include <functional>

#include "model_file/text/file_reader.h"

namespace mimbre::model_file {

namespace {

using Refused = std::function<void(const std::string& file, const InputError&)>;

std::shared_ptr<const SurfaceMesh> read(Builder& builder, const Value& value, const Refused& refused) {
  const auto path = value.word();
  if (!path) return nullptr;
  if (!has_folder(builder, value)) return nullptr;
  const std::string file = path_of(builder, value.mark(), *path);
  if (const auto known = builder.surfaces.find(file); known != builder.surfaces.end() && known->second)
    return known->second;
  builder.other_files.push_back(file);
  try {
    return builder.surfaces[file] = builder.reader->surface(file);
  } catch (const InputError& e) {
    refused(file, e);
  }
  return nullptr;
}

void all_errors(const Value& value, const InputError& e) {
  for (const Diagnostic& d : e.diagnostics()) value.error(to_string(d));
}

}  // namespace

std::shared_ptr<const SurfaceMesh> read_surface_file(Builder& builder, const Value& value) {
  return read(builder, value, [&](const std::string&, const InputError& e) { all_errors(value, e); });
}

std::shared_ptr<const SurfaceMesh> read_drawn_file(Builder& builder, const Value& value) {
  return read(builder, value, [&](const std::string& file, const InputError& e) {
    std::error_code status;
    if (!std::filesystem::is_regular_file(file, status))
      return all_errors(value, e);  // a mistake in the name
    for (const Diagnostic& d : e.diagnostics())
      builder.warnings.push_back({value.mark(), fmt::format("the shape is left out: {}", to_string(d))});
  });
}

Eigen::Vector3d read_scale(const Fields& fields) {
  const auto scale = fields.get("scale");
  if (!scale) return Eigen::Vector3d::Ones();
  const Eigen::Vector3d factors =
      scale->is_list() ? scale->triple().value_or(Eigen::Vector3d::Ones())
                       : Eigen::Vector3d(Eigen::Vector3d::Constant(scale->number().value_or(1)));
  if ((factors.array() != 0).all()) return factors;
  scale->error("is 0; a mesh in millimetres has scale: 0.001");
  return Eigen::Vector3d::Ones();
}

}  // namespace mimbre::model_file
