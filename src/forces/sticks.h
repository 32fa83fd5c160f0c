#pragma once
#include <algorithm>

#include "compile/compiled.h"
#include "spec/force_law.h"

namespace mimbre {

/// Whether the model has friction that heeds LawContext::holds: that of joints.
inline bool sticks(const Compiled& m) {
  return std::any_of(m.elements.begin(), m.elements.end(),
                     [](const ElementData& e) { return law_info(e.law).sticks; });
}

}  // namespace mimbre
