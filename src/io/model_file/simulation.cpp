#include <fmt/format.h>

#include <cmath>

#include "io/model_file/builder.h"

/// `simulation` and `initial`.
namespace mimbre::model_file {
namespace {

void read_integrator(const Value& value, spec::Simulation& simulation) {
  const Fields fields(value, {"type", "rho", "xi"});
  const auto type = fields.need("type", "generalized_alpha");
  const auto choice = type ? type->choice({"generalized_alpha", "newmark"}) : std::nullopt;
  if (!choice) return;
  simulation.integrator = static_cast<spec::Simulation::Integrator>(*choice);
  if (const auto rho = fields.get("rho")) {
    const auto r = rho->number();
    if (*choice == 1) rho->error("'rho' belongs to generalized_alpha; newmark has xi");
    if (r && (*r < 0 || *r > 1)) rho->error(fmt::format("{} is not between 0 and 1", *r));
    simulation.rho = r.value_or(-1);
  }
  if (const auto xi = fields.get("xi")) {
    const auto x = xi->number();
    if (*choice == 0) xi->error("'xi' belongs to newmark; generalized_alpha has rho");
    if (x && *x > 0) xi->error(fmt::format("{} is positive, which is unstable; it must be 0 or less", *x));
    simulation.xi = x.value_or(0);
  }
}

}  // namespace

void read_simulation(Builder& builder, Part& part) {
  spec::Simulation& simulation = builder.model.simulation;
  if (const auto initial = part.section("initial"))
    simulation.start_at_equilibrium = initial->choice({"assembled", "equilibrium"}).value_or(0) == 1;
  const auto section = part.section("simulation");
  if (!section) return;
  const Fields fields(*section, {"step", "end", "output_interval", "integrator", "formulation", "tolerance",
                                 "penalty", "max_iterations", "substeps"});
  const auto positive = [&](const char* key, double& target) {
    if (const auto value = fields.get(key)) target = value->positive().value_or(target);
  };
  positive("step", simulation.step);
  positive("end", simulation.end);
  positive("output_interval", simulation.output_interval);
  positive("tolerance", simulation.tolerance);
  positive("penalty", simulation.penalty);
  if (const auto count = fields.get("max_iterations"))
    simulation.max_iterations = count->integer(1, 1000).value_or(0);
  if (const auto count = fields.get("substeps")) simulation.substeps = count->integer(1, 100).value_or(0);
  if (const auto formulation = fields.get("formulation"))
    if (formulation->choice({"relative"})) simulation.formulation = "relative";
  if (const auto integrator = fields.get("integrator")) read_integrator(*integrator, simulation);
  if (simulation.step > simulation.end)
    fields.error(fmt::format("step {} is longer than end {}", simulation.step, simulation.end));
  const double steps = simulation.output_interval / simulation.step;
  if (simulation.output_interval > 0 && (steps < 0.5 || std::abs(steps - std::round(steps)) > 1e-6 * steps))
    fields.get("output_interval")
        ->error(fmt::format("{} is not a whole number of steps of {}", simulation.output_interval,
                            simulation.step));
}

}  // namespace mimbre::model_file
