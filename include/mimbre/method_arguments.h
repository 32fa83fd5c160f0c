#pragma once
#include "mimbre/run.h"

/// Options of a run as the command line and Python take them: what is wrong is named as there.
namespace mimbre {

/// The options, of which nothing conflicts with what a model file contains. Throws UsageError where they do
/// not fit together.
RunOptions run_options(const RunOptions& asked, const spec::Simulation& given);

/// The steps of a run of a model whose file contains `given`. Throws UsageError where a step or an end that
/// is asked for makes the step longer than the run, InputError where the file does.
RunPlan planned(const spec::Simulation& given, const RunOptions& options);

}  // namespace mimbre
