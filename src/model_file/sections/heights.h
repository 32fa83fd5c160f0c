#pragma once
#include <Eigen/Core>
#include <optional>

#include "model_file/text/value.h"

namespace mimbre::model_file {

/// Rows along y of heights along x, m, all of one length.
std::optional<Eigen::MatrixXd> read_heights(const Value& value);

}  // namespace mimbre::model_file
