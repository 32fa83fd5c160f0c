#include "dynamics/relative/element_tangents.h"

#include <algorithm>

namespace mimbre::relative {

ElementTangents::ElementTangents(const Compiled& m, std::size_t values) {
  std::size_t count = 0;
  for (const ElementData& e : m.elements) {
    possible_ = possible_ && !e.pooled;
    first_.push_back(count);
    if (e.marked) count += static_cast<std::size_t>(e.count * e.count);
  }
  for (const FlexibleData& f : m.flexible) possible_ = possible_ && !f.absolute();
  possible_ = possible_ && count > 0;
  if (!possible_) return;
  values_.resize(values);
  tangents_.assign(count, 0.0);
}

bool ElementTangents::changed(std::size_t element, const ElementState<double>& state,
                              const MatrixWeights& weights) {
  const double* old = tangents_.data() + first_[element];
  bool any = false;
  for (int i = 0; i < state.count * state.count; ++i) {
    now_[i] = weights.damping * state.damping[i] + weights.stiffness * state.stiffness[i];
    any = any || now_[i] != old[i];
  }
  return any;
}

void ElementTangents::keep(std::size_t element, const ElementState<double>& state,
                           const MatrixWeights& weights) {
  if (!possible_) return;
  if (changed(element, state, weights))
    std::copy_n(now_, state.count * state.count, tangents_.data() + first_[element]);
}

void ElementTangents::assembled(const double* values) {
  if (!possible_) return;
  std::copy_n(values, values_.size(), values_.begin());
}

}  // namespace mimbre::relative
