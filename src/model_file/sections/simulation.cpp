#include <fmt/format.h>

#include <array>
#include <cmath>

#include "mimbre/method_names.h"
#include "model_file/text/builder.h"

/// `simulation` and `initial`.
namespace mimbre::model_file {
namespace {

/// The enumerator that `value` names, if it names one.
template <class Enumeration, std::size_t Count>
std::optional<Enumeration> choice(const Value& value, const std::array<const char*, Count>& names) {
  const auto index = value.choice({names.begin(), names.end()});
  return index ? std::optional(static_cast<Enumeration>(*index)) : std::nullopt;
}

void read_integrator(const Value& value, spec::Simulation& simulation) {
  using Integrator = spec::Simulation::Integrator;
  const Fields fields(value, {"type", "rho", "xi", "accuracy"});
  const auto type = fields.need("type", "generalized_alpha");
  const auto integrator = type ? choice<Integrator>(*type, method_names::integrators) : std::nullopt;
  if (!integrator) return;
  simulation.integrator = *integrator;
  if (const auto accuracy = fields.get("accuracy")) {
    if (*integrator != Integrator::dopri853)
      accuracy->error(fmt::format("'accuracy' belongs to dopri853, not to {}", name_of(*integrator)));
    simulation.accuracy = accuracy->positive().value_or(0);
  }
  if (const auto rho = fields.get("rho")) {
    const auto r = rho->number();
    // Below, HHT is not unconditionally stable (Hilber, Hughes, Taylor 1977: α from -1/3 to 0).
    const double least = *integrator == Integrator::hht ? 0.5 : 0;
    if (*integrator == Integrator::newmark)
      rho->error("'rho' belongs to generalized_alpha and hht; newmark has xi");
    else if (*integrator == Integrator::conserve || is_explicit(*integrator))
      rho->error(
          fmt::format("'rho' belongs to generalized_alpha and hht; {} has none", name_of(*integrator)));
    else if (r && !(*r >= least && *r <= 1))
      rho->error(fmt::format("{} is not between {} and 1{}", *r, least,
                             *integrator == Integrator::hht ? " (generalized_alpha takes 0 to 1)" : ""));
    simulation.rho = r.value_or(-1);
  }
  if (const auto xi = fields.get("xi")) {
    const auto x = xi->number();
    if (*integrator == Integrator::conserve || is_explicit(*integrator))
      xi->error(fmt::format("'xi' belongs to newmark; {} has none", name_of(*integrator)));
    else if (*integrator != Integrator::newmark)
      xi->error(fmt::format("'xi' belongs to newmark; {} has rho",
                            method_names::integrators[static_cast<std::size_t>(*integrator)]));
    else if (x && *x > 0)
      xi->error(fmt::format("{} is positive, which is unstable; it must be 0 or less", *x));
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
  const Fields fields(*section,
                      {"step", "end", "output_interval", "integrator", "formulation", "inertia", "formalism",
                       "tolerance", "penalty", "max_iterations", "substeps", "fixed_cost"});
  const auto positive = [&](const char* key, double& target, const Quantity& of = quantity::number) {
    if (const auto value = fields.get(key)) target = value->positive(of).value_or(target);
  };
  positive("step", simulation.step, quantity::time);
  positive("end", simulation.end, quantity::time);
  simulation.end_given = fields.get("end").has_value();
  positive("output_interval", simulation.output_interval, quantity::time);
  positive("tolerance", simulation.tolerance);
  positive("penalty", simulation.penalty);
  if (const auto count = fields.get("max_iterations"))
    simulation.max_iterations = count->integer(1, 1000).value_or(0);
  if (const auto count = fields.get("substeps")) simulation.substeps = count->integer(1, 100).value_or(0);
  if (const auto flag = fields.get("fixed_cost")) simulation.fixed_cost = flag->flag().value_or(false);
  const auto chosen = [&](const char* key, const auto& names, auto& target) {
    if (const auto value = fields.get(key))
      target = choice<std::remove_reference_t<decltype(target)>>(*value, names).value_or(target);
  };
  chosen("formulation", method_names::formulations, simulation.formulation);
  chosen("inertia", method_names::inertias, simulation.inertia);
  chosen("formalism", method_names::formalisms, simulation.formalism);
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
