#include "simulation/start/elastodynamics.h"

#include <fmt/format.h>

#include "mimbre/diagnostics.h"

namespace mimbre {

void refuse_elastodynamics(const Compiled& model, const Method& method) {
  using Simulation = spec::Simulation;
  const auto needs = [&]() -> const char* {
    if (method.formulation == Simulation::Formulation::natural) return "formulation: relative";
    if (method.formalism != Simulation::Formalism::index3) return "formalism: index3";
    if (method.inertia != Simulation::Inertia::integrals) return "inertia: integrals";
    const bool iterates = method.integrator == Simulation::Integrator::generalized_alpha ||
                          method.integrator == Simulation::Integrator::newmark ||
                          method.integrator == Simulation::Integrator::hht;
    return iterates ? nullptr : "integrator: generalized_alpha, newmark or hht";
  }();
  if (!needs) return;
  for (const BodyData& b : model.bodies) {
    if (!b.elastodynamic) continue;
    const spec::Body& body = model.spec().bodies[static_cast<std::size_t>(b.spec)];
    throw InputError(body.mark,
                     fmt::format("body '{}' bends by elastodynamics, which needs {}", body.name, needs));
  }
}

}  // namespace mimbre
