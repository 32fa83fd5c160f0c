#pragma once
#include <string>
#include <vector>

#include "dynamics/state_transfer.h"
#include "dynamics/system.h"

namespace mimbre {

/// Watches how far loops are open where nothing closes them: modes of a whole loop are linear about the rigid
/// mechanism, and leave open what is of second order in the deflection.
class LoopWatch {
 public:
  void start() { largest_ = 0; }
  /// After every accepted step, kinematics evaluated. Neither allocates nor throws.
  void watch(const System& system, double time) {
    const double open = system.equations() > 0 ? system.scales().of_equations(system.phi()) : 0;
    if (!(open > largest_)) return;
    largest_ = open;
    time_ = time;
  }
  void transfer(StateTransfer& transfer) { transfer(largest_, time_); }
  std::vector<std::string> warnings() const;

 private:
  double largest_ = 0, time_ = 0;  ///< by the scales of the equations; s
};

}  // namespace mimbre
