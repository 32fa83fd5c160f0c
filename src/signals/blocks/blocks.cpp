#include <algorithm>

#include "signals/blocks/table.h"

namespace mimbre {

std::span<const BlockInfo* const> all_blocks() { return blocks::infos; }

const BlockInfo& block_info(int type) { return *blocks::infos[static_cast<std::size_t>(type)]; }

int find_block(std::string_view name) {
  const auto found = std::find_if(blocks::infos.begin(), blocks::infos.end(),
                                  [&](const BlockInfo* info) { return info->name == name; });
  return found == blocks::infos.end() ? -1 : static_cast<int>(found - blocks::infos.begin());
}

}  // namespace mimbre
