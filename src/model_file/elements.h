#pragma once
#include <fmt/format.h>

#include "model_file/builder.h"

/// What the sections of force elements have in common.
namespace mimbre::model_file {

/// Calls `one(name, entry, value)` for every named thing of a section and counts it in `names`.
template <class Read>
void for_each(Builder& builder, Part& part, const std::string& key, Names& names, std::size_t& count,
              Read&& one) {
  const auto section = part.section(key);
  if (!section) return;
  if (!section->is_map()) return section->error("names with their descriptions are needed");
  for (const auto& entry : section->tree().entries) {
    const std::string name = part.full_name(entry.key);
    if (!builder.claim(names, part, name, entry.mark, static_cast<int>(count))) continue;
    one(name, entry.mark, Value(part.reading, *entry.value, fmt::format("{} '{}'", names.kind, name)));
    ++count;
  }
}

/// The two frames of `between`, at the places `at` (two), or at one place that both have; -1 where that is
/// wrong, and said.
std::pair<int, int> read_ends(Builder& builder, const Part& part, const Fields& fields,
                              const std::string& name, bool one_place);

/// Keys with the sections of the laws (model/force_laws.h) between them.
std::vector<std::string> with_element_sections(std::vector<std::string> before,
                                               const std::vector<std::string>& behind);
/// Those sections.
void read_elements(Builder& builder, Part& part);

}  // namespace mimbre::model_file
