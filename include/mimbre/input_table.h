#pragma once
#include <string>
#include <vector>

#include "mimbre/spec.h"

namespace mimbre {

/// Values of an input over time, as a run plays them: at least one, times (s) increase, all numbers are
/// finite.
struct RecordedInput {
  int input = -1;  ///< index into the model's inputs
  std::vector<double> times, values;
};

/// Reads recorded inputs from a table of cells between commas, semicolons or tabs (docs/model-file.md,
/// "Recorded inputs"). Its header names the columns: `t` or `time`, and inputs, with units in brackets or in
/// a second line. Without a header the columns are t and the value. `name`: the input that the table is of,
/// whose column may be called `value`, too; other columns are not read. Empty: all columns, each of which is
/// an input, which messages call `columns`. Throws UnknownName where the model has no such input, and
/// InputError, with file and line, for everything else that is no such table.
std::vector<RecordedInput> read_input_table(const std::string& path, const std::vector<spec::Input>& inputs,
                                            const std::string& name = {},
                                            const std::string& columns = "an input or tunable parameter");

}  // namespace mimbre
