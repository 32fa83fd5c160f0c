#include "compile/signals/compile_blocks.h"

#include "spec/block_info.h"

namespace mimbre {

bool feeds_through(const spec::Block& block) {
  const BlockInfo& info = block_info(find_block(block.type));
  return !info.feeds_through || info.feeds_through(block);
}

bool is_smooth(const spec::Block& block) { return block_info(find_block(block.type)).smooth; }

SignalsData::Block compile_block(const spec::Block& block, double step, SignalsData& signals) {
  SignalsData::Block b{};
  b.type = find_block(block.type);
  b.inputs = static_cast<int>(block.inputs.size());
  b.outputs = output_count(block);
  b.every = block.every;
  b.numbers = static_cast<int>(signals.numbers.size());
  b.function = -1;
  b.matrices = signals.matrices;
  const BlockPlan plan{signals, b, step};
  if (const BlockInfo& info = block_info(b.type); info.compile)
    info.compile(block, plan);
  else
    plan.add_numbers(block.numbers);
  return b;
}

}  // namespace mimbre
