#pragma once
#include "mimbre/fe_import.h"

namespace mimbre::fe {

/// Throws std::invalid_argument unless all are positive.
void check(const FileUnits& units);

}  // namespace mimbre::fe
