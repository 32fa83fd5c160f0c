#include "simulation/watch/contact_log.h"

#include <fmt/format.h>

#include "simulation/describe/names.h"

namespace mimbre {
namespace {

std::string body_of(const Compiled& m, int frame) {
  const int body = m.frames[frame].body;
  return body < 0 ? "the ground" : fmt::format("body '{}'", m.spec().bodies[m.bodies[body].spec].name);
}

/// "surface 'wall'", "the sphere of body 'b'".
std::string touched(const Compiled& m, const ContactTrouble::Where& where) {
  const ElementData& e = m.elements[where.element];
  if (!e.pooled && e.surface < std::ssize(m.spec().surfaces))
    return fmt::format("surface '{}'", m.spec().surfaces[static_cast<std::size_t>(e.surface)].name);
  return "the sphere of " + body_of(m, where.frame_a);
}

std::string passing(const Compiled& m, const ContactTrouble& t, int substeps) {
  return fmt::format(
      "{}: the sphere of {} went through {} within {} (first at t = {:.6g} s{}), and was not pushed, or not "
      "fully; take a smaller step{}",
      element_name(m, m.elements[t.passed_where.element]), body_of(m, t.passed_where.frame_b),
      touched(m, t.passed_where), substeps > 1 ? "the smallest part of a step" : "a step", t.passed,
      t.passes > 1 ? fmt::format(", {} times in all", t.passes) : "",
      substeps > 1 ? "" : ", or `substeps: 4`");
}

std::string sinking(const Compiled& m, const ContactTrouble& t) {
  const ElementData& e = m.elements[t.sank_where.element];
  if (on_road(e.measure))
    return fmt::format(
        "{}: its hub is below the road from t = {:.6g} s on, at the deepest {:.3g} m at t = {:.6g} s: no "
        "tyre "
        "is pressed in by more than its radius, {:.3g} m; look at the height of the road and of the wheel, "
        "at the load, and at the tyre's stiffness",
        element_name(m, e), t.sank, t.depth - t.depth_limit, t.deepest_at, t.depth_limit);
  return fmt::format(
      "{}: the sphere of {} is deeper in {} than its radius, {:.3g} m, from t = {:.6g} s on, at the deepest "
      "{:.3g} m at t = {:.6g} s: from there it can be pushed out on any side; the contact is too soft for "
      "what presses or strikes it: take a larger stiffness, or a larger sphere",
      element_name(m, e), body_of(m, t.sank_where.frame_b), touched(m, t.sank_where), t.depth_limit, t.sank,
      t.depth, t.deepest_at);
}

}  // namespace

ContactLog empty_contact_log(const Compiled& m) {
  return ContactLog(m.spec().contacts.size() + m.spec().tyres.size());
}

std::vector<std::string> contact_warnings(const Compiled& m, const ContactLog& log, int substeps) {
  std::vector<std::string> warnings;
  for (const ContactTrouble& t : log) {
    if (t.passed >= 0) warnings.push_back(passing(m, t, substeps));
    if (t.sank >= 0) warnings.push_back(sinking(m, t));
  }
  return warnings;
}

std::string sunk_wheels(const Compiled& m, const ContactLog& log) {
  for (const ContactTrouble& t : log)
    if (t.sank >= 0 && on_road(m.elements[t.sank_where.element].measure))
      return fmt::format(
          "; {} had its hub below the road, {:.3g} m at t = {:.6g} s, from where it is pushed out with many "
          "times its load: look at the height of the road and of the wheel",
          element_name(m, m.elements[t.sank_where.element]), t.depth - t.depth_limit, t.deepest_at);
  return {};
}

}  // namespace mimbre
