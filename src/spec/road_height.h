#pragma once
#include <optional>
#include <vector>

#include "mimbre/function.h"

namespace mimbre {

/// Of a road over distance or time: straight lines through the points, level beyond both ends; with a period
/// level from the last point on to where the first comes again. Throws InputError as Function::table does.
Function road_height(std::vector<double> x, std::vector<double> z, std::optional<double> period);

}  // namespace mimbre
