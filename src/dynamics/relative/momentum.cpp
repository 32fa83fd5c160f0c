#include "dynamics/relative/momentum_impl.h"

namespace mimbre::relative {

template MomentumOf<double> momentum<double>(const Compiled&, Workspace<double>&, const std::vector<int>&,
                                             const double*, const double*);
template Vec3<double> mean_spin<double>(const Mat3<double>&, const Vec3<double>&);
template double centrifugal_power<double>(const MomentumOf<double>&, const Vec3<double>&);

}  // namespace mimbre::relative
