#pragma once
#include "mimbre/channels.h"
#include "mimbre/spec.h"

namespace mimbre::live {

/// A road over distance as far as somebody may drive on it: two lengths of what is drawn of it before that,
/// and seventeen behind, where it repeats or goes on. The profile is right to a millimetre but for jumps,
/// which take a two-thousandth of the length; where the road is a length higher or lower than where it is
/// drawn, or not finite, it has no points. No more than 20 000 points.
RoadDrawing road_stretch(const spec::Road& road);

}  // namespace mimbre::live
