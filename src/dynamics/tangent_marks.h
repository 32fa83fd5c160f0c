#pragma once
#include <cmath>
#include <span>
#include <vector>

#include "compile/compiled.h"
#include "dynamics/ancf.h"
#include "dynamics/system.h"
#include "forces/element.h"

namespace mimbre {

/// An element's share of the leading matrix, kg, or kg m² of one that measures an angle: of several
/// components, of the first three, which are lengths.
template <class T>
double element_tangent(const ElementState<T>& s, const MatrixWeights& weights) {
  double sum = 0;
  for (int k = 0; k < (s.count == 1 ? 1 : 3); ++k)
    sum +=
        weights.damping * s.damping[k * (s.count + 1)] + weights.stiffness * s.stiffness[k * (s.count + 1)];
  return sum;
}

/// The tangents of forces that may change at once, as they are in a factorised matrix: of elements, and of
/// beams by absolute nodal coordinates (see ancf.h), by body.
class TangentMarks {
 public:
  explicit TangentMarks(const Compiled& m);
  std::span<double> values() { return values_; }
  /// Whether there is an element that heeds LawContext::holds.
  bool sticks() const { return sticks_; }
  double& element(std::size_t k) { return values_[k]; }
  double* ancf() { return values_.data() + ancf_; }
  /// Changes of an element's mark that ask for a new matrix are larger than this.
  double small(std::size_t element) const { return small_[element]; }

  /// Whether the present tangents differ from these by more than a fiftieth of a body's mean mass, or half of
  /// what one of the bodies resists motion with. `elements`: storage of their states; `amplitudes(i)`: those
  /// of body i.
  template <class Amplitudes>
  bool changed(const Compiled& m, const double* elements, const MatrixWeights& weights,
               const Amplitudes& amplitudes) const {
    for (std::size_t k = 0; k < m.elements.size(); ++k) {
      if (!m.elements[k].marked) continue;
      const ElementState<const double> s = element_state(m.elements[k], elements);
      if (std::abs(element_tangent(s, weights) - values_[k]) > small_[k]) return true;
    }
    const double* marks = values_.data() + ancf_;
    for (std::size_t i = 0; i < m.bodies.size(); ++i) {
      if (m.bodies[i].modes == 0 || !m.flexible[m.bodies[i].flexible].absolute()) continue;
      const FlexibleData& f = m.flexible[m.bodies[i].flexible];
      if (ancf::marks_moved(f, amplitudes(i), marks, small_[ancf_ + i] / weights.stiffness)) return true;
      marks += ancf::marks(f);
    }
    return false;
  }

  /// Whether the tangent of an element is by as much below nine tenths of this.
  bool fell(const Compiled& m, const double* elements, const MatrixWeights& weights) const {
    for (std::size_t k = 0; k < m.elements.size(); ++k) {
      if (!m.elements[k].marked) continue;
      const double now = element_tangent(element_state(m.elements[k], elements), weights);
      if (values_[k] - now > small_[k] && now < fallen * values_[k]) return true;
    }
    return false;
  }

 private:
  static constexpr double fallen = 0.9;
  std::size_t ancf_;
  bool sticks_;
  std::vector<double> values_;
  std::vector<double> small_;  ///< of elements, then of bodies
};

}  // namespace mimbre
