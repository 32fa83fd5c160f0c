#pragma once
#include <string>

namespace mimbre {

/// What this library was made with: results are the same bits only from the same.
struct BuildInfo {
  std::string version;       ///< of mimbre
  std::string compiler;      ///< its name and version
  std::string instructions;  ///< vector instructions that the step may use: "avx512f, fma", "sse2", …
};
const BuildInfo& build_info();

}  // namespace mimbre
