#pragma once
#include <ostream>

#include "mimbre/method_names.h"

/// Parameters of tests are printed as words. Found by their namespaces.
namespace mimbre::spec {
inline void PrintTo(Simulation::Formulation formulation, std::ostream* out) { *out << name_of(formulation); }
}  // namespace mimbre::spec
