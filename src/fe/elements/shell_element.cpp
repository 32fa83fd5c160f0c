#include "fe/elements/shell_element.h"

#include "fe/elements/congruence.h"
#include "fe/elements/shell_curved.h"
#include "fe/elements/shell_flat.h"
#include "math/cross_matrix.h"

namespace mimbre::fe {
namespace {

bool flat(const ShellGeometry& shell) { return node_count(shell.type) <= 4; }

ShellMatrix symmetric(const ShellMatrix& m) { return 0.5 * (m + m.transpose()); }

/// The shell whose nodes lie in its middle surface, at the ends of arms from the given ones.
ShellGeometry at_arms(const ShellGeometry& shell) {
  ShellGeometry moved = shell;
  moved.nodes += shell.offset * shell.normals;
  moved.offset = 0;
  moved.normals.resize(3, 0);
  return moved;
}

/// Motion of the ends of arms by that of the nodes that carry them: u + θ × arm.
ShellMatrix arms_of(const ShellGeometry& shell) {
  const Eigen::Index count = shell.nodes.cols();
  ShellMatrix arms = ShellMatrix::Identity(6 * count, 6 * count);
  for (Eigen::Index a = 0; a < count; ++a)
    arms.block<3, 3>(6 * a, 6 * a + 3) = -cross_matrix(shell.offset * shell.normals.col(a));
  return arms;
}

bool has_arms(const ShellGeometry& shell) { return shell.normals.cols() > 0; }

}  // namespace

ShellMatrices shell_matrices(const ShellGeometry& shell, const ElementMaterial& material) {
  if (has_arms(shell)) {
    const ShellMatrices moved = shell_matrices(at_arms(shell), material);
    const ShellMatrix arms = arms_of(shell);
    ShellMatrices matrices{ShellMatrix::Zero(arms.rows(), arms.rows()),
                           ShellMatrix::Zero(arms.rows(), arms.rows())};
    add_congruent(matrices.stiffness, 1, arms, moved.stiffness);
    add_congruent(matrices.mass, 1, arms, moved.mass);
    return {symmetric(matrices.stiffness), symmetric(matrices.mass)};
  }
  const ShellMatrix stiffness =
      flat(shell) ? flat_stiffness(shell, material) : curved_stiffness(shell, material);
  const double density = material.density();
  ShellMatrix mass = flat(shell) ? flat_drilling_mass(shell, density) : curved_drilling_mass(shell, density);
  for_each_mass_point(shell, density, [&](const Eigen::Vector3d&, double dm, const ShellField& motion) {
    add_square(mass, dm, motion);
  });
  return {symmetric(stiffness), symmetric(mass)};
}

void for_each_mass_point(const ShellGeometry& shell, double density, const VisitMass& visit) {
  if (has_arms(shell)) {
    const Eigen::MatrixXd arms = arms_of(shell);
    return for_each_mass_point(at_arms(shell), density,
                               [&](const Eigen::Vector3d& place, double dm, const ShellField& motion) {
                                 visit(place, dm, Eigen::MatrixXd(Eigen::MatrixXd(motion) * arms));
                               });
  }
  flat(shell) ? for_each_flat_mass_point(shell, density, visit)
              : for_each_curved_mass_point(shell, density, visit);
}

ShellStrains shell_strains(const ShellGeometry& shell, const ElementMaterial& material) {
  if (has_arms(shell)) {
    ShellStrains strains = shell_strains(at_arms(shell), material);
    const Eigen::MatrixXd arms = arms_of(shell);
    strains.membrane = (strains.membrane * arms).eval();
    strains.curvature = (strains.curvature * arms).eval();
    return strains;
  }
  return flat(shell) ? flat_strains(shell, material) : curved_strains(shell);
}

}  // namespace mimbre::fe
