#pragma once
#include <chrono>
#include <thread>

#include "mimbre/real_time.h"

/// Loops against the clock, on machines that are busy: what is asserted has to hold whenever a thread gets
/// its turn.
namespace mimbre::test {

/// Half a second at ten times the clock.
inline RealTimeOptions quick_loop() {
  RealTimeOptions options;
  options.lock_memory = false;
  options.speed = 10;
  options.duration = 0.5;
  return options;
}

/// Whether it does within some minutes: long, for the machine may have other work.
template <class Condition>
bool comes_true(Condition&& condition) {
  for (int k = 0; k < 24'000; ++k) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

}  // namespace mimbre::test
