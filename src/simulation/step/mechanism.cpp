#include "simulation/step/mechanism.h"

#include "dynamics/relative/forces.h"
#include "simulation/start/assembly.h"
#include "simulation/start/elastodynamics.h"
#include "simulation/start/transfer_matrices.h"
#include "simulation/step/signal_state.h"

namespace mimbre {

Mechanism::Mechanism(const Compiled& compiled, const Method& method)
    : model(compiled),
      observer(compiled, method.inertia),
      natural(make_natural(compiled, method)),
      system(natural ? static_cast<System&>(*natural) : observer),
      generalised_(compiled.velocities) {
  refuse_elastodynamics(compiled, method);
  refuse_transfer_matrices(compiled, method);
  if (method.formalism == spec::Simulation::Formalism::transfer_matrices) observer.use_transfer_matrices();
}

void Mechanism::observe() { observe_other(state); }

const State& Mechanism::observe_other(const State& other) {
  if (natural) {
    natural->to_relative(other, seen);
    observer.begin_step(seen.q.data());
  }
  const State& s = natural ? seen : other;
  observer.kinematics(s.time, s.q.data(), s.v.data(), s.a.data());
  return s;
}

void Mechanism::observe_afresh() {
  if (!natural) observer.begin_step(state.q.data());
  observe();
}

void Mechanism::enter(double step) {
  system.enter(state.u.data(), state.z.data(), step);
  observer.enter(state.u.data(), state.z.data(), step);
}

bool Mechanism::remembers() const {
  return state.z.size() > 0 || !model.signals.integrals.empty() || model.signals.clock >= 0;
}

void Mechanism::evaluate_forces() {
  const State& s = view();
  relative::forces(model, observer.workspace(), s.time, s.q.data(), s.v.data(), s.a.data(),
                   generalised_.data());
}

void Mechanism::commit(bool known) {
  if (!remembers()) return;
  if (!known) evaluate_forces();
  commit_signals(model, observer, state);
}

void Mechanism::commit_jump(bool known) {
  if (!known) evaluate_forces();
  commit_signalled_laws(model, observer, state);
}

}  // namespace mimbre
