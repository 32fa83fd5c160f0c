#pragma once
#include <fmt/format.h>

#include "model_file/text/builder.h"
#include "spec/force_law.h"

/// What the sections of force elements have in common.
namespace mimbre::model_file {

/// Calls `one(name, entry, value)` for every named item of a section and counts it in `names`.
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

/// Items of a section that have nothing but a name, a place and what `read` finds.
template <class Item, class Read>
void read_each(Builder& builder, Part& part, const std::string& key, Names& names, std::vector<Item>& items,
               Read&& read) {
  std::size_t count = items.size();
  for_each(builder, part, key, names, count,
           [&](const std::string& name, const Mark& mark, const Value& value) {
             Item item;
             item.name = name;
             item.mark = mark;
             read(builder, part, value, item);
             items.push_back(std::move(item));
           });
}

/// The two frames of `between`, at the places `at` (two), or at one place that both have; -1 where that is
/// wrong, which is reported.
std::pair<int, int> read_ends(Builder& builder, const Part& part, const Fields& fields,
                              const std::string& name, bool one_place);

/// The joint that is named and its velocity coordinate, a plain number: the one of `coordinate`, which joints
/// with several need; nothing where that is wrong, which is reported.
std::optional<std::pair<int, int>> read_coordinate(Builder& builder, const Part& part, const Value& joint,
                                                   const std::optional<Value>& coordinate);
/// A frame at another's place with these global axes, on the same body.
int turned_frame(Builder& builder, int frame, const std::string& name, const Eigen::Matrix3d& axes,
                 const Value& value);

/// The `joint` and its `coordinate`, with the factor 1; nothing where that is wrong, which is reported.
std::optional<spec::Element::Term> read_coordinate(Builder& builder, const Part& part, const Fields& fields);
/// Likewise as what the element acts on; false where that is wrong.
bool read_coordinate_of(Builder& builder, const Part& part, const Fields& fields, spec::Element& e);

/// Numbers by their keys. `turns`: on an angle. `may_miss`: those that are not given are as they are
/// otherwise, even NaN.
std::vector<double> read_numbers(std::span<const LawNumber> numbers, const Fields& fields, const Value& value,
                                 bool turns, bool may_miss = false);
inline std::vector<double> read_numbers(const LawInfo& law, const Fields& fields, const Value& value,
                                        bool turns) {
  return read_numbers(law.numbers, fields, value, turns);
}

void read_torsion_spring(Builder& builder, const Part& part, const Value& value, spec::Element& e);
void read_cable(Builder& builder, const Part& part, const LawInfo& law, const Value& value, spec::Element& e);
void read_motor(Builder& builder, const Part& part, const LawInfo& law, const Value& value, spec::Element& e);
void read_drag(Builder& builder, const Part& part, const LawInfo& law, const Value& value, spec::Element& e);

/// Keys with the sections of the laws (spec/force_law.h) between them.
std::vector<std::string> with_element_sections(std::vector<std::string> before,
                                               const std::vector<std::string>& behind);
/// Those sections.
void read_elements(Builder& builder, Part& part);

}  // namespace mimbre::model_file
