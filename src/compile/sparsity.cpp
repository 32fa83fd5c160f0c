#include "compile/by_bodies.h"
#include "compile/compile_parts.h"

namespace mimbre {

void compile_sparsity(Compiled& c) {
  if (is_eliminated_by_bodies(c)) return;
  linalg::BlockPattern pattern;
  for (int b = 0; b < static_cast<int>(c.bodies.size()); ++b) {
    pattern.sizes.push_back(c.bodies[b].size());
    for (int a = c.bodies[b].parent; a >= 0; a = c.bodies[a].parent) pattern.couplings.push_back({a, b});
  }
  const auto couple = [&](const Path& path) {
    for (const PathEntry& e : path.entries)
      for (const PathEntry& f : path.entries) pattern.couplings.push_back({e.body, f.body});
  };
  for (const auto& l : c.loops) couple(l.path);
  for (const auto& k : c.constraints) couple(k.path);
  for (const auto& e : c.elements) couple(e.path);
  for (const auto& swarm : c.swarms)
    for (const SwarmSphere& sphere : swarm.spheres) couple(sphere.path);
  c.symbolic = linalg::BlockSymbolic(pattern);

  const auto find_places = [&](Path& path) {
    for (std::size_t i = 0; i < path.entries.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j)
        path.places.push_back(c.symbolic.place(path.entries[i].body, path.entries[j].body));
  };
  for (auto& l : c.loops) find_places(l.path);
  for (auto& k : c.constraints) find_places(k.path);
  for (auto& e : c.elements) find_places(e.path);
  for (auto& swarm : c.swarms)
    for (SwarmSphere& sphere : swarm.spheres) find_places(sphere.path);
  c.mass_places.resize(c.bodies.size());
  for (int b = 0; b < static_cast<int>(c.bodies.size()); ++b) {
    c.diagonal.push_back(c.symbolic.place(b, b));
    for (int frame = c.bodies[b].inboard_frame; c.frames[frame].body >= 0;
         frame = c.bodies[c.frames[frame].body].inboard_frame) {
      const int a = c.frames[frame].body;
      c.mass_places[b].push_back({a, c.frames[frame].subspace, c.symbolic.place(a, b)});
    }
  }
}

}  // namespace mimbre
