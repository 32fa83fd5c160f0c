#pragma once
#include "mimbre/report.h"

namespace mimbre::results {

/// A short name per run, no two alike: what was set, formulation, formalism, integrator or step where it
/// differs between the runs; for a run that has none of it the name of its file, without folder and ending.
/// A run's own label is taken as it is.
std::vector<std::string> run_labels(const std::vector<ComparedRun>& runs);

}  // namespace mimbre::results
