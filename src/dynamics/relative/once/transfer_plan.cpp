#include "dynamics/relative/once/transfer_plan.h"

#include <functional>
#include <map>
#include <set>

#include "compile/by_bodies.h"

namespace mimbre::relative {
namespace {

std::vector<CoupledRows> find_coupled_rows(const Compiled& m, TransferPlan& plan) {
  std::vector<CoupledRows> all;
  for_rows(m, [&](const EquationRows& e) {
    if (!e.path.entries.empty()) all.push_back({&e.path, e.count, e.jacobian, -1, e.first_equation});
  });
  for (int k = 0; k < static_cast<int>(m.elements.size()); ++k) {
    const ElementData& e = m.elements[k];
    if (e.body >= 0 || e.path.entries.empty() || e.pooled) continue;
    if (e.leg) {
      plan.legs.push_back(k);
      continue;
    }
    if (const auto on = acts_on_body(e, m); on && on->carried)
      plan.grounded.push_back({k, on->body, on->plus >= 0 ? on->plus : on->minus});
    else
      all.push_back({&e.path, e.count, e.jacobian, k, -1});
  }
  return all;
}

/// Bodies from those of the path on towards the ground until they meet, the farthest ones first: calls
/// `passed` with each whose joint lies on the way. Returns where they meet; −1: the ground.
int meet(const Compiled& m, const Path& path, const std::function<void(int body)>& passed) {
  std::set<int> front;
  for (const PathEntry& e : path.entries) front.insert(e.body);
  while (front.size() > 1) {
    const int body = *front.rbegin();
    front.erase(body);
    passed(body);
    front.insert(m.bodies[body].parent);
  }
  return *front.begin();
}

}  // namespace

TransferPlan::TransferPlan(const Compiled& m) : nodes(m.bodies.size() + 1) {
  const int ground = static_cast<int>(m.bodies.size());
  const auto node_of = [&](int body) { return body < 0 ? ground : body; };
  for (int i = 0; i < ground; ++i) {
    TransferNode& node = nodes[static_cast<std::size_t>(i)];
    node.parent = node_of(m.bodies[i].parent);
    node.coordinates = node.unknowns = m.bodies[i].size();
  }
  rows = find_coupled_rows(m, *this);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    CoupledRows& r = rows[k];
    r.scaled = scaled;
    r.signs = signs;
    scaled += static_cast<std::size_t>(r.count * r.path->width);
    signs += static_cast<std::size_t>(r.count);
    std::vector<int> passed;
    r.node = node_of(meet(m, *r.path, [&](int body) { passed.push_back(body); }));
    if (passed.empty()) continue;

    // Places of the forces in the node where they end, then outwards at every joint that they pass.
    TransferNode& last = nodes[static_cast<std::size_t>(r.node)];
    r.unknown = last.unknowns;
    last.unknowns += r.count;
    std::map<int, int> place{{r.node, -1 - r.unknown}};
    for (auto body = passed.rbegin(); body != passed.rend(); ++body) {
      TransferNode& node = nodes[static_cast<std::size_t>(*body)];
      const int above = place.at(node.parent);
      place[*body] = node.size;
      node.size += r.count;
      for (int c = 0; c < r.count; ++c) node.passes.push_back(above >= 0 ? above + c : above - c);
    }
    for (int e = 0; e < static_cast<int>(r.path->entries.size()); ++e) {
      const int body = r.path->entries[e].body;
      nodes[static_cast<std::size_t>(body)].moves.push_back({static_cast<int>(k), e, place.at(body)});
    }
  }
}

}  // namespace mimbre::relative
