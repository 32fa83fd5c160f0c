#pragma once
#include <cmath>

#include "forces/element.h"

/// Drag of the air on a frame's origin, along each of the frame's axes: F = −½ ρ c A |u| u, with u the
/// velocity against the wind and a coefficient c for each axis.
namespace mimbre::forces {

namespace drag {
/// Among the law's numbers; `coefficient`: the first of three.
constexpr int area = 0, density = 1, coefficient = 2;
}  // namespace drag

/// Arguments, where there are some: the wind in global axes, m/s.
template <class T>
void drag_law(const LawContext<T>& c, ElementState<T>& s) {
  using std::sqrt;
  const T* p = c.numbers();
  Vec3<T> u(s.v[0], s.v[1], s.v[2]);
  if (c.has_arguments()) {
    const Vec3<T> wind(c.argument(0), c.argument(1), c.argument(2));
    for (int k = 0; k < 3; ++k) u[k] -= s.linear_of(k).dot(wind);
  }
  const T speed = sqrt(u.squaredNorm()), factor = T(0.5) * p[drag::density] * p[drag::area];
  const T inverse = T(1) / select(speed > T(0), speed, T(1));
  // The tangent is factor (c_k |u| δ_kl + c_k u_k u_l/|u|): its symmetric part.
  for (int k = 0; k < 3; ++k) {
    s.force[k] = factor * p[drag::coefficient + k] * speed * u[k];
    for (int l = 0; l < 3; ++l) {
      const T mean = T(0.5) * (p[drag::coefficient + k] + p[drag::coefficient + l]);
      s.stiffness[3 * k + l] = T(0);
      s.damping[3 * k + l] = factor * mean * (u[k] * u[l] * inverse + (k == l ? speed : T(0)));
    }
  }
}

/// In still air all of it is lost; in wind it works as a load does.
inline void drag_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  for (int k = 0; k < 3; ++k) (c.has_arguments() ? e.working : e.dissipating)[k] = s.force[k];
}

struct Drag {
  static constexpr std::array<LawNumber, 5> numbers{{
      {.key = "area", .unit = "m^2", .about = "that the coefficients are for", .above = 0},
      {.key = "density", .unit = "kg/m^3", .about = "of the air", .otherwise = 1.225, .least = 0},
      {.key = "cx", .about = "coefficient along the frame's x", .least = 0},
      {.key = "cy", .about = "likewise y", .least = 0},
      {.key = "cz", .about = "likewise z", .least = 0},
  }};
  static constexpr LawInfo info{.name = "drag",
                                .section = "drags",
                                .velocity = true,
                                .numbers = numbers,
                                .arguments = 3,
                                .optional = true};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    drag_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    drag_energy(c, s, e);
  }
};

}  // namespace mimbre::forces
