#include "app/common.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "app/terminal/busy.h"
#include "mimbre/assembly.h"
#include "mimbre/model_file.h"
#include "mimbre/real_time_plan.h"
#include "mimbre/text.h"

namespace mimbre::app {

std::map<std::string, std::string> overrides(const std::vector<std::string>& settings) {
  std::map<std::string, std::string> result;
  for (const std::string& setting : settings) {
    const auto equals = setting.find('=');
    if (equals == 0 || equals == std::string::npos || equals + 1 == setting.size())
      throw UsageError(fmt::format("--set {}: name=value is needed, for example --set length=1.5", setting));
    if (!result.emplace(setting.substr(0, equals), setting.substr(equals + 1)).second)
      throw UsageError(fmt::format("--set {}: is given twice", setting.substr(0, equals)));
  }
  return result;
}

void add_most_modes_option(Parser& command, int& most_modes) {
  command
      .add_option("--most-modes", most_modes,
                  "Keep at most this number of modes of each flexible body, the lowest\nones")
      .within(1, 100000)
      .type_name("N")
      .group("Method");
}

void add_set_option(Parser& command, std::vector<std::string>& settings) {
  command.add_option("--set", settings, "Replace a parameter of the model file; may be repeated")
      .type_name("NAME=VALUE")
      .repeated();
}

void add_strict_option(Parser& command, bool& strict) {
  command.add_flag("--strict", strict, "Exit with 4 if there is a warning");
}

int done_with(bool warnings, bool strict) { return warnings && strict ? warned : done; }

LoadedModel load(const std::string& path, const std::vector<std::string>& settings, bool quiet,
                 int most_modes) {
  std::vector<Diagnostic> warnings;
  LoadedModel loaded;
  {
    Busy busy(fmt::format("reading {} and reducing its flexible bodies", path), !quiet);
    spec::Model spec = load_model(path, overrides(settings), &warnings, &loaded.other_files);
    if (most_modes > 0) spec = with_lowest_modes(std::move(spec), most_modes);
    busy.now(fmt::format("laying out the {} bodies", spec.bodies.size()));
    loaded.model = Model::compile(brought_together(std::move(spec)));
  }
  for (const Diagnostic& warning : warnings) {
    fmt::print(stderr, "{}\n", diagnostic_line(warning, "warning"));
    loaded.warnings.push_back(to_string(warning));
  }
  return loaded;
}

std::string diagnostic_line(const Diagnostic& diagnostic, const std::string& severity) {
  const Mark& mark = diagnostic.mark;
  std::string place = mark.file;
  if (mark.line > 0) place += fmt::format(":{}:{}", mark.line, mark.column);
  return printable(fmt::format("{}: {}: {}", place.empty() ? "mimbre" : place, severity, diagnostic.message));
}

void print_error(const std::string& message) {
  fmt::print(stderr, "mimbre: error: {}\n", printable(message));
}
void print_warning(const std::string& message) {
  fmt::print(stderr, "mimbre: warning: {}\n", printable(message));
}

void print_data(const std::string& text) {
  errno = 0;
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
    throw Failure(fmt::format("cannot write to the standard output: {}", std::strerror(errno)));
}

}  // namespace mimbre::app
