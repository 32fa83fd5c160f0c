#include "app/terminal/monitor.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "app/options.h"
#include "mimbre/real_time_summary.h"

namespace mimbre::app {

Json timings_json(const Timings& timings) { return Json::parse(timings_summary(timings)); }

Json monitor_json(const RealTimeMonitor& monitor) { return Json::parse(real_time_summary(monitor)); }

void add_clock_options(Parser& command, RealTimeOptions& options) {
  command.add_option("--speed", options.speed, "Simulated seconds in a second")
      .above(0, 1000)
      .type_name("X")
      .group("Clock");
  command
      .add_option("--priority", options.priority,
                  "Of the scheduling SCHED_FIFO, 1 to 99, where that is permitted; 0: none")
      .within(0, 99)
      .type_name("N")
      .group("Clock");
  command.add_option("--cpu", options.processor, "The processor that the steps are made on; -1: any")
      .within(-1, 4095)
      .type_name("N")
      .group("Clock");
}

double duration_of(const std::string& text, const std::string& option) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  const std::string unit = end;
  const double factor = unit == "us" ? 1e-6 : unit == "ms" ? 1e-3 : unit.empty() || unit == "s" ? 1 : NAN;
  const double seconds = number * factor;
  if (end == text.c_str() || !std::isfinite(seconds) || seconds <= 0)
    throw UsageError(fmt::format("{}: '{}' is no time; write 1ms, 500us or 0.002s", option, text));
  return seconds;
}

}  // namespace mimbre::app
