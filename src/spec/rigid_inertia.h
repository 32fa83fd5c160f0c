#pragma once
#include <optional>
#include <string>

#include "mimbre/spec.h"

namespace mimbre {

/// What is wrong with the inertia of a rigid body about its centre of mass.
struct InertiaFault {
  std::string what;
  std::string harmless;  ///< why the motion does not depend on it; empty: it may
};

/// Nothing where matter can have the inertia: principal moments that are not negative, none larger than the
/// sum of the others, and none without mass. A point mass and a thin rod have moments that are 0. What no
/// matter can have is harmless where the joints between the body and the ground keep it from turning, or let
/// it turn about one direction only, about which the moment is not negative.
std::optional<InertiaFault> inertia_fault(const spec::Model& model, std::size_t body);

}  // namespace mimbre
