#pragma once
#include <Eigen/Core>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "fe/elements/solid_shape.h"
#include "mimbre/fe_mesh.h"
#include "support/dense.h"

/// Meshes of solids and shells for tests.
namespace mimbre::test {

using fe::ElementType;

inline constexpr std::array kSolidTypes{ElementType::tet4,     ElementType::tet10,    ElementType::hex8,
                                        ElementType::hex20,    ElementType::wedge6,   ElementType::wedge15,
                                        ElementType::pyramid5, ElementType::pyramid13};

std::string type_name(ElementType type);

ElementType corners_only(ElementType type);

/// Turns elements with nodes at their corners into those with nodes on the edges too.
void add_edge_nodes(fe::SolidMesh& mesh, ElementType type);

using Place = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

/// The block [0, size] in nx × ny × nz bricks, each one element, two wedges, six tetrahedra or six pyramids
/// round its centre; `place` moves
/// the corners.
fe::SolidMesh block(ElementType type, const Eigen::Vector3d& size, const std::array<int, 3>& counts,
                    const fe::Material& material, const Place& place = {});

/// nx × ny shells over a place of two coordinates in [0, 1].
fe::SolidMesh shell_mesh(ElementType type, int nx, int ny, const fe::Material& material, double thickness,
                         const std::function<Eigen::Vector3d(double, double)>& place);

/// One element, an affine image of the reference element whose nodes are moved by up to `distortion` of its
/// size: edges of quadratic elements get curved.
fe::NodePositions single_element(ElementType type, double distortion, unsigned seed = 1);

/// The six unit rigid motions (translations, rotations about the origin) of nodes with three dofs.
Eigen::MatrixXd rigid_motions(const Eigen::Matrix3Xd& nodes);

}  // namespace mimbre::test
