#include "fe_files/mesh_builder.h"

#include <fmt/format.h>

#include <algorithm>

#include "fe_files/text.h"

namespace mimbre::fe {

namespace {

/// Six times as many dofs still have int indices.
constexpr std::size_t kMostNodes = 350'000'000;

}  // namespace

int NodeTable::add(std::int64_t label, const Eigen::Vector3d& position, const TextFile& file) {
  const int index = size();
  if (!by_label_.emplace(label, index).second) file.fail(fmt::format("node {} is there already", label));
  if (labels_.size() >= kMostNodes) file.fail(fmt::format("has more than {} nodes", kMostNodes));
  positions_.push_back(position);
  labels_.push_back(label);
  return index;
}

int NodeTable::find(std::int64_t label) const {
  const auto found = by_label_.find(label);
  return found == by_label_.end() ? -1 : found->second;
}

int NodeTable::at(std::int64_t label, const TextFile& file, const char* user, std::int64_t user_label) const {
  const int index = find(label);
  if (index < 0)
    file.fail(fmt::format("node {} of {} {} is not there (nodes must come before their first use)", label,
                          user, user_label));
  return index;
}

void NodeTable::move_into(SolidMesh& mesh) {
  mesh.nodes.resize(3, size());
  for (int i = 0; i < size(); ++i) mesh.nodes.col(i) = positions_[static_cast<std::size_t>(i)];
  mesh.labels = std::move(labels_);
  positions_ = {};
  by_label_ = {};
}

std::vector<int>& NodeSets::operator[](const std::string& name) {
  const auto [place, is_new] = by_name_.emplace(lower(name), static_cast<int>(sets_.size()));
  if (is_new) sets_.push_back({name, {}});
  return sets_[static_cast<std::size_t>(place->second)].nodes;
}

const std::vector<int>* NodeSets::find(const std::string& name) const {
  const auto found = by_name_.find(lower(name));
  return found == by_name_.end() ? nullptr : &sets_[static_cast<std::size_t>(found->second)].nodes;
}

void NodeSets::move_into(SolidMesh& mesh) {
  for (NodeSet& set : sets_) {
    std::sort(set.nodes.begin(), set.nodes.end());
    set.nodes.erase(std::unique(set.nodes.begin(), set.nodes.end()), set.nodes.end());
    set.nodes.shrink_to_fit();
  }
  mesh.node_sets = std::move(sets_);
}

void scale(SolidMesh& mesh, double length, double mass, double time) {
  const double area = length * length;
  const auto to_si = [&](Material& material) {
    material.young *= mass / (length * time * time);
    material.density *= mass / (area * length);
  };
  mesh.nodes *= length;
  for (ElementGroup& group : mesh.groups) {
    group.thickness *= length;
    group.offset *= length;
  }
  for (NamedMaterial& named : mesh.materials) {
    to_si(named.material);
    if (named.elastic) *named.elastic *= mass / (length * time * time);
  }
  for (Orientation& orientation : mesh.orientations) orientation.origin *= length;
  for (PointMass& point : mesh.point_masses) {
    point.mass *= mass;
    point.inertia *= mass * area;
    point.offset *= length;
  }
  // Rotations among displacements have the unit of length in their factors; alone they have none.
  const auto rotates = [](const LinearTerm& term) { return term.direction >= 3; };
  const auto to_length = [&](std::vector<LinearTerm>& terms) {
    const bool all = std::all_of(terms.begin(), terms.end(), rotates);
    for (LinearTerm& term : terms)
      if (!all && rotates(term)) term.factor *= length;
    return !all;
  };
  for (Spring& spring : mesh.springs)
    spring.stiffness *= mass / (time * time) * (to_length(spring.stretch) ? 1 : area);
  for (Equation& equation : mesh.equations) to_length(equation.terms);
  for (BeamElement& beam : mesh.beams) {
    to_si(beam.material);
    for (Eigen::Vector3d& offset : beam.offsets) offset *= length;
    for (double* size : {&beam.section.area, &beam.section.shear_y, &beam.section.shear_z}) *size *= area;
    for (double* reach : {&beam.section.reach_y, &beam.section.reach_z}) *reach *= length;
    beam.section.torsion_modulus *= area * length;
    for (double* moment : {&beam.section.Iy, &beam.section.Iz, &beam.section.J}) *moment *= area * area;
  }
}

}  // namespace mimbre::fe
