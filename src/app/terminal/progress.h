#pragma once
#include <chrono>
#include <string>

namespace mimbre::app {

/// A line on the terminal with the progress of a run; nothing where stderr is not a terminal.
class Progress {
 public:
  explicit Progress(bool wanted);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  bool shown() const { return shown_; }
  /// Redraws at most ten times per second. `time` of `end` simulated, s, with `cpu_seconds` of stepping.
  void update(double time, double end, double cpu_seconds);
  /// The same for work in stages: what is being done, and how much of it is, 0 to 1.
  void update(const std::string& stage, double done);
  /// Takes the line away.
  void clear();

 private:
  bool shown_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point next_{};
};

}  // namespace mimbre::app
