#include "simulation/observe/constraint_channels.h"

#include <fmt/format.h>

#include <algorithm>

#include "joints/joint_kind.h"
#include "spec/constraint_kind.h"

namespace mimbre {

Wrench<double> constraint_wrench(const ConstraintData& c, const relative::RelativeSystem& system,
                                 const State& s) {
  const auto& w = system.workspace();
  Wrench<double> out{Vec3d::Zero(), Vec3d::Zero()};
  for (int r = 0; r < c.count; ++r) {
    out.force -= s.multipliers[c.first_equation + r] * w.constraint_linear[c.covectors + r];
    out.moment -= s.multipliers[c.first_equation + r] * w.constraint_angular[c.covectors + r];
  }
  const Motion<double> b =
      relative::output_motion(system, c.terms.front().frame_b, s.q.data(), s.v.data(), s.a.data());
  out.moment -= b.position.cross(out.force);
  return out;
}

void add_constraint_info(const Compiled& m, const ConstraintData& c, std::vector<ChannelInfo>& channels) {
  const std::string& name = m.spec().constraints[c.spec].name;
  if (c.of_coordinates) {
    for (const ConstraintTerm& term : c.terms) {
      const std::string& joint = m.spec().joints[term.joint_spec].name;
      const bool several = joint_info(term.joint).velocities > 1, angle = is_angle(term.joint, term.local);
      channels.push_back(
          {fmt::format("constraint.{}.force.{}{}", name, joint,
                       several ? fmt::format(".{}", term.local) : ""),
           angle ? "N m" : "N",
           fmt::format("{} of constraint '{}' on coordinate {} of joint '{}', positive where it drives it on",
                       angle ? "torque" : "force", name, term.local, joint)});
    }
    return;
  }
  const ConstraintInfo& info = constraint_info(c.kind);
  for (const bool moment : {false, true})
    for (const char* axis : {"x", "y", "z"})
      if (moment ? info.moment : info.force)
        channels.push_back(
            {fmt::format("constraint.{}.{}.{}", name, moment ? "moment" : "force", axis),
             moment ? "N m" : "N",
             fmt::format("reaction {} of constraint '{}' on its second side, at its point there, {} of the "
                         "global axes",
                         moment ? "moment" : "force", name, axis)});
}

void read_constraint(const ConstraintData& c, const relative::RelativeSystem& system, const State& s,
                     double* values) {
  if (c.of_coordinates) {
    for (const ConstraintTerm& term : c.terms) *values++ = -s.multipliers[c.first_equation] * term.factor;
    return;
  }
  const ConstraintInfo& info = constraint_info(c.kind);
  const Wrench<double> w = constraint_wrench(c, system, s);
  if (info.force) values = std::copy_n(w.force.data(), 3, values);
  if (info.moment) std::copy_n(w.moment.data(), 3, values);
}

}  // namespace mimbre
