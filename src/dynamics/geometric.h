#pragma once
#include <algorithm>
#include <array>

#include "dynamics/flexible.h"
#include "dynamics/stress_motion.h"
#include "mimbre/reduced_body.h"

/// Geometric stiffness of flexible bodies by their present loads (GeometricStiffness). Bodies without it have
/// no terms, and nothing happens here.
///
/// Forces at the boundary have an energy: with the modes' elastic forces R y there, and the displacements of
/// second order that go with them, Δ_l = ½ yᵀ K_l y (how much nearer the ends of a bar come as it bends, for
/// a force along it), it is
///   ½ (y + K⁻¹ Rᵀ Δ)ᵀ K (y + K⁻¹ Rᵀ Δ) = ½ yᵀ K y + Δᵀ R y + ½ Δᵀ R K⁻¹ Rᵀ Δ
/// so that the load is s = R (y + K⁻¹ Rᵀ Δ), and Rᵀ Δ acts back. Without this the bending would be driven by
/// vibrations along the bar that do not notice it, and grow without bound.
namespace mimbre::geometric {

/// Whether forces go by accelerations: those of inertia and gravity stiffen a body.
inline bool has_loads_of_inertia(const Compiled& m) {
  return std::any_of(m.flexible.begin(), m.flexible.end(),
                     [](const FlexibleData& f) { return f.geometric.inertial > 0; });
}

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

/// Present value of a load of inertia or gravity.
template <class T>
T inertial_load(int number, const StressMotion<T>& m) {
  constexpr std::array<std::array<int, 2>, 6> products{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}}};
  using Loads = GeometricStiffness;
  if (number < Loads::acceleration) return m.omega[products[number][0]] * m.omega[products[number][1]];
  if (number < Loads::angular_acceleration) return m.acceleration[number - Loads::acceleration];
  return m.alpha[number - Loads::angular_acceleration];
}

/// The matrix of the k-th load, and its row of `rows` if it is one of the boundary.
inline const double* matrix(const GeometricData& g, int k) {
  return g.stiffness.data() + static_cast<std::ptrdiff_t>(k) * g.modes * g.stiffness.cols();
}
inline const double* boundary_row(const GeometricData& g, const Rows& rows, int k) {
  return rows.data() + (g.loads[static_cast<std::size_t>(k)] - GeometricStiffness::boundary) * rows.cols();
}

/// out += factor K_l y, padded.
template <class T>
void add_product(const GeometricData& g, const double* row, const T& factor, const T* y, T* out) {
  const int s = static_cast<int>(g.stiffness.cols());
  for (int l = 0; l < g.modes; ++l, row += s) {
    const T x = factor * y[l];
    for (int k = 0; k < s; ++k) out[k] += x * row[k];
  }
}

/// Δ_l = ½ yᵀ K_l y of a load.
template <class T>
T second_order(const GeometricData& g, const double* row, const T* y) {
  const int s = static_cast<int>(g.stiffness.cols());
  T sum(0);
  for (int l = 0; l < g.modes; ++l, row += s) sum += y[l] * dot(row, y, s);
  return T(0.5) * sum;
}

/// x = y + K⁻¹ Rᵀ Δ, padded.
template <class T>
void strained(const GeometricData& g, const T* y, T* x) {
  const int s = static_cast<int>(g.stiffness.cols());
  for (int k = 0; k < s; ++k) x[k] = y[k];
  for (int l = g.inertial; l < static_cast<int>(g.loads.size()); ++l) {
    const T delta = second_order(g, matrix(g, l), y);
    const double* compliance = boundary_row(g, g.boundary_compliance, l);
    for (int k = 0; k < s; ++k) x[k] += delta * compliance[k];
  }
}

/// elastic += (Σ s_l K_l) y by inertia and gravity; y: padded amplitudes.
template <class T>
void add_inertial_forces(const GeometricData& g, const StressMotion<T>& m, const T* y, T* elastic) {
  for (int l = 0; l < g.inertial; ++l)
    add_product(g, matrix(g, l), inertial_load(g.loads[static_cast<std::size_t>(l)], m), y, elastic);
}

/// elastic += (Σ s_l K_l) y + Rᵀ Δ by forces at the boundary. x: scratch of the stride.
template <class T>
void add_boundary_forces(const GeometricData& g, const T* y, T* x, T* elastic) {
  const int s = static_cast<int>(g.stiffness.cols());
  if (g.inertial == static_cast<int>(g.loads.size())) return;
  strained(g, y, x);
  for (int l = g.inertial; l < static_cast<int>(g.loads.size()); ++l) {
    const double* load = boundary_row(g, g.boundary_loads, l);
    add_product(g, matrix(g, l), dot(load, x, s), y, elastic);
    const T delta = second_order(g, matrix(g, l), y);
    for (int k = 0; k < s; ++k) elastic[k] += delta * load[k];
  }
}

/// What the boundary adds to ½ yᵀ K y. x: scratch of the stride.
template <class T>
T boundary_energy(const GeometricData& g, const T* y, T* x) {
  const int s = static_cast<int>(g.stiffness.cols());
  strained(g, y, x);
  T energy(0);
  for (int l = g.inertial; l < static_cast<int>(g.loads.size()); ++l) {
    const double* load = boundary_row(g, g.boundary_loads, l);
    energy += second_order(g, matrix(g, l), y) * T(0.5) * (dot(load, y, s) + dot(load, x, s));
  }
  return energy;
}

/// Numbers of scratch that stiffness() needs for any body of the model.
inline std::size_t scratch(const Compiled& m) {
  std::size_t most = 0;
  for (const FlexibleData& f : m.flexible)
    most = std::max(most, (1 + f.geometric.loads.size()) * static_cast<std::size_t>(f.stride));
  return most;
}

/// out: modes rows of the stride: the tangent at constant loads of inertia and gravity,
/// Σ s_l K_l + Σ (K_l y ∂s_l/∂y + R_l (K_l y)ᵀ), ∂s_l/∂y = R_l + Σ R_l K⁻¹ R_mᵀ (K_m y)ᵀ.
template <class T>
void stiffness(const GeometricData& g, const StressMotion<T>& m, const T* y, T* out, T* scratch) {
  const int s = static_cast<int>(g.stiffness.cols()), size = g.modes * s;
  const int loads = static_cast<int>(g.loads.size());
  std::fill(out, out + size, T(0));
  const auto add = [&](int l, const T& value) {
    const double* block = matrix(g, l);
    for (int k = 0; k < size; ++k) out[k] += value * block[k];
  };
  for (int l = 0; l < g.inertial; ++l) add(l, inertial_load(g.loads[static_cast<std::size_t>(l)], m));
  if (g.inertial == loads) return;
  T *x = scratch, *products = scratch + s;
  strained(g, y, x);
  for (int l = g.inertial; l < loads; ++l) {
    add(l, dot(boundary_row(g, g.boundary_loads, l), x, s));
    T* product = products + (l - g.inertial) * s;
    std::fill(product, product + s, T(0));
    add_product(g, matrix(g, l), T(1), y, product);
  }
  for (int l = g.inertial; l < loads; ++l) {
    const double* load = boundary_row(g, g.boundary_loads, l);
    const T* own = products + (l - g.inertial) * s;
    const auto outer = [&](const auto* row, const T& factor) {
      for (int r = 0; r < g.modes; ++r)
        for (int k = 0; k < s; ++k) out[r * s + k] += factor * own[r] * row[k];
    };
    outer(load, T(1));
    for (int r = 0; r < g.modes; ++r)
      for (int k = 0; k < s; ++k) out[r * s + k] += load[r] * own[k];
    for (int n = g.inertial; n < loads; ++n)
      outer(products + (n - g.inertial) * s, T(dot(load, boundary_row(g, g.boundary_compliance, n), s)));
  }
}

}  // namespace mimbre::geometric
