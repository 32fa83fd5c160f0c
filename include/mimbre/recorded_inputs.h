#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "mimbre/simulation.h"

namespace mimbre {

/// Inputs that a run plays from tables.
class RecordedInputs {
 public:
  /// A table of one input: `values` at `times` (s). Throws InputError for times that do not increase, numbers
  /// that are not finite, and where there are not as many values as times.
  void add(const std::string& name, std::vector<double> times, std::vector<double> values);
  bool contains(const std::string& name) const;
  /// By the input's name a hash of its table: of the same points it is the same in every process.
  std::map<std::string, std::uint64_t> fingerprints() const;
  /// What they are at the start, for RunOptions::inputs.
  std::map<std::string, double> start();
  /// Finds the inputs by their names. Throws InputError where the simulation has none.
  void attach(const Simulation& simulation);
  /// Before each step: an input that is constant gets the value of a point that has been reached since the
  /// last step, one in straight lines what the table, with lines between its points, is at the step's end.
  /// Between points of the former, and where the table has not begun or has ended, it stays what others, as
  /// events, made of it.
  void set(Simulation& simulation);

 private:
  struct Track {
    std::string name;
    std::vector<double> times, values;
    int input = -1;
    bool linear = false;
    std::size_t at = 0;  ///< the last point that is not after the time asked for
  };
  static double value(Track& track, double time);
  double last_step(const Simulation& simulation) const;

  std::vector<Track> tracks_;
  double last_ = 0;  ///< when they were last set
};

}  // namespace mimbre
