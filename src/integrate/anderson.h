#pragma once
#include <Eigen/Core>

#include "dynamics/scales.h"

namespace mimbre {

/// Anderson acceleration of a fixed-point iteration (Anderson 1965; Walker, Ni 2011): mixes the last few
/// iterates so that their corrections cancel as far as possible. Here the iteration is Newton's with a matrix
/// that lacks some tangent terms, so that it contracts slowly in a few directions. Corrections are compared
/// by the scales of the coordinates. Allocates only when made.
class Anderson {
 public:
  /// Iterates of two parts: corrections are known of the first, which are coordinates; the second, of size m,
  /// is mixed along.
  Anderson(const Scales& scales, int m);
  void reset() { count_ = 0; }
  /// x, y: the new iterate; d: the correction that led to it. Replaces x and y by the mixed iterate.
  void mix(Eigen::VectorXd& x, Eigen::VectorXd& y, const Eigen::VectorXd& d);

 private:
  static constexpr int depth = 5;
  int count_ = 0;
  Eigen::VectorXd scales_;  ///< of the coordinates
  Eigen::MatrixXd x_, y_, d_, differences_;
  Eigen::VectorXd new_x_, new_y_, new_d_;
};

}  // namespace mimbre
