#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <stdexcept>
#include <string>

#include "linalg/block_sparse.h"

namespace mimbre::linalg {
namespace {

int rounded_up(int n, int unit = kLanes) { return (n + unit - 1) / unit * unit; }

/// Columns of L that make one panel. `below` holds the blocks of the other rows.
struct Supernode {
  std::vector<int> blocks;
  std::vector<int> below;  ///< ascending
  int columns = 0;
  int rows_below = 0;
};

int total(const std::vector<int>& blocks, const std::vector<int>& sizes) {
  int sum = 0;
  for (int block : blocks) sum += sizes[block];
  return sum;
}

/// Eliminates the blocks that are not empty, always one with the least degree (unknowns it is coupled with);
/// of equals the last. Returns them in order, each with the later blocks it is coupled with by then (fill
/// included). `neighbours`: ascending.
std::vector<Supernode> eliminate(const std::vector<int>& sizes, std::vector<std::vector<int>> neighbours) {
  std::set<std::pair<int, int>> queue;  // (degree, -block)
  std::vector<int> degree(sizes.size()), seen_by(sizes.size(), -1), merged;
  std::size_t ends = 0;  // of couplings, twice their number
  for (int block = 0; block < static_cast<int>(sizes.size()); ++block) {
    degree[block] = total(neighbours[block], sizes);
    if (sizes[block] > 0) queue.emplace(degree[block], -block);
    ends += neighbours[block].size();
  }
  std::vector<Supernode> result;
  // In a long chain all blocks are coupled with all, and so are those that are left of any mechanism in the
  // end: then nothing fills in, and each elimination takes the same from all degrees.
  while (ends < queue.size() * (queue.size() - 1)) {
    const int block = -queue.begin()->second;
    queue.erase(queue.begin());
    std::vector<int> below = std::move(neighbours[block]);
    ends -= 2 * below.size();
    for (const int other : below) seen_by[other] = block;
    for (const int other : below) {
      std::vector<int>& its = neighbours[other];
      its.erase(std::lower_bound(its.begin(), its.end(), block));
      int now = degree[other] - sizes[block];
      const auto known = std::count_if(its.begin(), its.end(), [&](int i) { return seen_by[i] == block; });
      if (known + 1 < std::ssize(below)) {
        merged.clear();
        std::set_union(its.begin(), its.end(), below.begin(), below.end(), std::back_inserter(merged));
        merged.erase(std::lower_bound(merged.begin(), merged.end(), other));
        ends += merged.size() - its.size();
        its = merged;
        now = total(its, sizes);
      }
      queue.erase({degree[other], -other});
      degree[other] = now;
      queue.emplace(now, -other);
    }
    const int rows = total(below, sizes);
    result.push_back({{block}, std::move(below), sizes[block], rows});
  }
  std::vector<int> left;
  for (const auto& [of_degree, negative] : queue) left.push_back(-negative);
  std::sort(left.begin(), left.end());
  int rows = total(left, sizes);
  for (const auto& [of_degree, negative] : queue) {
    const int block = -negative;
    left.erase(std::lower_bound(left.begin(), left.end(), block));
    rows -= sizes[block];
    result.push_back({{block}, left, sizes[block], rows});
  }
  return result;
}

/// Estimated cycles of a panel: pivots one after the other, products on whole vectors, four columns at once.
double cost(int columns, int rows_below) {
  const int rows = rounded_up(rounded_up(columns, 4) + rows_below);
  double sum = 20 + 0.5 * rows * columns;  // the call, zeroing the panel
  for (int j = 0; j < columns; j += 4) {
    const int width = std::min(4, columns - j);
    const int vectors = (rows - j / kLanes * kLanes) / kLanes;
    sum += 20 + 20 * width + vectors * width * (0.5 * j + 2);
  }
  for (int j = 0; j < rows_below; j += 4) {
    const int vectors = rounded_up(rows_below - j / kLanes * kLanes) / kLanes;
    sum += 20 + vectors * std::min(4, rows_below - j) * (0.5 * columns + 2);
  }
  return sum;
}

/// Merges supernodes with their parents in the elimination tree where that saves time. Children precede
/// parents, before and after.
std::vector<Supernode> amalgamate(std::vector<Supernode> nodes, const std::vector<int>& sizes) {
  std::vector<int> node_of(sizes.size(), -1);
  for (int s = 0; s < static_cast<int>(nodes.size()); ++s) node_of[nodes[s].blocks.front()] = s;
  std::vector<std::vector<int>> children(nodes.size());
  for (int s = 0; s < static_cast<int>(nodes.size()); ++s) {
    Supernode& node = nodes[s];
    const auto gain = [&](int child) {
      const Supernode& c = nodes[child];
      return cost(c.columns, c.rows_below) + cost(node.columns, node.rows_below) -
             cost(c.columns + node.columns, node.rows_below);
    };
    while (!children[s].empty()) {
      const auto best = std::max_element(children[s].begin(), children[s].end(),
                                         [&](int a, int b) { return gain(a) < gain(b); });
      if (gain(*best) <= 0) break;
      Supernode child = std::move(nodes[*best]);
      nodes[*best] = {};
      const std::vector<int> adopted = std::move(children[*best]);
      children[s].erase(best);
      children[s].insert(children[s].end(), adopted.begin(), adopted.end());
      node.blocks.insert(node.blocks.begin(), child.blocks.begin(), child.blocks.end());
      node.columns += child.columns;
    }
    int parent = static_cast<int>(nodes.size());
    for (int block : node.below) parent = std::min(parent, node_of[block]);
    if (!node.below.empty()) children[parent].push_back(s);
  }
  std::erase_if(nodes, [](const Supernode& node) { return node.blocks.empty(); });
  return nodes;
}

/// The pattern's couplings, i >= j, diagonals included, sorted; and each block's neighbours among blocks that
/// are not empty, ascending.
struct Couplings {
  std::vector<std::pair<int, int>> pairs;
  std::vector<std::vector<int>> neighbours;
};

template <class T>
void sort_uniquely(std::vector<T>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

Couplings couplings_of(const BlockPattern& pattern) {
  const int count = static_cast<int>(pattern.sizes.size());
  Couplings result;
  result.neighbours.resize(pattern.sizes.size());
  for (int i = 0; i < count; ++i) result.pairs.emplace_back(i, i);
  for (const auto& [i, j] : pattern.couplings) {
    if (std::min(i, j) < 0 || std::max(i, j) >= count)
      throw std::invalid_argument("coupling of blocks " + std::to_string(i) + " and " + std::to_string(j) +
                                  " among " + std::to_string(count) + " blocks");
    result.pairs.emplace_back(std::max(i, j), std::min(i, j));
    if (i == j || pattern.sizes[i] == 0 || pattern.sizes[j] == 0) continue;
    result.neighbours[i].push_back(j);
    result.neighbours[j].push_back(i);
  }
  for (std::vector<int>& its : result.neighbours) sort_uniquely(its);
  sort_uniquely(result.pairs);
  return result;
}

/// Where blocks are among the panels and in them.
struct Layout {
  std::vector<int> position, panel_of;     ///< of a block: first column in the elimination order; panel
  std::vector<std::vector<int>> below;     ///< of a panel: blocks of the other rows, in that order
  std::vector<std::map<int, int>> row_of;  ///< of a panel: block → panel row
};

Layout layout_of(const std::vector<Supernode>& nodes, const std::vector<int>& sizes) {
  Layout l{std::vector<int>(sizes.size(), -1), std::vector<int>(sizes.size(), -1), {}, {}};
  int next = 0;
  for (const Supernode& node : nodes)
    for (int block : node.blocks) {
      l.panel_of[block] = static_cast<int>(&node - nodes.data());
      l.position[block] = next;
      next += sizes[block];
    }
  for (const Supernode& node : nodes) {
    l.below.emplace_back(node.below.begin(), node.below.end());
    std::sort(l.below.back().begin(), l.below.back().end(),
              [&](int a, int b) { return l.position[a] < l.position[b]; });
  }
  l.row_of.resize(nodes.size());
  return l;
}

/// Adds the updates by panel `s`: for every panel that owns some of its rows, the product in rectangles that
/// are contiguous there.
void add_updates(const Array<Panel>& panels, const Layout& l, const std::vector<int>& sizes, std::size_t s,
                 Array<PanelUpdate>& updates) {
  struct Run {
    int row, target_row, size;  // rows of the panel and of the target panel
  };
  const std::vector<int>& below = l.below[s];
  for (std::size_t first = 0, last = 0; first < below.size(); first = last) {
    const int t = l.panel_of[below[first]];
    while (last < below.size() && l.panel_of[below[last]] == t) ++last;
    std::vector<Run> runs;
    // All rows from there on: a panel has the later rows of the panels that update it.
    for (std::size_t b = first; b < below.size(); ++b) {
      const int block = below[b], target_row = l.row_of[t].at(block);
      if (!runs.empty() && runs.back().target_row + runs.back().size == target_row)
        runs.back().size += sizes[block];
      else
        runs.push_back({l.row_of[s].at(block), target_row, sizes[block]});
    }
    const Panel& target = panels[t];
    for (std::size_t c = 0; c < runs.size() && runs[c].target_row < target.columns; ++c) {
      const int columns = std::min(runs[c].size, target.columns - runs[c].target_row);
      for (std::size_t r = c; r < runs.size(); ++r)
        updates.push_back({target.offset + runs[r].target_row +
                               static_cast<std::ptrdiff_t>(target.stride) * runs[c].target_row,
                           target.stride, runs[r].row, runs[c].row, runs[r].size, columns});
    }
  }
}

}  // namespace

BlockSymbolic::BlockSymbolic(const BlockPattern& pattern) {
  for (int size : pattern.sizes) {
    if (size < 0) throw std::invalid_argument("a block has the negative size " + std::to_string(size));
    start_.push_back(start_.back() + size);
  }
  Couplings couplings = couplings_of(pattern);
  couplings_ = couplings.pairs;
  const std::vector<Supernode> nodes =
      amalgamate(eliminate(pattern.sizes, std::move(couplings.neighbours)), pattern.sizes);
  Layout l = layout_of(nodes, pattern.sizes);
  const auto append_unknowns = [&](int block, Array<int>& to) {
    for (int k = start_[block]; k < start_[block + 1]; ++k) to.push_back(k);
  };
  for (const Supernode& node : nodes)
    for (int block : node.blocks) append_unknowns(block, unknowns_);

  for (std::size_t s = 0; s < nodes.size(); ++s) {
    const Supernode& node = nodes[s];
    Panel panel;
    panel.offset = value_count_;
    panel.columns = node.columns;
    panel.first = l.position[node.blocks.front()];
    panel.first_row = static_cast<int>(rows_.size());
    panel.below = rounded_up(node.columns, 4);
    panel.stride = rounded_up(panel.below + node.rows_below);
    // Where that costs no storage, the other rows start with a whole vector.
    const int aligned = rounded_up(panel.below);
    if (aligned + node.rows_below <= panel.stride) panel.below = aligned;
    for (int block : node.blocks) l.row_of[s][block] = l.position[block] - panel.first;
    int row = panel.below;
    for (int block : l.below[s]) {
      l.row_of[s][block] = row;
      row += pattern.sizes[block];
      append_unknowns(block, rows_);
    }
    rows_.resize(rows_.size() + panel.stride - row, unknowns_[panel.first]);
    value_count_ += static_cast<std::ptrdiff_t>(panel.stride) * panel.columns;
    panels_.push_back(panel);
  }
  for (std::size_t s = 0; s < nodes.size(); ++s) {
    panels_[s].first_update = static_cast<int>(updates_.size());
    add_updates(panels_, l, pattern.sizes, s, updates_);
    panels_[s].last_update = static_cast<int>(updates_.size());
  }

  for (const auto& [i, j] : couplings_) {
    BlockPlace place;
    if (pattern.sizes[i] > 0 && pattern.sizes[j] > 0) {
      const bool transposed = l.position[i] < l.position[j];
      const int row = transposed ? j : i, column = transposed ? i : j;
      const int s = l.panel_of[column];
      place = {panels_[s].offset + l.row_of[s].at(row) +
                   static_cast<std::ptrdiff_t>(panels_[s].stride) * l.row_of[s].at(column),
               1, panels_[s].stride};
      if (transposed) std::swap(place.row_stride, place.col_stride);
    }
    places_.push_back(place);
  }
}

bool BlockSymbolic::coupled(int i, int j) const {
  return std::binary_search(couplings_.begin(), couplings_.end(), std::pair(std::max(i, j), std::min(i, j)));
}

BlockPlace BlockSymbolic::place(int i, int j) const {
  if (!coupled(i, j))
    throw std::invalid_argument("blocks " + std::to_string(i) + " and " + std::to_string(j) +
                                " are not coupled");
  const auto found =
      std::lower_bound(couplings_.begin(), couplings_.end(), std::pair(std::max(i, j), std::min(i, j)));
  BlockPlace place = places_[found - couplings_.begin()];
  if (i < j) std::swap(place.row_stride, place.col_stride);
  return place;
}

}  // namespace mimbre::linalg
