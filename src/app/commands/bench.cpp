#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/common.h"
#include "app/json.h"
#include "app/method_options.h"
#include "app/summary.h"
#include "app/terminal/table.h"
#include "mimbre/run.h"
#include "mimbre/run_summary.h"

/// mimbre bench: how fast models run on this machine.
namespace mimbre::app {
namespace {

struct BenchArguments {
  std::vector<std::string> models, settings;
  RunOptions method;
  std::optional<double> until;
  int runs = 5;
  bool json = false;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

/// What one model took: the contents of the table and the JSON.
struct Measurement {
  std::string model;
  Json method;  ///< in force
  int coordinates = 0, elastic_coordinates = 0;
  double step = 0;
  RunTotals totals;                 ///< of one run: the same in all; its time is the median
  std::vector<double> cpu_seconds;  ///< of each run
  double real_time_factor = 0;
  double peak_memory_mb = 0;
  Simulation::Phases phases;  ///< of one more run, profiled
  double per_step(double total) const {
    return totals.steps > 0 ? total / static_cast<double>(totals.steps) : 0;
  }
};

/// Whole runs without any output: only the stepping loop is timed.
Measurement measure(const std::string& path, const BenchArguments& arguments) {
  const LoadedModel loaded = load(path, arguments.settings);
  const Model& model = *loaded.model;
  RunOptions options = run_options(arguments.method, model.spec().simulation);
  options.end = arguments.until;
  Measurement result;
  result.model = path;
  result.method = method_json(resolve_method(model.spec().simulation, options));
  result.elastic_coordinates = model.elastic_coordinates();
  const RunPlan plan = planned(model.spec().simulation, options);
  result.step = plan.step;
  for (int k = 0; k < arguments.runs; ++k) {
    Simulation simulation(loaded.model, options);
    result.coordinates = simulation.coordinates();
    result.totals = {};
    const StepReport report = advance(simulation, plan, plan.steps, result.totals);
    if (!report.ok()) throw Failure(fmt::format("{}: {}", path, simulation.explain(report)));
    result.cpu_seconds.push_back(result.totals.cpu_seconds);
    result.totals.cpu_seconds = median(result.cpu_seconds);
    result.real_time_factor = real_time_factor(result.totals, simulation.time());
  }
  result.peak_memory_mb = peak_memory_mb();
  options.profile = true;
  Simulation profiled(loaded.model, options);
  RunTotals ignored;
  advance(profiled, plan, plan.steps, ignored);
  result.phases = profiled.phases();
  return result;
}

Json to_json(const Measurement& m) {
  Json json{{"model", m.model},
            {"coordinates", m.coordinates},
            {"elastic_coordinates", m.elastic_coordinates},
            {"step", m.step},
            {"steps", m.totals.steps},
            {"cpu_seconds", m.totals.cpu_seconds},
            {"cpu_seconds_of_runs", m.cpu_seconds},
            {"microseconds_per_step", 1e6 * m.per_step(m.totals.cpu_seconds)},
            {"iterations_per_step", m.per_step(static_cast<double>(m.totals.iterations))},
            {"factorisations_per_step", m.per_step(static_cast<double>(m.totals.factorisations))},
            {"real_time_factor", m.real_time_factor},
            {"peak_memory_mb", m.peak_memory_mb},
            {"phases_microseconds_per_step",
             {{"residual", 1e6 * m.per_step(m.phases.residual)},
              {"matrix", 1e6 * m.per_step(m.phases.matrix)},
              {"solution", 1e6 * m.per_step(m.phases.solution)},
              {"projection", 1e6 * m.per_step(m.phases.projection)},
              {"energy", 1e6 * m.per_step(m.phases.energy)},
              {"other", 1e6 * m.per_step(m.phases.other)}}}};
  json.update(m.method);
  return json;
}

/// Where the time of a step goes, µs, from the profiled run.
std::string phase_table(const std::vector<Measurement>& measurements) {
  Table table({"µs per step", "inverse dynamics", "matrix and factorisation", "solutions",
               "kinematics of projections", "energy balance", "other"});
  for (const Measurement& m : measurements) {
    std::vector<std::string> row{m.model};
    for (const double seconds : {m.phases.residual, m.phases.matrix, m.phases.solution, m.phases.projection,
                                 m.phases.energy, m.phases.other})
      row.push_back(fmt::format("{:.3g}", 1e6 * m.per_step(seconds)));
    table.add(row);
  }
  return table.markdown();
}

std::string to_table(const std::vector<Measurement>& measurements) {
  Table table({"model", "coordinates", "step, s", "steps", "CPU s", "µs per step", "iterations per step",
               "factorisations per step", "real-time factor", "peak MB"});
  for (const Measurement& m : measurements)
    table.add({m.model, fmt::format("{}", m.coordinates), fmt::format("{:.4g}", m.step),
               fmt::format("{}", m.totals.steps), fmt::format("{:.4g}", m.totals.cpu_seconds),
               fmt::format("{:.4g}", 1e6 * m.per_step(m.totals.cpu_seconds)),
               fmt::format("{:.3g}", m.per_step(static_cast<double>(m.totals.iterations))),
               fmt::format("{:.3g}", m.per_step(static_cast<double>(m.totals.factorisations))),
               fmt::format("{:.4g}", m.real_time_factor), fmt::format("{:.4g}", m.peak_memory_mb)});
  return table.markdown();
}

int run_bench(const BenchArguments& arguments) {
  std::vector<Measurement> measurements;
  for (const std::string& path : arguments.models) measurements.push_back(measure(path, arguments));
  if (!arguments.json) {
    print_data(to_table(measurements) + '\n' + phase_table(measurements));
    return done;
  }
  Json json = answer("bench");
  json["runs"] = arguments.runs;
  json["models"] = Json::array();
  for (const Measurement& m : measurements) json["models"].push_back(to_json(m));
  print_data(to_text(json) + '\n');
  return done;
}

}  // namespace

Command add_bench(CommandLine& program) {
  Parser parser = program.add_command("bench", "Measure how fast models run on this machine");
  const auto arguments = std::make_shared<BenchArguments>();
  parser.add_option("models", arguments->models, "Model files (YAML)").required().type_name("MODEL");
  parser.add_option("--runs", arguments->runs, "Runs of each model; their median counts")
      .within(1, 100000)
      .show_default()
      .type_name("N");
  add_set_option(parser, arguments->settings);
  parser.add_option("--until", arguments->until, "End in s, instead of the models'").above(0).type_name("T");
  parser.add_flag("--json", arguments->json, "The same as JSON");
  add_method_options(parser, arguments->method);
  parser.footer(
      "A Markdown table: median CPU time of the stepping loop alone, without output. A real-time factor "
      "above 1 is\n"
      "faster than real time. The peak memory is the process's, up to and with the model of the row.\n"
      "Example:\n  mimbre bench pendulum.yaml car.yaml --runs 9");
  return {parser, [arguments] { return run_bench(*arguments); }};
}

}  // namespace mimbre::app
