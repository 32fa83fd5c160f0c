#include "mimbre/run_summary.h"

#include <sys/resource.h>

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "mimbre/build.h"
#include "mimbre/method_names.h"
#include "mimbre/text.h"
#include "results/report_json.h"

namespace mimbre {
namespace {

using results::Json;

std::string text_of(const Json& json) {
  return printable_json(json.dump(2, ' ', false, Json::error_handler_t::replace));
}

Json arguments_of(const MethodArguments& arguments) {
  Json json = Json::object();
  const auto word = [&](const char* key, const std::string& value) {
    if (!value.empty()) json[key] = value;
  };
  word("formulation", arguments.formulation);
  word("inertia", arguments.inertia);
  word("formalism", arguments.formalism);
  word("integrator", arguments.integrator);
  if (arguments.xi) json["integrator_xi"] = *arguments.xi;
  if (arguments.rho) json["rho"] = *arguments.rho;
  if (arguments.tolerance) json["tolerance"] = *arguments.tolerance;
  if (arguments.accuracy) json["accuracy"] = *arguments.accuracy;
  if (arguments.max_iterations) json["max_iterations"] = arguments.max_iterations;
  if (arguments.substeps) json["substeps"] = arguments.substeps;
  if (arguments.fixed_cost || arguments.no_fixed_cost) json["fixed_cost"] = arguments.fixed_cost;
  return json;
}

Json method_of(const Method& method) {
  Json json;
  json["formulation"] = name_of(method.formulation);
  json["inertia"] = name_of(method.inertia);
  json["formalism"] = name_of(method.formalism);
  json["integrator"] = name_of(method.integrator);
  if (method.integrator == spec::Simulation::Integrator::newmark)
    json["xi"] = method.xi;
  else if (method.integrator != spec::Simulation::Integrator::conserve && !is_explicit(method.integrator))
    json["rho"] = method.rho;
  if (method.accuracy > 0) json["accuracy"] = method.accuracy;
  json["tolerance"] = method.tolerance;
  return json;
}

Json resolved_of(const Method& method) {
  Json json = method_of(method);
  json["inertia"] = name_of(method.inertia);
  json["penalty"] = method.penalty;
  json["max_iterations"] = method.max_iterations;
  json["substeps"] = method.substeps;
  json["fixed_cost"] = method.fixed_cost;
  json["step"] = method.step;
  json["end"] = method.end;
  json["default_end"] = method.default_end;
  json["output_interval"] = method.output_interval;
  return json;
}

std::array<std::pair<const char*, Validity::Peak>, 6> named(const Validity& v) {
  return {{{"deflection", v.deflection},
           {"foreshortening", v.foreshortening},
           {"compression", v.compression},
           {"tension", v.tension},
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

std::string arguments_summary(const MethodArguments& arguments) { return text_of(arguments_of(arguments)); }

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
