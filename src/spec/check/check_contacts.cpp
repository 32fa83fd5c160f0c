#include "mimbre/reduced_body.h"
#include "spec/check/checked_item.h"
#include "spec/contact_pairs.h"
#include "spec/force_law.h"
#include "spec/surface_kind.h"

/// Surfaces, and spheres that touch them.
namespace mimbre::checks {
namespace {

/// Pairs of spheres: each is kept, whether they are near each other or not.
constexpr std::size_t most_pairs = 20000;
/// Of a swarm: with surfaces, and places for those that are near each other.
constexpr std::size_t most_of_swarm = 100000;

void check_spheres(const spec::Model& model, const CheckedItem& item, const spec::Spheres& spheres) {
  item.positive("radius of its spheres", spheres.radius);
  for (const int frame : spheres.frames)
    if (!item.index("frame of a sphere", frame, model.frames.size(), "frames")) return;
  if (spheres.surface_of < 0) {
    if (spheres.frames.empty()) item.error("has a set of spheres without any; give frames");
    return;
  }
  if (!item.index("surface_of", spheres.surface_of, model.bodies.size(), "bodies")) return;
  const spec::Body& body = model.bodies[static_cast<std::size_t>(spheres.surface_of)];
  if (!body.flexible || body.flexible->triangles.empty())
    item.error(fmt::format("surface_of: body '{}' has no mesh with a surface; give points of it", body.name));
}

std::size_t count(const spec::Model& model, const spec::Contact& contact) {
  std::size_t sum = 0;
  for (const spec::Spheres& set : contact.spheres)
    sum += set.surface_of < 0
               ? set.frames.size()
               : static_cast<std::size_t>(
                     model.bodies[static_cast<std::size_t>(set.surface_of)].flexible->nodes.cols());
  return sum;
}

}  // namespace

void check_surfaces(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.surfaces.size(); ++k) {
    const spec::Surface& s = model.surfaces[k];
    const CheckedItem item(errors, "surface", s.name, s.mark, k);
    const int number = find_surface(s.kind);
    if (number < 0) {
      item.error(fmt::format("kind: there is no surface '{}'", s.kind));
      continue;
    }
    item.index("frame", s.frame, model.frames.size(), "frames");
    const SurfaceInfo& kind = surface_info(number);
    for (std::size_t i = 0; i < kind.sizes.size() && !kind.sizes[i].empty(); ++i)
      for (int c = kind.sizes[i] == "size" ? 0 : static_cast<int>(i);
           c < (kind.sizes[i] == "size" ? 3 : static_cast<int>(i) + 1); ++c)
        item.positive(std::string(kind.sizes[i]), s.size[c]);
    if (kind.check) kind.check(s, item);
  }
}

void check_contacts(const spec::Model& model, std::vector<Diagnostic>& errors) {
  const LawInfo& law = law_info(find_law("contact"));
  for (std::size_t k = 0; k < model.contacts.size(); ++k) {
    const spec::Contact& contact = model.contacts[k];
    const CheckedItem item(errors, "contact", contact.name, contact.mark, k);
    const std::size_t before = errors.size();
    for (const spec::Spheres& spheres : contact.spheres) check_spheres(model, item, spheres);
    if (contact.spheres.empty()) item.error("has no spheres");
    for (const int surface : contact.surfaces)
      item.index("surface", surface, model.surfaces.size(), "surfaces");
    if (contact.swarm && !contact.among)
      item.error("is a swarm whose spheres do not touch one another; set 'among', too");
    if (contact.surfaces.empty() && !contact.among)
      item.error("touches nothing: give surfaces, or let the spheres touch one another");
    if (contact.numbers.size() != law.numbers.size()) {
      item.error(fmt::format("law '{}' has {} numbers, {} are given", law.name, law.numbers.size(),
                             contact.numbers.size()));
      continue;
    }
    for (std::size_t i = 0; i < law.numbers.size(); ++i)
      if (!law.numbers[i].allows(contact.numbers[i]))
        item.error(
            fmt::format("{} {}", law.numbers[i].key, wrong_number(law.numbers[i], contact.numbers[i])));
    if (errors.size() > before) continue;
    const std::size_t spheres = count(model, contact), pairs = spheres * contact.surfaces.size() +
                                                               (contact.swarm   ? places_per_sphere * spheres
                                                                : contact.among ? spheres * (spheres - 1) / 2
                                                                                : 0);
    if (pairs > (contact.swarm ? most_of_swarm : most_pairs))
      item.error(
          contact.swarm
              ? fmt::format("its {} spheres on {} surfaces take {} places for pairs; at most {} can be: give "
                            "fewer spheres or surfaces",
                            spheres, contact.surfaces.size(), pairs, most_of_swarm)
              : fmt::format(
                    "its {} spheres make {} pairs, each of which is looked at in every step; at most {} "
                    "can be: give fewer spheres{}",
                    spheres, pairs, most_pairs,
                    contact.among ? ", or let them be a swarm, of which only near ones are" : ""));
  }
}

}  // namespace mimbre::checks
