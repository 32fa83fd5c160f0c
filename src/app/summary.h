#pragma once
#include <string>
#include <vector>

#include "app/common.h"
#include "app/stepping.h"

/// What is said about a run when it has ended.
namespace mimbre::app {

/// How a run ended.
struct Ending {
  std::string status = "ok";  ///< "ok", "failed" or "interrupted"
  std::string message;        ///< what went wrong, empty when nothing did
};

/// What is the same whenever the same run is made: this is kept in the results file. `method`: in force, by
/// method_in_force().
Json run_summary(Simulation& simulation, const Json& method, const Totals& totals, const Ending& ending,
                 const std::vector<std::string>& warnings);

/// Adds what differs from run to run: times of this machine, memory.
void add_measurements(Json& summary, const Simulation& simulation, const Totals& totals);

/// Simulated seconds per CPU second of stepping; larger than 1 is faster than real time. NaN when nothing was
/// measured.
double real_time_factor(const Simulation& simulation, const Totals& totals);

/// The table for people.
std::string summary_table(Simulation& simulation, const Json& method, const Totals& totals);

}  // namespace mimbre::app
