#pragma once
#include <Eigen/Core>
#include <functional>

#include "fe/solve/lowest_modes.h"

namespace mimbre::fe {

/// A symmetric pencil (K, M) by what it does to blocks of vectors.
struct Pencil {
  Eigen::Index size = 0;
  std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)> solve;  ///< (K − shift M)⁻¹ b, positive definite
  std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)> mass;   ///< M x
  double shift = 0;
  Eigen::Index rows = 0;  ///< of the vectors, where they have more entries than the space has dimensions
};

/// The `count` lowest solutions of K v = λ M v by block Lanczos iteration with full orthogonalisation
/// (Golub, Underwood 1977; shift and invert, Grimes, Lewis, Simon 1994). `progress` (optional) is called with
/// 0 to 1. Vectors are M-normalised, their largest entry positive. M may be semidefinite. Throws
/// std::runtime_error when it does not converge, std::invalid_argument when M is indefinite, there are fewer
/// solutions of finite λ than asked for, or numbers overflow.
Modes block_lanczos(const Pencil& pencil, int count, const std::function<void(double)>& progress = {});

/// All solutions with λ ≤ limit. Throws std::invalid_argument when they are more than a thousand.
Modes block_lanczos_below(const Pencil& pencil, double limit,
                          const std::function<void(double)>& progress = {});

}  // namespace mimbre::fe
