#include <fmt/format.h>

#include "model_file/text/builder.h"

/// `neglected_inertia:` terms of flexible bodies' inertia that the model does without, by body.
namespace mimbre::model_file {
namespace {

InertiaTerms read_terms(const Value& value) {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const InertiaTermInfo& term : inertia_terms) all.emplace_back(term.name);
    return all;
  }();
  InertiaTerms terms;
  for (const Value& item : value.list())
    if (const auto term = item.choice(names)) terms.add(static_cast<InertiaTerm>(*term));
  return terms;
}

}  // namespace

void read_neglected_inertia(Builder& builder, Part& model) {
  const auto section = model.section("neglected_inertia");
  if (!section) return;
  if (!section->is_map())
    return section->error(
        "names of flexible bodies, or all, with terms are needed, for example all: [coriolis_modes]");
  for (const auto& entry : section->tree().entries) {
    const Value value(model.reading, *entry.value, fmt::format("neglected_inertia '{}'", entry.key));
    const InertiaTerms terms = read_terms(value);
    const bool all = entry.key == "all";
    if (all && builder.body_names.index.count("all") > 0)
      value.error("a body is called all, as all of them are here; rename it");
    const int one = all ? -1 : builder.resolve(builder.body_names, model, entry.key, value);
    for (std::size_t k = 0; k < builder.bodies.size(); ++k) {
      if (!all && static_cast<int>(k) != one) continue;
      if (builder.bodies[k].flexible)
        builder.model.bodies[k].neglected.bits |= terms.bits;
      else if (!all && !builder.bodies[k].failed)
        builder.warnings.push_back(
            {entry.mark,
             fmt::format("neglected_inertia: body '{}' is rigid and has none of these terms", entry.key)});
    }
  }
}

}  // namespace mimbre::model_file
