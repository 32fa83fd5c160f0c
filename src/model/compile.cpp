#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "math/decompositions.h"
#include "mimbre/model.h"
#include "mimbre/reduced_body.h"
#include "model/compiled.h"
#include "model/flexible_data.h"
#include "model/topology.h"

namespace mimbre {
namespace {

/// Builds the flat arrays from the spec and its tree.
class Compiler {
 public:
  explicit Compiler(spec::Model model) {
    c_.spec = std::move(model);
    c_.gravity = c_.spec.gravity;
  }

  std::unique_ptr<const Compiled> run() {
    topology_ = find_topology(c_.spec);
    bodies();
    frames();
    subspaces();
    forces();
    loops_and_drives();
    matrix();
    scales();
    return std::make_unique<const Compiled>(std::move(c_));
  }

 private:
  void bodies() {
    const auto& spec_bodies = c_.spec.bodies;
    c_.body_of_spec.assign(spec_bodies.size(), -1);
    std::map<const ReducedBody*, int> known;
    for (const Topology::Branch& branch : topology_.branches) {
      const spec::Body& s = spec_bodies[branch.body];
      const spec::Joint& joint = c_.spec.joints[branch.joint];
      const JointInfo& info = joint_info(joint.type);
      BodyData b;
      b.spec = branch.body;
      b.parent = branch.parent < 0 ? -1 : c_.body_of_spec[branch.parent];
      b.joint_spec = branch.joint;
      b.joint = joint.type;
      b.reversed = branch.reversed;
      b.joint_velocities = info.velocities;
      b.joint_positions = info.positions;
      b.q = c_.positions;
      b.v = c_.velocities;
      if (s.flexible) {
        b.modes = s.flexible->modes;
        b.mass = s.flexible->mass;
        const auto [it, is_new] = known.try_emplace(s.flexible.get(), static_cast<int>(c_.flexible.size()));
        if (is_new) c_.flexible.push_back(flexible_data(*s.flexible));
        b.flexible = it->second;
        b.first_moment = s.flexible->first_moment;
        b.second_moment = s.flexible->second_moment;
      } else {
        b.mass = s.mass;
        b.first_moment = s.mass * s.com;
        // P about the centre of mass from J = tr(P) I − P.
        const Mat3d about_com = 0.5 * s.inertia.trace() * Mat3d::Identity() - s.inertia;
        b.second_moment = about_com + s.mass * s.com * s.com.transpose();
      }
      b.inertia = b.second_moment.trace() * Mat3d::Identity() - b.second_moment;
      c_.positions += info.positions + b.modes;
      c_.velocities += info.velocities + b.modes;
      c_.body_of_spec[branch.body] = static_cast<int>(c_.bodies.size());
      c_.bodies.push_back(b);
    }
  }

  int tree_body(const spec::Frame& f) const { return f.body < 0 ? -1 : c_.body_of_spec[f.body]; }

  void frames() {
    const auto& spec_frames = c_.spec.frames;
    std::set<int> needed, full;
    for (const Topology::Branch& b : topology_.branches) {
      const spec::Joint& j = c_.spec.joints[b.joint];
      full.insert(b.reversed ? j.frame_b : j.frame_a);
    }
    for (int k : topology_.cut_joints) full.insert({c_.spec.joints[k].frame_a, c_.spec.joints[k].frame_b});
    for (const auto& s : c_.spec.springs) needed.insert({s.frame_a, s.frame_b});
    for (const auto& l : c_.spec.loads) full.insert(l.frame);
    for (const auto& t : c_.spec.tyres) needed.insert(t.frame);
    needed.insert(full.begin(), full.end());

    c_.frame_of_spec.assign(spec_frames.size(), -1);
    const auto add_frames = [&](bool dynamic, int body) {
      for (int k = 0; k < static_cast<int>(spec_frames.size()); ++k)
        if (tree_body(spec_frames[k]) == body && (needed.count(k) > 0) == dynamic) {
          c_.frame_of_spec[k] = static_cast<int>(c_.frames.size());
          c_.frames.push_back(frame_data(k));
          c_.frames.back().full = !dynamic || full.count(k) > 0;
        }
    };
    const int nb = static_cast<int>(c_.bodies.size());
    for (int b = 0; b < nb; ++b) {
      c_.bodies[b].first_frame = static_cast<int>(c_.frames.size());
      add_frames(true, b);
      c_.bodies[b].last_frame = static_cast<int>(c_.frames.size());
    }
    c_.first_ground_frame = static_cast<int>(c_.frames.size());
    add_frames(true, -1);
    c_.last_ground_frame = c_.dynamic_frames = static_cast<int>(c_.frames.size());
    for (int b = -1; b < nb; ++b) add_frames(false, b);
    for (int b = 0; b < nb; ++b) {
      BodyData& body = c_.bodies[b];
      const spec::Joint& j = c_.spec.joints[body.joint_spec];
      body.inboard_frame = c_.frame_of_spec[body.reversed ? j.frame_b : j.frame_a];
      body.outboard_frame = c_.frame_of_spec[body.reversed ? j.frame_a : j.frame_b];
    }
  }

  FrameData frame_data(int k) const {
    const spec::Frame& s = c_.spec.frames[k];
    FrameData f;
    f.spec = k;
    f.body = tree_body(s);
    f.position = s.pose.position;
    f.rotation = s.pose.rotation;
    if (f.body < 0 || c_.bodies[f.body].flexible < 0 || s.flexible_frame < 0) return f;
    const BodyFrame& r = c_.spec.bodies[s.body].flexible->frames[s.flexible_frame];
    if (r.X.isZero(0) && r.X_theta.isZero(0)) return f;
    f.flexible = c_.bodies[f.body].flexible;
    const int stride = c_.flexible[f.flexible].stride;
    const auto& second = c_.spec.bodies[s.body].flexible->second_order;
    f.X = padded(second ? second->frame_shapes[s.flexible_frame] : r.X, stride);
    f.X_theta = padded(r.X_theta, stride);
    f.turns = !r.X_theta.isZero(0);
    const ReducedBody& body = *c_.spec.bodies[s.body].flexible;
    f.turn = static_cast<FrameTurn>(body.boundary_rotation);
    if (body.ancf) {
      f.turn = FrameTurn::slope;
      f.along = body.ancf->along;
      f.normal = body.ancf->normal;
    }
    return f;
  }

  int add_subspace(int body, int frame) {
    MotionSubspace set{body, frame, c_.subspace_storage, pad(c_.bodies[body].size())};
    c_.subspace_storage += 6 * set.stride;
    c_.subspaces.push_back(set);
    return static_cast<int>(c_.subspaces.size()) - 1;
  }

  void subspaces() {
    for (int b = 0; b < static_cast<int>(c_.bodies.size()); ++b) {
      BodyData& body = c_.bodies[b];
      body.subspace = add_subspace(b, -1);  // of the body frame
      for (int f = body.first_frame; f < body.last_frame; ++f)
        c_.frames[f].subspace = c_.frames[f].flexible < 0 ? body.subspace : add_subspace(b, f);
    }
  }

  /// The bodies whose coordinates move frame b relative to frame a.
  Path make_path(int frame_a, int frame_b) const {
    std::map<int, PathEntry, std::greater<>> entries;
    const auto walk = [&](int frame, bool plus) {
      while (c_.frames[frame].body >= 0) {
        const int body = c_.frames[frame].body;
        PathEntry& e = entries[body];
        e.body = body;
        (plus ? e.plus : e.minus) = c_.frames[frame].subspace;
        frame = c_.bodies[body].inboard_frame;
      }
    };
    walk(frame_a, false);
    walk(frame_b, true);
    Path path;
    for (auto& [body, e] : entries) {
      if (e.plus == e.minus || c_.bodies[body].size() == 0) continue;
      e.offset = path.width;
      path.width += pad(c_.bodies[body].size());
      path.entries.push_back(e);
    }
    return path;
  }

  int add_jacobian(const Path& path, int rows) {
    const int offset = c_.jacobian_storage;
    c_.jacobian_storage += rows * path.width;
    return offset;
  }

  void forces() {
    const spec::Model& s = c_.spec;
    for (int k = 0; k < static_cast<int>(s.springs.size()); ++k) {
      SpringData d;
      d.spec = k;
      d.frame_a = c_.frame_of_spec[s.springs[k].frame_a];
      d.frame_b = c_.frame_of_spec[s.springs[k].frame_b];
      d.elastic = s.springs[k].elastic;
      d.damping = s.springs[k].damping;
      d.general = s.springs[k].general;
      d.free_length = assembled_distance(s.springs[k].frame_a, s.springs[k].frame_b);
      if (!(d.free_length > 0))
        throw InputError(s.springs[k].mark,
                         fmt::format("spring '{}' has length 0 in the assembled position: its "
                                     "direction is not defined; move one end",
                                     s.springs[k].name));
      d.path = make_path(d.frame_a, d.frame_b);
      d.jacobian = add_jacobian(d.path, 1);
      c_.springs.push_back(std::move(d));
    }
    for (const spec::Road& r : s.roads) c_.roads.push_back({r.over, r.height});
    for (int k = 0; k < static_cast<int>(s.tyres.size()); ++k) {
      TyreData d;
      d.spec = k;
      d.frame = c_.frame_of_spec[s.tyres[k].frame];
      d.road = s.tyres[k].road;
      d.stiffness = s.tyres[k].stiffness;
      d.radius = s.tyres[k].radius;
      d.path = make_path(ground_frame(), d.frame);
      d.jacobian = add_jacobian(d.path, 1);
      c_.tyres.push_back(std::move(d));
    }
    for (int k = 0; k < static_cast<int>(s.loads.size()); ++k) {
      const spec::Load& l = s.loads[k];
      c_.loads.push_back({k, c_.frame_of_spec[l.frame], l.force, l.moment, l.scale, l.follower});
    }
    for (int b = 0; b < static_cast<int>(c_.bodies.size()); ++b)
      for (const spec::JointSpring& js : s.joints[c_.bodies[b].joint_spec].springs)
        c_.joint_springs.push_back({c_.bodies[b].joint_spec, b, c_.bodies[b].q + js.coordinate,
                                    c_.bodies[b].v + js.coordinate, js.coordinate, js.elastic, js.damping});
  }

  /// Any frame that no coordinate moves: the parent side of a tree joint on the ground.
  int ground_frame() const {
    for (const BodyData& b : c_.bodies)
      if (b.parent < 0) return b.inboard_frame;
    return 0;
  }

  double assembled_distance(int frame_a, int frame_b) const {
    const auto global = [&](const spec::Frame& f) -> Vec3d {
      if (f.body < 0) return f.pose.position;
      const spec::Pose& body = c_.spec.bodies[f.body].pose;
      return body.position + body.rotation * f.pose.position;
    };
    return (global(c_.spec.frames[frame_b]) - global(c_.spec.frames[frame_a])).norm();
  }

  void loops_and_drives() {
    for (int k : topology_.cut_joints) {
      const spec::Joint& j = c_.spec.joints[k];
      LoopData loop;
      loop.joint_spec = k;
      loop.frame_a = c_.frame_of_spec[j.frame_a];
      loop.frame_b = c_.frame_of_spec[j.frame_b];
      loop.first_equation = c_.equations;
      loop.count = joint_info(j.type).equations;
      loop.closure = joint_info(j.type).closure;
      loop.path = make_path(loop.frame_a, loop.frame_b);
      loop.jacobian = add_jacobian(loop.path, loop.count);
      c_.equations += loop.count;
      c_.loops.push_back(std::move(loop));
    }
    for (int b = 0; b < static_cast<int>(c_.bodies.size()); ++b)
      for (const spec::Drive& d : c_.spec.joints[c_.bodies[b].joint_spec].drives)
        c_.drives.push_back({c_.bodies[b].joint_spec, b, c_.bodies[b].q + d.coordinate,
                             c_.bodies[b].v + d.coordinate, c_.equations++, d.coordinate,
                             driven_position(c_.spec.joints[c_.bodies[b].joint_spec], d), 1.0});
  }

  /// A run may be longer than the file says: what is prepared reaches over four times that.
  Function driven_position(const spec::Joint& joint, const spec::Drive& d) const {
    if (d.of == spec::Drive::Of::position) return d.law;
    const auto k = static_cast<std::size_t>(d.coordinate);
    const double start = k < joint.initial_position.size() ? joint.initial_position[k].value_or(0) : 0;
    return d.law.integral(start, 4 * c_.spec.simulation.end);
  }

  void matrix() {
    linalg::BlockPattern pattern;
    for (int b = 0; b < static_cast<int>(c_.bodies.size()); ++b) {
      pattern.sizes.push_back(c_.bodies[b].size());
      for (int a = c_.bodies[b].parent; a >= 0; a = c_.bodies[a].parent) pattern.couplings.push_back({a, b});
    }
    const auto couple = [&](const Path& path) {
      for (const PathEntry& e : path.entries)
        for (const PathEntry& f : path.entries) pattern.couplings.push_back({e.body, f.body});
    };
    for (const auto& l : c_.loops) couple(l.path);
    for (const auto& s : c_.springs) couple(s.path);
    for (const auto& t : c_.tyres) couple(t.path);
    c_.symbolic = std::make_shared<const linalg::BlockSymbolic>(pattern);

    const auto find_places = [&](Path& path) {
      for (std::size_t i = 0; i < path.entries.size(); ++i)
        for (std::size_t j = 0; j <= i; ++j)
          path.places.push_back(c_.symbolic->place(path.entries[i].body, path.entries[j].body));
    };
    for (auto& l : c_.loops) find_places(l.path);
    for (auto& s : c_.springs) find_places(s.path);
    for (auto& t : c_.tyres) find_places(t.path);
    c_.mass_places.resize(c_.bodies.size());
    for (int b = 0; b < static_cast<int>(c_.bodies.size()); ++b) {
      c_.diagonal.push_back(c_.symbolic->place(b, b));
      for (int frame = c_.bodies[b].inboard_frame; c_.frames[frame].body >= 0;
           frame = c_.bodies[c_.frames[frame].body].inboard_frame) {
        const int a = c_.frames[frame].body;
        c_.mass_places[b].push_back({a, c_.frames[frame].subspace, c_.symbolic->place(a, b)});
      }
    }
  }

  void scales() {
    double mass = 0, length = 0;
    int with_mass = 0, with_length = 0;
    for (const BodyData& b : c_.bodies) {
      if (b.mass > 0) mass += b.mass, ++with_mass;
      // From the centre of mass, so that it does not matter where the body's own frame lies.
      const Vec3d centre = b.mass > 0 ? Vec3d(b.first_moment / b.mass) : Vec3d::Zero();
      double largest = 0;
      for (int f = b.first_frame; f < b.last_frame; ++f)
        largest = std::max(largest, (c_.frames[f].position - centre).norm());
      if (!(largest > 0) && b.mass > 0)  // held nowhere else: the radius of gyration
        largest = std::sqrt(std::max(0.0, b.second_moment.trace() / b.mass - centre.squaredNorm()));
      if (largest > 0) length += largest, ++with_length;
    }
    if (with_mass > 0) c_.mass_scale = mass / with_mass;
    if (with_length > 0) c_.length_scale = length / with_length;
    const double angle = c_.length_scale * c_.length_scale;
    for (LoopData& l : c_.loops)
      for (int r = 0; r < l.count; ++r)
        l.scale[r] = l.closure[r].kind == LoopClosure::Kind::angle ? angle : 1.0;
    for (DriveData& d : c_.drives) {
      d.scale = is_angle(c_.bodies[d.body].joint, d.local) ? angle : 1.0;
    }
  }

  Compiled c_;
  Topology topology_;
};

}  // namespace

Model::Model(std::unique_ptr<const Compiled> compiled) : compiled_(std::move(compiled)) {}
Model::~Model() = default;

std::shared_ptr<const Model> Model::compile(spec::Model model) {
  return std::shared_ptr<const Model>(new Model(Compiler(std::move(model)).run()));
}

const spec::Model& Model::spec() const { return compiled_->spec; }
int Model::bodies() const { return static_cast<int>(compiled_->bodies.size()); }
int Model::coordinates() const { return compiled_->velocities; }
int Model::elastic_coordinates() const {
  int n = 0;
  for (const BodyData& b : compiled_->bodies) n += b.modes;
  return n;
}
int Model::constraints() const { return compiled_->equations; }

std::vector<Model::JointLine> Model::joint_lines() const {
  const Compiled& c = *compiled_;
  std::vector<JointLine> lines;
  const auto body_name = [&](int b) {
    return b < 0 ? std::string("ground") : c.spec.bodies[c.bodies[b].spec].name;
  };
  for (int b = 0; b < bodies(); ++b) {
    const spec::Joint& j = c.spec.joints[c.bodies[b].joint_spec];
    lines.push_back({j.name, std::string(joint_info(j.type).name), body_name(c.bodies[b].parent),
                     body_name(b), false, joint_info(j.type).velocities, 0});
  }
  for (const LoopData& l : c.loops) {
    const spec::Joint& j = c.spec.joints[l.joint_spec];
    lines.push_back({j.name, std::string(joint_info(j.type).name), body_name(c.frames[l.frame_a].body),
                     body_name(c.frames[l.frame_b].body), true, 0, l.count});
  }
  return lines;
}

}  // namespace mimbre
