#pragma once
#include <optional>
#include <string>

#include "app/json.h"
#include "app/options.h"
#include "mimbre/run.h"

/// The options that choose how a model is computed; the same in every command that computes.
namespace mimbre::app {

/// What the command line sets; empty: as in the model file.
struct MethodArguments {
  std::string formulation, inertia, formalism, integrator;
  std::optional<double> rho, xi, tolerance;
  int max_iterations = 0, substeps = 0;            ///< 0: as in the model file
  bool fixed_cost = false, no_fixed_cost = false;  ///< neither: as in the model file
};

/// Which of the options a command has.
struct MethodChoice {
  bool formulation = true;
  bool motion = true;  ///< formalism, integrator and its parameter: a command that takes steps
};

/// Adds --formulation, --inertia, --formalism, --integrator, --rho, --integrator-xi, --tolerance,
/// --max-iterations, --substeps, --fixed-cost and --no-fixed-cost to a command.
void add_method_options(Parser& command, MethodArguments& arguments, MethodChoice choice = {});

/// The arguments as options of a run of a model whose file has `given`. Throws UsageError where they do not
/// fit together.
RunOptions run_options(const MethodArguments& arguments, const spec::Simulation& given);

/// The steps of a run of a model whose file has `given`, with the --step and --until of the command line
/// where given. Throws UsageError where one of these makes the step longer than the run, InputError where the
/// file does.
RunPlan planned(const spec::Simulation& given, const RunOptions& options, std::optional<double> step,
                std::optional<double> until);

/// What the command line chose, for the results file; what it did not is absent.
Json to_json(const MethodArguments& arguments);

/// The method in force: formulation, inertia, formalism, integrator, and rho or xi.
Json method_json(const Method& method);

/// All that was resolved: that, with the constants of the iterations, parts of repeated steps, step, end,
/// whether nobody gave the end, and output interval.
Json resolved_json(const Method& method);

}  // namespace mimbre::app
