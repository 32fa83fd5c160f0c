#pragma once
#include "fe/elements/shell_element.h"

/// Curved shells of six or eight nodes: degenerated solids (Ahmad, Irons, Zienkiewicz 1970). Material lines
/// across the shell stay straight and turn with the nodes; no stress across; shear factor 5/6. Two points
/// through the thickness; in the surface 3 in the triangle, 3 × 3 in the quadrilateral, 2 × 2 with reduced
/// integration, as the solids have them into which CalculiX expands S6, S8 and S8R. Only the last is free of
/// locking where the shell is thin against its elements.
///
/// Drilling: the rotation about the normal follows that of the membrane by a penalty (Hughes, Brezzi 1989).
/// With reduced integration two motions have no energy, of the membrane and of the rotations; they get a
/// share of that by full integration.
namespace mimbre::fe {

ShellMatrix curved_stiffness(const ShellGeometry& shell, const ElementMaterial& material);
ShellMatrix curved_drilling_mass(const ShellGeometry& shell, double density);
void for_each_curved_mass_point(const ShellGeometry& shell, double density, const VisitMass& visit);
ShellStrains curved_strains(const ShellGeometry& shell);

}  // namespace mimbre::fe
