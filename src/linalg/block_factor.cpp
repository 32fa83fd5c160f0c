#include "linalg/block_factor_impl.h"

namespace mimbre::linalg {

template class BlockFactor<double>;
template void to_dense(const BlockSymbolic&, const double*, double*);
template void multiply(const BlockSymbolic&, const double*, const double*, double*);

}  // namespace mimbre::linalg
