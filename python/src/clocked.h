#pragma once
#include <functional>
#include <optional>
#include <string>

#include "mimbre/real_time.h"

namespace mimbre::python {

struct ClockedOptions {
  RealTimeOptions loop;
  std::optional<int> port;  ///< of the page; none: there is no page
  std::string address, token, record;
};

/// Called in the loop, without the interpreter's lock.
struct ClockedCalls {
  std::function<void()> before, after;         ///< a step
  std::function<bool()> stop;                  ///< whether to end it
  std::function<void(const std::string&)> at;  ///< before it begins: the address of the page
};

/// Runs a simulation against the clock. What the monitor knows at its end, as JSON.
std::string clocked(Simulation& simulation, const ClockedOptions& options, const ClockedCalls& calls);

}  // namespace mimbre::python
