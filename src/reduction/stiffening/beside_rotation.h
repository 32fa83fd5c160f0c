#pragma once
#include <Eigen/Core>

namespace mimbre {

/// T for the amplitudes, and the three rotations of Stretching's forms as they are.
Eigen::MatrixXd beside_rotation(const Eigen::MatrixXd& T);

}  // namespace mimbre
