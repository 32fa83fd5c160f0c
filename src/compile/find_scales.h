#pragma once
#include <algorithm>
#include <limits>
#include <vector>

#include "compile/compiled.h"

namespace mimbre {

/// Finds the mechanism's mass and length scales, and what follows from them: scales of the penalties, masses
/// that impacts move.
void find_scales(Compiled& model);

/// What a body resists motion with, together with all that is fixed to it. A body without mass counts as the
/// lightest of those that it is joined to.
struct BodyResistance {
  double mass = std::numeric_limits<double>::infinity();  ///< kg
  double inertia = mass;                                  ///< kg m²
};

/// By tree body; behind them that of the ground, infinite.
class BodyResistances {
 public:
  explicit BodyResistances(const Compiled& model);
  /// Of a tree body, -1: the ground.
  const BodyResistance& of(int body) const { return all_[body < 0 ? all_.size() - 1 : std::size_t(body)]; }
  /// The lighter one of two bodies.
  BodyResistance least(int body_a, int body_b) const {
    const BodyResistance &a = of(body_a), &b = of(body_b);
    return {std::min(a.mass, b.mass), std::min(a.inertia, b.inertia)};
  }

 private:
  std::vector<BodyResistance> all_;
};

/// A penalty beyond this many times the mass that it moves leaves too few digits for that mass.
constexpr double largest_penalty_ratio = 1e6;

/// Penalty scale of an equation that moves bodies of this resistance: `usual` where they are not too light.
inline double penalty_scale(double usual, double resistance) {
  return std::min(usual, largest_penalty_ratio * resistance);
}

}  // namespace mimbre
