#pragma once
#include <string_view>

#include "app/json.h"
#include "app/options.h"
#include "mimbre/method_arguments.h"

/// The options that choose how a model is computed; the same in every command that computes.
namespace mimbre::app {

/// Which of the options of the table (mimbre/run_option.h) a command has.
struct MethodChoice {
  bool steps = true;              ///< those of a command that takes steps
  std::string_view without = {};  ///< the key of one that it has not
};

/// Adds the options of the table that the command line has to a command.
void add_method_options(Parser& command, RunOptions& asked, MethodChoice choice = {});

/// Formulation, formalism and integrator, for people.
std::string method_line(const Method& method);

/// The words of a command line that ask for these.
std::vector<std::string> method_words(const RunOptions& asked);

/// What the command line chose, for the results file; what it did not is absent.
Json arguments_json(const RunOptions& asked);

/// The method in force: formulation, inertia, formalism, integrator, and rho or xi.
Json method_json(const Method& method);

/// All that was resolved: that, with the constants of the iterations, parts of repeated steps, step, end,
/// whether nobody gave the end, and output interval.
Json resolved_json(const Method& method);

}  // namespace mimbre::app
