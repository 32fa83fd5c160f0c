#pragma once
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "mimbre/method.h"

/// The table of the options of a run. The reader of model files, the checks, the command line, Python,
/// results and the fingerprint of saved states loop over it and know no option by name; a test compares it
/// with the schemas.
namespace mimbre {

/// Where the value of an option is: in the model, and in what a caller asks for.
template <class Value>
struct OptionMember {
  using type = Value;
  Value spec::Simulation::*in_model;
  std::optional<Value> RunOptions::*asked = nullptr;  ///< null: of the model file alone
};

struct RunOption {
  static constexpr double none = std::numeric_limits<double>::infinity();
  using Simulation = spec::Simulation;
  using Member = std::variant<OptionMember<double>, OptionMember<int>, OptionMember<bool>,
                              OptionMember<Simulation::Formulation>, OptionMember<Simulation::Inertia>,
                              OptionMember<Simulation::Formalism>, OptionMember<Simulation::Integrator>>;

  std::string_view key;  ///< in model files, Python and results
  Member member;
  std::string_view about;  ///< for the schema and Python

  // Numbers. The model's default, or a value that means the library's, may be out of the range.
  std::string_view unit = {};                                   ///< "s", or none
  double above = -none;                                         ///< it is more than this,
  double least = -none, most = none;                            ///< and may be these
  double otherwise = std::numeric_limits<double>::quiet_NaN();  ///< the default; NaN: resolve_method decides
  // Enumerations: the words, in their order.
  std::span<const char* const> words = {};

  // The command line and Python; without a name here neither has it.
  std::string_view option = {};  ///< "max-iterations"
  std::string_view value = {};   ///< what stands for the value in the help
  std::string_view help = {};
  std::string_view help_not = {};  ///< of a flag: --no-option
  bool of_steps = true;            ///< a state of rest does not need it

  // In the model file.
  std::string_view section = {};   ///< the key of the map within `simulation` that has it
  std::string_view file_key = {};  ///< its key there, if not `key`

  /// Integrators that have it; none: it does not depend on them.
  std::span<const Simulation::Integrator> of = {};
  /// Where no integrator is asked for, the first of `of` takes the place of these.
  std::span<const Simulation::Integrator> replaces = {};
  bool in_headline = false;    ///< belongs to the short description of the method
  bool changes_states = true;  ///< a saved state is only continued with the same

  bool allows(double x) const;
  bool belongs_to(Simulation::Integrator integrator) const;
  std::string_view key_in_file() const { return file_key.empty() ? key : file_key; }
};

std::span<const RunOption> run_option_table();
/// Null: there is none of that name that may be asked for.
const RunOption* find_run_option(std::string_view key);

/// What numbers it takes: "a whole number from 1 to 100".
std::string allowed_numbers(const RunOption& option);
// Its value; words are counted from 0, a flag is 0 or 1.
double value_in(const RunOption& option, const spec::Simulation& simulation);
std::optional<double> value_in(const RunOption& option, const RunOptions& asked);
/// Whether the model has another value than `Simulation` starts with.
bool is_given(const RunOption& option, const spec::Simulation& simulation);
/// What is wrong with such a value, whatever the other options are: "is 2; it must be a number from 0 to 1".
/// Empty: nothing.
std::string wrong_value(const RunOption& option, double value);
/// The same as text; a word as it is.
std::string shown_value(const RunOption& option, double value);

/// How messages call options: by their keys, or "--max-iterations".
enum class OptionNames { keys, command_line };
std::string name_of(const RunOption& option, OptionNames names);

struct OptionConflict {
  std::string_view key;  ///< of the option that does not fit
  std::string message;
};
/// Where options that are asked for do not go together, or not with what the model has.
std::optional<OptionConflict> find_conflict(const spec::Simulation& given, const RunOptions& asked,
                                            OptionNames names);

/// The integrator that is asked for: by its name, or by an option that only fits another one than the
/// model's.
spec::Simulation::Integrator integrator_in_force(const spec::Simulation& given, const RunOptions& asked);

}  // namespace mimbre
