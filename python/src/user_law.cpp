#include "user_law.h"

#include <fmt/format.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
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

/// What is measured, for a function of Python: a number, or an array of six.
nb::object measured(const double* values, int components) {
  if (components == 1) return nb::float_(*values);
  using Array = nb::ndarray<nb::numpy, const double, nb::ndim<1>>;
  return nb::cast(Array(values, {static_cast<std::size_t>(components)}), nb::rv_policy::copy);
}

/// So many finite numbers, or nothing; one stands alone.
std::optional<std::vector<double>> numbers(const nb::object& given, std::size_t count, bool alone) {
  std::vector<double> values(1);
  if (!(alone ? nb::try_cast(given, values[0]) : nb::try_cast(given, values))) return {};
  const auto finite = [](double value) { return std::isfinite(value); };
  if (values.size() != count || !std::all_of(values.begin(), values.end(), finite)) return {};
  return values;
}

/// function(time, x, v, *signals) → force; with states function(time, x, v, *signals, states) → force,
/// states. Between frames x, v and the force are arrays of six.
struct Asked {
  std::string name;
  PyObject* function;  ///< which `held` keeps
  std::size_t signals, states;

  /// Throws what the function raises. That is before the step, which is then not made.
  void operator()(spec::LawCall& call) const {
    const nb::gil_scoped_acquire locked;
    const int n = call.components;
    nb::list arguments;
    arguments.append(call.time);
    arguments.append(measured(call.x, n));
    arguments.append(measured(call.v, n));
    for (std::size_t k = 0; k < signals; ++k) arguments.append(call.signals[k]);
    if (states > 0) arguments.append(std::vector<double>(call.states, call.states + states));
    const nb::object returned = nb::borrow<nb::callable>(function)(*nb::tuple(arguments));
    const bool pair = states > 0 && nb::isinstance<nb::tuple>(returned) && nb::len(returned) == 2;
    std::optional<std::vector<double>> force, next = std::vector<double>();
    if (states == 0 || pair)
      force = numbers(pair ? nb::object(returned[0]) : returned, static_cast<std::size_t>(n), n == 1);
    if (pair) next = numbers(returned[1], states, false);
    if (!force || !next) refuse(name, call.time, wanted(n).c_str(), returned);
    std::copy(force->begin(), force->end(), call.force);
    std::copy(next->begin(), next->end(), call.next);
  }

  std::string wanted(int components) const {
    if (states > 0)
      return fmt::format("({}, {} states) of finite numbers",
                         components == 1 ? "force" : "six forces and torques", states);
    return components == 1 ? "a finite number" : "six finite numbers, of force and torque,";
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
      if (element.law != placed.section || element.name != name) continue;
      element.law = "user";
      element.user = placed.law.law;
      element.arguments.clear();
      element.numbers.clear();
      for (const std::string& signal : placed.law.signals)
        element.arguments.push_back(source(model, placed, signal, element.mark));
      model.text += fmt::format("# The force of {} was a function, which a file cannot hold.\n", name);
    }
  }
}

void bind_user_law(nb::module_& module) {
  nb::class_<UserLaw>(module, "UserLaw", "A force law that is a function.");
  nb::class_<PlacedLaw>(module, "PlacedLaw").def(nb::init<std::string, std::string, std::string, UserLaw>());
  module.def("compiled_law", &compiled_law, nb::arg("address"), nb::arg("keep"), nb::arg("signals"),
             nb::arg("states"), nb::arg("stores"));
  module.def("sampled_law", &sampled_law, nb::arg("name"), nb::arg("function"), nb::arg("signals"),
             nb::arg("states"));
}

}  // namespace mimbre::python
