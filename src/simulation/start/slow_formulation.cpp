#include "mimbre/slow_formulation.h"

#include <fmt/format.h>

#include <algorithm>

#include "dynamics/natural/once/layout.h"
#include "mimbre/method_names.h"

namespace mimbre {
namespace {

constexpr double many = 2e7;  ///< operations of a factorisation, some milliseconds
constexpr double times_slower =
    30;  ///< as many as in natural coordinates, whose blocks are smaller and take longer each

/// Multiplications and additions of a factorisation.
double operations(const linalg::BlockSymbolic& symbolic) {
  double sum = 0;
  for (const linalg::Panel& p : symbolic.panels()) {
    const double n = p.columns;
    sum += n * n * n / 3 + n * n * (p.stride - p.below);
    for (int u = p.first_update; u < p.last_update; ++u) {
      const linalg::PanelUpdate& update = symbolic.updates()[static_cast<std::size_t>(u)];
      const double entries = static_cast<double>(update.rows) * update.columns;
      sum += (update.row == update.column ? 1 : 2) * n * entries;
    }
  }
  return sum;
}

}  // namespace

std::string explain_slow_formulation(const Simulation& simulation) {
  const Method& method = simulation.method();
  if (method.formulation != spec::Simulation::Formulation::relative ||
      method.formalism == spec::Simulation::Formalism::transfer_matrices)
    return {};
  const Compiled& m = simulation.model().compiled();
  const double relative = operations(m.symbolic);
  if (!(relative > many)) return {};
  const double natural = operations(*natural::Layout(m).symbolic);
  if (!(relative > times_slower * natural)) return {};
  const auto pooled = [](const ElementData& e) { return e.pooled; };
  const auto elastodynamic = [](const BodyData& b) { return b.elastodynamic; };
  const bool chain_by_transfer = !is_runge_kutta(method.integrator) &&
                                 std::none_of(m.elements.begin(), m.elements.end(), pooled) &&
                                 std::none_of(m.bodies.begin(), m.bodies.end(), elastodynamic);
  return fmt::format(
      "the matrix of {} relative coordinates takes {:.2g} operations to factorise, {:.0f} times as many as "
      "that of natural ones; {}--formulation natural is the fast choice for so long a chain",
      m.velocities, relative, relative / natural,
      chain_by_transfer ? "--formalism transfer_matrices or " : "");
}

}  // namespace mimbre
