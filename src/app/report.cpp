#include "mimbre/report.h"

#include <filesystem>

#include "app/common.h"
#include "app/targets.h"

/// mimbre report: a results file as a page.
namespace mimbre::app {
namespace {

struct Arguments {
  std::string results, output;
};

int run(const Arguments& arguments) {
  const std::string output =
      arguments.output.empty() ? std::filesystem::path(arguments.results).replace_extension(".html").string()
                               : arguments.output;
  require_different(arguments.results, output);
  const Results results = read_results(arguments.results);
  require_writable(output);
  write_report(results, output);
  print_data(output + '\n');
  return done;
}

}  // namespace

Command add_report(CLI::App& program) {
  CLI::App* parser = program.add_subcommand(
      "report", "Make one HTML page of a results file, with plots and an animation, to open in a browser");
  const auto arguments = std::make_shared<Arguments>();
  parser->add_option("results", arguments->results, "Results file (HDF5)")
      ->required()
      ->type_name("RESULTS.h5");
  parser->add_option("-o,--output", arguments->output, "The page; default: the results' name with .html")
      ->type_name("FILE.html");
  parser->footer("Prints the page's name.\nExample:\n  mimbre report pendulum.h5 -o pendulum.html");
  return {parser, [arguments] { return run(*arguments); }};
}

}  // namespace mimbre::app
