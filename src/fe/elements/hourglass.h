#pragma once
#include "fe/elements/solid_element.h"

namespace mimbre::fe {

/// Share of the full integration's energy that motions get which reduced integration does not see.
constexpr double kHourglassShare = 0.002;

/// Adds to the lower triangle of a reduced 20-node brick's stiffness what keeps its six motions without
/// energy in hand.
void add_hourglass_stiffness(const SolidGeometry& geometry, const ElementMaterial& material,
                             SolidMatrix& stiffness);

}  // namespace mimbre::fe
