#pragma once
#include <memory>

#include "dynamics/relative/system.h"
#include "dynamics/state_transfer.h"
#include "simulation/observe/smallest_reactions.h"

namespace mimbre {

/// Multipliers of the constraints in a state whose accelerations are known, in memory of its own and with the
/// system's sparse factorisation: cheap enough for now and then during a run.
class Reactions {
 public:
  explicit Reactions(const System& system);
  /// From now on redundant constraints get the smallest reactions of all joints (SmallestReactions).
  /// `always`: they are redundant; otherwise find() looks for them only where multipliers do not settle, at
  /// singular positions.
  void choose_smallest(const Compiled& model, bool always);
  /// Neither allocates nor throws. Changes the system's factorisation; its last residual is that of `state`
  /// with the multipliers found, and false is returned, with multipliers of zero, where the matrix is
  /// singular.
  bool find(relative::RelativeSystem& system, State& state);
  // The same in pieces that cost about as much each, one after the other:
  /// The residual at the state without multipliers.
  void begin(relative::RelativeSystem& system, State& state);
  /// The matrix. Where it is singular, false, and there are no further pieces.
  bool factor(relative::RelativeSystem& system, const State& state);
  /// The multipliers.
  void solve(relative::RelativeSystem& system, State& state);
  /// The residual with them.
  void evaluate(relative::RelativeSystem& system, const State& state);
  // And reduce() where they are not determined().

  /// After the system's residual at `state`, whose multipliers balance the forces: makes them the smallest
  /// where constraints are redundant, and the last residual that with them.
  void reduce(relative::RelativeSystem& system, State& state);
  /// After the system's residual at `state`, as reduce(): where a step of `step` seconds goes through a
  /// singular position, the reactions that are resolved there (SmallestReactions::limit).
  void limit(relative::RelativeSystem& system, State& state, double step);
  /// The first that limit() found, if any.
  const std::optional<UnresolvedReaction>& unresolved() const { return unresolved_; }
  void forget_unresolved() { unresolved_.reset(); }
  /// What it remembers: that.
  void transfer(StateTransfer& transfer) {
    bool found = unresolved_.has_value();
    UnresolvedReaction value = unresolved_.value_or(UnresolvedReaction{});
    transfer(found, value.time, value.joint, value.force, value.moment);
    if (transfer.restoring()) unresolved_ = found ? std::optional(value) : std::nullopt;
  }
  /// Whether the multipliers of the last find() are the only ones that balance the state.
  bool determined() const { return settled_ && !always_; }

 private:
  bool always_ = false, settled_ = true;
  std::unique_ptr<SmallestReactions> smallest_;
  std::optional<UnresolvedReaction> unresolved_;
  Eigen::VectorXd residual_, change_, jacobian_change_;
};

}  // namespace mimbre
