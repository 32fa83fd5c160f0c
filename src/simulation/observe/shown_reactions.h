#pragma once
#include <memory>

#include "simulation/observe/reactions.h"
#include "simulation/step/mechanism.h"

namespace mimbre {

/// The reactions to show of a state: where the constraints determine them, the integrator's own (natural
/// coordinates: what balances its accelerations); elsewhere, also at singular positions on the way, the
/// smallest ones, and within a step of those no more than is resolved. The integrator, and what it keeps from
/// step to step, is left alone. Allocates only when made.
class ShownReactions {
 public:
  /// `redundant`: some constraints are, or nearly, so that the smallest reactions are always wanted.
  ShownReactions(const Mechanism& mechanism, const Method& method, bool redundant);

  /// Finds them at the mechanism's state, of which kinematics is evaluated. The system returned has them in
  /// its last residual, with the state().
  relative::RelativeSystem& find(Mechanism& mechanism);
  /// In relative coordinates, with the multipliers of find().
  const State& state() const { return state_; }

  /// The first ones that were not resolved, where a singular position was passed.
  const std::optional<UnresolvedReaction>& unresolved() const { return reactions_.unresolved(); }
  void forget_unresolved() { reactions_.forget_unresolved(); }

  /// What it remembers.
  void transfer(StateTransfer& transfer) { reactions_.transfer(transfer); }

 private:
  const double step_;
  const bool has_multipliers_;  ///< the integrator
  Reactions reactions_;
  std::unique_ptr<relative::RelativeSystem> reader_;  ///< of loops in relative coordinates
  State state_;
  Eigen::VectorXd residual_;
};

}  // namespace mimbre
