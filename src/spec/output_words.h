#pragma once
#include <string>

#include "spec/output_kind.h"

namespace mimbre {

/// The kinds of model files for which that holds: "'deflection' and 'strain'".
std::string kinds_with(bool (*uses)(const OutputInfo&));

}  // namespace mimbre
