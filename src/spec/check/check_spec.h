#pragma once
#include "mimbre/spec.h"

namespace mimbre {

/// Throws InputError with every mistake that is found: what the later stages take for granted of a spec,
/// whoever made it (a file, a builder, a program). Each message names the item by its kind and name, says
/// what is wrong and what would be right, and keeps the item's mark. What depends on the tree or on the
/// position that closes the loops is not known here: find_topology and the start of a run check that.
void check_spec(const spec::Model& model);

}  // namespace mimbre
