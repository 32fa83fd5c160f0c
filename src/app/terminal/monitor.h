#pragma once
#include "app/json.h"
#include "app/options.h"
#include "mimbre/real_time.h"

namespace mimbre::app {

/// Median, percentiles and worst, s.
Json timings_json(const Timings& timings);
/// What is known of all steps against the clock.
Json monitor_json(const RealTimeMonitor& monitor);

/// Adds --speed, --priority and --cpu to a command.
void add_clock_options(Parser& command, RealTimeOptions& options);

/// Seconds of "1ms", "500us", "0.002s" or "0.002". Throws UsageError that names the option.
double duration_of(const std::string& text, const std::string& option);

}  // namespace mimbre::app
