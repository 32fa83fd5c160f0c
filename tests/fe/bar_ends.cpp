#include "fe/bar_ends.h"

namespace mimbre::test {

fe::Interface end(const fe::SolidMesh& mesh, const std::string& name, double x, fe::Interface::Tie tie) {
  fe::Interface i;
  i.name = name;
  i.tie = tie;
  for (int k = 0; k < mesh.nodes.cols(); ++k)
    if (std::abs(mesh.nodes(0, k) - x) < 1e-9) i.nodes.push_back(k);
  i.point = fe::centre_of(mesh, i.nodes);
  return i;
}

}  // namespace mimbre::test
