#pragma once
#include <string>

#include "mimbre/spec.h"

/// Drawings of an FMU, as SVG and as PNG.
namespace mimbre::portable {

struct Icon {
  std::string svg, png;  ///< the same drawing
};

/// The mechanism where its file draws it: lines of the bodies between the points that others are fixed to,
/// springs, wheels and joints, seen along the axis in which it is thinnest.
Icon model_icon(const spec::Model& model);
/// A dot.
Icon terminal_icon();

}  // namespace mimbre::portable
