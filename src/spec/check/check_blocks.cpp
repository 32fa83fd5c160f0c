#include "spec/block_info.h"
#include "spec/check/checked_item.h"

/// Blocks and events.
namespace mimbre::checks {
namespace {

void check_block(const spec::Model& model, const CheckedItem& item, const spec::Block& block) {
  const int row = find_block(block.type);
  if (row < 0) {
    std::string known;
    for (const BlockInfo* info : all_blocks())
      known += fmt::format("{}'{}'", known.empty() ? "" : ", ", info->name);
    return item.error(fmt::format("there is no block '{}'; there are {}", block.type, known));
  }
  const BlockInfo& info = block_info(row);
  item.not_negative("every", block.every);
  if (!info.continuous && !(block.every > 0))
    item.error(fmt::format("a block '{}' is sampled: 'every' is missing, s", block.type));
  const int inputs = static_cast<int>(block.inputs.size());
  if (info.inputs >= 0 && inputs != info.inputs)
    return item.error(
        fmt::format("a block '{}' has {} inputs, {} are given", block.type, info.inputs, inputs));
  if (info.inputs < 0 && !info.outside && (inputs < 1 || inputs > most_block_inputs))
    return item.error(fmt::format("has {} inputs; 1 to {} are possible", inputs, most_block_inputs));
  for (const spec::Law& law : block.inputs) {
    if (law.formula.is_zero()) item.error("has an input without a formula");
    check_law(model, item, law, 0);
  }
  if (block.numbers.size() != info.numbers.size())
    return item.error(fmt::format("a block '{}' has {} numbers, {} are given", block.type,
                                  info.numbers.size(), block.numbers.size()));
  if (!info.outside && block.outside)
    item.error(fmt::format("a block '{}' has no code from elsewhere; one of type 'fmu' has", block.type));
  bool good = true;
  for (std::size_t k = 0; k < info.numbers.size(); ++k)
    if (const LawNumber& number = info.numbers[k]; !number.allows(block.numbers[k])) {
      item.error(fmt::format("{} {}", number.key, wrong_number(number, block.numbers[k])));
      good = false;
    }
  if (block.matrices.size() != info.matrices.size())
    return item.error(fmt::format("a block '{}' has {} matrices, {} are given", block.type,
                                  info.matrices.size(), block.matrices.size()));
  for (std::size_t k = 0; k < info.matrices.size(); ++k)
    good = item.finite(std::string(info.matrices[k].key), block.matrices[k]) && good;
  if (good && info.check) info.check(block, item);
}

}  // namespace

void check_blocks(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.blocks.size(); ++k)
    check_block(model, CheckedItem(errors, "signal", model.blocks[k].name, model.blocks[k].mark, k),
                model.blocks[k]);
}

void check_events(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.events.size(); ++k) {
    const spec::Event& event = model.events[k];
    const CheckedItem item(errors, "event", event.name, event.mark, k);
    if (event.when.formula.is_zero()) item.error("has no formula that could cross zero");
    check_law(model, item, event.when, 0);
    item.enumerator("direction", event.direction, 3);
    for (const spec::Event::Set& set : event.sets) {
      item.index("set: input", set.input, model.inputs.size(), "inputs");
      if (set.value.formula.is_zero()) item.error("sets an input without saying to what");
      check_law(model, item, set.value, 0);
    }
  }
}

}  // namespace mimbre::checks
