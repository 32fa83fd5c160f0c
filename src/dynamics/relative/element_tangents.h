#pragma once
#include <algorithm>
#include <vector>

#include "dynamics/relative/matrix.h"
#include "dynamics/state_transfer.h"

namespace mimbre::relative {

/// The matrix as it was assembled, and the tangents of the marked force elements in it (ElementData::marked).
/// Where only these have changed, as a contact closes or a damper's law bends, they are exchanged in it: far
/// less work than to assemble all of it anew. Allocates only when made.
class ElementTangents {
 public:
  ElementTangents(const Compiled& m, std::size_t values);

  /// What the matrix is assembled with.
  void keep(std::size_t element, const ElementState<double>& state, const MatrixWeights& weights);
  /// The matrix is assembled: these values.
  void assembled(const double* values);
  /// The values with the tangents of the last evaluation of forces; `marked(k, state)` is told of each that
  /// changed.
  template <class Marked>
  void exchange(const Compiled& m, Workspace<double>& w, const MatrixWeights& weights, double* values,
                Marked&& marked);
  void transfer(StateTransfer& transfer) { transfer(values_, tangents_); }
  /// Whether tangents can be exchanged: some element is marked, and there are none of the absolute
  /// coordinates of beams or of pools. Else nothing is kept.
  bool possible() const { return possible_; }

 private:
  /// Of one element, into now_: whether they are other ones than in the matrix.
  bool changed(std::size_t element, const ElementState<double>& state, const MatrixWeights& weights);

  bool possible_ = true;
  std::vector<std::size_t> first_;  ///< by element, into tangents_
  std::vector<double> values_, tangents_;
  double now_[36] = {};
};

template <class Marked>
void ElementTangents::exchange(const Compiled& m, Workspace<double>& w, const MatrixWeights& weights,
                               double* values, Marked&& marked) {
  for (std::size_t k = 0; k < m.elements.size(); ++k) {
    const ElementData& e = m.elements[k];
    if (!e.marked) continue;
    const ElementState<double> state = element_state(e, w.elements.data());
    double* old = tangents_.data() + first_[k];
    if (!changed(k, state, weights)) continue;
    marked(k, state);
    const int n = e.count;
    const bool touched = std::any_of(old, old + n * n, [](double x) { return x != 0; });
    double difference[36];
    for (int i = 0; i < n * n; ++i) {
      difference[i] = now_[i] - old[i];
      old[i] = now_[i];
    }
    if (e.body >= 0) {
      const linalg::BlockPlace& place = m.diagonal[e.body];
      values_[place.offset + e.local * (place.row_stride + place.col_stride)] += difference[0];
    } else if (!e.path.entries.empty()) {
      // What does not touch in the matrix has no rows there; what does must leave it by the same.
      if (e.measure == Measure::contact && !touched) element_rows<double>(m, w, e, state);
      const double* rows = w.jacobian.data() + e.jacobian;
      weigh_rows<double>(n, e.path.width, rows, w.weighted.data(),
                         [&](int r, int c) { return difference[r * n + c]; });
      add_pairs(e.path, w.weighted.data(), rows, n, values_.data());
    }
  }
  std::copy(values_.begin(), values_.end(), values);
}

}  // namespace mimbre::relative
