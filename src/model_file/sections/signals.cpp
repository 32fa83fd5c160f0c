#include "model_file/sections/signals.h"

#include <fmt/format.h>

#include <algorithm>

#include "model_file/sections/blocks.h"
#include "model_file/text/scanning.h"

namespace mimbre::model_file {
namespace {

/// "a.b.c": letters, digits, '_' and dots between names.
std::size_t dotted_end(const std::string& text, std::size_t i) {
  std::size_t end = name_end(text, i);
  while (end + 1 < text.size() && text[end] == '.' && starts_name(text[end + 1]))
    end = name_end(text, end + 1);
  return end;
}

/// What a name stands for in a part.
std::optional<spec::Source> find_source(Builder& builder, const Part& part, const std::string& name) {
  using Kind = spec::Source::Kind;
  const std::vector<std::string> meanings = part.meanings(name);
  const auto in = [&](const Names& names, Kind kind) -> std::optional<spec::Source> {
    for (const std::string& full : meanings)
      if (const auto found = names.index.find(full); found != names.index.end())
        return spec::Source{kind, found->second};
    return {};
  };
  if (const auto source = in(builder.input_names, Kind::input)) return source;
  if (const auto source = in(builder.signal_names, Kind::signal)) return source;
  for (const std::string& full : meanings) {
    if (!builder.outputs_ahead.contains(full)) continue;
    const auto [place, first] = builder.sensor_of_output.emplace(full, std::ssize(builder.model.sensors));
    if (first) {
      builder.model.sensors.emplace_back();
      builder.model.sensors.back().name = full;
    }
    return spec::Source{Kind::sensor, place->second};
  }
  return {};
}

constexpr const char* no_word =
    "a name in expressions has letters from a to z and A to Z, digits and '_' only";

bool is_word(const std::string& name) {
  return !name.empty() && starts_name(name[0]) && name_end(name, 0) == name.size();
}

}  // namespace

SignalText replace_signals(Builder& builder, const Part& part, const std::string& text) {
  SignalText result;
  for (std::size_t i = 0; i < text.size();) {
    if (is_digit(text[i]) || text[i] == '.') {
      const std::size_t end = std::max(number_end(text, i), i + 1);
      result.text += text.substr(i, end - i);
      i = end;
      continue;
    }
    if (!starts_name(text[i])) {
      result.text += text[i++];
      continue;
    }
    const std::size_t end = dotted_end(text, i);
    const std::string name = text.substr(i, end - i);
    i = end;
    const std::size_t next = text.find_first_not_of(" \t\n", end);
    const bool called = next != std::string::npos && text[next] == '(';
    const ParameterValue* parameter = part.reading.scope->find(name);
    std::optional<spec::Source> source;
    if (!called && !is_variable_name(name)) {
      source = find_source(builder, part, name);
      // A parameter was there before outputs could be named; one that is tunable is an input. A choice of a
      // template's parameter is nearer than what stands outside of it.
      if (source && parameter && source->kind == spec::Source::Kind::sensor) source.reset();
      if (part.reading.scope->chooser_of(name)) source.reset();
    }
    if (!source) {
      result.text += name;
      continue;
    }
    const auto same = std::find_if(result.sources.begin(), result.sources.end(), [&](const spec::Source& s) {
      return s.kind == source->kind && s.index == source->index;
    });
    const auto k = same - result.sources.begin();
    if (same == result.sources.end()) {
      const std::string variable = fmt::format("signal_{}_", k);
      result.sources.push_back(*source);
      result.variables.push_back({variable, {name, variable}, quantity::any});
    }
    result.text += result.variables[static_cast<std::size_t>(k)].name;
  }
  return result;
}

bool uses_signals(Builder& builder, const Part& part, const Value& value) {
  if (!value.is_scalar()) return false;
  if (builder.input_names.index.empty() && builder.signal_names.index.empty() &&
      builder.outputs_ahead.empty())
    return false;
  return replace_signals(builder, part, value.tree().text).any();
}

std::optional<spec::Law> read_formula(Builder& builder, const Part& part,
                                      const std::vector<FormulaTerm>& terms,
                                      const std::vector<std::string>& own, const Quantity& wanted) {
  std::string sum;
  std::vector<std::string> names = own;
  spec::Law law;
  for (const auto& [value, variables, factor, of] : terms) {
    if (!value.is_scalar()) {
      value.error("an expression is needed");
      return {};
    }
    const auto written = value.text();
    if (!written) return {};
    SignalText replaced = replace_signals(builder, part, *written);
    // Of all terms together each signal has one variable.
    std::vector<Variable> all = variables;
    for (std::size_t k = 0; k < replaced.sources.size(); ++k) {
      const spec::Source& source = replaced.sources[k];
      const auto same = std::find_if(law.arguments.begin(), law.arguments.end(), [&](const spec::Source& s) {
        return s.kind == source.kind && s.index == source.index;
      });
      const auto at = static_cast<std::size_t>(same - law.arguments.begin());
      if (same == law.arguments.end()) {
        law.arguments.push_back(source);
        names.push_back(fmt::format("argument_{}_", at));
      }
      Variable variable = replaced.variables[k];
      variable.name = fmt::format("argument_{}_", at);
      all.push_back(std::move(variable));
    }
    try {
      const std::string text =
          substitute_parameters(replaced.text, *part.reading.scope, all, of.value_or(wanted));
      const std::string times = factor == 1 ? "" : fmt::format("({:.17g})*", factor);
      sum += fmt::format("{}{}({})", sum.empty() ? "" : " + ", times, text);
    } catch (const ExpressionError& e) {
      value.error(e.what());
      return {};
    }
  }
  try {
    law.formula = Formula::expression(sum, names);
  } catch (const InputError& e) {
    terms.front().value.error(e.diagnostics().front().message);
    return {};
  }
  return law;
}

bool add_term_with_signals(Builder& builder, const Part& part, const Value& law, LawOf of, const char* as,
                           std::vector<FormulaTerm>& terms) {
  if (!uses_signals(builder, part, law)) return false;
  std::vector<Variable> variables = variables_of(of);
  variables.front().name = as;
  terms.emplace_back(law, std::move(variables));
  return true;
}

int anonymous_signal(Builder& builder, const Part& part, const Value& value, const std::string& name,
                     const Quantity& wanted) {
  const std::vector<Variable> time = variables_of(LawOf::time);
  std::vector<Variable> own = time;
  own.front().name = "t";
  auto law = read_formula(builder, part, {{value, own}}, {"t"}, wanted);
  if (!law) return -1;
  spec::Signal signal;
  signal.name = name;
  signal.mark = value.mark();
  signal.unit = std::string(wanted.unit);
  signal.named = false;
  law->arguments.insert(law->arguments.begin(), spec::Source{});  // time
  signal.law = std::move(*law);
  builder.model.signals.push_back(std::move(signal));
  return static_cast<int>(builder.model.signals.size()) - 1;
}

void read_inputs(Builder& builder, Part& part) {
  for (const auto& [name, parameter] : part.scope.tunables) {
    spec::Input input;
    input.name = part.full_name(name);
    input.mark = parameter.mark;
    input.start = parameter.start;
    input.min = parameter.min;
    input.max = parameter.max;
    input.tunable = true;
    if (!builder.claim(builder.input_names, part, input.name, input.mark,
                       static_cast<int>(builder.model.inputs.size())))
      continue;
    builder.model.inputs.push_back(std::move(input));
  }
  const auto section = part.section("inputs");
  if (!section) return;
  if (!section->is_map())
    return section->error(
        "names with their descriptions are needed, for example throttle: {start: 0, range: [0, 1]}");
  for (const auto& entry : section->tree().entries) {
    spec::Input input;
    input.name = part.full_name(entry.key);
    input.mark = entry.mark;
    if (!claim_variable(builder, builder.input_names, part, input.name, entry.key, entry.mark,
                        static_cast<int>(builder.model.inputs.size())))
      continue;
    const Value value(part.reading, *entry.value, fmt::format("input '{}'", input.name));
    if (value.is_scalar()) {
      input.start = value.number(quantity::any).value_or(0);
    } else {
      const Fields fields(value, {"unit", "start", "range", "hold", "about"});
      if (const auto unit = fields.get("unit")) input.unit = unit->text().value_or("");
      input.start = fields.number("start", 0, quantity::any);
      if (const auto range = fields.get("range"))
        if (const auto bounds = range->numbers(2, 2, quantity::any)) {
          input.min = (*bounds)[0];
          input.max = (*bounds)[1];
          if (!(input.min < input.max)) range->error("the range is [smallest, largest]");
          if (input.start < input.min || input.start > input.max)
            range->error(fmt::format("the start value {} is outside of the range", input.start));
        }
      if (const auto hold = fields.get("hold"))
        input.hold = hold->choice({"constant", "linear"}).value_or(0) == 1 ? spec::Input::Hold::linear
                                                                           : spec::Input::Hold::constant;
    }
    builder.model.inputs.push_back(std::move(input));
  }
}

bool claim_variable(Builder& builder, Names& names, const Part& part, const std::string& full_name,
                    const std::string& name, const Mark& mark, int index) {
  std::string why;
  if (!is_word(name))
    why = no_word;
  else if (is_variable_name(name) || is_function_name(name) || name == "pi" || name == "true" ||
           name == "false")
    why = "the name is taken by expressions; choose another";
  else if (part.reading.scope->find(name))
    why = "there is a parameter of that name; choose another";
  else if (const std::string* parameter = part.reading.scope->chooser_of(name))
    why = fmt::format(
        "'{0}' is a choice of parameter '{1}', and `{1} == {0}` has to mean that one; choose another", name,
        *parameter);
  for (const Names* other : {&builder.input_names, &builder.signal_names})
    if (why.empty() && other != &names && other->index.contains(full_name))
      why = fmt::format("there is an {} of that name; choose another", other->kind);
  if (!why.empty()) {
    builder.errors.add(mark, fmt::format("{} '{}': {}", names.kind, name, why));
    return false;
  }
  return builder.claim(names, part, full_name, mark, index);
}

void claim_signals(Builder& builder, Part& part) {
  const auto section = part.section("signals");
  if (!section) return;
  if (!section->is_map())
    return section->error("names with expressions are needed, for example torque: \"-100*angle\"");
  const auto claim = [&](const std::string& name, const std::string& word, const Mark& mark) {
    spec::Signal signal;
    signal.name = part.full_name(name);
    signal.mark = mark;
    if (claim_variable(builder, builder.signal_names, part, signal.name, word, mark,
                       static_cast<int>(builder.model.signals.size())))
      builder.model.signals.push_back(std::move(signal));
  };
  // Formulas call it BLOCK.OUTPUT, so that x and sin are names, too.
  const auto claim_output = [&](const std::string& name, const std::string& word, const Mark& mark) {
    const std::string full = part.full_name(name);
    if (!is_word(word)) return builder.errors.add(mark, fmt::format("signal '{}': {}", full, no_word));
    if (builder.input_names.index.contains(full))
      return builder.errors.add(mark, fmt::format("signal '{}': there is an {} of that name; choose another",
                                                  full, builder.input_names.kind));
    spec::Signal signal;
    signal.name = full;
    signal.mark = mark;
    if (builder.claim(builder.signal_names, part, full, mark, static_cast<int>(builder.model.signals.size())))
      builder.model.signals.push_back(std::move(signal));
  };
  for (const auto& entry : section->tree().entries) {
    const std::vector<std::string> outputs = output_names(*entry.value);
    if (outputs.empty()) claim(entry.key, entry.key, entry.mark);
    for (const std::string& output : outputs) claim_output(entry.key + "." + output, output, entry.mark);
  }
}

void claim_outputs(Builder& builder, Part& part) {
  const auto section = part.section("outputs");
  if (!section || !section->is_list()) return;
  for (const auto& item : section->tree().items)
    if (item->kind == Tree::Kind::map)
      if (const Tree::Entry* name = item->find("name"))
        builder.outputs_ahead.insert(instance_name(name->value->text, part.instance));
}

void read_signals(Builder& builder, Part& part) {
  const auto section = part.section("signals");
  if (!section || !section->is_map()) return;
  for (const auto& entry : section->tree().entries) {
    const auto signal_of = [&](const std::string& name) {
      const auto found = builder.signal_names.index.find(part.full_name(name));
      return found == builder.signal_names.index.end()
                 ? std::nullopt
                 : std::optional(static_cast<std::size_t>(found->second));
    };
    if (const int type = block_of(*entry.value); type >= 0) {
      std::vector<std::string> names = output_names(*entry.value);
      for (std::string& name : names) name = entry.key + "." + name;
      if (names.empty()) names.push_back(entry.key);
      std::vector<std::size_t> signals;
      for (const std::string& name : names)
        if (const auto at = signal_of(name)) signals.push_back(*at);
      const std::string name = part.full_name(entry.key);
      const Value value(part.reading, *entry.value, fmt::format("signal '{}'", name));
      if (const Tree::Entry* unit = entry.value->find("unit"))
        for (const std::size_t k : signals) builder.model.signals[k].unit = unit->value->text;
      if (signals.size() == names.size()) read_block(builder, part, value, name, type, signals);
      continue;
    }
    const auto found = signal_of(entry.key);
    if (!found) continue;
    const std::size_t at = *found;
    const Value value(part.reading, *entry.value, fmt::format("signal '{}'", builder.model.signals[at].name));
    const std::vector<Variable> time = variables_of(LawOf::time);
    const auto formula = [&](const Value& text) {
      auto law = read_formula(builder, part, {{text, time}}, {"t"}, quantity::any);
      if (!law) return;
      law->arguments.insert(law->arguments.begin(), spec::Source{});
      builder.model.signals[at].law = std::move(*law);
    };
    if (value.is_scalar()) {
      formula(value);
      continue;
    }
    if (!value.is_map()) {
      value.error(
          "an expression is needed, or {value: ..., every: 0.01}, or what an output would be: {joint: "
          "hinge}");
      continue;
    }
    spec::Signal& signal = builder.model.signals[at];
    const Tree& tree = value.tree();
    if (const Tree::Entry* unit = tree.find("unit")) signal.unit = unit->value->text;
    if (const Tree::Entry* every = tree.find("every"))
      signal.every =
          Value(part.reading, *every->value, value.what() + ": every").positive(quantity::time).value_or(0);
    if (const Tree::Entry* text = tree.find("value")) {
      const Fields known(value, {"value", "unit", "every", "about"});
      formula(Value(part.reading, *text->value, value.what()));
      continue;
    }
    spec::Output sensor;
    sensor.name = signal.name;
    sensor.mark = signal.mark;
    if (!read_sensor(builder, part, value, sensor)) continue;
    const int index = static_cast<int>(builder.model.sensors.size());
    builder.model.sensors.push_back(std::move(sensor));
    builder.model.signals[at].law = {Formula::expression("s", {"s"}), {{spec::Source::Kind::sensor, index}}};
  }
}

void resolve_sensors(Builder& builder) {
  for (const auto& [name, sensor] : builder.sensor_of_output) {
    const auto found = builder.output_names.index.find(name);
    if (found == builder.output_names.index.end()) continue;  // its description is wrong, which is reported
    builder.model.sensors[static_cast<std::size_t>(sensor)] =
        builder.model.outputs[static_cast<std::size_t>(found->second)];
  }
}

}  // namespace mimbre::model_file
