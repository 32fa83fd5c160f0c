#include <map>

#include "compile/compile_parts.h"
#include "compile/element_parts.h"
#include "compile/paths.h"
#include "spec/force_law.h"
#include "spec/surface_kind.h"

namespace mimbre {
namespace {

SurfaceData surface_data(const spec::Surface& s) {
  SurfaceData data{find_surface(s.kind), s.size, {}};
  if (const SurfaceInfo& info = surface_info(data.kind); info.mesh) data.mesh = info.mesh(s);
  return data;
}

/// Elements for pairs of a swarm, with room for the rows of any.
void add_places(Compiled& c, ElementData e, SwarmData& swarm) {
  int width = 0;
  for (const SwarmSphere& sphere : swarm.spheres) width = std::max(width, sphere.path.width);
  e.pooled = true;
  e.state_count += pair_states;
  swarm.first = static_cast<int>(c.elements.size());
  for (int k = places_per_sphere * static_cast<int>(swarm.spheres.size()); k > 0; --k) {
    e.jacobian = c.jacobian_storage;
    c.jacobian_storage += 2 * e.count * width;
    add_element(c, e);
  }
  swarm.last = static_cast<int>(c.elements.size());
}

}  // namespace

void compile_contacts(Compiled& c, const ContactPairs& pairs) {
  for (const spec::Surface& s : c.spec().surfaces) c.surfaces.push_back(surface_data(s));
  std::map<double, int> spheres;  // that others touch, by radius
  std::size_t next = 0;
  for (int k = 0; k < static_cast<int>(c.spec().contacts.size()); ++k) {
    const spec::Contact& s = c.spec().contacts[static_cast<std::size_t>(k)];
    c.first_of_contact.push_back(static_cast<int>(c.elements.size()));
    ElementData contact;
    contact.law = find_law("contact");
    const LawInfo& law = law_info(contact.law);
    const bool turning = law.resists_turning(s.numbers);
    contact.numbers = add_numbers(c, s.numbers);
    add_derived(c, contact, s.numbers);
    contact.spec = k;
    contact.measure = Measure::contact;
    contact.count = turning ? 6 : 3;
    contact.marked = true;
    contact.state_count = turning ? law.turning_states : law.states;
    const auto sphere_of = [&](double radius) {
      const auto [it, fresh] = spheres.try_emplace(radius, static_cast<int>(c.surfaces.size()));
      if (fresh) c.surfaces.push_back({find_surface("sphere"), {radius, 0, 0}, {}});
      return it->second;
    };
    for (; next < pairs.pairs.size() && pairs.pairs[next].contact == k; ++next) {
      const ContactPair& pair = pairs.pairs[next];
      ElementData e = contact;
      e.frame_a = c.frame_of_spec[pair.frame_a];
      e.frame_b = c.frame_of_spec[pair.frame_b];
      e.radius = pair.radius;
      e.surface = pair.surface < 0 ? sphere_of(pair.other_radius) : pair.surface;
      add_element(c, std::move(e));
    }
    SwarmData& swarm = c.swarms.emplace_back();
    for (const ContactSphere& given : pairs.swarms[static_cast<std::size_t>(k)]) {
      SwarmSphere sphere;
      sphere.frame = c.frame_of_spec[given.frame];
      sphere.surface = sphere_of(given.radius);
      sphere.radius = given.radius;
      sphere.path = make_path(c, ground_frame(c), sphere.frame);
      swarm.spheres.push_back(std::move(sphere));
    }
    add_places(c, contact, swarm);
  }
  c.first_of_contact.push_back(static_cast<int>(c.elements.size()));
}

}  // namespace mimbre
