#include "user_law.h"

#include <fmt/format.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "bindings.h"
#include "mimbre/diagnostics.h"

/// Force laws of users: compiled ones, which stand inside the iteration and know nothing of Python, and
/// functions of Python, which are asked once a step.
namespace mimbre::python {
namespace {

/// What a compiled law is for C; docs/python.md explains the arguments, which are those of spec::LawCall.
using Compiled = void (*)(double time, double step, const double* x, const double* v, const double* signals,
                          const double* states, double* force, double* stiffness, double* damping,
                          double* next, double* stored, double* dissipating);

/// `keep` is the object whose function stands at the address: the last user of the law, who may be on any
/// thread, lets it go with the interpreter's lock.
std::shared_ptr<const spec::UserLaw> held(spec::UserLaw law, const nb::object& keep) {
  return {new spec::UserLaw(std::move(law)), [keep = keep.inc_ref().ptr()](const spec::UserLaw* made) {
            const nb::gil_scoped_acquire locked;
            delete made;
            Py_DECREF(keep);
          }};
}

UserLaw compiled_law(std::uintptr_t address, const nb::object& keep, const std::vector<std::string>& signals,
                     const std::vector<double>& states, bool stores) {
  const auto function = reinterpret_cast<Compiled>(address);
  spec::UserLaw law;
  law.states = states;
  law.elastic = stores;
  law.evaluate = [function](spec::LawCall& c) {
    function(c.time, c.step, c.x, c.v, c.signals, c.states, c.force, c.stiffness, c.damping, c.next,
             &c.stored, c.dissipating);
  };
  return {held(std::move(law), keep), signals};
}

[[noreturn]] void refuse(const std::string& name, double time, const char* wanted,
                         const nb::object& returned) {
  PyErr_Format(PyExc_ValueError, "law '%s': at t = %s its function gave %R; %s is needed", name.c_str(),
               fmt::format("{}", time).c_str(), returned.ptr(), wanted);
  nb::raise_python_error();
}

/// function(time, x, v, *signals) → force; with states function(time, x, v, *signals, states) → force,
/// states.
struct Asked {
  std::string name;
  PyObject* function;  ///< which `held` keeps
  std::size_t signals, states;

  /// Throws what the function raises. That is before the step, which is then not made.
  void operator()(spec::LawCall& call) const {
    const nb::gil_scoped_acquire locked;
    nb::list arguments;
    for (const double value : {call.time, *call.x, *call.v}) arguments.append(value);
    for (std::size_t k = 0; k < signals; ++k) arguments.append(call.signals[k]);
    if (states > 0) arguments.append(std::vector<double>(call.states, call.states + states));
    nb::object returned = nb::borrow<nb::callable>(function)(*nb::tuple(arguments));
    double force = 0;
    if (states == 0) {
      if (!nb::try_cast(returned, force) || !std::isfinite(force))
        refuse(name, call.time, "a finite number", returned);
    } else {
      std::pair<double, std::vector<double>> both;
      const bool good = nb::isinstance<nb::tuple>(returned) && nb::len(returned) == 2 &&
                        nb::try_cast(nb::object(returned[0]), both.first) &&
                        nb::try_cast(nb::object(returned[1]), both.second);
      const auto finite = [](double value) { return std::isfinite(value); };
      if (!good || both.second.size() != states || !finite(both.first) ||
          !std::all_of(both.second.begin(), both.second.end(), finite))
        refuse(name, call.time, fmt::format("(force, {} states) of finite numbers", states).c_str(),
               returned);
      force = both.first;
      std::copy(both.second.begin(), both.second.end(), call.next);
    }
    *call.force = force;
  }
};

UserLaw sampled_law(const std::string& name, const nb::callable& function,
                    const std::vector<std::string>& signals, const std::vector<double>& states) {
  spec::UserLaw law;
  law.sampled = true;
  law.states = states;
  law.evaluate = Asked{name, function.ptr(), signals.size(), states.size()};
  return {held(std::move(law), function), signals};
}

template <class Things>
int index_of(const Things& things, const std::string& name) {
  const auto at = std::find_if(things.begin(), things.end(), [&](const auto& t) { return t.name == name; });
  return at == things.end() ? -1 : static_cast<int>(at - things.begin());
}

spec::Source source(const spec::Model& model, const PlacedLaw& law, const std::string& name,
                    const Mark& mark) {
  using Kind = spec::Source::Kind;
  for (const std::string& full : {law.instance + name, name}) {
    if (const int k = index_of(model.signals, full); k >= 0) return {Kind::signal, k};
    if (const int k = index_of(model.inputs, full); k >= 0) return {Kind::input, k};
  }
  std::vector<std::string> known;
  for (const spec::Signal& signal : model.signals)
    if (signal.named) known.push_back(signal.name);
  for (const spec::Input& input : model.inputs) known.push_back(input.name);
  throw InputError(
      mark, fmt::format("law '{}': signals: there is no signal, input or tunable parameter "
                        "'{}'{}; there are: {}",
                        law.instance + law.name, name, did_you_mean(name, known), fmt::join(known, ", ")));
}

}  // namespace

void put_laws(spec::Model& model, const std::vector<PlacedLaw>& laws) {
  for (const PlacedLaw& placed : laws) {
    const std::string name = placed.instance + placed.name;
    for (spec::Element& element : model.elements) {
      if (element.law != "actuator" || element.name != name) continue;
      element.law = "user";
      element.user = placed.law.law;
      element.arguments.clear();
      for (const std::string& signal : placed.law.signals)
        element.arguments.push_back(source(model, placed, signal, element.mark));
      model.text += fmt::format("# The force of {} was a function, which is not said here.\n", name);
    }
  }
}

void bind_user_law(nb::module_& module) {
  nb::class_<UserLaw>(module, "UserLaw", "A force law that is a function.");
  nb::class_<PlacedLaw>(module, "PlacedLaw").def(nb::init<std::string, std::string, UserLaw>());
  module.def("compiled_law", &compiled_law, nb::arg("address"), nb::arg("keep"), nb::arg("signals"),
             nb::arg("states"), nb::arg("stores"));
  module.def("sampled_law", &sampled_law, nb::arg("name"), nb::arg("function"), nb::arg("signals"),
             nb::arg("states"));
}

}  // namespace mimbre::python
