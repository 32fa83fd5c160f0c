#include "compile/topology.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <queue>
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
  std::vector<int> heaviest_of(n + 1, -1);  // of each group, by its root
  for (int b = 0; b < n; ++b) {
    int& heaviest = heaviest_of[root(b + 1)];
    if (heaviest < 0 || mass(b) > mass(heaviest)) heaviest = b;
  }
  for (int b = 0; b < n; ++b) {
    if (root(b + 1) == root(0)) continue;
    const int heaviest = heaviest_of[root(b + 1)];
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

/// Joints that can lead from the ground, at 0, and from each body, by its number plus one, in their order.
std::vector<std::vector<int>> joints_by_body(const spec::Model& model) {
  std::vector<std::vector<int>> joints(model.bodies.size() + 1);
  for (int k = 0; k < static_cast<int>(model.joints.size()); ++k) {
    const Joint& j = model.joints[k];
    if (j.cut == Joint::Cut::always) continue;
    for (const int body : {body_a(model, j), body_b(model, j)}) joints[body + 1].push_back(k);
  }
  return joints;
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
  // Joints that lead on from a body that is reached, best first; some lead to one that is reached meanwhile.
  using Key = std::tuple<int, int, int, int, int>;
  std::priority_queue<Key, std::vector<Key>, std::greater<>> candidates;
  const std::vector<std::vector<int>> joints_of = joints_by_body(model);
  const auto reach = [&](int from) {
    for (const int k : joints_of[from + 1]) {
      const Joint& j = model.joints[k];
      const int a = body_a(model, j), b = body_b(model, j);
      if (reached(a == from ? b : a)) continue;
      const int child_frame = a == from ? j.frame_b : j.frame_a;
      candidates.push({rank(j), undeformed(model, child_frame) ? 0 : 1, -joint_info(j.type).equations,
                       from < 0 ? 0 : depth[from] + 1, k});
    }
  };
  reach(-1);
  while (!candidates.empty()) {
    const int best = std::get<4>(candidates.top());
    candidates.pop();
    const Joint& j = model.joints[best];
    const int a = body_a(model, j), b = body_b(model, j);
    if (reached(a) && reached(b)) continue;
    const int from = reached(a) ? a : b, to = reached(a) ? b : a;
    depth[to] = from < 0 ? 0 : depth[from] + 1;
    parent[to] = from;
    parent_joint[to] = best;
    in_tree[best] = true;
    reach(to);
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
  std::vector<int> outer_body(nj, -1);
  for (int b = 0; b < n; ++b)
    if (parent_joint[b] >= 0) outer_body[parent_joint[b]] = b;
  std::vector<std::vector<int>> children(n + 1);
  for (const int b : outer_body)
    if (b >= 0) children[parent[b] + 1].push_back(b);
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
