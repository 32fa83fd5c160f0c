#pragma once
#include <fmt/format.h>

#include <Eigen/Core>
#include <string>

#include "spec/check/checked_item.h"

namespace mimbre::blocks {

inline std::string shape_of(const Eigen::MatrixXd& m) { return fmt::format("{} x {}", m.rows(), m.cols()); }

inline bool check_shape(const checks::CheckedItem& item, const char* name, const Eigen::MatrixXd& m,
                        Eigen::Index rows, Eigen::Index columns, bool optional = false) {
  if (m.rows() == rows && m.cols() == columns) return true;
  if (optional && m.size() == 0) return true;
  item.error(fmt::format("{} is {}; it has to be {} x {} here", name, shape_of(m), rows, columns));
  return false;
}

}  // namespace mimbre::blocks
