#include "played.h"

#include <fmt/format.h>

#include <cmath>

namespace mimbre::python {

namespace nb = nanobind;

namespace {

double value(const std::string& name, const nb::callable& function, double time) {
  const nb::object returned = function(time);
  double number = 0;
  if (!nb::try_cast(returned, number) || !std::isfinite(number)) {
    PyErr_Format(PyExc_ValueError, "input '%s': at t = %s its function gave %R; a finite number is needed",
                 name.c_str(), fmt::format("{}", time).c_str(), returned.ptr());
    nb::raise_python_error();
  }
  return number;
}

}  // namespace

Inputs::Inputs(const std::vector<Table>& tables, const std::vector<Function>& functions) {
  for (const auto& [name, times, values] : tables) recorded_.add(name, times, values);
  for (const auto& [name, function] : functions) functions_.push_back({-1, name, function});
}

std::map<std::string, double> Inputs::start() {
  std::map<std::string, double> values = recorded_.start();
  for (const Called& called : functions_) values[called.name] = value(called.name, called.function, 0);
  return values;
}

void Inputs::attach(const Simulation& simulation) {
  recorded_.attach(simulation);
  for (Called& called : functions_) called.input = simulation.input(called.name);
}

void Inputs::set(Simulation& simulation, Attention& attention) {
  recorded_.set(simulation);
  if (!functions_.empty()) attention.call([&] { call(simulation); });
}

void Inputs::call(Simulation& simulation) {
  for (const Called& called : functions_) {
    const bool linear =
        simulation.inputs()[static_cast<std::size_t>(called.input)].hold == spec::Input::Hold::linear;
    simulation.set_input(called.input, value(called.name, called.function,
                                             simulation.time() + (linear ? simulation.step_size() : 0)));
  }
}

Asked::Asked(const LoadedModel& loaded, const MethodChoice& method, std::optional<double> until,
             Inputs& inputs) {
  if (until && !(*until >= 0 && std::isfinite(*until)))
    throw InputError(Mark{}, fmt::format("until: is {}; a number of seconds from 0 is needed", *until));
  const spec::Simulation& given = loaded.model->spec().simulation;
  options = method.options(given);
  options.end = until;
  options.inputs = inputs.start();
  plan = planned(given, options);
}

}  // namespace mimbre::python
