#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/common.h"
#include "app/interrupts.h"
#include "app/json.h"
#include "app/method_options.h"
#include "app/progress.h"
#include "app/summary.h"
#include "app/targets.h"
#include "mimbre/results.h"
#include "mimbre/run.h"

/// mimbre run: simulates a model.
namespace mimbre::app {
namespace {

struct Arguments {
  std::string model, output, csv;
  std::vector<std::string> settings;
  MethodArguments method;
  std::optional<double> step, until;
  bool json = false, quiet = false;
};

/// What of the command line decides the results; kept in the results file.
std::string options_json(const Arguments& arguments) {
  Json json = Json::object();
  for (const auto& [name, value] : overrides(arguments.settings)) json["set"][name] = value;
  if (arguments.step) json["step"] = *arguments.step;
  if (arguments.until) json["until"] = *arguments.until;
  json.update(to_json(arguments.method));
  return to_text(json);
}

void check_targets(const Arguments& arguments) {
  for (const std::string& path : {arguments.output, arguments.csv}) {
    if (path.empty()) continue;
    require_different(arguments.model, path);
    require_no_body(path);
    require_writable(path);
  }
  if (!arguments.output.empty() && !arguments.csv.empty()) require_different(arguments.output, arguments.csv);
}

/// Puts the simulation's rows into the files that were asked for.
class Recorder {
 public:
  Recorder(const Arguments& arguments, const Simulation& simulation) {
    if (!arguments.output.empty())
      results_ =
          std::make_unique<ResultsWriter>(arguments.output, simulation.header(options_json(arguments)));
    if (!arguments.csv.empty()) {
      std::vector<std::string> columns;
      for (int k = 0; k < simulation.output_count(); ++k) columns.push_back(simulation.channels()[k].name);
      csv_ = std::make_unique<CsvWriter>(arguments.csv, columns);
    }
  }

  bool recording() const { return results_ || csv_; }

  void record(Simulation& simulation) {
    if (!recording()) return;
    simulation.sample(row_);
    if (results_) results_->add(row_);
    outputs_ = row_.channels.head(simulation.output_count());
    if (csv_) csv_->add(row_.time, outputs_);
  }

  /// Closes both files, whatever happened to the other; the first thing that goes wrong is thrown afterwards.
  void finish(const std::string& summary) {
    std::exception_ptr first;
    const auto keep_first = [&](auto&& work) {
      try {
        work();
      } catch (const std::exception&) {
        if (!first) first = std::current_exception();
      }
    };
    if (results_) keep_first([&] { results_->finish(summary); });
    if (csv_) keep_first([&] { csv_->finish(); });
    if (first) std::rethrow_exception(first);
  }

 private:
  std::unique_ptr<ResultsWriter> results_;
  std::unique_ptr<CsvWriter> csv_;
  ResultsRow row_;
  Eigen::VectorXd outputs_;
};

/// The stepping loop with its output. What goes wrong in it is told by the ending, so that the results so far
/// are kept.
Ending simulate(Simulation& simulation, const RunPlan& plan, Recorder& recorder, Progress& progress,
                RunTotals& totals) {
  const double end = static_cast<double>(plan.steps) * simulation.step_size();
  // Without files the clock is read once, with a progress line a few hundred times.
  const std::int64_t chunk = recorder.recording() ? plan.stride
                             : progress.shown()   ? plan.steps / 500 + 1
                                                  : plan.steps;
  try {
    recorder.record(simulation);
    while (totals.steps < plan.steps) {
      const StepReport report =
          advance(simulation, std::min(chunk, plan.steps - totals.steps), totals, interrupted);
      if (!report.ok()) return {"failed", simulation.explain(report)};
      if (totals.steps % plan.stride == 0) recorder.record(simulation);
      progress.update(simulation.time(), end, totals.cpu_seconds);
      if (interrupted() && totals.steps < plan.steps)
        return {"interrupted",
                fmt::format("interrupted at t = {:.6g} s of {:.6g} s", simulation.time(), end)};
    }
  } catch (const std::exception& error) {
    return {"failed", error.what()};
  }
  return {};
}

int run(const Arguments& arguments) {
  const LoadedModel loaded = load(arguments.model, arguments.settings);
  check_targets(arguments);
  const spec::Simulation& given = loaded.model->spec().simulation;
  RunOptions options = run_options(arguments.method, given);
  options.step = arguments.step.value_or(0);
  Simulation simulation(loaded.model, options);
  const RunPlan plan =
      plan_run(arguments.until.value_or(given.end), given.output_interval, simulation.step_size());

  catch_interrupts();
  Recorder recorder(arguments, simulation);
  Progress progress(!arguments.quiet);
  RunTotals totals;
  Ending ending = simulate(simulation, plan, recorder, progress, totals);
  progress.clear();

  std::vector<std::string> warnings = loaded.warnings;
  for (const std::string& warning : simulation.warnings()) {
    print_warning(warning);
    warnings.push_back(warning);
  }
  try {
    recorder.finish(to_text(run_summary(simulation, totals, ending, warnings)));
  } catch (const std::exception& error) {
    if (ending.message.empty()) ending = {"failed", error.what()};
  }

  if (!ending.message.empty()) {
    print_error(ending.message);
    if (recorder.recording())
      fmt::print(stderr, "mimbre: the results up to then were kept ({} steps of {})\n", totals.steps,
                 plan.steps);
  }
  if (arguments.json) {
    Json summary = run_summary(simulation, totals, ending, warnings);
    add_measurements(summary, simulation, totals);
    print_data(to_text(summary) + '\n');
  } else if (!arguments.quiet) {
    fmt::print(stderr, "{}", summary_table(simulation, totals));
  }
  return ending.message.empty() ? done : failed;
}

}  // namespace

Command add_run(CommandLine& program) {
  Parser parser = program.add_command("run", "Simulate a model");
  const auto arguments = std::make_shared<Arguments>();
  parser.add_option("model", arguments->model, "Model file (YAML)").required().type_name("MODEL");
  add_set_option(parser, arguments->settings);
  parser.add_option("--step", arguments->step, "Step in s, instead of the model's").above(0).type_name("H");
  parser.add_option("--until", arguments->until, "End in s, instead of the model's").from(0).type_name("T");
  parser.add_option("-o,--output", arguments->output, "Results file (HDF5): every channel, poses, modes")
      .type_name("FILE.h5");
  parser.add_option("--csv", arguments->csv, "Table of the model's outputs (CSV)").type_name("FILE.csv");
  parser.add_flag("--json", arguments->json, "The run's summary as JSON on the standard output");
  parser.add_flag("-q,--quiet", arguments->quiet, "No progress line and no summary table");
  add_method_options(parser, arguments->method);
  parser.footer(
      "Exit codes: 0 done, 1 the model is bad, 2 wrong use, 3 a step failed, a file could not be written, or "
      "the run\n"
      "was interrupted; the results up to then are kept.\n"
      "Example:\n  mimbre run pendulum.yaml --set length=2 --until 10 --output pendulum.h5 --csv "
      "pendulum.csv");
  return {parser, [arguments] { return run(*arguments); }};
}

}  // namespace mimbre::app
