#include "simulation/observe/recorded_sections.h"

#include <map>
#include <utility>

#include "mimbre/reduced_body.h"
#include "spec/output_kind.h"

namespace mimbre {

std::vector<RecordedSection> recorded_sections(const spec::Model& model) {
  std::map<std::pair<int, int>, RecordedSection> found;  // by body and section
  for (std::size_t k = 0; k < model.outputs.size(); ++k) {
    const spec::Output& o = model.outputs[k];
    if (output_info(o).place != OutputInfo::Place::section) continue;
    const auto& body = model.bodies[static_cast<std::size_t>(o.item)].flexible;
    if (!body || !body->sections) continue;  // it was made rigid
    const auto& section = body->sections->sections[static_cast<std::size_t>(o.node)];
    RecordedSection& recorded = found[{o.item, o.node}];
    recorded.body = o.item;
    recorded.bar = section.bar;
    recorded.element = section.element;
    recorded.end = o.node % 2 == 1;
    recorded.along = section.along;
    recorded.channels[static_cast<std::size_t>(o.component)] = static_cast<int>(k);
  }
  std::vector<RecordedSection> all;
  for (auto& [place, section] : found) all.push_back(std::move(section));
  return all;
}

}  // namespace mimbre
