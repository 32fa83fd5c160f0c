#pragma once
#include <vector>

#include "mimbre/function.h"

/// Splines of the fifth degree, whose second derivatives are smooth: for motions whose accelerations count.
namespace mimbre {

/// A function at points x, which ascend strictly: its values, slopes and second derivatives.
struct SplinePoints {
  std::vector<double> x, value, slope, second;
};

/// What a spline does at its ends. not_a_knot: its first three pieces are one polynomial, and its last three,
/// so that polynomials of degree 5 come back exactly. natural: third and fourth derivatives vanish, which is
/// the smoothest, ∫ f'''² dx, through the points.
enum class SplineEnds { not_a_knot, natural };

/// The spline of degree 5 with four continuous derivatives through the points (at least one). Of fewer than
/// six points the polynomial through them.
SplinePoints quintic_spline(const std::vector<double>& x, const std::vector<double>& y, SplineEnds ends);

/// Values near y (at least four) on the function f that minimises
///     ∫ (y − f)² dx + (period / 2π)⁶ ∫ f'''² dx,
/// the first integral by the mean of the intervals beside each point (Reinsch 1967; Woltring 1986): of a sine
/// the share 1 / (1 + (period / its period)⁶) is left, half of one of that period, without a shift.
std::vector<double> smoothed(const std::vector<double>& x, const std::vector<double>& y, double period);

/// The piecewise polynomials of degree 5 that have these values, slopes and second derivatives. Before the
/// first point it is constant, if that is after 0, where models begin; behind the last one the last piece
/// goes on.
Function quintic_function(const SplinePoints& points);

}  // namespace mimbre
