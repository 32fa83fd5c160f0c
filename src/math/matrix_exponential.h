#pragma once
#include <Eigen/Core>

namespace mimbre {

/// A small matrix that needs no heap.
constexpr int most_small = 32;
using SmallMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, most_small, most_small>;

/// exp(a) of a square matrix. Allocates nothing.
SmallMatrix matrix_exponential(const SmallMatrix& a);

}  // namespace mimbre
