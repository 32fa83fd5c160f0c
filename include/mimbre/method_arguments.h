#pragma once
#include <optional>
#include <string>

#include "mimbre/run.h"

/// How a run is computed, in the words that the command line and Python use.
namespace mimbre {

/// Empty: as in the model file.
struct MethodArguments {
  std::string formulation, inertia, formalism, integrator;  ///< names of mimbre/method_names.h
  std::optional<double> rho, xi, tolerance, accuracy;
  int max_iterations = 0, substeps = 0;            ///< 0: as in the model file
  bool fixed_cost = false, no_fixed_cost = false;  ///< neither: as in the model file
};

/// The arguments as options of a run of a model whose file contains `given`. Throws UsageError where they do
/// not fit together.
RunOptions run_options(const MethodArguments& arguments, const spec::Simulation& given);

/// The steps of a run of a model whose file contains `given`, with a step and an end of the caller's where
/// given, in s. Throws UsageError where one of these makes the step longer than the run, InputError where the
/// file does.
RunPlan planned(const spec::Simulation& given, const RunOptions& options, std::optional<double> step,
                std::optional<double> until);

}  // namespace mimbre
