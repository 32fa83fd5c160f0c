#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

/// Numerical derivatives and integrals of functions that are known by their values only.
namespace mimbre::difference {

/// The estimates of one derivative with ever smaller steps h: the one that agrees best with the estimate
/// before it. Coarse steps suffer from curvature, fine ones from rounding; in between neighbours agree. Kinks
/// nearer than the coarse steps only spoil those. Stops early where two agree to `enough`, relative.
template <class Estimate>
double best_estimate(Estimate&& estimate, double h, double shrink, int levels, double enough) {
  double before = estimate(h);
  double best = before;
  double least = std::numeric_limits<double>::infinity();
  for (int level = 1; level < levels; ++level) {
    h *= shrink;
    const double now = estimate(h);
    const double change = std::abs(now - before);
    before = now;
    if (change < least) {
      least = change;
      best = now;
      if (change <= enough * std::abs(now)) break;
    } else if (!std::isfinite(best)) {
      best = now;
    }
  }
  return best;
}

/// Far from zero the spacing of floating-point numbers grows, and the steps with it.
inline double scale_at(double x) { return std::max(1.0, 1e-4 * std::abs(x)); }

/// f'(x) by five-point central differences; relative error about 1e-10 for smooth functions that vary over
/// 0.01 and more.
template <class F>
double first(F&& f, double x) {
  const auto estimate = [&](double h) {
    return ((f(x - 2 * h) - f(x + 2 * h)) + 8 * (f(x + h) - f(x - h))) / (12 * h);
  };
  return best_estimate(estimate, 0x1p-7 * scale_at(x), 0x1p-3, 6, 1e-10);
}

/// f''(x) by five-point central differences; relative error about 1e-8.
template <class F>
double second(F&& f, double x) {
  const double at_x = f(x);
  const auto estimate = [&](double h) {
    return (16 * ((f(x + h) - at_x) + (f(x - h) - at_x)) - ((f(x + 2 * h) - at_x) + (f(x - 2 * h) - at_x))) /
           (12 * h * h);
  };
  return best_estimate(estimate, 0x1p-6 * scale_at(x), 0x1p-2, 6, 1e-9);
}

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

}  // namespace mimbre::difference
