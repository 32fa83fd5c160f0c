#include "compile/compiled.h"
#include "mimbre/model.h"
#include "spec/constraint_kind.h"

/// What a compiled model consists of, in words and counts.
namespace mimbre {

int Model::bodies() const { return static_cast<int>(compiled().bodies.size()); }
int Model::coordinates() const { return compiled().velocities; }
int Model::elastic_coordinates() const {
  int n = 0;
  for (const BodyData& b : compiled().bodies) n += b.modes;
  return n;
}
int Model::constraints() const { return compiled().equations; }

std::vector<Model::JointLine> Model::joint_lines() const {
  const Compiled& c = compiled();
  std::vector<JointLine> lines;
  const auto body_name = [&](int b) {
    return b < 0 ? std::string("ground") : c.spec().bodies[c.bodies[b].spec].name;
  };
  for (int b = 0; b < bodies(); ++b) {
    const spec::Joint& j = c.spec().joints[c.bodies[b].joint_spec];
    lines.push_back({j.name, std::string(joint_info(j.type).name), body_name(c.bodies[b].parent),
                     body_name(b), false, joint_info(j.type).velocities, 0});
  }
  for (const LoopData& l : c.loops) {
    const spec::Joint& j = c.spec().joints[l.joint_spec];
    lines.push_back({j.name, std::string(joint_info(j.type).name), body_name(c.frames[l.frame_a].body),
                     body_name(c.frames[l.frame_b].body), true, 0, l.count});
  }
  return lines;
}

std::vector<Model::ConstraintLine> Model::constraint_lines() const {
  const Compiled& c = compiled();
  std::vector<ConstraintLine> lines;
  for (const ConstraintData& constraint : c.constraints) {
    ConstraintLine line{c.spec().constraints[constraint.spec].name,
                        std::string(constraint_info(constraint.kind).name),
                        {},
                        constraint.count};
    const auto body = [&](int frame) {
      const int b = c.frames[frame].body;
      return b < 0 ? std::string("ground") : c.spec().bodies[c.bodies[b].spec].name;
    };
    for (const ConstraintTerm& term : constraint.terms)
      if (term.joint_spec >= 0)
        line.between.push_back(c.spec().joints[term.joint_spec].name);
      else
        line.between = {body(term.frame_a), body(term.frame_b)};
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace mimbre
