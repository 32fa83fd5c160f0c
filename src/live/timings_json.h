#pragma once
#include "mimbre/timings.h"
#include "results/report_json.h"

namespace mimbre::live {

/// Median, percentiles and worst, s.
results::Json timings_json(const Timings& timings);

}  // namespace mimbre::live
