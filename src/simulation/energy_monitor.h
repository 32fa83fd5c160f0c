#pragma once
#include <algorithm>
#include <cmath>
#include <string>

#include "simulation/energy.h"

namespace mimbre {

/// Watches the energy that the numerics feed in, from its lowest level on. More than `share` of the energy
/// that was at play in the run (largest kinetic and stored energy, against the start) makes a warning.
struct EnergyMonitor {
  static constexpr double share = 0.01;
  double start_gravity = 0, at_play = 0, lowest = 0, fed = 0;
  double largest_input = 0, largest_at = 0;  // of a step
  EnergyMeter::Place largest_place;

  void start(const EnergyMeter& meter) {
    *this = {};
    start_gravity = meter.balance().gravitational;
    at_play = meter.balance().total() - start_gravity;
  }

  void watch(const EnergyMeter& meter, double time) {
    const EnergyBalance& e = meter.balance();
    at_play = std::max(
        at_play, e.kinetic + e.elastic + e.springs + e.tyres + std::abs(e.gravitational - start_gravity));
    lowest = std::min(lowest, e.numerical);
    fed = std::max(fed, e.numerical - lowest);
    if (meter.last_input() > largest_input) {
      largest_input = meter.last_input();
      largest_at = time;
      largest_place = meter.last_place();
    }
  }

  /// What is to be said of it; empty when it is in order. Less than `nothing`, J, is round-off.
  std::string warning(const Compiled& model, double nothing) const;
};

}  // namespace mimbre
