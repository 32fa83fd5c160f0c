#include "model_file/text/parse.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "model_file/sections/contacts.h"
#include "model_file/sections/elements.h"
#include "model_file/sections/fmu_block.h"
#include "model_file/sections/signals.h"
#include "model_file/text/builder.h"
#include "model_file/text/degrees.h"
#include "model_file/text/includes.h"
#include "model_file/text/parameters.h"
#include "model_file/text/repeats.h"

namespace mimbre::model_file {
namespace {

void check_version(const Fields& fields) {
  const auto version = fields.get("mimbre");
  if (!version) return fields.error("'mimbre: 1' is missing, the version of the format");
  const auto number = version->number();
  if (number && *number != 1)
    version->error(
        fmt::format("format version {} is not known; this program reads version 1", version->tree().text));
}

/// Whether some are given, right or wrong.
bool has_bodies(const Part& part) {
  const auto section = part.section("bodies");
  if (!section) return false;
  return section->is_map() ? !section->tree().entries.empty() : !section->is_null();
}

void warn_unused(Builder& builder) {
  const Part& model = builder.parts.front();
  const auto warn = [&](const std::string& section, const std::string& kind,
                        const std::set<std::string>& used) {
    if (const Tree::Entry* entry = model.tree->find(section))
      for (const auto& item : entry->value->entries)
        if (!used.contains(item.key))
          builder.warnings.push_back({item.mark, fmt::format("{} '{}' is not used", kind, item.key)});
  };
  std::set<std::string> roads, templates;
  for (const auto& [name, content] : model.templates)
    if (builder.placed_templates.contains(content.tree.get()) || content.mark.file != builder.model.file)
      templates.insert(name);  // an included file may have more than is needed
  for (const spec::Tyre& tyre : builder.model.tyres)
    roads.insert(builder.model.roads[static_cast<std::size_t>(tyre.road)].name);
  for (const spec::Constraint& constraint : builder.model.constraints)
    if (constraint.road >= 0)
      roads.insert(builder.model.roads[static_cast<std::size_t>(constraint.road)].name);
  warn("roads", "road", roads);
  warn("subsystems", "subsystem", templates);
  if (builder.model.outputs.empty())
    builder.warnings.push_back({model.tree->mark, "there are no outputs, so a CSV file has only the time"});
}

}  // namespace

spec::Model parse_by(const FileReader& files, const std::string& text, const std::string& name,
                     const std::string& directory, const std::map<std::string, std::string>& overrides,
                     std::vector<Diagnostic>* warnings, const Limits& limits,
                     std::vector<std::string>* other_files, std::vector<DeclaredParameter>* declared) {
  Builder builder(limits, files);
  builder.directory = directory;
  builder.model.file = name;
  builder.model.text = text;

  Part& model = builder.parts.emplace_back();
  model.reading = {&model.scope, &builder.errors, &builder.limits};
  model.written = with_includes(builder, files.model(text, name, builder.limits, builder.errors.list));
  model.tree = model.written;
  const Fields fields(
      Value(model.reading, *model.written, "model"),
      with_element_sections(
          {"mimbre", "title", "include", "gravity", "parameters", "require", "materials", "sections",
           "bodies", "frames", "joints", "constraints", "springs", "loads", "roads", "tyres", "surfaces",
           "contacts", "neglected_inertia"},
          {"inputs", "signals", "events", "subsystems", "instances", "outputs", "initial", "simulation"}));
  if (!fields.value().is_map()) builder.errors.throw_if_any();
  check_version(fields);

  if (const auto parameters = model.section("parameters"))
    read_parameters(*parameters, overrides, model.scope, declared);
  report_unknown(overrides, model.scope, model.reading);
  if (const auto require = model.section("require")) read_requirements(*require);
  model.tree = written_out(model.written, model.reading, model.instance);
  if (const auto title = fields.get("title")) builder.model.title = title->text().value_or("");
  if (const auto gravity = fields.get("gravity"))
    builder.model.gravity = gravity->triple(quantity::acceleration).value_or(builder.model.gravity);

  read_instances(builder);
  for (Part& part : builder.parts) read_inputs(builder, part);
  for (Part& part : builder.parts) claim_signals(builder, part);
  for (Part& part : builder.parts) claim_outputs(builder, part);
  read_roads(builder, model);
  for (Part& part : builder.parts) read_materials_and_sections(builder, part);
  for (Part& part : builder.parts) read_bodies(builder, part);
  for (Part& part : builder.parts) read_frames(builder, part);
  for (Part& part : builder.parts) read_joints(builder, part);
  add_floating_joints(builder);
  check_inertias(builder);
  for (Part& part : builder.parts) read_constraints(builder, part);
  for (Part& part : builder.parts) read_springs(builder, part);
  for (Part& part : builder.parts) read_loads(builder, part);
  for (Part& part : builder.parts) read_tyres(builder, part);
  for (Part& part : builder.parts) read_elements(builder, part);
  for (Part& part : builder.parts) read_surfaces(builder, part);
  for (Part& part : builder.parts) read_contacts(builder, part);
  read_outputs(builder);
  for (Part& part : builder.parts) read_signals(builder, part);
  for (Part& part : builder.parts) read_events(builder, part);
  resolve_sensors(builder);
  read_simulation(builder, model);
  complete_fmu_intervals(builder.model);
  const bool refused =
      !builder.errors.list.empty() && std::any_of(builder.parts.begin(), builder.parts.end(), has_bodies);
  if (builder.model.bodies.empty() && !refused)
    builder.errors.add(model.tree->mark, "the model has no body; add one under 'bodies'");
  builder.errors.throw_if_any();

  warn_of_loaded_nodes(builder);
  warn_of_degrees(builder);
  split_bodies(builder);
  segment_bodies(builder);
  read_neglected_inertia(builder, model);
  builder.errors.throw_if_any();
  reduce_bodies(builder);
  builder.errors.throw_if_any();
  warn_unused(builder);
  if (warnings) warnings->insert(warnings->end(), builder.warnings.begin(), builder.warnings.end());
  if (other_files) *other_files = std::move(builder.other_files);
  return std::move(builder.model);
}

}  // namespace mimbre::model_file
