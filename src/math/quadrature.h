#pragma once
#include <array>
#include <cmath>

/// Integrals of functions that are known by their values only.
namespace mimbre::quadrature {

/// ∫ f from a to b by ten-point Gauss–Legendre: exact for polynomials up to degree 19.
template <class F>
double panel(F&& f, double a, double b) {
  constexpr std::array<double, 5> nodes{0.1488743389816312, 0.4333953941292472, 0.6794095682990244,
                                        0.8650633666889845, 0.9739065285171717};
  constexpr std::array<double, 5> weights{0.2955242247147529, 0.2692667193099963, 0.2190863625159820,
                                          0.1494513491505806, 0.0666713443086881};
  const double half = 0.5 * (b - a), middle = a + half;
  double sum = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    sum += weights[i] * (f(middle - nodes[i] * half) + f(middle + nodes[i] * half));
  return half * sum;
}

/// ∫ f from a to b by that rule on eight equal panels: about 1e-12 for eight periods of a sine; at a kink the
/// error is about 1e-4 (b - a)² times the change of slope.
template <class F>
double integral(F&& f, double a, double b) {
  constexpr int panels = 8;
  const double width = (b - a) / panels;
  double sum = 0;
  for (int k = 0; k < panels; ++k) sum += panel(f, a + k * width, a + (k + 1) * width);
  return sum;
}

}  // namespace mimbre::quadrature
