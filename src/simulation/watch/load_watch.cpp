#include "simulation/watch/load_watch.h"

namespace mimbre {

LoadWatch::LoadWatch(const Mechanism& mechanism, const Method& method, bool redundant)
    : step_(method.step),
      finds_(mechanism.natural != nullptr || method.formalism == spec::Simulation::Formalism::global_modes),
      redundant_(redundant),
      reader_(mechanism.model, method.inertia),
      reactions_(reader_),
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
  stage_ = Stage::begin;
  pending_ = true;
}

void LoadWatch::start(const Mechanism& mechanism, ValidityMonitor& validity) {
  reactions_.forget_unresolved();
  steps_ = 0;
  take(mechanism);
  validity.start_lag(reader_, state_);
  finish(validity);
}

void LoadWatch::watch(const Mechanism& mechanism, ValidityMonitor& validity) {
  if (pending_ && !advance()) {
    validity.watch_loads(reader_.workspace(), state_.time);
    pending_ = false;
  }
  steps_ = (steps_ + 1) % interval;
  if (steps_ == 0) take(mechanism);
}

void LoadWatch::finish(ValidityMonitor& validity) {
  if (!pending_) return;
  while (advance()) {
  }
  validity.watch_loads(reader_.workspace(), state_.time);
  pending_ = false;
}

/// Performs the stage and moves on to the next; false after the last one. Where the
/// integrator has multipliers of relative coordinates these are used.
bool LoadWatch::advance() {
  switch (stage_) {
    case Stage::begin:
      reader_.enter(state_.u.data(), state_.z.data(), 0);
      reader_.begin_step(state_.q.data());
      if (finds_) {
        reactions_.begin(reader_, state_);
        stage_ = Stage::factor;
      } else {
        state_.multipliers = multipliers_;
        reactions_.evaluate(reader_, state_);
        stage_ = Stage::reduce;
      }
      return reader_.equations() > 0;
    case Stage::factor:
      stage_ = Stage::solve;
      return reactions_.factor(reader_, state_);
    case Stage::solve:
      reactions_.solve(reader_, state_);
      stage_ = Stage::evaluate;
      return true;
    case Stage::evaluate:
      reactions_.evaluate(reader_, state_);
      stage_ = Stage::reduce;
      return true;
    case Stage::reduce:
      if (finds_ ? !reactions_.determined() : redundant_) reactions_.reduce(reader_, state_);
      stage_ = Stage::limit;
      return true;
    case Stage::limit:
      reactions_.limit(reader_, state_, step_);
      return false;
  }
  return false;
}

void LoadWatch::transfer(StateTransfer& transfer) {
  reactions_.transfer(transfer);
  int stage = static_cast<int>(stage_);
  transfer(steps_, stage, pending_, state_.time, state_.q, state_.v, state_.a, state_.z, state_.u,
           multipliers_);
  if (!transfer.restoring() || !pending_) return;
  // The results of earlier stages follow from the state.
  stage_ = Stage::begin;
  while (static_cast<int>(stage_) < stage && advance()) {
  }
}

}  // namespace mimbre
