#include <cmath>

#include "mimbre/method_names.h"
#include "spec/checked_item.h"

/// Gravity, and how the model is computed.
namespace mimbre::checks {
namespace {

using Integrator = spec::Simulation::Integrator;

void check_rho(const CheckedItem& item, const spec::Simulation& s) {
  if (std::isnan(s.rho)) return item.error("rho is not a number; a negative one means the default");
  if (s.rho < 0) return;
  // Below, HHT is not unconditionally stable (Hilber, Hughes, Taylor 1977: α from -1/3 to 0).
  const double least = s.integrator == Integrator::hht ? 0.5 : 0;
  if (s.integrator == Integrator::newmark || s.integrator == Integrator::conserve ||
      is_explicit(s.integrator))
    item.error(fmt::format("rho is {}, but it belongs to generalized_alpha and hht, not to {}", s.rho,
                           name_of(s.integrator)));
  else if (!(s.rho >= least && s.rho <= 1))
    item.error(fmt::format("rho is {}; for {} it must be from {} to 1", s.rho, name_of(s.integrator), least));
}

void check_xi(const CheckedItem& item, const spec::Simulation& s) {
  if (!item.finite("xi", s.xi) || s.xi == 0) return;
  if (s.integrator != Integrator::newmark)
    item.error(fmt::format("xi is {}, but it belongs to newmark, not to {}", s.xi, name_of(s.integrator)));
  else if (s.xi > 0)
    item.error(fmt::format("xi is {}, which is unstable; it must be 0 or less", s.xi));
}

void check_times(const CheckedItem& item, const spec::Simulation& s) {
  // Years of computing; a larger number is a mistake.
  constexpr double most_steps = 1e13;
  const bool step = item.positive("step", s.step), end = item.positive("end", s.end);
  if (!step || !end) return;
  if (s.step > s.end) item.error(fmt::format("step {} is longer than end {}", s.step, s.end));
  if (!(s.end / s.step <= most_steps))
    item.error(fmt::format("a run to {} s has too many steps of {} s", s.end, s.step));
  if (!item.not_negative("output_interval", s.output_interval) || s.output_interval == 0) return;
  const double steps = s.output_interval / s.step;
  if (!(steps >= 0.5) || std::abs(steps - std::round(steps)) > 1e-6 * steps)
    item.error(
        fmt::format("output_interval {} is not a whole number of steps of {}", s.output_interval, s.step));
}

}  // namespace

void check_simulation(const spec::Model& model, std::vector<Diagnostic>& errors) {
  const Mark mark{model.file, 0, 0};
  CheckedItem(errors, "model", mark).finite("gravity", model.gravity);
  const spec::Simulation& s = model.simulation;
  const CheckedItem item(errors, "simulation", mark);
  check_times(item, s);
  item.enumerator("formulation", s.formulation, static_cast<int>(method_names::formulations.size()));
  item.enumerator("inertia", s.inertia, static_cast<int>(method_names::inertias.size()));
  item.enumerator("formalism", s.formalism, static_cast<int>(method_names::formalisms.size()));
  if (item.enumerator("integrator", s.integrator, static_cast<int>(method_names::integrators.size()))) {
    check_rho(item, s);
    check_xi(item, s);
  }
  item.not_negative("tolerance", s.tolerance);
  item.not_negative("penalty", s.penalty);
  item.not_negative("accuracy", s.accuracy);
  if (s.accuracy > 0 && s.integrator != Integrator::dopri853)
    item.error(fmt::format("accuracy belongs to dopri853, not to {}", name_of(s.integrator)));
  if (s.fixed_cost && s.accuracy > 0)
    item.error("steps of a fixed cost have no accuracy to keep; leave fixed_cost or accuracy out");
  item.between("max_iterations", s.max_iterations, 0, 1000);
  item.between("substeps", s.substeps, 0, 100);
  if (s.fixed_cost && s.formalism != spec::Simulation::Formalism::index3)
    item.error(fmt::format("fixed_cost is of the formalism index3, not of {}", name_of(s.formalism)));
  if (s.fixed_cost && s.max_iterations == 1)
    item.error("fixed_cost needs two iterations at least; max_iterations is 1");
  if (s.fixed_cost && s.substeps > 1)
    item.error(fmt::format("fixed_cost makes each step once; substeps is {}", s.substeps));
}

}  // namespace mimbre::checks
