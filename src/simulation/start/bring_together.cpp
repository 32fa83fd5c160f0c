#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

#include "integrate/initial.h"
#include "joints/table.h"
#include "math/once/decompositions.h"
#include "math/rotation.h"
#include "mimbre/assembly.h"
#include "simulation/start/assembly.h"
#include "spec/output_kind.h"

namespace mimbre {
namespace {

using Eigen::VectorXd;

constexpr double closed = 1e-8;           ///< of the equations' scales
constexpr double right_way_round = 1e-5;  ///< by which a cut joint's rotation may differ from one it can have
constexpr double same_place = 1e-5;       ///< of the mechanism's size
constexpr int most_coordinates = 200;     ///< of a model in which ways are searched
constexpr std::size_t most_ways = 32;

/// Numbers in [−1, 1), the same ones everywhere (splitmix64).
class RandomNumbers {
 public:
  double next() {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-52 - 1;
  }

 private:
  std::uint64_t state_ = 1;
};

/// A mechanism whose loops are to be closed.
struct LoopAssembly {
  explicit LoopAssembly(const Model& model)
      : m(model.compiled()), system(m), state(given_state(m, system, {}, weight, velocity_weight)) {
    // Flexible bodies are put together undeformed.
    for (const BodyData& b : m.bodies) weight.segment(b.v + b.joint_velocities, b.modes).setZero();
    system.enter(state.u.data(), state.z.data(), 0);
    loops.resize(m.loops.size());
    std::iota(loops.begin(), loops.end(), 0);
    system.begin_step(state.q.data());
    place(state.q);
    const auto& frames = system.workspace().frames;
    for (int k = 0; k < m.dynamic_frames; ++k)
      size = std::max(size, (frames[k].position - frames[0].position).norm());
    for (const LoopData& l : m.loops)
      size = std::max(size, (frames[l.frame_b].position - frames[l.frame_a].position).norm());
    if (!(size > 0)) size = m.length_scale;
  }

  void place(const VectorXd& q) {
    const VectorXd rest = VectorXd::Zero(m.velocities);
    system.kinematics(0, q.data(), rest.data(), rest.data());
  }

  /// Closes loops by the coordinates of these weights. Cut joints close the right way round: their
  /// equations alone also hold for axes that point the other way.
  bool close(const std::vector<int>& which, const VectorXd& weights, VectorXd& q) {
    close_positions(system, 0, weights, q);
    return std::all_of(which.begin(), which.end(), [&](int l) { return is_closed(m.loops[l]); });
  }

  bool is_closed(const LoopData& l) const {
    for (int k = l.first_equation; k < l.first_equation + l.count; ++k)
      if (!(std::abs(system.phi()[k]) <= closed * system.scales().equations[static_cast<std::size_t>(k)]))
        return false;
    if (l.joint_spec < 0) return true;
    const auto& frames = system.workspace().frames;
    const Motion<double>&a = frames[l.frame_a], &b = frames[l.frame_b];
    const spec::JointType type = m.spec().joints[static_cast<std::size_t>(l.joint_spec)].type;
    const Mat3d turned = a.rotation.transpose() * b.rotation;
    double coordinates[7];
    const double still[6] = {};
    joint_coordinates<double>(type, turned, a.rotation.transpose() * (b.position - a.position), coordinates);
    JointMotion<double> motion;
    joint_motion<double>(type, coordinates, still, motion);
    return (motion.rotation - turned).norm() < right_way_round;
  }

  /// Origins of all frames, one below the other.
  VectorXd places(const VectorXd& q) {
    place(q);
    VectorXd out(3 * m.dynamic_frames);
    for (int k = 0; k < m.dynamic_frames; ++k)
      out.segment<3>(3 * k) = system.workspace().frames[k].position + system.workspace().origin;
    return out;
  }

  /// q with the joint coordinates of these weights anywhere.
  VectorXd scattered(const VectorXd& q, const VectorXd& weights, RandomNumbers& random) const {
    VectorXd x = VectorXd::Zero(m.velocities), out(m.positions);
    for (const BodyData& b : m.bodies)
      for (int k = 0; k < b.joint_velocities; ++k)
        if (weights[b.v + k] > 0)
          x[b.v + k] = random.next() * (is_angle(b.joint, k) ? std::numbers::pi : size);
    system.retract(q.data(), x.data(), out.data());
    return out;
  }

  const Compiled& m;
  std::vector<int> loops;  ///< all
  relative::RelativeSystem system;
  VectorXd weight, velocity_weight;
  State state;
  double size = 0;  ///< m, of the mechanism as it is drawn
};

double within_a_turn(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

/// Value of a joint's velocity coordinate: of rotations by quaternions, component of the rotation vector.
double value_of(const BodyData& b, const VectorXd& q, int k) {
  const JointInfo& info = joint_info(b.joint);
  if (info.quaternion < 0 || k < info.rotation) {
    const double value = q[b.q + k];
    return is_angle(b.joint, k) ? within_a_turn(value) : value;
  }
  const Eigen::Vector4d turn = q.segment<4>(b.q + info.quaternion);
  return quaternion_log<double>(turn)[k - info.rotation];
}

/// Loops that share coordinates.
struct Group {
  std::vector<int> loops;
  VectorXd weight;  ///< of the coordinates that may close them, otherwise 0
};

std::vector<Group> groups_of(const LoopAssembly& assembly) {
  const Compiled& m = assembly.m;
  std::vector<std::size_t> root(m.bodies.size());
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t k) {
    while (root[k] != k) k = root[k] = root[root[k]];
    return k;
  };
  const auto moves = [&](const PathEntry& e) {
    const BodyData& b = m.bodies[e.body];
    return (assembly.weight.segment(b.v, b.joint_velocities).array() > 0).any();
  };
  for (const LoopData& l : m.loops) {
    std::optional<std::size_t> first;
    for (const PathEntry& e : l.path.entries)
      if (moves(e)) {
        const auto here = find(static_cast<std::size_t>(e.body));
        if (first) root[here] = find(*first);
        first = find(here);
      }
  }
  std::vector<Group> groups;
  std::vector<int> group_of(m.bodies.size(), -1);
  for (std::size_t k = 0; k < m.loops.size(); ++k) {
    int group = -1;
    for (const PathEntry& e : m.loops[k].path.entries) {
      if (!moves(e)) continue;
      int& known = group_of[find(static_cast<std::size_t>(e.body))];
      if (known < 0) {
        known = static_cast<int>(groups.size());
        groups.push_back({{}, VectorXd::Zero(m.velocities)});
      }
      group = known;
      const BodyData& b = m.bodies[e.body];
      groups[static_cast<std::size_t>(group)].weight.segment(b.v, b.joint_velocities) =
          assembly.weight.segment(b.v, b.joint_velocities);
    }
    if (group >= 0) groups[static_cast<std::size_t>(group)].loops.push_back(static_cast<int>(k));
  }
  return groups;
}

int tries_for(const VectorXd& weight) { return 40 + 20 * static_cast<int>((weight.array() > 0).count()); }

/// How far q is from what the joints of a group are given as `near`, or without any from
/// where they were drawn.
class Distance {
 public:
  Distance(LoopAssembly& assembly, const Group& group, const VectorXd& q)
      : assembly_(assembly), start_(assembly.places(q)) {
    for (const BodyData& b : assembly.m.bodies) {
      const auto number = static_cast<std::size_t>(b.joint_spec);
      if (b.joint_spec < 0 || number >= assembly.m.spec().joints.size()) continue;
      const auto& near = assembly.m.spec().joints[number].near;
      for (int k = 0; k < static_cast<int>(near.size()); ++k)
        if (near[static_cast<std::size_t>(k)] && group.weight[b.v + k] > 0)
          wishes_.push_back({&b, k, *near[static_cast<std::size_t>(k)]});
    }
  }

  bool wished() const { return !wishes_.empty(); }

  double of(const VectorXd& q) const {
    if (wishes_.empty()) return (assembly_.places(q) - start_).norm();
    double sum = 0;
    for (const Wish& w : wishes_) {
      const double off = value_of(*w.body, q, w.coordinate) - w.value;
      sum += std::abs(is_angle(w.body->joint, w.coordinate) ? within_a_turn(off) : off / assembly_.size);
    }
    return sum;
  }

 private:
  struct Wish {
    const BodyData* body;
    int coordinate;
    double value;
  };
  LoopAssembly& assembly_;
  VectorXd start_;
  std::vector<Wish> wishes_;
};

/// Of the positions that close all loops the one nearest to what is wished, or one near q. Groups are closed
/// one by one, so that each search has few coordinates.
bool find_closed(LoopAssembly& assembly, VectorXd& q) {
  RandomNumbers random;
  for (const Group& group : groups_of(assembly)) {
    const Distance distance(assembly, group, q);
    double nearest = std::numeric_limits<double>::infinity();
    VectorXd found = q;
    const int tries = assembly.m.velocities > most_coordinates ? 1 : tries_for(group.weight);
    for (int k = 0; k < tries; ++k) {
      VectorXd tried = k == 0 ? q : assembly.scattered(q, group.weight, random);
      if (!assembly.close(group.loops, group.weight, tried)) continue;
      const double way = distance.of(tried);
      if (way < nearest) {
        nearest = way;
        found = tried;
      }
      if (k == 0 && !distance.wished()) break;
    }
    if (!std::isfinite(nearest)) return false;
    q = found;
  }
  return assembly.close(assembly.loops, assembly.weight, q);
}

/// Weights of the coordinates that the others of the group decide: those near the ground stay.
VectorXd dependent(LoopAssembly& assembly, const Group& group, const VectorXd& q) {
  // By the scales of coordinates and equations, so that lengths and angles compare.
  const Scales& scales = assembly.system.scales();
  Eigen::MatrixXd jacobian = dense_jacobian(assembly.system, 0, q);
  for (Eigen::Index k = 0; k < jacobian.cols(); ++k)
    for (Eigen::Index r = 0; r < jacobian.rows(); ++r)
      jacobian(r, k) *=
          scales.coordinates[static_cast<std::size_t>(k)] / scales.equations[static_cast<std::size_t>(r)];
  std::vector<int> columns;
  for (int k = static_cast<int>(group.weight.size()) - 1; k >= 0; --k)
    if (group.weight[k] > 0) columns.push_back(k);
  VectorXd weight = VectorXd::Zero(group.weight.size());
  // Gram and Schmidt, from the leaves on.
  Eigen::MatrixXd basis(jacobian.rows(), 0);
  for (const int k : columns) {
    VectorXd rest = jacobian.col(k);
    const double length = rest.norm();
    for (int round = 0; round < 2; ++round) rest -= basis * (basis.transpose() * rest);
    if (!(rest.norm() > 1e-6 * std::max(length, 1e-6))) continue;
    weight[k] = group.weight[k];
    basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
    basis.rightCols<1>() = rest.normalized();
  }
  return weight;
}

}  // namespace

namespace {

spec::Pose placed(const spec::Model& model, int frame) {
  const spec::Frame& f = model.frames[static_cast<std::size_t>(frame)];
  if (f.body == spec::ground) return f.pose;
  const spec::Pose& body = model.bodies[static_cast<std::size_t>(f.body)].pose;
  return {body.position + body.rotation * f.pose.position, body.rotation * f.pose.rotation};
}

/// What a displacement is counted from: the place in the assembled position.
double assembled_place(const spec::Model& model, const spec::Output& o) {
  const spec::Pose here = placed(model, o.item), from = placed(model, o.reference);
  return o.direction.dot(from.rotation.transpose() * (here.position - from.position));
}

}  // namespace

spec::Model brought_together(spec::Model model) {
  if (std::none_of(model.joints.begin(), model.joints.end(), [](const auto& j) { return j.apart; }))
    return model;
  const std::shared_ptr<const Model> compiled = Model::compile(model);
  LoopAssembly assembly(*compiled);
  VectorXd q = assembly.state.q;
  if (!find_closed(assembly, q)) return model;
  const auto shift_offsets = [&](double sign) {
    for (auto* outputs : {&model.outputs, &model.sensors})
      for (spec::Output& o : *outputs)
        if (output_info(o).reference) o.offset += sign * assembled_place(model, o);
  };
  shift_offsets(1);
  assembly.place(q);
  const auto& workspace = assembly.system.workspace();
  for (std::size_t k = 0; k < assembly.m.bodies.size(); ++k) {
    const BodyData& b = assembly.m.bodies[k];
    const Motion<double>& motion = workspace.bodies[k];
    model.bodies[static_cast<std::size_t>(b.spec)].pose = {motion.position + workspace.origin,
                                                           motion.rotation};
    if (b.joint_spec < 0 || static_cast<std::size_t>(b.joint_spec) >= model.joints.size()) continue;
    spec::Joint& joint = model.joints[static_cast<std::size_t>(b.joint_spec)];
    joint.near.resize(static_cast<std::size_t>(b.joint_velocities));
    for (int i = 0; i < b.joint_velocities; ++i) joint.near[static_cast<std::size_t>(i)] = value_of(b, q, i);
  }
  shift_offsets(-1);
  return model;
}

std::vector<AssemblyChoice> assembly_choices(const Model& model) {
  const std::vector<spec::Joint>& joints = model.spec().joints;
  std::vector<AssemblyChoice> choices;
  if (std::none_of(joints.begin(), joints.end(), [](const auto& j) { return j.apart; })) return choices;
  LoopAssembly assembly(model);
  VectorXd q = assembly.state.q;
  if (assembly.m.velocities > most_coordinates || !assembly.close(assembly.loops, assembly.weight, q))
    return choices;
  RandomNumbers random;
  for (const Group& group : groups_of(assembly)) {
    const VectorXd weight = dependent(assembly, group, q);
    std::vector<VectorXd> ways{q}, places{assembly.places(q)};
    for (int k = 0; k < tries_for(weight) && ways.size() < most_ways; ++k) {
      VectorXd tried = assembly.scattered(q, weight, random);
      if (!assembly.close(assembly.loops, weight, tried)) continue;
      const VectorXd there = assembly.places(tried);
      if (std::any_of(places.begin(), places.end(), [&](const VectorXd& known) {
            return (known - there).lpNorm<Eigen::Infinity>() < same_place * assembly.size;
          }))
        continue;
      ways.push_back(std::move(tried));
      places.push_back(there);
    }
    if (ways.size() == 1) continue;
    AssemblyChoice choice;
    for (const int l : group.loops)
      if (assembly.m.loops[l].joint_spec >= 0)
        choice.loops.push_back(joints[static_cast<std::size_t>(assembly.m.loops[l].joint_spec)].name);
    choice.ways.resize(ways.size());
    for (const BodyData& b : assembly.m.bodies)
      for (int k = 0; k < b.joint_velocities; ++k) {
        if (!(weight[b.v + k] > 0)) continue;
        choice.coordinates.push_back(
            {joints[static_cast<std::size_t>(b.joint_spec)].name, k, is_angle(b.joint, k)});
        for (std::size_t w = 0; w < ways.size(); ++w) choice.ways[w].push_back(value_of(b, ways[w], k));
      }
    choices.push_back(std::move(choice));
  }
  return choices;
}

}  // namespace mimbre
