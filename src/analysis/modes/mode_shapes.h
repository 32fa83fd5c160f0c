#pragma once
#include <Eigen/Core>
#include <complex>

#include "mimbre/modes.h"

/// What dense and sparse modes have in common.
namespace mimbre::linear {

/// The same motions, each of as few coordinates as possible (reduced echelon form by columns).
Eigen::MatrixXd echelon(Eigen::MatrixXd motions);

/// The largest of the first entries by their scales becomes 1. Returns the factor.
std::complex<double> normalise(Eigen::VectorXcd& x, Eigen::Index entries, const Eigen::VectorXd& scale);

/// A mode of that eigenvalue, without its shape. `decay_round_off`: of Re λ, 1/s.
Mode mode_of(std::complex<double> value, double decay_round_off);

}  // namespace mimbre::linear
