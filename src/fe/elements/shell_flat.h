#pragma once
#include "fe/elements/shell_element.h"

/// Flat shells of three or four nodes. A plate (shell_bending.h) and a membrane with drilling rotations
/// (shell_membrane.h) in the plane of the element; the nodes of a warped quadrilateral hang on it by rigid
/// arms, so that rigid motions stay without energy.
///
/// The mass is consistent with displacements that are linear plus parabolas over the sides, whose middles
/// move as those of cubic beams between the nodes, by ½(ua + ub) + ⅛(θa − θb) × (xb − xa) (Allman 1984, in
/// all directions).
namespace mimbre::fe {

ShellMatrix flat_stiffness(const ShellGeometry& shell, const ElementMaterial& material);
/// What drilling rotations have of the mass beyond the points.
ShellMatrix flat_drilling_mass(const ShellGeometry& shell, double density);
void for_each_flat_mass_point(const ShellGeometry& shell, double density, const VisitMass& visit);
ShellStrains flat_strains(const ShellGeometry& shell, const ElementMaterial& material);

}  // namespace mimbre::fe
