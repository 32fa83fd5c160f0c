#pragma once
#include "compile/compiled.h"
#include "mimbre/method.h"

namespace mimbre {

/// Throws InputError, with the body and the option, where a body bends by linear elastodynamics and the
/// method cannot follow that: its matrix has no part by which the mechanism drives the modes, so that only
/// iterated rules get there, and natural coordinates have no such bodies.
void refuse_elastodynamics(const Compiled& model, const Method& method);

}  // namespace mimbre
