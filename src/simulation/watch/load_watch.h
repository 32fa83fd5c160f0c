#pragma once
#include <memory>

#include "simulation/observe/reactions.h"
#include "simulation/step/mechanism.h"
#include "simulation/watch/validity.h"

namespace mimbre {

/// Passes the forces in every 16th state of a run to the monitor of linear theory. They cost as much as a
/// step, so that the state is kept and evaluated in stages after the next few steps, one stage per step. The
/// result does not depend on that. Allocates only in its constructor.
class LoadWatch {
 public:
  LoadWatch(const Mechanism& mechanism, const Method& method, bool redundant);

  /// Begins with the current state, which is evaluated at once.
  void start(const Mechanism& mechanism, ValidityMonitor& validity);
  /// After every accepted step.
  void watch(const Mechanism& mechanism, ValidityMonitor& validity);
  /// Performs the remaining stages; call before reading results.
  void finish(ValidityMonitor& validity);
  void transfer(StateTransfer& transfer);

  /// The first reactions that were not resolved, if any.
  const std::optional<UnresolvedReaction>& unresolved() const { return reactions_.unresolved(); }

 private:
  static constexpr int interval = 16;  ///< steps; more than there are stages
  /// The next part of the evaluation, in this order. Relative coordinates need no `factor`, `solve` and
  /// `evaluate`; without constraints `begin` is all.
  enum class Stage { begin, factor, solve, evaluate, reduce, limit };
  void take(const Mechanism& mechanism);
  bool advance();

  const double step_;
  const bool finds_;  ///< multipliers, where the integrator has none of relative coordinates
  const bool redundant_;
  relative::RelativeSystem reader_;
  Reactions reactions_;
  State state_;                  ///< that is evaluated
  Eigen::VectorXd multipliers_;  ///< the integrator's own, at that state
  int steps_ = 0;                ///< since it was taken
  Stage stage_ = Stage::begin;
  bool pending_ = false;
};

}  // namespace mimbre
