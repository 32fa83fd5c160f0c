#include "simulation/observe/shown_reactions.h"

namespace mimbre {

ShownReactions::ShownReactions(const Mechanism& mechanism, const Method& method, bool redundant)
    : step_(method.step),
      has_multipliers_(method.formalism != spec::Simulation::Formalism::global_modes),
      reactions_(mechanism.observer),
      reader_(!mechanism.natural && mechanism.model.equations > 0
                  ? std::make_unique<relative::RelativeSystem>(mechanism.model, method.inertia)
                  : nullptr),
      state_(mechanism.view()),
      residual_(mechanism.model.velocities) {
  if (mechanism.model.equations > 0) reactions_.choose_smallest(mechanism.model, redundant);
}

relative::RelativeSystem& ShownReactions::find(Mechanism& mechanism) {
  state_ = mechanism.view();
  const auto evaluate = [&](relative::RelativeSystem& system) {
    system.residual(state_.time, state_.q.data(), state_.v.data(), state_.a.data(), state_.multipliers.data(),
                    0, residual_.data());
  };
  if (mechanism.natural) {
    reactions_.find(mechanism.observer, state_);
    reactions_.limit(mechanism.observer, state_, step_);
    return mechanism.observer;
  }
  if (!reader_) {
    evaluate(mechanism.observer);
    return mechanism.observer;
  }
  reader_->enter(mechanism.state.u.data(), mechanism.state.z.data(), 0);
  reader_->begin_step(state_.q.data());
  if (!reactions_.find(*reader_, state_) || (reactions_.determined() && has_multipliers_)) {
    state_.multipliers = mechanism.state.multipliers;
    evaluate(*reader_);
  }
  reactions_.limit(*reader_, state_, step_);
  return *reader_;
}

}  // namespace mimbre
