#pragma once
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/options.h"
#include "mimbre/diagnostics.h"
#include "mimbre/model.h"

/// What the commands share. Messages go to stderr, data to stdout.
namespace mimbre::app {

/// Exit codes of the program.
enum Exit : int {
  done = 0,
  bad_input = 1,  ///< the model or another input is bad
  bad_usage = 2,
  failed = 3,  ///< the simulation failed, or was interrupted
  warned = 4   ///< done, but not without a warning, and --strict was given; a check of a body's validation
               ///< report failed; `check` refuses a converted robot
};

/// A command of the program: its options, and what it does; `run` returns the exit code.
struct Command {
  Parser parser;
  std::function<int()> run;
};

/// All that the program has, in the order of its help (commands/all.cpp; commands/first.cpp for the program
/// that is built first).
std::vector<Command> add_commands(CommandLine& program);
Command add_run(CommandLine& program);
Command add_live(CommandLine& program);
Command add_page(CommandLine& program);
Command add_plan(CommandLine& program);
Command add_check(CommandLine& program);
Command add_static(CommandLine& program);
Command add_linearise(CommandLine& program);
Command add_modes(CommandLine& program);
Command add_report(CommandLine& program);
Command add_compare(CommandLine& program);
Command add_bench(CommandLine& program);
Command add_verify(CommandLine& program);
Command add_reproduce(CommandLine& program);
Command add_reduce(CommandLine& program);
Command add_select(CommandLine& program);
Command add_terms(CommandLine& program);
Command add_convert(CommandLine& program);
Command add_stress(CommandLine& program);
Command add_export(CommandLine& program);
Command add_generate(CommandLine& program);
Command add_fmu(CommandLine& program);
Command add_inverse_dynamics(CommandLine& program);
Command add_trim(CommandLine& program);
Command add_kinematics(CommandLine& program);

/// The computation failed, though the input could be read: exit code 3.
struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// "name=value" texts to parameters by name. Throws UsageError.
std::map<std::string, std::string> overrides(const std::vector<std::string>& settings);

/// Adds the option --set to a command.
void add_set_option(Parser& command, std::vector<std::string>& settings);

/// Adds the option --most-modes to a command, for load().
void add_most_modes_option(Parser& command, int& most_modes);

/// Adds the option --strict to a command.
void add_strict_option(Parser& command, bool& strict);
/// The exit code of what was done, with or without warnings.
int done_with(bool warnings, bool strict);

/// A compiled model, and the loader's warnings as lines for people (already printed).
struct LoadedModel {
  std::shared_ptr<const Model> model;
  std::vector<std::string> warnings;
  std::vector<std::string> other_files;  ///< that were read with the model file: no output may replace them
};
/// Reads and compiles a model file, and prints the loader's warnings to stderr; unless `quiet` it reports on
/// the terminal what takes long. Throws InputError, UsageError. `most_modes`: of each flexible body, its
/// lowest ones; 0: all.
LoadedModel load(const std::string& path, const std::vector<std::string>& settings, bool quiet = false,
                 int most_modes = 0);

/// "file:line:column: error: message", without the parts that are not known.
std::string diagnostic_line(const Diagnostic& diagnostic, const std::string& severity);

/// One line to stderr: "mimbre: error: …".
void print_error(const std::string& message);
/// One line to stderr: "mimbre: warning: …".
void print_warning(const std::string& message);

/// Text to stdout, at once. Throws Failure when it cannot be written.
void print_data(const std::string& text);

}  // namespace mimbre::app
