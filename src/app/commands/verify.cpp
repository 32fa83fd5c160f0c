#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/common.h"
#include "app/json.h"
#include "app/method_options.h"
#include "app/terminal/interrupts.h"
#include "app/terminal/progress.h"
#include "app/terminal/table.h"
#include "mimbre/method_names.h"
#include "mimbre/verify.h"

/// mimbre verify: one model in both formulations, and how far they lie apart.
namespace mimbre::app {
namespace {

constexpr std::size_t channels_shown = 10;

struct VerifyArguments {
  std::string model;
  std::vector<std::string> settings;
  RunOptions method;
  std::optional<double> until;
  bool json = false, all = false, no_refine = false, quiet = false, strict = false;
};

Json number_or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

/// {"relative": …, "natural": …}
template <class Get>
Json of_both(const VerificationPair& pair, const Get& get) {
  Json json;
  for (std::size_t f = 0; f < pair.runs.size(); ++f) json[method_names::formulations[f]] = get(pair.runs[f]);
  return json;
}

Json to_json(const VerificationPair& pair) {
  Json json;
  json["step"] = pair.runs[0].step;
  json["steps"] = of_both(pair, [](const VerificationRun& r) { return r.totals.steps; });
  json["iterations"] = of_both(pair, [](const VerificationRun& r) { return r.totals.iterations; });
  json["repeated_steps"] = of_both(pair, [](const VerificationRun& r) { return r.totals.repeated_steps; });
  json["cpu_seconds"] = of_both(pair, [](const VerificationRun& r) { return r.totals.cpu_seconds; });
  const auto violation = [&](double Violations::*kind) {
    return of_both(pair, [kind](const VerificationRun& r) { return r.totals.violations.*kind; });
  };
  json["position_violation"] = violation(&Violations::position_violation);
  json["angle_violation"] = violation(&Violations::angle_violation);
  json["velocity_violation"] = violation(&Violations::velocity_violation);
  json["angular_velocity_violation"] = violation(&Violations::angular_velocity_violation);
  json["energy_drift"] = of_both(pair, [](const VerificationRun& r) { return r.energy_drift; });
  return json;
}

/// What halving the step changes in each formulation, the root mean square of the scale.
Json to_json(const std::array<std::optional<Apart>, 2>& changes) {
  Json json;
  for (std::size_t f = 0; f < changes.size(); ++f)
    json[method_names::formulations[f]] =
        changes[f]->scale > 0 ? changes[f]->rms_difference / changes[f]->scale : 0;
  return json;
}

Json to_json(const Verification& v, const std::string& model, const std::vector<std::string>& warnings) {
  Json json = answer("verify", v.failures().empty() ? "ok" : "failed");
  json["model"] = model;
  json["until"] = v.end;
  Json method = method_json(v.method);
  method.erase("formulation");
  json.update(method);
  json["agree"] = v.agree();
  json["refinement_ratio"] = number_or_null(v.agreement.ratio);
  json["coordinates"] = of_both(v.whole, [](const VerificationRun& r) { return r.coordinates; });
  json["constraints"] = of_both(v.whole, [](const VerificationRun& r) { return r.constraints; });
  if (v.compared()) json["verdict"] = verdict(v);
  json["warnings"] = warnings;
  json["total_repeated_steps"] = v.repeated_steps;
  json["without_repeats"] = v.without_repeats;
  if (!v.failures().empty()) json["failures"] = v.failures();
  json.update(to_json(v.whole));
  if (v.half) json["half_step"] = to_json(*v.half);
  if (v.quarter) json["quarter_step"] = to_json(*v.quarter);
  json["channels"] = Json::array();
  for (const Refined& c : v.agreement.channels) {
    Json channel{{"name", c.whole.name},
                 {"unit", c.whole.unit},
                 {"difference", c.finest().relative_difference},
                 {"agrees", c.agrees()},
                 {"max_difference", c.whole.max_difference},
                 {"time", c.whole.time},
                 {"rms_difference", c.whole.rms_difference},
                 {"range", c.whole.range},
                 {"scale", c.whole.scale},
                 {"relative_difference", c.whole.relative_difference}};
    if (c.half) {
      channel["half_step_difference"] = c.half->max_difference;
      channel["half_step_rms_difference"] = c.half->rms_difference;
      channel["half_step_relative_difference"] = c.half->relative_difference;
      channel["ratio"] = number_or_null(c.ratio());
    }
    if (c.quarter) {
      channel["quarter_step_difference"] = c.quarter->max_difference;
      channel["quarter_step_rms_difference"] = c.quarter->rms_difference;
      channel["quarter_step_relative_difference"] = c.quarter->relative_difference;
    }
    if (c.step[0]) channel["step_error"] = to_json(c.step);
    if (c.half_step[0]) channel["half_step_error"] = to_json(c.half_step);
    json["channels"].push_back(std::move(channel));
  }
  return json;
}

std::string channel_table(const Agreement& agreement, bool all) {
  Table table({"channel", "unit", "largest difference", "at t, s", "% of range", "% with half the step",
               "times smaller", "% that half the step changes", "agrees"});
  const std::size_t count =
      all ? agreement.channels.size() : std::min(channels_shown, agreement.channels.size());
  for (std::size_t k = 0; k < count; ++k) {
    const Refined& c = agreement.channels[k];
    table.add({c.whole.name, c.whole.unit, fmt::format("{:.4g}", c.whole.max_difference),
               fmt::format("{:.6g}", c.whole.time), fmt::format("{:.3g}", 100 * c.whole.relative_difference),
               c.half ? fmt::format("{:.3g}", 100 * c.half->relative_difference) : "",
               c.ratio() ? fmt::format("{:.3g}", *c.ratio()) : "",
               c.step[0] ? fmt::format("{:.3g}", 100 * c.step_error()) : "", c.agrees() ? "yes" : "no"});
  }
  std::string text = table.text();
  if (count < agreement.channels.size())
    text +=
        fmt::format("({} more channels agree better; --all shows them)\n", agreement.channels.size() - count);
  return text;
}

std::string run_table(const Verification& v) {
  Table table({"formulation", "coordinates", "step, s", "steps", "repeated", "iterations per step", "CPU s",
               "violation, m", "violation, rad", "violation, m/s", "violation, rad/s", "energy drift, J"});
  const auto add = [&](const VerificationPair& pair) {
    for (std::size_t f = 0; f < pair.runs.size(); ++f) {
      const RunTotals& t = pair.runs[f].totals;
      const double steps = static_cast<double>(std::max<std::int64_t>(t.steps, 1));
      table.add({method_names::formulations[f], fmt::format("{}", pair.runs[f].coordinates),
                 fmt::format("{:.6g}", pair.runs[f].step), fmt::format("{}", t.steps),
                 fmt::format("{}", t.repeated_steps),
                 fmt::format("{:.3g}", static_cast<double>(t.iterations) / steps),
                 fmt::format("{:.4g}", t.cpu_seconds), fmt::format("{:.3g}", t.violations.position_violation),
                 fmt::format("{:.3g}", t.violations.angle_violation),
                 fmt::format("{:.3g}", t.violations.velocity_violation),
                 fmt::format("{:.3g}", t.violations.angular_velocity_violation),
                 fmt::format("{:.3g}", pair.runs[f].energy_drift)});
    }
  };
  add(v.whole);
  if (v.half) add(*v.half);
  if (v.quarter) add(*v.quarter);
  return table.text();
}

std::string to_report(const Verification& v, bool all) {
  std::string text;
  if (v.compared()) text += verdict(v) + "\n\n" + channel_table(v.agreement, all) + '\n';
  return text + run_table(v);
}

/// With the loader's warnings.
Verification verify(const VerifyArguments& arguments, std::vector<std::string>& warnings) {
  const LoadedModel loaded = load(arguments.model, arguments.settings);
  warnings = loaded.warnings;
  VerifyOptions options;
  options.run = run_options(arguments.method, loaded.model->spec().simulation);
  RunOptions whole = options.run;
  whole.end = arguments.until;
  planned(loaded.model->spec().simulation, whole);  // else refused
  options.end = arguments.until.value_or(-1);
  options.refine = !arguments.no_refine;
  Progress progress(!arguments.quiet);
  double reached = 0;
  options.progress = [&](double time, double end, double cpu_seconds) {
    reached = time;
    progress.update(time, end, cpu_seconds);
  };
  options.stop = interrupted;
  catch_interrupts();
  Verification v = mimbre::verify(loaded.model, options);
  if (v.interrupted) throw Failure(fmt::format("interrupted at t = {:.6g} s of {:.6g} s", reached, v.end));
  return v;
}

int run_verify(const VerifyArguments& arguments) {
  std::vector<std::string> warnings;
  const Verification v = verify(arguments, warnings);
  std::vector<std::string> found = v.warnings();
  if (v.failures().empty() && !v.agree()) {
    const std::string text = verdict(v);
    found.push_back(text.substr(0, text.find('\n')));
  }
  warnings.insert(warnings.end(), found.begin(), found.end());
  print_data(arguments.json ? to_text(to_json(v, arguments.model, warnings)) + '\n'
                            : to_report(v, arguments.all));
  for (const std::string& failure : v.failures()) print_error(failure);
  for (const std::string& warning : found) print_warning(warning);
  return v.failures().empty() ? done_with(!warnings.empty(), arguments.strict) : failed;
}

}  // namespace

Command add_verify(CommandLine& program) {
  Parser parser = program.add_command(
      "verify", "Run a model in both formulations, relative and natural coordinates, and compare them");
  const auto arguments = std::make_shared<VerifyArguments>();
  parser.add_option("model", arguments->model, "Model file (YAML)").required().type_name("MODEL");
  add_set_option(parser, arguments->settings);
  parser.add_option("--until", arguments->until, "End in s, instead of the model's").from(0).type_name("T");
  parser.add_flag("--no-refine", arguments->no_refine, "Leave out the runs with half the step");
  parser.add_flag("--all", arguments->all, "All channels, not only the ones that differ most");
  parser.add_flag("--json", arguments->json, "The same as JSON, with all channels");
  parser.add_flag("-q,--quiet", arguments->quiet, "No progress line");
  add_strict_option(parser, arguments->strict);
  add_method_options(parser, arguments->method, {.without = "formulation"});
  parser.footer(
      "The two formulations are implemented separately and integrate different coordinates; their results "
      "differ by an\nerror of second order: with half the step it is about 4 times smaller. A difference "
      "that does not decrease is a\nmistake in one of them, or the step is far too long. Each is also "
      "compared with itself at half the step, and at\na quarter if that decides: a channel that a shorter "
      "step changes by much does not count as agreement.\nExit codes: 0 both ran (\"agree\": whether they "
      "agree to 1 % of the range of every channel, or better with every\nhalving), 1 the model is bad, 2 "
      "wrong use, 3 one of them failed, 4 they disagree or a run warned, if --strict\nwas given.\nExample:\n "
      " mimbre verify pendulum.yaml --until 2");
  return {parser, [arguments] { return run_verify(*arguments); }};
}

}  // namespace mimbre::app
