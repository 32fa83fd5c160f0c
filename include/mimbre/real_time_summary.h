#pragma once
#include <string>

#include "mimbre/real_time.h"

/// Objects in JSON (schema/output.schema.json) that describe steps against the clock.
namespace mimbre {

/// Median, percentiles and worst, s.
std::string timings_summary(const Timings& timings);

/// What is known of all steps against the clock.
std::string real_time_summary(const RealTimeMonitor& monitor);

}  // namespace mimbre
