#pragma once
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mimbre/usage_error.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

/// The command line: a thin front of CLI11, whose headers take a compiler seconds and are known to
/// options.cpp alone. A command adds an option in one statement:
///
///     parser.add_option("--until", until, "End in s").above(0).type_name("T");
namespace mimbre::app {

/// A word on the command line that nothing takes.
struct UnexpectedArgument : UsageError {
  using UsageError::UsageError;
};

/// A handle of an option, for its further properties.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option required();
  /// What stands for the value in the help, as FILE in "--output FILE".
  Option type_name(const std::string& name);
  /// The heading under which the help lists it.
  Option group(const std::string& title);
  /// The help shows the value that the variable has now.
  Option show_default();
  /// Not together with the other.
  Option excludes(const Option& other);

  // An option with a list of values takes all words up to the next option.
  /// Only one word each time, and it may be given several times.
  Option repeated();
  /// It may be given several times, and all words count.
  Option take_all();

  // What values there are. The help shows those of choice, within, positive and not_negative.
  Option choice(const std::vector<std::string>& words);
  /// Likewise one of these words, but a wrong one is answered with a near one.
  Option one_of(const std::vector<std::string>& words);
  Option within(int low, int high);
  Option within(double low, double high);
  Option positive();
  Option not_negative();
  /// A finite number from `low` to `high`.
  Option from(double low, double high = std::numeric_limits<double>::infinity());
  /// A finite number larger than `low`, up to `high`.
  Option above(double low, double high = std::numeric_limits<double>::infinity());

 private:
  CLI::Option* option_;
};

/// An option that was given, by its long name, and what followed it.
struct GivenOption {
  std::string name;
  std::vector<std::string> values;
};

/// A handle of a command, to define its options and to ask which were given. The variables of the
/// options must live until the command line is parsed, and keep their values where nothing is given.
class Parser {
 public:
  explicit Parser(CLI::App* app) : app_(app) {}

  /// `names`: "--step", "-o,--output", or "model" for a word without a name in front.
  Option add_option(const std::string& names, std::string& value, const std::string& help);
  Option add_option(const std::string& names, int& value, const std::string& help);
  Option add_option(const std::string& names, double& value, const std::string& help);
  Option add_option(const std::string& names, std::optional<double>& value, const std::string& help);
  Option add_option(const std::string& names, std::optional<int>& value, const std::string& help);
  Option add_option(const std::string& names, std::vector<std::string>& values, const std::string& help);
  /// One of these words: `chosen` gets its place among them.
  Option add_choice(const std::string& names, const std::vector<std::string>& words,
                    const std::function<void(int)>& chosen, const std::string& help);
  Option add_flag(const std::string& names, bool& value, const std::string& help);
  /// Where it is given, the value becomes `then`.
  Option add_flag(const std::string& names, std::optional<bool>& value, bool then, const std::string& help);
  /// The end of the help.
  void footer(const std::string& text);

  std::string name() const;
  /// Whether the command line names this command.
  bool chosen() const;
  /// Whether the command has this option and it was given.
  bool has(const std::string& option) const;
  /// All that were given, in the order in which they were added.
  std::vector<GivenOption> given() const;

 protected:
  CLI::App* app_;
};

/// The whole command line: a command and its options.
class CommandLine : public Parser {
 public:
  /// `version`: the answer to --version.
  CommandLine(const std::string& name, const std::string& about, const std::string& version);
  ~CommandLine();

  Parser add_command(const std::string& name, const std::string& about);
  std::string help() const;
  /// Reads the arguments. An exit code when help or the version was asked for, and printed; nothing when a
  /// command is to run. Throws UsageError, and Failure where the answer cannot be printed.
  std::optional<int> parse(int argc, const char* const* argv);

 private:
  /// What the first option is that the command needs and was not given.
  std::optional<std::string> missing() const;
  /// A near name for the first option that the command does not have.
  std::string hint() const;

  std::unique_ptr<CLI::App> owned_;
};

}  // namespace mimbre::app
