#pragma once
#include <string>
#include <vector>

#include "mimbre/fe_reduce.h"

namespace mimbre::app {

/// Loads of the option --load, `NAME=SELECTION,fx,fy,fz`; selections and the other arguments as of
/// nodes_of. Throws UsageError that names the mistake.
std::vector<fe::SpreadLoad> loads_of(const std::vector<std::string>& texts, const fe::SolidMesh& mesh,
                                     const std::vector<fe::Dof>& dofs, double length_unit);

}  // namespace mimbre::app
