#include "simulation/observe/joint_channels.h"

#include <fmt/format.h>

#include <algorithm>

#include "joints/joint_kind.h"
#include "math/rotation.h"
#include "outputs/joint_coordinates.h"

namespace mimbre {
namespace {

/// Rotation and displacement of frame b in a's axes, and its angular and linear velocity and acceleration as
/// a sees them.
struct RelativeMotion {
  Mat3d rotation;
  Vec3d displacement, omega, velocity, alpha, acceleration;
};

RelativeMotion relative_motion(const Motion<double>& a, const Motion<double>& b) {
  const Mat3d At = a.rotation.transpose();
  const Vec3d d = b.position - a.position, omega = b.omega - a.omega,
              velocity = b.velocity - a.velocity - a.omega.cross(d);
  return {At * b.rotation,
          At * d,
          At * omega,
          At * velocity,
          At * (b.alpha - a.alpha - a.omega.cross(omega)),
          At * (b.acceleration - a.acceleration - a.alpha.cross(d) - a.omega.cross(a.omega.cross(d)) -
                2 * a.omega.cross(velocity))};
}

}  // namespace

JointObserver::JointObserver(const Compiled& m)
    : model_(m), body_(m.spec().joints.size(), -1), loop_(m.spec().joints.size(), -1) {
  for (std::size_t b = 0; b < m.bodies.size(); ++b) body_[m.bodies[b].joint_spec] = static_cast<int>(b);
  for (std::size_t l = 0; l < m.loops.size(); ++l) loop_[m.loops[l].joint_spec] = static_cast<int>(l);
}

JointCoordinates JointObserver::coordinates(int joint, const relative::RelativeSystem& system,
                                            const State& s) const {
  JointCoordinates out;
  const spec::Joint& of = model_.spec().joints[joint];
  const JointInfo& info = joint_info(of.type);
  if (body_[joint] >= 0) {
    const BodyData& b = model_.bodies[body_[joint]];
    std::copy_n(s.q.data() + b.q, info.positions, out.positions.begin());
    std::copy_n(s.v.data() + b.v, info.velocities, out.rates.begin());
    std::copy_n(s.a.data() + b.v, info.velocities, out.accelerations.begin());
    return out;
  }
  const auto motion = [&](int frame) {
    return relative::output_motion(system, model_.frame_of_spec[frame], s.q.data(), s.v.data(), s.a.data());
  };
  const RelativeMotion r = relative_motion(motion(of.frame_a), motion(of.frame_b));
  joint_coordinates<double>(of.type, r.rotation, r.displacement, out.positions.data());
  // The columns of the motion subspace are orthonormal.
  const std::array<double, 6> rest{};
  JointMotion<double> subspace;
  joint_motion<double>(of.type, out.positions.data(), rest.data(), subspace);
  for (int k = 0; k < info.velocities; ++k)
    out.rates[k] = subspace.angular.col(k).dot(r.omega) + subspace.linear.col(k).dot(r.velocity);
  joint_motion<double>(of.type, out.positions.data(), out.rates.data(), subspace);
  for (int k = 0; k < info.velocities; ++k)
    out.accelerations[k] = subspace.angular.col(k).dot(r.alpha - subspace.angular_bias) +
                           subspace.linear.col(k).dot(r.acceleration);
  return out;
}

JointReaction JointObserver::reaction(int joint, const relative::RelativeSystem& system,
                                      const State& s) const {
  const auto& w = system.workspace();
  Vec3d force = Vec3d::Zero(), moment = Vec3d::Zero();  // on b, the moment about the common point
  if (body_[joint] >= 0) {
    const double sign = model_.bodies[body_[joint]].reversed ? -1 : 1;
    force = sign * w.transmitted[body_[joint]].force;
    moment = sign * w.transmitted[body_[joint]].moment;
  } else {
    // A floating one beside others has no equations.
    if (loop_[joint] >= 0) {
      const LoopData& l = model_.loops[loop_[joint]];
      for (int k = l.first_equation; k < l.first_equation + l.count; ++k) {
        force -= s.multipliers[k] * w.covector_linear[k];
        moment -= s.multipliers[k] * w.covector_angular[k];
      }
    }
    // What acts on its coordinates goes through it too.
    for (const ElementData& e : model_.elements) {
      if (e.measure != Measure::coordinate || e.joint_spec != joint) continue;
      const ElementState<const double> on = element_state(e, w.elements.data());
      const Vec3d acting = -on.force[0] * on.linear_of(0);
      force += acting;
      moment -= on.force[0] * on.angular_of(0) - w.frames[e.frame_b].position.cross(acting);
    }
    for (const ConstraintData& c : model_.constraints)
      for (std::size_t t = 0; t < c.terms.size(); ++t) {
        if (c.terms[t].joint_spec != joint) continue;
        const std::size_t k = static_cast<std::size_t>(c.covectors) + t;
        force -= s.multipliers[c.first_equation] * w.constraint_linear[k];
        moment -= s.multipliers[c.first_equation] * w.constraint_angular[k];
      }
  }
  const int frame = model_.frame_of_spec[model_.spec().joints[joint].frame_b];
  const Motion<double> b = relative::output_motion(system, frame, s.q.data(), s.v.data(), s.a.data());
  moment -= b.position.cross(force);
  return {force, moment, b.rotation.transpose() * force, b.rotation.transpose() * moment};
}

void JointObserver::add_motion_info(int j, std::vector<ChannelInfo>& channels) const {
  static const char* const quaternion[] = {"w", "x", "y", "z"};
  const spec::Joint& joint = model_.spec().joints[j];
  const bool cut = body_[j] < 0;
  const JointInfo& info = joint_info(joint.type);
  const std::string prefix = fmt::format("joint.{}.", joint.name);
  const auto numbered = [&](int k) { return info.velocities > 1 ? fmt::format(".{}", k) : std::string(); };
  for (int k = 0, plain = 0; k < info.positions; ++k) {
    const int q = info.quaternion < 0 ? -1 : k - info.quaternion;
    if (q >= 0 && q < 4) {
      channels.push_back({fmt::format("{}rotation.{}", prefix, quaternion[q]), "1",
                          fmt::format("quaternion {} of joint '{}', its second body's axes to the first's",
                                      quaternion[q], joint.name)});
      channels.back().alike = outputs::alike_position(model_, j, k);
      continue;
    }
    const bool angle = is_angle(joint.type, plain);
    channels.push_back({fmt::format("{}position{}", prefix, numbered(plain)), angle ? "rad" : "m",
                        fmt::format("coordinate {} of joint '{}'{}", plain, joint.name,
                                    cut && angle ? ", which is cut: within ±π" : "")});
    channels.back().alike = outputs::alike_position(model_, j, k);
    ++plain;
  }
  for (int k = 0; k < info.velocities; ++k)
    channels.push_back({fmt::format("{}velocity{}", prefix, numbered(k)),
                        is_angle(joint.type, k) ? "rad/s" : "m/s",
                        fmt::format("rate of coordinate {} of joint '{}'", k, joint.name)});
}

void JointObserver::add_reaction_info(int j, std::vector<ChannelInfo>& channels) const {
  const std::string& joint = model_.spec().joints[j].name;
  for (const bool own : {false, true})
    for (const bool moment : {false, true})
      for (const char* axis : {"x", "y", "z"})
        channels.push_back(
            {fmt::format("joint.{}.{}{}.{}", joint, moment ? "moment" : "force", own ? "_joint" : "", axis),
             moment ? "N m" : "N",
             fmt::format("reaction {} of joint '{}' on its second body, {} {}", moment ? "moment" : "force",
                         joint, axis, own ? "of the joint's own axes there" : "of the global axes")});
}

void JointObserver::read_motion(int joint, const relative::RelativeSystem& system, const State& s,
                                double* values) const {
  const JointInfo& info = joint_info(model_.spec().joints[joint].type);
  const JointCoordinates c = coordinates(joint, system, s);
  values = std::copy_n(c.positions.begin(), info.positions, values);
  std::copy_n(c.rates.begin(), info.velocities, values);
}

void JointObserver::read_reaction(int joint, const relative::RelativeSystem& system, const State& s,
                                  double* values) const {
  const JointReaction r = reaction(joint, system, s);
  for (const Vec3d* v : {&r.force, &r.moment, &r.force_joint, &r.moment_joint})
    values = std::copy_n(v->data(), 3, values);
}

}  // namespace mimbre
