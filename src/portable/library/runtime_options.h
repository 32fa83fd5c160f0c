#pragma once
#include <cstddef>
#include <cstdint>

#include "mimbre/method.h"
#include "mimbre/simulation.h"

/// What the runtime and the code that calls it agree on.
namespace mimbre::portable {

/// Of a saved state: how many parameters were set, the number of the snapshot's bytes, and whether inputs do
/// not move the start any more. The parameters follow, then the snapshot.
struct StateHead {
  std::uint64_t parameters = 0;
  std::uint64_t size = 0;
  std::uint64_t begun = 0;
};
struct StateParameter {
  std::uint64_t number = 0;
  double value = 0;
};

/// Steps tell what goes wrong; nobody asks for the rest.
inline RunOptions runtime_options() {
  RunOptions options;
  options.energies = options.validity = options.warnings = false;
  return options;
}

/// Of a saved state without parameters.
inline std::size_t state_bytes(const Simulation& simulation) {
  return sizeof(StateHead) + simulation.save().bytes().size();
}

}  // namespace mimbre::portable
