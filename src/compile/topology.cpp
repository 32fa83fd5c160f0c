#include "compile/topology.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <tuple>

#include "joints/joint_kind.h"
#include "mimbre/reduced_body.h"

namespace mimbre {
namespace {

using spec::Joint;

bool must_stay(const Joint& joint) {
  const auto given = [](const auto& values) {
    return std::any_of(values.begin(), values.end(), [](const auto& v) { return v.has_value(); });
  };
  return joint.cut == Joint::Cut::never || !joint.drives.empty() || given(joint.initial_position) ||
         given(joint.initial_velocity) || given(joint.near);
}

int body_a(const spec::Model& m, const Joint& j) { return m.frames[j.frame_a].body; }
int body_b(const spec::Model& m, const Joint& j) { return m.frames[j.frame_b].body; }

/// Bodies that no chain of joints (cut: always aside) leads to the ground get a floating joint, the heaviest
/// first.
void float_loose_bodies(spec::Model& model) {
  const int n = static_cast<int>(model.bodies.size());
  std::vector<int> group(n + 1);
  for (int i = 0; i <= n; ++i) group[i] = i;
  const auto root = [&](int i) {
    while (group[i] != i) i = group[i] = group[group[i]];
    return i;
  };
  for (const Joint& j : model.joints)
    if (j.cut != Joint::Cut::always) group[root(body_a(model, j) + 1)] = root(body_b(model, j) + 1);
  const auto mass = [&](int b) {
    return model.bodies[b].flexible ? model.bodies[b].flexible->mass : model.bodies[b].mass;
  };
  for (int b = 0; b < n; ++b) {
    if (root(b + 1) == root(0)) continue;
    int heaviest = b;
    for (int k = b + 1; k < n; ++k)
      if (root(k + 1) == root(b + 1) && mass(k) > mass(heaviest)) heaviest = k;
    const spec::Body& body = model.bodies[heaviest];
    spec::Frame on_ground{body.name + ".floating.a", body.mark, spec::ground, body.pose, -1};
    spec::Frame on_body{body.name + ".floating.b", body.mark, heaviest, {}, -1};
    Joint joint;
    joint.name = body.name + ".floating";
    joint.mark = body.mark;
    joint.type = spec::JointType::floating;
    joint.frame_a = static_cast<int>(model.frames.size());
    joint.frame_b = joint.frame_a + 1;
    model.frames.push_back(on_ground);
    model.frames.push_back(on_body);
    model.joints.push_back(joint);
    group[root(heaviest + 1)] = root(0);
  }
}

/// True when the modes do not move the frame: a good place for a body's own (input) joint.
bool undeformed(const spec::Model& m, int frame) {
  const spec::Frame& f = m.frames[frame];
  if (f.body < 0 || !m.bodies[f.body].flexible || f.flexible_frame < 0) return true;
  return m.bodies[f.body].flexible->frames[f.flexible_frame].X.isZero();
}

/// A tree by Prim's algorithm from the ground. Joints with springs count like those that must stay, or, where
/// `yielding`, come after them. Nothing, and errors, where a joint that must stay would be cut.
std::optional<Topology> grow_tree(const spec::Model& model, bool yielding, std::vector<Diagnostic>& errors) {
  const auto rank = [&](const Joint& j) {
    if (must_stay(j)) return 0;
    return j.springs.empty() ? 2 : yielding ? 1 : 0;
  };
  const int n = static_cast<int>(model.bodies.size());
  const int nj = static_cast<int>(model.joints.size());
  std::vector<int> depth(n, -1), parent(n, -1), parent_joint(n, -1);
  std::vector<bool> in_tree(nj, false);

  const auto reached = [&](int body) { return body < 0 || depth[body] >= 0; };
  for (int step = 0; step < n; ++step) {
    int best = -1;
    std::tuple<int, int, int, int, int> best_key;
    for (int k = 0; k < nj; ++k) {
      const Joint& j = model.joints[k];
      if (j.cut == Joint::Cut::always) continue;
      const int a = body_a(model, j), b = body_b(model, j);
      if (reached(a) == reached(b)) continue;
      const int from = reached(a) ? a : b;
      const int child_frame = reached(a) ? j.frame_b : j.frame_a;
      const std::tuple key{rank(j), undeformed(model, child_frame) ? 0 : 1, -joint_info(j.type).equations,
                           from < 0 ? 0 : depth[from] + 1, k};
      if (best < 0 || key < best_key) best = k, best_key = key;
    }
    if (best < 0) break;
    const Joint& j = model.joints[best];
    const int a = body_a(model, j), b = body_b(model, j);
    const int from = reached(a) ? a : b, to = reached(a) ? b : a;
    depth[to] = from < 0 ? 0 : depth[from] + 1;
    parent[to] = from;
    parent_joint[to] = best;
    in_tree[best] = true;
  }

  Topology topology;
  errors.clear();
  for (int k = 0; k < nj; ++k) {
    if (in_tree[k]) continue;
    const Joint& j = model.joints[k];
    if (must_stay(j))
      errors.push_back(
          {j.mark, fmt::format("joint '{}' closes a loop, so it is cut and can have no drive, "
                               "initial value or `cut: never`; give them to another joint of the loop, "
                               "or cut another one with `cut: always`",
                               j.name)});
    if (!joint_info(j.type).free()) topology.cut_joints.push_back(k);
  }
  if (!errors.empty()) return {};

  // Depth first from the ground, children in the order of their joints.
  std::vector<std::vector<int>> children(n + 1);
  for (int k = 0; k < nj; ++k)
    for (int b = 0; b < n; ++b)
      if (parent_joint[b] == k) children[parent[b] + 1].push_back(b);
  std::vector<int> stack(children[0].rbegin(), children[0].rend());
  while (!stack.empty()) {
    const int b = stack.back();
    stack.pop_back();
    const int k = parent_joint[b];
    topology.branches.push_back({b, parent[b], k, body_a(model, model.joints[k]) == b});
    stack.insert(stack.end(), children[b + 1].rbegin(), children[b + 1].rend());
  }
  return topology;
}

}  // namespace

Topology find_topology(spec::Model& model) {
  float_loose_bodies(model);
  std::vector<Diagnostic> errors;
  std::optional<Topology> topology = grow_tree(model, false, errors);
  if (!topology) topology = grow_tree(model, true, errors);
  if (!topology) throw InputError(errors);
  return *std::move(topology);
}

}  // namespace mimbre
