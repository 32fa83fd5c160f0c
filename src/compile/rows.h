#pragma once
#include <Eigen/Core>

#include "base/array.h"

namespace mimbre {

/// A dense matrix of an image, row by row: each row contiguous, and padded by who makes it so that loops over
/// columns vectorise.
class Rows {
 public:
  using Values = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  Rows() = default;
  Rows(Eigen::Index rows, Eigen::Index columns)
      : rows_(rows), columns_(columns), values_(static_cast<std::size_t>(rows * columns), 0) {}
  template <class Derived>
  Rows(const Eigen::MatrixBase<Derived>& values)
      : Rows(values.rows(), values.cols()) {  // NOLINT: stands for it
    matrix() = values;
  }
  static Rows Zero(Eigen::Index rows, Eigen::Index columns) { return {rows, columns}; }

  Eigen::Index rows() const { return rows_; }
  Eigen::Index cols() const { return columns_; }
  Eigen::Index size() const { return rows_ * columns_; }
  double* data() { return values_.data(); }
  const double* data() const { return values_.data(); }
  double& operator()(Eigen::Index row, Eigen::Index column) { return data()[row * columns_ + column]; }
  double operator()(Eigen::Index row, Eigen::Index column) const { return data()[row * columns_ + column]; }
  Eigen::Map<Values> matrix() { return {data(), rows_, columns_}; }
  Eigen::Map<const Values> matrix() const { return {data(), rows_, columns_}; }

 private:
  Eigen::Index rows_ = 0, columns_ = 0;
  Array<double> values_;
};

}  // namespace mimbre
