#include "mimbre/run.h"

#include <fmt/format.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "bindings.h"
#include "json_text.h"
#include "mimbre/results.h"
#include "played.h"

namespace mimbre::python {
namespace {

/// The rows of a run, in the memory of its results. Their number is known from the start.
class Rows {
 public:
  Rows(Results& results, const Simulation& simulation, const RunPlan& plan) : results_(results) {
    const Eigen::Index count = plan.rows();
    results.time.resize(count);
    results.channels.resize(count, std::ssize(simulation.channels()));
    results.poses.reserve(static_cast<std::size_t>(count));
  }

  void record(Simulation& simulation) {
    simulation.sample(row_);
    if (rows_ == 0) results_.modes.resize(results_.time.size(), row_.modes.size());
    results_.time[rows_] = row_.time;
    results_.channels.row(rows_) = row_.channels.transpose();
    results_.modes.row(rows_) = row_.modes.transpose();
    results_.poses.push_back(row_.poses);
    ++rows_;
  }

  /// What was not reached is left out.
  void finish() {
    if (rows_ == results_.time.size()) return;
    results_.time.conservativeResize(rows_);
    results_.channels.conservativeResize(rows_, Eigen::NoChange);
    results_.modes.conservativeResize(rows_, results_.modes.cols());
  }

 private:
  Results& results_;
  ResultsRow row_;
  Eigen::Index rows_ = 0;
};

struct Finished {
  std::shared_ptr<Results> results;
  std::string status, message;
  std::string measured_json;  ///< the summary with times of this machine
  nb::object raised;          ///< by Python, which stopped the run
};

std::string options_json(const LoadedModel& loaded, const MethodChoice& method, std::optional<double> until,
                         const std::vector<Table>& tables, const std::vector<Function>& functions) {
  Json json = Json::object();
  for (const auto& [name, value] : loaded.parameters) json["set"][name] = value;
  if (until) json["until"] = *until;
  for (const auto& [name, times, values] : tables)
    json["input"].push_back(fmt::format("{}=table of {} points", name, times.size()));
  for (const auto& [name, function] : functions) json["input"].push_back(name + "=function");
  json.update(Json::parse(arguments_summary(method.asked)));
  return json_text(json);
}

Finished run(const LoadedModel& loaded, const MethodChoice& method, std::optional<double> until,
             const std::vector<Table>& tables, const std::vector<Function>& functions,
             const std::optional<nb::callable>& progress) {
  Inputs inputs(tables, functions);  // which hold objects of Python
  const Asked asked(loaded, method, until, inputs);
  Finished finished{std::make_shared<Results>(), {}, {}, {}, nb::none()};
  const Simulation* running = nullptr;
  Attention attention([&] {
    if (progress && running) (*progress)(running->time());
  });
  {
    const nb::gil_scoped_release others_run;
    Simulation simulation(loaded.model, asked.options);
    running = &simulation;
    inputs.attach(simulation);
    Results& results = *finished.results;
    results.header = simulation.header(options_json(loaded, method, until, tables, functions));
    Rows rows(results, simulation, asked.plan);
    RunTotals totals;
    const RunEnding ending =
        simulate(simulation, asked.plan, inputs, rows, totals, attention, [&] { return attention.stop(); });
    rows.finish();
    std::vector<std::string> warnings;
    for (const Diagnostic& warning : loaded.warnings) warnings.push_back(to_string(warning));
    for (const std::string& warning : simulation.warnings()) warnings.push_back(warning);
    results.summary_json = run_summary(simulation, totals, ending, warnings);
    finished.measured_json = measured_summary(results.summary_json, simulation, totals);
    finished.status = ending.status;
    finished.message = ending.message;
  }
  finished.raised = attention.raised();
  return finished;
}

}  // namespace

void bind_run(nb::module_& module) {
  nb::class_<Finished>(module, "Finished")
      .def_ro("results", &Finished::results)
      .def_ro("status", &Finished::status)
      .def_ro("message", &Finished::message)
      .def_ro("measured_json", &Finished::measured_json)
      .def(
          "take_raised", [](Finished& f) { return std::exchange(f.raised, nb::none()); },
          "What Python raised, or None. Given away: with its traceback, it may lead back here, and such a "
          "circle would stay for ever.");
  module.def("run", &run, nb::arg("model"), nb::arg("method"), nb::arg("until").none(), nb::arg("tables"),
             nb::arg("functions"), nb::arg("progress").none());
}

}  // namespace mimbre::python
