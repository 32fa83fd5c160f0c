#include <map>

#include "compile/compile_parts.h"
#include "compile/element_parts.h"
#include "compile/paths.h"
#include "spec/force_law.h"

namespace mimbre {
namespace {

/// The sum's path, over the bodies of all its legs.
void join_legs(Compiled& c, ElementData& sum) {
  std::map<int, int, std::greater<>> offsets;  // by body, leaf to root
  for (const Leg& leg : sum.legs) {
    const ElementData& e = c.elements[leg.element];
    if (e.body >= 0) offsets[e.body] = 0;
    for (const PathEntry& entry : e.path.entries) offsets[entry.body] = 0;
  }
  for (auto& [body, offset] : offsets) {
    PathEntry entry;
    entry.body = body;
    append(c, entry, sum.path);
    offset = entry.offset;
  }
  for (Leg& leg : sum.legs) {
    const ElementData& e = c.elements[leg.element];
    if (e.body >= 0) leg.offsets.push_back(offsets[e.body] + e.local);
    for (const PathEntry& entry : e.path.entries) leg.offsets.push_back(offsets[entry.body]);
  }
  sum.jacobian = add_jacobian(c, sum.path, 1);
}

}  // namespace

void compile_sums(Compiled& c) {
  for (int k = 0; k < static_cast<int>(c.elements.size()); ++k) {
    if (c.elements[k].measure != Measure::sum) continue;
    c.sums.push_back(k);
    const spec::Element& s = c.spec().elements[c.elements[k].spec];
    const auto add = [&](ElementData e, double factor) {
      e.law = find_law("sensor");
      e.leg = true;
      const int place = add_element(c, std::move(e));
      c.elements[k].legs.push_back({place, factor, {}});
    };
    for (const auto& term : s.terms) add(on_coordinate(c, term.joint, term.coordinate), term.factor);
    for (std::size_t i = 1; i < s.path.size(); ++i) {
      ElementData e;
      e.measure = Measure::distance;
      e.frame_a = c.frame_of_spec[s.path[i - 1]];
      e.frame_b = c.frame_of_spec[s.path[i]];
      e.reference = assembled_distance(c, s.path[i - 1], s.path[i]);
      add(std::move(e), 1);
    }
    join_legs(c, c.elements[k]);
  }
}

}  // namespace mimbre
