#include <set>

#include "compile/compile_parts.h"
#include "compile/flexible_data.h"
#include "compile/signals/compile_signals.h"
#include "spec/constraint_kind.h"
#include "spec/force_law.h"

namespace mimbre {
namespace {

int tree_body(const Compiled& c, const spec::Frame& f) { return f.body < 0 ? -1 : c.body_of_spec[f.body]; }

/// Frames of the spec that a step needs, and of these the ones whose axes and accelerations it needs.
struct FramesOfStep {
  std::set<int> needed, full;
};
FramesOfStep frames_of_step(const Compiled& c, const Topology& topology, const ContactPairs& pairs) {
  const spec::Model& spec = c.spec();
  FramesOfStep frames;
  std::set<int>&needed = frames.needed, &full = frames.full;
  for (const Topology::Branch& b : topology.branches) {
    const spec::Joint& j = spec.joints[b.joint];
    full.insert(b.reversed ? j.frame_b : j.frame_a);
  }
  for (int k : topology.cut_joints) full.insert({spec.joints[k].frame_a, spec.joints[k].frame_b});
  for (const auto& s : spec.constraints) {
    if (!constraint_info(find_constraint(s.type)).of_coordinates) full.insert({s.frame_a, s.frame_b});
    for (const auto& term : s.terms)  // also of floating joints that close a loop, which are not cut
      full.insert({spec.joints[term.joint].frame_a, spec.joints[term.joint].frame_b});
  }
  for (const auto& s : spec.springs) needed.insert({s.frame_a, s.frame_b});
  for (const auto& l : spec.loads) full.insert(l.frame);
  for (const auto& t : spec.tyres) (law_info(find_law(t.law)).rolling_size ? full : needed).insert(t.frame);
  for (const auto& e : spec.elements) {
    using On = spec::Element::On;
    if (e.on == On::line) needed.insert({e.frame_a, e.frame_b});
    if (e.on == On::axis || e.on == On::frames) full.insert({e.frame_a, e.frame_b});
    if (e.on == On::path) needed.insert(e.path.begin(), e.path.end());
    if (e.on == On::velocity) full.insert(e.frame_b);
  }
  for (const ContactPair& pair : pairs.pairs) full.insert({pair.frame_a, pair.frame_b});
  for (const auto& swarm : pairs.swarms)
    for (const ContactSphere& sphere : swarm) full.insert(sphere.frame);
  for (const int sensor : seen_within_a_step(c)) {
    const spec::Output& o = spec.sensors[sensor];
    const auto add = [&](int frame) {
      if (frame >= 0) full.insert(frame);
    };
    if (!is_of_frame(o)) continue;
    add(o.item);
    add(o.reference);
  }
  needed.insert(full.begin(), full.end());
  return frames;
}

FrameData frame_data(const Compiled& c, int k) {
  const spec::Frame& s = c.spec().frames[k];
  FrameData f;
  f.spec = k;
  f.body = tree_body(c, s);
  f.position = s.pose.position;
  f.rotation = s.pose.rotation;
  f.central = f.position.isZero(0);
  f.aligned = f.rotation == Mat3d::Identity();
  if (f.body < 0 || c.bodies[f.body].flexible < 0) return f;
  if (s.node >= 0) {
    const ReducedBody& body = *c.spec().bodies[s.body].flexible;
    f.flexible = c.bodies[f.body].flexible;
    f.X = padded(
        (body.second_order ? body.second_order->node_shapes : body.node_shapes).middleRows<3>(3 * s.node),
        c.flexible[f.flexible].stride);
    return f;
  }
  if (s.flexible_frame < 0) return f;
  const BodyFrame& r = c.spec().bodies[s.body].flexible->frames[s.flexible_frame];
  if (r.X.isZero(0) && r.X_theta.isZero(0)) return f;
  f.flexible = c.bodies[f.body].flexible;
  const int stride = c.flexible[f.flexible].stride;
  const auto& second = c.spec().bodies[s.body].flexible->second_order;
  f.X = padded(second ? second->frame_shapes[s.flexible_frame] : r.X, stride);
  f.X_theta = padded(r.X_theta, stride);
  f.turns = !r.X_theta.isZero(0);
  const ReducedBody& body = *c.spec().bodies[s.body].flexible;
  f.turn = static_cast<FrameTurn>(body.boundary_rotation);
  if (body.ancf) {
    const AncfKind kind = body.ancf->kind;
    f.turn = kind == AncfKind::planar  ? FrameTurn::slope
             : kind == AncfKind::cable ? FrameTurn::direction
                                       : FrameTurn::section;
    f.along = body.ancf->along;
    f.normal = body.ancf->normal;
    if (kind == AncfKind::thick)
      f.directions = body.ancf->sections[static_cast<std::size_t>(s.flexible_frame)];
  }
  return f;
}

/// What acts on the frame bends its body, whose modes do not move it.
void let_bend(FrameData& f) {
  if (f.flexible < 0) return;
  f.bends = true;
  f.flexible = -1;
  f.turn = FrameTurn::infinitesimal;
}

int add_subspace(Compiled& c, int body, int frame) {
  MotionSubspace set{body, frame, c.subspace_storage, pad_columns(c.bodies[body].size())};
  c.subspace_storage += 6 * set.stride;
  c.subspaces.push_back(set);
  return static_cast<int>(c.subspaces.size()) - 1;
}

}  // namespace

void compile_frames(Compiled& c, const Topology& topology, const ContactPairs& pairs) {
  const spec::Model& spec = c.spec();
  const FramesOfStep frames = frames_of_step(c, topology, pairs);
  c.frame_of_spec.assign(spec.frames.size(), -1);
  std::vector<std::vector<int>> frames_of(c.bodies.size() + 1);  // of the ground, then of each body
  for (int k = 0; k < static_cast<int>(spec.frames.size()); ++k)
    frames_of[static_cast<std::size_t>(tree_body(c, spec.frames[k]) + 1)].push_back(k);
  const auto add_frames = [&](bool dynamic, int body) {
    for (const int k : frames_of[static_cast<std::size_t>(body + 1)])
      if ((frames.needed.count(k) > 0) == dynamic) {
        c.frame_of_spec[k] = static_cast<int>(c.frames.size());
        c.frames.push_back(frame_data(c, k));
        FrameData& f = c.frames.back();
        f.full = !dynamic || frames.full.count(k) > 0;
        if (dynamic && body >= 0 && c.bodies[body].elastodynamic) let_bend(f);
      }
  };
  const int nb = static_cast<int>(c.bodies.size());
  for (int b = 0; b < nb; ++b) {
    c.bodies[b].first_frame = static_cast<int>(c.frames.size());
    add_frames(true, b);
    c.bodies[b].last_frame = static_cast<int>(c.frames.size());
  }
  c.first_ground_frame = static_cast<int>(c.frames.size());
  add_frames(true, -1);
  c.last_ground_frame = c.dynamic_frames = static_cast<int>(c.frames.size());
  for (int b = -1; b < nb; ++b) add_frames(false, b);
  for (int b = 0; b < nb; ++b) {
    BodyData& body = c.bodies[b];
    const spec::Joint& j = spec.joints[body.joint_spec];
    body.inboard_frame = c.frame_of_spec[body.reversed ? j.frame_b : j.frame_a];
    body.outboard_frame = c.frame_of_spec[body.reversed ? j.frame_a : j.frame_b];
    if (body.elastodynamic) let_bend(c.frames[body.outboard_frame]);
  }
}

void compile_subspaces(Compiled& c) {
  for (int b = 0; b < static_cast<int>(c.bodies.size()); ++b) {
    BodyData& body = c.bodies[b];
    body.subspace = add_subspace(c, b, -1);  // of the body frame
    for (int f = body.first_frame; f < body.last_frame; ++f)
      c.frames[f].subspace = c.frames[f].flexible < 0 ? body.subspace : add_subspace(c, b, f);
  }
}

}  // namespace mimbre
