#include "simulation/watch/loop_watch.h"

#include <fmt/format.h>

namespace mimbre {
namespace {

/// Of the mechanism's size. The Iltis and its suspension stay below 1e-4, with errors of 1 and 0.2 %; random
/// loops of slender bars at 5e-3 to 2e-2 had elastic and kinetic energies that were wrong by half and more.
constexpr double open_loops = 3e-4;

}  // namespace

std::vector<std::string> LoopWatch::warnings() const {
  if (!(largest_ > open_loops)) return {};
  return {fmt::format(
      "with formalism: global_modes the loops are open by up to {:.2g} % of the mechanism's size "
      "(limit {:.2g} %, worst at t = {:.4g} s): the bodies bend too far for modes about the rigid "
      "mechanism, and motion and energies may be wrong by far more; use formalism: index3",
      100 * largest_, 100 * open_loops, time_)};
}

}  // namespace mimbre
