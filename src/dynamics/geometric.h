#pragma once
#include <algorithm>
#include <array>

#include "dynamics/flexible.h"
#include "dynamics/stress_motion.h"
#include "mimbre/reduced_body.h"

/// Geometric stiffness of flexible bodies by their present loads (GeometricStiffness). Bodies without it have
/// no terms, and nothing happens here.
namespace mimbre::geometric {

/// Adds to the motion of a body frame (body axes, gravity taken off) the mean motion of the body in it.
template <class T>
StressMotion<T> stress_motion(const GeometricData& g, const Vec3<T>& omega, const Vec3<T>& acceleration,
                              const Vec3<T>& alpha, const T* ydd) {
  const int s = static_cast<int>(g.mean_motion.cols());
  StressMotion<T> m{omega, acceleration, alpha};
  for (int k = 0; k < 3; ++k) {
    m.acceleration[k] += dot(g.mean_motion.data() + k * s, ydd, s);
    m.alpha[k] += dot(g.mean_motion.data() + (3 + k) * s, ydd, s);
  }
  return m;
}

/// Present value of a load; y: padded amplitudes.
template <class T>
T load(const GeometricData& g, int number, const StressMotion<T>& m, const T* y) {
  constexpr std::array<std::array<int, 2>, 6> products{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}}};
  using Loads = GeometricStiffness;
  if (number < Loads::acceleration) return m.omega[products[number][0]] * m.omega[products[number][1]];
  if (number < Loads::angular_acceleration) return m.acceleration[number - Loads::acceleration];
  if (number < Loads::boundary) return m.alpha[number - Loads::angular_acceleration];
  const int s = static_cast<int>(g.boundary_loads.cols());
  return dot(g.boundary_loads.data() + (number - Loads::boundary) * s, y, s);
}

/// elastic += (Σ s_l K_l) y, both padded.
template <class T>
void add_forces(const GeometricData& g, const StressMotion<T>& m, const T* y, T* elastic) {
  const int s = static_cast<int>(g.stiffness.cols());
  const double* row = g.stiffness.data();
  for (const int number : g.loads) {
    const T value = load(g, number, m, y);
    for (int l = 0; l < g.modes; ++l, row += s) {
      const T x = value * y[l];
      for (int k = 0; k < s; ++k) elastic[k] += x * row[k];
    }
  }
}

/// out = Σ s_l K_l, modes rows of the stride: the tangent at constant loads.
template <class T>
void stiffness(const GeometricData& g, const StressMotion<T>& m, const T* y, T* out) {
  const int s = static_cast<int>(g.stiffness.cols()), size = g.modes * s;
  std::fill(out, out + size, T(0));
  const double* block = g.stiffness.data();
  for (const int number : g.loads) {
    const T value = load(g, number, m, y);
    for (int k = 0; k < size; ++k) out[k] += value * block[k];
    block += size;
  }
}

}  // namespace mimbre::geometric
