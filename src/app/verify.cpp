#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "app/common.h"
#include "app/method_options.h"
#include "app/progress.h"
#include "app/stepping.h"
#include "app/table.h"
#include "app/verify_series.h"

/// mimbre verify: one model in both formulations, and how far they lie apart.
namespace mimbre::app {
namespace {

using Formulation = spec::Simulation::Formulation;
constexpr std::array formulations{Formulation::relative, Formulation::natural};
constexpr std::array names{"relative", "natural"};
constexpr std::size_t channels_shown = 10;

struct Arguments {
  std::string model;
  std::vector<std::string> settings;
  MethodArguments method;
  std::optional<double> step, until;
  bool json = false, all = false, no_refine = false, quiet = false;
};

/// A run in one formulation.
struct Run {
  double step = 0;
  int coordinates = 0, constraints = 0;
  Series series;
  Totals totals;
  double energy_drift = std::numeric_limits<double>::quiet_NaN();  ///< J, that the numerics put in
  std::string failure;                                             ///< empty: it came to its end
  bool ok() const { return failure.empty(); }
};

/// Steps of `step`, sampled at every `stride`th. What goes wrong is told by the run, not thrown.
Run make_run(const LoadedModel& loaded, const RunOptions& options, const Plan& plan, Progress& progress) {
  Run run;
  run.step = options.step;
  try {
    Simulation simulation(loaded.model, options);
    run.coordinates = simulation.coordinates();
    run.constraints = simulation.constraints();
    run.series.info = simulation.channels();
    ResultsRow row;
    const auto sample = [&] {
      simulation.sample(row);
      run.series.time.push_back(row.time);
      run.series.channels.push_back(row.channels);
    };
    sample();
    const double end = static_cast<double>(plan.steps) * options.step;
    while (run.totals.steps < plan.steps) {
      const std::int64_t left = plan.steps - run.totals.steps;
      const StepReport report = advance(simulation, std::min(plan.stride, left), run.totals);
      if (!report.ok()) {
        run.failure = simulation.explain(report);
        break;
      }
      if (interrupted())
        throw Failure(fmt::format("interrupted at t = {:.6g} s of {:.6g} s", simulation.time(), end));
      sample();
      progress.update(simulation.time(), end, run.totals.cpu_seconds);
    }
    run.energy_drift = simulation.energy().numerical;
  } catch (const Failure&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const InputError& error) {
    // What the default formulation cannot start is a bad model.
    if (options.formulation == Formulation::relative) throw;
    run.failure = error.what();
  } catch (const std::exception& error) {
    run.failure = error.what();
  }
  return run;
}

/// The runs in both formulations at one step.
using Pair = std::array<Run, 2>;

Pair make_pair(const LoadedModel& loaded, RunOptions options, const Plan& plan, Progress& progress) {
  Pair pair;
  for (std::size_t f = 0; f < formulations.size(); ++f) {
    options.formulation = formulations[f];
    pair[f] = make_run(loaded, options, plan, progress);
  }
  return pair;
}

bool ok(const Pair& pair) { return pair[0].ok() && pair[1].ok(); }

/// Everything that is said.
struct Verification {
  std::string model;
  Json method;
  double end = 0;
  Pair whole;
  std::optional<Pair> half;
  Agreement agreement;

  /// "the natural formulation failed with the step 0.01 s: …", a line for each failure.
  std::vector<std::string> failures() const {
    std::vector<std::string> lines;
    const auto add = [&](const Pair& pair) {
      for (std::size_t f = 0; f < pair.size(); ++f)
        if (!pair[f].ok())
          lines.push_back(fmt::format("the {} formulation failed with the step {:.6g} s: {}", names[f],
                                      pair[f].step, pair[f].failure));
    };
    add(whole);
    if (half) add(*half);
    return lines;
  }
  bool compared() const { return ok(whole); }
  bool agree() const { return compared() && (!half || ok(*half)) && agreement.agree; }
};

Verification verify(const Arguments& arguments) {
  const LoadedModel loaded = load(arguments.model, arguments.settings);
  const spec::Simulation& given = loaded.model->spec().simulation;
  RunOptions options = run_options(arguments.method, given);
  options.step = arguments.step.value_or(given.step);
  const Plan plan = plan_run(arguments.until.value_or(given.end), given.output_interval, options.step);
  Verification v;
  v.model = arguments.model;
  v.method = method_in_force(options, given);
  v.method.erase("formulation");
  v.end = static_cast<double>(plan.steps) * options.step;
  catch_interrupts();
  Progress progress(!arguments.quiet);
  v.whole = make_pair(loaded, options, plan, progress);
  std::vector<Apart> whole, half;
  if (v.compared()) whole = differences(v.whole[0].series, v.whole[1].series);
  for (Run& run : v.whole) run.series = {};
  if (v.compared() && !arguments.no_refine) {
    options.step /= 2;
    v.half = make_pair(loaded, options, {2 * plan.steps, 2 * plan.stride}, progress);
    if (ok(*v.half)) half = differences((*v.half)[0].series, (*v.half)[1].series);
    for (Run& run : *v.half) run.series = {};
  }
  v.agreement = agreement(whole, half);
  return v;
}

Json number_or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

/// {"relative": …, "natural": …}
template <class Get>
Json of_both(const Pair& pair, const Get& get) {
  Json json;
  for (std::size_t f = 0; f < pair.size(); ++f) json[names[f]] = get(pair[f]);
  return json;
}

Json to_json(const Pair& pair) {
  Json json;
  json["step"] = pair[0].step;
  json["steps"] = of_both(pair, [](const Run& r) { return r.totals.steps; });
  json["iterations"] = of_both(pair, [](const Run& r) { return r.totals.iterations; });
  json["cpu_seconds"] = of_both(pair, [](const Run& r) { return r.totals.cpu_seconds; });
  json["position_violation"] = of_both(pair, [](const Run& r) { return r.totals.max_position_violation; });
  json["velocity_violation"] = of_both(pair, [](const Run& r) { return r.totals.max_velocity_violation; });
  json["energy_drift"] = of_both(pair, [](const Run& r) { return r.energy_drift; });
  return json;
}

Json to_json(const Verification& v) {
  Json json;
  json["status"] = v.failures().empty() ? "ok" : "failed";
  json["model"] = v.model;
  json["until"] = v.end;
  json.update(v.method);
  json["agree"] = v.agree();
  json["refinement_ratio"] = number_or_null(v.agreement.ratio);
  json["coordinates"] = of_both(v.whole, [](const Run& r) { return r.coordinates; });
  json["constraints"] = of_both(v.whole, [](const Run& r) { return r.constraints; });
  if (v.compared()) json["verdict"] = verdict(v.agreement);
  if (!v.failures().empty()) json["failures"] = v.failures();
  json.update(to_json(v.whole));
  if (v.half) json["half_step"] = to_json(*v.half);
  json["channels"] = Json::array();
  for (const Refined& c : v.agreement.channels) {
    Json channel{{"name", c.whole.name},
                 {"unit", c.whole.unit},
                 {"max_difference", c.whole.max_difference},
                 {"time", c.whole.time},
                 {"rms_difference", c.whole.rms_difference},
                 {"range", c.whole.range},
                 {"relative_difference", c.whole.relative_difference}};
    if (c.half) {
      channel["half_step_difference"] = c.half->max_difference;
      channel["half_step_rms_difference"] = c.half->rms_difference;
      channel["half_step_relative_difference"] = c.half->relative_difference;
      channel["ratio"] = number_or_null(c.ratio());
    }
    json["channels"].push_back(std::move(channel));
  }
  return json;
}

std::string channel_table(const Agreement& agreement, bool all) {
  Table table({"channel", "unit", "largest difference", "at t, s", "% of range", "% with half the step",
               "times smaller"});
  const std::size_t count =
      all ? agreement.channels.size() : std::min(channels_shown, agreement.channels.size());
  for (std::size_t k = 0; k < count; ++k) {
    const Refined& c = agreement.channels[k];
    table.add({c.whole.name, c.whole.unit, fmt::format("{:.4g}", c.whole.max_difference),
               fmt::format("{:.6g}", c.whole.time), fmt::format("{:.3g}", 100 * c.whole.relative_difference),
               c.half ? fmt::format("{:.3g}", 100 * c.half->relative_difference) : "",
               c.ratio() ? fmt::format("{:.3g}", *c.ratio()) : ""});
  }
  std::string text = table.text();
  if (count < agreement.channels.size())
    text +=
        fmt::format("({} more channels agree better; --all shows them)\n", agreement.channels.size() - count);
  return text;
}

std::string run_table(const Verification& v) {
  Table table({"formulation", "coordinates", "step, s", "steps", "iterations per step", "CPU s",
               "position violation, m", "velocity violation, m/s", "energy drift, J"});
  const auto add = [&](const Pair& pair) {
    for (std::size_t f = 0; f < pair.size(); ++f) {
      const Totals& t = pair[f].totals;
      const double steps = static_cast<double>(std::max<std::int64_t>(t.steps, 1));
      table.add({names[f], fmt::format("{}", pair[f].coordinates), fmt::format("{:.6g}", pair[f].step),
                 fmt::format("{}", t.steps), fmt::format("{:.3g}", static_cast<double>(t.iterations) / steps),
                 fmt::format("{:.4g}", t.cpu_seconds), fmt::format("{:.3g}", t.max_position_violation),
                 fmt::format("{:.3g}", t.max_velocity_violation),
                 fmt::format("{:.3g}", pair[f].energy_drift)});
    }
  };
  add(v.whole);
  if (v.half) add(*v.half);
  return table.text();
}

std::string to_report(const Verification& v, bool all) {
  std::string text;
  if (v.compared()) text += verdict(v.agreement) + "\n\n" + channel_table(v.agreement, all) + '\n';
  return text + run_table(v);
}

int run(const Arguments& arguments) {
  const Verification v = verify(arguments);
  print_data(arguments.json ? to_text(to_json(v)) + '\n' : to_report(v, arguments.all));
  for (const std::string& failure : v.failures()) print_error(failure);
  if (v.failures().empty() && !v.agree()) {
    const std::string text = verdict(v.agreement);
    print_warning(text.substr(0, text.find('\n')));
  }
  return v.failures().empty() ? done : failed;
}

}  // namespace

Command add_verify(CLI::App& program) {
  CLI::App* parser = program.add_subcommand(
      "verify", "Run a model in both formulations, relative and natural coordinates, and compare them");
  const auto arguments = std::make_shared<Arguments>();
  parser->add_option("model", arguments->model, "Model file (YAML)")->required()->type_name("MODEL");
  add_set_option(*parser, arguments->settings);
  parser->add_option("--step", arguments->step, "Step in s, instead of the model's")
      ->check(number_from(0, INFINITY, true))
      ->type_name("H");
  parser->add_option("--until", arguments->until, "End in s, instead of the model's")
      ->check(number_from(0, INFINITY))
      ->type_name("T");
  parser->add_flag("--no-refine", arguments->no_refine, "Leave out the runs with half the step");
  parser->add_flag("--all", arguments->all, "All channels, not only the ones that differ most");
  parser->add_flag("--json", arguments->json, "The same as JSON, with all channels");
  parser->add_flag("-q,--quiet", arguments->quiet, "No progress line");
  add_method_options(*parser, arguments->method, {.formulation = false, .motion = true});
  parser->footer(
      "The two formulations are programmed apart and integrate different coordinates, so that their results "
      "differ by\n"
      "an error that falls with the square of the step: with half the step it is about 4 times smaller. A "
      "difference\n"
      "that does not fall is a mistake in one of them, or a step that is far too long.\n"
      "Exit codes: 0 both ran (\"agree\" says whether they agree: to 1 % of the range of every channel, or "
      "nearer with\n"
      "every halving), 1 the model is bad, 2 wrong use, 3 one of them failed.\n"
      "Example:\n  mimbre verify pendulum.yaml --until 2");
  return {parser, [arguments] { return run(*arguments); }};
}

}  // namespace mimbre::app
