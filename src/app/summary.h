#pragma once
#include <string>
#include <vector>

#include "app/json.h"
#include "mimbre/run.h"

/// The summary of a run when it has ended.
namespace mimbre::app {

/// How a run ended.
struct Ending {
  std::string status = "ok";  ///< "ok", "failed" or "interrupted"
  std::string message;        ///< what went wrong, empty when nothing did
};

/// What is the same whenever the same run is made: this is kept in the results file.
Json run_summary(Simulation& simulation, const RunTotals& totals, const Ending& ending,
                 const std::vector<std::string>& warnings);

/// The units of the outputs, by their names.
Json output_units(const Simulation& simulation);

/// Adds what differs from run to run: times of this machine, memory.
void add_measurements(Json& summary, const Simulation& simulation, const RunTotals& totals);

/// The table for people.
std::string summary_table(Simulation& simulation, const RunTotals& totals);

}  // namespace mimbre::app
