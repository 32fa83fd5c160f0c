#pragma once
#include <fmt/format.h>
#include <nanobind/nanobind.h>

#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "attention.h"
#include "loaded_model.h"
#include "mimbre/recorded_inputs.h"
#include "mimbre/run_summary.h"

/// Runs with inputs that are played, whatever is kept of them.
namespace mimbre::python {

/// An input's name with a table of times and values, or with a function of time.
using Table = std::tuple<std::string, std::vector<double>, std::vector<double>>;
using Function = std::tuple<std::string, nanobind::callable>;

/// Inputs that a run plays: tables as the program does, functions of Python once a step. Made and destroyed
/// with the interpreter's lock.
class Inputs {
 public:
  Inputs(const std::vector<Table>& tables, const std::vector<Function>& functions);
  /// What they are at the start. Calls functions, with the interpreter's lock.
  std::map<std::string, double> start();
  void attach(const Simulation& simulation);
  /// Before a step, without the lock.
  void set(Simulation& simulation, Attention& attention);

 private:
  struct Called {
    int input;
    std::string name;
    nanobind::callable function;
  };
  void call(Simulation& simulation);

  RecordedInputs recorded_;
  std::vector<Called> functions_;
};

/// What a run is asked for, checked: its options and its steps. Made with the interpreter's lock.
struct Asked {
  Asked(const LoadedModel& loaded, const MethodChoice& method, std::optional<double> until, Inputs& inputs);
  RunOptions options;
  RunPlan plan;
};

/// The loop of `mimbre run`, with its rows in memory. `stop`: asked before each step.
template <class Rows, class Stop>
RunEnding simulate(Simulation& simulation, const RunPlan& plan, Inputs& inputs, Rows& rows, RunTotals& totals,
                   Attention& attention, const Stop& stop) {
  const auto before_step = [&] {
    inputs.set(simulation, attention);
    return stop();
  };
  rows.record(simulation);
  std::int64_t recorded = 0;
  const auto stopped = [&](RunEnding ending) {
    if (recorded < totals.steps) rows.record(simulation);
    return ending;
  };
  while (totals.steps < plan.steps) {
    const std::int64_t row = plan.next_row(totals.steps);
    StepReport report;
    try {
      report = advance(simulation, plan, row, totals, before_step);
    } catch (nanobind::python_error& error) {  // of a law, before its step was made
      attention.keep(error);
    }
    if (!report.ok()) return stopped({"failed", simulation.explain(report)});
    if (simulation.stopped()) {
      rows.record(simulation);
      return {};
    }
    if (totals.steps < row)
      return stopped({"interrupted",
                      fmt::format("interrupted at t = {:.6g} s of {:.6g} s", simulation.time(), plan.end)});
    rows.record(simulation);
    recorded = row;
  }
  return {};
}

}  // namespace mimbre::python
