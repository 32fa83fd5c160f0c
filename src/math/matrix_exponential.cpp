#include "math/matrix_exponential.h"

#include <unsupported/Eigen/MatrixFunctions>

namespace mimbre {

SmallMatrix matrix_exponential(const SmallMatrix& a) { return a.exp(); }

}  // namespace mimbre
