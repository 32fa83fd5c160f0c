#pragma once
#include <vector>

#include "compile/compiled.h"
#include "mimbre/channels.h"

namespace mimbre {

/// The joints, springs, loads and tyres of a model, and the frames between which they are drawn.
struct ElementDrawings {
  std::vector<FrameDrawing> frames;
  std::vector<ElementDrawing> elements;
};

/// `bodies`: as they are drawn; their modes are those that move the frames.
ElementDrawings element_drawings(const Compiled& model, const std::vector<BodyDrawing>& bodies);

}  // namespace mimbre
