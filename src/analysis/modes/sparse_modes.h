#pragma once
#include <optional>
#include <string>

#include "analysis/linear_point.h"
#include "mimbre/modes.h"

namespace mimbre::linear {

/// From this number of relative coordinates on the sparse solver is the faster one.
constexpr int least_sparse = 200;

/// The `most` lowest modes (0: 20) about an equilibrium, by sparse matrices; nothing where that is not
/// possible, and `why`.
std::optional<LinearisedModes> sparse_modes(const Linearised& located, int most, std::string& why);

}  // namespace mimbre::linear
