#include <fmt/format.h>

#include "fmu/package.h"
#include "mimbre/fmu_import.h"
#include "model_file/sections/fmu_block.h"

namespace mimbre::model_file {
namespace {

/// The start value of a variable as text: expressions for numbers, as everywhere.
std::optional<std::string> parameter_text(const fmu::Description& description, const std::string& name,
                                          const Value& value) {
  const fmu::Variable* variable = description.find(name);
  if (variable && variable->type == fmu::Type::boolean) {
    const auto flag = value.flag();
    return flag ? std::optional<std::string>(*flag ? "true" : "false") : std::nullopt;
  }
  if (!variable || variable->type == fmu::Type::string) return value.text();
  const auto number = value.number(quantity::any);
  return number ? std::optional(fmt::format("{:.17g}", *number)) : std::nullopt;
}

/// {signal: variable}, [variable, …] or one variable.
std::vector<std::string> output_variables(const Value& value) {
  std::vector<std::string> names;
  const auto add = [&](const Value& each) {
    if (const auto name = each.text()) names.push_back(*name);
  };
  if (value.is_scalar()) {
    add(value);
  } else if (value.is_list()) {
    for (const Value& each : value.list()) add(each);
  } else if (value.is_map()) {
    for (const auto& entry : value.tree().entries)
      add(Value(value.reading(), *entry.value, fmt::format("{}: {}", value.what(), entry.key)));
  }
  return names;
}

}  // namespace

std::vector<Value> read_fmu(Builder& builder, const Fields& fields, spec::Block& block) {
  std::vector<Value> formulas;
  const auto path = fields.need("fmu", "controller.fmu");
  const auto outputs = fields.need("outputs", "[u]");
  if (!path || !outputs) return formulas;
  const auto name = path->word();
  if (!name || !has_folder(builder, *path)) return formulas;
  FmuSettings settings;
  settings.file = path_of(builder, path->mark(), *name);
  settings.outputs = output_variables(*outputs);
  if (const auto inputs = fields.get("inputs")) {
    if (!inputs->is_map()) inputs->error("names of the FMU's inputs with formulas are needed: {y: angle}");
    for (const auto& entry : inputs->tree().entries) {
      settings.inputs.push_back(entry.key);
      formulas.emplace_back(inputs->reading(), *entry.value,
                            fmt::format("{}: {}", inputs->what(), entry.key));
    }
  }
  if (const auto at = fields.get("inputs_at"))
    settings.inputs_of_the_end = at->choice({"start", "end"}).value_or(0) == 1;
  if (const auto process = fields.get("process")) settings.process = process->flag().value_or(false);
  if (const auto timeout = fields.get("timeout")) {
    settings.timeout = timeout->positive(quantity::time).value_or(settings.timeout);
    if (!settings.process) timeout->error("is of a process of its own: set `process: true` as well");
  }
  builder.other_files.push_back(settings.file);
  try {
    if (const auto parameters = fields.get("parameters")) {
      const auto package = fmu::Package::open(settings.file);
      if (!parameters->is_map())
        parameters->error("names of the FMU's parameters with values are needed: {kp: 2}");
      for (const auto& entry : parameters->tree().entries)
        if (const auto text = parameter_text(package->description(), entry.key,
                                             Value(parameters->reading(), *entry.value,
                                                   fmt::format("{}: {}", parameters->what(), entry.key))))
          settings.parameters[entry.key] = *text;
    }
    block.outside = load_fmu(settings);
  } catch (const InputError& error) {
    for (const Diagnostic& d : error.diagnostics()) path->error(to_string(d));
  }
  return formulas;
}

}  // namespace mimbre::model_file
