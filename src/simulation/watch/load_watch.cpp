#include "simulation/watch/load_watch.h"

namespace mimbre {

LoadWatch::LoadWatch(const Mechanism& mechanism, const Method& method, bool redundant)
    : step_(method.step),
      natural_(mechanism.natural != nullptr),
      redundant_(redundant),
      eyes_(mechanism.model, method.inertia),
      reactions_(eyes_),
      state_(mechanism.view()),
      multipliers_(state_.multipliers) {
  state_.z = mechanism.state.z;
  state_.u = mechanism.state.u;
  if (mechanism.model.equations > 0) reactions_.choose_smallest(mechanism.model, redundant);
}

void LoadWatch::take(const Mechanism& mechanism) {
  state_ = mechanism.view();
  state_.z = mechanism.state.z;
  state_.u = mechanism.state.u;
  multipliers_ = state_.multipliers;
  next_ = 0;
  pending_ = true;
}

void LoadWatch::start(const Mechanism& mechanism, ValidityMonitor& validity) {
  reactions_.forget_unresolved();
  steps_ = 0;
  take(mechanism);
  finish(validity);
}

void LoadWatch::watch(const Mechanism& mechanism, ValidityMonitor& validity) {
  if (pending_ && !piece(next_++)) {
    validity.watch_loads(eyes_.workspace(), state_.time);
    pending_ = false;
  }
  steps_ = (steps_ + 1) % interval;
  if (steps_ == 0) take(mechanism);
}

void LoadWatch::finish(ValidityMonitor& validity) {
  if (!pending_) return;
  while (piece(next_++)) {
  }
  validity.watch_loads(eyes_.workspace(), state_.time);
  pending_ = false;
}

/// Whether there are more of them. In relative coordinates the integrator's own multipliers will do.
bool LoadWatch::piece(int number) {
  const bool constrained = eyes_.equations() > 0;
  if (number == 0) {
    eyes_.enter(state_.u.data(), state_.z.data(), 0);
    eyes_.begin_step(state_.q.data());
    if (natural_) {
      reactions_.begin(eyes_, state_);
    } else {
      state_.multipliers = multipliers_;
      reactions_.evaluate(eyes_, state_);
    }
    return constrained;
  }
  if (natural_ && number < 4) {
    if (number == 1) return reactions_.factor(eyes_, state_);
    if (number == 2) reactions_.solve(eyes_, state_);
    if (number == 3) reactions_.evaluate(eyes_, state_);
    return true;
  }
  const int last = natural_ ? 5 : 2;
  if (number < last) {
    if (natural_ ? !reactions_.determined() : redundant_) reactions_.reduce(eyes_, state_);
    return true;
  }
  reactions_.limit(eyes_, state_, step_);
  return false;
}

void LoadWatch::transfer(StateTransfer& transfer) {
  reactions_.transfer(transfer);
  transfer(steps_, next_, pending_, state_.time, state_.q, state_.v, state_.a, state_.z, state_.u,
           multipliers_);
  if (!transfer.restoring() || !pending_) return;
  // What was seen so far follows from the state.
  const int seen = next_;
  for (int k = 0; k < seen; ++k) piece(k);
}

}  // namespace mimbre
