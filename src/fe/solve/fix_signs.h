#pragma once
#include <Eigen/Core>

namespace mimbre::fe {

/// Turns every column so that its entry of largest magnitude is positive; of entries that are equal up to
/// round-off, as in symmetric shapes, the first decides.
void fix_signs(Eigen::MatrixXd& columns);

}  // namespace mimbre::fe
