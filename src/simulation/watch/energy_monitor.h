#pragma once
#include <algorithm>
#include <cmath>
#include <string>

#include "simulation/step/energy.h"

namespace mimbre {

/// Watches the energy that the numerics feed in or take out.
///
/// Judged is the balance, not what single steps do: what comes in and goes out again (a singular position,
/// the error of the sums over a turn) changes nothing for good. Its limit is a share of the energy at play.
/// Within the run it may swing wider, so that a gain is seen that hides behind earlier losses.
///
/// Numerical damping is on purpose where wheels hit steps: it takes there what vibrations too fast for the
/// step have. Beside dampers that take much more it changes little, as a damper does that is a tenth
/// stronger.
///
/// Where a spring vibrates fast against the step its own energy counts as at play, too: the vibration of a
/// part is not made right by the energy of a travelling whole. (Not so of bodies' modes: high ones ring at
/// any start, and are damped on purpose.)
struct EnergyMonitor {
  static constexpr double share = 0.01;                ///< of the energy at play
  static constexpr double share_of_swing = 0.05;       ///< likewise
  static constexpr double share_of_dissipation = 0.1;  ///< of what dampers take
  static constexpr double share_of_vibration = 0.1;    ///< of what vibrates with too few steps a period
  static constexpr double few_steps = 20;

  // Kinetic and potential energy: the highest and the lowest the latter came. Springs count from their
  // assembled length, gravity from the origin, so that only differences mean anything.
  double highest = 0, lowest_potential = 0;
  double drive_turnover = 0, drive_work = 0;  ///< in and out: drives hold a motion that losses would damp
  // Of the numerical energy.
  double most = 0, least = 0, rise = 0, fall = 0, last = 0;
  struct Step {
    double energy = 0, time = 0;
    EnergyMeter::Place place;
    void transfer(StateTransfer& transfer) {
      transfer(energy, time);
      place.transfer(transfer);
    }
  };
  Step largest_gain, largest_loss;

  void start(const EnergyMeter& meter);
  /// After every accepted step. Neither allocates nor throws.
  void watch(const EnergyMeter& meter, double time);

  void transfer(StateTransfer& transfer) {
    transfer(highest, lowest_potential, drive_turnover, drive_work, most, least, rise, fall, last);
    largest_gain.transfer(transfer);
    largest_loss.transfer(transfer);
  }

  double at_play() const { return highest - lowest_potential + drive_turnover; }

  /// Its warning; empty when it is in order. Less than `nothing`, J, is round-off.
  std::string warning(const Compiled& model, const EnergyMeter& meter, double nothing) const;
};

}  // namespace mimbre
