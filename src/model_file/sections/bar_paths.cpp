#include "model_file/sections/bar_paths.h"

#include <algorithm>

namespace mimbre::model_file {
namespace {

std::size_t at(int k) { return static_cast<std::size_t>(k); }

struct BarWalk {
  explicit BarWalk(const fe::Mesh& of)
      : mesh(of), elements_at(at(static_cast<int>(of.nodes.cols()))), reached(elements_at.size(), false) {
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
      for (const int node : mesh.elements[e].nodes) elements_at[at(node)].push_back(static_cast<int>(e));
    used.assign(mesh.elements.size(), false);
  }

  /// From `node` along `element` to where the bars end, branch or have been reached before.
  BarPath follow(int node, int element, int before) {
    BarPath path{{node}, {}, before};
    for (;;) {
      used[at(element)] = true;
      const auto& ends = mesh.elements[at(element)].nodes;
      node = ends[0] == node ? ends[1] : ends[0];
      path.elements.push_back(element);
      path.nodes.push_back(node);
      path.closes = reached[at(node)];
      reached[at(node)] = true;
      const auto& here = elements_at[at(node)];
      path.free_end = here.size() == 1;
      if (path.closes || here.size() != 2) return path;
      element = here.front() == element ? here.back() : here.front();
    }
  }

  const fe::Mesh& mesh;
  std::vector<std::vector<int>> elements_at;
  std::vector<bool> reached, used;
};

}  // namespace

std::vector<BarPath> bar_paths(const fe::Mesh& mesh, int start) {
  struct Begin {
    int node, element, before;
  };
  BarWalk walk(mesh);
  std::vector<BarPath> paths;
  std::vector<Begin> waiting;
  const auto wait_at = [&](int node, int before) {
    const auto& here = walk.elements_at[at(node)];
    for (auto e = here.rbegin(); e != here.rend(); ++e)
      if (!walk.used[at(*e)]) waiting.push_back({node, *e, before});
  };
  walk.reached[at(start)] = true;
  wait_at(start, -1);
  while (!waiting.empty()) {
    const Begin begin = waiting.back();
    waiting.pop_back();
    if (walk.used[at(begin.element)]) continue;  // a loop has come back along it
    paths.push_back(walk.follow(begin.node, begin.element, begin.before));
    if (!paths.back().closes) wait_at(paths.back().nodes.back(), static_cast<int>(paths.size()) - 1);
  }
  return paths;
}

std::vector<int> share_pieces(const std::vector<BarPath>& paths, int count) {
  std::vector<int> shares(paths.size(), 1);
  for (int k = static_cast<int>(paths.size()); k < count; ++k) {
    std::size_t longest = 0;
    const auto elements = [&](std::size_t p) { return static_cast<long>(paths[p].elements.size()); };
    for (std::size_t p = 1; p < paths.size(); ++p)
      if (elements(p) * shares[longest] > elements(longest) * shares[p]) longest = p;
    ++shares[longest];
  }
  return shares;
}

}  // namespace mimbre::model_file
