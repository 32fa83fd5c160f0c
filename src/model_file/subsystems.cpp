#include <fmt/format.h>

#include <Eigen/Geometry>

#include "model_file/builder.h"
#include "model_file/elements.h"
#include "model_file/parameters.h"

/// Templates and their instances.
namespace mimbre::model_file {
namespace {

const std::vector<std::string>& template_keys() {
  static const std::vector<std::string> keys =
      with_element_sections({"file", "mimbre", "title", "parameters", "require", "materials", "sections",
                             "bodies", "frames", "joints", "springs", "loads", "tyres"},
                            {"inputs", "signals", "outputs"});
  return keys;
}

/// The template's tree: what stands here, or the file it names.
std::shared_ptr<const Tree> read_template(Builder& builder, const Value& value,
                                          const std::shared_ptr<const Tree>& tree) {
  const Fields fields(value, template_keys());
  const auto file = fields.get("file");
  if (!file) return tree;
  if (value.tree().entries.size() > 1) value.error("a template is either here or in a file, not both");
  const auto path = file->word();
  const auto text = path ? read_file(builder, *file, *path) : std::nullopt;
  if (!text) return nullptr;
  const std::string name = builder.directory == "." ? *path : builder.directory + "/" + *path;
  auto read = parse_yaml(*text, name, builder.limits, builder.errors.list);
  const Value content(value.reading(), *read, value.what());
  const Fields checked(content, template_keys());
  if (checked.has("file")) content.error("a template's file cannot name a further file");
  // So that the results explain themselves.
  builder.model.text += fmt::format("\n# {}:\n# ", *path);
  for (const char c : *text) builder.model.text += c == '\n' ? std::string("\n# ") : std::string(1, c);
  return read;
}

std::optional<Placement> read_placement(const Fields& fields) {
  Placement place;
  if (const auto mirror = fields.get("mirror")) {
    const auto axes = mirror->word();
    if (!axes) return {};
    for (const char c : *axes) {
      const auto k = std::string("xyz").find(c);
      if (k == std::string::npos || axes->size() > 3) {
        mirror->error(fmt::format("'{}' is not x, y, z or several of them such as xy", *axes));
        return {};
      }
      place.mirror[static_cast<Eigen::Index>(k)] = -1;
    }
  }
  if (const auto rotate = fields.get("rotate")) {
    const Eigen::Vector3d vector = rotate->triple(quantity::angle).value_or(Eigen::Vector3d::Zero());
    const double angle = vector.stableNorm();
    if (angle > 0) place.rotation = Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
  }
  if (const auto at = fields.get("at"))
    place.translation = at->triple(quantity::length).value_or(Eigen::Vector3d::Zero());
  return place;
}

}  // namespace

void read_instances(Builder& builder) {
  Part& model = builder.parts.front();
  std::map<std::string, std::shared_ptr<const Tree>> templates;
  std::vector<std::string> names;
  if (const auto section = model.section("subsystems")) {
    if (!section->is_map()) return section->error("names with templates are needed");
    for (const auto& entry : section->tree().entries) {
      if (!check_name(model.reading, entry.key, entry.mark, "subsystem")) continue;
      const Value value(model.reading, *entry.value, fmt::format("subsystem '{}'", entry.key));
      templates[entry.key] = value.is_map() ? read_template(builder, value, entry.value) : nullptr;
      if (!value.is_map())
        value.error("a template is needed: bodies, joints and so on, or {file: corner.yaml}");
      names.push_back(entry.key);
    }
  }
  const auto section = model.section("instances");
  if (!section) return;
  if (!section->is_map())
    return section->error("names with templates are needed, for example left: {of: corner}");
  std::size_t placed = 0;
  for (const auto& entry : section->tree().entries) {
    if (!check_name(model.reading, entry.key, entry.mark, "instance")) continue;
    const Value value(model.reading, *entry.value, fmt::format("instance '{}'", entry.key));
    const Fields fields(value, {"of", "at", "mirror", "rotate", "with"});
    const auto of = fields.need("of", names.empty() ? "corner" : names.front());
    const auto name = of ? of->word() : std::nullopt;
    const auto place = read_placement(fields);
    const auto with = fields.get("with");
    const auto given = with ? read_given(*with) : std::map<std::string, std::string>{};
    if (!name || !place) continue;
    const auto found = templates.find(*name);
    if (found == templates.end()) {
      of->error(fmt::format("there is no subsystem '{}'{}{}", *name, did_you_mean(*name, names),
                            names.empty() ? "" : "; there are: " + joined(names)));
      continue;
    }
    if (!found->second) continue;
    placed += found->second->size;
    if (placed > builder.limits.nodes)
      throw InputError(entry.mark,
                       fmt::format("the instances have more than {} values together", builder.limits.nodes));
    Part& part = builder.parts.emplace_back();
    part.instance = entry.key;
    builder.errors.instances.push_back(entry.key);
    part.tree = found->second;
    part.place = *place;
    part.scope.outer = &model.scope;
    part.reading = {&part.scope, &builder.errors, &builder.limits};
    if (const auto parameters = part.section("parameters")) read_parameters(*parameters, given, part.scope);
    for (const auto& [key, text] : given)
      if (!part.scope.values.contains(key)) {
        std::vector<std::string> known;
        for (const auto& [k, v] : part.scope.values) known.push_back(k);
        with->error(fmt::format("the template '{}' has no parameter '{}'{}; {}", *name, key,
                                did_you_mean(key, known),
                                known.empty() ? "it has none" : "it has: " + joined(known)));
      }
    if (const auto require = part.section("require")) read_requirements(*require);
  }
}

}  // namespace mimbre::model_file
