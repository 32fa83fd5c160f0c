#include <fmt/format.h>

#include "math/turn.h"
#include "model_file/sections/elements.h"
#include "model_file/text/builder.h"
#include "model_file/text/includes.h"
#include "model_file/text/parameters.h"
#include "model_file/text/repeats.h"

/// Templates and their instances.
namespace mimbre::model_file {
namespace {

const std::vector<std::string>& template_keys() {
  static const std::vector<std::string> keys = with_element_sections(
      {"file", "include", "mimbre", "title", "parameters", "require", "materials", "sections", "bodies",
       "frames", "joints", "constraints", "springs", "loads", "tyres", "surfaces", "contacts"},
      {"inputs", "signals", "events", "subsystems", "instances", "outputs"});
  return keys;
}

/// The template's tree: what stands here, or the file it names; null, and an error, where there is none.
std::shared_ptr<const Tree> read_template(Builder& builder, const Value& value,
                                          const std::shared_ptr<const Tree>& tree) {
  if (!value.is_map()) {
    value.error("a template is needed: bodies, joints and so on, or {file: corner.yaml}");
    return nullptr;
  }
  const auto file = Fields(value, template_keys()).get("file");
  if (!file) return tree;
  if (tree->entries.size() > 1) value.error("a template is either here or in a file, not both");
  const auto read = read_tree(builder, *file);
  if (!read) return nullptr;
  const Value content(value.reading(), *read, value.what());
  if (Fields(content, template_keys()).has("file"))
    content.error("a template's file cannot name a further file; it can include it");
  return read->kind == Tree::Kind::map ? read : nullptr;
}

void read_templates(Builder& builder, Part& part) {
  const auto section = part.section("subsystems");
  if (!section) return;
  if (!section->is_map()) return section->error("names with templates are needed");
  for (const auto& entry : section->tree().entries) {
    if (!check_name(part.reading, entry.key, entry.mark, "subsystem")) continue;
    const Value value(part.reading, *entry.value, fmt::format("subsystem '{}'", part.full_name(entry.key)));
    part.templates[entry.key] = {read_template(builder, value, entry.value), &part, entry.mark};
  }
}

/// The template that a part calls `name`: its own, or of where it is written.
const Template* find_template(const Part& part, const std::string& name, std::vector<std::string>& known) {
  for (const Part* home = &part; home; home = home->home) {
    const auto found = home->templates.find(name);
    if (found != home->templates.end()) return &found->second;
    for (const auto& [other, content] : home->templates) known.push_back(other);
  }
  return nullptr;
}

std::optional<Placement> read_placement(const Fields& fields) {
  Placement place;
  if (const auto mirror = fields.get("mirror")) {
    const auto axes = mirror->word();
    if (!axes) return {};
    for (const char c : *axes) {
      if (*axes == "none") break;
      const auto k = std::string("xyz").find(c);
      if (k == std::string::npos || axes->size() > 3) {
        mirror->error(fmt::format("'{}' is not x, y, z or several of them such as xy, or none", *axes));
        return {};
      }
      place.mirror[static_cast<Eigen::Index>(k)] = -1;
    }
  }
  if (const auto rotate = fields.get("rotate")) {
    place.rotation = turn_by(rotate->triple(quantity::angle).value_or(Eigen::Vector3d::Zero()));
  }
  if (const auto at = fields.get("at"))
    place.translation = at->triple(quantity::length).value_or(Eigen::Vector3d::Zero());
  return place;
}

/// Values that the instance gives to parameters of its template.
void read_own_parameters(Part& part, const std::string& of, const std::optional<Value>& with,
                         const std::map<std::string, std::string>& given) {
  if (const auto parameters = part.section("parameters")) read_parameters(*parameters, given, part.scope);
  for (const auto& [key, text] : given) {
    if (part.scope.values.contains(key)) continue;
    std::vector<std::string> known;
    for (const auto& [k, v] : part.scope.values) known.push_back(k);
    with->error(fmt::format("the template '{}' has no parameter '{}'{}; {}", of, key,
                            did_you_mean(key, known),
                            known.empty() ? "it has none" : "it has: " + joined(known)));
  }
  if (const auto require = part.section("require")) read_requirements(*require);
}

class Placer {
 public:
  explicit Placer(Builder& builder) : builder_(builder) {}

  void place_all(Part& part, int depth) {
    read_templates(builder_, part);
    const auto section = part.section("instances");
    if (!section) return;
    if (!section->is_map())
      return section->error("names with templates are needed, for example left: {of: corner}");
    if (depth > builder_.limits.depth)
      throw InputError(section->mark(),
                       fmt::format("templates stand in each other more than {} deep", builder_.limits.depth));
    for (const auto& entry : section->tree().entries)
      if (check_name(part.reading, entry.key, entry.mark, "instance")) place(part, entry, depth);
  }

 private:
  void place(Part& outer, const Tree::Entry& entry, int depth) {
    const std::string name = outer.full_name(entry.key);
    const Value value(outer.reading, *entry.value, fmt::format("instance '{}'", name));
    const Fields fields(value, {"of", "at", "mirror", "rotate", "with"});
    const auto of = fields.need("of", outer.templates.empty() ? "corner" : outer.templates.begin()->first);
    const auto word = of ? of->word() : std::nullopt;
    const auto place = read_placement(fields);
    const auto with = fields.get("with");
    const auto given = with ? read_given(*with) : std::map<std::string, std::string>{};
    if (!word || !place) return;
    std::vector<std::string> known;
    const Template* found = find_template(outer, *word, known);
    if (!found)
      return of->error(fmt::format("there is no subsystem '{}'{}{}", *word, did_you_mean(*word, known),
                                   known.empty() ? "" : "; there are: " + joined(known)));
    if (!found->tree) return;
    builder_.placed_templates.insert(found->tree.get());
    for (const Part* part = &outer; part; part = part->outer)
      if (part->written == found->tree)
        return of->error(fmt::format("the subsystem '{}' stands in itself; that would never end", *word));
    placed_ += found->tree->size;
    if (placed_ > builder_.limits.nodes)
      throw InputError(entry.mark,
                       fmt::format("the instances have more than {} values together", builder_.limits.nodes));
    Part& part = builder_.parts.emplace_back();
    part.instance = name;
    part.outer = &outer;
    part.home = found->home;
    builder_.errors.instance(name);
    part.written = part.tree = found->tree;
    part.place = outer.outer ? outer.place.of(*place) : *place;
    part.scope.outer = &found->home->scope;
    part.reading = {&part.scope, &builder_.errors, &builder_.limits};
    read_own_parameters(part, *word, with, given);
    part.tree = written_out(part.written, part.reading, part.instance);
    placed_ += part.tree->size - std::min(part.tree->size, found->tree->size);
    place_all(part, depth + 1);
  }

  Builder& builder_;
  std::size_t placed_ = 0;
};

}  // namespace

void read_instances(Builder& builder) { Placer(builder).place_all(builder.parts.front(), 0); }

}  // namespace mimbre::model_file
