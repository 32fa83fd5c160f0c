#include "simulation/watch/winch_watch.h"

#include <fmt/format.h>

#include "forces/cable.h"
#include "simulation/describe/names.h"
#include "spec/force_law.h"

namespace mimbre {

WinchWatch::WinchWatch(const Compiled& m) : model_(m) {
  using namespace forces::cable;
  for (int k = 0; k < std::ssize(m.elements); ++k) {
    const ElementData& e = m.elements[k];
    if (law_info(e.law).path && e.argument_count > 0)
      winches_.push_back(
          {k, e.states + e.own_states + rest_before, least_rest * m.numbers[e.numbers + rest_number], -1});
  }
}

void WinchWatch::start() {
  for (Winch& w : winches_) w.from = -1;
}

void WinchWatch::watch(const double* states, double time) {
  for (Winch& w : winches_)
    if (w.from < 0 && !(states[w.rest] > w.least)) w.from = time;
}

void WinchWatch::transfer(StateTransfer& transfer) {
  for (Winch& w : winches_) transfer(w.from);
}

std::vector<std::string> WinchWatch::warnings() const {
  std::vector<std::string> all;
  for (const Winch& w : winches_)
    if (w.from >= 0)
      all.push_back(fmt::format(
          "{}: its `length` is shorter than {:.3g} m from t = {:.6g} s on, a thousandth of what it begins "
          "with: "
          "no cable is shorter, so the winch was held there; end the winding before, for example with "
          "max(…, 0.1)",
          element_name(model_, model_.elements[w.element]), w.least, w.from));
  return all;
}

}  // namespace mimbre
