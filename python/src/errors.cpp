#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <exception>
#include <regex>
#include <string>

#include "bindings.h"
#include "mimbre/unknown_name.h"
#include "mimbre/usage_error.h"

/// The library's exceptions as those of the package (mimbre/errors.py).
namespace mimbre::python {
namespace {

/// Diagnostics as mimbre.Diagnostic takes them.
nb::list to_list(const std::vector<Diagnostic>& diagnostics) {
  nb::list list;
  for (const Diagnostic& d : diagnostics)
    list.append(nb::make_tuple(d.mark.file, d.mark.line, d.mark.column, d.message));
  return list;
}

/// `make`: a class, or a function that makes an exception.
void raise(const char* make, const nb::object& argument) {
  const nb::object exception = nb::module_::import_("mimbre.errors").attr(make);
  const nb::object error = exception(argument);
  PyErr_SetObject(error.type().ptr(), error.ptr());
}

/// What the program calls options are arguments here.
std::string without_dashes(const std::string& text) {
  std::string words = std::regex_replace(text, std::regex("--integrator-xi"), "xi");
  words = std::regex_replace(words, std::regex("--no-fixed-cost"), "fixed_cost=False");
  words = std::regex_replace(words, std::regex("--([a-z]+)-([a-z]+)"), "$1_$2");
  return std::regex_replace(words, std::regex("--([a-z])"), "$1");
}

void translate(const std::exception_ptr& pointer, void*) {
  try {
    std::rethrow_exception(pointer);
  } catch (const UnknownName& error) {
    raise("_unknown_name", to_list(error.diagnostics()));
  } catch (const InputError& error) {
    raise("_input_error", to_list(error.diagnostics()));
  } catch (const UsageError& error) {
    raise("_input_error", to_list({{Mark{}, without_dashes(error.what())}}));
  } catch (const Failure& error) {
    raise("SimulationError", nb::cast(std::string(error.what())));
  }
}

}  // namespace

void bind_errors(nb::module_& module) {
  nb::register_exception_translator(translate);
  module.def(
      "did_you_mean",
      [](const std::string& name, const std::vector<std::string>& names) {
        return did_you_mean(name, names);
      },
      nb::arg("name"), nb::arg("candidates"), "\" (did you mean 'x'?)\", or nothing where none is near.");
}

}  // namespace mimbre::python
