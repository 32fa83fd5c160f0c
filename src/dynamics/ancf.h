#pragma once
#include <algorithm>
#include <cmath>

#include "dynamics/ancf_spatial.h"

/// Elastic forces of beams by absolute nodal coordinates; those in space are in ancf_spatial.h. Of planar
/// ones the strain energy is ½∫EA ε² + ½∫EI κ², with ε = |r'| − 1 and κ = (r' × r'')/|r'|², the turn of the
/// tangent per undeformed length, so that N and M are those of the cross-sections at any deflection
/// (Gerstmayr, Irschik, On the correct representation of bending and axial deformation in the absolute nodal
/// coordinate formulation, J. Sound Vib. 318 (2008)).
namespace mimbre::ancf {

/// A strain at a Gauss point: its value, rate, and derivatives by r' and r'' (along, across each).
template <class T>
struct Strain {
  T value, rate;
  T by_slope[2], by_curvature[2];
};

/// r', r'' and rates at a Gauss point.
template <class T>
struct Point {
  T a[2] = {T(1), T(0)}, b[2] = {T(0), T(0)}, a_rate[2] = {T(0), T(0)}, b_rate[2] = {T(0), T(0)};
};

template <class T>
Point<T> point_at(const AncfElement& e, const AncfElement::Point& p, const T* y, const T* yd) {
  Point<T> x;
  for (int k = 0; k < 8; ++k) {
    const int at = e.amplitudes[k];
    if (at < 0) continue;
    x.a[k % 2] += p.slope[k / 2] * y[at];
    x.b[k % 2] += p.curvature[k / 2] * y[at];
    x.a_rate[k % 2] += p.slope[k / 2] * yd[at];
    x.b_rate[k % 2] += p.curvature[k / 2] * yd[at];
  }
  return x;
}

template <class T>
Strain<T> stretch(const Point<T>& x) {
  using std::sqrt;
  const T length = sqrt(x.a[0] * x.a[0] + x.a[1] * x.a[1]);
  const T t0 = x.a[0] / length, t1 = x.a[1] / length;
  return {length - T(1), t0 * x.a_rate[0] + t1 * x.a_rate[1], {t0, t1}, {T(0), T(0)}};
}

template <class T>
Strain<T> bend(const Point<T>& x) {
  const T s = x.a[0] * x.a[0] + x.a[1] * x.a[1];
  Strain<T> k;
  k.value = (x.a[0] * x.b[1] - x.a[1] * x.b[0]) / s;
  k.by_slope[0] = (x.b[1] - T(2) * k.value * x.a[0]) / s;
  k.by_slope[1] = (-x.b[0] - T(2) * k.value * x.a[1]) / s;
  k.by_curvature[0] = -x.a[1] / s;
  k.by_curvature[1] = x.a[0] / s;
  k.rate = T(0);
  for (int c = 0; c < 2; ++c) k.rate += k.by_slope[c] * x.a_rate[c] + k.by_curvature[c] * x.b_rate[c];
  return k;
}

/// Adds the forces of strain, times `elastic`, and of its rate, times `damping`, to `out`.
template <class T>
void add_forces(const FlexibleData& f, double elastic, double damping, const T* y, const T* yd, T* out) {
  const auto add = [&](const AncfElement& e, const AncfElement::Point& p, const Strain<T>& strain) {
    const T force = p.stiffness * (elastic * strain.value + damping * f.ancf_damping * strain.rate);
    for (int k = 0; k < 8; ++k)
      if (const int at = e.amplitudes[k]; at >= 0)
        out[at] += force * (strain.by_slope[k % 2] * p.slope[k / 2] +
                            strain.by_curvature[k % 2] * p.curvature[k / 2]);
  };
  for (const AncfElement& e : f.ancf) {
    for (const AncfElement::Point& p : e.axial) add(e, p, stretch(point_at(e, p, y, yd)));
    for (const AncfElement::Point& p : e.bending) add(e, p, bend(point_at(e, p, y, yd)));
  }
  for (const AncfSpatialElement& e : f.ancf_spatial)
    add_forces(e, elastic, damping * f.ancf_damping, y, yd, out);
}

template <class T>
T energy(const FlexibleData& f, const T* y) {
  T sum(0);
  const auto add = [&](const AncfElement::Point& p, const Strain<T>& strain) {
    sum += T(0.5) * p.stiffness * strain.value * strain.value;
  };
  for (const AncfElement& e : f.ancf) {
    for (const AncfElement::Point& p : e.axial) add(p, stretch(point_at(e, p, y, y)));
    for (const AncfElement::Point& p : e.bending) add(p, bend(point_at(e, p, y, y)));
  }
  for (const AncfSpatialElement& e : f.ancf_spatial) sum += energy(e, y);
  return sum;
}

/// Adds stiffness · ∂f/∂y + damping · ∂f/∂ẏ at ẏ = 0, symmetric, by add(row, column, value) for every pair
/// of amplitudes that an element joins.
template <class T, class Add>
void add_tangent(const FlexibleData& f, const T* y, double stiffness, double damping, const Add& add) {
  const double along_strain = stiffness + damping * f.ancf_damping;
  // H: second derivatives of the strain by (r', r'').
  const auto add_point = [&](const AncfElement& e, const AncfElement::Point& p, const Strain<T>& strain,
                             const T(&H)[4][4]) {
    T C[4][4];
    const T g[4] = {strain.by_slope[0], strain.by_slope[1], strain.by_curvature[0], strain.by_curvature[1]};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        C[i][j] = p.stiffness * (along_strain * g[i] * g[j] + stiffness * strain.value * H[i][j]);
    for (int k = 0; k < 8; ++k) {
      if (e.amplitudes[k] < 0) continue;
      const int c = k % 2;
      const double s = p.slope[k / 2], b = p.curvature[k / 2];
      for (int l = 0; l <= k; ++l) {
        if (e.amplitudes[l] < 0) continue;
        const int d = l % 2;
        const double t = p.slope[l / 2], h = p.curvature[l / 2];
        const T x = s * (C[c][d] * t + C[c][2 + d] * h) + b * (C[2 + c][d] * t + C[2 + c][2 + d] * h);
        add(e.amplitudes[k], e.amplitudes[l], x);
        if (l != k) add(e.amplitudes[l], e.amplitudes[k], x);
      }
    }
  };
  for (const AncfElement& e : f.ancf) {
    for (const AncfElement::Point& p : e.axial) {
      const Point<T> x = point_at(e, p, y, y);
      const Strain<T> strain = stretch(x);
      const T length = T(1) + strain.value;
      T H[4][4] = {};
      for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j) H[i][j] = (T(i == j) - strain.by_slope[i] * strain.by_slope[j]) / length;
      add_point(e, p, strain, H);
    }
    for (const AncfElement::Point& p : e.bending) {
      const Point<T> x = point_at(e, p, y, y);
      const Strain<T> strain = bend(x);
      const T s = x.a[0] * x.a[0] + x.a[1] * x.a[1];
      const T g[2] = {x.b[1] / s, -x.b[0] / s};  // of r' × r'' by r', over s
      const T turned[2] = {-x.a[1] / s, x.a[0] / s};
      T H[4][4] = {};
      for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j) {
          H[i][j] = (T(-2) * (g[i] * x.a[j] + x.a[i] * g[j]) +
                     strain.value * (T(8) * x.a[i] * x.a[j] / s - T(2) * T(i == j))) /
                    s;
          H[2 + i][j] = T(i - j) / s - T(2) * turned[i] * x.a[j] / s;
          H[j][2 + i] = H[2 + i][j];
        }
      add_point(e, p, strain, H);
    }
  }
  for (const AncfSpatialElement& e : f.ancf_spatial)
    add_tangent(e, y, stiffness, damping * f.ancf_damping, add);
}

/// Per axial Gauss point: force over length, which is geometric stiffness, and the direction in which the
/// axis is stiff. They decide whether a tangent is still good.
inline std::size_t marks(const FlexibleData& f) {
  std::size_t count = 9 * f.ancf.size();
  for (const AncfSpatialElement& e : f.ancf_spatial) count += mark_count(e);
  return count;
}

/// Of all bodies.
inline std::size_t all_marks(const Compiled& m) {
  std::size_t count = 0;
  for (const BodyData& b : m.bodies)
    if (b.modes > 0) count += marks(m.flexible[b.flexible]);
  return count;
}

/// Calls visit(number) for the marks at y, N/m.
template <class Visit>
void visit_marks(const FlexibleData& f, const double* y, const Visit& visit) {
  for (const AncfElement& e : f.ancf)
    for (const AncfElement::Point& p : e.axial) {
      const Strain<double> strain = stretch(point_at(e, p, y, y));
      const double stiffness = p.stiffness / (e.length * e.length);
      visit(stiffness * strain.value);
      visit(stiffness * strain.by_slope[0]);
      visit(stiffness * strain.by_slope[1]);
    }
  for (const AncfSpatialElement& e : f.ancf_spatial) {
    std::array<double, 24> of_element;
    marks(e, y, of_element.data());
    for (std::size_t k = 0; k < mark_count(e); ++k) visit(of_element[k]);
  }
}

/// Keeps the marks at y.
inline void keep_marks(const FlexibleData& f, const double* y, double* marks) {
  visit_marks(f, y, [&](double mark) { *marks++ = mark; });
}

/// Whether those at y differ from the kept ones by more than `limit`, N/m.
inline bool marks_moved(const FlexibleData& f, const double* y, const double* marks, double limit) {
  double most = 0;
  visit_marks(f, y, [&](double mark) { most = std::max(most, std::abs(mark - *marks++)); });
  return most > limit;
}

}  // namespace mimbre::ancf
