#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/advice.h"
#include "app/common.h"
#include "app/input_tables.h"
#include "app/json.h"
#include "app/method_options.h"
#include "app/recorder.h"
#include "app/summary.h"
#include "app/targets.h"
#include "app/terminal/busy.h"
#include "app/terminal/interrupts.h"
#include "app/terminal/progress.h"
#include "mimbre/run.h"

/// mimbre run: simulates a model.
namespace mimbre::app {
namespace {

struct RunArguments {
  std::string model, output, csv, state, resume;
  std::vector<std::string> settings, inputs;
  RunOptions method;
  std::optional<double> until, every;
  int most_modes = 0;
  bool json = false, quiet = false, strict = false, csv_units = false;
};

/// What of the command line decides the results; kept in the results file.
std::string options_json(const RunArguments& arguments) {
  Json json = Json::object();
  for (const auto& [name, value] : overrides(arguments.settings)) json["set"][name] = value;
  if (arguments.until) json["until"] = *arguments.until;
  for (const std::string& input : arguments.inputs) json["input"].push_back(input);
  if (arguments.most_modes > 0) json["most_modes"] = arguments.most_modes;
  json.update(arguments_json(arguments.method));
  return to_text(json);
}

/// The same in a saved state: tables by their content, whose files may have other names or other values when
/// the run continues.
std::string saved_options_json(const RunArguments& arguments, const RecordedInputs& inputs) {
  Json json = Json::parse(options_json(arguments));
  json.erase("input");
  for (const auto& [name, hash] : inputs.fingerprints()) json["input"][name] = fmt::format("{:016x}", hash);
  return to_text(json);
}

void check_targets(const RunArguments& arguments, const LoadedModel& loaded,
                   const std::vector<std::string>& files) {
  const std::string* const targets[] = {&arguments.output, &arguments.csv, &arguments.state};
  for (const std::string* target : targets) {
    const std::string& path = *target;
    if (path.empty()) continue;
    if (target != &arguments.state && !arguments.resume.empty()) require_different(arguments.resume, path);
    for (const std::string* other : targets)
      if (other != target && !other->empty()) require_different(*other, path);
    require_not_read(arguments.model, loaded, path);
    for (const std::string& input : files) require_different(input, path);
    require_no_body(path);
    require_writable(path);
  }
}

/// Saves the run now and then; without a file never.
struct Saving {
  std::string path;
  RunPlan times;  ///< the plan with the interval of saving as that of the rows
  RunState state;

  bool wanted() const { return !path.empty(); }
  void save(const Simulation& simulation, const RunTotals& totals, Recorder& recorder) {
    recorder.describe(state);
    simulation.save(state.snapshot);
    state.totals = totals;
    write_run_state(path, state);
    recorder.remove_what_was_taken_over();
  }
};

/// The stepping loop with its output, from where the totals are. The ending reports what goes wrong in it,
/// so that the results so far are kept.
Ending simulate(Simulation& simulation, const RunPlan& plan, RecordedInputs& inputs, Recorder& recorder,
                Progress& progress, Saving& saving, RunTotals& totals, const std::function<void()>& begin) {
  // Without files the clock is read once, with a progress line a few hundred times.
  const std::int64_t chunk = progress.shown() ? plan.steps / 500 + 1 : plan.steps;
  std::int64_t& recorded = saving.state.recorded;
  const auto stop = [&] {
    inputs.set(simulation);
    recorder.flush_if_due();
    return interrupted();
  };
  // Where a run stops is its last row, too.
  const auto stopped = [&](Ending ending) {
    if (recorded < totals.steps) recorder.record(simulation);
    return ending;
  };
  try {
    begin();
    // A saved run that an event stopped has come to its end.
    if (simulation.stopped() && saving.wanted()) saving.save(simulation, totals, recorder);
    while (totals.steps < plan.steps && !simulation.stopped()) {
      const std::int64_t row = recorder.recording() ? plan.next_row(totals.steps) : plan.steps;
      const std::int64_t save = saving.wanted() ? saving.times.next_row(totals.steps) : plan.steps;
      const std::int64_t pause = recorder.recording() ? plan.steps : totals.steps + chunk;
      const StepReport report = advance(simulation, plan, std::min({row, save, pause}), totals, stop);
      if (!report.ok()) return stopped({"failed", simulation.explain(report)});
      if (totals.steps == row || simulation.stopped()) {
        recorder.record(simulation);
        recorded = totals.steps;
      }
      if (simulation.stopped()) {
        if (saving.wanted()) saving.save(simulation, totals, recorder);
        return {};
      }
      const bool ends = interrupted() && totals.steps < plan.steps;
      if (saving.wanted() && (totals.steps == save || ends)) saving.save(simulation, totals, recorder);
      progress.update(simulation.time(), plan.end, totals.cpu_seconds);
      if (ends)
        return stopped(
            {"interrupted",
             fmt::format("interrupted at t = {:.6g} s of {:.6g} s{}", simulation.time(), plan.end,
                         saving.wanted() ? fmt::format("; --resume {} continues from there", saving.path)
                                         : std::string())});
    }
  } catch (const std::exception& error) {
    return {"failed", error.what()};
  }
  return {};
}

/// An input that the saved run played from a table is played from the same one. `now`, `then`: options.
void require_same_tables(const InputTables& played, const Json& now, const Json& then) {
  const Json before = then.value("input", Json::object());
  for (const auto& [name, file] : played.file_of_input)
    if (before.contains(name) && before[name] != now["input"][name])
      throw InputError(Mark{file, 0, 0},
                       fmt::format("the table of input '{}' is not the one that the saved run played: a run "
                                   "continues with the same times and values only",
                                   name));
}

/// Options that decide the results must be those of the saved run; it may end later.
void require_same_options(const RunArguments& arguments, const InputTables& played, const RunState& saved) {
  Json now = Json::parse(saved_options_json(arguments, played.tables)),
       then = Json::parse(saved.options_json);
  require_same_tables(played, now, then);
  now.erase("until");
  then.erase("until");
  if (now == then) return;
  const Json change = Json::diff(then, now);
  const std::string where = change.empty() ? std::string() : change[0].value("path", "");
  throw UsageError(
      fmt::format("the saved run was made with other options: it had {}, and here there are {} (they differ "
                  "in '{}'); only --until may differ",
                  then.dump(), now.dump(), where.empty() ? where : where.substr(1)));
}

/// The file that a saved run was writing, under the name that it has now.
std::string file_of_rows(const std::string& grown) {
  std::error_code error;
  const std::string whole = file_when_whole(grown);
  return whole.empty() || std::filesystem::exists(grown, error) ? grown : whole;
}

/// Puts a simulation to where a saved run was.
void resume(const RunArguments& arguments, const RunState& saved, const RunPlan& plan,
            Simulation& simulation) {
  if (saved.totals.steps > plan.steps || saved.snapshot.time > plan.end)
    throw UsageError(fmt::format("the saved run is at t = {:.6g} s already, the end asked for is {:.6g} s",
                                 saved.snapshot.time, plan.end));
  if (saved.snapshot.model != simulation.fingerprint())
    throw InputError(Mark{arguments.model, 0, 0},
                     fmt::format("the state in '{}' was saved of another model, or the model (or a file that "
                                 "it names) has been changed since; a run continues with the same model only",
                                 arguments.resume));
  if (saved.program != this_program())
    print_warning(
        fmt::format("the state in '{}' was saved by another program ({}; this is {}): the run continues "
                    "correctly, but not bit for bit",
                    arguments.resume, saved.program, this_program()));
  const auto same_files = [&](const char* option, const std::string& now, const std::string& then) {
    if (now.empty() == then.empty()) return;
    throw UsageError(
        then.empty()
            ? fmt::format("the saved run had no {}, so that its first rows are missing; continue without",
                          option)
            : fmt::format("the saved run had {}; give it here as well (its rows are in '{}')", option,
                          file_of_rows(then)));
  };
  same_files("--output", arguments.output, saved.results);
  same_files("--csv", arguments.csv, saved.csv);
  simulation.restore(saved.snapshot);
}

/// The row at the end of the saved run goes where the run goes on, and one to the later end would have none.
void drop_old_end(RunState& saved, const RunPlan& plan, const Simulation& simulation,
                  std::vector<ResultsRow>& rows) {
  if (rows.size() < 2 || saved.recorded == 0 || simulation.stopped()) return;
  std::int64_t last = 0;
  while (plan.next_row(last) < saved.recorded) last = plan.next_row(last);
  if (plan.next_row(last) == saved.recorded) return;
  rows.pop_back();
  saved.recorded = last;
}

/// Options that need others; the file of the saved run is that of the resumed one, if none is named.
RunArguments completed(RunArguments arguments) {
  if (arguments.every && arguments.state.empty()) {
    if (arguments.resume.empty()) throw UsageError("--every belongs to --save-state FILE");
    arguments.state = arguments.resume;
  }
  if (arguments.csv_units && arguments.csv.empty()) throw UsageError("--csv-units belongs to --csv FILE.csv");
  return arguments;
}

std::unique_ptr<Simulation> assembled(const LoadedModel& loaded, const RunOptions& options, bool quiet) {
  const Busy busy("assembling the mechanism", !quiet);
  return std::make_unique<Simulation>(loaded.model, options);
}

/// Warnings of loading and of the run; the latter are printed.
std::vector<std::string> print_warnings(const LoadedModel& loaded, const Simulation& simulation) {
  std::vector<std::string> warnings = loaded.warnings;
  for (const std::string& warning : simulation.warnings()) {
    print_warning(warning);
    warnings.push_back(warning);
  }
  return warnings;
}

void print_default_end(const Simulation& simulation, const RunPlan& plan) {
  if (simulation.method().default_end)
    fmt::print(stderr,
               "mimbre: note: the model has no end: the run ends at {} s (set it by --until, or by `end` "
               "in its section `simulation`)\n",
               plan.end);
}

int run_model(const RunArguments& given_arguments) {
  const RunArguments arguments = completed(given_arguments);
  const LoadedModel loaded = load(arguments.model, arguments.settings, arguments.quiet, arguments.most_modes);
  InputTables played = input_tables(arguments.inputs, loaded.model->spec().inputs);
  RecordedInputs& inputs = played.tables;
  check_targets(arguments, loaded, played.files);
  const spec::Simulation& given = loaded.model->spec().simulation;
  std::optional<RunState> saved;
  if (!arguments.resume.empty()) {
    saved = read_run_state(arguments.resume);
    require_same_options(arguments, played, *saved);
  }
  RunOptions options = run_options(arguments.method, given);
  options.end = arguments.until;
  options.inputs = inputs.start();
  const RunPlan plan = planned(given, options);
  const std::unique_ptr<Simulation> owner = assembled(loaded, options, arguments.quiet);
  Simulation& simulation = *owner;
  inputs.attach(simulation);
  if (const std::string why = simulation.not_saved(); !why.empty() && !arguments.state.empty())
    throw InputError(Mark{arguments.model, 0, 0}, why + "; run without --save-state");
  if (!arguments.quiet) {
    print_default_end(simulation, plan);
    print_advice(simulation);
  }

  catch_interrupts();
  const RunFiles files{arguments.output, arguments.csv, arguments.csv_units};
  std::vector<ResultsRow> rows;
  if (saved) {
    resume(arguments, *saved, plan, simulation);
    if (saved->rows.count > 0) rows = recorded_rows(*saved, files, simulation.output_count());
    drop_old_end(*saved, plan, simulation, rows);
    if (simulation.stopped() && !arguments.quiet)
      fmt::print(stderr, "mimbre: note: an event stopped the saved run at t = {:.6g} s: it ends there\n",
                 simulation.time());
  }
  Recorder recorder(files, simulation, options_json(arguments));
  RunTotals totals;
  Saving saving{arguments.state, plan, {}};
  saving.times.output_interval = arguments.every.value_or(2 * plan.end);  // none: at the end
  saving.state.options_json = saved_options_json(arguments, inputs);
  saving.state.program = this_program();
  if (saved) {
    totals = saved->totals;
    saving.state.recorded = saved->recorded;
  }
  Progress progress(!arguments.quiet);
  Ending ending = simulate(simulation, plan, inputs, recorder, progress, saving, totals, [&] {
    if (saved)
      recorder.take_over(*saved, rows);
    else
      recorder.record(simulation);
  });
  progress.clear();

  const std::vector<std::string> warnings = print_warnings(loaded, simulation);
  std::vector<std::string> kept;
  try {
    kept = recorder.finish(run_summary(simulation, totals, ending, warnings), ending.message.empty());
  } catch (const std::exception& error) {
    if (ending.message.empty()) ending = {"failed", error.what()};
  }

  if (!ending.message.empty()) {
    print_error(ending.message);
    if (!kept.empty())
      fmt::print(stderr, "mimbre: the results until then are kept: {} ({} steps of {})\n",
                 fmt::join(kept, ", "), totals.steps, plan.steps);
  }
  if (arguments.json) {
    Json summary = answer("run");
    summary.update(Json::parse(run_summary(simulation, totals, ending, warnings)));
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
  const auto arguments = std::make_shared<RunArguments>();
  parser.add_option("model", arguments->model, "Model file (YAML)").required().type_name("MODEL");
  add_set_option(parser, arguments->settings);
  add_input_option(parser, arguments->inputs);
  parser.add_option("--until", arguments->until, "End in s, instead of the model's").from(0).type_name("T");
  parser.add_option("-o,--output", arguments->output, "Results file (HDF5): every channel, poses, modes")
      .type_name("FILE.h5");
  parser.add_option("--csv", arguments->csv, "Table of the model's outputs (CSV)").type_name("FILE.csv");
  parser
      .add_option("--save-state", arguments->state,
                  "File for the state, written every --every seconds, at the end, and when\nthe run is "
                  "interrupted: --resume continues from it")
      .type_name("FILE");
  parser.add_option("--every", arguments->every, "Simulated seconds from one saved state to the next")
      .above(0)
      .type_name("S");
  parser
      .add_option("--resume", arguments->resume,
                  "Continue from a saved state, with the same model and options, to the same\nresults as "
                  "without the interruption")
      .type_name("FILE");
  parser.add_flag("--csv-units", arguments->csv_units, "A second line in the table: the columns' units");
  parser.add_flag("--json", arguments->json, "The summary as JSON");
  parser.add_flag("-q,--quiet", arguments->quiet, "No progress line and no summary table");
  add_strict_option(parser, arguments->strict);
  add_method_options(parser, arguments->method);
  add_most_modes_option(parser, arguments->most_modes);
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
  return {parser, [arguments] { return run_model(*arguments); }};
}

}  // namespace mimbre::app
