#pragma once
#include <Eigen/Core>
#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "analysis/linear_point.h"

/// Small motions about a steady motion along which the coefficients repeat: ẋ = A(t) x, A(t + T) = A(t). They
/// are x = e^{λt} p(t), p(t + T) = p(t), and grow over a period by the multiplier μ = e^{λT}, an eigenvalue
/// of the transition Φ(T) (Floquet 1883).
namespace mimbre::linear {

/// Along the scales of the states.
struct Transition {
  double period = 0;                  ///< T, s: the shortest in which all that turns is back
  Eigen::MatrixXd over_period;        ///< Φ(T)
  std::vector<Eigen::MatrixXd> on;    ///< Φ at equal parts of the period, from 0 on
  std::vector<Eigen::MatrixXd> A;     ///< there, of the rates of velocities s alone
  std::vector<Eigen::MatrixXd> mass;  ///< of these
  int first_speed = 0;                ///< s among the states
};

/// Φ by exponentials of fourth order without commutators (Blanes, Moan, Appl. Numer. Math. 56, 2006), which
/// are exact where A does not vary, in up to 1024 steps, halved until nothing changes. `scale`: of the
/// states. Nothing, and in `why` the reason: the point is no steady motion all the way round, what turns has
/// no common period or is too slow for that many steps, coefficients do not repeat, a position on the way is
/// singular, or multipliers differ by more than nine digits.
std::optional<Transition> find_transition(const Compiled& model, const relative::RelativeSystem& system,
                                          const Linearised& at, const Eigen::VectorXd& scale,
                                          std::string& why);

/// λ of a multiplier, whose imaginary part is known but for multiples of 2π/T: that which is nearest to the
/// frequency of the velocities, on average over the period and by kinetic energy. `shape`: x(0), along the
/// scales of the states as Φ is. Of a real multiplier, whose motion repeats itself or its opposite, the
/// frequency is the root of the mean square.
std::complex<double> exponent_of(const Transition& transition, std::complex<double> multiplier,
                                 const Eigen::VectorXcd& shape);

}  // namespace mimbre::linear
