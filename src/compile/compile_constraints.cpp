#include <map>

#include "compile/compile_parts.h"
#include "compile/element_parts.h"
#include "compile/paths.h"
#include "spec/constraint_kind.h"

namespace mimbre {
namespace {

/// The coordinates of a coupling, so that the equation is a length or an angle whatever multiple of it is
/// given: the largest factor of a length, or where there is none of an angle, is 1.
void couple(const Compiled& m, const spec::Constraint& s, ConstraintData& c) {
  double largest[2] = {0, 0};  // of angles, of lengths
  for (const spec::Constraint::Term& given : s.terms) {
    const ElementData on = on_coordinate(m, given.joint, given.coordinate);
    ConstraintTerm term;
    term.frame_a = on.frame_a;
    term.frame_b = on.frame_b;
    term.factor = given.factor;
    term.joint_spec = given.joint;
    term.joint = on.joint;
    term.local = given.coordinate;
    term.body = on.body;
    term.q = on.q;
    term.v = on.v;
    if (on.turns >= 0) term.turns = c.state_count++;
    double& most = largest[is_angle(on.joint, given.coordinate) ? 0 : 1];
    most = std::max(most, std::abs(given.factor));
    c.terms.push_back(term);
  }
  const double unit = largest[1] > 0 ? largest[1] : largest[0];
  for (ConstraintTerm& term : c.terms) term.factor /= unit;
  c.numbers.push_back(s.numbers[0] / unit);
  c.lengths = largest[1] > 0 ? 1 : 0;
}

/// The bodies that any of a constraint's terms moves, and where each term finds them.
void find_paths(const Compiled& m, ConstraintData& c) {
  std::map<int, PathEntry, std::greater<>> entries;
  for (ConstraintTerm& term : c.terms) {
    if (term.body >= 0) {
      entries[term.body].body = term.body;
      continue;
    }
    term.path = make_path(m, term.frame_a, term.frame_b);
    for (const PathEntry& e : term.path.entries) entries[e.body].body = e.body;
  }
  for (auto& [body, e] : entries) {
    append(m, e, c.path);
  }
  for (ConstraintTerm& term : c.terms)
    for (PathEntry& e : term.path.entries) e.offset = entries[e.body].offset;
}

void add_constraint(Compiled& m, int k) {
  const spec::Constraint& s = m.spec().constraints[k];
  ConstraintData c;
  c.spec = k;
  c.kind = find_constraint(s.type);
  const ConstraintInfo& info = constraint_info(c.kind);
  c.of_coordinates = info.of_coordinates;
  c.first_equation = m.equations;
  c.count = info.equations;
  c.lengths = info.lengths;
  c.rates = info.rates;
  c.state_count = info.states;
  if (info.of_coordinates) {
    couple(m, s, c);
  } else {
    ConstraintTerm term;
    term.frame_a = m.frame_of_spec[s.frame_a];
    term.frame_b = m.frame_of_spec[s.frame_b];
    c.terms.push_back(term);
    if (info.compile)
      info.compile(s, c);
    else
      c.numbers.append(s.numbers.begin(), s.numbers.end());
  }
  if (info.on_road) {
    const spec::Pose ground = global_pose(m, s.frame_a);
    c.road = s.road;
    c.numbers.append(ground.position.begin(), ground.position.end());
    c.numbers.append(ground.rotation.data(), ground.rotation.data() + 9);
  }
  find_paths(m, c);
  c.jacobian = add_jacobian(m, c.path, c.count);
  c.covectors = m.constraint_covectors;
  m.constraint_covectors += c.count * static_cast<int>(c.terms.size());
  c.states = static_cast<int>(m.states.size());
  c.next_states = m.constraint_states;
  m.constraint_states += c.state_count;
  m.states.resize(m.states.size() + c.state_count, 0.0);
  if (info.start) {
    const spec::Pose a = global_pose(m, s.frame_a);
    info.start(c, a.rotation.transpose() * (global_pose(m, s.frame_b).position - a.position),
               m.states.data() + c.states);
  }
  m.equations += c.count;
  m.constraints.push_back(std::move(c));
}

}  // namespace

void compile_constraints(Compiled& m) {
  for (int k = 0; k < static_cast<int>(m.spec().constraints.size()); ++k) add_constraint(m, k);
}

}  // namespace mimbre
