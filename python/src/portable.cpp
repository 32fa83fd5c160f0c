#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <filesystem>
#include <tuple>

#include "bindings.h"
#include "loaded_model.h"
#include "mimbre/fmu.h"

/// Code and FMUs of models.
namespace mimbre::python {
namespace {

std::string name_or(const LoadedModel& m, const std::string& name) {
  return name.empty() ? identifier_of(m.model->spec().file) : name;
}

/// The path of the source, and what is not in it.
std::tuple<std::string, std::vector<std::string>> generate(const LoadedModel& m, const MethodChoice& method,
                                                           const std::string& folder,
                                                           const std::string& name) {
  const nb::gil_scoped_release others_run;
  const GeneratedCode code =
      generate_code(m.model, method.options(m.model->spec().simulation), name_or(m, name));
  write_code(code, folder);
  return {(std::filesystem::path(folder) / (code.name + ".c")).string(), code.left_out};
}

/// What is not in the FMU, and why it has no binary.
std::tuple<std::vector<std::string>, std::string> fmu(const LoadedModel& m, const MethodChoice& method,
                                                      const std::string& path, int version,
                                                      const std::string& kind, const std::string& name,
                                                      bool binary_only, bool library, bool arrays) {
  const nb::gil_scoped_release others_run;
  FmuOptions options;
  options.version = version;
  options.kind = kind == "me" ? FmuOptions::Kind::model_exchange : FmuOptions::Kind::co_simulation;
  options.name = name_or(m, name);
  options.binary_only = binary_only;
  options.with_library = library;
  options.arrays = arrays;
  options.settings = m.parameters;
  const WrittenFmu written = write_fmu(m.model, method.options(m.model->spec().simulation), options, path);
  return {written.left_out, written.without_binary};
}

}  // namespace

void bind_portable(nb::module_& module) {
  module.def("generate", &generate, nb::arg("model"), nb::arg("method"), nb::arg("folder"), nb::arg("name"));
  module.def("fmu", &fmu, nb::arg("model"), nb::arg("method"), nb::arg("path"), nb::arg("version"),
             nb::arg("kind"), nb::arg("name"), nb::arg("binary_only"), nb::arg("library"), nb::arg("arrays"));
}

}  // namespace mimbre::python
