#include "simulation/start/accuracy_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "simulation/describe/names.h"

namespace mimbre {

std::string accuracy_limits(const Compiled& m) {
  constexpr std::size_t most = 4;
  std::vector<std::string> names;
  for (const ElementData& e : m.elements)
    // Turns that an element counts are not integrated.
    if (law_states(e) > e.own_states) names.push_back(element_name(m, e));
  if (m.signals.clock >= 0) names.push_back("continuous blocks");
  if (!m.signals.integrals.empty()) names.push_back("integrals of signals");
  if (names.empty()) return {};
  std::string list;
  for (std::size_t k = 0; k < std::min(most, names.size()); ++k) list += (k > 0 ? ", " : "") + names[k];
  if (names.size() > most) list += ", …";
  return fmt::format(
      "accuracy does not cover states that force elements and blocks integrate themselves, which is of low "
      "order in the step: {}; compare with a smaller step",
      list);
}

}  // namespace mimbre
