#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>

#include "fe_files/gmsh.h"
#include "fe_files/inp/inp_model.h"
#include "fe_files/mesh_builder.h"
#include "fe_files/mesh_formats.h"
#include "fe_files/node_table.h"
#include "fe_files/text.h"
#include "fe_files/units.h"

namespace mimbre::fe {

namespace {

ImportedMesh in_si(ImportedMesh mesh, const FileUnits& units) {
  check(units);
  scale(mesh.mesh, units.length, units.mass, units.time);
  return mesh;
}

}  // namespace

void check(const FileUnits& units) {
  for (const double unit : {units.length, units.mass, units.time})
    if (!(unit > 0) || !std::isfinite(unit)) throw std::invalid_argument("units of a file must be positive");
}

ImportedMesh read_gmsh(const std::string& path, const FileUnits& units) {
  TextFile file(path);
  return in_si(parse_gmsh(file), units);
}

ImportedMesh read_inp(const std::string& path, const FileUnits& units) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return in_si(parse_inp(std::make_unique<TextFile>(path), folder, true), units);
}

const MeshFormat* find_mesh_format(const std::string& path) {
  const std::string ending = lower(std::filesystem::path(path).extension().string());
  for (const MeshFormat* format : mesh_formats)
    if (format->ending == ending) return format;
  return nullptr;
}

std::string mesh_formats_help() {
  std::string lines;
  for (const MeshFormat* format : mesh_formats)
    lines += fmt::format("  {:<22}{}\n", format->ending, format->help);
  return lines;
}

ImportedMesh read_mesh(const std::string& path, const FileUnits& units) {
  if (const MeshFormat* format = find_mesh_format(path))
    return in_si(
        format->parse(std::make_unique<TextFile>(path), std::filesystem::path(path).parent_path().string()),
        units);
  std::string known;
  for (const MeshFormat* format : mesh_formats)
    known += fmt::format("{}{} ({})", known.empty() ? "" : " or ", format->ending, format->program);
  throw InputError({path, 0, 0}, fmt::format("is no mesh by its name: {} is needed", known));
}

ImportedMesh read_nodes(const std::string& path, const FileUnits& units) {
  if (find_mesh_format(path)) return read_mesh(path, units);
  TextFile file(path);
  return in_si(parse_node_table(file), units);
}

}  // namespace mimbre::fe
