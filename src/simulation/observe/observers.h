#pragma once
#include <memory>
#include <string>
#include <vector>

#include "simulation/start/drive_smoothness.h"
#include "simulation/step/mechanism.h"
#include "simulation/step/step_maker.h"
#include "simulation/watch/energy_monitor.h"
#include "simulation/watch/load_watch.h"
#include "simulation/watch/loop_watch.h"
#include "simulation/watch/road_watch.h"
#include "simulation/watch/spin_watch.h"
#include "simulation/watch/turn_watch.h"
#include "simulation/watch/validity.h"
#include "simulation/watch/winch_watch.h"

namespace mimbre {

/// What looks on while a mechanism moves, as far as the method asks for it. Nothing of the motion depends on
/// it.
class Observers {
 public:
  Observers(const Mechanism& mechanism, const Method& method, bool redundant);

  /// From now on.
  void start(const Mechanism& mechanism, const EnergyMeter& meter);
  /// After every accepted step of `length` seconds. Neither allocates nor throws.
  void watch(Mechanism& mechanism, const EnergyMeter& meter, double length);
  void transfer(StateTransfer& transfer);

  std::vector<Validity> validity();
  /// Of linear theory.
  std::vector<std::string> validity_warnings();
  /// A body that is bent too far for a step to have a meaning; else empty.
  std::string meaningless() const { return validity_ ? validity_->meaningless() : std::string(); }
  std::vector<std::string> winch_warnings() const { return winches_.warnings(); }
  /// Of tyres that leave their road.
  std::vector<std::string> road_warnings() const { return roads_.warnings(); }
  /// Of turning that laws of force were not made for.
  std::vector<std::string> turn_warnings() const { return turns_.warnings(); }
  /// Of bodies that turn too far in a step.
  std::vector<std::string> spin_warnings() const;
  /// Of loops that the formalism does not close.
  std::vector<std::string> loop_warnings() const;
  /// Empty when there is none.
  std::string energy_warning(const StepMaker& steps) const;
  /// The first reactions that were not resolved, of those that were watched.
  std::optional<UnresolvedReaction> unresolved() const;

 private:
  const Compiled& model_;
  const bool energies_;
  EnergyMonitor monitor_;
  WinchWatch winches_;
  TurnWatch turns_;
  RoadWatch roads_;
  std::unique_ptr<SpinWatch> spins_;
  std::unique_ptr<LoopWatch> loops_;
  std::unique_ptr<ValidityMonitor> validity_;
  std::unique_ptr<LoadWatch> loads_;
};

}  // namespace mimbre
