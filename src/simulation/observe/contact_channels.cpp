#include "simulation/observe/contact_channels.h"

#include <algorithm>
#include <cmath>

#include "forces/element_ends.h"
#include "math/elementary.h"

namespace mimbre {

ContactSum contact_sum(const Compiled& m, const relative::Workspace<double>& w, int contact, int body) {
  ContactSum sum;
  for (int k = m.first_of_contact[contact]; k < m.first_of_contact[contact + 1]; ++k) {
    const ElementData& e = m.elements[k];
    const ElementState<const double> c = element_state(e, w.elements.data());
    if (c.x[0] >= 0) continue;
    const ElementEnds ends = ends_of(m, e, w.signals.states + e.states);
    const bool on_a = body >= 0 && m.frames[ends.frame_a].body == body,
               on_b = body < 0 || m.frames[ends.frame_b].body == body;
    if (!on_a && !on_b) continue;
    for (int i = 0; i < 3; ++i) sum.force += (on_b ? -c.force[i] : c.force[i]) * c.linear_of(i);
    sum.normal -= c.force[0];
    sum.tangential += mimbre::hypot(c.force[1], c.force[2]);
    sum.depth = std::max(sum.depth, -c.x[0]);
    ++sum.count;
  }
  return sum;
}

}  // namespace mimbre
