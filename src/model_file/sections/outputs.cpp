#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "joints/joint_kind.h"
#include "mimbre/reduced_body.h"
#include "model_file/sections/signals.h"
#include "model_file/text/builder.h"
#include "spec/output_words.h"

/// Channels of the CSV file.
namespace mimbre::model_file {
namespace {

using Of = OutputInfo::Of;
using Place = OutputInfo::Place;

/// Commas and quotes would break the columns of a CSV file.
bool check_output_name(const Value& value, const std::string& name) {
  const bool good = !name.empty() && name.size() <= 100 && std::all_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) >= 0x20 && c != ',' && c != '"' && c != 0x7f;
  });
  if (!good)
    value.error(fmt::format("'{}' is no name of a column; it has 1 to 100 characters, no comma and no quote",
                            name.substr(0, 100)));
  if (name == "t") value.error("'t' is the column of the time; choose another name");
  return good && name != "t";
}

/// "x" or 0: an index among `words`.
int read_component(const Fields& fields, const std::vector<std::string>& words) {
  const auto component = fields.need("component", words.front());
  if (!component) return 0;
  if (component->is_scalar() && component->tree().text.find_first_not_of("0123456789") == std::string::npos)
    return component->integer(0, static_cast<int>(words.size()) - 1).value_or(0);
  return component->choice(words).value_or(0);
}

void read_words(const OutputInfo& kind, const Fields& fields, spec::Output& output) {
  if (kind.otherwise >= 0 && !fields.has("component"))
    output.component = kind.otherwise;
  else
    output.component = read_component(fields, {kind.words.begin(), kind.words.end()});
}

void read_joint_component(const Builder& builder, const OutputInfo& kind, const Fields& fields,
                          spec::Output& output) {
  const JointInfo& info = joint_info(builder.model.joints[static_cast<std::size_t>(output.item)].type);
  const int count = kind.count ? kind.count(info) : 0;
  if (kind.count && count == 0) return fields.error(fmt::format("a {} joint {}", info.name, kind.without));
  if (!kind.words.empty()) return read_words(kind, fields, output);
  if (const auto component = fields.get("component"))
    output.component = component->integer(0, count - 1).value_or(0);
  else if (count > 1)
    fields.error(fmt::format("the joint has {} coordinates; choose one: component: 0", count));
  if (kind.offset)
    output.offset = fields.number("offset", 0,
                                  is_angle(info.type, output.component) ? quantity::angle : quantity::length);
}

/// The frame from which a displacement is seen, and where that frame sees the undeformed place.
void read_reference(Builder& builder, const Part& part, const Fields& fields, spec::Output& output) {
  const auto named = fields.need("relative_to", "hub");
  if (!named) return;
  if (named->is_scalar() && named->tree().text == "ground")
    return named->error("the ground has no axes of its own here; name a frame of it, or use 'position'");
  output.reference = attach(builder, part, *named, {}, fmt::format("{}.reference", output.name));
  if (output.reference < 0) return;
  see_from(output, builder.global_pose(output.reference), builder.global_pose(output.item).position);
}

/// The node of the body's surface at `at`, or of the number `node` in its mesh.
void read_surface_node(const Builder& builder, const Part& part, const Fields& fields,
                       const ReducedBody& body, spec::Output& output) {
  if (const auto node = fields.get("node")) {
    const auto label = node->integer(0, std::numeric_limits<int>::max());
    if (!label) return;
    const SurfaceNode found = surface_node(body, *label);
    if (!found.fault.empty()) return node->error(found.fault);
    output.node = found.node;
    return;
  }
  const auto at = fields.get("at");
  const auto point = at ? at->triple(quantity::length) : std::nullopt;
  if (!point) return;
  const SurfaceNode found = surface_node(body, builder.body_pose(output.item), part.place.point(*point));
  if (!found.fault.empty()) at->error(found.fault);
  output.node = found.node;
}

/// Which component of a body's stress or strain, or which direction, and where; without a place its extreme
/// over the surface.
void read_at_surface(Builder& builder, const Part& part, const OutputInfo& kind, const Fields& fields,
                     const Value& named, spec::Output& output) {
  const auto along = kind.along ? fields.get("along") : std::nullopt;
  if (along) {
    if (fields.has("component")) along->error("give 'along' or 'component', not both");
    const spec::Pose pose = builder.body_pose(output.item);
    output.direction =
        pose.rotation.transpose() * part.place.vector(along->direction().value_or(Eigen::Vector3d::UnitX()));
  } else {
    read_words(kind, fields, output);
  }
  if (fields.has("node") && fields.has("at")) fields.error("give 'node' or 'at', not both");
  const auto& body = builder.model.bodies[static_cast<std::size_t>(output.item)].flexible;
  if (!body) {
    const BodyInfo& info = builder.bodies[static_cast<std::size_t>(output.item)];
    if (info.description)
      named.error("bodies made of bars have no stress modes; a body that 'mimbre reduce' made has them");
    else
      builder.warnings.push_back(
          {named.mark(),
           fmt::format("body '{}' is rigid: output '{}' is 0 always",
                       builder.model.bodies[static_cast<std::size_t>(output.item)].name, output.name)});
    return;
  }
  if (body->stress.size() == 0)
    return named.error("the body's file has no stress modes; reduce its model again, with its elements");
  read_surface_node(builder, part, fields, *body, output);
}

/// Bodies made of bars, with modes, in one piece have section forces; their reduction has to keep them.
bool ask_for_sections(Builder& builder, const Value& named, int body) {
  BodyInfo& info = builder.bodies[static_cast<std::size_t>(body)];
  if (info.failed) return false;
  if (!info.description || info.description->kind != BeamKind::reduced || info.description->in_pieces()) {
    named.error(
        "has no section forces: they are those of a flexible body made of bars, with modes, in one piece");
    return false;
  }
  info.description->options.sections = true;
  return true;
}

/// A force or moment in a section at a node of the bars, or the stress by them. The bar that ends there,
/// where one does; else the one that begins.
void read_at_section(Builder& builder, const Part& part, const OutputInfo& kind, const Fields& fields,
                     const Value& named, spec::Output& output) {
  read_words(kind, fields, output);
  const auto at = fields.need("at", "[0.5, 0, 0]");
  const auto point = at ? at->triple(quantity::length) : std::nullopt;
  if (!point || !ask_for_sections(builder, named, output.item)) return;
  const BodyInfo& info = builder.bodies[static_cast<std::size_t>(output.item)];
  const spec::Pose pose = builder.body_pose(output.item);
  const Eigen::Vector3d local = pose.rotation.transpose() * (part.place.point(*point) - pose.position);
  const fe::Mesh& mesh = info.description->mesh;
  Eigen::Index node = 0;
  const double off = (mesh.nodes.colwise() - local).colwise().norm().minCoeff(&node);
  for (std::size_t e = 0; e < mesh.elements.size() && output.node < 0; ++e)
    if (mesh.elements[e].nodes[1] == node) output.node = static_cast<int>(2 * e + 1);
  for (std::size_t e = 0; e < mesh.elements.size() && output.node < 0; ++e)
    if (mesh.elements[e].nodes[0] == node) output.node = static_cast<int>(2 * e);
  const double element =
      std::sqrt((mesh.nodes.colwise() - mesh.nodes.col(node))
                    .colwise()
                    .squaredNorm()
                    .unaryExpr([](double d) { return d > 0 ? d : std::numeric_limits<double>::max(); })
                    .minCoeff());
  const Eigen::Vector3d nearest = pose.position + pose.rotation * mesh.nodes.col(node);
  if (off > 0.51 * element)
    return at->error(
        fmt::format("is {:.3g} m away from the nearest node of the bars, {}", off, to_text(nearest)));
  if (off > 1e-6 * element)
    builder.warnings.push_back(
        {at->mark(),
         fmt::format("output '{}': the section is that at the nearest node, {}; more elements have "
                     "more nodes",
                     output.name, to_text(nearest))});
}

/// A body, a list of bodies, or `all` of the model.
void read_several_bodies(Builder& builder, const Part& part, const Value& named, spec::Output& output) {
  const bool is_list = named.is_list();
  if (!is_list && named.is_scalar() && named.tree().text == "all" &&
      builder.known(builder.body_names, part, "all") < 0)
    return;
  const std::vector<Value> values = is_list ? named.list() : std::vector{named};
  if (values.empty()) return named.error("names no body; a body, a list of bodies, or all");
  bool with_mass = false;
  for (const Value& value : values) {
    const auto name = value.word();
    const int body = name ? builder.resolve(builder.body_names, part, *name, value) : -1;
    if (body < 0) return;
    if (std::find(output.bodies.begin(), output.bodies.end(), body) != output.bodies.end())
      return value.error(fmt::format("body '{}' is named twice", *name));
    output.bodies.push_back(body);
    const BodyInfo& info = builder.bodies[static_cast<std::size_t>(body)];
    with_mass = with_mass || info.failed || info.flexible ||
                builder.model.bodies[static_cast<std::size_t>(body)].mass > 0;
  }
  if (!with_mass) named.error("has no mass, and so neither a centre of mass nor momentum");
}

/// What is of the motion of a body's mass: along which axis, and angular momentum about what.
void read_motion_of_mass(Builder& builder, const Part& part, const OutputInfo& kind, const Fields& fields,
                         const Value& named, spec::Output& output) {
  read_words(kind, fields, output);
  read_several_bodies(builder, part, named, output);
  const auto about = fields.get("about");
  if (!about || !kind.about) return;
  if (const auto point = about->triple(quantity::length)) output.about = part.place.point(*point);
}

/// Of all spheres, or of one body.
void read_body_of_contact(Builder& builder, const Part& part, const Fields& fields, spec::Output& output) {
  const auto on = fields.get("on");
  const auto name = on ? on->word() : std::nullopt;
  if (!name) return;
  if (const int body = builder.resolve(builder.body_names, part, *name, *on); body >= 0)
    output.bodies = {body};
}

void read_mode(const Builder& builder, const Fields& fields, const Value& named, spec::Output& output) {
  const BodyInfo& info = builder.bodies[static_cast<std::size_t>(output.item)];
  const auto& loaded = builder.model.bodies[static_cast<std::size_t>(output.item)].flexible;
  const int modes = loaded ? loaded->modes : info.description ? mode_count(*info.description) : 0;
  const auto component = fields.need("component", "0");
  if (info.failed) return;
  if (modes == 0)
    named.error(fmt::format("body '{}' is rigid and has no modes", named.tree().text));
  else if (component)
    output.component = component->integer(0, modes - 1).value_or(0);
}

void read_of_frame(Builder& builder, const Part& part, const OutputInfo& kind, const Fields& fields,
                   const Value& named, spec::Output& output) {
  output.item = attach(builder, part, named, fields.get("at"), fmt::format("{}.output", output.name));
  if (output.item < 0) return;
  const int body = builder.model.frames[static_cast<std::size_t>(output.item)].body;
  if (!kind.words.empty()) read_words(kind, fields, output);
  if (const auto axes = fields.get("axes"); axes && kind.own_axes)
    output.own_axes = axes->choice({"global", "own"}).value_or(0) == 1;
  if (kind.reference) read_reference(builder, part, fields, output);
  if (!kind.along) return;
  const auto along = fields.need("along", "[0, 0, 1]");
  const auto direction = along ? along->direction() : std::nullopt;
  output.direction = builder.body_pose(body).rotation.transpose() *
                     part.place.vector(direction.value_or(Eigen::Vector3d::UnitZ()));
}

const Names& names_of(const Builder& builder, Of of) {
  return of == Of::joint    ? builder.joint_names
         : of == Of::body   ? builder.body_names
         : of == Of::spring ? builder.spring_names
         : of == Of::tyre   ? builder.tyre_names
                            : builder.contact_names;
}

void read_item(Builder& builder, const Part& part, const Fields& fields, const OutputInfo& kind,
               const Value& named, spec::Output& output) {
  if (kind.of == Of::bodies) return read_motion_of_mass(builder, part, kind, fields, named, output);
  if (kind.of == Of::frame) return read_of_frame(builder, part, kind, fields, named, output);
  const auto name = named.word();
  if (!name) return;
  output.item = builder.resolve(names_of(builder, kind.of), part, *name, named);
  if (output.item < 0) return;
  if (kind.of == Of::joint) return read_joint_component(builder, kind, fields, output);
  if (kind.modes) return read_mode(builder, fields, named, output);
  if (kind.place == Place::surface) return read_at_surface(builder, part, kind, fields, named, output);
  if (kind.place == Place::section) return read_at_section(builder, part, kind, fields, named, output);
  if (!kind.words.empty()) read_words(kind, fields, output);
  if (kind.of == Of::contact) read_body_of_contact(builder, part, fields, output);
}

/// Those that have a key.
std::vector<const OutputInfo*> kinds_in_files() {
  std::vector<const OutputInfo*> kinds;
  for (const OutputInfo* kind : all_outputs())
    if (kind->in_files) kinds.push_back(kind);
  return kinds;
}

/// Those whose keys are given.
std::vector<const OutputInfo*> given_kinds(const Fields& fields) {
  std::vector<const OutputInfo*> kinds = kinds_in_files();
  std::erase_if(kinds, [&](const OutputInfo* kind) { return !fields.has(std::string(kind->name)); });
  return kinds;
}

/// These keys and those of all outputs.
std::vector<std::string> keys_with(std::vector<std::string> keys) {
  keys.insert(keys.end(),
              {"at", "component", "along", "offset", "relative_to", "node", "axes", "about", "on"});
  for (const OutputInfo* kind : kinds_in_files()) keys.emplace_back(kind->name);
  return keys;
}

void check_used(const Fields& fields, const OutputInfo& kind) {
  for (const std::string& fault : unused_keys(kind, [&](const std::string& key) { return fields.has(key); }))
    fields.error(fault);
}

void add_output(Builder& builder, const Part& part, const Value& named, spec::Output output) {
  const int index = static_cast<int>(builder.model.outputs.size());
  if (!builder.output_names.index.emplace(output.name, index).second)
    named.error(
        fmt::format("there are two outputs called '{}'; {}", output.name,
                    part.instance.empty() ? "rename one" : "in a template the name needs {instance}"));
  builder.model.outputs.push_back(std::move(output));
}

/// Without a place: an output for each section of all bars, NAME.BAR.ELEMENT.start or end, and each
/// component, or the one that is named. Of a section whose shape is not known there is no stress.
void add_all_sections(Builder& builder, const Part& part, const Fields& fields, const Value& given_name,
                      const Value& body, const spec::Output& named) {
  const std::vector<std::string> words{section_components.begin(), section_components.end()};
  const int first = fields.has("component") ? read_component(fields, words) : 0,
            last = fields.has("component") ? first : static_cast<int>(words.size()) - 1;
  const auto name = body.word();
  const int item = name ? builder.resolve(builder.body_names, part, *name, body) : -1;
  if (item < 0 || !ask_for_sections(builder, body, item)) return;
  const auto& elements = builder.bodies[static_cast<std::size_t>(item)].description->mesh.elements;
  int number = 0;  // of the element in its bar
  for (std::size_t e = 0; e < elements.size(); ++e) {
    number = e > 0 && elements[e - 1].bar == elements[e].bar ? number + 1 : 1;
    for (const bool end : {false, true})
      for (int component = first; component <= last; ++component) {
        if (component == von_mises_of_section && !(elements[e].section.torsion_modulus > 0)) continue;
        spec::Output output = named;
        output.name = fmt::format("{}.{}.{}.{}.{}", named.name, elements[e].bar, number,
                                  end ? "end" : "start", words[static_cast<std::size_t>(component)]);
        output.item = item;
        output.node = static_cast<int>(2 * e) + (end ? 1 : 0);
        output.component = component;
        add_output(builder, part, given_name, std::move(output));
      }
  }
}

void read_output(Builder& builder, const Part& part, const Value& value) {
  const Fields fields(value, keys_with({"name"}));
  if (!value.has_fields()) return;
  const auto given_name = fields.need("name", "chassis.z");
  const auto text = given_name ? given_name->text() : std::nullopt;
  spec::Output output;
  output.mark = value.mark();
  if (text && text->size() <= 1000) output.name = instance_name(*text, part.instance);

  const std::vector<const OutputInfo*> given = given_kinds(fields);
  if (given.size() != 1) {
    std::vector<std::string> words;
    for (const OutputInfo* kind : kinds_in_files()) words.emplace_back(kind->name);
    value.error(fmt::format("specifies {} to measure; exactly one of {}",
                            given.empty() ? "nothing" : "several items", joined(words)));
    return;
  }
  const OutputInfo& kind = *given.front();
  const std::string key(kind.name);
  if (!text || !check_output_name(*given_name, output.name)) return;
  check_used(fields, kind);
  output.kind = key;
  if (kind.place == Place::section && !fields.has("at"))
    return add_all_sections(builder, part, fields, *given_name, *fields.get(key), output);
  read_item(builder, part, fields, kind, *fields.get(key), output);
  add_output(builder, part, *given_name, std::move(output));
}

}  // namespace

std::string instance_name(std::string text, const std::string& instance) {
  const std::string placeholder = "{instance}";
  for (auto at = text.find(placeholder); at != std::string::npos;
       at = text.find(placeholder, at + instance.size()))
    text.replace(at, placeholder.size(), instance);
  return text;
}

bool read_sensor(Builder& builder, const Part& part, const Value& value, spec::Output& output) {
  const Fields fields(value, keys_with({"unit", "every"}));
  const std::vector<const OutputInfo*> given = given_kinds(fields);
  if (given.size() != 1) {
    value.error(given.empty()
                    ? "specifies nothing to measure: 'value' with an expression, or what an output would be, "
                      "for example joint: hinge"
                    : "specifies several items to measure; keep one");
    return false;
  }
  const std::string key(given.front()->name);
  output.kind = key;
  check_used(fields, *given.front());
  read_item(builder, part, fields, *given.front(), *fields.get(key), output);
  return true;
}

void read_outputs(Builder& builder) {
  Part& model = builder.parts.front();
  if (const auto section = model.section("outputs"))
    for (const Value& value : section->list()) read_output(builder, model, value);

  // A template's outputs: each for all of its instances before the next, as columns are compared.
  std::vector<std::vector<const Part*>> groups;
  std::unordered_map<const Tree*, std::size_t> group_of;
  for (const Part& part : builder.parts) {
    if (part.instance.empty() || !part.section("outputs")) continue;
    const auto [place, first] = group_of.emplace(part.written.get(), groups.size());
    if (first) groups.emplace_back();
    groups[place->second].push_back(&part);
  }
  for (const auto& parts : groups) {
    std::size_t most = 0;
    for (const Part* part : parts) most = std::max(most, part->section("outputs")->list().size());
    for (std::size_t k = 0; k < most; ++k)
      for (const Part* part : parts) {
        const Value list = *part->section("outputs");
        if (k >= list.tree().items.size()) continue;  // they may be repeated more often in another
        read_output(builder, *part, Value(part->reading, *list.tree().items[k], list.what()));
      }
  }
}

}  // namespace mimbre::model_file
