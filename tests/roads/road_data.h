#pragma once
#include <string>

/// The roads of tests/data/roads.
namespace mimbre::test {

inline std::string road_path(const std::string& name) {
  return std::string(MIMBRE_SOURCE_DIR) + "/tests/data/roads/" + name;
}

}  // namespace mimbre::test
