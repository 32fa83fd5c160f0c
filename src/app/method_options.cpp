#include "app/method_options.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "mimbre/method_names.h"
#include "mimbre/run_option.h"
#include "mimbre/run_summary.h"

namespace mimbre::app {
namespace {

std::string long_name(const RunOption& option) { return name_of(option, OptionNames::command_line); }

void add(Parser& command, const RunOption& option, std::optional<double>& value) {
  const Option added = command.add_option(long_name(option), value, std::string(option.help));
  const bool open = std::isfinite(option.above);
  (open ? Option(added).above(option.above, option.most) : Option(added).from(option.least, option.most))
      .type_name(std::string(option.value))
      .group("Method");
}

void add(Parser& command, const RunOption& option, std::optional<int>& value) {
  command.add_option(long_name(option), value, std::string(option.help))
      .within(static_cast<int>(option.least), static_cast<int>(option.most))
      .type_name(std::string(option.value))
      .group("Method");
}

void add(Parser& command, const RunOption& option, std::optional<bool>& value) {
  const Option yes =
      command.add_flag(long_name(option), value, true, std::string(option.help)).group("Method");
  command.add_flag(fmt::format("--no-{}", option.option), value, false, std::string(option.help_not))
      .excludes(yes)
      .group("Method");
}

template <class Enumeration>
void add(Parser& command, const RunOption& option, std::optional<Enumeration>& value) {
  const std::vector<std::string> words(option.words.begin(), option.words.end());
  const auto chosen = [&value](int index) { value = static_cast<Enumeration>(index); };
  command.add_choice(long_name(option), words, chosen, std::string(option.help))
      .type_name(std::string(option.value))
      .group("Method");
}

}  // namespace

void add_method_options(Parser& command, RunOptions& asked, MethodChoice choice) {
  for (const RunOption& option : run_option_table())
    if (!option.option.empty() && option.key != choice.without && (choice.steps || !option.of_steps))
      std::visit([&](const auto& m) { add(command, option, asked.*m.asked); }, option.member);
}

std::string method_line(const Method& method) {
  if (!is_runge_kutta(method.integrator))
    return fmt::format("{}, {}, {}", name_of(method.formulation), name_of(method.formalism),
                       name_of(method.integrator));
  const std::string accuracy = method.accuracy > 0 ? fmt::format(", accuracy {:g}", method.accuracy) : "";
  return fmt::format("{}, {}{}", name_of(method.formulation), name_of(method.integrator), accuracy);
}

std::vector<std::string> method_words(const RunOptions& asked) {
  std::vector<std::string> words;
  for (const RunOption& option : run_option_table()) {
    const auto value = value_in(option, asked);
    if (!value || option.option.empty()) continue;
    const bool flag = std::holds_alternative<OptionMember<bool>>(option.member);
    words.push_back(flag && *value == 0 ? fmt::format("--no-{}", option.option) : long_name(option));
    if (!flag) words.push_back(shown_value(option, *value));
  }
  return words;
}

Json arguments_json(const RunOptions& asked) { return Json::parse(arguments_summary(asked)); }

Json method_json(const Method& method) { return Json::parse(method_summary(method)); }

Json resolved_json(const Method& method) { return Json::parse(resolved_summary(method)); }

}  // namespace mimbre::app
