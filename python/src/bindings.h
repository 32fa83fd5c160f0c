#pragma once
#include <nanobind/nanobind.h>

#include <stdexcept>

/// The module mimbre._core: what of the library Python sees, one function for each file beside this one. It
/// is thin: words, units and labels are given by the Python files, which are the package's interface.
namespace mimbre::python {

namespace nb = nanobind;

/// The computation failed, though the input could be read: mimbre.SimulationError.
struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

void bind_analysis(nb::module_& module);
void bind_equilibria(nb::module_& module);
void bind_errors(nb::module_& module);
void bind_histories(nb::module_& module);
void bind_linear(nb::module_& module);
void bind_model(nb::module_& module);
void bind_portable(nb::module_& module);
void bind_motion(nb::module_& module);
void bind_reduction(nb::module_& module);
void bind_results(nb::module_& module);
void bind_run(nb::module_& module);
void bind_simulation(nb::module_& module);
void bind_user_law(nb::module_& module);
void bind_yaml(nb::module_& module);

}  // namespace mimbre::python
