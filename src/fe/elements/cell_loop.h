#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

#include "base/parallel.h"
#include "fe/elements/mesh_cells.h"

namespace mimbre::fe {

/// Nodes are shared out to threads in runs of this length: neighbours stay together, and every part of the
/// mesh keeps every thread busy.
constexpr int kNodeRun = 64;

/// Computes the matrices of all cells, a bunch of cells at a time, and adds them. `size(cell)` doubles go to
/// a cell, `compute(cell, double*)` fills them, on any thread; `add(cell, const double*, owned)` adds those
/// columns whose node satisfies owned(node). Each node has one thread, and its cells come in ascending order:
/// the sums do not depend on the number of threads.
template <class Size, class Compute, class Add>
void loop_over_cells(const MeshCells& cells, int threads, const Size& size, const Compute& compute,
                     const Add& add) {
  constexpr int kBunch = 1024;
  std::vector<double> values;
  std::vector<std::size_t> at(kBunch + 1, 0);
  for (int begin = 0; begin < cells.size(); begin += kBunch) {
    const int count = std::min(kBunch, cells.size() - begin);
    for (int k = 0; k < count; ++k) at[k + 1] = at[k] + static_cast<std::size_t>(size(begin + k));
    values.resize(std::max(values.size(), at[count]));
    parallel_ranges(even_bounds(count, threads), [&](int from, int to) {
      for (int k = from; k < to; ++k) compute(begin + k, values.data() + at[k]);
    });
    parallel_ranges(even_bounds(threads, threads), [&](int thread, int) {
      const auto owned = [&](int node) { return node / kNodeRun % threads == thread; };
      for (int k = 0; k < count; ++k) add(begin + k, values.data() + at[k], owned);
    });
  }
}

}  // namespace mimbre::fe
