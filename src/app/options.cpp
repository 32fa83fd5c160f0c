#include "app/options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "app/common.h"
#include "mimbre/diagnostics.h"

namespace mimbre::app {
namespace {

/// A finite number from `low` (or, when `open`, more than it) to `high`.
CLI::Validator finite(double low, double high, bool open) {
  const auto check = [=](const std::string& text) -> std::string {
    double number = 0;
    if (!CLI::detail::lexical_cast(text, number)) return fmt::format("'{}' is not a number", text);
    if (std::isfinite(number) && (open ? number > low : number >= low) && number <= high) return {};
    const std::string least =
        std::isfinite(low) ? fmt::format(" {} {}", open ? "above" : "of at least", low) : "";
    const std::string most = std::isfinite(high) ? fmt::format(" of at most {}", high) : "";
    return fmt::format("{} is not a number{}{}{}", text, least, least.empty() || most.empty() ? "" : " and",
                       most);
  };
  return CLI::Validator(check, "");
}

}  // namespace

Option Option::required() { return Option(option_->required()); }
Option Option::type_name(const std::string& name) { return Option(option_->type_name(name)); }
Option Option::group(const std::string& title) { return Option(option_->group(title)); }
Option Option::show_default() { return Option(option_->capture_default_str()); }
Option Option::excludes(const Option& other) { return Option(option_->excludes(other.option_)); }
Option Option::repeated() { return Option(option_->allow_extra_args(false)); }
Option Option::take_all() { return Option(option_->take_all()); }

Option Option::choice(const std::vector<std::string>& words) {
  return Option(option_->check(CLI::IsMember(words)));
}
Option Option::one_of(const std::vector<std::string>& words) {
  const auto check = [words](const std::string& text) -> std::string {
    if (std::find(words.begin(), words.end(), text) != words.end()) return {};
    return fmt::format("'{}' is not one of {}{}", text, fmt::join(words, ", "), did_you_mean(text, words));
  };
  return Option(option_->check(CLI::Validator(check, "")));
}
Option Option::within(int low, int high) { return Option(option_->check(CLI::Range(low, high))); }
Option Option::within(double low, double high) { return Option(option_->check(CLI::Range(low, high))); }
Option Option::positive() { return Option(option_->check(CLI::PositiveNumber)); }
Option Option::not_negative() { return Option(option_->check(CLI::NonNegativeNumber)); }
Option Option::from(double low, double high) { return Option(option_->check(finite(low, high, false))); }
Option Option::above(double low, double high) { return Option(option_->check(finite(low, high, true))); }

Option Parser::add_option(const std::string& names, std::string& value, const std::string& help) {
  return Option(app_->add_option(names, value, help));
}
Option Parser::add_option(const std::string& names, int& value, const std::string& help) {
  return Option(app_->add_option(names, value, help));
}
Option Parser::add_option(const std::string& names, double& value, const std::string& help) {
  return Option(app_->add_option(names, value, help));
}
Option Parser::add_option(const std::string& names, std::optional<double>& value, const std::string& help) {
  return Option(app_->add_option(names, value, help));
}
Option Parser::add_option(const std::string& names, std::optional<int>& value, const std::string& help) {
  return Option(app_->add_option(names, value, help));
}
Option Parser::add_option(const std::string& names, std::vector<std::string>& values,
                          const std::string& help) {
  return Option(app_->add_option(names, values, help));
}
Option Parser::add_choice(const std::string& names, const std::vector<std::string>& words,
                          const std::function<void(int)>& chosen, const std::string& help) {
  const auto choose = [words, chosen](const std::string& word) {
    chosen(static_cast<int>(std::find(words.begin(), words.end(), word) - words.begin()));
  };
  return Option(app_->add_option_function<std::string>(names, choose, help)).one_of(words);
}
Option Parser::add_flag(const std::string& names, bool& value, const std::string& help) {
  return Option(app_->add_flag(names, value, help));
}
Option Parser::add_flag(const std::string& names, std::optional<bool>& value, bool then,
                        const std::string& help) {
  return Option(app_->add_flag_callback(
      names, [&value, then] { value = then; }, help));
}

void Parser::footer(const std::string& text) { app_->footer(text); }
std::string Parser::name() const { return app_->get_name(); }
bool Parser::chosen() const { return app_->parsed(); }

bool Parser::has(const std::string& option) const {
  const CLI::Option* const found = app_->get_option_no_throw(option);
  return found && found->count() > 0;
}

std::vector<GivenOption> Parser::given() const {
  std::vector<GivenOption> options;
  for (const CLI::Option* option : app_->get_options())
    if (option->count() > 0) options.push_back({option->get_name(), option->results()});
  return options;
}

CommandLine::CommandLine(const std::string& name, const std::string& about, const std::string& own_version)
    : Parser(nullptr), owned_(std::make_unique<CLI::App>(about, name)) {
  app_ = owned_.get();
  app_->set_version_flag("--version", own_version);
  app_->require_subcommand(1);
}

CommandLine::~CommandLine() = default;

Parser CommandLine::add_command(const std::string& name, const std::string& about) {
  return Parser(app_->add_subcommand(name, about));
}

std::string CommandLine::help() const { return app_->help(); }

std::optional<int> CommandLine::parse(int argc, const char* const* argv) try {
  app_->parse(argc, argv);
  return {};
} catch (const CLI::Success& asked) {  // help or version
  std::ostringstream answer;
  const int code = app_->exit(asked, answer, answer);
  print_data(answer.str());
  return code;
} catch (const CLI::ExtrasError& error) {
  throw UnexpectedArgument(error.what() + hint());
} catch (const CLI::RequiredError& error) {
  throw UsageError(missing().value_or(error.what()));
} catch (const CLI::ParseError& error) {
  throw UsageError(error.what());
}

std::optional<std::string> CommandLine::missing() const {
  for (CLI::App* command : app_->get_subcommands())
    for (const CLI::Option* option : command->get_options())
      if (option->get_required() && option->count() == 0)
        return fmt::format("{} is missing: {}",
                           option->get_positional() ? option->get_type_name() : option->get_name(),
                           option->get_description());
  return {};
}

std::string CommandLine::hint() const {
  for (CLI::App* command : app_->get_subcommands()) {
    std::vector<std::string> names;
    for (const CLI::Option* option : command->get_options())
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& rest : command->remaining())
      if (rest.starts_with("--")) return did_you_mean(rest.substr(0, rest.find('=')), names);
  }
  return {};
}

}  // namespace mimbre::app
