#pragma once
#include <string>

#include "app/json.h"
#include "app/options.h"
#include "mimbre/method_arguments.h"

/// The options that choose how a model is computed; the same in every command that computes.
namespace mimbre::app {

/// Which of the options a command has.
struct MethodChoice {
  bool formulation = true;
  bool motion = true;  ///< formalism, integrator and its parameter: a command that takes steps
};

/// Adds --formulation, --inertia, --formalism, --integrator, --rho, --integrator-xi, --accuracy, --tolerance,
/// --max-iterations, --substeps, --fixed-cost and --no-fixed-cost to a command.
void add_method_options(Parser& command, MethodArguments& arguments, MethodChoice choice = {});

/// What the command line chose, for the results file; what it did not is absent.
Json arguments_json(const MethodArguments& arguments);

/// The method in force: formulation, inertia, formalism, integrator, and rho or xi.
Json method_json(const Method& method);

/// Formulation, formalism and integrator, for people.
std::string method_words(const Method& method);

/// All that was resolved: that, with the constants of the iterations, parts of repeated steps, step, end,
/// whether nobody gave the end, and output interval.
Json resolved_json(const Method& method);

}  // namespace mimbre::app
