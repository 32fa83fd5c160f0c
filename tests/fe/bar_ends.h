#pragma once
#include <cmath>
#include <string>

#include "mimbre/fe_reduce.h"

namespace mimbre::test {

/// The nodes of a bar along x that lie at `x`, tied to their mean.
inline fe::Interface end(const fe::SolidMesh& mesh, const std::string& name, double x,
                         fe::Interface::Tie tie = fe::Interface::Tie::rigid) {
  fe::Interface i;
  i.name = name;
  i.tie = tie;
  for (int k = 0; k < mesh.nodes.cols(); ++k)
    if (std::abs(mesh.nodes(0, k) - x) < 1e-9) i.nodes.push_back(k);
  i.point = fe::centre_of(mesh, i.nodes);
  return i;
}

}  // namespace mimbre::test
