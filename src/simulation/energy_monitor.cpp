#include "simulation/energy_monitor.h"

#include <fmt/format.h>

#include "simulation/names.h"

namespace mimbre {

std::string EnergyMonitor::warning(const Compiled& model, double nothing) const {
  if (fed <= std::max(share * at_play, nothing)) return {};
  return fmt::format(
      "the numerics fed in {:.3g} J, more than {:g} % of the {:.3g} J at play; the most in the step to t = "
      "{:.6g} s, {:.3g} J at {}: do not trust this run; take a smaller step or an integrator with damping "
      "(the default, generalised-alpha)",
      fed, 100 * share, at_play, largest_at, largest_input, place_name(model, largest_place));
}

}  // namespace mimbre
