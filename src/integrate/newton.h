#pragma once
#include <algorithm>

namespace mimbre {

/// Judges the corrections of a Newton iteration whose matrix is kept as long as it contracts well.
struct NewtonProgress {
  // Contraction rates: where a new matrix would help; where a new one is missing terms; up to which the
  // remaining error is that of a geometric series.
  static constexpr double refactor_from = 0.1, slow_from = 0.2, geometric_below = 0.5;

  double previous = 0;
  double rate = 1;       ///< of contraction, at the last correction
  bool refactor = true;  ///< a new matrix would help
  bool slow = false;     ///< even a new one contracts slowly: terms are missing from it
  int corrections = 0;
  double least = 0;  ///< correction so far
  int idle = 0;      ///< corrections since the least one halved: round-off, where they are many

  /// Takes the size of a correction by a matrix that was new or not; returns the estimate of the error left.
  double add(double correction, bool fresh) {
    rate = corrections == 0 ? 1.0 : correction / std::max(previous, 1e-300);
    previous = correction;
    slow = slow || (corrections > 1 && fresh && rate > slow_from);
    refactor = !slow && corrections > 0 && rate > refactor_from;
    if (corrections == 0 || correction < 0.5 * least) {
      least = correction;
      idle = 0;
    } else {
      ++idle;
    }
    ++corrections;
    return correction * (rate < geometric_below ? rate / (1 - rate) : 1.0);
  }
};

}  // namespace mimbre
