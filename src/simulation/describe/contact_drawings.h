#pragma once
#include <vector>

#include "mimbre/channels.h"

namespace mimbre {

/// Adds the spheres and surfaces that bodies carry to the drawings of these, and behind them a drawing of the
/// ground where it carries any; a half-space as a plate.
void draw_contacts(const spec::Model& model, std::vector<BodyDrawing>& bodies);

/// Whether draw_contacts() draws the ground.
bool draws_ground(const spec::Model& model);

}  // namespace mimbre
