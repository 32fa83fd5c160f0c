#include "mimbre/run_summary.h"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "mimbre/build.h"
#include "mimbre/run_option.h"
#include "mimbre/text.h"
#include "results/report_json.h"

namespace mimbre {
namespace {

using results::Json;

std::string text_of(const Json& json) {
  return printable_json(json.dump(2, ' ', false, Json::error_handler_t::replace));
}

Json value_of(const RunOption& option, double value) {
  if (!option.words.empty()) return option.words[static_cast<std::size_t>(value)];
  if (std::holds_alternative<OptionMember<bool>>(option.member)) return value != 0;
  if (std::holds_alternative<OptionMember<int>>(option.member)) return static_cast<int>(value);
  return value;
}

/// By the names of the command line, as "integrator_xi".
Json arguments_of(const RunOptions& asked) {
  Json json = Json::object();
  for (const RunOption& option : run_option_table()) {
    const auto value = value_in(option, asked);
    if (!value || option.option.empty()) continue;
    std::string name(option.option);
    std::replace(name.begin(), name.end(), '-', '_');
    json[name] = value_of(option, *value);
  }
  return json;
}

/// What the integrator has of the options, or of the headline's alone.
Json options_of(const Method& method, bool headline) {
  Json json;
  for (const RunOption& option : run_option_table())
    if (option.belongs_to(method.integrator) && (option.in_headline || !headline))
      json[std::string(option.key)] = value_of(option, value_in(option, method));
  return json;
}

Json method_of(const Method& method) {
  Json json = options_of(method, true);
  if (!method.chosen.empty()) json["chosen"] = method.chosen;
  return json;
}

Json resolved_of(const Method& method) {
  Json json = options_of(method, false);
  json["default_end"] = method.default_end;
  return json;
}

std::array<std::pair<const char*, Validity::Peak>, 7> named(const Validity& v) {
  return {{{"deflection", v.deflection},
           {"foreshortening", v.foreshortening},
           {"compression", v.compression},
           {"tension", v.tension},
           {"lag", v.lag},
           {"held", v.held},
           {"high_modes", v.high_modes}}};
}

bool stopped_by(const Simulation& simulation, const EventRecord& e) {
  return simulation.stopped() && e.stops && e.count > 0 && e.last == simulation.time();
}

/// What linear theory neglected at worst, by flexible body.
Json validity(const Simulation& simulation) {
  Json bodies = Json::array();
  for (const Validity& v : simulation.validity()) {
    Json body{{"body", v.body}};
    for (const auto& [name, peak] : named(v)) {
      if (!peak.watched) {
        body[name] = nullptr;
        continue;
      }
      body[name] = peak.value;
      body["time"][name] = peak.time;
    }
    body["axial"] = v.axial;
    bodies.push_back(std::move(body));
  }
  return bodies;
}

/// The model's events, with the times of the first and the last of each.
Json happened(const Simulation& simulation) {
  Json events = Json::array();
  for (const EventRecord& e : simulation.events()) {
    Json event{{"event", e.name}, {"count", e.count}};
    if (e.count > 0) event.update({{"first", e.first}, {"last", e.last}});
    if (e.stops) event["stopped"] = stopped_by(simulation, e);
    events.push_back(std::move(event));
  }
  return events;
}

double per_step(std::int64_t total, const RunTotals& totals) {
  return totals.steps > 0 ? static_cast<double>(total) / static_cast<double>(totals.steps) : 0.0;
}

}  // namespace

std::string run_summary(Simulation& simulation, const RunTotals& totals, const RunEnding& ending,
                        const std::vector<std::string>& warnings) {
  Json summary;
  summary["status"] = ending.status;
  if (!ending.message.empty()) summary["message"] = ending.message;
  summary["steps"] = totals.steps;
  summary["step"] = simulation.step_size();
  summary.update(method_of(simulation.method()));
  summary["resolved"] = resolved_of(simulation.method());
  summary["time"] = simulation.time();
  summary["coordinates"] = simulation.coordinates();
  summary["iterations"] = totals.iterations;
  summary["iterations_per_step"] = per_step(totals.iterations, totals);
  summary["factorisations"] = totals.factorisations;
  summary["repeated_steps"] = totals.repeated_steps;
  if (simulation.method().fixed_cost) summary["unconverged_steps"] = totals.unconverged_steps;
  summary["max_position_violation"] = totals.violations.position_violation;
  summary["max_angle_violation"] = totals.violations.angle_violation;
  summary["max_velocity_violation"] = totals.violations.velocity_violation;
  summary["max_angular_velocity_violation"] = totals.violations.angular_velocity_violation;
  for (const EnergyTerm& term : energy_terms) summary["energy"][term.name] = simulation.energy().*term.value;
  if (Json bodies = validity(simulation); !bodies.empty()) summary["validity"] = std::move(bodies);
  if (Json events = happened(simulation); !events.empty()) summary["events"] = std::move(events);
  summary["warnings"] = warnings;
  ResultsRow row;
  simulation.sample(row);
  summary["outputs"] = Json::object();
  for (int k = 0; k < simulation.output_count(); ++k)
    summary["outputs"][simulation.channels()[k].name] = row.channels[k];
  return text_of(summary);
}

std::string measured_summary(const std::string& text, const Simulation& simulation, const RunTotals& totals) {
  Json summary = Json::parse(text);
  summary["cpu_seconds"] = totals.cpu_seconds;
  summary["initialisation_seconds"] = simulation.initialisation_seconds();
  summary["real_time_factor"] = real_time_factor(totals, simulation.time());
  summary["peak_memory_mb"] = peak_memory_mb();
  const BuildInfo& build = build_info();
  summary["build"] = {
      {"version", build.version}, {"compiler", build.compiler}, {"instructions", build.instructions}};
  return text_of(summary);
}

std::string arguments_summary(const RunOptions& asked) { return text_of(arguments_of(asked)); }

std::string method_summary(const Method& method) { return text_of(method_of(method)); }

std::string resolved_summary(const Method& method) { return text_of(resolved_of(method)); }

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
#ifdef __APPLE__
  return static_cast<double>(usage.ru_maxrss) * 1e-6;
#else
  return static_cast<double>(usage.ru_maxrss) * 1024e-6;
#endif
}

}  // namespace mimbre
