#pragma once
#include <Eigen/Core>

#include "mimbre/fe_mesh.h"

/// Flat shells of three or four nodes with six dofs each (body axes): translations, rotations of the first
/// node, then of the next ones. A plate (shell_bending.h) and a membrane with drilling rotations
/// (shell_membrane.h) in the plane of the element; the nodes of a warped quadrilateral hang on it by rigid
/// arms, so that rigid motions stay without energy.
///
/// Mass: consistent with displacements that are linear plus parabolas over the sides, whose middles move as
/// those of cubic beams between the nodes, by ½(ua + ub) + ⅛(θa − θb) × (xb − xa) (Allman 1984, in all
/// directions); and ρt³/12 about axes in the plane. Rigid motions have their exact inertia.
namespace mimbre::fe {

constexpr int kMaxShellDofs = 24;
using ShellNodes = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 4>;
using ShellMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxShellDofs, kMaxShellDofs>;

struct ShellMatrices {
  ShellMatrix stiffness, mass;  ///< symmetric, full storage
};

/// `type`: tri3 or quad4. Throws std::invalid_argument for an element without area or not convex.
ShellMatrices shell_matrices(ElementType type, const ShellNodes& nodes, const Material& material,
                             double thickness);

/// In-plane strains (xx, yy, engineering xy in the element's axes) by nodal dofs: at node k and height z
/// along the normal membrane + z · rows 3k to 3k + 2 of curvature.
struct ShellStrains {
  Eigen::Matrix3d axes;       ///< columns; the last is the normal
  Eigen::MatrixXd membrane;   ///< 3 × 6·nodes, the element's mean
  Eigen::MatrixXd curvature;  ///< 3·nodes × 6·nodes
};
ShellStrains shell_strains(ElementType type, const ShellNodes& nodes, const Material& material,
                           double thickness);

}  // namespace mimbre::fe
