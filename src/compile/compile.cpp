#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "compile/compile_signals.h"
#include "compile/compiled.h"
#include "compile/find_scales.h"
#include "compile/flexible_data.h"
#include "compile/image.h"
#include "compile/slow_speeds.h"
#include "compile/topology.h"
#include "math/once/decompositions.h"
#include "mimbre/model.h"
#include "mimbre/reduced_body.h"
#include "spec/check_spec.h"
#include "spec/constraint_kinds.h"
#include "spec/contact_pairs.h"
#include "spec/force_law.h"
#include "spec/surface_kind.h"

namespace mimbre {
namespace {

/// Builds the flat arrays from the spec and its tree.
class Compiler {
 public:
  explicit Compiler(spec::Model& model) : spec_(model) {
    c_.beside = &model;
    c_.gravity = model.gravity;
  }

  std::unique_ptr<const Image> run() {
    topology_ = find_topology(spec_);
    bodies();
    plan_signals(c_);
    frames();
    subspaces();
    elements();
    place_sensors(
        c_, [this](ElementData e) { return add_element(std::move(e)); },
        [this](int joint, int coordinate) { return on_coordinate(joint, coordinate); });
    legs();
    loops_and_drives();
    c_.element_storage = 0;
    for (const auto& [first, values] : pending_states_)
      std::copy(values.begin(), values.end(), c_.states.begin() + first);
    for (ElementData& e : c_.elements) {
      e.storage = c_.element_storage;
      c_.element_storage += mimbre::element_storage(e);
    }
    matrix();
    find_scales(c_);
    find_slow_speeds(c_);
    return std::make_unique<const Image>(c_);
  }

 private:
  void bodies() {
    const auto& spec_bodies = spec_.bodies;
    c_.body_of_spec.assign(spec_bodies.size(), -1);
    std::map<const ReducedBody*, int> known;
    for (const Topology::Branch& branch : topology_.branches) {
      const spec::Body& s = spec_bodies[branch.body];
      const spec::Joint& joint = spec_.joints[branch.joint];
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
    const auto& spec_frames = spec_.frames;
    std::set<int> needed, full;
    for (const Topology::Branch& b : topology_.branches) {
      const spec::Joint& j = spec_.joints[b.joint];
      full.insert(b.reversed ? j.frame_b : j.frame_a);
    }
    for (int k : topology_.cut_joints) full.insert({spec_.joints[k].frame_a, spec_.joints[k].frame_b});
    for (const auto& c : spec_.constraints) {
      if (c.kind != spec::Constraint::Kind::coupling) full.insert({c.frame_a, c.frame_b});
      for (const auto& term : c.terms)  // also of floating joints that close a loop, which are not cut
        full.insert({spec_.joints[term.joint].frame_a, spec_.joints[term.joint].frame_b});
    }
    for (const auto& s : spec_.springs) needed.insert({s.frame_a, s.frame_b});
    for (const auto& l : spec_.loads) full.insert(l.frame);
    for (const auto& t : spec_.tyres) (measure_of(t) == Measure::wheel ? full : needed).insert(t.frame);
    for (const auto& e : spec_.elements) {
      using On = spec::Element::On;
      if (e.on == On::line) needed.insert({e.frame_a, e.frame_b});
      if (e.on == On::axis || e.on == On::frames) full.insert({e.frame_a, e.frame_b});
      if (e.on == On::path) needed.insert(e.path.begin(), e.path.end());
      if (e.on == On::velocity) full.insert(e.frame_b);
    }
    pairs_ = contact_pairs(spec_);
    for (const ContactPair& pair : pairs_.pairs) full.insert({pair.frame_a, pair.frame_b});
    for (const auto& swarm : pairs_.swarms)
      for (const ContactSphere& sphere : swarm) full.insert(sphere.frame);
    for (const int sensor : seen_within_a_step(c_)) {
      const spec::Output& o = spec_.sensors[sensor];
      const auto add = [&](int frame) {
        if (frame >= 0) full.insert(frame);
      };
      if (!is_of_frame(o)) continue;
      add(o.item);
      add(o.reference);
    }
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
      const spec::Joint& j = spec_.joints[body.joint_spec];
      body.inboard_frame = c_.frame_of_spec[body.reversed ? j.frame_b : j.frame_a];
      body.outboard_frame = c_.frame_of_spec[body.reversed ? j.frame_a : j.frame_b];
    }
  }

  FrameData frame_data(int k) const {
    const spec::Frame& s = spec_.frames[k];
    FrameData f;
    f.spec = k;
    f.body = tree_body(s);
    f.position = s.pose.position;
    f.rotation = s.pose.rotation;
    if (f.body < 0 || c_.bodies[f.body].flexible < 0) return f;
    if (s.node >= 0) {
      const ReducedBody& body = *spec_.bodies[s.body].flexible;
      f.flexible = c_.bodies[f.body].flexible;
      f.X = padded(
          (body.second_order ? body.second_order->node_shapes : body.node_shapes).middleRows<3>(3 * s.node),
          c_.flexible[f.flexible].stride);
      return f;
    }
    if (s.flexible_frame < 0) return f;
    const BodyFrame& r = spec_.bodies[s.body].flexible->frames[s.flexible_frame];
    if (r.X.isZero(0) && r.X_theta.isZero(0)) return f;
    f.flexible = c_.bodies[f.body].flexible;
    const int stride = c_.flexible[f.flexible].stride;
    const auto& second = spec_.bodies[s.body].flexible->second_order;
    f.X = padded(second ? second->frame_shapes[s.flexible_frame] : r.X, stride);
    f.X_theta = padded(r.X_theta, stride);
    f.turns = !r.X_theta.isZero(0);
    const ReducedBody& body = *spec_.bodies[s.body].flexible;
    f.turn = static_cast<FrameTurn>(body.boundary_rotation);
    if (body.ancf) {
      f.turn = FrameTurn::slope;
      f.along = body.ancf->along;
      f.normal = body.ancf->normal;
    }
    return f;
  }

  int add_subspace(int body, int frame) {
    MotionSubspace set{body, frame, c_.subspace_storage, pad_columns(c_.bodies[body].size())};
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
      append(e, path);
    }
    return path;
  }

  /// Gives the entry its place in the path's rows.
  void append(PathEntry& e, Path& path) const {
    const BodyData& body = c_.bodies[e.body];
    e.offset = path.width;
    e.first = body.v;
    e.count = body.size();
    path.width += pad_columns(e.count);
    path.entries.push_back(e);
  }

  int add_jacobian(const Path& path, int rows) {
    const int offset = c_.jacobian_storage;
    c_.jacobian_storage += rows * path.width;
    return offset;
  }

  int add_element(ElementData e) {
    if (e.measure != Measure::none && e.measure != Measure::sum && e.body < 0 && !e.pooled) {
      e.path = make_path(e.frame_a < 0 ? ground_frame() : e.frame_a, e.frame_b);
      e.jacobian = add_jacobian(e.path, e.count);
    }
    e.states = static_cast<int>(c_.states.size());
    c_.states.resize(c_.states.size() + e.state_count, 0.0);
    c_.elements.push_back(std::move(e));
    return static_cast<int>(c_.elements.size()) - 1;
  }

  /// Elements that measure the summands of each sum, behind all others, and the sum's path over their bodies.
  void legs() {
    for (int k = 0; k < static_cast<int>(c_.elements.size()); ++k) {
      if (c_.elements[k].measure != Measure::sum) continue;
      c_.sums.push_back(k);
      const spec::Element& s = spec_.elements[c_.elements[k].spec];
      const auto add = [&](ElementData e, double factor) {
        e.law = find_law("sensor");
        e.leg = true;
        const int place = add_element(std::move(e));
        c_.elements[k].legs.push_back({place, factor, {}});
      };
      for (const auto& term : s.terms) add(on_coordinate(term.joint, term.coordinate), term.factor);
      for (std::size_t i = 1; i < s.path.size(); ++i) {
        ElementData e;
        e.measure = Measure::distance;
        e.frame_a = c_.frame_of_spec[s.path[i - 1]];
        e.frame_b = c_.frame_of_spec[s.path[i]];
        e.reference = assembled_distance(s.path[i - 1], s.path[i]);
        add(std::move(e), 1);
      }
      join_legs(c_.elements[k]);
    }
  }
  void join_legs(ElementData& sum) {
    std::map<int, int, std::greater<>> offsets;  // by body, leaf to root
    for (const Leg& leg : sum.legs) {
      const ElementData& e = c_.elements[leg.element];
      if (e.body >= 0) offsets[e.body] = 0;
      for (const PathEntry& entry : e.path.entries) offsets[entry.body] = 0;
    }
    for (auto& [body, offset] : offsets) {
      PathEntry entry;
      entry.body = body;
      append(entry, sum.path);
      offset = entry.offset;
    }
    for (Leg& leg : sum.legs) {
      const ElementData& e = c_.elements[leg.element];
      if (e.body >= 0) leg.offsets.push_back(offsets[e.body] + e.local);
      for (const PathEntry& entry : e.path.entries) leg.offsets.push_back(offsets[entry.body]);
    }
    sum.jacobian = add_jacobian(sum.path, 1);
  }

  /// On a coordinate of a joint, in the tree or cut.
  ElementData on_coordinate(int joint, int coordinate) const {
    const spec::Joint& j = spec_.joints[joint];
    ElementData e;
    e.measure = Measure::coordinate;
    e.joint_spec = joint;
    e.joint = j.type;
    e.local = coordinate;
    e.frame_a = c_.frame_of_spec[j.frame_a];
    e.frame_b = c_.frame_of_spec[j.frame_b];
    for (int b = 0; b < static_cast<int>(c_.bodies.size()); ++b)
      if (c_.bodies[b].joint_spec == joint) {
        e.body = b;
        e.q = c_.bodies[b].q + coordinate;
        e.v = c_.bodies[b].v + coordinate;
      }
    if (e.body < 0 && is_angle(j.type, coordinate)) count_turns(e);
    return e;
  }
  static void count_turns(ElementData& e) {
    e.turns = 0;
    e.own_states = e.state_count = e.measure == Measure::relative ? turning_states : 1;
  }

  void elements() {
    const spec::Model& s = spec_;
    for (int k = 0; k < static_cast<int>(s.springs.size()); ++k) {
      const spec::Spring& spring = s.springs[k];
      ElementData e;
      e.law = find_law("spring");
      e.spec = k;
      e.measure = Measure::distance;
      e.marked = true;
      e.frame_a = c_.frame_of_spec[spring.frame_a];
      e.frame_b = c_.frame_of_spec[spring.frame_b];
      e.functions = add_functions({spring.elastic, spring.damping});
      e.formula = add_formula(c_, spring.general);
      e.reference = assembled_distance(spring.frame_a, spring.frame_b);
      if (!(e.reference > 0))
        throw InputError(spring.mark, fmt::format("spring '{}' has length 0 in the assembled position: its "
                                                  "direction is not defined; move one end",
                                                  spring.name));
      add_element(std::move(e));
    }
    for (const spec::Road& r : s.roads) c_.roads.push_back(road_data(r));
    place_roads(c_);
    c_.first_tyre = static_cast<int>(c_.elements.size());
    for (int k = 0; k < static_cast<int>(s.tyres.size()); ++k) add_element(tyre(k));
    c_.first_load = static_cast<int>(c_.elements.size());
    for (int k = 0; k < static_cast<int>(s.loads.size()); ++k) {
      const spec::Load& l = s.loads[k];
      ElementData e;
      e.law = find_law("load");
      e.spec = k;
      e.frame_b = c_.frame_of_spec[l.frame];
      e.direction = l.force;
      e.second = l.moment;
      e.follower = l.follower;
      e.arguments = add_argument(c_, load_slot(c_, k));
      e.argument_count = 1;
      add_element(std::move(e));
    }
    c_.first_joint_spring = static_cast<int>(c_.elements.size());
    const auto joint_springs = [&](int joint) {
      const spec::Joint& j = s.joints[joint];
      for (int k = 0; k < static_cast<int>(j.springs.size()); ++k) {
        ElementData e = on_coordinate(joint, j.springs[k].coordinate);
        e.law = find_law("spring");
        e.spec = k;
        e.functions = add_functions({j.springs[k].elastic, j.springs[k].damping});
        e.formula = add_formula(c_, j.springs[k].general);
        add_element(std::move(e));
      }
    };
    for (const BodyData& b : c_.bodies) joint_springs(b.joint_spec);
    for (const int joint : topology_.cut_joints) joint_springs(joint);
    c_.first_other = static_cast<int>(c_.elements.size());
    for (int k = 0; k < static_cast<int>(s.elements.size()); ++k) add_element(other_element(k));
    contacts();
  }

  static Measure measure_of(const spec::Tyre& tyre) {
    return law_info(find_law(tyre.law)).rolling_size ? Measure::wheel : Measure::height;
  }
  ElementData tyre(int k) {
    const spec::Tyre& s = spec_.tyres[k];
    ElementData e;
    e.law = find_law(s.law);
    e.spec = k;
    e.measure = measure_of(s);
    e.count = measure_size(e.measure);
    e.marked = true;
    e.frame_b = c_.frame_of_spec[s.frame];
    e.road = s.road;
    e.state_count = law_info(e.law).states;
    e.numbers = add_numbers({s.stiffness, s.radius});
    add_numbers(s.numbers);
    add_derived(e, s.numbers);
    if (e.measure == Measure::height) return e;
    e.radius = s.radius;
    e.direction = s.axis.normalized();
    const RollingSize size = law_info(e.law).rolling_size(s.numbers);
    e.rolling = size.share;
    e.footprint = size.footprint;
    return e;
  }

  static RoadData road_data(const spec::Road& r) {
    RoadData road;
    road.over = r.over;
    road.height = r.height.data();
    road.friction = r.friction;
    for (const spec::Road::Patch& p : r.patches)
      road.patches.push_back({{p.low[0], p.low[1]}, {p.high[0], p.high[1]}, p.friction});
    road.origin = {r.origin[0], r.origin[1]};
    road.spacing = {r.spacing[0], r.spacing[1]};
    road.rows = static_cast<int>(r.heights.rows());
    road.columns = static_cast<int>(r.heights.cols());
    for (int j = 0; j < road.rows; ++j)
      for (int i = 0; i < road.columns; ++i) road.heights.push_back(r.heights(j, i));
    if (r.along_line.along() > 0) road.own = roads::arrays_of(r.along_line, roads::file_rounding);
    return road;
  }

  void contacts() {
    for (const spec::Surface& s : spec_.surfaces) c_.surfaces.push_back(surface_data(s));
    std::map<double, int> spheres;  // that others touch, by radius
    std::size_t next = 0;
    for (int k = 0; k < static_cast<int>(spec_.contacts.size()); ++k) {
      const spec::Contact& s = spec_.contacts[static_cast<std::size_t>(k)];
      c_.first_of_contact.push_back(static_cast<int>(c_.elements.size()));
      ElementData contact;
      contact.law = find_law("contact");
      const LawInfo& law = law_info(contact.law);
      const bool turning = law.resists_turning(s.numbers);
      contact.numbers = add_numbers(s.numbers);
      add_derived(contact, s.numbers);
      contact.spec = k;
      contact.measure = Measure::contact;
      contact.count = turning ? 6 : 3;
      contact.marked = true;
      contact.state_count = turning ? law.turning_states : law.states;
      const auto sphere_of = [&](double radius) {
        const auto [it, fresh] = spheres.try_emplace(radius, static_cast<int>(c_.surfaces.size()));
        if (fresh) c_.surfaces.push_back({find_surface("sphere"), {radius, 0, 0}, {}});
        return it->second;
      };
      for (; next < pairs_.pairs.size() && pairs_.pairs[next].contact == k; ++next) {
        const ContactPair& pair = pairs_.pairs[next];
        ElementData e = contact;
        e.frame_a = c_.frame_of_spec[pair.frame_a];
        e.frame_b = c_.frame_of_spec[pair.frame_b];
        e.radius = pair.radius;
        e.surface = pair.surface < 0 ? sphere_of(pair.other_radius) : pair.surface;
        add_element(std::move(e));
      }
      SwarmData& swarm = c_.swarms.emplace_back();
      for (const ContactSphere& given : pairs_.swarms[static_cast<std::size_t>(k)]) {
        SwarmSphere sphere;
        sphere.frame = c_.frame_of_spec[given.frame];
        sphere.surface = sphere_of(given.radius);
        sphere.radius = given.radius;
        sphere.path = make_path(ground_frame(), sphere.frame);
        swarm.spheres.push_back(std::move(sphere));
      }
      add_places(contact, swarm);
    }
    c_.first_of_contact.push_back(static_cast<int>(c_.elements.size()));
  }

  /// Elements for pairs of a swarm, with room for the rows of any.
  void add_places(ElementData e, SwarmData& swarm) {
    int width = 0;
    for (const SwarmSphere& sphere : swarm.spheres) width = std::max(width, sphere.path.width);
    e.pooled = true;
    e.state_count += pair_states;
    swarm.first = static_cast<int>(c_.elements.size());
    for (int k = places_per_sphere * static_cast<int>(swarm.spheres.size()); k > 0; --k) {
      e.jacobian = c_.jacobian_storage;
      c_.jacobian_storage += 2 * e.count * width;
      add_element(e);
    }
    swarm.last = static_cast<int>(c_.elements.size());
  }

  static SurfaceData surface_data(const spec::Surface& s) {
    SurfaceData data{find_surface(s.kind), s.size, {}};
    if (const SurfaceInfo& info = surface_info(data.kind); info.mesh) data.mesh = info.mesh(s);
    return data;
  }

  ElementData other_element(int k) {
    using On = spec::Element::On;
    const spec::Element& s = spec_.elements[k];
    ElementData e;
    if (s.on == On::coordinate) {
      e = on_coordinate(s.joint, s.coordinate);
    } else if (s.on == On::coordinates) {
      e.measure = Measure::sum;
      e.about = is_angle(spec_.joints[s.terms.front().joint].type, s.terms.front().coordinate);
    } else if (s.on == On::path) {
      e.measure = Measure::sum;
      for (std::size_t i = 1; i < s.path.size(); ++i)
        e.reference += assembled_distance(s.path[i - 1], s.path[i]);
    } else if (s.on == On::velocity) {
      e.measure = Measure::velocity;
      e.frame_b = c_.frame_of_spec[s.frame_b];
    } else {
      e.frame_a = c_.frame_of_spec[s.frame_a];
      e.frame_b = c_.frame_of_spec[s.frame_b];
      const spec::Pose a = global_pose(s.frame_a), b = global_pose(s.frame_b);
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
    e.law = find_law(s.law);
    e.spec = k;
    e.marked = true;
    e.numbers = add_numbers(s.numbers);
    add_derived(e, s.numbers);
    const LawInfo& law = law_info(e.law);
    if (const double inertia = law.inertia ? law.inertia(s.numbers) : 0; inertia > 0)
      e.inertia = add_numbers({inertia});
    for (const MaxwellNumbers& branch : branch_numbers(s)) add_numbers(branch);
    if (!s.functions.empty()) e.functions = add_functions(s.functions);
    e.formula = add_formula(c_, s.general);
    e.argument_count = static_cast<int>(s.arguments.size());
    e.arguments = static_cast<int>(c_.arguments.size());
    for (const spec::Source& source : s.arguments) add_argument(c_, slot_of(c_, source));
    e.user = s.user != nullptr;
    e.sampled = s.user && s.user->sampled;
    e.elastic = s.user && s.user->elastic;
    e.state_count += law.states;
    if (!s.branches.empty()) e.state_count += 6 * (1 + static_cast<int>(s.branches.size()));
    if (s.user) e.state_count += static_cast<int>(s.user->states.size()) + (s.user->sampled ? e.count : 0);
    if (law.given && !s.arguments.empty()) {
      const int slot = c_.arguments[e.arguments];
      if (slot >= c_.signals.first_moving) e.feedback = slot;
    }
    const int first =
        static_cast<int>(c_.states.size()) + e.own_states + (s.user && s.user->sampled ? e.count : 0);
    if (s.user) pending_states_.push_back({first, s.user->states});
    return e;
  }

  using MaxwellNumbers = std::vector<double>;
  static std::vector<MaxwellNumbers> branch_numbers(const spec::Element& s) {
    std::vector<MaxwellNumbers> all;
    for (const spec::MaxwellBranch& branch : s.branches) {
      MaxwellNumbers numbers;
      for (int r = 0; r < 6; ++r)
        for (int k = 0; k < 6; ++k) numbers.push_back(branch.stiffness(r, k));
      numbers.push_back(branch.relaxation);
      all.push_back(std::move(numbers));
    }
    return all;
  }

  int add_numbers(const std::vector<double>& numbers) {
    const int first = static_cast<int>(c_.numbers.size());
    c_.numbers.append(numbers.begin(), numbers.end());
    return first;
  }
  /// The numbers that follow from those given.
  void add_derived(const ElementData& e, const std::vector<double>& given) {
    std::vector<double> behind;
    if (const auto derived = law_info(e.law).derived) derived(given, e.reference, behind);
    add_numbers(behind);
  }
  int add_functions(const std::vector<Function>& functions) {
    const int first = static_cast<int>(c_.functions.size());
    for (const Function& f : functions) c_.functions.push_back(f.data());
    return first;
  }

  /// Any frame that no coordinate moves: the parent side of a tree joint on the ground.
  int ground_frame() const {
    for (const BodyData& b : c_.bodies)
      if (b.parent < 0) return b.inboard_frame;
    return 0;
  }

  /// Of a frame in the assembled position.
  spec::Pose global_pose(int frame) const {
    const spec::Frame& f = spec_.frames[frame];
    if (f.body < 0) return f.pose;
    const spec::Pose& body = spec_.bodies[f.body].pose;
    return {body.position + body.rotation * f.pose.position, body.rotation * f.pose.rotation};
  }
  double assembled_distance(int frame_a, int frame_b) const {
    return (global_pose(frame_b).position - global_pose(frame_a).position).norm();
  }

  void loops_and_drives() {
    for (int k : topology_.cut_joints) {
      const spec::Joint& j = spec_.joints[k];
      LoopData loop;
      loop.joint_spec = k;
      loop.frame_a = c_.frame_of_spec[j.frame_a];
      loop.frame_b = c_.frame_of_spec[j.frame_b];
      loop.first_equation = c_.equations;
      loop.count = joint_info(j.type).equations;
      const auto& closure = joint_info(j.type).closure;
      loop.closure.assign(closure.begin(), closure.begin() + loop.count);
      loop.path = make_path(loop.frame_a, loop.frame_b);
      loop.jacobian = add_jacobian(loop.path, loop.count);
      c_.equations += loop.count;
      c_.loops.push_back(std::move(loop));
    }
    for (int b = 0; b < static_cast<int>(c_.bodies.size()); ++b) {
      const BodyData& body = c_.bodies[b];
      const auto& drives = spec_.joints[body.joint_spec].drives;
      for (int k = 0; k < static_cast<int>(drives.size()); ++k) {
        const int coordinate = drives[k].coordinate;
        c_.drives.push_back({body.joint_spec, b, body.q + coordinate, body.v + coordinate, c_.equations++,
                             coordinate, drive_slot(c_, body.joint_spec, k), 1.0});
      }
    }
    for (int k = 0; k < static_cast<int>(spec_.constraints.size()); ++k) add_constraint(k);
  }

  void add_constraint(int k) {
    const spec::Constraint& s = spec_.constraints[k];
    const ConstraintInfo& info = constraint_info(s.kind);
    ConstraintData c;
    c.spec = k;
    c.kind = s.kind;
    c.first_equation = c_.equations;
    c.count = info.equations;
    c.lengths = info.lengths;
    c.state_count = info.states;
    switch (s.kind) {
      case spec::Constraint::Kind::coupling:
        couple(s, c);
        break;
      case spec::Constraint::Kind::distance:
        c.constant = s.length;
        break;
      case spec::Constraint::Kind::screw:
        c.constant = s.lead / (2 * std::numbers::pi);
        break;
      case spec::Constraint::Kind::on_curve:
        c.curve = space_curve(s.points, s.closed);
        break;
      default:
        break;
    }
    if (c.terms.empty()) {
      ConstraintTerm term;
      term.frame_a = c_.frame_of_spec[s.frame_a];
      term.frame_b = c_.frame_of_spec[s.frame_b];
      c.terms.push_back(term);
    }
    find_paths(c);
    c.jacobian = add_jacobian(c.path, c.count);
    c.covectors = c_.constraint_covectors;
    c_.constraint_covectors += c.count * static_cast<int>(c.terms.size());
    c.states = static_cast<int>(c_.states.size());
    c.next_states = c_.constraint_states;
    c_.constraint_states += c.state_count;
    c_.states.resize(c_.states.size() + c.state_count, 0.0);
    if (s.kind == spec::Constraint::Kind::on_curve) {
      const spec::Pose a = global_pose(s.frame_a);
      c_.states[c.states] =
          nearest_on(c.curve, a.rotation.transpose() * (global_pose(s.frame_b).position - a.position));
    }
    c_.equations += c.count;
    c_.constraints.push_back(std::move(c));
  }

  /// The coordinates of a coupling, so that the equation is a length or an angle whatever multiple of it is
  /// given: the largest factor of a length, or where there is none of an angle, is 1.
  void couple(const spec::Constraint& s, ConstraintData& c) {
    double largest[2] = {0, 0};  // of angles, of lengths
    for (const spec::Constraint::Term& given : s.terms) {
      const ElementData on = on_coordinate(given.joint, given.coordinate);
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
    c.constant = s.constant / unit;
    c.lengths = largest[1] > 0 ? 1 : 0;
  }

  /// The bodies that any of a constraint's terms moves, and where each term finds them.
  void find_paths(ConstraintData& c) const {
    std::map<int, PathEntry, std::greater<>> entries;
    for (ConstraintTerm& term : c.terms) {
      if (term.body >= 0) {
        entries[term.body].body = term.body;
        continue;
      }
      term.path = make_path(term.frame_a, term.frame_b);
      for (const PathEntry& e : term.path.entries) entries[e.body].body = e.body;
    }
    for (auto& [body, e] : entries) {
      append(e, c.path);
    }
    for (ConstraintTerm& term : c.terms)
      for (PathEntry& e : term.path.entries) e.offset = entries[e.body].offset;
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
    for (const auto& c : c_.constraints) couple(c.path);
    for (const auto& e : c_.elements) couple(e.path);
    for (const auto& swarm : c_.swarms)
      for (const SwarmSphere& sphere : swarm.spheres) couple(sphere.path);
    c_.symbolic = linalg::BlockSymbolic(pattern);

    const auto find_places = [&](Path& path) {
      for (std::size_t i = 0; i < path.entries.size(); ++i)
        for (std::size_t j = 0; j <= i; ++j)
          path.places.push_back(c_.symbolic.place(path.entries[i].body, path.entries[j].body));
    };
    for (auto& l : c_.loops) find_places(l.path);
    for (auto& c : c_.constraints) find_places(c.path);
    for (auto& e : c_.elements) find_places(e.path);
    for (auto& swarm : c_.swarms)
      for (SwarmSphere& sphere : swarm.spheres) find_places(sphere.path);
    c_.mass_places.resize(c_.bodies.size());
    for (int b = 0; b < static_cast<int>(c_.bodies.size()); ++b) {
      c_.diagonal.push_back(c_.symbolic.place(b, b));
      for (int frame = c_.bodies[b].inboard_frame; c_.frames[frame].body >= 0;
           frame = c_.bodies[c_.frames[frame].body].inboard_frame) {
        const int a = c_.frames[frame].body;
        c_.mass_places[b].push_back({a, c_.frames[frame].subspace, c_.symbolic.place(a, b)});
      }
    }
  }

  spec::Model& spec_;
  Compiled c_;
  Topology topology_;
  ContactPairs pairs_;
  std::vector<std::pair<int, std::vector<double>>> pending_states_;  ///< of user laws: where, what
};

}  // namespace

Model::Model(spec::Model model) : spec_(std::move(model)), image_(Compiler(spec_).run()) {}
Model::~Model() = default;

std::shared_ptr<const Model> Model::compile(spec::Model model) {
  check_spec(model);
  return std::shared_ptr<const Model>(new Model(std::move(model)));
}

const Compiled& Model::compiled() const { return image_->model(); }
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
