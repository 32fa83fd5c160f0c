#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "fe/elements/elastic_matrix.h"
#include "mimbre/fe_mesh.h"

/// Shells with six dofs per node (body axes): translations, rotations of the first node, then of the next
/// ones.
///
/// Flat shells of three or four nodes (shell_flat.h): a plate and a membrane with drilling rotations.
/// Curved shells of six or eight nodes (shell_curved.h): degenerated solids.
///
/// Mass: points on two surfaces at ± t/√12 from the middle one, whose displacements are linear in the dofs;
/// rigid motions have their exact inertia. Drilling rotations that differ from the membrane's rotation have
/// an inertia of ρt³/12 of their own, so that every motion of the nodes has mass.
namespace mimbre::fe {

constexpr int kMaxShellNodes = 8;
constexpr int kMaxShellDofs = 6 * kMaxShellNodes;
constexpr double kNoArea = 1e-10;  ///< relative to the square of the element's extent
using ShellNodes = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMaxShellNodes>;
using ShellMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxShellDofs, kMaxShellDofs>;
/// Rows x, y, z by nodal dofs.
using ShellField = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMaxShellDofs>;

/// Where the element lies.
struct ShellGeometry {
  ElementType type;
  ShellNodes nodes;  ///< body axes, m
  double thickness = 0;
  double offset = 0;        ///< of the middle surface from the nodes, along the normal
  bool reduced = false;     ///< integration, of quad8
  ShellNodes normals = {};  ///< at the nodes, in place of the element's for the offset; or none
};

struct ShellMatrices {
  ShellMatrix stiffness, mass;  ///< symmetric, full storage
};

/// Throws std::invalid_argument for an element without area or not convex.
ShellMatrices shell_matrices(const ShellGeometry& shell, const ElementMaterial& material);
inline ShellMatrices shell_matrices(ElementType type, const ShellNodes& nodes, const Material& material,
                                    double thickness) {
  return shell_matrices({type, nodes, thickness}, material);
}

/// Calls visit(position, mass, motion) for points that together have the mass of the element: its mass matrix
/// is Σ mass · motionᵀ motion and, of drilling rotations, more.
using VisitMass = std::function<void(const Eigen::Vector3d&, double, const ShellField&)>;
void for_each_mass_point(const ShellGeometry& shell, double density, const VisitMass& visit);

/// In-plane strains (xx, yy, engineering xy in the axes at the node) by nodal dofs: at node k and height z
/// along the normal membrane + z · curvature, rows 3k to 3k + 2 of each.
struct ShellStrains {
  std::vector<Eigen::Matrix3d> axes;  ///< of each node; columns, the last is the normal
  Eigen::MatrixXd membrane;           ///< 3·nodes × 6·nodes
  Eigen::MatrixXd curvature;          ///< 3·nodes × 6·nodes
};
ShellStrains shell_strains(const ShellGeometry& shell, const ElementMaterial& material);

}  // namespace mimbre::fe
