#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "bindings.h"
#include "played.h"

/// Runs of which a few channels are wanted and nothing else: thousands of them.
namespace mimbre::python {
namespace {

/// Tells runs in other threads to stop.
struct Stop {
  std::atomic<bool> wanted{false};
};

/// What is kept of such a run. Values: channels × instants.
struct Histories {
  RunPlan plan;
  std::vector<double> time, values;
  std::string status, message;
  double cpu_seconds = 0;  ///< of the steps

  Histories(const RunPlan& planned, std::vector<Simulation::Channel> of)
      : plan(planned),
        time(static_cast<std::size_t>(plan.rows())),
        values(of.size() * time.size()),
        channels_(std::move(of)) {}

  void record(Simulation& simulation) {
    for (std::size_t k = 0; k < channels_.size(); ++k)
      values[k * time.size() + rows_] = simulation.value(channels_[k]);
    time[rows_++] = simulation.time();
  }

  /// With all planned instants, as runs have that no event ends: what it has not is not a number.
  void pad() {
    const std::size_t had = time.size();
    std::vector<double> instants, padded;
    for (std::int64_t made = 0;; made = plan.next_row(made)) {
      instants.push_back(made == plan.steps ? plan.end : static_cast<double>(made) * plan.step);
      if (made == plan.steps) break;
    }
    for (std::size_t k = 0; k < channels_.size(); ++k)
      for (std::size_t i = 0; i < instants.size(); ++i) {
        const bool there = i < had && std::abs(time[i] - instants[i]) < 1e-6 * plan.step;
        padded.push_back(there ? values[k * had + i] : std::numeric_limits<double>::quiet_NaN());
      }
    time = std::move(instants);
    values = std::move(padded);
  }

  /// A run that an event has ended has fewer rows than were planned.
  void cut() {
    const std::size_t planned = time.size();
    if (rows_ == planned) return;
    for (std::size_t k = 1; k < channels_.size(); ++k)
      std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(k * planned), rows_,
                  values.begin() + static_cast<std::ptrdiff_t>(k * rows_));
    values.resize(channels_.size() * rows_);
    time.resize(rows_);
  }

 private:
  std::vector<Simulation::Channel> channels_;
  std::size_t rows_ = 0;
};

using View1 = nb::ndarray<nb::numpy, const double, nb::ndim<1>>;
using View2 = nb::ndarray<nb::numpy, const double, nb::ndim<2>>;
using Self = nb::handle_t<Histories>;

/// The interpreter's lock is taken where inputs are functions of Python alone.
Histories histories(const LoadedModel& loaded, const MethodChoice& method, std::optional<double> until,
                    const std::vector<Table>& tables, const std::vector<Function>& functions,
                    const std::vector<std::string>& names, const Stop& stop) {
  Inputs inputs(tables, functions);
  Asked asked(loaded, method, until, inputs);
  asked.options.validity = asked.options.warnings = false;  // which nobody reads
  Attention attention;
  std::optional<Histories> found;
  {
    const nb::gil_scoped_release others_run;
    Simulation simulation(loaded.model, asked.options);
    inputs.attach(simulation);
    std::vector<Simulation::Channel> channels;
    for (const std::string& name : names) channels.push_back(simulation.channel(name));
    found.emplace(asked.plan, std::move(channels));
    RunTotals totals;
    const RunEnding ending = simulate(simulation, asked.plan, inputs, *found, totals, attention, [&] {
      return stop.wanted.load(std::memory_order_relaxed) || attention.stop();
    });
    found->cut();
    found->status = ending.status;
    found->message = ending.message;
    found->cpu_seconds = totals.cpu_seconds;
  }
  attention.raise();
  return std::move(*found);
}

/// Throws what is wrong with all runs that are asked for so.
void check_run(const LoadedModel& loaded, const MethodChoice& method, std::optional<double> until) {
  Inputs none({}, {});
  Asked(loaded, method, until, none);
}

}  // namespace

void bind_histories(nb::module_& module) {
  nb::class_<Stop>(module, "Stop", "Ends runs in other threads.")
      .def(nb::init<>())
      .def("set", [](Stop& stop) { stop.wanted = true; })
      .def_prop_ro("is_set", [](const Stop& stop) { return stop.wanted.load(); });
  nb::class_<Histories>(module, "Histories", "Some channels of a run, and how it ended.")
      .def("pad", &Histories::pad, "To all planned instants: behind the end by an event not a number.")
      .def_ro("status", &Histories::status)
      .def_ro("message", &Histories::message)
      .def_ro("cpu_seconds", &Histories::cpu_seconds, "Of the steps.")
      .def_prop_ro(
          "time",
          [](Self self) {
            const auto& time = nb::cast<const Histories&>(self).time;
            return View1(time.data(), {time.size()}, self);
          },
          nb::rv_policy::automatic)
      .def_prop_ro(
          "values",
          [](Self self) {
            const auto& h = nb::cast<const Histories&>(self);
            return View2(h.values.data(),
                         {h.time.empty() ? 0 : h.values.size() / h.time.size(), h.time.size()}, self);
          },
          nb::rv_policy::automatic, "Channels × instants.");
  module.def("check_run", &check_run, nb::arg("model"), nb::arg("method"), nb::arg("until").none());
  module.def("histories", &histories, nb::arg("model"), nb::arg("method"), nb::arg("until").none(),
             nb::arg("tables"), nb::arg("functions"), nb::arg("channels"), nb::arg("stop"));
}

}  // namespace mimbre::python
