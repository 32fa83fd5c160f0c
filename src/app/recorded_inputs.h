#pragma once
#include <map>
#include <string>
#include <vector>

#include "app/options.h"
#include "mimbre/simulation.h"

/// Inputs that a run plays from tables.
namespace mimbre::app {

class RecordedInputs {
 public:
  RecordedInputs() = default;
  /// "NAME=FILE.csv" and "FILE.csv", several: tables of one of these inputs, and of all that the table names
  /// (mimbre/input_table.h). Throws InputError for what is no such table, UsageError for what is no such
  /// text.
  RecordedInputs(const std::vector<std::string>& given, const std::vector<spec::Input>& inputs);
  /// The same from memory. Throws InputError for times that do not increase, numbers that are not finite, and
  /// where there are not as many values as times.
  void add(const std::string& name, std::vector<double> times, std::vector<double> values);
  const std::vector<std::string>& files() const { return files_; }
  /// What they are at the start, for RunOptions::inputs.
  std::map<std::string, double> start();
  /// Finds the inputs by their names. Throws InputError where the simulation has none.
  void attach(const Simulation& simulation);
  /// Before each step: an input that is constant gets the last value that is not after now, one in straight
  /// lines what the table, with lines between its points, is at the step's end.
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

  std::vector<Track> tracks_;
  std::vector<std::string> files_;
};

/// Adds the option --input to a command.
void add_input_option(Parser& command, std::vector<std::string>& inputs);

}  // namespace mimbre::app
