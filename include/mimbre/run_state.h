#pragma once
#include <cstdint>
#include <string>

#include "mimbre/run.h"

/// What a run needs to go on from where it was, in one file (docs/states.md).
namespace mimbre {

/// How many rows a run has recorded, and a number that identifies them.
struct RecordedRows {
  std::int64_t count = 0;
  std::uint64_t hash = 0;
  void add(const ResultsRow& row);
  bool operator==(const RecordedRows&) const = default;
};

struct RunState {
  Simulation::Snapshot snapshot;
  RunTotals totals;
  RecordedRows rows;
  std::int64_t recorded = 0;  ///< the step of the last row
  std::string options_json;   ///< of the command line
  std::string program;        ///< that wrote it: version, compiler, instructions
  std::string results, csv;   ///< files in which the rows are found; empty: there is none
};

/// The program that is running, as RunState::program.
std::string this_program();

/// The name that a file of RunState gets when its run comes to its end: `run.part-PID.h5`, which grows beside
/// an older `run.h5`, becomes `run.h5`. Empty: it has that name already.
std::string file_when_whole(const std::string& file);

/// Writes the file anew; an older one stands until the new one is whole. Throws std::runtime_error with the
/// reason.
void write_run_state(const std::string& path, const RunState& state);
/// Throws InputError that names the file: missing, of another kind or version, damaged.
RunState read_run_state(const std::string& path);

}  // namespace mimbre
