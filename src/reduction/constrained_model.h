#pragma once
#include <vector>

#include "mimbre/fe_reduce.h"

namespace mimbre::fe {

/// Whether equations, rigid or mean elements join dofs of the mesh, or nodes without elements are in it.
bool has_constraints(const SolidMesh& mesh);

/// Whether nodes have rotations that nothing resists, as of a mass with inertia on a node of solids, or
/// rotations without mass.
bool has_loose_rotations(const FeMatrices& matrices);

/// All equations of the mesh, those of rigid and mean elements last.
std::vector<Equation> all_equations(const SolidMesh& mesh, const std::vector<Dof>& dofs);

/// Interfaces with nodes that are part of a rigid element take its reference in their place: it moves as they
/// do, and has rotations.
std::vector<Interface> at_references(const SolidMesh& mesh, const std::vector<Interface>& interfaces);

/// Matrices of the dofs that are left where the equations hold (FeMatrices::expansion). Dofs of the
/// interfaces' nodes stay, where there is another that an equation can be solved for. Dofs without stiffness
/// and mass, that no equation and no interface needs, are left out, and so are rotations without stiffness
/// that no interface needs, which have nothing to do with the rest (`loose`, if given, receives them;
/// Nastran's AUTOSPC holds them, too). Rotations without mass get a trace of stiffness. Throws
/// std::invalid_argument that names an equation which rigid motions of the body do not satisfy, or that joins
/// interfaces.
FeMatrices constrain(const SolidMesh& mesh, const FeMatrices& matrices,
                     const std::vector<Interface>& interfaces, std::vector<Dof>* loose = nullptr);

}  // namespace mimbre::fe
