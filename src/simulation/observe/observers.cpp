#include "simulation/observe/observers.h"

#include "mimbre/method_names.h"

namespace mimbre {

Observers::Observers(const Mechanism& mechanism, const Method& method, bool redundant)
    : model_(mechanism.model),
      energies_(method.energies && method.warnings),
      winches_(mechanism.model),
      turns_(mechanism.model),
      roads_(mechanism.model) {
  if (!method.validity) return;
  // Its limits are those of rules of second order.
  if (method.warnings && !is_runge_kutta(method.integrator)) spins_ = std::make_unique<SpinWatch>(model_);
  if (spins_ && spins_->none()) spins_.reset();
  if (method.warnings && method.formalism == spec::Simulation::Formalism::global_modes)
    loops_ = std::make_unique<LoopWatch>();
  validity_ = std::make_unique<ValidityMonitor>(model_);
  if (validity_->empty()) validity_.reset();
  if (validity_ && validity_->watches_loads())
    loads_ = std::make_unique<LoadWatch>(mechanism, method, redundant);
}

void Observers::start(const Mechanism& mechanism, const EnergyMeter& meter) {
  if (energies_) monitor_.start(meter);
  winches_.start();
  turns_.start();
  roads_.start();
  if (spins_) spins_->start();
  if (loops_) loops_->start();
  if (!validity_) return;
  validity_->start(mechanism.view(), mechanism.state);
  validity_->watch(mechanism.view());
  if (loads_) loads_->start(mechanism, *validity_);
}

void Observers::watch(Mechanism& mechanism, const EnergyMeter& meter, double length) {
  if (energies_) monitor_.watch(meter, mechanism.state.time);
  winches_.watch(mechanism.state.z.data(), mechanism.state.time);
  turns_.watch(mechanism.observer.workspace(), mechanism.state.time);
  roads_.watch(mechanism.observer.workspace(), mechanism.state.time);
  if (spins_) spins_->watch(mechanism, length);
  if (loops_) loops_->watch(mechanism.observer, mechanism.state.time);
  if (validity_) validity_->watch(mechanism.view());
  if (loads_) loads_->watch(mechanism, *validity_);
}

void Observers::transfer(StateTransfer& transfer) {
  monitor_.transfer(transfer);
  winches_.transfer(transfer);
  turns_.transfer(transfer);
  roads_.transfer(transfer);
  if (spins_) spins_->transfer(transfer);
  if (loops_) loops_->transfer(transfer);
  if (validity_) validity_->transfer(transfer);
  if (loads_) loads_->transfer(transfer);
}

std::vector<Validity> Observers::validity() {
  if (!validity_) return {};
  if (loads_) loads_->finish(*validity_);
  return validity_->worst();
}

std::vector<std::string> Observers::validity_warnings() {
  if (!validity_) return {};
  if (loads_) loads_->finish(*validity_);
  return validity_->warnings();
}

std::vector<std::string> Observers::spin_warnings() const {
  return spins_ ? spins_->warnings(model_) : std::vector<std::string>();
}

std::vector<std::string> Observers::loop_warnings() const {
  return loops_ ? loops_->warnings() : std::vector<std::string>();
}

std::string Observers::energy_warning(const StepMaker& steps) const {
  return energies_ ? monitor_.warning(model_, steps.meter(), steps.resting_energy()) : std::string();
}

std::optional<UnresolvedReaction> Observers::unresolved() const {
  return loads_ ? loads_->unresolved() : std::nullopt;
}

}  // namespace mimbre
