#include "compile/compile_parts.h"
#include "compile/elastodynamic_modes.h"
#include "compile/element_parts.h"
#include "compile/find_scales.h"
#include "compile/image.h"
#include "compile/signals/compile_signals.h"
#include "compile/slow_speeds.h"
#include "mimbre/model.h"
#include "spec/check/check_spec.h"

namespace mimbre {
namespace {

/// Gives each element its place in the workspace.
void place_elements(Compiled& c) {
  c.element_storage = 0;
  for (ElementData& e : c.elements) {
    e.storage = c.element_storage;
    c.element_storage += element_storage(e);
  }
}

/// Builds the flat arrays from the spec and its tree.
std::unique_ptr<const Image> compiled_image(spec::Model& spec) {
  Compiled c;
  c.source = &spec;
  c.gravity = spec.gravity;
  const Topology topology = find_topology(spec);
  compile_bodies(c, topology);
  plan_signals(c);
  const ContactPairs pairs = contact_pairs(spec);
  compile_frames(c, topology, pairs);
  compile_subspaces(c);
  compile_roads(c);
  compile_elements(c, topology);
  compile_contacts(c, pairs);
  place_sensors(
      c, [&](ElementData e) { return add_element(c, std::move(e)); },
      [&](int joint, int coordinate) { return on_coordinate(c, joint, coordinate); });
  compile_sums(c);
  compile_loops(c, topology);
  compile_drives(c);
  compile_constraints(c);
  place_elements(c);
  compile_sparsity(c);
  find_scales(c);
  find_slow_speeds(c);
  return std::make_unique<const Image>(c);
}

}  // namespace

Model::Model(spec::Model model) : spec_(std::move(model)), image_(compiled_image(spec_)) {}
Model::~Model() = default;

std::shared_ptr<const Model> Model::compile(spec::Model model) {
  check_spec(model);
  set_elastodynamic_modes(model);
  return std::shared_ptr<const Model>(new Model(std::move(model)));
}

const Compiled& Model::compiled() const { return image_->model(); }

}  // namespace mimbre
