#include <nanobind/stl/string.h>

#include "bindings.h"
#include "mimbre/isolation.h"
#include "mimbre/threads.h"

NB_MODULE(_core, module) {
  module.doc() = "The compiled part of mimbre; use `import mimbre`.";
  // Exceptions that are kept until the end keep their runs: no fault of the module.
  nanobind::set_leak_warnings(false);
  module.def("isolate_reading", &mimbre::isolate_reading, nanobind::arg("program"));
  module.def("use_one_blas_thread", &mimbre::use_one_blas_thread);
  mimbre::python::bind_errors(module);
  mimbre::python::bind_user_law(module);
  mimbre::python::bind_model(module);
  mimbre::python::bind_reduction(module);
  mimbre::python::bind_results(module);
  mimbre::python::bind_run(module);
  mimbre::python::bind_histories(module);
  mimbre::python::bind_simulation(module);
  mimbre::python::bind_analysis(module);
  mimbre::python::bind_equilibria(module);
  mimbre::python::bind_portable(module);
  mimbre::python::bind_linear(module);
  mimbre::python::bind_motion(module);
  mimbre::python::bind_yaml(module);
}
