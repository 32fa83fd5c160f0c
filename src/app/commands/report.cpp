#include "mimbre/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "app/common.h"
#include "app/json.h"
#include "app/targets.h"
#include "mimbre/reduced_body.h"

/// mimbre report: a results file as a page, or several compared on one.
namespace mimbre::app {
namespace {

struct ReportArguments {
  std::vector<std::string> results, labels, summaries;
  std::string output;
  bool json = false;
};

/// An option that is given once per results file, or not at all.
void require_one_per_file(const std::vector<std::string>& given, const char* option,
                          const ReportArguments& arguments) {
  if (given.empty() || given.size() == arguments.results.size()) return;
  throw UsageError(
      fmt::format("{} is given {} times for {} results files; give it once per file, in their order", option,
                  given.size(), arguments.results.size()));
}

std::string page_name(const ReportArguments& arguments) {
  if (!arguments.output.empty()) return arguments.output;
  if (arguments.results.size() > 1)
    throw UsageError("a page of several results needs a name; give it with -o FILE.html");
  return std::filesystem::path(arguments.results.front()).replace_extension(".html").string();
}

/// What `mimbre run --json` printed, which has the times that a results file has not. Throws InputError for
/// anything else, and for that of another run.
std::string measured_summary(const std::string& path, const Results& results) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(path, unknown)) throw InputError(Mark{path, 0, 0}, "is no file");
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto bad = [&](const std::string& what) { return InputError(Mark{path, 0, 0}, what); };
  if (!file) throw bad("cannot be read");
  const Json measured = Json::parse(text, nullptr, false);
  if (!measured.is_object() || !measured.contains("cpu_seconds"))
    throw bad("is not what `mimbre run --json` prints");
  const Json own = Json::parse(results.summary_json, nullptr, false);
  if (own.is_object())
    for (const auto& [key, value] : own.items())
      if (!measured.contains(key) || measured[key] != value)
        throw bad(fmt::format("is of another run than the results: '{}' differs", key));
  return text;
}

/// The page of a reduced body: its validation report and its modes.
int run_modes(const ReportArguments& arguments) {
  if (arguments.results.size() > 1)
    throw UsageError("a body's page has no room for other files; give the body alone");
  if (!arguments.labels.empty() || !arguments.summaries.empty())
    throw UsageError("--label and --summary are for results files, not for a body");
  const std::string output = page_name(arguments);
  require_different(arguments.results.front(), output);
  const ReducedBody body = load_reduced_body(arguments.results.front());
  require_writable(output);
  write_modes_report(body, output);
  print_data(made("report", output, arguments.json));
  return done;
}

int run_report(const ReportArguments& arguments) {
  if (std::any_of(arguments.results.begin(), arguments.results.end(), is_reduced_body))
    return run_modes(arguments);
  if (arguments.results.size() == 1 && !arguments.labels.empty())
    throw UsageError("--label names the runs of a comparison; there is one results file only");
  require_one_per_file(arguments.labels, "--label", arguments);
  require_one_per_file(arguments.summaries, "--summary", arguments);
  const std::string output = page_name(arguments);
  for (const std::string& path : arguments.results) require_different(path, output);
  for (const std::string& path : arguments.summaries) require_different(path, output);
  std::vector<ComparedRun> runs;
  for (std::size_t k = 0; k < arguments.results.size(); ++k) {
    ComparedRun run{read_results(arguments.results[k]), arguments.results[k], {}};
    if (!arguments.labels.empty()) run.label = arguments.labels[k];
    if (!arguments.summaries.empty())
      run.results.summary_json = measured_summary(arguments.summaries[k], run.results);
    runs.push_back(std::move(run));
  }
  require_writable(output);
  if (runs.size() > 1)
    write_comparison(runs, output);
  else
    write_report(runs.front().results, output);
  print_data(made("report", output, arguments.json));
  return done;
}

}  // namespace

Command add_report(CommandLine& program) {
  Parser parser = program.add_command(
      "report",
      "Make one HTML page of a results file, with plots and an animation, to open in a browser; of several, "
      "one that compares them; of a body that `mimbre reduce` made, one of its modes");
  const auto arguments = std::make_shared<ReportArguments>();
  parser
      .add_option("results", arguments->results,
                  "Results files (HDF5); the others are compared with the first. Or one reduced body")
      .required()
      .type_name("RESULTS.h5");
  parser.add_option("-o,--output", arguments->output, "The page; default, for one file: its name with .html")
      .type_name("FILE.html");
  parser
      .add_option("--label", arguments->labels,
                  "A run's name in a comparison, once per file in their order; default: what differs between "
                  "the runs")
      .type_name("NAME")
      .repeated();
  parser
      .add_option(
          "--summary", arguments->summaries,
          "What `mimbre run --json` printed, once per file in their order: CPU times, which a results "
          "file does not hold")
      .type_name("FILE.json")
      .repeated();
  parser.add_flag("--json", arguments->json, "The page's name as JSON");
  parser.footer(
      "Prints the page's name.\nExample:\n  mimbre report pendulum.h5 -o pendulum.html\n"
      "  mimbre report fine.h5 coarse.h5 --label 1ms --label 10ms -o steps.html\n"
      "  mimbre report arm.h5 -o modes.html");
  return {parser, [arguments] { return run_report(*arguments); }};
}

}  // namespace mimbre::app
