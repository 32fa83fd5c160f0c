#include "mimbre/model.h"

#include <fmt/format.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "bindings.h"
#include "loaded_model.h"
#include "mimbre/assembly.h"
#include "mimbre/build.h"
#include "mimbre/input_table.h"
#include "mimbre/method_names.h"
#include "mimbre/model_file.h"
#include "mimbre/urdf.h"
#include "user_law.h"

namespace mimbre::python {
namespace {

using Parameters = std::map<std::string, std::string>;
using Place = std::tuple<std::string, int, int, std::string>;  ///< as mimbre.Diagnostic

template <class Read>
std::shared_ptr<LoadedModel> loaded(const Parameters& parameters, const Read& read) {
  const nb::gil_scoped_release others_run;
  auto result = std::make_shared<LoadedModel>();
  result->parameters = parameters;
  result->model = Model::compile(brought_together(read(*result)));
  return result;
}

std::shared_ptr<LoadedModel> load(const std::string& path, const Parameters& parameters) {
  return loaded(parameters,
                [&](LoadedModel& to) { return load_model(path, parameters, &to.warnings, &to.other_files); });
}

std::shared_ptr<LoadedModel> parse(const std::string& text, const std::string& name,
                                   const std::string& directory, const Parameters& parameters,
                                   const std::vector<PlacedLaw>& laws) {
  return loaded(parameters, [&](LoadedModel& to) {
    spec::Model model = parse_model(text, name, directory, parameters, &to.warnings, &to.other_files);
    put_laws(model, laws);
    return model;
  });
}

std::vector<Place> places_of(const std::vector<Diagnostic>& diagnostics) {
  std::vector<Place> list;
  for (const Diagnostic& d : diagnostics)
    list.emplace_back(d.mark.file, d.mark.line, d.mark.column, d.message);
  return list;
}

std::vector<Place> warnings_of(const LoadedModel& loaded) { return places_of(loaded.warnings); }

/// The text of a robot's model file, which names other files from `folder`, and what was left out.
std::tuple<std::string, std::vector<Place>> robot(const std::string& path, const std::string& folder,
                                                  bool floating, bool keep_fixed, const Parameters& packages,
                                                  bool repair) {
  const nb::gil_scoped_release others_run;
  const ConvertedRobot converted = convert_urdf(path, {floating, keep_fixed, packages, folder, repair});
  std::vector<Diagnostic> notes = converted.notes;
  for (const Diagnostic& one : converted.repairs) notes.push_back({one.mark, "repaired: " + one.message});
  return {converted.text, places_of(notes)};
}

template <class Things>
std::vector<std::string> names_of(const Things& things) {
  std::vector<std::string> names;
  for (const auto& thing : things) names.push_back(thing.name);
  return names;
}

/// One of the words that there are, or none.
template <class Words>
std::string word(const char* name, const std::optional<std::string>& given, const Words& words) {
  if (!given) return {};
  const std::vector<std::string> all(words.begin(), words.end());
  if (std::find(all.begin(), all.end(), *given) != all.end()) return *given;
  throw InputError(Mark{}, fmt::format("{}: '{}' is not one of {}{}", name, *given, fmt::join(all, ", "),
                                       did_you_mean(*given, all)));
}

/// Names of inputs, with the times and values that a table has of them.
std::vector<std::tuple<std::string, std::vector<double>, std::vector<double>>> input_table(
    const LoadedModel& loaded, const std::string& path, const std::string& name) {
  const std::vector<spec::Input>& inputs = loaded.model->spec().inputs;
  std::vector<std::tuple<std::string, std::vector<double>, std::vector<double>>> tables;
  for (RecordedInput& read : read_input_table(path, inputs, name))
    tables.emplace_back(inputs[static_cast<std::size_t>(read.input)].name, std::move(read.times),
                        std::move(read.values));
  return tables;
}

void require(bool good, const char* name, std::optional<double> value, const char* wanted) {
  if (!good) throw InputError(Mark{}, fmt::format("{}: is {}; {} is needed", name, *value, wanted));
}

MethodChoice choice(const std::optional<std::string>& formulation, const std::optional<std::string>& inertia,
                    const std::optional<std::string>& formalism, const std::optional<std::string>& integrator,
                    std::optional<double> rho, std::optional<double> xi, std::optional<double> tolerance,
                    std::optional<double> accuracy, std::optional<int> max_iterations,
                    std::optional<int> substeps, std::optional<bool> fixed_cost, std::optional<double> step) {
  MethodChoice result;
  MethodArguments& to = result.arguments;
  to.formulation = word("formulation", formulation, method_names::formulations);
  to.inertia = word("inertia", inertia, method_names::inertias);
  to.formalism = word("formalism", formalism, method_names::formalisms);
  to.integrator = word("integrator", integrator, method_names::integrators);
  require(!rho || (*rho >= 0 && *rho <= 1), "rho", rho, "a number from 0 to 1");
  require(!xi || (*xi <= 0 && std::isfinite(*xi)), "xi", xi, "a number of at most 0");
  require(!tolerance || (*tolerance >= 1e-15 && *tolerance <= 1), "tolerance", tolerance,
          "a number from 1e-15 to 1");
  require(!accuracy || (*accuracy >= 1e-15 && *accuracy <= 1), "accuracy", accuracy,
          "a number from 1e-15 to 1");
  require(!max_iterations || (*max_iterations >= 1 && *max_iterations <= 1000), "max_iterations",
          max_iterations, "a whole number from 1 to 1000");
  require(!substeps || (*substeps >= 1 && *substeps <= 100), "substeps", substeps,
          "a whole number from 1 to 100");
  require(!step || (*step > 0 && std::isfinite(*step)), "step", step, "a number of seconds above 0");
  to.rho = rho;
  to.xi = xi;
  to.tolerance = tolerance;
  to.accuracy = accuracy;
  to.max_iterations = max_iterations.value_or(0);
  to.substeps = substeps.value_or(0);
  to.fixed_cost = fixed_cost.value_or(false);
  to.no_fixed_cost = !fixed_cost.value_or(true);
  result.step = step.value_or(0);
  return result;
}

}  // namespace

RunOptions MethodChoice::options(const spec::Simulation& given) const {
  RunOptions result = run_options(arguments, given);
  result.step = step;
  return result;
}

void bind_model(nb::module_& module) {
  nb::class_<LoadedModel>(module, "Model", "A compiled model; any number of threads may share it.")
      .def_prop_ro("title", [](const LoadedModel& m) { return m.model->spec().title; })
      .def_prop_ro("text", [](const LoadedModel& m) { return m.model->spec().text; })
      .def_prop_ro("file", [](const LoadedModel& m) { return m.model->spec().file; })
      .def_prop_ro("warnings", &warnings_of)
      .def_ro("other_files", &LoadedModel::other_files)
      .def_ro("parameters", &LoadedModel::parameters)
      .def_prop_ro("bodies", [](const LoadedModel& m) { return names_of(m.model->spec().bodies); })
      .def_prop_ro("joints", [](const LoadedModel& m) { return names_of(m.model->spec().joints); })
      .def_prop_ro("inputs", [](const LoadedModel& m) { return names_of(m.model->spec().inputs); })
      .def_prop_ro("outputs", [](const LoadedModel& m) { return names_of(m.model->spec().outputs); })
      .def_prop_ro("coordinates", [](const LoadedModel& m) { return m.model->coordinates(); })
      .def_prop_ro("elastic_coordinates", [](const LoadedModel& m) { return m.model->elastic_coordinates(); })
      .def_prop_ro("constraints", [](const LoadedModel& m) { return m.model->constraints(); })
      .def_prop_ro("starts_at_equilibrium",
                   [](const LoadedModel& m) { return m.model->spec().simulation.start_at_equilibrium; });
  module.def("load", &load, nb::arg("path"), nb::arg("parameters"));
  module.def("read_input_table", &input_table, nb::arg("model"), nb::arg("path"), nb::arg("name"));
  module.def("robot", &robot, nb::arg("path"), nb::arg("folder"), nb::arg("floating"), nb::arg("keep_fixed"),
             nb::arg("packages"), nb::arg("repair"));
  module.def("parse", &parse, nb::arg("text"), nb::arg("name"), nb::arg("directory"), nb::arg("parameters"),
             nb::arg("laws") = std::vector<PlacedLaw>());

  nb::class_<MethodChoice>(module, "Method", "How a run is computed; replaces settings of the model.");
  module.def("method", &choice, nb::arg("formulation") = nb::none(), nb::arg("inertia") = nb::none(),
             nb::arg("formalism") = nb::none(), nb::arg("integrator") = nb::none(),
             nb::arg("rho") = nb::none(), nb::arg("xi") = nb::none(), nb::arg("tolerance") = nb::none(),
             nb::arg("accuracy") = nb::none(), nb::arg("max_iterations") = nb::none(),
             nb::arg("substeps") = nb::none(), nb::arg("fixed_cost") = nb::none(),
             nb::arg("step") = nb::none());
  module.def("version", [] { return std::string(build_info().version); });
}

}  // namespace mimbre::python
