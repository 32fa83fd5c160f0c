#include "integrate/anderson.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace mimbre {

Anderson::Anderson(const Scales& scales, int m)
    : scales_(Eigen::Map<const Eigen::VectorXd>(scales.coordinates.data(),
                                                static_cast<Eigen::Index>(scales.coordinates.size()))),
      x_(scales_.size(), depth),
      y_(m, depth),
      d_(x_),
      differences_(x_),
      new_x_(scales_),
      new_y_(m),
      new_d_(scales_) {}

void Anderson::mix(Eigen::VectorXd& x, Eigen::VectorXd& y, const Eigen::VectorXd& d) {
  new_x_ = x;
  new_y_ = y;
  new_d_ = d.cwiseQuotient(scales_);
  const int columns = std::min(count_, depth);
  if (columns > 0) {
    // min |d − Σ θ_j (d − d_j)| by normal equations, scaled and slightly regularised.
    using Small = Eigen::Matrix<double, depth, depth>;
    using SmallVector = Eigen::Matrix<double, depth, 1>;
    Small gram = Small::Identity();
    SmallVector right = SmallVector::Zero(), theta;
    for (int j = 0; j < columns; ++j) differences_.col(j) = new_d_ - d_.col(j);
    for (int j = 0; j < columns; ++j) {
      right[j] = differences_.col(j).dot(new_d_);
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
  d_.col(slot) = new_d_;
  ++count_;
}

}  // namespace mimbre
