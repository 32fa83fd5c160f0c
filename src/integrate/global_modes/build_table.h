#pragma once
#include "integrate/global_modes/loop_table.h"
#include "integrate/global_modes/path.h"

namespace mimbre::global_modes {

struct TableOptions {
  double step = 0.01;            ///< s: modes that it resolves are kept
  double accuracy = 1e-3;        ///< share of the deflections by loads that the modes may leave out
  double violation = 1e-7;       ///< of Φ between the places, by the scales of the equations: is sought
  double most_violation = 1e-3;  ///< and is accepted
  int most_places = 513;
};

/// The table of a loop from a state on. Throws NoGlobalModes.
///
/// Modes are those of the loop with θ held: by the static deflections, at places all along the path, under
/// inertia and weight in random states of the whole mechanism near the state, and under unit forces wherever
/// elements may act (the static correction), each as large as the others, of which those combinations are
/// kept that have more than the wanted share of the energy (proper orthogonal decomposition in the metric of
/// the stiffness), and the eigenmodes in the middle that the step resolves. Where equations resist
/// deflections themselves, at each place the combinations are projected onto what the equations leave free.
LoopTable build_table(Probe& probe, const Loop& loop, const CoordinateKinds& kinds, const State& state,
                      const TableOptions& options);

}  // namespace mimbre::global_modes
