#include "signals/once/sampled_chains.h"

#include <algorithm>

namespace mimbre {

std::vector<char> takes_sampled(const SignalsData& d) {
  std::vector<char> follows(static_cast<std::size_t>(d.slots), 0);  // by slot
  for (const SignalsData::HeldInput& h : d.held)
    follows[static_cast<std::size_t>(h.slot)] = std::any_of(
        d.sampled.begin(), d.sampled.end(),
        [&](const SignalsData::Sampled& s) { return h.held >= s.held && h.held < s.held + s.values; });
  const auto any = [&](const LawData& law) {
    return std::any_of(law.slots.begin(), law.slots.end(),
                       [&](int slot) { return follows[static_cast<std::size_t>(slot)] != 0; });
  };
  // Blocks may take what is made behind them.
  for (bool changed = true; changed;) {
    changed = false;
    for (const auto* list : {&d.fixed, &d.moving})
      for (const SignalsData::Computed& made : *list) {
        const SignalsData::Block* b =
            made.block < 0 ? nullptr : &d.blocks[static_cast<std::size_t>(made.block)];
        if (!(b ? std::any_of(b->laws.begin(), b->laws.end(), any) : any(made.law))) continue;
        for (int k = 0; k < (b ? b->outputs : 1); ++k)
          if (char& mark = follows[static_cast<std::size_t>(made.slot + k)]; !mark) mark = changed = true;
      }
  }
  std::vector<char> takes;
  for (const SignalsData::Sampled& s : d.sampled)
    takes.push_back(std::any_of(s.inputs.begin(), s.inputs.end(), [&](const SignalsData::Seen& input) {
      return std::any_of(input.arguments.begin(), input.arguments.end(), [&](const auto& a) {
        return a.slot >= 0 && follows[static_cast<std::size_t>(a.slot)];
      });
    }));
  return takes;
}

}  // namespace mimbre
