#include "mimbre/run.h"

#include <fmt/format.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <nlohmann/json.hpp>

#include "app/common.h"
#include "app/recorded_inputs.h"
#include "app/summary.h"
#include "attention.h"
#include "bindings.h"
#include "loaded_model.h"
#include "mimbre/results.h"

namespace mimbre::python {
namespace {

/// An input's name with a table of times and values, or with a function of time.
using Table = std::tuple<std::string, std::vector<double>, std::vector<double>>;
using Function = std::tuple<std::string, nb::callable>;

/// Inputs that a run plays: tables as the program does, functions of Python once a step.
class Inputs {
 public:
  Inputs(const std::vector<Table>& tables, const std::vector<Function>& functions) {
    for (const auto& [name, times, values] : tables) recorded_.add(name, times, values);
    for (const auto& [name, function] : functions) functions_.push_back({-1, name, function});
  }

  void attach(const Simulation& simulation) {
    recorded_.attach(simulation);
    for (Called& called : functions_) called.input = simulation.input(called.name);
  }

  void set(Simulation& simulation, Attention& attention) {
    recorded_.set(simulation);
    if (!functions_.empty()) attention.call([&] { call(simulation); });
  }

 private:
  struct Called {
    int input;
    std::string name;
    nb::callable function;
  };

  void call(Simulation& simulation) {
    for (const Called& called : functions_) {
      const bool linear =
          simulation.inputs()[static_cast<std::size_t>(called.input)].hold == spec::Input::Hold::linear;
      const double time = simulation.time() + (linear ? simulation.step_size() : 0);
      const nb::object returned = called.function(time);
      double value = 0;
      if (!nb::try_cast(returned, value) || !std::isfinite(value)) {
        PyErr_Format(PyExc_ValueError,
                     "input '%s': at t = %s its function gave %R; a finite number is needed",
                     called.name.c_str(), fmt::format("{}", time).c_str(), returned.ptr());
        nb::raise_python_error();
      }
      simulation.set_input(called.input, value);
    }
  }

  app::RecordedInputs recorded_;
  std::vector<Called> functions_;
};

/// The rows of a run, in the memory of its results. Their number is known from the start.
class Rows {
 public:
  Rows(Results& results, const Simulation& simulation, const RunPlan& plan) : results_(results) {
    Eigen::Index count = 1;
    for (std::int64_t made = 0; made < plan.steps; made = plan.next_row(made)) ++count;
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
  app::Json json = app::Json::object();
  for (const auto& [name, value] : loaded.parameters) json["set"][name] = value;
  if (method.step > 0) json["step"] = method.step;
  if (until) json["until"] = *until;
  for (const auto& [name, times, values] : tables)
    json["input"].push_back(fmt::format("{}=table of {} points", name, times.size()));
  for (const auto& [name, function] : functions) json["input"].push_back(name + "=function");
  json.update(app::to_json(method.arguments));
  return app::to_text(json);
}

/// The loop of `mimbre run`, with its rows in memory.
app::Ending simulate(Simulation& simulation, const RunPlan& plan, Inputs& inputs, Rows& rows,
                     RunTotals& totals, Attention& attention) {
  const auto stop = [&] {
    inputs.set(simulation, attention);
    return attention.stop();
  };
  inputs.set(simulation, attention);
  rows.record(simulation);
  std::int64_t recorded = 0;
  const auto stopped = [&](app::Ending ending) {
    if (recorded < totals.steps) rows.record(simulation);
    return ending;
  };
  while (totals.steps < plan.steps) {
    const std::int64_t row = plan.next_row(totals.steps);
    StepReport report;
    try {
      report = advance(simulation, plan, row, totals, stop);
    } catch (nb::python_error& error) {  // of a law, before its step was made
      attention.keep(error);
    }
    if (!report.ok()) return stopped({"failed", simulation.explain(report)});
    if (totals.steps < row)
      return stopped({"interrupted",
                      fmt::format("interrupted at t = {:.6g} s of {:.6g} s", simulation.time(), plan.end)});
    rows.record(simulation);
    recorded = row;
  }
  return {};
}

Finished run(const LoadedModel& loaded, const MethodChoice& method, std::optional<double> until,
             const std::vector<Table>& tables, const std::vector<Function>& functions,
             const std::optional<nb::callable>& progress) {
  if (until && !(*until >= 0 && std::isfinite(*until)))
    throw InputError(Mark{}, fmt::format("until: is {}; a number of seconds from 0 is needed", *until));
  const spec::Simulation& given = loaded.model->spec().simulation;
  RunOptions options = method.options(given);
  options.end = until.value_or(-1);
  const RunPlan plan =
      app::planned(given, options, method.step > 0 ? std::optional(method.step) : std::nullopt, until);
  Finished finished{std::make_shared<Results>(), {}, {}, {}, nb::none()};
  const Simulation* running = nullptr;
  Attention attention([&] {
    if (progress && running) (*progress)(running->time());
  });
  Inputs inputs(tables, functions);  // which hold objects of Python
  {
    const nb::gil_scoped_release others_run;
    Simulation simulation(loaded.model, options);
    running = &simulation;
    inputs.attach(simulation);
    Results& results = *finished.results;
    results.header = simulation.header(options_json(loaded, method, until, tables, functions));
    Rows rows(results, simulation, plan);
    RunTotals totals;
    const app::Ending ending = simulate(simulation, plan, inputs, rows, totals, attention);
    rows.finish();
    std::vector<std::string> warnings;
    for (const Diagnostic& warning : loaded.warnings) warnings.push_back(to_string(warning));
    for (const std::string& warning : simulation.warnings()) warnings.push_back(warning);
    app::Json summary = app::run_summary(simulation, totals, ending, warnings);
    results.summary_json = app::to_text(summary);
    app::add_measurements(summary, simulation, totals);
    finished.measured_json = app::to_text(summary);
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
      .def_prop_ro("raised", [](const Finished& f) { return f.raised; });
  module.def("run", &run, nb::arg("model"), nb::arg("method"), nb::arg("until").none(), nb::arg("tables"),
             nb::arg("functions"), nb::arg("progress").none());
}

}  // namespace mimbre::python
