#pragma once
#include <memory>
#include <string>
#include <vector>

#include "mimbre/results.h"
#include "mimbre/run_state.h"

namespace mimbre::app {

/// The files that a run writes its rows to; empty: none.
struct RunFiles {
  std::string results, csv;
  bool csv_units = false;
};

/// The rows that a run recorded before it was saved, from where they are found now: the file that grew then,
/// or the one that it became. `outputs`: how many a table has. Throws InputError where they are not.
std::vector<ResultsRow> recorded_rows(const RunState& saved, const RunFiles& files, int outputs);

/// Puts a simulation's rows into the files that were asked for.
class Recorder {
 public:
  Recorder(const RunFiles& files, const Simulation& simulation, const std::string& options_json);

  bool recording() const { return results_ || csv_; }
  void record(Simulation& simulation);
  /// Begins with the rows of a saved run.
  void take_over(const RunState& saved, const std::vector<ResultsRow>& rows);

  /// Writes what has been waiting for long.
  void flush_if_due();
  /// Writes all rows, and notes their number and place in the state.
  void describe(RunState& state);
  /// Of rows that were taken over this run has its own by now: a file that was left beside another goes.
  void remove_what_was_taken_over();

  /// Closes both files, whatever happened to the other; the first thing that goes wrong is thrown afterwards.
  /// What is `whole` takes the place of older files, what is not stays beside them. Returns what is kept
  /// then.
  std::vector<std::string> finish(const std::string& summary, bool whole);

 private:
  void add(const ResultsRow& row);

  const RunFiles files_;
  const int outputs_count_;
  std::unique_ptr<ResultsWriter> results_;
  std::unique_ptr<CsvWriter> csv_;
  ResultsRow row_;
  Eigen::VectorXd outputs_;
  RecordedRows rows_;
  std::vector<std::string> taken_over_;
};

}  // namespace mimbre::app
