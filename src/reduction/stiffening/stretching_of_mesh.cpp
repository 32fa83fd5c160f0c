#include "reduction/bases/shapes.h"
#include "reduction/stiffening/stretching.h"
#include "reduction/tied_model.h"

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Modes whose pairs the states of stress are of: each pair takes a solution.
constexpr Index most_of_mesh = 4;

std::vector<int> first_dofs(const SolidMesh& mesh, const std::vector<Dof>& dofs) {
  std::vector<int> first(static_cast<std::size_t>(mesh.nodes.cols()), -1);
  for (std::size_t r = dofs.size(); r-- > 0;)
    first[static_cast<std::size_t>(dofs[r].node)] = static_cast<int>(r);
  return first;
}

/// Interfaces that move as one rigid body, and the mesh's own rigid parts.
std::vector<RigidNodes> rigid_nodes(const SolidMesh& mesh, const std::vector<Interface>& interfaces,
                                    const MatrixXd& points, const MatrixXd& shapes,
                                    const std::vector<Dof>& dofs, const std::vector<int>& first) {
  const auto known = [&](std::vector<int> nodes) {
    std::erase_if(nodes, [&](int node) { return first[static_cast<std::size_t>(node)] < 0; });
    return nodes;
  };
  std::vector<RigidNodes> rigid;
  for (std::size_t i = 0; i < interfaces.size(); ++i)
    if (interfaces[i].tie == Interface::Tie::rigid)
      rigid.push_back({known(interfaces[i].nodes), interfaces[i].point,
                       points.middleRows<3>(static_cast<Index>(6 * i + 3))});
  for (const RigidElement& element : mesh.rigid_elements) {
    const int row = first[static_cast<std::size_t>(element.reference)];
    const bool turns = row >= 0 && static_cast<std::size_t>(row) + 5 < dofs.size() &&
                       dofs[static_cast<std::size_t>(row) + 5].node == element.reference;
    if (turns && element.follows[0] && element.follows[1] && element.follows[2])
      rigid.push_back(
          {known(element.nodes), mesh.nodes.col(element.reference), shapes.middleRows<3>(row + 3)});
  }
  return rigid;
}

}  // namespace

std::optional<Stretching> stretching_of_mesh(const SolidMesh& mesh, const FeMatrices& all,
                                             const FeMatrices& left, const std::vector<Interface>& interfaces,
                                             const TiedModel& tied, const Shapes& shapes,
                                             const ReducedBody& body) {
  if (!all.of_mesh) return {};
  const bool constrained = left.expansion.size() > 0;
  const auto expanded = [&](const MatrixXd& u) -> MatrixXd { return constrained ? left.expansion * u : u; };
  MatrixXd z = MatrixXd::Zero(tied.boundaries(), tied.boundaries());
  for (std::size_t i = 0; i < interfaces.size(); ++i)
    for (const auto at : {static_cast<Index>(6 * i), static_cast<Index>(6 * i + 3)})
      z.block<3, 3>(at, at) = interfaces[i].axes.transpose();
  StretchedMesh stretched{mesh,
                          all.stiffness,
                          first_dofs(mesh, all.dofs),
                          expanded(shapes.dofs),
                          lowest_amplitudes(body, most_of_mesh),
                          {},
                          expanded(tied.expand(MatrixXd::Zero(tied.internals(), z.cols()), z)),
                          [&](const MatrixXd& forces) -> MatrixXd {
                            const MatrixXd x = tied.solve(
                                tied.restrict(constrained ? left.expansion.transpose() * forces : forces));
                            return expanded(tied.expand(x, MatrixXd::Zero(tied.boundaries(), x.cols())));
                          },
                          [&](const MeshCells& cells, const Mesh& beams, int number) {
                            return turning_cell(mesh, cells, beams, number);
                          }};
  stretched.rigid =
      rigid_nodes(mesh, interfaces, shapes.points, stretched.shapes, all.dofs, stretched.first_dof);
  std::vector<int> places;
  for (std::size_t i = 0; i < interfaces.size(); ++i) places.push_back(static_cast<int>(i));
  return find_stretching(stretched, places);
}

}  // namespace mimbre::fe
