#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <vector>

#include "fe_files/nastran/nastran_build.h"
#include "fe_files/text.h"

namespace mimbre::fe {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kNothing = 1e-14;  ///< of the largest factor

/// A GRID may stand several times with the same fields, as parts that share nodes have it.
void drop_copies(NastranModel& model) {
  std::unordered_map<std::int64_t, std::size_t> first;
  std::vector<NastranGrid> kept;
  for (const NastranGrid& grid : model.grids) {
    const auto [place, is_new] = first.emplace(grid.label, kept.size());
    const NastranGrid& other = is_new ? grid : kept[place->second];
    if (is_new || other.coordinates != grid.coordinates || other.position_system != grid.position_system ||
        other.displacement_system != grid.displacement_system)
      kept.push_back(grid);
  }
  model.grids = std::move(kept);
}

void place_nodes(NastranBuild& build) {
  NastranModel& model = build.model;
  const auto defaults = model.grid_defaults.value_or(std::pair<std::int64_t, std::int64_t>{0, 0});
  for (NastranGrid& grid : model.grids) {
    if (grid.position_system == -1) grid.position_system = defaults.first;
    if (grid.displacement_system == -2) grid.displacement_system = defaults.second;
  }
  drop_copies(model);
  SolidMesh& mesh = build.mesh;
  mesh.nodes.resize(3, static_cast<Eigen::Index>(model.grids.size()));
  for (std::size_t i = 0; i < model.grids.size(); ++i) {
    const NastranGrid& grid = model.grids[i];
    if (!build.by_label.emplace(grid.label, static_cast<int>(i)).second)
      model.error(model.mark(grid.place),
                  fmt::format("GRID {}: is there already, at another place or in other systems", grid.label));
    mesh.labels.push_back(grid.label);
    build.displacement_systems.push_back(grid.displacement_system);
  }
  try {
    model.systems.resolve([&](std::int64_t label, NastranSystems::GridPlace& place) {
      const auto found = build.by_label.find(label);
      if (found == build.by_label.end()) return false;
      const NastranGrid& grid = model.grids[static_cast<std::size_t>(found->second)];
      place = {grid.position_system, grid.coordinates};
      return true;
    });
  } catch (const InputError& error) {
    for (const Diagnostic& one : error.diagnostics()) model.error(one.mark, one.message);
    throw InputError(std::move(model.errors));
  }
  for (std::size_t i = 0; i < model.grids.size(); ++i) {
    const NastranGrid& grid = model.grids[i];
    build.guarded(fmt::format("GRID {}", grid.label), grid.place, [&] {
      const Mark mark = model.mark(grid.place);
      mesh.nodes.col(static_cast<Eigen::Index>(i)) =
          model.systems.at(grid.position_system, mark).place(grid.coordinates);
      model.systems.at(grid.displacement_system, mark);
    });
  }
  build.rotates.assign(model.grids.size(), 0);
}

/// Whether anything has a density or a mass of its own.
bool deck_has_mass(const NastranModel& model) {
  const auto positive = [](const auto& values, auto mass) {
    return std::any_of(values.begin(), values.end(), [&](const auto& value) { return mass(value) > 0; });
  };
  return positive(model.materials, [](const auto& m) { return m.second.density; }) ||
         positive(model.masses, [](const auto& m) { return m.mass; }) ||
         positive(model.shell_properties, [](const auto& p) { return p.second.mass; }) ||
         positive(model.bar_properties, [](const auto& p) { return p.second.section.mass; }) ||
         !model.scalar_masses.empty();
}

/// Nodes of ranges, in the order of the labels.
std::vector<int> nodes_in(std::vector<NastranRange> ranges,
                          const std::vector<std::pair<std::int64_t, int>>& sorted) {
  std::sort(ranges.begin(), ranges.end());
  std::vector<int> nodes;
  auto from = sorted.begin();
  for (const NastranRange& range : ranges) {
    from = std::lower_bound(from, sorted.end(), std::pair<std::int64_t, int>{range[0], -1});
    for (; from != sorted.end() && from->first <= range[1]; ++from) nodes.push_back(from->second);
  }
  return nodes;
}

void add_set(SolidMesh& mesh, const std::string& name, std::vector<int> nodes) {
  if (nodes.empty()) return;
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  mesh.node_sets.push_back({name, std::move(nodes)});
}

void add_sets(NastranBuild& build) {
  SolidMesh& mesh = build.mesh;
  std::vector<std::pair<std::int64_t, int>> sorted;
  for (std::size_t i = 0; i < build.model.grids.size(); ++i)
    sorted.emplace_back(mesh.labels[i], static_cast<int>(i));
  std::sort(sorted.begin(), sorted.end());
  for (const auto& [name, ranges] : build.model.sets) add_set(mesh, name, nodes_in(ranges, sorted));
  std::map<std::string, std::vector<int>> of_groups;
  for (const ElementGroup& group : mesh.groups) {
    std::vector<int>& nodes = of_groups[group.name];
    nodes.insert(nodes.end(), group.nodes.begin(), group.nodes.end());
  }
  for (auto& [name, nodes] : of_groups) add_set(mesh, name, std::move(nodes));
  for (const NastranRigid& rigid : build.model.rigid) {
    std::vector<int> nodes;
    for (const auto& [label, components] : rigid.followers)
      if (const auto found = build.by_label.find(label); found != build.by_label.end())
        nodes.push_back(found->second);
    add_set(mesh, fmt::format("{}:{}", rigid.card, rigid.label), std::move(nodes));
  }
  for (const NastranMean& mean : build.model.means) {
    std::vector<int> nodes;
    for (const NastranMean::Node& one : mean.nodes)
      if (const auto found = build.by_label.find(one.node); found != build.by_label.end())
        nodes.push_back(found->second);
    add_set(mesh, fmt::format("RBE3:{}", mean.label), std::move(nodes));
  }
}

/// Where other parts have mass, those without are meant so: a share of it that changes nothing keeps the mass
/// matrix positive.
void give_traces_of_mass(NastranBuild& build) {
  constexpr double kTrace = 1e-9;
  SolidMesh& mesh = build.mesh;
  if (!build.has_mass) return;
  double density = 0, mass = 0;
  for (const NamedMaterial& named : mesh.materials) density = std::max(density, named.material.density);
  for (const BeamElement& beam : mesh.beams) density = std::max(density, beam.material.density);
  for (const PointMass& point : mesh.point_masses) mass += point.mass;
  if (density == 0 && mass > 0 && mesh.nodes.cols() > 1) {
    const double size = (mesh.nodes.rowwise().maxCoeff() - mesh.nodes.rowwise().minCoeff()).norm();
    density = mass / (size * size * size);
  }
  for (NamedMaterial& named : mesh.materials) {
    if (named.material.density != 0 || density == 0) continue;
    named.material.density = kTrace * density;
    build.model.warn("no mass", {build.model.files.empty() ? "" : build.model.files.front(), 0, 0},
                     fmt::format("{} has no mass beside others that have; it is taken as {} of the densest",
                                 named.name, kTrace));
  }
}

}  // namespace

NastranBuild::NastranBuild(NastranModel& deck) : model(deck) {
  place_nodes(*this);
  has_mass = deck_has_mass(deck);
}

int NastranBuild::node(std::int64_t label, const NastranPlace& place, const std::string& user) {
  const auto found = by_label.find(label);
  if (found != by_label.end()) return found->second;
  model.error(model.mark(place),
              fmt::format("{}: node {} is {}", user, label,
                          model.is_scalar_point(label) ? "a scalar point, which has no place in a body"
                                                       : "not there"));
  return -1;
}

int NastranBuild::amid(int a, int b) {
  const auto [place, is_new] =
      middles.emplace(std::pair(std::min(a, b), std::max(a, b)), static_cast<int>(mesh.nodes.cols()));
  const int node = place->second;
  if (is_new) {
    mesh.nodes.conservativeResize(3, node + 1);
    mesh.nodes.col(node) = (at(a) + at(b)) / 2;
    mesh.labels.push_back(0);
    rotates.push_back(0);
    for (int d = 0; d < 3; ++d)
      mesh.equations.push_back({"a side without a node amid it", {{node, d, 1}, {a, d, -0.5}, {b, d, -0.5}}});
  }
  return node;
}

Matrix3d NastranBuild::directions(int node, const NastranPlace& place) const {
  // Nodes that pins add have the body's axes.
  if (static_cast<std::size_t>(node) >= displacement_systems.size()) return Matrix3d::Identity();
  return model.systems.at(displacement_systems[static_cast<std::size_t>(node)], model.mark(place))
      .directions(at(node));
}

void NastranBuild::add_translation(int node, const Vector3d& axis, const Vector3d& arm, double factor,
                                   std::vector<LinearTerm>& terms) {
  const Vector3d turn = arm.cross(axis);  // axis · (θ × arm) = θ · (arm × axis)
  for (int k = 0; k < 3; ++k) {
    terms.push_back({node, k, factor * axis[k]});
    terms.push_back({node, 3 + k, factor * turn[k]});
  }
}

void NastranBuild::add_rotation(int node, const Vector3d& axis, double factor,
                                std::vector<LinearTerm>& terms) {
  for (int k = 0; k < 3; ++k) terms.push_back({node, 3 + k, factor * axis[k]});
}

void NastranBuild::add_component(int node, int component, double factor, const NastranPlace& place,
                                 std::vector<LinearTerm>& terms) const {
  const Vector3d axis = directions(node, place).col(component % 3);
  if (component < 3)
    add_translation(node, axis, Vector3d::Zero(), factor, terms);
  else
    add_rotation(node, axis, factor, terms);
}

void NastranBuild::tidy(std::vector<LinearTerm>& terms, bool keep_rotations) const {
  std::vector<LinearTerm> summed;
  std::map<std::pair<int, int>, std::size_t> known;
  double turning = 0, moving = 0;
  for (const LinearTerm& term : terms) {
    if (term.direction >= 3 && !keep_rotations && !rotates[static_cast<std::size_t>(term.node)]) continue;
    const auto [place, is_new] = known.emplace(std::pair(term.node, term.direction), summed.size());
    if (is_new)
      summed.push_back(term);
    else
      summed[place->second].factor += term.factor;
  }
  for (const LinearTerm& term : summed) {
    double& largest = term.direction < 3 ? moving : turning;
    largest = std::max(largest, std::abs(term.factor));
  }
  std::erase_if(summed, [&](const LinearTerm& term) {
    return !(std::abs(term.factor) > kNothing * (term.direction < 3 ? moving : turning));
  });
  terms = std::move(summed);
}

const NastranMaterial& NastranBuild::material(std::int64_t label, const NastranPlace& user) const {
  const auto found = model.materials.find(label);
  if (found != model.materials.end()) return found->second;
  const auto other = model.other_materials.find(label);
  throw InputError(model.mark(user),
                   other == model.other_materials.end()
                       ? fmt::format("material {} is not there", label)
                       : fmt::format("material {} is a {}, which is not linear elastic as read here", label,
                                     other->second));
}

int NastranBuild::mesh_material(const std::string& name, const Material& values,
                                const std::optional<ElasticMatrix>& elastic) {
  const auto [place, is_new] = materials.emplace(name, static_cast<int>(mesh.materials.size()));
  if (is_new) mesh.materials.push_back({name, values, elastic});
  return place->second;
}

std::string NastranBuild::named(const std::string& what, const NastranPlace& place) const {
  return place.file == 0 ? fmt::format("{} of line {}", what, place.line)
                         : fmt::format("{} of {}:{}", what, model.mark(place).file, place.line);
}

void NastranBuild::guarded(const std::string& what, const NastranPlace& place,
                           const std::function<void()>& make) {
  try {
    make();
  } catch (const InputError& error) {
    for (const Diagnostic& one : error.diagnostics())
      model.error(one.mark, fmt::format("{}: {}", what, one.message));
  } catch (const std::invalid_argument& error) {
    model.error(model.mark(place), fmt::format("{}: {}", what, error.what()));
  }
}

ImportedMesh finish_nastran(NastranModel& model) {
  const auto refuse = [&] {
    if (model.errors.empty()) return;
    if (model.more_errors > 0)
      model.errors.push_back({model.errors.back().mark, fmt::format("and {} more", model.more_errors)});
    throw InputError(std::move(model.errors));
  };
  NastranBuild build(model);
  add_nastran_solids(build);
  add_nastran_shells(build);
  add_nastran_bars(build);
  add_nastran_panels(build);
  add_nastran_ties(build);
  settle_nastran_loose_nodes(build);
  add_sets(build);
  give_traces_of_mass(build);
  refuse();
  if (model.errors.empty() && build.mesh.groups.empty() && build.mesh.beams.empty() &&
      build.mesh.springs.empty())
    throw InputError({model.files.empty() ? std::string() : model.files.front(), 0, 0},
                     "has neither elements nor DMIG matrices");
  ImportedMesh result;
  result.mesh = std::move(build.mesh);
  result.warnings = std::move(model.warnings);
  return result;
}

}  // namespace mimbre::fe
