#include "integrate/stepper.h"

#include "integrate/explicit/explicit.h"
#include "integrate/global_modes/global_modes.h"
#include "integrate/independent.h"
#include "integrate/index3.h"
#include "integrate/lagrange.h"
#include "integrate/penalty.h"
#include "integrate/radau/radau.h"
#include "mimbre/method_names.h"

namespace mimbre {

std::unique_ptr<Stepper> make_stepper(System& system, spec::Simulation::Formalism formalism,
                                      const IntegratorOptions& options) {
  using Formalism = spec::Simulation::Formalism;
  if (is_explicit(options.rule)) return std::make_unique<ExplicitStepper>(system, options);
  if (options.rule == IntegratorOptions::Rule::radau) return std::make_unique<RadauStepper>(system, options);
  switch (formalism) {
    case Formalism::index3:
    case Formalism::transfer_matrices:  // by another solution in the system
      break;
    case Formalism::index1:
      return std::make_unique<LagrangeStepper>(system, options, false);
    case Formalism::baumgarte:
      return std::make_unique<LagrangeStepper>(system, options, true);
    case Formalism::penalty:
      return std::make_unique<PenaltyStepper>(system, options, false);
    case Formalism::index1_augmented:
      return std::make_unique<PenaltyStepper>(system, options, true);
    case Formalism::independent:
      return std::make_unique<IndependentStepper>(system, options);
    case Formalism::global_modes:
      return std::make_unique<GlobalModesStepper>(system, options);
  }
  return std::make_unique<IndexThree>(system, options);
}

}  // namespace mimbre
