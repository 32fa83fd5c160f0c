#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "mimbre/diagnostics.h"
#include "mimbre/model.h"

/// What the commands share. Messages go to stderr, data to stdout.
namespace mimbre::app {

constexpr const char* version = MIMBRE_VERSION;

/// Exit codes of the program.
enum Exit : int {
  done = 0,
  bad_input = 1,  ///< the model or another input is bad
  bad_usage = 2,
  failed = 3  ///< the simulation failed, or was interrupted
};

/// Objects keep the order in which their keys were written.
using Json = nlohmann::ordered_json;

/// A command of the program: its description for the parser, and what it does; `run` returns the exit code.
struct Command {
  CLI::App* parser;
  std::function<int()> run;
};

Command add_run(CLI::App& program);
Command add_check(CLI::App& program);
Command add_static(CLI::App& program);
Command add_report(CLI::App& program);
Command add_compare(CLI::App& program);
Command add_bench(CLI::App& program);
Command add_verify(CLI::App& program);
Command add_reproduce(CLI::App& program);
Command add_reduce(CLI::App& program);
Command add_select(CLI::App& program);
Command add_convert(CLI::App& program);
Command add_stress(CLI::App& program);
Command add_export(CLI::App& program);

/// Wrong use that only shows after parsing: exit code 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The computation failed, though the input could be read: exit code 3.
struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// "name=value" texts to parameters by name. Throws UsageError.
std::map<std::string, std::string> overrides(const std::vector<std::string>& settings);

/// Adds the option --set to a command.
void add_set_option(CLI::App& command, std::vector<std::string>& settings);

/// A check for options: a number from `low` (or, when `above`, more than it) to `high`, and finite.
CLI::Validator number_from(double low, double high, bool above = false);

/// A compiled model, and the loader's warnings as lines for people (already printed).
struct LoadedModel {
  std::shared_ptr<const Model> model;
  std::vector<std::string> warnings;
};
/// Reads and compiles a model file, and prints the loader's warnings to stderr. Throws InputError,
/// UsageError.
LoadedModel load(const std::string& path, const std::vector<std::string>& settings);

/// "file:line:column: error: message", without the parts that are not known.
std::string diagnostic_line(const Diagnostic& diagnostic, const std::string& severity);

/// One line to stderr: "mimbre: error: …".
void print_error(const std::string& message);
/// One line to stderr: "mimbre: warning: …".
void print_warning(const std::string& message);

/// JSON text; numbers that are not finite become null, text that is not UTF-8 is replaced.
std::string to_text(const Json& json, int indent = 2);
/// Text to stdout, at once. Throws Failure when it cannot be written.
void print_data(const std::string& text);

/// The process's largest resident memory so far, MB (10⁶ bytes).
double peak_memory_mb();

}  // namespace mimbre::app
