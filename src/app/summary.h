#pragma once
#include <string>
#include <vector>

#include "app/json.h"
#include "mimbre/run_summary.h"

/// The summary of a run when it has ended.
namespace mimbre::app {

using Ending = RunEnding;

/// The units of the outputs, by their names.
Json output_units(const Simulation& simulation);

/// Adds what differs from run to run: times of this machine, memory.
void add_measurements(Json& summary, const Simulation& simulation, const RunTotals& totals);

/// The table for people.
std::string summary_table(Simulation& simulation, const RunTotals& totals);

}  // namespace mimbre::app
