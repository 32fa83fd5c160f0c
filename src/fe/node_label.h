#pragma once
#include "mimbre/fe_mesh.h"

namespace mimbre::fe {

/// A node's number in its file, for messages; its index where the file has none.
inline std::int64_t label_of(const SolidMesh& mesh, int node) {
  const auto index = static_cast<std::size_t>(node);
  return index < mesh.labels.size() ? mesh.labels[index] : static_cast<std::int64_t>(node);
}

}  // namespace mimbre::fe
