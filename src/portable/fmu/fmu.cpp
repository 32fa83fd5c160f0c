#include "mimbre/fmu.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>
#include <stdexcept>

#include "base/output_place.h"
#include "base/sha256.h"
#include "mimbre/diagnostics.h"
#include "mimbre/method_names.h"
#include "portable/code_parts.h"
#include "portable/fmu/extra.h"
#include "portable/fmu/icon.h"
#include "portable/fmu/output_places.h"
#include "portable/fmu/parts.h"
#include "portable/fmu/terminals.h"
#include "portable/library/library_code.h"

namespace mimbre {
namespace {

using Role = FmuVariable::Role;

constexpr double none = std::numeric_limits<double>::infinity();

/// Continuous states, their derivatives, and event indicators, by `add`; the first has the reference `first`.
template <class Add>
void add_states(const GeneratedCode& code, int version, const Add& add, unsigned first) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < code.states.size(); ++k) names.push_back(fmt::format("state.{}", k + 1));
  for (std::size_t k = 0; k < code.states.size(); ++k)
    add({names[k], code.states[k].unit, code.states[k].meaning, 0, Role::state, false, 0, -none, none},
        "fmu.");
  for (std::size_t k = 0; k < code.states.size(); ++k) {
    FmuVariable v{fmt::format("der({})", names[k]),
                  code.states[k].rate_unit,
                  "",
                  0,
                  Role::derivative,
                  false,
                  0,
                  -none,
                  none};
    v.depends_on_all = true;
    v.state = first + static_cast<unsigned>(k);
    add(std::move(v), "fmu.");
  }
  if (version == 2) return;  // where indicators are no variables
  for (int k = 0; k < code.indicators; ++k) {
    FmuVariable v{fmt::format("indicator.{}", k + 1),
                  "",
                  "positive while the continuous states are well chosen",
                  0,
                  Role::indicator,
                  false,
                  0,
                  -none,
                  none};
    v.depends_on_all = true;
    add(std::move(v), "fmu.");
  }
}

/// Fixed parameters: real numbers, or whole ones.
template <class Add>
void add_parameters(const GeneratedCode& code, bool integer, const Add& add) {
  for (const GeneratedParameter& p : code.parameters)
    if (p.integer == integer)
      add({p.name, integer ? "" : "1", p.meaning, 0, p.derived ? Role::derived : Role::fixed, integer,
           p.start, p.min, p.max},
          "parameter.");
}

/// References are the places in the list.
std::vector<FmuVariable> variables_of(const GeneratedCode& code, FmuOptions::Kind kind, int version) {
  const bool exchange = kind == FmuOptions::Kind::model_exchange;
  const unsigned first_state = static_cast<unsigned>(1 + code.inputs.size() + code.outputs.size());
  std::vector<FmuVariable> list;
  std::set<std::string> names;
  const auto add = [&](FmuVariable v, const std::string& otherwise) {
    if (names.contains(v.name)) v.name = otherwise + v.name;
    while (!names.insert(v.name).second) v.name += "_";
    list.push_back(std::move(v));
  };
  // Where a model calls something so, that has the name.
  const auto is_called = [&](const std::string& name) {
    const auto same = [&](const GeneratedVariable& v) { return v.name == name; };
    return std::any_of(code.inputs.begin(), code.inputs.end(), same) ||
           std::any_of(code.outputs.begin(), code.outputs.end(), same);
  };
  add({is_called("time") ? "fmu.time" : "time", "s", "time", 0, Role::time, false, 0, -none, none}, "");
  for (const GeneratedVariable& v : code.inputs)
    add({v.name, v.unit.empty() ? "1" : v.unit, v.meaning, 0, v.tunable ? Role::parameter : Role::input,
         false, v.start, v.min, v.max},
        "input.");
  int number = 0;
  for (const GeneratedVariable& v : code.outputs) {
    FmuVariable output{v.name, v.unit.empty() ? "1" : v.unit, v.meaning, 0, Role::output, false, 0, -none,
                       none};
    output.outputs = {number++};
    // Both versions count the time among the knowns, parameters FMI 3 alone.
    if (v.by_time) output.dependencies.push_back(0);
    for (const int input : v.inputs)
      if (version == 3 || !code.inputs[static_cast<std::size_t>(input)].tunable)
        output.dependencies.push_back(1 + static_cast<unsigned>(input));
    output.depends_on_all = exchange && v.by_acceleration;
    for (unsigned k = 0; exchange && v.by_state && k < code.states.size(); ++k)
      output.dependencies.push_back(first_state + k);
    add(std::move(output), "output.");
  }
  add_parameters(code, false, add);
  if (exchange)
    add_states(code, version, add, first_state);
  else
    for (const auto& [name, meaning] :
         {std::pair("solver.steps", "steps of the model so far"),
          std::pair("solver.iterations", "iterations of the last communication step"),
          std::pair("solver.unconverged_steps",
                    "steps so far that were taken before their iterations had converged")})
      add({name, "", meaning, 0, Role::count, true, 0, -none, none}, "fmu.");
  add_parameters(code, true, add);
  for (std::size_t k = 0; k < list.size(); ++k) list[k].reference = static_cast<unsigned>(k);
  return list;
}

/// The components of a vector as one variable, with the reference of the first of them.
FmuVariable joined(const std::vector<FmuVariable>& list, const portable::OutputVector& vector) {
  FmuVariable out;
  std::set<unsigned> dependencies;
  for (const FmuVariable& v : list) {
    if (v.outputs.size() != 1 ||
        std::find(vector.outputs.begin(), vector.outputs.end(), v.outputs[0]) == vector.outputs.end())
      continue;
    if (out.outputs.empty()) out = v;
    out.outputs = vector.outputs;
    out.depends_on_all = out.depends_on_all || v.depends_on_all;
    dependencies.insert(v.dependencies.begin(), v.dependencies.end());
  }
  out.dependencies.assign(dependencies.begin(), dependencies.end());
  out.meaning = vector.meaning;
  return out;
}

/// Where all components of a vector are outputs whose names have a stem in common, they become one of that
/// name.
void join_arrays(FmuCode& fmu, const spec::Model& model) {
  std::vector<FmuVariable>& list = fmu.variables;
  for (const portable::OutputVector& vector :
       portable::output_vectors(fmu.code, portable::output_places(fmu.code, model))) {
    if (vector.stem.empty()) continue;
    FmuVariable array = joined(list, vector);
    const auto is_part = [&](const FmuVariable& v) {
      return v.outputs.size() == 1 &&
             std::find(vector.outputs.begin(), vector.outputs.end(), v.outputs[0]) != vector.outputs.end();
    };
    const auto is_called = [&](const std::string& name) {
      return std::any_of(list.begin(), list.end(),
                         [&](const FmuVariable& v) { return v.name == name && !is_part(v); });
    };
    array.name = is_called(vector.stem) ? "output." + vector.stem : vector.stem;
    while (is_called(array.name)) array.name += "_";
    std::erase_if(list, [&](const FmuVariable& v) { return is_part(v) && v.reference != array.reference; });
    *std::find_if(list.begin(), list.end(), is_part) = std::move(array);
  }
}

/// Of all that the code is, in the form of a UUID.
std::string token_of(const GeneratedCode& code, int version, bool arrays) {
  Sha256 digest;
  digest.add(code.header);
  digest.add(code.source);
  digest.add(fmt::format("{}{}", version, arrays ? " arrays" : ""));
  const std::string hex = digest.hex();
  return fmt::format("{{{}-{}-{}-{}-{}}}", hex.substr(0, 8), hex.substr(8, 4), hex.substr(12, 4),
                     hex.substr(16, 4), hex.substr(20, 12));
}

void add_terminals(const FmuCode& fmu, const spec::Model& model, portable::ArchiveFiles& files) {
  const std::string folder = "terminalsAndIcons/";
  const portable::Icon icon = portable::model_icon(model), terminal = portable::terminal_icon();
  files.emplace_back(folder + "terminalsAndIcons.xml",
                     portable::terminals_description(portable::fmu_terminals(fmu, model)));
  files.emplace_back(folder + "icon.png", icon.png);
  files.emplace_back(folder + "icon.svg", icon.svg);
  files.emplace_back(folder + "terminal.png", terminal.png);
  files.emplace_back(folder + "terminal.svg", terminal.svg);
  if (fmu.version == 2) files.emplace_back("model.png", icon.png);
}

}  // namespace

FmuCode generate_fmu(const std::shared_ptr<const Model>& model, const RunOptions& options,
                     const FmuOptions& fmu) {
  if (fmu.version != 2 && fmu.version != 3)
    throw InputError(Mark{},
                     fmt::format("there is no version {} of FMI here: 2 or 3 is needed", fmu.version));
  FmuCode out;
  const bool exchange = fmu.kind == FmuOptions::Kind::model_exchange;
  if (fmu.with_library && exchange)
    throw InputError(Mark{}, "the library makes steps of its own: it is for co-simulation alone");
  if (fmu.version == 2 && fmu.arrays)
    throw InputError(Mark{}, "FMI 2 has no arrays: leave out 'arrays', or write an FMU of FMI 3");
  out.version = fmu.version;
  out.kind = fmu.kind;
  out.with_library = fmu.with_library;
  out.arrays = fmu.arrays;
  const std::string name = fmu.name.empty() ? identifier_of(model->spec().file) : fmu.name;
  out.code = fmu.with_library ? portable::library_code(model, options, name, fmu.settings)
             : exchange       ? generate_exchange_code(model, options, name)
                              : portable::generate_steps(model, options, name, true);
  out.token = token_of(out.code, fmu.version, fmu.arrays);
  out.variables = variables_of(out.code, fmu.kind, fmu.version);
  if (fmu.arrays) join_arrays(out, model->spec());
  out.wrapper = portable::fmu_wrapper(out);
  return out;
}

WrittenFmu write_fmu(const std::shared_ptr<const Model>& model, const RunOptions& options,
                     const FmuOptions& fmu, const std::string& path) {
  const FmuCode made = generate_fmu(model, options, fmu);
  const portable::FmuBinary binary = portable::compile_fmu(made);
  const bool binary_only = fmu.binary_only || fmu.with_library;
  if (binary.bytes.empty() && binary_only)
    throw InputError(
        Mark{}, fmt::format("the FMU cannot have a binary, and is to have nothing else: {}", binary.message));
  portable::ArchiveFiles files;
  files.emplace_back("modelDescription.xml", fmu_description(made, *model, !binary_only));
  add_terminals(made, model->spec(), files);
  if (!binary_only) {
    files.emplace_back(fmt::format("sources/{}.h", made.code.name), made.code.header);
    files.emplace_back(fmt::format("sources/{}.c", made.code.name), made.code.source);
    files.emplace_back("sources/" + portable::fmu_wrapper_file(made), made.wrapper);
    if (made.version == 3)
      files.emplace_back("sources/buildDescription.xml", portable::fmu_build_description(made));
  }
  if (!binary.bytes.empty()) {
    files.emplace_back(binary.file, binary.bytes);
    files.insert(files.end(), binary.with.begin(), binary.with.end());
  }
  const Method method = resolve_method(model->spec().simulation, options);
  files.emplace_back("documentation/index.html",
                     portable::fmu_page(made, *model,
                                        fmt::format("integrator {}, at most {} iterations a step",
                                                    name_of(method.integrator), method.max_iterations)));
  portable::add_extra_files(made, model, options, std::min(fmu.reference, method.end), files);
  try {
    OutputPlace place(path);
    portable::write_archive(place.path(), files);
    place.commit();
  } catch (const std::runtime_error& error) {
    throw InputError(Mark{}, fmt::format("cannot write {}: {}", path, error.what()));
  }
  WrittenFmu out;
  out.without_binary = binary.message;
  out.left_out = made.code.left_out;
  for (const auto& [name, bytes] : files) out.files.push_back(name);
  return out;
}

}  // namespace mimbre
