#include "mimbre/model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>

#include "bindings.h"
#include "loaded_model.h"
#include "mimbre/assembly.h"
#include "mimbre/build.h"
#include "mimbre/input_table.h"
#include "mimbre/model_file.h"
#include "mimbre/page.h"
#include "mimbre/run_option.h"
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

/// What Python's arguments are: "number", "whole", "flag" or "text".
const char* kind_of(const RunOption& option) {
  if (!option.words.empty()) return "text";
  if (std::holds_alternative<OptionMember<bool>>(option.member)) return "flag";
  return std::holds_alternative<OptionMember<int>>(option.member) ? "whole" : "number";
}

/// The options that Python has, with the kinds of their values.
std::vector<std::pair<std::string, std::string>> method_options() {
  std::vector<std::pair<std::string, std::string>> options;
  for (const RunOption& option : run_option_table())
    if (!option.option.empty()) options.emplace_back(option.key, kind_of(option));
  return options;
}

/// The value of an option, as RunOptions has it.
template <class Type>
Type value_of(const RunOption& option, const nb::handle& given) {
  if constexpr (std::is_enum_v<Type>) {
    const auto word = nb::cast<std::string>(given);
    const std::vector<std::string> words(option.words.begin(), option.words.end());
    const auto found = std::find(words.begin(), words.end(), word);
    if (found == words.end())
      throw InputError(Mark{}, fmt::format("{}: '{}' is not one of {}{}", option.key, word,
                                           fmt::join(words, ", "), did_you_mean(word, words)));
    return static_cast<Type>(found - words.begin());
  } else {
    return nb::cast<Type>(given);
  }
}

/// Of arguments whose types are those of method_options().
MethodChoice choice(const nb::dict& given) {
  MethodChoice result;
  for (const auto& [name, value] : given) {
    const RunOption* const option = find_run_option(nb::cast<std::string>(name));
    if (!option)
      throw InputError(Mark{}, fmt::format("there is no option '{}'", nb::cast<std::string>(name)));
    std::visit(
        [&](const auto& m) {
          using Type = typename std::decay_t<decltype(m)>::type;
          result.asked.*m.asked = value_of<Type>(*option, value);
        },
        option->member);
    const double number = *value_in(*option, result.asked);
    if (!wrong_value(*option, number).empty())
      throw InputError(Mark{},
                       fmt::format("{}: is {}; {} is needed", option->key, number, allowed_numbers(*option)));
  }
  return result;
}

}  // namespace

RunOptions MethodChoice::options(const spec::Simulation& given) const { return run_options(asked, given); }

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
  module.def(
      "write_page", [](const LoadedModel& m, const std::string& path) { write_page(m.model, path); },
      nb::arg("model"), nb::arg("path"));
  module.def("load", &load, nb::arg("path"), nb::arg("parameters"));
  module.def("read_input_table", &input_table, nb::arg("model"), nb::arg("path"), nb::arg("name"));
  module.def("robot", &robot, nb::arg("path"), nb::arg("folder"), nb::arg("floating"), nb::arg("keep_fixed"),
             nb::arg("packages"), nb::arg("repair"));
  module.def("parse", &parse, nb::arg("text"), nb::arg("name"), nb::arg("directory"), nb::arg("parameters"),
             nb::arg("laws") = std::vector<PlacedLaw>());

  nb::class_<MethodChoice>(module, "Method", "How a run is computed; replaces settings of the model.");
  module.def("method", &choice, nb::arg("options"));
  module.def("method_options", &method_options, "The options of a run, with the kinds of their values.");
  module.def("version", [] { return std::string(build_info().version); });
}

}  // namespace mimbre::python
