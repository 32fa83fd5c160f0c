#pragma once

/// Shear coefficients k = 6 (1 + ν)/(p + q ν) of the cross-sections with a simple shape (G. R. Cowper, The
/// shear coefficient in Timoshenko's beam theory, Journal of Applied Mechanics 33 (1966) 335–340): kGA γ is
/// the shear force where γ is the slope less the mean rotation of the section.
namespace mimbre::fe {

struct ShearCoefficient {
  double p = 0, q = 0;  ///< both zero: the shape is not known

  bool known() const { return p > 0; }
  double at(double poisson) const { return 6 * (1 + poisson) / (p + q * poisson); }
};

/// Round, with a round hole of `inner` times the diameter.
inline ShearCoefficient round_shear(double inner) {
  const double m = inner / (1 + inner * inner), m2 = m * m;
  return {7 + 20 * m2, 6 + 12 * m2};
}

/// Rectangle, for shear along either side: 10 (1 + ν)/(12 + 11 ν).
inline ShearCoefficient rectangle_shear() { return {7.2, 6.6}; }

}  // namespace mimbre::fe
