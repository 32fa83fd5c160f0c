#pragma once
#include <cmath>
#include <span>
#include <vector>

#include "dynamics/ancf.h"
#include "dynamics/motion.h"
#include "dynamics/system.h"
#include "model/compiled.h"

namespace mimbre {

/// A spring's share of the leading matrix, kg.
inline double spring_tangent(const SpringState<double>& s, const MatrixWeights& weights) {
  return weights.damping * s.damping + weights.stiffness * s.stiffness;
}

/// A tyre's.
inline double tyre_tangent(const TyreState<double>& t, const MatrixWeights& weights) {
  return weights.stiffness * t.stiffness;
}

/// The tangents of forces that may change at once, as they are in a factorised matrix: of springs and tyres,
/// kg, and of beams by absolute nodal coordinates (see ancf.h), by body.
class TangentMarks {
 public:
  explicit TangentMarks(const Compiled& m)
      : tyres_(m.springs.size()),
        ancf_(m.springs.size() + m.tyres.size()),
        values_(ancf_ + ancf::all_marks(m)) {}
  std::span<double> values() { return values_; }
  double& spring(std::size_t k) { return values_[k]; }
  double& tyre(std::size_t k) { return values_[tyres_ + k]; }
  double* ancf() { return values_.data() + ancf_; }

  /// Whether the present tangents differ from these by more than a fiftieth of a body's mean mass.
  /// `amplitudes(i)`: those of body i.
  template <class Amplitudes>
  bool changed(const Compiled& m, const std::vector<SpringState<double>>& springs,
               const std::vector<TyreState<double>>& tyres, const MatrixWeights& weights,
               const Amplitudes& amplitudes) const {
    const double small = 0.02 * m.mass_scale;
    for (std::size_t k = 0; k < springs.size(); ++k)
      if (std::abs(spring_tangent(springs[k], weights) - values_[k]) > small) return true;
    for (std::size_t k = 0; k < tyres.size(); ++k)
      if (std::abs(tyre_tangent(tyres[k], weights) - values_[tyres_ + k]) > small) return true;
    const double* marks = values_.data() + ancf_;
    for (std::size_t i = 0; i < m.bodies.size(); ++i) {
      if (m.bodies[i].modes == 0 || m.flexible[m.bodies[i].flexible].ancf.empty()) continue;
      const FlexibleData& f = m.flexible[m.bodies[i].flexible];
      if (ancf::marks_moved(f, amplitudes(i), marks, small / weights.stiffness)) return true;
      marks += ancf::marks(f);
    }
    return false;
  }

 private:
  std::size_t tyres_, ancf_;
  std::vector<double> values_;
};

}  // namespace mimbre
