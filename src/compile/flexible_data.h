#pragma once
#include "compile/compiled.h"
#include "mimbre/reduced_body.h"

namespace mimbre {

/// The matrix with columns of zeros behind it, `stride` in all.
Rows padded(const Eigen::MatrixXd& matrix, int stride);

/// What a step needs of a flexible body: its integrals and matrices as padded rows.
FlexibleData flexible_data(const ReducedBody& body);

}  // namespace mimbre
