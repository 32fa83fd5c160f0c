#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>

#include "fe_files/gmsh.h"
#include "fe_files/inp/inp_model.h"
#include "fe_files/mesh_builder.h"
#include "fe_files/node_table.h"
#include "fe_files/text.h"
#include "fe_files/units.h"

namespace mimbre::fe {

namespace {

std::string ending(const std::string& path) {
  return lower(std::filesystem::path(path).extension().string());
}

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

ImportedMesh read_mesh(const std::string& path, const FileUnits& units) {
  const std::string kind = ending(path);
  if (kind == ".msh") return read_gmsh(path, units);
  if (kind == ".inp") return read_inp(path, units);
  throw InputError({path, 0, 0}, "is no mesh by its name: .msh (Gmsh) or .inp (CalculiX, Abaqus) is needed");
}

ImportedMesh read_nodes(const std::string& path, const FileUnits& units) {
  const std::string kind = ending(path);
  if (kind == ".msh" || kind == ".inp") return read_mesh(path, units);
  TextFile file(path);
  return in_si(parse_node_table(file), units);
}

}  // namespace mimbre::fe
