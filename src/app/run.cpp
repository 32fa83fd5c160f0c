#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/advice.h"
#include "app/busy.h"
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
  bool json = false, quiet = false, strict = false, csv_units = false;
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

void check_targets(const Arguments& arguments, const LoadedModel& loaded) {
  for (const std::string& path : {arguments.output, arguments.csv}) {
    if (path.empty()) continue;
    require_different(arguments.model, path);
    for (const std::string& input : loaded.other_files) require_different(input, path);
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
      std::vector<std::string> columns, units;
      for (int k = 0; k < simulation.output_count(); ++k) {
        columns.push_back(simulation.channels()[k].name);
        if (arguments.csv_units) units.push_back(simulation.channels()[k].unit);
      }
      csv_ = std::make_unique<CsvWriter>(arguments.csv, columns, units);
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

  /// Writes what has been waiting for long.
  void flush_if_due() {
    if (results_) results_->flush_if_due();
    if (csv_) csv_->flush_if_due();
  }

  /// Closes both files, whatever happened to the other; the first thing that goes wrong is thrown afterwards.
  /// What is `whole` takes the place of older files, what is not stays beside them. Returns what is kept
  /// then.
  std::vector<std::string> finish(const std::string& summary, bool whole) {
    std::vector<std::string> kept;
    std::exception_ptr first;
    const auto keep_first = [&](auto&& work) {
      try {
        work();
      } catch (const std::exception&) {
        if (!first) first = std::current_exception();
      }
    };
    const auto close = [&](auto& writer, const auto&... text) {
      if (whole) return writer.finish(text...);
      const std::string path = writer.keep(text...);
      kept.push_back(fmt::format("{} rows in '{}'", writer.rows(), path));
    };
    if (results_) keep_first([&] { close(*results_, summary); });
    if (csv_) keep_first([&] { close(*csv_); });
    if (first) std::rethrow_exception(first);
    return kept;
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
  // Without files the clock is read once, with a progress line a few hundred times.
  const std::int64_t chunk = progress.shown() ? plan.steps / 500 + 1 : plan.steps;
  std::int64_t recorded = 0;
  const auto stop = [&] {
    recorder.flush_if_due();
    return interrupted();
  };
  // Where a run stops is its last row, too.
  const auto stopped = [&](Ending ending) {
    if (recorded < totals.steps) recorder.record(simulation);
    return ending;
  };
  try {
    recorder.record(simulation);
    while (totals.steps < plan.steps) {
      const std::int64_t until =
          recorder.recording() ? plan.next_row(totals.steps) : std::min(totals.steps + chunk, plan.steps);
      const StepReport report = advance(simulation, plan, until, totals, stop);
      if (!report.ok()) return stopped({"failed", simulation.explain(report)});
      if (totals.steps == until) {
        recorder.record(simulation);
        recorded = until;
      }
      progress.update(simulation.time(), plan.end, totals.cpu_seconds);
      if (interrupted() && totals.steps < plan.steps)
        return stopped({"interrupted",
                        fmt::format("interrupted at t = {:.6g} s of {:.6g} s", simulation.time(), plan.end)});
    }
  } catch (const std::exception& error) {
    return {"failed", error.what()};
  }
  return {};
}

int run(const Arguments& arguments) {
  const LoadedModel loaded = load(arguments.model, arguments.settings, arguments.quiet);
  check_targets(arguments, loaded);
  const spec::Simulation& given = loaded.model->spec().simulation;
  RunOptions options = run_options(arguments.method, given);
  options.step = arguments.step.value_or(0);
  const RunPlan plan = planned(given, options, arguments.step, arguments.until);
  const std::unique_ptr<Simulation> made = [&] {
    const Busy busy("assembling the mechanism", !arguments.quiet);
    return std::make_unique<Simulation>(loaded.model, options);
  }();
  Simulation& simulation = *made;
  if (!arguments.quiet) print_advice(simulation);

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
  std::vector<std::string> kept;
  try {
    kept =
        recorder.finish(to_text(run_summary(simulation, totals, ending, warnings)), ending.message.empty());
  } catch (const std::exception& error) {
    if (ending.message.empty()) ending = {"failed", error.what()};
  }

  if (!ending.message.empty()) {
    print_error(ending.message);
    if (!kept.empty())
      fmt::print(stderr, "mimbre: what was computed until then is kept: {} ({} steps of {})\n",
                 fmt::join(kept, ", "), totals.steps, plan.steps);
  }
  if (arguments.json) {
    Json summary = answer("run");
    summary.update(run_summary(simulation, totals, ending, warnings));
    summary["units"] = output_units(simulation);
    add_measurements(summary, simulation, totals);
    print_data(to_text(summary) + '\n');
  } else if (!arguments.quiet) {
    print_data(summary_table(simulation, totals));
  }
  return ending.message.empty() ? done_with(!warnings.empty(), arguments.strict) : failed;
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
  parser.add_flag("--csv-units", arguments->csv_units, "A second line in the table: the columns' units");
  parser.add_flag("--json", arguments->json, "The summary as JSON");
  parser.add_flag("-q,--quiet", arguments->quiet, "No progress line and no summary table");
  add_strict_option(parser, arguments->strict);
  add_method_options(parser, arguments->method);
  parser.footer(
      "The summary goes to the standard output, as a table or with --json as JSON; warnings, errors and the "
      "progress line\ngo to the standard error.\n"
      "The run ends at its end: the last step is shorter where the end is no whole number of steps. Rows are "
      "written at the\n"
      "start, at the end, and at the first step at or after every multiple of the model's output_interval.\n"
      "Exit codes: 0 done, 1 the model is bad, 2 wrong use, 3 a step failed, a file could not be written, or "
      "the run\n"
      "was interrupted (the results up to then are kept, beside older files), 4 done with warnings, where "
      "--strict was given.\n"
      "Example:\n  mimbre run pendulum.yaml --set length=2 --until 10 --output pendulum.h5 --csv "
      "pendulum.csv");
  return {parser, [arguments] { return run(*arguments); }};
}

}  // namespace mimbre::app
