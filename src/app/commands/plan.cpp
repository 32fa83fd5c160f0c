#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/common.h"
#include "app/input_tables.h"
#include "app/json.h"
#include "app/method_options.h"
#include "app/terminal/monitor.h"
#include "app/terminal/progress.h"
#include "app/terminal/table.h"
#include "mimbre/method_names.h"
#include "mimbre/real_time_plan.h"

/// mimbre plan: which method, step and modes this machine can hold in real time.
namespace mimbre::app {
namespace {

struct PlanArguments {
  std::string model, deadline = "1ms";
  std::vector<std::string> settings, inputs;
  MethodArguments method;
  std::optional<double> until;
  double load = 70, watch = 20;
  RealTimeOptions clock;
  bool json = false;
};

/// Options for `mimbre live` and `mimbre run`.
std::vector<std::string> options_of(const RealTimeCandidate& c, const PlanArguments& a) {
  std::vector<std::string> words{"--formulation",    name_of(c.formulation),
                                 "--step",           fmt::format("{}", c.step),
                                 "--max-iterations", fmt::format("{}", c.max_iterations),
                                 "--substeps",       fmt::format("{}", c.substeps)};
  if (c.fixed_cost) words.emplace_back("--fixed-cost");
  if (a.method.no_fixed_cost) words.emplace_back("--no-fixed-cost");
  const auto add = [&](const std::string& option, const std::string& value) {
    words.push_back(option);
    words.push_back(value);
  };
  for (const std::string& setting : a.settings) add("--set", setting);
  for (const std::string& input : a.inputs) add("--input", input);
  if (!a.method.inertia.empty()) add("--inertia", a.method.inertia);
  if (!a.method.formalism.empty()) add("--formalism", a.method.formalism);
  if (!a.method.integrator.empty()) add("--integrator", a.method.integrator);
  if (a.method.xi) add("--integrator-xi", fmt::format("{}", *a.method.xi));
  if (a.method.accuracy) add("--accuracy", fmt::format("{}", *a.method.accuracy));
  if (a.method.rho) add("--rho", fmt::format("{}", *a.method.rho));
  if (a.method.tolerance) add("--tolerance", fmt::format("{}", *a.method.tolerance));
  if (c.most_modes > 0) words.insert(words.end(), {"--most-modes", fmt::format("{}", c.most_modes)});
  return words;
}

/// Options for `mimbre live` alone.
std::string clocked_options(const PlanArguments& a) {
  std::string words;
  if (a.clock.speed != 1) words += fmt::format(" --speed {}", a.clock.speed);
  if (a.clock.priority > 0) words += fmt::format(" --priority {}", a.clock.priority);
  if (a.clock.processor >= 0) words += fmt::format(" --cpu {}", a.clock.processor);
  return words;
}

Json candidate_json(const RealTimeCandidate& c) {
  Json json{{"formulation", name_of(c.formulation)},
            {"step", c.step},
            {"most_modes", c.most_modes > 0 ? Json(c.most_modes) : Json(nullptr)},
            {"substeps", c.substeps},
            {"fixed_cost", c.fixed_cost},
            {"max_iterations", c.max_iterations},
            {"coordinates", c.coordinates}};
  if (c.coordinates > 0 && c.median > 0)
    json.update({{"error", std::isfinite(c.error) ? Json(c.error) : Json(nullptr)},
                 {"worst_output", c.worst_output},
                 {"cpu", {{"median", c.median}, {"p9999", c.p9999}, {"worst", c.worst}}},
                 {"most_iterations", c.most_iterations}});
  if (!c.failure.empty()) json["failure"] = c.failure;
  return json;
}

Json to_json(const RealTimePlan& plan, const PlanArguments& a) {
  Json json = answer("plan", plan.chosen >= 0 ? "ok" : "failed");
  json["model"] = a.model;
  json["deadline"] = plan.deadline;
  json["reference_step"] = plan.reference_step;
  json["idle"] = monitor_json(*plan.idle);
  json["candidates"] = Json::array();
  for (const RealTimeCandidate& c : plan.candidates) json["candidates"].push_back(candidate_json(c));
  json["watched_candidates"] = plan.watched_candidates;
  if (plan.chosen < 0) return json;
  const RealTimeCandidate& chosen = plan.candidates[static_cast<std::size_t>(plan.chosen)];
  json["chosen"] = candidate_json(chosen);
  json["watched"] = monitor_json(*plan.watched);
  json["load"] = plan.load;
  json["margin"] = 1 - plan.load;
  json["machine_late"] = plan.machine_late;
  json["options"] = options_of(chosen, a);
  return json;
}

std::string plan_table(const RealTimePlan& plan, const PlanArguments& a) {
  Table table({"formulation", "step, ms", "modes", "parts", "unknowns", "error, %", "of", "CPU, ms",
               "99.99 %", "worst", "iterations", ""});
  for (std::size_t k = 0; k < plan.candidates.size(); ++k) {
    const RealTimeCandidate& c = plan.candidates[k];
    const bool measured = c.median > 0;
    const auto number = [&](const char* format, double value) {
      return measured ? fmt::format(fmt::runtime(format), value) : std::string("–");
    };
    table.add({name_of(c.formulation), fmt::format("{:.4g}", 1e3 * c.step),
               c.most_modes > 0 ? fmt::format("{}", c.most_modes) : "all", fmt::format("{}", c.substeps),
               fmt::format("{}", c.coordinates), number("{:.3g}", 100 * c.error), c.worst_output,
               number("{:.4f}", 1e3 * c.median), number("{:.4f}", 1e3 * c.p9999),
               number("{:.4f}", 1e3 * c.worst), fmt::format("{}", c.most_iterations),
               static_cast<int>(k) == plan.chosen ? "taken" : c.failure});
  }
  std::string text = table.text();
  text += fmt::format("\nlatency of the idle machine: {:.3f} ms in 99.99 %, {:.3f} ms at worst\n",
                      1e3 * plan.idle->latency.quantile(0.9999), 1e3 * plan.idle->latency.worst());
  if (plan.chosen < 0)
    return text +
           fmt::format(
               "no candidate meets a deadline of {} ms within {} % of it; {} were run against the clock\n",
               1e3 * plan.deadline, a.load, plan.watched_candidates);
  const RealTimeCandidate& c = plan.candidates[static_cast<std::size_t>(plan.chosen)];
  const RealTimeMonitor& m = *plan.watched;
  text += fmt::format(
      "against the clock, {} steps: computation {:.3f} ms in the median, {:.3f} ms in 99.99 %, {:.3f} ms at "
      "worst; latency {:.3f} ms in 99.99 %; {} overruns\nexpected error {:.2g} % ({}); {:.0f} % of each "
      "step's time is used in 99.99 %, {:.0f} % remains\n\n  mimbre live {}{} {}\n",
      m.steps.load(), 1e3 * m.computation.quantile(0.5), 1e3 * m.computation.quantile(0.9999),
      1e3 * m.computation.worst(), 1e3 * m.latency.quantile(0.9999), m.overrun_count(), 100 * c.error,
      c.worst_output, 100 * plan.load, 100 * (1 - plan.load), a.model, clocked_options(a),
      fmt::join(options_of(c, a), " "));
  if (plan.machine_late)
    text +=
        "\nThe machine itself is late: the computation alone keeps within the requested load. --priority and "
        "--cpu\nhelp if the system permits them; virtual and shared machines may stay late.\n";
  return text;
}

int plan(const PlanArguments& a) {
  const LoadedModel loaded = load(a.model, a.settings);
  const spec::Model& model = loaded.model->spec();
  RecordedInputs inputs = input_tables(a.inputs, model.inputs).tables;
  RealTimePlanOptions options;
  options.deadline = duration_of(a.deadline, "--deadline");
  options.end = a.until.value_or(0);
  options.load = a.load / 100;
  options.watch = a.watch;
  options.run = run_options(a.method, model.simulation);
  options.run.inputs = inputs.start();
  options.loop = a.clock;
  options.drive = [&](Simulation& simulation) {
    if (simulation.time() == 0) inputs.attach(simulation);
    inputs.set(simulation);
  };
  Progress progress(!a.json);
  options.progress = [&](const std::string& stage, double part) { progress.update(stage, part); };
  const RealTimePlan found = plan_real_time(model, options);
  progress.clear();
  print_data(a.json ? to_text(to_json(found, a)) + '\n' : plan_table(found, a));
  return found.chosen >= 0 ? done : failed;
}

}  // namespace

Command add_plan(CommandLine& program) {
  Parser parser =
      program.add_command("plan", "Measure which method, step and modes run in real time on this machine");
  const auto a = std::make_shared<PlanArguments>();
  parser.add_option("model", a->model, "Model file (YAML)").required().type_name("MODEL");
  add_set_option(parser, a->settings);
  add_input_option(parser, a->inputs);
  parser
      .add_option("--deadline", a->deadline,
                  "Time in which a step has to be done, with its unit: 1ms, 500us, 0.002s")
      .show_default()
      .type_name("T");
  parser.add_option("--until", a->until, "End of the manoeuvre in s, instead of the model's")
      .above(0)
      .type_name("T");
  parser.add_option("--load", a->load, "Percentage of a step's time that 99.99 % of the steps may use")
      .within(1., 100.)
      .show_default()
      .type_name("P");
  parser.add_option("--watch", a->watch, "Seconds that a proposal is run against the clock")
      .from(0.1, 86400)
      .show_default()
      .type_name("S");
  add_clock_options(parser, a->clock);
  parser.add_flag("--json", a->json, "The plan as JSON");
  add_method_options(parser, a->method);
  parser.footer(
      "Every candidate first runs the manoeuvre without a clock; errors are relative to a run with all modes "
      "and a sixteenth\nof the deadline as its step. The most accurate candidate that should meet the "
      "deadline is then run against the clock,\nand the next one if it does not meet it. The last line is "
      "the command to run.\nExample:\n  mimbre plan examples/iltis/vehicle.yaml --deadline 1ms");
  return {parser, [a] { return plan(*a); }};
}

}  // namespace mimbre::app
