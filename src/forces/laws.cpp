#include <algorithm>

#include "forces/table.h"

namespace mimbre {

std::span<const LawInfo* const> all_laws() { return forces::infos; }

const LawInfo& law_info(int law) { return *forces::infos[static_cast<std::size_t>(law)]; }

int find_law(std::string_view name) {
  const auto found = std::find_if(forces::infos.begin(), forces::infos.end(),
                                  [&](const LawInfo* info) { return info->name == name; });
  return found == forces::infos.end() ? -1 : static_cast<int>(found - forces::infos.begin());
}

}  // namespace mimbre
