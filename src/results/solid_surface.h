#pragma once
#include "mimbre/channels.h"

namespace mimbre::results {

/// Adds the boxes, cylinders and spheres of a drawing to its points and triangles, as points that no mode
/// moves, for programs that draw nothing else. `around`: corners of a circle.
void add_solids(BodyDrawing& body, int around);

}  // namespace mimbre::results
