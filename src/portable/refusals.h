#pragma once
#include <vector>

#include "compile/compiled.h"
#include "mimbre/diagnostics.h"
#include "mimbre/method.h"

namespace mimbre::portable {

/// Why code cannot be made of a model that is stepped so: for each reason the place, and what can be done
/// instead.
std::vector<Diagnostic> refusals(const Compiled& model, const Method& method);

/// Likewise of a model whose state an importer's solver integrates.
std::vector<Diagnostic> exchange_refusals(const Compiled& model, const Method& method);

}  // namespace mimbre::portable
