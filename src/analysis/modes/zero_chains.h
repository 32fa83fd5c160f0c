#pragma once
#include <Eigen/Core>

#include "analysis/linear_reduction.h"

namespace mimbre::linear {

/// Motions that nothing resists: how often λ = 0 is an eigenvalue, and its vectors.
struct Zeros {
  int count = 0;
  Eigen::MatrixXd vectors;  ///< of the states
};

/// Zeros of λ E x = F x, E = diag(I, M, I), where chains may be of any length: on wheels the path goes by the
/// heading, and the heading by the yaw rate. Null vectors are taken out, with what they accelerate, until
/// none is left (staircase; Van Dooren, Linear Algebra Appl. 27, 1979). F = E A rather than A, as forces have
/// a size each, and rows and columns of one size before each rank: stiff bodies among soft springs put 1e13
/// beside 1 into A, and the rank of that is one of round-off. `positions`, `velocities`: scales of y and s;
/// `acceleration`: at play, along them.
Zeros zero_chains(const Reduced& r, const Eigen::VectorXd& positions, const Eigen::VectorXd& velocities,
                  double acceleration);

}  // namespace mimbre::linear
