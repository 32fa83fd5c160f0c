#include <map>

#include "compile/compile_parts.h"
#include "compile/flexible_data.h"

namespace mimbre {
namespace {

/// Mass, centre of mass and inertia of a rigid body.
void set_rigid(const spec::Body& s, BodyData& b) {
  b.mass = s.mass;
  b.first_moment = s.mass * s.com;
  // P about the centre of mass from J = tr(P) I − P.
  const Mat3d about_com = 0.5 * s.inertia.trace() * Mat3d::Identity() - s.inertia;
  b.second_moment = about_com + s.mass * s.com * s.com.transpose();
}

/// What is left of inertia: forces on the modes by the motion of the undeformed body.
InertiaTerms elastodynamic_terms() {
  InertiaTerms all;
  for (int k = 0; k < inertia_term_count; ++k) {
    const auto term = static_cast<InertiaTerm>(k);
    if (term != InertiaTerm::centrifugal && term != InertiaTerm::rotation_coupling) all.add(term);
  }
  return all;
}

}  // namespace

void compile_bodies(Compiled& c, const Topology& topology) {
  const spec::Model& spec = c.spec();
  c.body_of_spec.assign(spec.bodies.size(), -1);
  std::map<const ReducedBody*, int> known;
  for (const Topology::Branch& branch : topology.branches) {
    const spec::Body& s = spec.bodies[branch.body];
    const spec::Joint& joint = spec.joints[branch.joint];
    const JointInfo& info = joint_info(joint.type);
    BodyData b;
    b.spec = branch.body;
    b.parent = branch.parent < 0 ? -1 : c.body_of_spec[branch.parent];
    b.joint_spec = branch.joint;
    b.joint = joint.type;
    b.reversed = branch.reversed;
    b.joint_velocities = info.velocities;
    b.joint_positions = info.positions;
    b.joint_lengths = info.lengths;
    b.joint_biased = info.biased;
    for (int k = 0; k < info.velocities; ++k)
      b.joint_axes[static_cast<std::size_t>(k)] = static_cast<signed char>(info.fixed_axis(k));
    b.q = c.positions;
    b.v = c.velocities;
    if (s.flexible) {
      b.modes = s.flexible->modes;
      b.mass = s.flexible->mass;
      const auto [it, is_new] = known.try_emplace(s.flexible.get(), static_cast<int>(c.flexible.size()));
      if (is_new) c.flexible.push_back(flexible_data(*s.flexible));
      b.flexible = it->second;
      b.neglected = s.neglected.complete();
      b.elastodynamic = s.elastodynamic && b.modes > 0;
      if (b.elastodynamic) b.neglected.bits |= elastodynamic_terms().bits;
      b.first_moment = s.flexible->first_moment;
      b.second_moment = s.flexible->second_moment;
    } else {
      set_rigid(s, b);
    }
    b.inertia = b.second_moment.trace() * Mat3d::Identity() - b.second_moment;
    c.positions += info.positions + b.modes;
    c.velocities += info.velocities + b.modes;
    c.body_of_spec[branch.body] = static_cast<int>(c.bodies.size());
    c.bodies.push_back(b);
  }
}

}  // namespace mimbre
