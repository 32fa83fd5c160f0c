#pragma once
#include <string>

#include "mimbre/fe.h"

namespace mimbre::fe {

/// What no solid is like, in SI, and in which units it may have been meant: "density 7.85 kg/m³ (is it in
/// g/cm³?)". Empty when nothing is odd.
std::string oddity(const Material& material);

}  // namespace mimbre::fe
