#include <fmt/format.h>

#include "fe_files/element_faces.h"
#include "fe_files/inp/inp_model.h"
#include "fe_files/text.h"

namespace mimbre::fe {

namespace {

/// 0: no face.
int face_number(std::string_view text) {
  const std::string name = lower(text);
  if (name == "spos") return 1;
  if (name == "sneg") return 2;
  return name.size() == 2 && name[0] == 's' && name[1] >= '1' && name[1] <= '6' ? name[1] - '0' : 0;
}

}  // namespace

void read_inp_surface(InpModel& model, const InpKeyword& keyword) {
  const std::string* name = keyword.find("NAME");
  if (!name || name->empty())
    throw InputError(keyword.mark, "*SURFACE needs NAME=, for example *SURFACE, NAME=left");
  const std::string* type = keyword.find("TYPE");
  const bool of_nodes = type && lower(*type) == "node";
  if (type && !of_nodes && lower(*type) != "element") {
    model.warn("surface", keyword.mark, fmt::format("*SURFACE, TYPE={} is left out", shown(*type)));
    return;
  }
  const auto universe = static_cast<std::size_t>(model.nodes.size());
  std::vector<int> members;
  std::string_view line;
  while (model.lines.next_data(line)) {
    const TextFile& file = model.lines.file();
    const std::string_view first = next_field(line);
    const auto label = to_integer(first);
    if (of_nodes) {
      const int node = label ? model.nodes.find(*label) : -1;
      const std::vector<int>* set = label ? nullptr : model.node_sets.find(std::string(first));
      if (node < 0 && !set) {
        model.warn(
            "surface " + *name, file.mark(),
            fmt::format("there is no node or node set '{}' of the surface {}", shown(first), shown(*name)));
        continue;
      }
      if (set) add_members(*set, universe, members);
      if (node >= 0) members.push_back(node);
      continue;
    }
    const std::string_view face_name = next_field(line);
    const int face = face_number(face_name);
    std::vector<int> one;
    const std::vector<int>* elements = &one;
    if (label) {
      const auto found = model.element_by_label.find(*label);
      if (found == model.element_by_label.end()) {
        model.warn("surface " + *name, file.mark(),
                   fmt::format("element {} of the surface {} is not there", *label, shown(*name)));
        continue;
      }
      one = {found->second};
    } else {
      elements = &model.known_element_set(std::string(first), file.mark()).elements;
    }
    for (const int index : *elements) {
      const InpElement& element = model.elements[static_cast<std::size_t>(index)];
      const InpType& kind = model.types[static_cast<std::size_t>(element.type)];
      const std::vector<int> places =
          kind.kind == InpType::Kind::element ? face_nodes(kind.type, face) : std::vector<int>{};
      if (places.empty() && kind.kind != InpType::Kind::element) {
        model.warn(
            "surface " + *name, file.mark(),
            fmt::format("element {} of the surface {} is not part of the body", element.label, shown(*name)));
        continue;
      }
      if (places.empty())
        file.fail(fmt::format("element {} has no face '{}' (S1 to S6)", element.label, shown(face_name)));
      std::vector<int> nodes;
      for (const int place : places)
        nodes.push_back(model.element_nodes[element.first + static_cast<std::size_t>(place)]);
      add_members(nodes, universe, members);
      model.surfaces[lower(*name)].faces.push_back(std::move(nodes));
    }
  }
  add_members(members, universe, model.node_sets[*name]);
}

}  // namespace mimbre::fe
