#include "mimbre/real_time_summary.h"

#include <nlohmann/json.hpp>

#include "live/timings_json.h"

namespace mimbre {

results::Json live::timings_json(const Timings& t) {
  return {{"median", t.quantile(0.5)},
          {"p99", t.quantile(0.99)},
          {"p9999", t.quantile(0.9999)},
          {"worst", t.worst()}};
}

std::string timings_summary(const Timings& timings) { return live::timings_json(timings).dump(2); }

std::string real_time_summary(const RealTimeMonitor& m) {
  using live::timings_json;
  results::Json overruns{{"count", m.overrun_count()}};
  for (int k = 0; k < overrun_causes; ++k)
    overruns[name_of(static_cast<OverrunCause>(k))] = m.overruns[static_cast<std::size_t>(k)].load();
  const results::Json summary{{"steps", m.steps.load()},
                              {"computation", timings_json(m.computation)},
                              {"cpu", timings_json(m.cpu)},
                              {"latency", timings_json(m.latency)},
                              {"overruns", overruns},
                              {"late_steps", m.late.load()},
                              {"page_faults", m.page_faults.load()},
                              {"preemptions", m.preemptions.load()},
                              {"most_iterations", m.most_iterations.load()},
                              {"most_parts", m.most_parts.load()},
                              {"unconverged_steps", m.unconverged.load()}};
  return summary.dump(2);
}

}  // namespace mimbre
