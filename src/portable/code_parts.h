#pragma once
#include <memory>
#include <string>
#include <vector>

#include "dynamics/state.h"
#include "mimbre/generate.h"
#include "portable/record.h"

/// Parts that both kinds of code have, of steps and of derivatives.
namespace mimbre::portable {

/// The same with letters, digits and _ alone.
std::string identifier(const std::string& text);
/// Throws InputError where it is no identifier of C.
void check_identifier(const std::string& name);
/// The same where it cannot be that of a type beside what C's library declares.
void check_type_name(const std::string& name);
std::string upper_case(std::string name);
/// A comment's text, which cannot end it.
std::string comment(std::string text);

/// Inputs and outputs, with their numbers' names. `start`: the state that inputs start from.
void name_variables(const Compiled& m, const State& start, const RecordedModel& recorded, GeneratedCode& out);
/// The part of a header that has these names.
std::string variable_names(const GeneratedCode& code);
/// The same as lists for programs that need them when they run.
std::string variable_lists(const GeneratedCode& code);
/// The table of where inputs are held, and their ranges.
std::string held_inputs(const Compiled& m, const GeneratedCode& code);

/// As generate_code. `varies`: also how outputs vary with inputs and the time while the motion does not,
/// where that is known (GeneratedCode::varies).
GeneratedCode generate_steps(const std::shared_ptr<const Model>& model, const RunOptions& options,
                             const std::string& name, bool varies);

/// The members of a struct, and their numbers.
struct StructText {
  std::string text;
  long doubles = 0, ints = 0;
  void add(const std::string& member, long count, const std::string& about = "");
  void add_ints(const std::string& member, long count);
};

}  // namespace mimbre::portable
