#pragma once
#include <array>

#include "linalg/complex.h"

/// Radau IIA of order 5 with three stages: y_i = y_0 + h Σ A_ij f_j, y(h) = y_3 (Hairer, Wanner 1996, IV.5
/// and IV.8).
namespace mimbre::radau {

inline constexpr int stages = 3;
using Row = std::array<double, stages>;

inline constexpr Row c{0.15505102572168219, 0.64494897427831781, 1};
inline constexpr std::array<Row, stages> A{
    {{0.19681547722366043, -0.065535425850198388, 0.023770974348220152},
     {0.39442431473908728, 0.29207341166522846, -0.04154875212599793},
     {0.37640306270046728, 0.51248582618842161, 1. / 9}}};

/// T⁻¹ A⁻¹ T is γ, and α + iβ of the second component plus i times the third.
inline constexpr double gamma = 3.6378342527444957;
inline constexpr linalg::Complex alpha_beta{2.6810828736277521, 3.0504301992474106};
inline constexpr std::array<Row, stages> T{
    {{0.094438762488975241, -0.14125529502095421, -0.030029194105147424},
     {0.25021312296533331, 0.20412935229379993, 0.38294211275726194},
     {1, 1, 0}}};
inline constexpr std::array<Row, stages> T_inverse{
    {{4.1787185915519047, 0.32768282076106239, 0.52337644549944955},
     {-4.1787185915519047, -0.32768282076106239, 0.47662355450055045},
     {-0.50287263494578688, 2.5719269498556054, -0.59603920482822492}}};

/// Error of order 3: (γ/h − ∂f/∂y)⁻¹ (f_0 + Σ e_i (y_i − y_0)/h).
inline constexpr Row error{-10.048809399827416, 1.3821427331607489, -1. / 3};

/// Weights of three values at the stages in the polynomial through them at θ, the step being 0 to 1.
inline Row polynomial(double theta) {
  Row weights;
  for (int i = 0; i < stages; ++i) {
    const double p = c[(i + 1) % stages], q = c[(i + 2) % stages];
    weights[i] = (theta - p) * (theta - q) / ((c[i] - p) * (c[i] - q));
  }
  return weights;
}

}  // namespace mimbre::radau
