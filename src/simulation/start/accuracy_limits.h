#pragma once
#include <string>

#include "compile/compiled.h"

namespace mimbre {

/// A warning that names parts of the model whose error Method::accuracy does not cover; empty: there are
/// none.
std::string accuracy_limits(const Compiled& model);

}  // namespace mimbre
