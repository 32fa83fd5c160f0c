#pragma once
#include <fmt/format.h>

#include "compile/signals/compile_signals.h"
#include "mimbre/diagnostics.h"

namespace mimbre::outputs {

/// Throws InputError where a signal would see, within a step, modes of a body by elastodynamics: nothing of
/// the mechanism may depend on these.
inline void refuse_driven(const SensorPlaces& places, const spec::Output& o, int body) {
  if (body < 0 || !places.compiled.bodies[body].elastodynamic) return;
  throw InputError(
      o.mark, fmt::format("'{}' is of a body that bends by elastodynamics, of which the mechanism has no "
                          "part; see it at instants, by a signal with `every: 0.01`",
                          o.name));
}

}  // namespace mimbre::outputs
