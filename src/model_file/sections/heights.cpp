#include "model_file/sections/heights.h"

#include <fmt/format.h>

namespace mimbre::model_file {

std::optional<Eigen::MatrixXd> read_heights(const Value& value) {
  const auto rows = value.list();
  Eigen::MatrixXd heights;
  for (std::size_t j = 0; j < rows.size(); ++j) {
    const auto row = rows[j].numbers(2, 10000, quantity::length);
    if (!row) return std::nullopt;
    if (j == 0) heights.setZero(std::ssize(rows), std::ssize(*row));
    if (std::ssize(*row) != heights.cols()) {
      rows[j].error(fmt::format("has {} heights; the first row has {}", row->size(), heights.cols()));
      return std::nullopt;
    }
    for (std::size_t i = 0; i < row->size(); ++i)
      heights(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(i)) = (*row)[i];
  }
  return heights;
}

}  // namespace mimbre::model_file
