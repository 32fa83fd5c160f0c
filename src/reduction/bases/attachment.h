#pragma once
#include <functional>

#include "reduction/bases/shapes.h"

namespace mimbre::fe {

/// Eigenmodes of the body held at its first interface alone, as its tangent frame holds it, for the basis of
/// eigenmodes and attachment modes (Hurty 1965; Craig 1987). Attachment modes, deflections by unit forces at
/// the other interfaces, are combinations of the static modes. So each eigenmode is returned without its part
/// in these: columns over the internal dofs, all interfaces held. With the static modes they span the basis.
/// `modes` of them or, where `limit` (ω², s⁻²) is positive, all below it. `eigenvalues`: of the eigenmodes.
Eigen::MatrixXd attached_eigenmodes(const TiedModel& tied, const FeMatrices& matrices,
                                    const std::vector<Interface>& interfaces, int modes, double limit,
                                    Eigen::VectorXd& eigenvalues,
                                    const std::function<void(double)>& progress = {});

/// Static deflections by the inertia of six unit accelerations of the body, all interfaces held: columns over
/// the internal dofs. R: rigid_shapes. With the eigenmodes above they span the vectors of modal truncation
/// augmentation (Dickens, Nakagawa, Wittbrodt 1997) for these loads: K⁻¹(F − M Φ Φᵀ F) and Φ have the span of
/// K⁻¹F and Φ.
Eigen::MatrixXd inertia_responses(const TiedModel& tied, const FeMatrices& matrices,
                                  const Eigen::MatrixXd& R);

}  // namespace mimbre::fe
