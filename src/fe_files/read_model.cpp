#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <stdexcept>

#include "fe_files/inp/inp_lines.h"
#include "fe_files/inp/inp_model.h"
#include "fe_files/mesh_formats.h"
#include "fe_files/nastran/nastran.h"
#include "fe_files/text.h"
#include "mimbre/fe_import.h"

namespace mimbre::fe {
namespace {

namespace fs = std::filesystem;

FeModel model_of(ImportedMatrices read) {
  return {std::move(read.mesh), std::move(read.matrices), std::move(read.file_dofs),
          std::move(read.warnings)};
}

void add_materials(SolidMesh& mesh, const std::vector<NamedMaterial>& materials) {
  for (const NamedMaterial& material : materials) {
    const int index = static_cast<int>(mesh.materials.size());
    mesh.materials.push_back(material);
    if (material.name.empty()) mesh.materials.back().name = "material";
    bool used = false;
    for (ElementGroup& group : mesh.groups)
      if (material.name.empty() ? group.material < 0 : group.name == material.name) {
        group.material = index;
        used = true;
      }
    if (!used && !material.name.empty())
      throw std::invalid_argument(
          fmt::format("--material: no elements belong to a group '{}'", material.name));
  }
}

bool is_nastran(const std::string& ending) {
  return ending == ".pch" || ending == ".dmig" || ending == ".bdf" || ending == ".dat" || ending == ".nas";
}

/// The value that goes with a name, or with none; marks it as used.
const double* value_for(const std::string& name, const std::vector<NamedNumber>& given,
                        std::vector<char>& used) {
  used.resize(given.size(), 0);
  const double* value = nullptr;
  for (std::size_t k = 0; k < given.size(); ++k)
    if (given[k].name.empty() ? value == nullptr : lower(given[k].name) == lower(name)) {
      value = &given[k].value;
      used[k] = 1;
    }
  return value;
}

void require_used(const char* option, const char* what, const std::vector<NamedNumber>& given,
                  const std::vector<char>& used) {
  for (std::size_t k = 0; k < given.size(); ++k)
    if (k >= used.size() || !used[k])
      throw std::invalid_argument(
          given[k].name.empty() ? fmt::format("{}: every {} has its own", option, what)
                                : fmt::format("{}: no {} '{}' is without", option, what, given[k].name));
}

void add_densities(SolidMesh& mesh, const std::vector<NamedNumber>& given) {
  std::vector<char> used;
  for (const NamedNumber& number : given)
    if (!(number.value > 0) || !std::isfinite(number.value))
      throw std::invalid_argument(fmt::format("--density must be positive, is {}", number.value));
  for (NamedMaterial& named : mesh.materials)
    if (named.material.density == 0)
      if (const double* density = value_for(named.name, given, used)) named.material.density = *density;
  for (BeamElement& beam : mesh.beams)  // of those without a name here: their materials are copies
    if (beam.material.density == 0 && beam.material.young > 0)
      for (const NamedMaterial& named : mesh.materials)
        if (named.material.young == beam.material.young && named.material.poisson == beam.material.poisson)
          beam.material.density = named.material.density;
  require_used("--density", "material", given, used);
}

/// Point masses may be all the mass that a model has.
void require_densities(const SolidMesh& mesh) {
  const auto require = [](double density, const std::string& what) {
    if (density == 0)
      throw std::invalid_argument(
          fmt::format("{} has no density; --density [MATERIAL=]RHO gives it one, in kg/m³", what));
  };
  if (mesh.point_masses.empty())
    for (const ElementGroup& group : mesh.groups)
      if (group.material >= 0 && !group.nodes.empty()) {
        const NamedMaterial& named = mesh.materials[static_cast<std::size_t>(group.material)];
        require(named.material.density, fmt::format("material '{}'", named.name));
      }
  for (const BeamElement& beam : mesh.beams)
    if (beam.material.young > 0) require(beam.material.density, "the material of a beam");
}

void add_thicknesses(SolidMesh& mesh, const std::vector<NamedNumber>& given) {
  std::vector<char> used;
  for (const NamedNumber& number : given)
    if (!(number.value > 0) || !std::isfinite(number.value))
      throw std::invalid_argument(fmt::format("--thickness must be positive, is {}", number.value));
  for (ElementGroup& group : mesh.groups)
    if (is_shell(group.type) && group.thickness == 0)
      if (const double* thickness = value_for(group.name, given, used)) group.thickness = *thickness;
  require_used("--thickness", "group of shells", given, used);
  for (const ElementGroup& group : mesh.groups)
    if (is_shell(group.type) && group.thickness == 0)
      throw std::invalid_argument(fmt::format(
          "the shells '{}' have no thickness; --thickness [GROUP=]T gives them one, in m", group.name));
}

/// The torsion constant of a quadratic brick across each section.
void expand_beams(SolidMesh& mesh) {
  if (mesh.beams.empty())
    throw std::invalid_argument("--beam-torsion brick: the file has no beams with sections");
  for (BeamElement& beam : mesh.beams) {
    Section& section = beam.section;
    if (section.Iy > 0 && section.Iz > 0) section.J = 4 * section.Iy * section.Iz / (section.Iy + section.Iz);
  }
}

FeModel assembled(const std::string& path, ImportedMesh read, const FeCompanions& companions) {
  add_materials(read.mesh, companions.materials);
  add_densities(read.mesh, companions.densities);
  add_thicknesses(read.mesh, companions.thicknesses);
  if (companions.beam_torsion == BeamTorsion::brick) expand_beams(read.mesh);
  std::erase_if(read.warnings, [&](const Diagnostic& warning) {
    return !companions.densities.empty() && warning.message.ends_with("has no *DENSITY");
  });
  std::vector<Diagnostic> lacking;
  std::copy_if(read.warnings.begin(), read.warnings.end(), std::back_inserter(lacking),
               [](const Diagnostic& warning) { return warning.message.ends_with(no_elasticity); });
  if (!lacking.empty()) throw InputError(std::move(lacking));
  try {
    require_densities(read.mesh);
    FeMatrices matrices = assemble(read.mesh);
    if (matrices.dofs.empty()) throw std::invalid_argument("has no elements");
    return {std::move(read.mesh), std::move(matrices), {}, std::move(read.warnings)};
  } catch (const std::invalid_argument& error) {
    throw InputError(Mark{path}, error.what());
  }
}

/// Those that CalculiX writes beside its input.
std::vector<std::string> matrices_beside(const std::string& path) {
  std::vector<std::string> files;
  for (const char* ending : {".sti", ".mas", ".dof"})
    files.push_back(fs::path(path).replace_extension(ending).string());
  return files;
}

bool all_exist(const std::vector<std::string>& files) {
  for (const std::string& file : files)
    if (!fs::exists(file)) return false;
  return true;
}

}  // namespace

FeModel read_model(const std::string& path, const FeCompanions& companions, const FileUnits& units) {
  const std::string ending = lower(fs::path(path).extension().string());
  const bool matrices = ending == ".inp" && all_exist(matrices_beside(path));
  if (companions.beam_torsion == BeamTorsion::brick && (ending != ".inp" || matrices))
    throw std::invalid_argument(
        "--beam-torsion brick is for beams of an .inp file without matrices beside it");
  if (matrices) return model_of(read_calculix_matrices(path, units));
  if (find_mesh_format(path)) return assembled(path, read_mesh(path, units), companions);
  if (ending == ".mtx" || ending == ".npz") {
    if (companions.mass.empty() || companions.nodes.empty())
      throw std::invalid_argument("a stiffness matrix needs --mass FILE and --nodes FILE beside it");
    return model_of(read_sparse_matrices(path, companions.mass, companions.nodes, companions.dofs, units));
  }
  if (is_nastran(ending)) {
    if (companions.nodes.empty())
      if (std::optional<ImportedMesh> mesh = read_nastran(path, units))
        return assembled(path, std::move(*mesh), companions);
    return model_of(read_nastran_dmig(path, companions.nodes, "", "", units));
  }
  throw std::invalid_argument(fmt::format("'{}': the ending '{}' is not known", path, ending));
}

std::vector<std::string> files_beside(const std::string& inp_path) {
  const std::string ending = lower(fs::path(inp_path).extension().string());
  if (is_nastran(ending)) return nastran_includes(inp_path);
  if (ending != ".inp") return {};
  std::vector<std::string> files;
  for (const std::string& file : matrices_beside(inp_path))
    if (fs::exists(file)) files.push_back(file);
  InpLines lines(std::make_unique<TextFile>(inp_path), fs::path(inp_path).parent_path().string(), true);
  InpKeyword keyword;
  while (lines.next_keyword(keyword)) {
  }
  files.insert(files.end(), lines.included().begin(), lines.included().end());
  return files;
}

}  // namespace mimbre::fe
