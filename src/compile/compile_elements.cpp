#include <fmt/format.h>

#include "compile/compile_parts.h"
#include "compile/element_parts.h"
#include "compile/paths.h"
#include "compile/signals/compile_signals.h"
#include "spec/force_law.h"

namespace mimbre {
namespace {

ElementData spring_element(Compiled& c, int k) {
  const spec::Spring& spring = c.spec().springs[k];
  ElementData e;
  e.law = find_law("spring");
  e.spec = k;
  e.measure = Measure::distance;
  e.marked = true;
  e.frame_a = c.frame_of_spec[spring.frame_a];
  e.frame_b = c.frame_of_spec[spring.frame_b];
  e.functions = add_functions(c, {spring.elastic, spring.damping});
  e.formula = add_formula(c, spring.general);
  e.reference = assembled_distance(c, spring.frame_a, spring.frame_b);
  if (!(e.reference > 0))
    throw InputError(spring.mark, fmt::format("spring '{}' has length 0 in the assembled position: its "
                                              "direction is not defined; move one end",
                                              spring.name));
  return e;
}

ElementData tyre_element(Compiled& c, int k) {
  const spec::Tyre& s = c.spec().tyres[k];
  ElementData e;
  e.law = find_law(s.law);
  const LawInfo& law = law_info(e.law);
  e.spec = k;
  e.measure = law.rolling_size ? Measure::wheel : Measure::height;
  e.count = measure_size(e.measure);
  e.marked = true;
  e.frame_b = c.frame_of_spec[s.frame];
  e.road = s.road;
  e.state_count = law.states;
  e.numbers = add_numbers(c, {s.stiffness, s.radius});
  add_numbers(c, s.numbers);
  add_derived(c, e, s.numbers);
  if (!law.rolling_size) return e;
  e.radius = s.radius;
  e.direction = s.axis.normalized();
  const RollingSize size = law.rolling_size(s.numbers);
  e.rolling = size.share;
  e.footprint = size.footprint;
  return e;
}

ElementData load_element(Compiled& c, int k) {
  const spec::Load& l = c.spec().loads[k];
  ElementData e;
  e.law = find_law("load");
  e.spec = k;
  e.frame_b = c.frame_of_spec[l.frame];
  e.direction = l.force;
  e.second = l.moment;
  e.follower = l.follower;
  e.arguments = add_argument(c, load_slot(c, k));
  e.argument_count = 1;
  return e;
}

void add_joint_springs(Compiled& c, int joint) {
  const spec::Joint& j = c.spec().joints[joint];
  for (int k = 0; k < static_cast<int>(j.springs.size()); ++k) {
    ElementData e = on_coordinate(c, joint, j.springs[k].coordinate);
    e.law = find_law("spring");
    e.spec = k;
    e.functions = add_functions(c, {j.springs[k].elastic, j.springs[k].damping});
    e.formula = add_formula(c, j.springs[k].general);
    add_element(c, std::move(e));
  }
}

/// What it measures.
ElementData measured_by(const Compiled& c, const spec::Element& s) {
  using On = spec::Element::On;
  ElementData e;
  if (s.on == On::coordinate) {
    e = on_coordinate(c, s.joint, s.coordinate);
  } else if (s.on == On::coordinates) {
    e.measure = Measure::sum;
    e.about = is_angle(c.spec().joints[s.terms.front().joint].type, s.terms.front().coordinate);
  } else if (s.on == On::path) {
    e.measure = Measure::sum;
    for (std::size_t i = 1; i < s.path.size(); ++i)
      e.reference += assembled_distance(c, s.path[i - 1], s.path[i]);
  } else if (s.on == On::velocity) {
    e.measure = Measure::velocity;
    e.frame_b = c.frame_of_spec[s.frame_b];
  } else {
    e.frame_a = c.frame_of_spec[s.frame_a];
    e.frame_b = c.frame_of_spec[s.frame_b];
    const spec::Pose a = global_pose(c, s.frame_a), b = global_pose(c, s.frame_b);
    const Vec3d apart = a.rotation.transpose() * (b.position - a.position);
    e.rotation = a.rotation.transpose() * b.rotation;
    e.position = apart;
    e.measure = s.on == On::line ? Measure::distance : s.on == On::axis ? Measure::axis : Measure::relative;
    e.direction = s.direction.normalized();
    e.about = s.about;
    e.reference = s.on == On::line ? apart.norm() : e.direction.dot(apart);
    if ((e.measure == Measure::axis && e.about) || e.measure == Measure::relative) count_turns(e);
  }
  e.count = measure_size(e.measure);
  return e;
}

void add_branch(Compiled& c, const spec::MaxwellBranch& branch) {
  std::vector<double> numbers;
  for (int r = 0; r < 6; ++r)
    for (int k = 0; k < 6; ++k) numbers.push_back(branch.stiffness(r, k));
  numbers.push_back(branch.relaxation);
  add_numbers(c, numbers);
}

ElementData other_element(Compiled& c, int k) {
  const spec::Element& s = c.spec().elements[k];
  ElementData e = measured_by(c, s);
  e.law = find_law(s.law);
  e.spec = k;
  e.marked = true;
  e.numbers = add_numbers(c, s.numbers);
  add_derived(c, e, s.numbers);
  const LawInfo& law = law_info(e.law);
  if (const double inertia = law.inertia ? law.inertia(s.numbers) : 0; inertia > 0)
    e.inertia = add_numbers(c, {inertia});
  for (const spec::MaxwellBranch& branch : s.branches) add_branch(c, branch);
  if (!s.functions.empty()) e.functions = add_functions(c, s.functions);
  e.formula = add_formula(c, s.general);
  e.argument_count = static_cast<int>(s.arguments.size());
  e.arguments = static_cast<int>(c.arguments.size());
  for (const spec::Source& source : s.arguments) add_argument(c, slot_of(c, source));
  e.user = s.user != nullptr;
  e.sampled = s.user && s.user->sampled;
  e.elastic = s.user && s.user->elastic;
  e.state_count += law.states;
  if (!s.branches.empty()) e.state_count += 6 * (1 + static_cast<int>(s.branches.size()));
  if (s.user) e.state_count += static_cast<int>(s.user->states.size()) + (s.user->sampled ? e.count : 0);
  if (law.given && !s.arguments.empty()) {
    const int slot = c.arguments[e.arguments];
    if (slot >= c.signals.first_moving) e.feedback = slot;
  }
  return e;
}

/// The states of a law that the user wrote, at the start.
void set_user_states(Compiled& c, const ElementData& e) {
  const auto& user = c.spec().elements[e.spec].user;
  if (!user) return;
  const int first = e.states + e.own_states + (user->sampled ? e.count : 0);
  std::copy(user->states.begin(), user->states.end(), c.states.begin() + first);
}

}  // namespace

void compile_elements(Compiled& c, const Topology& topology) {
  const spec::Model& s = c.spec();
  const auto next = [&] { return static_cast<int>(c.elements.size()); };
  for (int k = 0; k < static_cast<int>(s.springs.size()); ++k) add_element(c, spring_element(c, k));
  c.first_tyre = next();
  for (int k = 0; k < static_cast<int>(s.tyres.size()); ++k) add_element(c, tyre_element(c, k));
  c.first_load = next();
  for (int k = 0; k < static_cast<int>(s.loads.size()); ++k) add_element(c, load_element(c, k));
  c.first_joint_spring = next();
  for (const BodyData& b : c.bodies) add_joint_springs(c, b.joint_spec);
  for (const int joint : topology.cut_joints) add_joint_springs(c, joint);
  c.first_other = next();
  for (int k = 0; k < static_cast<int>(s.elements.size()); ++k) {
    const int added = add_element(c, other_element(c, k));
    set_user_states(c, c.elements[added]);
  }
}

}  // namespace mimbre
