#pragma once
#include <memory>

#include "simulation/observe/reactions.h"
#include "simulation/step/mechanism.h"
#include "simulation/watch/validity.h"

namespace mimbre {

/// Shows the forces in every 16th state of a run to the monitor of linear theory. They cost as much as a step
/// does, so that the state is kept and looked at piece by piece after the next few steps: no step pays for
/// more than one piece. What is found does not depend on that. Allocates only when made.
class LoadWatch {
 public:
  LoadWatch(const Mechanism& mechanism, const Method& method, bool redundant);

  /// From the state of now on, which is looked at at once.
  void start(const Mechanism& mechanism, ValidityMonitor& validity);
  /// After every accepted step.
  void watch(const Mechanism& mechanism, ValidityMonitor& validity);
  /// Does the pieces that are left: before anyone asks for what was found.
  void finish(ValidityMonitor& validity);
  void transfer(StateTransfer& transfer);

  /// The first reactions that were not resolved, if any.
  const std::optional<UnresolvedReaction>& unresolved() const { return reactions_.unresolved(); }

 private:
  static constexpr int interval = 16;  ///< steps; more than there are pieces
  void take(const Mechanism& mechanism);
  bool piece(int number);

  const double step_;
  const bool natural_, redundant_;
  relative::RelativeSystem eyes_;
  Reactions reactions_;
  State state_;                  ///< that is looked at
  Eigen::VectorXd multipliers_;  ///< the integrator's own of it
  int steps_ = 0;
  int next_ = 0;  ///< piece
  bool pending_ = false;
};

}  // namespace mimbre
