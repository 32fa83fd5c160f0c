#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <type_traits>

#include "mimbre/run_option.h"
#include "model_file/text/builder.h"

/// `simulation` and `initial`.
namespace mimbre::model_file {
namespace {

std::optional<double> read_number(const Value& value, const RunOption& option) {
  const Quantity& of = option.unit == "s" ? quantity::time : quantity::number;
  const auto number = option.above == 0 ? value.positive(of) : value.number(of);
  if (!number || option.allows(*number)) return number;
  value.error(fmt::format("{} is not {}", *number, allowed_numbers(option)));
  return {};
}

template <class Type>
std::optional<Type> read_value(const Value& value, const RunOption& option) {
  if constexpr (std::is_same_v<Type, double>) {
    return read_number(value, option);
  } else if constexpr (std::is_same_v<Type, int>) {
    return value.integer(static_cast<int>(option.least), static_cast<int>(option.most));
  } else if constexpr (std::is_same_v<Type, bool>) {
    return value.flag();
  } else {
    const auto index = value.choice({option.words.begin(), option.words.end()});
    return index ? std::optional(static_cast<Type>(*index)) : std::nullopt;
  }
}

void read_option(const Fields& fields, const RunOption& option, spec::Simulation& simulation,
                 RunOptions& asked) {
  const auto value = fields.get(std::string(option.key_in_file()));
  if (!value) return;
  std::visit(
      [&](const auto& m) {
        const auto read = read_value<typename std::decay_t<decltype(m)>::type>(*value, option);
        if (!read) return;
        simulation.*m.in_model = *read;
        if (m.asked) asked.*m.asked = *read;
      },
      option.member);
}

/// The keys of a map: of `simulation` itself, or of one that it has, like that of the integrator.
std::vector<std::string> keys_of_section(std::string_view section) {
  std::vector<std::string> keys;
  for (const RunOption& option : run_option_table()) {
    const std::string_view key = option.section == section ? option.key_in_file()
                                 : section.empty()         ? option.section
                                                           : std::string_view();
    if (!key.empty() && std::find(keys.begin(), keys.end(), key) == keys.end()) keys.emplace_back(key);
  }
  return keys;
}

/// The map of `simulation` that has the option: itself, or one in it, like that of the integrator.
std::optional<Fields> fields_of(const Fields& all, const RunOption& option,
                                std::map<std::string, Fields>& sections) {
  if (option.section.empty()) return all;
  const auto found = sections.find(std::string(option.section));
  return found == sections.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace

void read_simulation(Builder& builder, Part& part) {
  spec::Simulation& simulation = builder.model.simulation;
  if (const auto initial = part.section("initial"))
    simulation.start_at_equilibrium = initial->choice({"assembled", "equilibrium"}).value_or(0) == 1;
  const auto section = part.section("simulation");
  if (!section) return;
  const Fields fields(*section, keys_of_section({}));
  std::map<std::string, Fields> sections;
  for (const RunOption& option : run_option_table()) {
    const std::string name(option.section);
    if (name.empty() || sections.contains(name)) continue;
    if (const auto value = fields.get(name)) sections.emplace(name, Fields(*value, keys_of_section(name)));
  }
  RunOptions asked;
  for (const RunOption& option : run_option_table())
    if (const auto held = fields_of(fields, option, sections)) read_option(*held, option, simulation, asked);
  simulation.end_given = asked.end.has_value();
  const auto integrator = sections.find("integrator");
  if (integrator != sections.end() && !asked.integrator)
    integrator->second.need("type", "generalized_alpha");
  else if (const auto conflict = find_conflict({}, asked, OptionNames::keys)) {
    const RunOption& option = *find_run_option(conflict->key);
    const auto held = fields_of(fields, option, sections);
    const auto value = held ? held->get(std::string(option.key_in_file())) : std::nullopt;
    (value ? *value : *section).error(conflict->message);
  }
  if (simulation.step > simulation.end)
    fields.error(fmt::format("step {} is longer than end {}", simulation.step, simulation.end));
  const double steps = simulation.output_interval / simulation.step;
  if (simulation.output_interval > 0 && (steps < 0.5 || std::abs(steps - std::round(steps)) > 1e-6 * steps))
    fields.get("output_interval")
        ->error(fmt::format("{} is not a whole number of steps of {}", simulation.output_interval,
                            simulation.step));
}

}  // namespace mimbre::model_file
