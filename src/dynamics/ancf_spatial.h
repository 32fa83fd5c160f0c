#pragma once
#include <array>

#include "compile/compiled.h"
#include "dynamics/section_axes.h"
#include "math/forward.h"

/// Elastic forces of beams in space by absolute nodal coordinates. A law knows, of a point, some vectors of
/// the deformed beam and what strains they are; its energy is half the sum of stiffness times strain squared.
/// All vectors are in the axes of the undeformed line: x along it.
namespace mimbre::ancf {

/// A vector at a point: from which weights, the first of the element's vectors that it is made of, and which
/// axis it is without deformation (-1: zero).
struct Field {
  bool higher;
  int first, axis;
};

template <class T, int fields, int strains>
struct Strains {
  std::array<T, strains> value;
  std::array<std::array<Vec3<T>, fields>, strains> by;  ///< derivatives by the vectors
};

/// r' of a cable: ε = |r'| − 1.
struct CableStretch {
  static constexpr std::array<Field, 1> fields{{{false, 0, 0}}};
  static constexpr int strains = 1, shapes = 4, stride = 1;
  template <class T>
  static Strains<T, 1, 1> at(const Vec3<T>* x) {
    const T length = x[0].norm();
    return {{length - T(1)}, {{{x[0] / length}}}};
  }
};

/// r', r'' of a cable: κ = r' × r''/|r'|², the turn of the tangent per undeformed length (Gerstmayr, Shabana,
/// Analysis of thin beams and cables using the absolute nodal co-ordinate formulation, Nonlinear Dyn. 45
/// (2006), with the measure of Gerstmayr, Irschik 2008).
struct CableBend {
  static constexpr std::array<Field, 2> fields{{{false, 0, 0}, {true, 0, -1}}};
  static constexpr int strains = 3, shapes = 4, stride = 1;
  template <class T>
  static Strains<T, 2, 3> at(const Vec3<T>* x) {
    const T s = x[0].squaredNorm();
    const Vec3<T> k = x[0].cross(x[1]) / s;
    Strains<T, 2, 3> out;
    for (int m = 0; m < 3; ++m) {
      const int i = (m + 1) % 3, j = (m + 2) % 3;
      out.value[m] = k[m];
      Vec3<T>&by_slope = out.by[m][0], &by_curvature = out.by[m][1];
      by_slope = x[0] * (T(-2) * k[m] / s);
      by_slope[i] += x[1][j] / s;
      by_slope[j] -= x[1][i] / s;
      by_curvature = Vec3<T>::Zero();
      by_curvature[j] = x[0][i] / s;
      by_curvature[i] = -x[0][j] / s;
    }
    return out;
  }
};

/// r', directions y and z of the cross-section, y', z' of a thick beam: Γ = Aᵀ r' − e1 and κ = axial(Aᵀ A'),
/// A the SectionAxes: the strains of the geometrically exact beam (Simo, Vu-Quoc 1986; Nachbagauer, Gruber,
/// Gerstmayr, Structural and continuum mechanics approaches for a 3D shear deformable ANCF beam finite
/// element, J. Comput. Nonlinear Dyn. 8 (2013)).
struct ThickBeam {
  static constexpr std::array<Field, 5> fields{
      {{true, 0, 0}, {false, 1, 1}, {false, 2, 2}, {true, 1, -1}, {true, 2, -1}}};
  static constexpr int strains = 6, shapes = 3, stride = 3;
  template <class T>
  static Strains<T, 5, 6> at(const Vec3<T>* x) {
    const SectionAxes<T> s(x[1], x[2]);
    const Vec3<T> r = s.local(x[0]), y = s.local(x[1]), k = s.turn(x[3], x[4]), yp = s.local(x[3]),
                  zp = s.local(x[4]);
    Strains<T, 5, 6> out;
    for (auto& by : out.by)
      for (Vec3<T>& v : by) v = Vec3<T>::Zero();
    // eᵢ·v varies by eᵢ·δv and by the turn of eᵢ, δφ·(eᵢ × v); v in these axes.
    const auto crossed = [](int i, const Vec3<T>& v) {
      Vec3<T> c = Vec3<T>::Zero();
      const int j = (i + 1) % 3, l = (i + 2) % 3;
      c[j] = -v[l];
      c[l] = v[j];
      return c;
    };
    Vec3<T> turned[6];
    for (int i = 0; i < 3; ++i) {
      out.value[i] = r[i] - T(i == 0 ? 1 : 0);
      out.by[i][0] = s.e[i];
      turned[i] = crossed(i, r);
    }
    const T Z = s.z_length;
    for (int i = 0; i < 3; ++i) out.value[3 + i] = k[i];
    turned[3] = crossed(1, zp) / -Z;
    out.by[3][4] = s.e[1] / -Z;
    out.by[3][2] = s.e[2] * (-k[0] / Z);
    turned[4] = crossed(0, zp) / Z;
    out.by[4][4] = s.e[0] / Z;
    out.by[4][2] = s.e[2] * (-k[1] / Z);
    const T a = s.y3 / s.y2;
    turned[5] = turned[4] * a + (crossed(2, y) * k[1] - crossed(0, yp) - crossed(1, y) * k[2]) / s.y2;
    out.by[5][4] = out.by[4][4] * a;
    out.by[5][2] = out.by[4][2] * a;
    out.by[5][1] = (s.e[2] * k[1] - s.e[1] * k[2]) / s.y2;
    out.by[5][3] = s.e[0] / -s.y2;
    for (int m = 0; m < 6; ++m) s.add_moment(turned[m], out.by[m][1], out.by[m][2]);
    return out;
  }
};

/// Directions y and z of the cross-section of a thick beam: its stretch along both, and its shear.
struct ThickSection {
  static constexpr std::array<Field, 2> fields{{{false, 1, 1}, {false, 2, 2}}};
  static constexpr int strains = 3, shapes = 3, stride = 3;
  template <class T>
  static Strains<T, 2, 3> at(const Vec3<T>* x) {
    const Vec3<T> none = Vec3<T>::Zero();
    return {{T(0.5) * (x[0].squaredNorm() - T(1)), T(0.5) * (x[1].squaredNorm() - T(1)), x[0].dot(x[1])},
            {{{x[0], none}, {none, x[1]}, {x[1], x[0]}}}};
  }
};

/// Calls visit(law, point) for the points of an element.
template <class Visit>
void visit_points(const AncfSpatialElement& e, const Visit& visit) {
  const auto& p = e.points;
  if (e.thick) {
    for (std::size_t k = 0; k < 2; ++k) visit(ThickBeam(), p[k]);
    for (std::size_t k = 2; k < 5; ++k) visit(ThickSection(), p[k]);
  } else {
    for (std::size_t k = 0; k < 3; ++k) visit(CableStretch(), p[k]);
    for (std::size_t k = 3; k < 5; ++k) visit(CableBend(), p[k]);
  }
}

/// Calls visit(component, field, axis, weight) for all that the vectors of a law are made of; of components
/// of the element's vectors that have an amplitude.
template <class Law, class Visit>
void visit_weights(const AncfSpatialElement& e, const AncfSpatialElement::Point& p, const Visit& visit) {
  for (std::size_t f = 0; f < Law::fields.size(); ++f) {
    const Field& field = Law::fields[f];
    const auto& weights = field.higher ? p.higher : p.lower;
    for (int k = 0; k < Law::shapes; ++k) {
      const double weight = weights[static_cast<std::size_t>(k)];
      if (weight == 0) continue;
      const auto first = static_cast<std::size_t>(3 * (field.first + Law::stride * k));
      for (std::size_t c = 0; c < 3; ++c)
        if (e.amplitudes[first + c] >= 0) visit(first + c, f, static_cast<int>(c), weight);
    }
  }
}

template <class Law, class T>
using Vectors = std::array<Vec3<T>, Law::fields.size()>;

/// The law's vectors by amplitudes, or their rates.
template <class Law, class T>
Vectors<Law, T> vectors(const AncfSpatialElement& e, const AncfSpatialElement::Point& p, const T* y,
                        bool rates) {
  Vectors<Law, T> x;
  for (std::size_t f = 0; f < x.size(); ++f) {
    x[f] = Vec3<T>::Zero();
    if (const int axis = Law::fields[f].axis; axis >= 0 && !rates) x[f][axis] = T(1);
  }
  visit_weights<Law>(e, p, [&](std::size_t k, std::size_t f, int c, double weight) {
    x[f][c] += weight * y[e.amplitudes[k]];
  });
  return x;
}

/// Of one element, as add_forces() of ancf.h.
template <class T>
void add_forces(const AncfSpatialElement& e, double elastic, double damping, const T* y, const T* yd,
                T* out) {
  visit_points(e, [&]<class Law>(const Law&, const AncfSpatialElement::Point& p) {
    const Vectors<Law, T> x = vectors<Law>(e, p, y, false);
    const auto strain = Law::template at<T>(x.data());
    Vectors<Law, T> rate, force;
    if (damping != 0) rate = vectors<Law>(e, p, yd, true);
    for (Vec3<T>& f : force) f = Vec3<T>::Zero();
    for (std::size_t m = 0; m < strain.value.size(); ++m) {
      T stress = elastic * strain.value[m];
      if (damping != 0)
        for (std::size_t f = 0; f < x.size(); ++f) stress += damping * strain.by[m][f].dot(rate[f]);
      stress *= T(p.stiffness[m]);
      for (std::size_t f = 0; f < x.size(); ++f) force[f] += strain.by[m][f] * stress;
    }
    visit_weights<Law>(e, p, [&](std::size_t k, std::size_t f, int c, double weight) {
      out[e.amplitudes[k]] += weight * force[f][c];
    });
  });
}

template <class T>
T energy(const AncfSpatialElement& e, const T* y) {
  T sum(0);
  visit_points(e, [&]<class Law>(const Law&, const AncfSpatialElement::Point& p) {
    const auto strain = Law::template at<T>(vectors<Law>(e, p, y, false).data());
    for (std::size_t m = 0; m < strain.value.size(); ++m)
      sum += T(0.5 * p.stiffness[m]) * strain.value[m] * strain.value[m];
  });
  return sum;
}

/// ∂(Σ stiffness s ∂s/∂x)/∂x · `stiffness` + Σ stiffness ∂s/∂x ∂s/∂xᵀ · `damping`, by the law's vectors: a
/// row for each of their components.
template <class Law, class T>
std::array<Vectors<Law, T>, 3 * Law::fields.size()> second_derivatives(const AncfSpatialElement::Point& p,
                                                                       const Vectors<Law, T>& x,
                                                                       double stiffness, double damping) {
  std::array<Vectors<Law, T>, 3 * Law::fields.size()> out;
  std::array<Vec3<Forward<T>>, Law::fields.size()> varied;
  for (std::size_t f = 0; f < x.size(); ++f)
    for (int c = 0; c < 3; ++c) varied[f][c] = x[f][c];
  for (std::size_t row = 0; row < out.size(); ++row) {
    const std::size_t of = row / 3;
    const int c = static_cast<int>(row % 3);
    varied[of][c].by = T(1);
    const auto strain = Law::template at<Forward<T>>(varied.data());
    varied[of][c].by = T(0);
    for (std::size_t f = 0; f < x.size(); ++f) {
      out[row][f] = Vec3<T>::Zero();
      for (std::size_t m = 0; m < strain.value.size(); ++m)
        for (int k = 0; k < 3; ++k) {
          const Forward<T>& by = strain.by[m][f][k];
          out[row][f][k] += p.stiffness[m] * ((stiffness + damping) * strain.value[m].by * by.value +
                                              stiffness * strain.value[m].value * by.by);
        }
    }
  }
  return out;
}

/// Components of an element's vectors.
inline int components(const AncfSpatialElement& e) { return e.thick ? 27 : 12; }

/// stiffness · ∂f/∂y + damping · ∂f/∂ẏ at ẏ = 0 of one element, by its components, row by row.
template <class T>
void tangent(const AncfSpatialElement& e, const T* y, double stiffness, double damping, T* out) {
  const auto n = static_cast<std::size_t>(components(e));
  for (std::size_t k = 0; k < n * n; ++k) out[k] = T(0);
  visit_points(e, [&]<class Law>(const Law&, const AncfSpatialElement::Point& p) {
    const auto C = second_derivatives<Law, T>(p, vectors<Law>(e, p, y, false), stiffness, damping);
    visit_weights<Law>(e, p, [&](std::size_t row, std::size_t f, int c, double weight) {
      const Vectors<Law, T>& of_row = C[3 * f + static_cast<std::size_t>(c)];
      visit_weights<Law>(e, p, [&](std::size_t column, std::size_t g, int d, double other) {
        out[row * n + column] += (weight * other) * of_row[g][d];
      });
    });
  });
}

// Of doubles they are in ancf_spatial.cpp (see there).
void add_forces(const AncfSpatialElement& e, double elastic, double damping, const double* y,
                const double* yd, double* out);
double energy(const AncfSpatialElement& e, const double* y);
void tangent(const AncfSpatialElement& e, const double* y, double stiffness, double damping, double* out);

/// As add_tangent() of ancf.h; `damping` times the beam's.
template <class T, class Add>
void add_tangent(const AncfSpatialElement& e, const T* y, double stiffness, double damping, const Add& add) {
  T K[27 * 27];
  tangent(e, y, stiffness, damping, K);
  const int n = components(e);
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c) {
      const int row = e.amplitudes[static_cast<std::size_t>(r)],
                column = e.amplitudes[static_cast<std::size_t>(c)];
      if (row >= 0 && column >= 0) add(row, column, K[r * n + c]);
    }
}

/// Numbers that marks() has of an element.
inline std::size_t mark_count(const AncfSpatialElement& e) { return e.thick ? 24 : 12; }

/// As the marks of ancf.h: what stress resists motion across the line with, and in which directions it is
/// stiff, N/m.
void marks(const AncfSpatialElement& e, const double* y, double* out);

}  // namespace mimbre::ancf
