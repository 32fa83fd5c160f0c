#pragma once
#include <cmath>
#include <string>

#include "mimbre/fe_reduce.h"

namespace mimbre::test {

/// The nodes of a bar along x that lie at `x`, tied to their mean.
fe::Interface end(const fe::SolidMesh& mesh, const std::string& name, double x,
                  fe::Interface::Tie tie = fe::Interface::Tie::rigid);

}  // namespace mimbre::test
