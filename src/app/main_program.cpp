#include "app/main_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <nlohmann/json.hpp>
#include <string_view>

#include "app/common.h"
#include "app/json.h"
#include "mimbre/build.h"
#include "mimbre/isolation.h"
#include "mimbre/threads.h"

/// The command line `mimbre`: finds the command, and reports what goes wrong in it.
namespace mimbre::app {
namespace {

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

Json to_json(const Diagnostic& d) {
  Json json{{"message", d.message}};
  if (!d.mark.file.empty()) json["file"] = d.mark.file;
  if (d.mark.line > 0) json.update({{"line", d.mark.line}, {"column", d.mark.column}});
  return json;
}

/// For machines, to stdout.
void print_json(const std::vector<Diagnostic>& errors, const std::string& command) {
  Json object = answer(command, "error");
  object["errors"] = Json::array();
  for (const Diagnostic& error : errors) object["errors"].push_back(to_json(error));
  try {
    print_data(to_text(object) + '\n');
  } catch (const Failure& unwritable) {
    if (errors.front().message != unwritable.what()) print_error(unwritable.what());
  }
}

/// The errors to stderr, and for machines to stdout.
int report_errors(const std::vector<Diagnostic>& errors, const Command& command, int code) {
  for (const Diagnostic& error : errors) fmt::print(stderr, "{}\n", diagnostic_line(error, "error"));
  if (command.parser.has("--json")) print_json(errors, command.parser.name());
  return code;
}

int run_guarded(const Command& command) {
  const auto one = [&](const std::string& message, int code) {
    return report_errors({{Mark{}, one_line(message)}}, command, code);
  };
  try {
    return command.run();
  } catch (const InputError& error) {
    return report_errors(error.diagnostics(), command, bad_input);
  } catch (const UsageError& error) {
    return one(error.what(), bad_usage);
  } catch (const Failure& error) {
    return one(error.what(), failed);
  } catch (const std::bad_alloc&) {
    return one("there is not enough memory", failed);
  } catch (const std::runtime_error& error) {
    // What the library throws where the input was good: a file cannot be written, an iteration goes nowhere.
    return one(error.what(), failed);
  } catch (const std::exception& error) {
    return one(error.what(), bad_input);
  }
}

int sweep_is_elsewhere(bool json) {
  const std::string message =
      "sweep comes with the Python package: `make python` where mimbre's sources are, then "
      "`build/python-env/bin/mimbre sweep STUDY.yaml`";
  print_error(message);
  if (json) print_json({{Mark{}, message}}, "sweep");
  return bad_usage;
}

std::vector<std::string> names_of(const std::vector<Command>& commands) {
  std::vector<std::string> names;
  for (const Command& command : commands) names.push_back(command.parser.name());
  return names;
}

/// `command`: as far as it is known.
int usage_error(const std::string& message, const std::string& command, bool json) {
  print_error(one_line(message));
  fmt::print(stderr, "'mimbre {}{}--help' prints more\n", command, command.empty() ? "" : " ");
  if (json) print_json({{Mark{}, one_line(message)}}, command);
  return bad_usage;
}

}  // namespace

int main_program(int argc, char** argv) {
  if (const auto rehearsed = rehearse_reading(argc, argv)) return *rehearsed;
  isolate_reading("/proc/self/exe");
  use_one_blas_thread();
  CommandLine program("mimbre", "Flexible multibody systems in real time",
                      fmt::format("mimbre {}", build_info().version));
  program.footer(
      "Messages go to the standard error, data to the standard output.\nExit codes: 0 done, 1 the model or "
      "another input is bad, 2 wrong use, 3 the simulation failed, 4 done with warnings\nif --strict was "
      "given.\n'mimbre COMMAND --help' prints more about a command.\nMany runs of a model: `mimbre sweep`, "
      "which comes with the Python package.\nExample:\n  mimbre run pendulum.yaml --output pendulum.h5 && "
      "mimbre report pendulum.h5");
  const std::vector<Command> commands = add_commands(program);
  const std::vector<std::string> names = names_of(commands);
  if (argc < 2) {
    fmt::print(stderr, "{}", program.help());
    return bad_usage;
  }
  const std::string first = argv[1];
  const bool json = std::find(argv + 1, argv + argc, std::string_view("--json")) != argv + argc;
  if (first == "sweep") return sweep_is_elsewhere(json);
  if (!first.starts_with('-') && std::find(names.begin(), names.end(), first) == names.end())
    return usage_error(fmt::format("there is no command '{}'{}", first, did_you_mean(first, names)), "",
                       json);
  try {
    if (const auto answered = program.parse(argc, argv)) return *answered;
  } catch (const Failure& error) {
    print_error(error.what());
    return failed;
  } catch (const UnexpectedArgument& error) {
    return usage_error(error.what(), first, json);
  } catch (const UsageError& error) {
    return usage_error(error.what(), first.starts_with('-') ? "" : first, json);
  }
  for (const Command& command : commands)
    if (command.parser.chosen()) return run_guarded(command);
  return bad_usage;
}

}  // namespace mimbre::app
