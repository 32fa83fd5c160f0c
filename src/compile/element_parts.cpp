#include "compile/element_parts.h"

#include "compile/paths.h"
#include "spec/force_law.h"

namespace mimbre {

int add_element(Compiled& c, ElementData e) {
  if (e.measure != Measure::none && e.measure != Measure::sum && e.body < 0 && !e.pooled) {
    e.path = make_path(c, e.frame_a < 0 ? ground_frame(c) : e.frame_a, e.frame_b);
    e.jacobian = add_jacobian(c, e.path, e.count);
  }
  e.states = static_cast<int>(c.states.size());
  c.states.resize(c.states.size() + e.state_count, 0.0);
  c.elements.push_back(std::move(e));
  return static_cast<int>(c.elements.size()) - 1;
}

ElementData on_coordinate(const Compiled& c, int joint, int coordinate) {
  const spec::Joint& j = c.spec().joints[joint];
  ElementData e;
  e.measure = Measure::coordinate;
  e.joint_spec = joint;
  e.joint = j.type;
  e.local = coordinate;
  e.frame_a = c.frame_of_spec[j.frame_a];
  e.frame_b = c.frame_of_spec[j.frame_b];
  for (int b = 0; b < static_cast<int>(c.bodies.size()); ++b)
    if (c.bodies[b].joint_spec == joint) {
      e.body = b;
      e.q = c.bodies[b].q + coordinate;
      e.v = c.bodies[b].v + coordinate;
    }
  if (e.body < 0 && is_angle(j.type, coordinate)) count_turns(e);
  return e;
}

void count_turns(ElementData& e) {
  e.turns = 0;
  e.own_states = e.state_count = e.measure == Measure::relative ? turning_states : 1;
}

int add_numbers(Compiled& c, const std::vector<double>& numbers) {
  const int first = static_cast<int>(c.numbers.size());
  c.numbers.append(numbers.begin(), numbers.end());
  return first;
}

void add_derived(Compiled& c, const ElementData& e, const std::vector<double>& given) {
  std::vector<double> behind;
  if (const auto derived = law_info(e.law).derived) derived(given, e.reference, behind);
  add_numbers(c, behind);
}

int add_functions(Compiled& c, const std::vector<Function>& functions) {
  const int first = static_cast<int>(c.functions.size());
  for (const Function& f : functions) c.functions.push_back(f.data());
  return first;
}

}  // namespace mimbre
