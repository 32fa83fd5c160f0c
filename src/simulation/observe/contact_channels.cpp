#include "simulation/observe/contact_channels.h"

#include <fmt/format.h>

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

void add_contact_info(const spec::Contact& contact, std::vector<ChannelInfo>& info) {
  const std::string of = fmt::format("contact.{}", contact.name),
                    who = fmt::format("contact '{}'", contact.name);
  for (const char axis : {'x', 'y', 'z'})
    info.push_back({fmt::format("{}.force.{}", of, axis), "N",
                    fmt::format("force on the spheres of {}, {} of the global axes", who, axis)});
  info.push_back({of + ".normal", "N", fmt::format("sum of the normal forces of {}", who)});
  info.push_back({of + ".depth", "m", fmt::format("largest depth of {}", who)});
  info.push_back({of + ".count", "1", fmt::format("pairs of {} that touch", who)});
}

void read_contact(const ContactSum& sum, double* to) {
  Vec3d::Map(to) = sum.force;
  to[3] = sum.normal;
  to[4] = sum.depth;
  to[5] = sum.count;
}

}  // namespace mimbre
