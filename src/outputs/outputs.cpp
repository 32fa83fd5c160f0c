#include <algorithm>

#include "outputs/table.h"

namespace mimbre {

std::span<const OutputInfo* const> all_outputs() { return outputs::infos; }

int find_output(std::string_view name) {
  const auto found = std::find_if(outputs::infos.begin(), outputs::infos.end(),
                                  [&](const OutputInfo* info) { return info->name == name; });
  return found == outputs::infos.end() ? -1 : static_cast<int>(found - outputs::infos.begin());
}

const OutputInfo& output_info(const spec::Output& output) {
  return *outputs::infos[static_cast<std::size_t>(find_output(output.kind))];
}

}  // namespace mimbre
