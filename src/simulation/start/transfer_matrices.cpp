#include "simulation/start/transfer_matrices.h"

#include <fmt/format.h>

#include "compile/element_name.h"
#include "mimbre/diagnostics.h"

namespace mimbre {

void refuse_transfer_matrices(const Compiled& model, const Method& method) {
  using Simulation = spec::Simulation;
  if (method.formalism != Simulation::Formalism::transfer_matrices) return;
  const Mark where{model.spec().file, 0, 0};
  if (method.formulation == Simulation::Formulation::natural)
    throw InputError(where,
                     "formalism transfer_matrices: solves joint by joint, and natural coordinates "
                     "have no joint coordinates; use formulation: relative");
  for (const ElementData& e : model.elements)
    if (e.pooled)
      throw InputError(where,
                       fmt::format("formalism transfer_matrices: {}: its spheres touch other ones from step "
                                   "to step, so that no way along the bodies is known before; use formalism: "
                                   "index3",
                                   element_name(model, e)));
}

}  // namespace mimbre
