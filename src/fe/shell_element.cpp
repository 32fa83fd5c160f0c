#include "fe/shell_element.h"

#include "fe/shell_curved.h"
#include "fe/shell_flat.h"

namespace mimbre::fe {
namespace {

bool flat(const ShellGeometry& shell) { return node_count(shell.type) <= 4; }

ShellMatrix symmetric(const ShellMatrix& m) { return 0.5 * (m + m.transpose()); }

}  // namespace

ShellMatrices shell_matrices(const ShellGeometry& shell, const ElementMaterial& material) {
  const ShellMatrix stiffness =
      flat(shell) ? flat_stiffness(shell, material) : curved_stiffness(shell, material);
  const double density = material.density();
  ShellMatrix mass = flat(shell) ? flat_drilling_mass(shell, density) : curved_drilling_mass(shell, density);
  for_each_mass_point(shell, density, [&](const Eigen::Vector3d&, double dm, const ShellField& motion) {
    mass += dm * motion.transpose() * motion;
  });
  return {symmetric(stiffness), symmetric(mass)};
}

void for_each_mass_point(const ShellGeometry& shell, double density, const VisitMass& visit) {
  flat(shell) ? for_each_flat_mass_point(shell, density, visit)
              : for_each_curved_mass_point(shell, density, visit);
}

ShellStrains shell_strains(const ShellGeometry& shell, const ElementMaterial& material) {
  return flat(shell) ? flat_strains(shell, material) : curved_strains(shell);
}

}  // namespace mimbre::fe
