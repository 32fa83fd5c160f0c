#include "model_file/sections/fmu_block.h"

namespace mimbre::model_file {

std::vector<std::string> fmu_keys() {
  return {"inputs", "outputs", "parameters", "inputs_at", "process", "timeout"};
}

std::vector<std::string> fmu_output_names(const Tree& description) {
  std::vector<std::string> names;
  const Tree::Entry* outputs = description.find("outputs");
  if (!outputs) return names;
  for (const auto& item : outputs->value->items) names.push_back(item->text);
  for (const auto& entry : outputs->value->entries) names.push_back(entry.key);
  return names;
}

void complete_fmu_intervals(spec::Model& model) {
  for (spec::Block& block : model.blocks)
    if (block.outside && !(block.every > 0)) block.every = model.simulation.step;
}

}  // namespace mimbre::model_file
