#pragma once
#include <string>

#include "dynamics/relative/system.h"
#include "dynamics/state.h"

namespace mimbre {

/// A warning where loops are drawn open, by more than a thousandth of the mechanism's size or of a radian:
/// which, by how much, and what closing them moved most. Else nothing, nor where bodies are drawn apart
/// (spec::Joint::apart). Changes the system's last evaluation.
std::string drawn_open(relative::RelativeSystem& system, const State& assembled);

}  // namespace mimbre
