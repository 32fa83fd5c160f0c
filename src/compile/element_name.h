#pragma once
#include <string>

#include "compile/compiled.h"

namespace mimbre {

/// "spring 'front'".
std::string element_name(const Compiled& model, const ElementData& element);

}  // namespace mimbre
