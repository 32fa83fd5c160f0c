#pragma once
#include <cmath>

#include "forces/element.h"
#include "math/elementary.h"

/// A gas spring: a piston on an enclosed gas, which pushes its ends apart, against the ambient pressure. The
/// gas changes by p Vⁿ = constant, n from 1 (slowly, as warm as its surroundings) to 1.4 (fast, of air).
namespace mimbre::forces {

namespace gas_spring {
/// Among the law's numbers. The pressure is that at `length`, where the column of gas is `gas_length` long.
constexpr int pressure = 0, area = 1, length = 2, gas_length = 3, exponent = 4, damping = 5, ambient = 6;
/// Shorter than this part of its column the gas is not: from there on the force stays.
constexpr double shortest = 1e-3;

template <class T>
struct Gas {
  T column, force, slope;  ///< m, N that pushes apart, ∂force/∂x
};
template <class T>
Gas<T> gas(const T* p, const T& x) {
  using mimbre::pow;
  const T asked = p[gas_length] + (x - p[length]), least = shortest * p[gas_length];
  const auto free = asked > least;
  const T column = select(free, asked, least);
  const T inside = p[pressure] * pow(T(p[gas_length] / column), p[exponent]);
  const T slope = select(free, T(-p[exponent] * inside / column * p[area]), T(0));
  return {column, T(p[area] * (inside - p[ambient])), slope};
}
}  // namespace gas_spring

template <class T>
void gas_spring_law(const LawContext<T>& c, ElementState<T>& s) {
  const T* p = c.numbers();
  const gas_spring::Gas<T> g = gas_spring::gas(p, s.x[0]);
  s.force[0] = -g.force + p[gas_spring::damping] * s.v[0];
  s.stiffness[0] = -g.slope;
  s.damping[0] = p[gas_spring::damping];
}

/// Stored since `length`: the work done on the gas and by the surroundings.
inline void gas_spring_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  using namespace gas_spring;
  const double* p = c.numbers();
  const Gas<double> g = gas(p, s.x[0]);
  const double n = p[exponent], whole = p[gas_length], ratio = g.column / whole;
  // ∫ p dV, by its logarithm where n is 1.
  const double work = std::abs(n - 1) < 1e-9 ? mimbre::log(ratio) : (mimbre::pow(ratio, 1 - n) - 1) / (1 - n);
  const double held = s.x[0] - p[length] - (g.column - whole);  // beyond the end of the gas
  e.stored = -p[area] * (p[pressure] * whole * work - p[ambient] * (g.column - whole)) - g.force * held;
  e.dissipating[0] = p[damping] * s.v[0];
}

struct GasSpring {
  static constexpr std::array<LawNumber, 7> numbers{{
      {.key = "pressure", .unit = "Pa", .about = "of the gas at that length", .above = 0},
      {.key = "area", .unit = "m^2", .about = "of the piston", .above = 0},
      {.key = "length", .unit = "m", .about = "of the spring between its ends", .above = 0},
      {.key = "gas_length", .unit = "m", .about = "of the column of gas at that length", .above = 0},
      {.key = "exponent", .about = "1 slowly, 1.4 fast", .otherwise = 1.2, .above = 0},
      {.key = "damping", .unit = "N s/m", .about = "of the seals", .otherwise = 0, .least = 0},
      {.key = "ambient", .unit = "Pa", .about = "pressure outside", .otherwise = 101325, .least = 0},
  }};
  static constexpr LawInfo info{.name = "gas_spring",
                                .section = "gas_springs",
                                .along = true,
                                .numbers = numbers,
                                .drawn_along = "spring damper"};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    gas_spring_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    gas_spring_energy(c, s, e);
  }
};

}  // namespace mimbre::forces
