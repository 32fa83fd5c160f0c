#pragma once
#include <Eigen/SparseCore>
#include <string>

namespace mimbre::fe {

/// What SciPy's save_npz writes of a matrix in coordinate form, as bytes: a ZIP of arrays, not compressed.
std::string npz_of(const Eigen::SparseMatrix<double>& matrix);

}  // namespace mimbre::fe
