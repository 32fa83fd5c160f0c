#pragma once
#include "model/compiled.h"

namespace mimbre {

/// Sets the speeds below which laws of force elements count motion as rest: blows of stops and contacts
/// (forces/blow.h), and the turning of a motor's gear (forces/motor.h). They are shares of the speeds that
/// the mechanism itself has, by its length scale and gravity, so that no unit of length or time counts.
void find_slow_speeds(Compiled& model);

}  // namespace mimbre
