#pragma once
#include <vector>

#include "compile/compiled.h"

/// Instants at which functions of time are not smooth.
namespace mimbre::portable {

struct TimeEvent {
  double time = 0;
  double period = 0;  ///< s, after which it comes again; 0: it does not
};

/// Jumps and kinks of the model's functions of time by points or pieces, and of signals that are tables of
/// the time; of those that drive a joint also jumps of the second derivative. Formulas of time are taken to
/// be smooth.
std::vector<TimeEvent> time_events(const Compiled& model);

}  // namespace mimbre::portable
