#pragma once
#include <map>
#include <string>

/// The Magic Formula once more, for tests only: written equation by equation as Pacejka (Tire and Vehicle
/// Dynamics, 3rd edition, 2012, section 4.3.2) and the handbooks of MF-Tyre 5.2 and PAC2002 print them, on
/// words in place of an array, without the limits and smoothing that a simulation needs. It shares no code
/// with src/forces/magic.
namespace mimbre::test {

/// The numbers of a property file by their keys, SI units, and `version`: 52, 61 or 62.
using Coefficients = std::map<std::string, double>;

/// Fz, N; kappa; alpha, rad; gamma, rad; p, Pa; Vcx, m/s, as src/forces/magic/terms.h defines them.
struct Slip {
  double Fz, kappa, alpha, gamma, p, Vcx;
};

/// N, N m and m.
struct Published {
  double Fx, Fy, Mx, My, Mz, trail, sigma_kappa, sigma_alpha;
};

Published published_formula(const Coefficients& c, const Slip& slip);

}  // namespace mimbre::test
