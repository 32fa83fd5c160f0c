#pragma once
#include <vector>

#include "mimbre/channels.h"

namespace mimbre {

/// How the bodies of a model are drawn: flexible ones as their mesh or beams, rigid ones as their lines; the
/// surfaces among their shapes as points and triangles that no mode moves, the other shapes as they are.
std::vector<BodyDrawing> body_drawings(const spec::Model& model);

}  // namespace mimbre
