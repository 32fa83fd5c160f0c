#include <algorithm>

#include "forces/surfaces/table.h"

namespace mimbre {

std::span<const SurfaceInfo* const> all_surfaces() { return surfaces::infos; }

const SurfaceInfo& surface_info(int kind) { return *surfaces::infos[static_cast<std::size_t>(kind)]; }

int find_surface(std::string_view name) {
  const auto found = std::find_if(surfaces::infos.begin(), surfaces::infos.end(),
                                  [&](const SurfaceInfo* info) { return info->name == name; });
  return found == surfaces::infos.end() ? -1 : static_cast<int>(found - surfaces::infos.begin());
}

}  // namespace mimbre
