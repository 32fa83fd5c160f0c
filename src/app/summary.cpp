#include "app/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/method_options.h"
#include "app/terminal/table.h"

namespace mimbre::app {
namespace {

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

/// What linear theory neglected at worst, of all bodies.
std::string worst(const std::vector<Validity>& bodies) {
  const char* names[] = {"deflection", "shortening", "compression",  "tension",
                         "lag",        "held",       "highest modes"};
  std::string text;
  for (std::size_t k = 0; k < std::size(names); ++k) {
    double largest = 0;
    std::size_t watched = 0;
    for (const Validity& v : bodies) {
      const Validity::Peak peak = named(v)[k].second;
      largest = std::max(largest, peak.value);
      if (peak.watched) ++watched;
    }
    text += fmt::format("{}{} ", k == 0 ? "" : ", ", names[k]);
    text += watched == 0 ? "not watched" : fmt::format("{:.2g} %", 100 * largest);
    if (watched > 0 && watched < bodies.size())
      text += fmt::format(" ({} of {} bodies)", watched, bodies.size());
  }
  return text;
}

double per_step(std::int64_t total, const RunTotals& totals) {
  return totals.steps > 0 ? static_cast<double>(total) / static_cast<double>(totals.steps) : 0.0;
}

}  // namespace

Json output_units(const Simulation& simulation) {
  Json units = Json::object();
  for (int k = 0; k < simulation.output_count(); ++k)
    units[simulation.channels()[k].name] = simulation.channels()[k].unit;
  return units;
}

void add_measurements(Json& summary, const Simulation& simulation, const RunTotals& totals) {
  summary = Json::parse(measured_summary(to_text(summary), simulation, totals));
}

std::string summary_table(Simulation& simulation, const RunTotals& totals) {
  Table table({"run", "", ""});
  const auto line = [&](const char* name, const std::string& value, const std::string& unit = "") {
    table.add({name, value, unit});
  };
  const auto number = [](double value) { return fmt::format("{:.6g}", value); };
  line("simulated time", number(simulation.time()), "s");
  line("steps", fmt::format("{}", totals.steps));
  line("step", number(simulation.step_size()), "s");
  // In the last column, for the numbers to stay aligned.
  line("method", "", method_line(simulation.method()));
  if (const std::string& why = simulation.method().chosen; !why.empty()) line("integrator chosen", "", why);
  if (simulation.method().default_end)
    line("end", number(simulation.method().end), "s  (the default: the model has none)");
  line("coordinates", fmt::format("{}", simulation.coordinates()));
  line("iterations per step", fmt::format("{:.3g}", per_step(totals.iterations, totals)));
  if (totals.repeated_steps > 0)
    line("steps repeated in parts", fmt::format("{}", totals.repeated_steps),
         fmt::format("({} parts each)", simulation.method().substeps));
  if (simulation.method().fixed_cost)
    line("steps taken unconverged", fmt::format("{}", totals.unconverged_steps),
         fmt::format("(fixed cost: {} iterations)", simulation.method().max_iterations));
  line("initialisation", fmt::format("{:.4g}", simulation.initialisation_seconds()), "CPU s");
  line("stepping", fmt::format("{:.4g}", totals.cpu_seconds), "CPU s");
  line("real-time factor", fmt::format("{:.4g}", real_time_factor(totals, simulation.time())),
       "(above 1: faster than real time)");
  const Violations& v = totals.violations;
  line("largest position violation", fmt::format("{:.3g}", v.position_violation), "m");
  line("largest angle violation", fmt::format("{:.3g}", v.angle_violation), "rad");
  line("largest velocity violation", fmt::format("{:.3g}", v.velocity_violation), "m/s");
  line("largest angular velocity violation", fmt::format("{:.3g}", v.angular_velocity_violation), "rad/s");
  for (const EventRecord& e : simulation.events())
    line(fmt::format("event {}", e.name).c_str(),
         e.count > 0 ? fmt::format("{:.9g}", e.last) : fmt::format("{}", e.count),
         e.count > 1   ? fmt::format("s  (the last of {}, the first at {:.9g} s)", e.count, e.first)
         : e.count > 0 ? stopped_by(simulation, e) ? "s  (stopped the run)" : "s"
                       : "times");
  for (const EnergyTerm& term : energy_terms)
    line(fmt::format("energy, {}", term.name).c_str(), number(simulation.energy().*term.value), "J");
  if (const auto bodies = simulation.validity(); !bodies.empty())
    line("against linear theory", "", worst(bodies));
  return table.text();
}

}  // namespace mimbre::app
