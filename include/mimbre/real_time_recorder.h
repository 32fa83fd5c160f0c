#pragma once
#include <memory>
#include <string>

#include "mimbre/real_time.h"

namespace mimbre {

/// Records a loop to results files, by a thread of its own: rows as those of a run, and in the group
/// `/realtime` how each step went against the clock. Where the simulation is put elsewhere, the rows go on in
/// another file: NAME-2.h5 and so on beside NAME.h5, the first that there is not. A disk that is too slow
/// loses rows, not the loop its time.
class RealTimeRecorder : public RealTimePart {
 public:
  /// `options_json`: as in Simulation::header(). Rows come every `interval` s of the simulation; 0: at every
  /// step. Throws std::runtime_error where the file cannot be written.
  RealTimeRecorder(const std::string& path, Simulation& simulation, const std::string& options_json,
                   double interval);
  ~RealTimeRecorder() override;

  void after(Simulation& simulation, const StepReport& report, bool output) override;
  void timed(const StepTiming& timing) override;
  void moved(Simulation& simulation) override;

  // For any thread.
  void record(bool on);
  bool recording() const;
  /// That could not be written in time.
  std::int64_t lost_rows() const;
  /// What went wrong; nothing is recorded after it. Empty: nothing.
  std::string failure() const;
  /// Of the file that is written, or was last.
  std::string path() const;

  /// After the loop: writes what waits, and closes the file. `summary_json`: as of ResultsWriter::finish().
  /// Throws std::runtime_error where that fails, or something before it did.
  void finish(const RealTimeLoop& loop, const std::string& summary_json);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mimbre
