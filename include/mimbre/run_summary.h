#pragma once
#include <string>
#include <vector>

#include "mimbre/run.h"

/// Objects in JSON (schema/output.schema.json) that describe a run. Numbers that are not finite are null.
namespace mimbre {

/// How a run ended.
struct RunEnding {
  std::string status = "ok";  ///< "ok", "failed" or "interrupted"
  std::string message;        ///< what went wrong, empty when nothing did
};

/// What is the same whenever the same run is made: this is kept in the results file.
std::string run_summary(Simulation& simulation, const RunTotals& totals, const RunEnding& ending,
                        const std::vector<std::string>& warnings);

/// That, with what differs from run to run: times of this machine, memory, the build.
std::string measured_summary(const std::string& summary, const Simulation& simulation,
                             const RunTotals& totals);

/// What was asked for of the options that the command line has, by their names there ("integrator_xi").
std::string arguments_summary(const RunOptions& asked);

/// The method in force: formulation, inertia, formalism, integrator, and rho or xi.
std::string method_summary(const Method& method);

/// All that was resolved: that, with the constants of the iterations, parts of repeated steps, step, end,
/// whether nobody gave the end, and output interval.
std::string resolved_summary(const Method& method);

/// The process's largest resident memory so far, MB (10⁶ bytes).
double peak_memory_mb();

}  // namespace mimbre
