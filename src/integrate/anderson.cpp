#include "integrate/anderson.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace mimbre {

Anderson::Anderson(int n, int m)
    : x_(n, depth), y_(m, depth), d_(n, depth), differences_(n, depth), new_x_(n), new_y_(m) {}

void Anderson::mix(Eigen::VectorXd& x, Eigen::VectorXd& y, const Eigen::VectorXd& d) {
  new_x_ = x;
  new_y_ = y;
  const int columns = std::min(count_, depth);
  if (columns > 0) {
    // min |d − Σ θ_j (d − d_j)| by normal equations, scaled and slightly regularised.
    using Small = Eigen::Matrix<double, depth, depth>;
    using SmallVector = Eigen::Matrix<double, depth, 1>;
    Small gram = Small::Identity();
    SmallVector right = SmallVector::Zero(), theta;
    for (int j = 0; j < columns; ++j) differences_.col(j) = d - d_.col(j);
    for (int j = 0; j < columns; ++j) {
      right[j] = differences_.col(j).dot(d);
      for (int i = 0; i <= j; ++i) gram(i, j) = gram(j, i) = differences_.col(i).dot(differences_.col(j));
    }
    SmallVector scale;
    for (int j = 0; j < depth; ++j) scale[j] = 1 / std::sqrt(std::max(gram(j, j), 1e-300));
    gram = scale.asDiagonal() * gram * scale.asDiagonal();
    gram.diagonal().array() += 1e-10;
    theta = scale.asDiagonal() * gram.ldlt().solve(scale.asDiagonal() * right);
    if (theta.allFinite() && theta.cwiseAbs().maxCoeff() < 1e4) {
      for (int j = 0; j < columns; ++j) {
        x -= theta[j] * (new_x_ - x_.col(j));
        y -= theta[j] * (new_y_ - y_.col(j));
      }
    }
  }
  const int slot = count_ % depth;
  x_.col(slot) = new_x_;
  y_.col(slot) = new_y_;
  d_.col(slot) = d;
  ++count_;
}

}  // namespace mimbre
